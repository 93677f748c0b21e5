//! The result of a scene in the window: the frames that `relievo scene run` has baked.

use std::path::Path;

use glam::{DAffine3, Vec3};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_render as render;
use relievo_scene::stepper::Stepper;
use relievo_scene::world::{Item, World};
use relievo_tiles::by_format;
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::uniform_rates;
use relievo_view::show::{Ball, Eye, Frames, Picture, Subject};

use super::particles::spacing;
use super::tissue::add;

/// Cells along an edge of a face at most.
const FINEST: u32 = 64;

/// A scene over time.
pub struct SceneFrames {
    context: Context,
    name: String,
    stepper: Stepper,
    frames: u32,
}

impl SceneFrames {
    /// Opens a scene whose results are in the folder `out`. Returns also the axis that points up.
    pub fn open(context: Context, path: &Path, out: &Path) -> Result<(Self, usize)> {
        let scene = relievo_scene::file::read_file(path)?;
        let frames = scene.output.frames;
        let direction = scene.up.direction();
        let up = (0..3).find(|axis| direction[*axis] > 0.5).unwrap_or(2);
        if !out.is_dir() {
            return Err(unbaked(0).at(out.display().to_string()));
        }
        let stepper = Stepper::new(&context, World::new(&context, scene, &[])?, out)?;
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok((Self { context, name, stepper, frames }, up))
    }
}

fn unbaked(frame: usize) -> Error {
    Error::invalid(format!("frame {frame} of the scene is not baked")).advise("bake it by `relievo scene run`")
}

impl Subject for SceneFrames {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: self.frames as usize, rate: self.stepper.world().scene.fps }
    }

    fn picture(&mut self, frame: usize, _: &[f64], _: &Eye) -> Result<Picture> {
        use relievo_scene::cache::State;
        if self.stepper.cache().state(frame as u32) != State::Baked {
            return Err(unbaked(frame));
        }
        self.stepper.open(&self.context, frame as u32)?;
        let world = self.stepper.world();
        let mut picture = Picture::default();
        let mut detailed = 0;
        for (index, item) in world.items().iter().enumerate() {
            let entry = &world.scene.objects[index];
            if !entry.visible {
                continue;
            }
            let color = entry.colour.map(|value| value.min(1.0));
            let (mesh, transform) = match item {
                Item::Surface(surface) => {
                    detailed += surface.displacement().allocated_count();
                    (surface_mesh(&self.context, world, index)?, *surface.transform())
                }
                Item::Triangles(_) => triangle_mesh(&self.context, world, index)?,
                Item::Mesh(item) if entry.fluid.is_some() => {
                    let radius = 0.5 * spacing(&item.mesh.points);
                    let place = |point: &[f32; 3]| moved(&item.transform, *point);
                    picture.balls.extend(item.mesh.points.iter().map(|point| Ball {
                        center: place(point),
                        radius,
                        color,
                    }));
                    continue;
                }
                Item::Mesh(item) => (item.mesh.clone(), item.transform),
            };
            add(&mut picture.mesh, placed(mesh, &transform, color));
        }
        picture.facts = vec![
            format!("frame {frame}, {:.3} s", frame as f64 / world.scene.fps),
            format!("{} objects", world.items().len()),
            format!("{detailed} tiles with detail"),
        ];
        Ok(picture)
    }
}

/// A surface with its detail, divided as its scene says.
fn surface_mesh(context: &Context, world: &World, index: usize) -> Result<Mesh> {
    let Some(Item::Surface(surface)) = world.items().get(index) else { return Ok(Mesh::default()) };
    let output = &world.scene.output;
    let topology = surface.surface().topology();
    let field = surface.displacement().field();
    let coarse = uniform_rates(topology, output.rate.clamp(1, FINEST));
    let rates: Vec<u32> =
        (0..).zip(coarse).map(|(tile, rate)| rate.max(field.density(tile).min(FINEST.min(output.mesh_rate)))).collect();
    let mut made = surface.displaced()?.tessellate(context, world.cage(index), &rates)?;
    if let Some(colors) = surface.colors() {
        by_format!(colors, field => made.paint(field));
    }
    Ok(made.mesh)
}

/// A triangle mesh with its detail, and where it is.
fn triangle_mesh(context: &Context, world: &World, index: usize) -> Result<(Mesh, DAffine3)> {
    let Some(Item::Triangles(item)) = world.items().get(index) else {
        return Ok((Mesh::default(), DAffine3::IDENTITY));
    };
    let object = &item.object;
    let rates = |face: u32| object.rates(face);
    let mut made =
        TriangleTessellation::new(context, &object.displaced()?, object.normals(), world.cage(index), rates)?;
    if let Some(colors) = object.colors() {
        by_format!(colors, field => made.paint(field))?;
    }
    Ok((made.mesh, *object.transform()))
}

/// A mesh in the world, of a colour where it has none.
fn placed(mesh: Mesh, transform: &DAffine3, color: [f32; 3]) -> render::Mesh {
    let triangles = mesh.triangles();
    let made = render::Mesh { triangles, ..render::Mesh::of_tessellation(mesh) };
    let turn = transform.matrix3.inverse().transpose();
    let points: Vec<[f32; 3]> = made.points.iter().map(|point| moved(transform, *point)).collect();
    let normals = match made.normals.len() == points.len() {
        true => made.normals,
        false => {
            let mut sums = vec![Vec3::ZERO; points.len()];
            for triangle in &made.triangles {
                let [a, b, c] = triangle.map(|point| Vec3::from(made.points[point as usize]));
                triangle.iter().for_each(|point| sums[*point as usize] += (b - a).cross(c - a));
            }
            sums.iter().map(Vec3::to_array).collect()
        }
    };
    let normal =
        |normal: &[f32; 3]| (turn * Vec3::from(*normal).as_dvec3()).normalize_or(glam::DVec3::Z).as_vec3().to_array();
    let colors = if made.colors.len() == points.len() { made.colors } else { vec![color; points.len()] };
    render::Mesh { normals: normals.iter().map(normal).collect(), colors, points, ..made }
}

fn moved(transform: &DAffine3, point: [f32; 3]) -> [f32; 3] {
    transform.transform_point3(Vec3::from(point).as_dvec3()).as_vec3().to_array()
}
