//! `relievo fluid`

mod convert;
mod files;
mod frames;
mod info;
mod mesh;
mod plot;
#[cfg(feature = "server")]
mod rank;
mod render;
mod sim;
mod spacing;
mod statistics;
mod surface;

use clap::Subcommand;

#[cfg(any(feature = "server", feature = "view"))]
pub use self::files::beside;
pub use self::frames::{FrameBar, bar, chunk, frames, needs_folder, read};
pub use self::info::tell;
pub use self::render::{add_floor, bounds, ends};
pub use self::sim::FrameFormat;
#[cfg(feature = "view")]
pub use self::sim::Run as FluidRun;
pub use self::surface::Options as SurfaceOptions;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Simulates a fluid of particles and writes its frames, or goes on where it was interrupted.
    Sim(sim::Arguments),
    /// Simulates a fluid together with other processes, which connect by TCP, as one of their ranks.
    #[cfg(feature = "server")]
    Rank(rank::Arguments),
    /// Makes meshes of the surfaces of particles.
    Mesh(mesh::Arguments),
    /// Renders the surface of particles.
    Render(render::Rendering),
    /// Says what is in a file of particles or a folder of frames, or what a description begins as.
    Info(info::Arguments),
    /// Plots how a simulation went, from its statistics.
    Plot(plot::Arguments),
    /// Writes particles in another format.
    Convert(convert::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Sim(arguments) => sim::run(arguments),
        #[cfg(feature = "server")]
        Task::Rank(arguments) => rank::run(arguments),
        Task::Mesh(arguments) => mesh::run(arguments),
        Task::Render(arguments) => render::run(arguments),
        Task::Info(arguments) => info::run(arguments),
        Task::Plot(arguments) => plot::run(arguments),
        Task::Convert(arguments) => convert::run(arguments),
    }
}
