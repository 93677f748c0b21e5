//! `relievo view`

mod baker;
mod deviation;
mod fluid;
mod levels;
mod particles;
mod scene;
mod tissue;
mod walkers;

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use relievo_core::{Context, Error, ErrorKind, Result};
use relievo_view::Script;
use relievo_view::model::{self, Opening, Session, SurfaceKind};
use relievo_view::show::{self, Subject};

use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::args::limits::Limits;
use crate::args::viewpoint::Axis;

const EXAMPLE: &str = "Examples: relievo view frog.obj
          relievo view frog.relievo        (with frog.obj beside it)
          relievo view frames/             (particles, played)
          relievo view robot.rcrowd --square 400
          relievo view press.toml frames/  (soft tissue and its frames)
          relievo view wave.toml           (a fluid: baked in the window, or by `relievo fluid sim`)
          relievo view snow.toml           (a scene: baked in the window, or by `relievo scene run`)

Left button on the surface: the brush; with Ctrl inverted, with Shift smoothing. Middle or right button, or the left one
beside the model: turn; with Shift move, with Ctrl zoom, as the wheel does. Right button or Esc during a stroke: take it back.
F, Shift+F: size and strength. X: symmetry. W: borders of faces. Home: all in view. 1, 3, 7: front, right, top; with Ctrl back,
left, bottom. 5: with or without perspective. R: the ray caster's picture while the hand rests. Space, left, right: play, the
frame before, the next. Ctrl+Z, Ctrl+Shift+Z: undo, redo. Ctrl+S, Ctrl+Shift+S: save, save as.
With an image (--decal): click: lay it, then add a pin; drag: move a pin; Delete: remove it; Enter: write the image; Esc: take it
off. A file that is dropped on the window is the brush's image, the image to lay, or the mesh to press.

