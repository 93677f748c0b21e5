//! `relievo fluid render`: pictures of particles, by rays against their surface itself or against a mesh of it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::ValueEnum;
use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_fluid::{March, Motion, RayCaster};
use relievo_particleio::Particles;
use relievo_render as render;
use relievo_render::{Dielectric, Image, Material, Scene, View};
use relievo_scene::isosurface::Isosurface;

use super::surface::Selection;
use crate::Outcome;
use crate::args::limits::Limits;
use crate::args::numbers::vector;
use crate::args::viewpoint::Viewpoint;

#[derive(clap::Args)]
pub struct Rendering {
    /// The particles of each picture: frames of a cache, classic .bgeo, legacy .vtk, .vdb, or the points of mesh files, with their
    /// channel `velocity` if they have one. A folder of frames gives a picture of each.
    #[arg(required = true, value_name = "FRAME")]
    frames: Vec<PathBuf>,
    /// The picture: a .png. Those of several frames are put side by side. Of a folder, the folder for the pictures; without
    /// other options, its first and its last frame are in view.
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// Of a folder, the first and the last frame, both included; left out, all.
    #[arg(long = "frames", value_name = "A..B", value_parser = crate::args::numbers::frames)]
    chunk: Option<(u32, u32)>,
    #[command(flatten)]
    surface: super::surface::Options,
    /// Renders a mesh of cells of this size in place of the surface itself.
    #[arg(long, value_name = "SPACINGS")]
    mesh: Option<f32>,
    /// Where particles are left out, renders each picture with all of them too, and says what time is saved.
    #[arg(long)]
    compare: bool,
    /// What the fluid is.
    #[arg(long, value_enum, default_value_t = Look::Water)]
    material: Look,
    /// How long the shutter is open: what moves is blurred, where no mesh is made.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    shutter: f32,
    #[command(flatten)]
    viewpoint: Viewpoint,
    /// Rays from the camera per pixel.
    #[arg(long, default_value_t = 4)]
    samples: u32,
    /// Pictures in a row.
    #[arg(long, default_value_t = 2)]
    columns: u32,
    /// Direction to the sun.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "-0.55,-0.45,0.7")]
    sun: DVec3,
    /// Height of the floor; left out, where the lowest particles lie on it.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    floor: Option<f64>,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Look {
    /// Clear water.
    Water,
    /// A matt blue.
    Opaque,
}

/// The colour of an opaque fluid.
const BLUE: [f32; 3] = [0.08, 0.28, 0.55];
/// Colours of the squares of the floor, and how many there are along it.
const SQUARES: [[f32; 3]; 2] = [[0.56, 0.56, 0.54], [0.44, 0.44, 0.44]];
const ALONG: u32 = 64;

pub fn run(arguments: &Rendering) -> Outcome {
    if let [folder] = arguments.frames.as_slice()
        && folder.is_dir()
    {
        return sequence(arguments, folder);
    }
    super::frames::needs_folder(&arguments.frames[0], arguments.chunk)?;
    let path = &arguments.output;
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(Error::unsupported("the format to write is not known")
            .at(path.display().to_string())
            .advise("use the extension .png")
            .into());
    }
    let context = arguments.limits.context()?;
    let frames = arguments.frames.iter().map(|path| super::frames::read(&context, path));
    let frames: Vec<Particles> = frames.collect::<Result<_>>()?;
    let (low, high) = bounds(&frames)?;
    let view = arguments.view(low, high)?;
    let [width, height] = arguments.viewpoint.size;
    let columns = arguments.columns.clamp(1, frames.len() as u32);
    let rows = (frames.len() as u32).div_ceil(columns);
    let mut sheet = Image::new(width.saturating_mul(columns), height.saturating_mul(rows), 3)?;
    let bar = super::frames::bar(frames.len() as u64)?;
    for (at, (path, frame)) in (0..).zip(arguments.frames.iter().zip(frames)) {
        let named = |error: Error| error.at(path.display().to_string());
        let (picture, line) = arguments.picture(&context, path, frame, &view, (low, high)).map_err(named)?;
        bar.suspend(|| crate::print(&line))?;
        bar.inc(1);
        let (left, top) = (at % columns * width, at / columns * height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            sheet.set_color(left + x, top + y, picture.color(x, y));
        }
    }
    bar.finish_and_clear();
    render::write_png(path, &sheet)?;
    Ok(ExitCode::SUCCESS)
}

