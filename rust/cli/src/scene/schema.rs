//! `relievo scene schema`

use std::process::ExitCode;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let text = match arguments.json {
        true => format!("{:#}\n", relievo_scene::manual::json()),
        false => relievo_scene::manual::text(),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
