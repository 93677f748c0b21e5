//! `relievo scene check`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_scene::world::World;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene file.
    scene: PathBuf,
    /// Also read files below this folder.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let scene = relievo_scene::file::read_file(&arguments.scene)?;
    let frames = scene.output.frames;
    let world = World::new(&context, scene, &arguments.allow_path)?;
    for note in world.notes() {
        eprintln!("note: {note}");
    }
    crate::print(&format!("{}: no faults, {frames} frames\n", arguments.scene.display()))?;
    Ok(ExitCode::SUCCESS)
}
