//! `relievo server status`

use std::process::ExitCode;

use relievo_client::{Nothing, SceneList};
use serde_json::Value;

use super::connection::{self, Connection};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo server status --json";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The name of the scene; left out, all of yours.
    scene: Option<String>,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let mut client = arguments.connection.client()?;
    if let Some(scene) = &arguments.scene {
        connection::print(&client.status(scene)?, arguments.json)?;
        return Ok(ExitCode::SUCCESS);
    }
    let SceneList { scenes } = client.call("scene.list", &Nothing {})?;
    let text = match arguments.json {
        true => format!("{:#}\n", Value::from_iter(scenes.iter().map(connection::value))),
        false => scenes.iter().map(connection::line).collect(),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
