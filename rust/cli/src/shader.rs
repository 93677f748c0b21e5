//! `relievo shader`

mod augment;
mod check;
mod classify;
mod export;
mod mark;
mod opened;
mod run;
mod source;
mod values;
#[cfg(feature = "view")]
mod view;

use clap::Subcommand;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Reads a shader and lists its entry points, resources, float variables and vectors.
    Check(check::Arguments),
    /// Writes into a shader the annotation that takes a vector of some of its variables.
    Mark(mark::Arguments),
    /// Turns the annotations of a shader into code.
    Augment(augment::Arguments),
    /// Draws the picture of a shader, and the mask of what resembles the positive examples.
    Run(run::Arguments),
    /// Takes the feature vectors of pixels, judges the features, and says why a pixel belongs to its class.
    Classify(classify::Arguments),
    /// Prints the values that the float variables have at a pixel.
    Values(values::Arguments),
    /// Makes a transfer function of classes, as an image or as a function of a shader.
    Export(export::Arguments),
    /// Opens a window in which pixels are classified by clicks and variables are chosen for vectors.
    #[cfg(feature = "view")]
    View(view::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Check(arguments) => check::run(arguments),
        Task::Mark(arguments) => mark::run(arguments),
        Task::Augment(arguments) => augment::run(arguments),
        Task::Run(arguments) => run::run(arguments),
        Task::Classify(arguments) => classify::run(arguments),
        Task::Values(arguments) => values::run(arguments),
        Task::Export(arguments) => export::run(arguments),
        #[cfg(feature = "view")]
        Task::View(arguments) => view::run(arguments),
    }
}
