//! `relievo shader`

mod augment;
mod check;
mod classify;
mod export;
mod mark;
mod opened;
mod run;
mod values;
#[cfg(feature = "view")]
mod view;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::Subcommand;
use relievo_core::Result;
use relievo_shaderlab::{Faults, Shader, Source};

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

/// Prints the faults of a shader with their lines and ends the command.
fn refused(faults: &Faults) -> Outcome {
    let _ = write!(std::io::stderr(), "{faults}");
    Ok(ExitCode::FAILURE)
}

/// Evaluates to the value of a result with faults, or ends the command after they are printed.
macro_rules! sound {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(faults) => return $crate::shader::refused(&faults),
        }
    };
}
use sound;

/// Reads a shader file.
fn read(path: &Path) -> Result<std::result::Result<Shader, Faults>> {
    Ok(Shader::new(Source::read(path)?))
}

/// Writes a text to a file, which appears whole or not at all.
fn store(path: &Path, text: &str) -> Result<()> {
    relievo_core::file::store(path, |file| file.write_all(text.as_bytes()))
}

/// Reads a column and a row.
fn pixel(text: &str) -> std::result::Result<[u32; 2], String> {
    let numbers: Vec<_> = text.split(',').map(|part| part.trim().parse::<u32>()).collect();
    match numbers.as_slice() {
        [Ok(x), Ok(y)] => Ok([*x, *y]),
        _ => Err(format!("{text:?} is not a column and a row, such as 120,80")),
    }
}
