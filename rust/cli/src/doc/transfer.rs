//! `relievo doc transfer`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_bake::transfer::{TransferOptions, transfer_watched};
use relievo_document::Document;

use crate::Outcome;
use crate::args::limits::Isolation;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    /// The document.
    file: PathBuf,
    /// The mesh its layers are taken to.
    mesh: PathBuf,
    /// The document to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The mesh the document was made on, where it does not hold its points, or the mesh has creases.
    #[arg(long, value_name = "MESH")]
    from: Option<PathBuf>,
    /// How far a place of the old surface may be from one of the new, in units of the meshes; 2 % of the new mesh's
    /// extent if left out.
    #[arg(long, value_name = "DISTANCE")]
    reach: Option<f64>,
    #[command(flatten)]
    isolation: Isolation,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let document = Document::open(&arguments.file, context.memory_limit())?;
    let from = arguments.from.as_ref().map(|path| relievo_meshio::read(&context, path)).transpose()?;
    let mesh = relievo_meshio::read(&context, &arguments.mesh)?;
    let options = TransferOptions { reach: arguments.reach, isolation: arguments.isolation.isolation };
    let (made, report) = transfer_watched(&context, &document, from.as_ref(), &mesh, &options, &mut Bar::new())
        .map_err(|error| error.at(arguments.file.display().to_string()))?;
    made.write(&arguments.output)?;
    let notes: String = document.notes.iter().map(|note| format!("note: {note}\n")).collect();
    crate::print(&format!("{notes}{report}\n"))?;
    Ok(ExitCode::SUCCESS)
}
