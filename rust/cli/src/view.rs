//! `relievo view`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, ErrorKind};
use relievo_view::Script;
use relievo_view::model::{self, Opening, Session, SurfaceKind};

use crate::Outcome;
use crate::args::limits::Limits;
use crate::args::viewpoint::Axis;

const EXAMPLE: &str = "Examples: relievo view frog.obj
          relievo view frog.relievo        (with frog.obj beside it)

Left button on the surface: the brush; with Ctrl inverted, with Shift smoothing. Middle or right button, or the left one
beside the model: turn; with Shift move, with Ctrl zoom, as the wheel does. Right button or Esc during a stroke: take it back.
F, Shift+F: size and strength. X: symmetry. W: borders of faces. Home: all in view. 1, 3, 7: front, right, top; with Ctrl back,
left, bottom. 5: with or without perspective. Ctrl+Z, Ctrl+Shift+Z: undo, redo. Ctrl+S, Ctrl+Shift+S: save, save as.

Acts of a script, one a line: drag BUTTON X0 Y0 X1 Y1 (left, middle or right, after ctrl+ or shift+; places are shares of the
view), point X Y, wheel NOTCHES, press NAME (what stands on a button, a layer's name, eye NAME, edit NUMBER), key NAME,
type TEXT, resize WIDTH HEIGHT, wait_frames N, screenshot FILE, quit";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// A mesh, or a document (.relievo).
    file: PathBuf,
    /// The mesh that the document was made on; left out, the one beside it that has the same name.
    mesh: Option<PathBuf>,
    /// Take a mesh for the control cage of a Catmull-Clark surface, or for its triangles; left out, for its triangles if it
    /// has no other faces.
    #[arg(long, value_enum, value_name = "KIND")]
    surface: Option<Kind>,
    /// Cells along an edge of a face, of new details and of the view: a power of two from 1 to 256; left out, as many as
    /// make some hundred thousand triangles.
    #[arg(long, value_name = "COUNT", value_parser = cells)]
    cells: Option<u32>,
    /// The axis that points up.
    #[arg(long, value_enum, default_value = "z")]
    up: Axis,
    /// A part of the name of the graphics device that draws; left out, the best there is.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Play the acts of a file, as a mouse and a keyboard would do them, and close the window.
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Print what brush events cost when the window is closed.
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
fn cells(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|count: &u32| count.is_power_of_two() && *count <= 256);
    count.ok_or_else(|| format!("{text:?} is no power of two from 1 to 256"))
}

pub fn run(arguments: &Arguments) -> Outcome {
    let script = arguments.script.as_deref().map(Script::read).transpose()?;
    let (kind, adapter) = (crate::args::device::Device::Gpu, arguments.adapter.as_deref());
    let device = crate::args::device::device(kind, adapter, arguments.limits.memory_limit)?
        .ok_or_else(|| Error::new(ErrorKind::Device, "there is no graphics device to draw with"))?;
    let opening = Opening {
        file: arguments.file.clone(),
        mesh: arguments.mesh.clone(),
        kind: arguments.surface.map(|kind| match kind {
            Kind::Smooth => SurfaceKind::Surface,
            Kind::Triangles => SurfaceKind::Triangles,
        }),
        cells: arguments.cells,
    };
    let session = Session::open(arguments.limits.context()?, &opening)?;
    let up = match arguments.up {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    };
    let session = model::run(session, &device, up, script)?;
    if arguments.costs {
        crate::print(&session.costs.summary())?;
    }
    Ok(ExitCode::SUCCESS)
}
