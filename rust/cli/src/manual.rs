//! `relievo manual`, which packages are made with.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::CommandFactory;
use relievo_core::Error;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the pages, which is made.
    folder: PathBuf,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let folder = &arguments.folder;
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    clap_mangen::generate_to(crate::Arguments::command(), folder).map_err(|error| Error::io(folder, &error))?;
    Ok(ExitCode::SUCCESS)
}