/// Renders a picture of each frame in a folder, all from the same viewpoint.
fn sequence(arguments: &Rendering, folder: &Path) -> Outcome {
    let frames = super::frames::chunk(folder, arguments.chunk)?;
    let context = arguments.limits.context()?;
    let (low, high) = ends(&context, folder)?;
    let view = arguments.view(low, high)?;
    std::fs::create_dir_all(&arguments.output).map_err(|error| Error::io(&arguments.output, &error))?;
    let bar = super::frames::bar(frames.len() as u64)?;
    for (name, path) in &frames {
        let named = |error: Error| error.at(path.display().to_string());
        let frame = super::frames::read(&context, path)?;
        let (picture, line) = arguments.picture(&context, path, frame, &view, (low, high)).map_err(named)?;
        render::write_png(&arguments.output.join(format!("{name}.png")), &picture)?;
        bar.suspend(|| crate::print(&line))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(ExitCode::SUCCESS)
}

/// The box around the points of the first and the last frame in a folder, which is the same for every chunk of its frames.
pub fn ends(context: &Context, folder: &Path) -> Result<(DVec3, DVec3)> {
    let frames = super::frames::frames(folder)?;
    let ends = frames.iter().take(1).chain(frames.last()).map(|(_, path)| super::frames::read(context, path));
    bounds(&ends.collect::<Result<Vec<_>>>()?)
}

/// The box around the points of all frames.
pub fn bounds(frames: &[Particles]) -> Result<(DVec3, DVec3)> {
    let points = || frames.iter().flat_map(|frame| &frame.points).map(|point| Vec3::from(*point).as_dvec3());
    match (points().reduce(DVec3::min), points().reduce(DVec3::max)) {
        (Some(low), Some(high)) => Ok((low, high)),
        _ => Err(Error::invalid("there are no particles").advise("render frames that have some")),
    }
}

impl Rendering {
    fn view(&self, low: DVec3, high: DVec3) -> Result<View> {
        let mut view = self.viewpoint.view((low, high), self.sun, self.samples)?;
        view.shutter = [0.0, self.shutter];
        Ok(view)
    }

    /// The picture of a frame, and a line on what it took.
    fn picture(
        &self,
        context: &Context,
        path: &Path,
        frame: Particles,
        view: &View,
        bounds: (DVec3, DVec3),
    ) -> Result<(Image, String)> {
        let count = frame.points.len();
        let spacing = self.surface.spacing(&frame)?;
        let all = (self.compare && self.surface.is_classifying(&frame)).then(|| frame.clone());
        let selection = self.surface.select(context, frame)?;
        let share = selection.share.clone();
        let (picture, [prepared, rendered]) = self.trace(context, &selection, spacing, view, bounds)?;
        let mut line = format!("prepared in {prepared:.2} s, rendered in {rendered:.2} s");
        if let Some(particles) = all {
            let selection = Selection { particles, blind: Vec::new(), share: String::new() };
            let whole: f64 = self.trace(context, &selection, spacing, view, bounds)?.1.iter().sum();
            let saved = whole - prepared - rendered;
            let what = if saved < 0.0 { "more than" } else { "saved of" };
            line += &format!(", {:.2} s {what} {whole:.2} s with all", saved.abs());
        }
        Ok((picture, format!("{}: {count} particles, {share}{line}\n", path.display())))
    }

    /// A picture, and the seconds in which the surface was prepared and the picture rendered.
    fn trace(
        &self,
        context: &Context,
        selection: &Selection,
        spacing: f32,
        view: &View,
        (low, high): (DVec3, DVec3),
    ) -> Result<(Image, [f64; 2])> {
        let start = Instant::now();
        let mut scene = Scene::new()?;
        let height = self.floor.unwrap_or(low.z - 0.25 * f64::from(spacing));
        add_floor(&mut scene, (low, high), height)?;
        let look = match self.material {
            Look::Water => Material { base_color: [1.0; 3], specular: 0.02, roughness: 0.15 },
            Look::Opaque => Material { base_color: BLUE, specular: 0.04, roughness: 0.3 },
        };
        let fluid = scene.add_object(DAffine3::IDENTITY, look)?;
        scene.set_dielectric(fluid, (self.material == Look::Water).then_some(Dielectric::WATER))?;
        let surface = Arc::new(self.surface.surface(context, &selection.particles)?);
        match self.mesh {
            Some(cell) => {
                let mesh = selection.mesh(context, &surface, cell * spacing)?;
                scene.set_mesh(fluid, 0, render::Mesh::of_tessellation(mesh))?;
            }
            None => {
                let velocities = selection.particles.velocities().unwrap_or_default();
                let motion = Motion { velocities, shutter: view.shutter };
                let caster = RayCaster::new(context, &surface, motion, &selection.blind, March::default())?;
                scene.set_implicit(fluid, Some(Box::new(Isosurface(caster))))?;
            }
        }
        let prepared = start.elapsed().as_secs_f64();
        let picture = scene.render(context, view)?.color;
        Ok((picture, [prepared, start.elapsed().as_secs_f64() - prepared]))
    }
}

/// A floor of squares in two colours, much wider than what lies on it.
pub fn add_floor(scene: &mut Scene, (low, high): (DVec3, DVec3), height: f64) -> Result<()> {
    let (middle, extent) = (0.5 * (low + high), (high - low).truncate().max_element().max(1e-3));
    let side = 10.0 * extent / f64::from(ALONG);
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::splat(side),
        glam::DQuat::IDENTITY,
        DVec3::new(middle.x, middle.y, height),
    );
    let mut mesh = render::Mesh::default();
    for (column, row) in (0..ALONG).flat_map(|row| (0..ALONG).map(move |column| (column, row))) {
        let first = mesh.points.len() as u32;
        for [x, y] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
            let [x, y] = [column + x, row + y].map(|at| at as f32 - 0.5 * ALONG as f32);
            mesh.points.push([x, y, 0.0]);
            mesh.colors.push(SQUARES[((column + row) % 2) as usize]);
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let floor = scene.add_object(place, Material::default())?;
    scene.set_mesh(floor, 0, mesh)
}
