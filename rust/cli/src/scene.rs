//! `relievo scene`

mod check;
mod export;
mod folder;
mod new;
mod run;
mod schema;

use clap::Subcommand;

#[cfg(feature = "view")]
pub use self::folder::folder_of;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Runs a scene: physics, imprints, pictures and meshes of its frames.
    Run(run::Arguments),
    /// Writes a commented scene for your own meshes.
    New(new::Arguments),
    /// Reads a scene and its meshes and says what is wrong, without running it.
    Check(check::Arguments),
    /// Prints the format of scene files.
    Schema(schema::Arguments),
    /// Writes scenes for other programs.
    Export(export::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Run(arguments) => run::run(arguments),
        Task::New(arguments) => new::run(arguments),
        Task::Check(arguments) => check::run(arguments),
        Task::Schema(arguments) => schema::run(arguments),
        Task::Export(arguments) => export::run(arguments),
    }
}
