//! `relievo server control`

use std::process::ExitCode;

use relievo_client::{Nothing, SceneName, Status};

use super::connection::{self, Connection};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo server control dam pause";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The name of the scene.
    scene: String,
    /// What to do with it.
    #[arg(value_enum)]
    action: Action,
    #[command(flatten)]
    connection: Connection,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Action {
    /// Stops after the frame that is computed.
    Pause,
    /// Goes on, also after it was cancelled or failed.
    Resume,
    /// Stops at once. The frames that are there stay.
    Cancel,
    /// Forgets the scene and its meshes. Its frames stay in the cache until there is no room for others.
    Remove,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let mut client = arguments.connection.client()?;
    let name = SceneName { scene: arguments.scene.clone() };
    let method = match arguments.action {
        Action::Pause => "scene.pause",
        Action::Resume => "scene.resume",
        Action::Cancel => "scene.cancel",
        Action::Remove => {
            let _: Nothing = client.call("scene.remove", &name)?;
            return Ok(ExitCode::SUCCESS);
        }
    };
    let status: Status = client.call(method, &name)?;
    connection::print(&status, false)?;
    Ok(ExitCode::SUCCESS)
}
