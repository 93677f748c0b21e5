//! `relievo export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_scene::description::When;
use relievo_scene::stepper::RunOptions;

use crate::Outcome;
use crate::run::{folder_of, range};

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Writes frames of a scene as scenes for POV-Ray 3.7: camera, light, and displaced surfaces as geometry.
    Pov(Frames),
    /// Writes frames of a scene as Python scripts that make them in Blender 3.4 and later, with their arrays beside them.
    Blender(Frames),
}

#[derive(clap::Args)]
struct Frames {
    /// The scene file.
    scene: PathBuf,
    /// Folder for everything that is written, with the cache of frames; left out, one named after the scene.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// First and last frame, both included; left out, the last one alone.
    #[arg(long, value_name = "A..B", value_parser = range)]
    frames: Option<(u32, u32)>,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
    /// Also read files below this folder.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let (arguments, povray, blender) = match &arguments.what {
        What::Pov(arguments) => (arguments, When::Every, When::Never),
        What::Blender(arguments) => (arguments, When::Never, When::Every),
    };
    let context = Context::new(&ContextOptions { threads: 0, memory_limit: arguments.memory_limit })?;
    let mut scene = relievo_scene::file::read_file(&arguments.scene)?;
    let output = &mut scene.output;
    (output.picture_frames, output.mesh, output.tiles) = (When::Never, When::Never, When::Never);
    (output.documents, output.povray, output.blender) = (When::Never, povray, blender);
    let last = output.frames - 1;
    let options = RunOptions {
        out: arguments.out.clone().unwrap_or_else(|| folder_of(&arguments.scene)),
        frames: Some(arguments.frames.unwrap_or((last, last))),
        allowed: arguments.allow_path.clone(),
        rebake: false,
    };
    let summary = relievo_scene::stepper::run(&context, scene, &options, &mut Silent)?;
    for note in &summary.notes {
        eprintln!("note: {note}");
    }
    let files: Vec<String> = summary.files.iter().map(|file| format!("{}\n", file.display())).collect();
    crate::print(&files.concat())?;
    Ok(ExitCode::SUCCESS)
}
