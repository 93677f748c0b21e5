//! Pictures of progressive meshes: a level, or what a list of edits does to one.

use std::path::PathBuf;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::parameter::Switch;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_lod::progressive::{DeviceLevel, Edit, Extract, Region};
use relievo_render::virtual_vertex::{DeviceMesh, IndirectMesh, Placed, Rasterizer, Shape};
use relievo_render::{Image, Material, Mesh, Scene, View, write_png};
use relievo_scene::showing::Showing;

use crate::args::device::{Adapter, Device as Kind};
use crate::args::viewpoint::Axis;

#[derive(clap::Args)]
pub struct Drawing {
    /// Draw it: a .png. With a list of edits, the mesh before them, every edit at its level with the balls of its handles
    /// (purple) and anchors (orange), and the finest level after them, side by side.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// The axis that points up.
    #[arg(long, value_enum, default_value = "z")]
    up: Axis,
    /// Degrees that it is turned by about that axis.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
    turn: f64,
    /// Pixels of each picture: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "480x480")]
    size: [u32; 2],
    /// What makes the level of the picture and draws it. Edits are made by the processor.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
}

/// Colours that anyone can tell apart (Okabe, Ito 2008).
const HANDLE: [f32; 3] = [0.60, 0.19, 0.39];
const ANCHOR: [f32; 3] = [0.79, 0.35, 0.01];
/// How much of a ball covers what is behind.
const COVER: f32 = 0.45;
/// Colours that are taken in every pixel.
const SAMPLES: u32 = 16;

/// One of the pictures beside each other.
pub struct Panel {
    pub mesh: Extract,
    /// The same on the device that draws, if that has made it.
    pub level: Option<DeviceLevel>,
    /// Draws the edges of triangles, and the balls of what is done.
    pub edit: Option<Edit>,
}

impl Drawing {
    /// Whether a picture is wanted.
    pub fn is_wanted(&self) -> bool {
        self.picture.is_some()
    }

    /// The graphics device that is to draw, if one is.
    pub fn device(&self, memory_limit: u64) -> Result<Option<Device>> {
        self.adapter.open(self.device, memory_limit)
    }

    /// Draws meshes side by side, all from where the first and the last of them are in view, on a graphics device or by
    /// rays.
    pub fn draw(&self, context: &Context, device: Option<&Device>, panels: &[Panel]) -> Result<()> {
        let Some(path) = &self.picture else { return Ok(()) };
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
            return Err(Error::unsupported("the format to write is not known")
                .at(path.display().to_string())
                .advise("use the extension .png"));
        }
        let up = match self.up {
            Axis::X => DVec3::X,
            Axis::Y => DVec3::Y,
            Axis::Z => DVec3::Z,
        };
        let turn = DAffine3::from_axis_angle(up, self.turn.to_radians());
        let points = || panels.iter().flat_map(|panel| &panel.mesh.points).map(|point| placed(&turn, *point));
        let (low, high) =
            (points().reduce(Vec3::min).unwrap_or_default(), points().reduce(Vec3::max).unwrap_or_default());
        let showing = Showing::new((low.to_array(), high.to_array()), self.up.into(), self.size)?;
        let [width, height] = self.size;
        let count = u32::try_from(panels.len()).unwrap_or(u32::MAX);
        let mut painter = match device {
            Some(device) => Painter::Device(Rasterizer::new(device)?, device),
            None => Painter::Rays(context),
        };
        let mut picture = Image::new(width.saturating_mul(count), height, 3)?;
        for (column, panel) in (0..).step_by(width as usize).zip(panels) {
            let mut view = View::new(showing.camera);
            view.lights = showing.lights.clone();
            [view.settings.width, view.settings.height] = self.size;
            (view.settings.samples, view.settings.sky_rays) = (SAMPLES, 0);
            view.settings.shadows = Switch::OFF;
            view.settings.wireframe = if panel.edit.is_some() { Switch::ON } else { Switch::OFF };
            let regions = panel.edit.as_ref().map(regions).unwrap_or_default();
            let plain = painter.render(&view, &showing.material, panel, &[], &turn)?;
            let covered = painter.render(&view, &showing.material, panel, &regions, &turn)?;
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let (under, over) = (plain.color(x, y), covered.color(x, y));
                let mixed = std::array::from_fn(|k| under[k] + COVER * (over[k] - under[k]));
                picture.set_color(column + x, y, mixed);
            }
        }
        write_png(path, &picture)
    }
}

