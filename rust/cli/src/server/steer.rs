//! `relievo server steer`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, file};

use super::connection::{self, Connection};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo server steer dam --after 24 --set 'fluid.viscosity = 0.1'";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The name of the scene.
    scene: String,
    /// The last frame that stays; later ones are computed anew.
    #[arg(long, value_name = "FRAME")]
    after: u64,
    /// A key of the description and its new value, as in the description. May be given several times.
    #[arg(long, value_name = "KEY = VALUE", required_unless_present = "file")]
    set: Vec<String>,
    /// A file with keys and values in place of --set.
    #[arg(long, value_name = "FILE", conflicts_with = "set")]
    file: Option<PathBuf>,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

/// Bytes of a file with changes at most.
const LONGEST: u64 = 1 << 20;

pub fn run(arguments: &Arguments) -> Outcome {
    let changes = match &arguments.file {
        None => arguments.set.join("\n"),
        Some(path) => String::from_utf8(file::load(path, LONGEST)?)
            .map_err(|_| Error::invalid("it is not UTF-8 text").at(path.display().to_string()))?,
    };
    let status = arguments.connection.client()?.steer(&arguments.scene, arguments.after, &changes)?;
    connection::print(&status, arguments.json)?;
    Ok(ExitCode::SUCCESS)
}
