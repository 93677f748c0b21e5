//! `relievo scene run`

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use relievo_core::{Context, ContextOptions};
use relievo_scene::stepper::{Run, RunOptions};

use super::folder::folder_of;
use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::args::numbers::frames;

/// Bytes of meshes from which a run says how many there will be.
const LARGE: u64 = 256 << 20;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene file.
    scene: PathBuf,
    /// Folder for everything that is written; left out, one named after the scene.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// First and last frame, both included; a run goes on from the baked frame before.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// What makes imprints and evaluates dabs that sculpt. What a graphics device does not do, the processor does.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Write what each stage cost to this file, for Perfetto or Chrome.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
    /// Also read files below this folder.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    /// Compute frames again that are in the cache.
    #[arg(long)]
    rebake: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = Context::new(&ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit })?;
    let scene = relievo_scene::file::read_file(&arguments.scene)?;
    let out = arguments.out.clone().unwrap_or_else(|| folder_of(&arguments.scene));
    let options = RunOptions {
        out: out.clone(),
        frames: arguments.frames,
        allowed: arguments.allow_path.clone(),
        rebake: arguments.rebake,
        device: arguments.adapter.open(arguments.device, arguments.memory_limit)?,
    };
    let bar = bar();
    let mut progress = |fraction: f32, stage: &str| {
        bar.set_position((fraction * 1000.0) as u64);
        bar.set_message(stage.to_string());
        true
    };
    let summary = Run::prepare(&context, scene, &options, &mut progress).and_then(|run| {
        let bytes = run.mesh_bytes()?;
        if bytes >= LARGE {
            bar.suspend(|| {
                eprintln!(
                    "note: meshes will take about {} MiB, more where tiles get displacement; lower `rate`, or write them \
                     as GLB or for the last frame alone",
                    bytes >> 20
                );
            });
        }
        run.finish(&context, &mut progress)
    });
    bar.finish_and_clear();
    let summary = summary?;
    if let Some(path) = &arguments.trace {
        let json = summary.trace.json().to_string();
        relievo_core::file::store(path, |file| std::io::Write::write_all(file, json.as_bytes()))?;
    }
    for note in &summary.notes {
        eprintln!("note: {note}");
    }
    crate::print(&summary.report(&out))?;
    Ok(ExitCode::SUCCESS)
}

/// A bar on a terminal; elsewhere nothing is shown.
fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(1000);
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {elapsed} of about {duration}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
