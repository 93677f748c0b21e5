//! `relievo doc`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Subcommand;
use relievo_document::examine;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Verifies every block of a document and says which are damaged.
    Check(Check),
}

#[derive(clap::Args)]
struct Check {
    /// The document.
    file: PathBuf,
    /// Bytes that the file and what is made of it may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Check(arguments) => check(arguments),
    }
}

/// Ends with 1 if anything is damaged.
fn check(arguments: &Check) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let (document, damage) = examine(&context, &arguments.file)?;
    let blocks: usize = document.layers().iter().map(|layer| layer.blocks().len()).sum();
    let file = arguments.file.display();
    let mut text: String = damage.iter().map(|damage| format!("{file}: {damage}\n")).collect();
    text += &match damage.len() {
        0 => format!("{file}: no damage, {blocks} blocks of {} layers\n", document.layers().len()),
        count => format!("{file}: {count} parts are damaged, of {blocks} blocks\n"),
    };
    crate::print(&text)?;
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
