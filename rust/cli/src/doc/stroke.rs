//! `relievo doc stroke`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Context, ContextOptions};
use relievo_scene::replay::{Replay, replay};

use crate::Outcome;
use crate::args::device::{Adapter, Device as Kind};
use crate::args::limits::Isolation;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh: the control cage of the surface that is painted and sculpted.
    mesh: PathBuf,
    /// The list of strokes: a scene file with `[[strokes]]` and no objects; `relievo scene schema` shows the keys.
    strokes: PathBuf,
    /// File to write, once for each: a document (.relievo), or the displaced mesh (.obj, .ply, .glb, .usda, .stl, .off).
    #[arg(short, long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Take the mesh's own triangles for the surface, as a document of triangles does by itself.
    #[arg(long)]
    triangles: bool,
    /// Document of the mesh to go on from.
    #[arg(long, value_name = "FILE")]
    document: Option<PathBuf>,
    /// What makes dabs. What a graphics device does not do, the processor does.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    isolation: Isolation,
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
    /// Also read images below this folder.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = Context::new(&ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit })?;
    let wanted = Replay {
        mesh: arguments.mesh.clone(),
        triangles: arguments.triangles,
        isolation: arguments.isolation.isolation,
        strokes: arguments.strokes.clone(),
        document: arguments.document.clone(),
        outputs: arguments.out.clone(),
        allowed: arguments.allow_path.clone(),
        device: arguments.adapter.open(arguments.device, arguments.memory_limit)?,
    };
    let (done, notes) = replay(&context, &wanted, &mut Bar::new())?;
    for note in &notes {
        eprintln!("note: {note}");
    }
    crate::print(&format!(
        "dabs: {} made, {} too far from the surface\ntiles: {} changed\nfiles: {}\n",
        done.dabs,
        done.missed,
        done.report.changed.len(),
        arguments.out.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
    ))?;
    Ok(ExitCode::SUCCESS)
}
