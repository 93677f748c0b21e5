//! `relievo foam render`: the fluid and solids by rays, and foam over them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_fluid::{March, Motion, RayCaster, Surface};
use relievo_particleio::Particles;
use relievo_render as render;
use relievo_render::foam::{FoamView, Lens, Scenery};
use relievo_render::{Dielectric, Frame, Image, Material, Scene, View};
use relievo_scene::isosurface::Isosurface;

use super::picture::{Options, summary};
use super::source::Source;
use crate::Outcome;
use crate::args::limits::Limits;
use crate::args::numbers::vector;
use crate::args::viewpoint::Viewpoint;
use crate::fluid::{add_floor, bar, bounds, chunk, ends, needs_folder};

#[derive(clap::Args)]
pub struct Arguments {
    /// The frame of foam, or a folder of frames.
    foam: PathBuf,
    /// The frame of the fluid that it belongs to, or the folder of frames that have the same names. Without other
    /// options, the first and the last frame of the folder are in view.
    #[arg(long, value_name = "FRAME")]
    fluid: Option<PathBuf>,
    /// Of a folder, the first and the last frame, both included; left out, all.
    #[arg(long, value_name = "A..B", value_parser = crate::args::numbers::frames)]
    frames: Option<(u32, u32)>,
    #[command(flatten)]
    surface: crate::fluid::SurfaceOptions,
    /// A mesh that stands in the fluid. May be repeated.
    #[arg(long = "solid", value_name = "MESH")]
    solids: Vec<PathBuf>,
    #[command(flatten)]
    picture: Options,
    #[command(flatten)]
    viewpoint: Viewpoint,
    /// Rays from the camera per pixel.
    #[arg(long, default_value_t = 4)]
    samples: u32,
    /// Direction to the sun.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "-0.55,-0.45,0.7")]
    sun: DVec3,
    /// How much light of each colour a metre of the fluid takes away: red, green, blue.
    #[arg(long, value_name = "R,G,B", value_parser = vector, default_value = "0.45,0.09,0.06")]
    absorption: DVec3,
    #[command(flatten)]
    limits: Limits,
}

/// The reflectance of solids.
const ROCK: [f32; 3] = [0.22, 0.2, 0.18];

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    if !arguments.foam.is_dir() {
        needs_folder(&arguments.foam, arguments.frames)?;
        arguments.picture.check()?;
        let fluid = arguments.fluid.as_deref();
        let line = one(&context, arguments, &arguments.foam, fluid, arguments.picture.output(), None)?;
        crate::print(&line)?;
        return Ok(ExitCode::SUCCESS);
    }
    let pictures = arguments.picture.folder()?;
    let frames = chunk(&arguments.foam, arguments.frames)?;
    let view = ends(&context, arguments.fluid.as_ref().unwrap_or(&arguments.foam))?;
    let bar = bar(frames.len() as u64)?;
    for (name, path) in &frames {
        let fluid = arguments.fluid.as_ref().map(|folder| of_name(folder, name)).transpose()?;
        let picture = pictures.join(format!("{name}.png"));
        let line = one(&context, arguments, path, fluid.as_deref(), &picture, Some(view))?;
        bar.suspend(|| crate::print(&format!("{}: {line}", path.display())))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(ExitCode::SUCCESS)
}

/// Returns the frame in a folder that has a name.
fn of_name(folder: &Path, name: &str) -> Result<PathBuf> {
    let frames = crate::fluid::frames(folder)?;
    let found = frames.into_iter().find(|(other, _)| other == name).map(|(_, path)| path);
    found.ok_or_else(|| Error::invalid(format!("there is no frame {name}")).at(folder.display().to_string()))
}

