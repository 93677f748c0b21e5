//! `relievo tissue`

mod body;
mod build;
mod info;
mod motion;
mod picture;
mod render;
mod sim;

use std::path::{Path, PathBuf};

use clap::Subcommand;
use relievo_core::error::nearest;
use relievo_core::{Context, Error, Result, file};
use relievo_tissue::{Model, SavedState, Simulation};
use serde::de::DeserializeOwned;

use crate::Outcome;
use crate::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Makes a finite-element model from surfaces, or converts one.
    Build(build::Arguments),
    /// Simulates a model and writes its frames, or goes on where it was interrupted.
    Sim(sim::Arguments),
    /// Renders a model or its frames, coloured by material, stress, strain or muscle.
    Render(render::Arguments),
    /// Says what is in a model or a frame.
    Info(info::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Build(arguments) => build::run(arguments),
        Task::Sim(arguments) => sim::run(arguments),
        Task::Render(arguments) => render::run(arguments),
        Task::Info(arguments) => info::run(arguments),
    }
}

/// Bytes of a description at most.
const LONGEST: u64 = 1 << 22;

/// Reads a description in TOML. An unknown key is an error that names the one that may be meant.
fn description<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let named = |error: Error| error.at(path.display().to_string());
    let bytes = file::load(path, LONGEST)?;
    let text = std::str::from_utf8(&bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
    toml::from_str(text).map_err(|error| {
        let described = Error::invalid(error.to_string());
        let mut names = error.message().split('`').skip(1).step_by(2);
        let word = names.next().filter(|_| error.message().starts_with("unknown"));
        named(match word.and_then(|word| nearest(word, names)) {
            Some(name) => described.advise(format!("perhaps `{name}` is meant")),
            None => described,
        })
    })
}

/// Returns the folder of a file, from which other files are named.
fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

/// Returns whether the extension of a path is `extension`.
fn is_named(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Reads a model: `.rtissue`, or Abaqus' `.inp`, of which keywords that are passed over are noted.
fn model(context: &Context, path: &Path) -> Result<Model> {
    if is_named(path, "inp") {
        let read = Model::read_inp(context, path)?;
        read.notes.iter().for_each(|note| eprintln!("note: {}: {note}", path.display()));
        return Ok(read.model);
    }
    Model::read(context, path)
}

/// Reads a frame and puts the simulation there.
fn show(context: &Context, simulation: &mut Simulation, path: &Path) -> Result<()> {
    let saved = SavedState::read(context, path)?;
    simulation.set_state(saved.state).map_err(|error| error.at(path.display().to_string()))
}
