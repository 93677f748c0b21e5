//! `relievo tissue`

mod build;
mod info;
pub mod picture;
pub mod render;
mod sim;

use std::path::Path;

use clap::Subcommand;
use relievo_core::{Context, Result};
use relievo_scene::tissue::{is_named, read_model};
use relievo_tissue::{Model, SavedState, Simulation};

pub use self::info::tell;
use crate::Outcome;
use crate::args::limits::Limits;

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
    /// Renders a model or its frames, coloured by material, stress, strain, contact pressure or muscle.
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

/// Reads a model, or builds that of a description, and notes what was passed over.
pub fn model(context: &Context, path: &Path) -> Result<Model> {
    let (model, notes) = read_model(context, path)?;
    notes.iter().for_each(|note| eprintln!("note: {note}"));
    Ok(model)
}

/// Reads a frame and puts the simulation there.
pub fn show(context: &Context, simulation: &mut Simulation, path: &Path) -> Result<()> {
    let saved = SavedState::read(context, path)?;
    simulation.set_state(saved.state).map_err(|error| error.at(path.display().to_string()))
}