/// Renders a frame into a picture, with a box in view, or all of its own particles. Returns a line on it.
fn one(
    context: &Context,
    arguments: &Arguments,
    foam: &Path,
    fluid: Option<&Path>,
    output: &Path,
    around: Option<(DVec3, DVec3)>,
) -> Result<String> {
    let mut foam = Source::open(context, foam)?;
    let fluid = fluid.map(|path| crate::fluid::read(context, path)).transpose()?;
    let (low, high) = match (around, fluid.as_ref().filter(|fluid| !fluid.points.is_empty())) {
        (Some(around), _) => around,
        (None, Some(fluid)) => bounds(std::slice::from_ref(fluid))?,
        (None, None) => foam.bounds()?,
    };
    let view = arguments.viewpoint.view((low, high), arguments.sun, arguments.samples)?;
    let stage = Stage::new(context, arguments, fluid, (low, high))?;
    let picture = stage.render(context, Parts::All, &view)?.color;
    let depth = |parts: Parts| -> Result<Image> { Ok(stage.render(context, parts, &view.for_depths())?.depth) };
    let scenery = Scenery {
        solids: Some(depth(Parts::Solids)?),
        fluid: stage.surface.is_some().then(|| depth(Parts::Fluid)).transpose()?,
    };
    let [width, height] = arguments.viewpoint.size;
    let from = FoamView { camera: view.camera, lens: Lens::Perspective, width, height };
    let start = Instant::now();
    let device = arguments.surface.device(context)?;
    let layers = arguments.picture.layers((context, device), &mut foam, from, &scenery, &view.lights)?;
    arguments.picture.write(context, output, &picture, &layers)?;
    Ok(summary(&foam, &layers, start.elapsed().as_secs_f64()))
}

/// Which objects are rendered.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parts {
    All,
    Solids,
    Fluid,
}

/// What stands about the foam.
struct Stage {
    solids: Vec<render::Mesh>,
    surface: Option<Arc<Surface>>,
    dielectric: Dielectric,
    bounds: (DVec3, DVec3),
    floor: f64,
}

impl Stage {
    fn new(context: &Context, arguments: &Arguments, fluid: Option<Particles>, bounds: (DVec3, DVec3)) -> Result<Self> {
        let read = |path: &PathBuf| {
            let mesh = relievo_meshio::read(context, path)?;
            Ok(render::Mesh { triangles: mesh.triangles(), points: mesh.points, ..render::Mesh::default() })
        };
        let mut floor = bounds.0.z;
        let surface = match &fluid {
            Some(particles) if !particles.points.is_empty() => {
                floor -= 0.25 * f64::from(arguments.surface.spacing(particles)?);
                Some(Arc::new(arguments.surface.surface(context, particles)?))
            }
            _ => None,
        };
        Ok(Self {
            solids: arguments.solids.iter().map(read).collect::<Result<_>>()?,
            surface,
            dielectric: Dielectric { absorption: arguments.absorption.as_vec3().to_array(), ..Dielectric::WATER },
            bounds,
            floor,
        })
    }

    fn render(&self, context: &Context, parts: Parts, view: &View) -> Result<Frame> {
        let mut scene = Scene::new()?;
        if parts != Parts::Fluid {
            add_floor(&mut scene, self.bounds, self.floor)?;
            for solid in &self.solids {
                let look = Material { base_color: ROCK, specular: 0.03, roughness: 0.5 };
                let object = scene.add_object(DAffine3::IDENTITY, look)?;
                scene.set_mesh(object, 0, solid.clone())?;
            }
        }
        if let (Some(surface), true) = (&self.surface, parts != Parts::Solids) {
            let water = Material { base_color: [1.0; 3], specular: 0.02, roughness: 0.15 };
            let object = scene.add_object(DAffine3::IDENTITY, water)?;
            scene.set_dielectric(object, Some(self.dielectric))?;
            let caster = RayCaster::new(context, surface, Motion::default(), &[], March::default())?;
            scene.set_implicit(object, Some(Box::new(Isosurface(caster))))?;
        }
        scene.render(context, view)
    }
}
