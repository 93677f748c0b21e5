//! `relievo crowd`

mod build;
mod export;
mod info;
pub mod picture;
mod refit;
mod scene;

use clap::Subcommand;

pub use self::info::tell;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Builds the cluster hierarchy of a character or a static model.
    Build(build::Arguments),
    /// Gives a crowd model the shape or the clips of a changed file, without building it anew.
    Refit(refit::Arguments),
    /// Reports what is in a crowd model: clips, clusters, errors and levels.
    Info(info::Arguments),
    /// Reports what one view of a crowd draws, in clusters and triangles.
    View(scene::ViewArguments),
    /// Renders a picture of a crowd with the triangles that the view deserves.
    Render(picture::Arguments),
    /// Writes the mesh of a crowd model at a chosen error, in one of its poses.
    Export(export::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Build(arguments) => build::run(arguments),
        Task::Refit(arguments) => refit::run(arguments),
        Task::Info(arguments) => info::run(arguments),
        Task::View(arguments) => scene::run(arguments),
        Task::Render(arguments) => picture::run(arguments),
        Task::Export(arguments) => export::run(arguments),
    }
}