fn placed(turn: &DAffine3, point: [f32; 3]) -> Vec3 {
    turn.transform_point3(Vec3::from(point).as_dvec3()).as_vec3()
}

/// The balls of an edit and their colours.
fn regions(edit: &Edit) -> Vec<(Region, [f32; 3])> {
    let handles = edit.handles.iter().map(|handle| (handle.region, HANDLE));
    handles.chain(edit.anchors.iter().map(|anchor| (*anchor, ANCHOR))).collect()
}

/// What draws.
enum Painter<'a> {
    Rays(&'a Context),
    Device(Rasterizer, &'a Device),
}

impl Painter<'_> {
    fn render(
        &mut self,
        view: &View,
        material: &Material,
        panel: &Panel,
        regions: &[(Region, [f32; 3])],
        turn: &DAffine3,
    ) -> Result<Image> {
        let mesh = || {
            let Extract { points, normals, triangles, .. } = panel.mesh.clone();
            Mesh { points, normals, triangles, ..Mesh::default() }
        };
        let balls =
            || regions.iter().map(|(region, color)| (ball(region), Material { base_color: *color, ..*material }));
        match self {
            Self::Rays(context) => {
                let mut scene = Scene::new()?;
                for (mesh, material) in std::iter::once((mesh(), *material)).chain(balls()) {
                    let object = scene.add_object(*turn, material)?;
                    scene.set_mesh(object, 0, mesh)?;
                }
                Ok(scene.render(context, view)?.color)
            }
            Self::Device(rasterizer, device) => {
                let copied = panel.level.is_none().then(|| (mesh(), *material));
                let meshes = copied.into_iter().chain(balls());
                let meshes = meshes.map(|(mesh, material)| Ok((DeviceMesh::new(device, &mesh, &material)?, material)));
                let meshes: Vec<_> = meshes.collect::<Result<_>>()?;
                let level = panel.level.as_ref().map(|level| {
                    let bounds = level.hierarchy().bounds();
                    let (vertices, indices, arguments) = (level.vertices(), level.indices(), level.arguments());
                    (Shape::Indirect(IndirectMesh { vertices, indices, arguments, bounds }), *material)
                });
                let shapes =
                    level.into_iter().chain(meshes.iter().map(|(mesh, made_of)| (Shape::Mesh(mesh), *made_of)));
                let placed =
                    shapes.map(|(shape, material)| Placed { transform: *turn, ..Placed::new(shape, material) });
                Ok(rasterizer.render(&placed.collect::<Vec<_>>(), view)?.color)
            }
        }
    }
}

/// A ball whose edges are not drawn.
fn ball(region: &Region) -> Mesh {
    const ROWS: u32 = 32;
    const AROUND: u32 = 2 * ROWS;
    let at = |row: u32, column: u32| {
        let (down, round) = (row as f32 / ROWS as f32, column as f32 / AROUND as f32);
        let (down, round) = (down * std::f32::consts::PI, round * std::f32::consts::TAU);
        Vec3::new(down.sin() * round.cos(), down.sin() * round.sin(), down.cos())
    };
    let places = || (0..=ROWS).flat_map(|row| (0..AROUND).map(move |column| (row, column)));
    let normals: Vec<Vec3> = places().map(|(row, column)| at(row, column)).collect();
    let center = Vec3::from(region.center);
    let number = |row: u32, column: u32| row * AROUND + column % AROUND;
    let triangles: Vec<[u32; 3]> = places()
        .take((ROWS * AROUND) as usize)
        .flat_map(|(row, column)| {
            let [a, b] = [number(row, column), number(row, column + 1)];
            [[a, a + AROUND, b + AROUND], [a, b + AROUND, b]]
        })
        .collect();
    Mesh {
        points: normals.iter().map(|normal| (center + region.radius * normal).to_array()).collect(),
        normals: normals.iter().map(|normal| normal.to_array()).collect(),
        edges: vec![0; triangles.len()],
        triangles,
        ..Mesh::default()
    }
}