Acts of a script, one a line: drag BUTTON X0 Y0 X1 Y1 (left, middle or right, after ctrl+ or shift+; places are shares of the
view), point X Y, pen PRESSURE LEAN (a pen from now on, 0 to 1 and degrees), wheel NOTCHES, press NAME (what stands on a button, a
layer's name, eye NAME, edit NUMBER), key NAME, type TEXT, drop FILE (on the window), resize WIDTH HEIGHT, wait_frames N, rest
(until the caster's picture and recorded ones are there), screenshot FILE, quit";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// A mesh, a document (.relievo), a progressive mesh (.rlvpm), a crowd model (.rcrowd), soft tissue (.rtissue, .inp, or the
    /// description of its simulation), a fluid (.toml), particles or a folder of their frames, or a scene (.toml).
    file: PathBuf,
    /// The mesh that the document was made on; left out, the one beside it that has the same name. With soft tissue the
    /// folder of its frames, with a scene or a fluid the folder of its results; left out, the one that is named after the
    /// file.
    mesh: Option<PathBuf>,
    /// A mesh that is pressed into the surface by hand.
    #[arg(long, value_name = "FILE")]
    tool: Option<PathBuf>,
    /// An image, PNG or EXR, that the brush paints and sculpts with.
    #[arg(long, value_name = "FILE")]
    stamp: Option<PathBuf>,
    /// An image, PNG or EXR, that is laid on the surface by hand.
    #[arg(long, value_name = "FILE")]
    decal: Option<PathBuf>,
    /// So many agents of a crowd model on a square.
    #[arg(long, value_name = "N", default_value_t = 100, conflicts_with = "agents")]
    square: usize,
    /// The agents of a crowd model, as `relievo crowd view` takes them.
    #[arg(long, value_name = "FILE")]
    agents: Option<PathBuf>,
    /// Frames of particles a second.
    #[arg(long, value_name = "N", default_value_t = 24.0)]
    fps: f64,
    /// Take a mesh for the control cage of a Catmull-Clark surface, or for its triangles; left out, for its triangles if it
    /// has no other faces.
    #[arg(long, value_enum, value_name = "KIND")]
    surface: Option<Kind>,
    /// Cells along an edge of a face, of new details and of the view: a power of two from 1 to 256; left out, as many as
    /// make some hundred thousand triangles.
    #[arg(long, value_name = "COUNT", value_parser = cells)]
    cells: Option<u32>,
    /// The axis that points up; left out, y for crowds, what a scene says, and z for all else.
    #[arg(long, value_enum)]
    up: Option<Axis>,
    #[command(flatten)]
    adapter: Adapter,
    /// Play the acts of a file, as a mouse and a keyboard would do them, and close the window.
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Print when the window is closed what brush events cost, how long the first picture took and how many came a second.
    #[arg(long)]
    costs: bool,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Kind {
    /// The limit surface of Catmull and Clark.
    Smooth,
    /// The triangles of the mesh.
    Triangles,
}

/// Reads a power of two from 1 to 256.
fn cells(text: &str) -> std::result::Result<u32, String> {
    let count = text.parse().ok().filter(|count: &u32| count.is_power_of_two() && *count <= 256);
    count.ok_or_else(|| format!("{text:?} is no power of two from 1 to 256"))
}

pub fn run(arguments: &Arguments) -> Outcome {
    let begins = Instant::now();
    let script = arguments.script.as_deref().map(Script::read).transpose()?;
    let device = arguments
        .adapter
        .open(Device::Gpu, arguments.limits.memory_limit)?
        .ok_or_else(|| Error::new(ErrorKind::Device, "there is no graphics device to draw with"))?;
    let context = arguments.limits.context()?;
    let axis = |axis: Axis| match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    };
    if let Some((subject, up)) = subject(&context, arguments)? {
        show::run(subject, &device, arguments.up.map_or(up, axis), script)?;
        return Ok(ExitCode::SUCCESS);
    }
    let opening = Opening {
        file: arguments.file.clone(),
        mesh: arguments.mesh.clone(),
        kind: arguments.surface.map(|kind| match kind {
            Kind::Smooth => SurfaceKind::Surface,
            Kind::Triangles => SurfaceKind::Triangles,
        }),
        cells: arguments.cells,
    };
    let mut session = Session::open(context, &opening)?;
    if let Some(tool) = &arguments.tool {
        session.open_tool(tool)?;
    }
    if let Some(stamp) = &arguments.stamp {
        session.open_stamp(stamp)?;
    }
    if let Some(image) = &arguments.decal {
        session.open_decal(image)?;
    }
    let session = model::run(session, &device, arguments.up.map_or(2, axis), script)?;
    if arguments.costs {
        let first = session.costs.first_frame().map_or(0.0, |first| (first - begins).as_secs_f64());
        crate::print(&format!("{}first picture: after {first:.2} s\n", session.costs.summary()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Opens what is played and not edited, and says which axis points up; `None` for a mesh or a document.
fn subject(context: &Context, arguments: &Arguments) -> Result<Option<(Box<dyn Subject>, usize)>> {
    let (file, context) = (arguments.file.as_path(), context.clone());
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let (subject, up): (Box<dyn Subject>, usize) = match extension.as_deref() {
        _ if file.is_dir() => (Box::new(particles::ParticleFrames::open(context, file, arguments.fps)?), 2),
        Some("rlvfluid" | "bgeo" | "vtk" | "vdb") => {
            (Box::new(particles::ParticleFrames::open(context, file, arguments.fps)?), 2)
        }
        Some("rlvpm") => (Box::new(levels::Levels::open(context, file)?), 2),
        Some("rcrowd") => {
            let agents = arguments.agents.as_deref();
            (Box::new(walkers::Walkers::open(context, file, agents, arguments.square)?), 1)
        }
        Some("rtissue" | "inp") => (Box::new(tissue::Tissue::open(context, file, arguments.mesh.as_deref())?), 2),
        Some("toml") if is_tissue(file)? => {
            (Box::new(tissue::Tissue::open(context, file, arguments.mesh.as_deref())?), 2)
        }
        Some("toml") if is_fluid(file)? => {
            let out = arguments.mesh.clone().unwrap_or_else(|| crate::scene::folder_of(file));
            (Box::new(fluid::FluidFrames::open(context, file, &out)?), 2)
        }
        Some("toml") => {
            let out = arguments.mesh.clone().unwrap_or_else(|| crate::scene::folder_of(file));
            let (scene, up) = scene::SceneFrames::open(context, file, &out)?;
            (Box::new(scene), up)
        }
        _ => return Ok(None),
    };
    Ok(Some((subject, up)))
}

/// Whether a description is one of a simulation of soft tissue, which names its model.
fn is_tissue(path: &Path) -> Result<bool> {
    Ok(head(path)?.lines().any(|line| line.split_once('=').is_some_and(|(key, _)| key.trim() == "model")))
}

/// Whether a description is one of a simulation of a fluid, which has a basin, blocks, fills or emitters.
fn is_fluid(path: &Path) -> Result<bool> {
    let tables = ["[basin]", "[fluid]", "[[block]]", "[[fill]]", "[[emitter]]"];
    Ok(head(path)?.lines().any(|line| tables.contains(&line.trim())))
}

/// Reads the beginning of a description.
fn head(path: &Path) -> Result<String> {
    let mut text = String::new();
    let failed = |error: std::io::Error| Error::io(path, &error);
    relievo_core::file::open(path)?.take(1 << 20).read_to_string(&mut text).map_err(failed)?;
    Ok(text)
}
