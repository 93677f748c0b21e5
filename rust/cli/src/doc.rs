//! `relievo doc`

pub mod displaced;
mod edits;
mod export;
mod import;
mod stroke;
mod transfer;
pub mod triangles;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use relievo_document::{Damage, compact, examine, repair};

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Replays a list of strokes on a mesh, or on a document of it.
    Stroke(stroke::Arguments),
    /// Verifies every block and every edit of a document and says which are damaged.
    Check(Named),
    /// Makes a damaged document one that opens: keeps what can be kept, says what is lost, and leaves the file as it
    /// was beside it with `.damaged` after its name.
    Repair(Named),
    /// Folds the edits of a document into its layers, which makes the file smaller; they can no longer be undone.
    Compact(Compact),
    /// Lists the edits of a document.
    Log(edits::Listed),
    /// Undoes the last edits of a document.
    Undo(edits::Moved),
    /// Makes undone edits of a document again.
    Redo(edits::Moved),
    /// Takes a document along: as Ptex, as a map on the texture coordinates of the mesh, or as a displaced mesh.
    Export(export::Arguments),
    /// Takes the layers of a document to another mesh, and says what of that mesh is uncovered.
    Transfer(transfer::Arguments),
    /// Makes a document of a Ptex file.
    Import(import::Arguments),
}

#[derive(clap::Args)]
struct Named {
    /// The document.
    file: PathBuf,
    /// Bytes that the file and what is made of it may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

#[derive(clap::Args)]
struct Compact {
    #[command(flatten)]
    document: Named,
    /// Edits that can still be undone, the last ones.
    #[arg(long, value_name = "EDITS", default_value_t = 0)]
    keep: usize,
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Stroke(arguments) => stroke::run(arguments),
        Task::Check(arguments) => check(arguments),
        Task::Repair(arguments) => mend(arguments),
        Task::Compact(arguments) => fold(arguments),
        Task::Log(arguments) => edits::list(arguments),
        Task::Undo(arguments) => edits::undo(arguments),
        Task::Redo(arguments) => edits::redo(arguments),
        Task::Export(arguments) => export::run(arguments),
        Task::Transfer(arguments) => transfer::run(arguments),
        Task::Import(arguments) => import::run(arguments),
    }
}

/// A line about `file` for each of `notes`.
fn lines(file: &Path, notes: impl IntoIterator<Item = String>) -> String {
    notes.into_iter().map(|note| format!("{}: {note}\n", file.display())).collect()
}

/// Ends with 1 if anything is damaged.
fn check(arguments: &Named) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let (document, damage) = examine(&context, &arguments.file)?;
    let blocks: usize = document.layers().iter().map(|layer| layer.blocks().len()).sum();
    let notes = document.notes.iter().cloned().chain(damage.iter().map(ToString::to_string));
    let sum = match damage.len() {
        0 => format!("no damage, {blocks} blocks of {} layers", document.layers().len()),
        count => format!("{count} parts are damaged, of {blocks} blocks; `relievo doc repair` keeps what can be kept"),
    };
    crate::print(&lines(&arguments.file, notes.chain([sum])))?;
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn mend(arguments: &Named) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let done = repair(&context, &arguments.file)?;
    let lost = |damage: &Damage| if damage.lost { "lost" } else { "restored" };
    let count = done.damage.iter().filter(|damage| damage.lost).count();
    let lost = done.damage.iter().map(|damage| format!("{}: {damage}", lost(damage)));
    let sum = match &done.kept {
        None => "nothing is damaged".to_string(),
        Some(kept) => {
            format!("repaired, {count} parts are lost and no edit can be undone; as it was: {}", kept.display())
        }
    };
    crate::print(&lines(&arguments.file, lost.chain(done.note.clone()).chain([sum])))?;
    Ok(ExitCode::SUCCESS)
}

fn fold(arguments: &Compact) -> Outcome {
    let Named { file, memory_limit } = &arguments.document;
    let limit = if *memory_limit == 0 { u64::MAX } else { *memory_limit };
    let done = compact(file, limit, arguments.keep)?;
    let [before, after] = done.bytes;
    let sum = format!(
        "{} edits are folded into its layers and can no longer be undone, {} undone ones are gone; {before} bytes before, \
         {after} after",
        done.edits, done.undone
    );
    crate::print(&lines(file, done.note.into_iter().chain([sum])))?;
    Ok(ExitCode::SUCCESS)
}
