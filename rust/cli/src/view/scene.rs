//! A scene in the window: its frames, which are baked there or were by `relievo scene run`.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Context, Mesh, Result};
use relievo_crowd::{Crowd, CrowdView, Frame};
use relievo_render as render;
use relievo_scene::cache::State;
use relievo_scene::stepper::{RunOptions, Stepper};
use relievo_scene::world::{Item, World};
use relievo_tiles::by_format;
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::uniform_rates;
use relievo_view::show::{Bake, Ball, Eye, Frames, Picture, Subject};

use super::baker::Baker;
use super::particles::spacing;
use super::tissue::add;
use super::walkers;

/// Cells along an edge of a face at most.
const FINEST: u32 = 64;

/// A scene over time.
pub struct SceneFrames {
    context: Context,
    name: String,
    path: PathBuf,
    out: PathBuf,
    stepper: Stepper,
    crowds: Vec<(Crowd, Frame)>,
    frames: u32,
    /// Frames that are baked, from the first one on.
    baked: u32,
    baker: Option<Baker>,
}

impl SceneFrames {
    /// Opens a scene whose results are in the folder `out`, which is made if it is missing. Returns also the axis that
    /// points up.
    pub fn open(context: Context, path: &Path, out: &Path) -> Result<(Self, usize)> {
        let scene = relievo_scene::file::read_file(path)?;
        let frames = scene.output.frames;
        let direction = scene.up.direction();
        let up = (0..3).find(|axis| direction[*axis] > 0.5).unwrap_or(2);
        let stepper = Stepper::new(&context, World::new(&context, scene, &[])?, out)?;
        let crowds =
            (0..stepper.world().scene.crowds.len()).map(|index| Ok((stepper.world().crowd(index)?, Frame::default())));
        let crowds = crowds.collect::<Result<_>>()?;
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let (path, out) = (path.to_owned(), out.to_owned());
        Ok((Self { context, name, path, out, stepper, crowds, frames, baked: 0, baker: None }, up))
    }
}

impl Subject for SceneFrames {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: self.frames as usize, rate: self.stepper.world().scene.fps }
    }

    fn follows_the_eye(&self) -> bool {
        !self.crowds.is_empty()
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        // Agents that the first picture has no triangles of count too.
        let agents = self.crowds.iter().flat_map(|(crowd, _)| walkers::bounds(crowd));
        let agents = agents.reduce(|[low, high], other| [low.min(other[0]), high.max(other[1])])?;
        let objects = self.stepper.world().start_bounds();
        Some(objects.map_or(agents, |(low, high)| [low.min(agents[0]), high.max(agents[1])]))
    }

    fn bake(&mut self, _: &[f64]) -> Option<Bake> {
        let cache = self.stepper.cache();
        while self.baked < self.frames && cache.state(self.baked) == State::Baked {
            self.baked += 1;
        }
        let missing = Bake { stage: format!("{} of {} frames are baked", self.baked, self.frames), ..Bake::default() };
        let state = self.baker.as_ref().map_or(missing, Baker::state);
        Some(Bake { frames: self.baked as usize, ..state })
    }

    fn begin_bake(&mut self, _: &[f64]) {
        let (context, path, out) = (self.context.clone(), self.path.clone(), self.out.clone());
        self.baker = Some(Baker::start(move |progress| {
            let scene = relievo_scene::file::read_file(&path)?;
            let options =
                RunOptions { out: out.clone(), frames: None, allowed: Vec::new(), rebake: false, device: None };
            let summary = relievo_scene::stepper::run(&context, scene, &options, progress)?;
            let files = format!("all frames are baked in {}", out.display());
            Ok([files].into_iter().chain(summary.notes).collect::<Vec<_>>().join("; "))
        }));
    }

    fn stop_bake(&mut self) {
        self.baker.iter().for_each(Baker::stop);
    }

    fn picture(&mut self, frame: usize, _: &[f64], eye: &Eye) -> Result<Picture> {
        let is_baked = frame < self.baked as usize;
        // A frame that is not baked is shown as the last one before it that is, or as the scene begins.
        let shown = self.baked.checked_sub(1).map(|last| last.min(frame as u32));
        if let Some(shown) = shown {
            self.stepper.open(&self.context, shown)?;
        }
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
        let time = world.scene.time(shown.unwrap_or(0));
        let (mut seen, mut agents) = (0, 0);
        for (index, (crowd, drawn)) in self.crowds.iter_mut().enumerate() {
            let entry = &world.scene.crowds[index];
            world.walk(index, time, crowd)?;
            let view = CrowdView::perspective(eye.place, eye.axes, eye.fov, eye.size, entry.pixels)?;
            crowd.cut(&self.context, &view, drawn)?;
            let color = entry.colour.map(|value| value.min(1.0));
            let mut mesh = walkers::mesh(&self.context, (crowd, drawn), time, |_, _, _, _| color)?;
            if mesh.normals.len() < mesh.points.len() {
                let normals = sums(&mesh.points, &mesh.triangles).into_iter();
                mesh.normals = normals.map(|normal| Vec3::from(normal).normalize_or(Vec3::Z).to_array()).collect();
            }
            add(&mut picture.mesh, mesh);
            (seen, agents) = (seen + drawn.drawn.len(), agents + crowd.agents().len());
        }
        picture.facts = vec![
            match is_baked {
                true => format!("frame {frame}, {:.3} s", frame as f64 / world.scene.fps),
                false => format!("frame {frame} is not baked yet"),
            },
            format!("{} objects", world.items().len()),
            format!("{detailed} tiles with detail"),
        ];
        if agents > 0 {
            picture.facts.push(format!("{seen} of {agents} agents in view"));
        }
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
pub fn placed(mesh: Mesh, transform: &DAffine3, color: [f32; 3]) -> render::Mesh {
    let triangles = mesh.triangles();
    let made = render::Mesh { triangles, ..render::Mesh::of_tessellation(mesh) };
    let turn = transform.matrix3.inverse().transpose();
    let points: Vec<[f32; 3]> = made.points.iter().map(|point| moved(transform, *point)).collect();
    let normals = match made.normals.len() == points.len() {
        true => made.normals,
        false => sums(&made.points, &made.triangles),
    };
    let normal =
        |normal: &[f32; 3]| (turn * Vec3::from(*normal).as_dvec3()).normalize_or(DVec3::Z).as_vec3().to_array();
    let colors = if made.colors.len() == points.len() { made.colors } else { vec![color; points.len()] };
    render::Mesh { normals: normals.iter().map(normal).collect(), colors, points, ..made }
}

/// The sums of the normals of the triangles at each point.
fn sums(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|point| Vec3::from(points[point as usize]));
        triangle.iter().for_each(|point| sums[*point as usize] += (b - a).cross(c - a));
    }
    sums.iter().map(Vec3::to_array).collect()
}

fn moved(transform: &DAffine3, point: [f32; 3]) -> [f32; 3] {
    transform.transform_point3(Vec3::from(point).as_dvec3()).as_vec3().to_array()
}
