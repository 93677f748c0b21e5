//! `relievo server watch`

use std::process::ExitCode;

use relievo_client::{Client, Status};
use relievo_core::Result;

use super::connection::{self, Connection};
use crate::Outcome;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo server watch dam";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The name of the scene.
    scene: String,
    #[command(flatten)]
    connection: Connection,
}

/// Waits until a scene is done, and shows its progress.
pub fn watch(client: &mut Client, scene: &str) -> Result<Status> {
    let last = client.status(scene)?.frames - 1;
    client.wait(scene, last, &mut Bar::new())
}

pub fn run(arguments: &Arguments) -> Outcome {
    let status = watch(&mut arguments.connection.client()?, &arguments.scene)?;
    connection::print(&status, false)?;
    Ok(ExitCode::SUCCESS)
}
