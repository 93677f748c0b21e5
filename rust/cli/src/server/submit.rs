//! `relievo server submit`

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use relievo_client::Submit;
use relievo_core::{Error, file};
use relievo_simulation::{Description, FoamDescription};

use super::connection::{self, Connection};
use crate::Outcome;
use crate::bar::Bar;
use crate::fluid::beside;

const EXAMPLE: &str = "Example: relievo server submit examples/fluids/dam.toml --watch";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// What is simulated: a fluid, and what it meets, in TOML, as `relievo fluid sim` reads it. With a table `foam`, foam
    /// is simulated with it.
    description: PathBuf,
    /// The name of the scene on the server; left out, that of the file.
    #[arg(long)]
    name: Option<String>,
    /// Shows the progress until the scene is done.
    #[arg(long)]
    watch: bool,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

/// Bytes of a description at most.
const LONGEST: u64 = 1 << 20;

pub fn run(arguments: &Arguments) -> Outcome {
    let path = &arguments.description;
    let named = |error: Error| error.at(path.display().to_string());
    let text = String::from_utf8(file::load(path, LONGEST)?);
    let text = text.map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
    let (kind, description) = match FoamDescription::is_meant(&text) {
        true => ("foam", FoamDescription::parse(&text).map(|it| it.fluid)),
        false => ("fluid", Description::parse(&text)),
    };
    let description = description.map_err(named)?;
    let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let scene = arguments.name.clone().unwrap_or_else(stem);
    let folder = beside(path);
    let mut files = BTreeMap::new();
    for name in description.files().map_err(named)? {
        // What the description writes is UTF-8.
        files.insert(name.to_string_lossy().into_owned(), folder.path(&name)?);
    }
    let mut client = arguments.connection.client()?;
    let files = client.send_files(&files, &mut Bar::new())?;
    let submit = Submit { scene: scene.clone(), kind: kind.into(), description: text, files, forced: false };
    let mut status = client.submit(&submit)?;
    if arguments.watch {
        status = super::watch::watch(&mut client, &scene)?;
    }
    connection::print(&status, arguments.json)?;
    Ok(ExitCode::SUCCESS)
}
