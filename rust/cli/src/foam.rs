//! `relievo foam`

mod composite;
mod export;
mod generate;
mod info;
mod picture;
mod render;
mod source;

use clap::Subcommand;

#[cfg(feature = "view")]
pub use self::generate::Run as FoamRun;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Makes spray, foam and bubbles from the frames of a fluid, or goes on where it was interrupted.
    #[command(after_help = "Example: relievo foam generate frames -o foam --air-rate 8000")]
    Generate(generate::Arguments),
    /// Renders foam with the fluid and solids by rays.
    #[command(
        after_help = "Example: relievo foam render foam/0040.rlvfluid --fluid frames/0040.rlvfluid --solid rock.obj -o wave.png"
    )]
    Render(render::Arguments),
    /// Renders foam over a picture of any renderer.
    #[command(
        after_help = "Example: relievo foam composite foam/0040.rlvfluid --picture water.exr --eye 3,-3,2 --target 0,0,0 -o wave.png"
    )]
    Composite(composite::Arguments),
    /// Writes foam for other renderers: a density file for media of POV-Ray, or particles with radii.
    #[command(after_help = "Example: relievo foam export foam/0040.rlvfluid -o foam.df3 --cell 0.02")]
    Export(export::Arguments),
    /// Lists the particles of frames by type, or the settings of pictures.
    #[command(after_help = "Example: relievo foam info foam")]
    Info(info::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Generate(arguments) => generate::run(arguments),
        Task::Render(arguments) => render::run(arguments),
        Task::Composite(arguments) => composite::run(arguments),
        Task::Export(arguments) => export::run(arguments),
        Task::Info(arguments) => info::run(arguments),
    }
}
