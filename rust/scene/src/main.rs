//! Runs a scene file on the processor: `relievo-scene SCENE OUT`. The demo makes its pictures with it, because it compiles
//! in half the time of the `relievo` command, whose `run` has every option.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_scene::diagnostic::Failure;
use relievo_scene::stepper::{self, RunOptions};

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [scene, out] = arguments.as_slice() else {
        eprintln!("usage: relievo-scene SCENE OUT");
        return ExitCode::from(2);
    };
    match run(scene, out) {
        Ok(report) => {
            print!("{report}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprint!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(scene: &Path, out: &Path) -> Result<String, Failure> {
    let context = Context::new(&ContextOptions::default())?;
    let description = relievo_scene::file::read_file(scene)?;
    let options = RunOptions { out: out.to_owned(), frames: None, allowed: Vec::new(), rebake: false, device: None };
    let summary = stepper::run(&context, description, &options, &mut Silent)?;
    for note in &summary.notes {
        eprintln!("note: {note}");
    }
    Ok(summary.report(out))
}
