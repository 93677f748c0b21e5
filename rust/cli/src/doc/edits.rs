//! `relievo doc log`, `undo` and `redo`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, Result};
use relievo_document::{Entry, Journal, Log};
use serde_json::json;

use super::{Named, lines};
use crate::Outcome;

#[derive(clap::Args)]
pub struct Listed {
    #[command(flatten)]
    document: Named,
    /// Print JSON for programs, with what each edit was made of as a whole.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
pub struct Moved {
    /// The document.
    file: PathBuf,
    /// Edits to go back or forward by.
    #[arg(long, value_name = "EDITS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    edits: u32,
    /// Bytes that the file and what is made of it may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

/// Prints every edit, the oldest first; undone ones follow in the order in which they are made again.
pub fn list(arguments: &Listed) -> Outcome {
    let Named { file, memory_limit } = &arguments.document;
    let (edits, note) = relievo_document::list_edits(file, limit(*memory_limit))?;
    if arguments.json {
        let list = edits.iter().map(|edit| json!({ "done": edit.is_done, "bytes": edit.bytes, "input": edit.input }));
        crate::print(&format!("{:#}\n", json!({ "edits": list.collect::<Vec<_>>(), "note": note })))?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows = edits.iter().enumerate().map(|(index, edit)| {
        let state = if edit.is_done { "" } else { "undone, " };
        format!("{}: {state}{} bytes: {}", index + 1, edit.bytes, shortened(&edit.input))
    });
    let done = edits.iter().filter(|edit| edit.is_done).count();
    let sum = format!("{done} edits can be undone, {} can be made again", edits.len() - done);
    crate::print(&lines(file, rows.chain(note).chain([sum])))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the most bytes that a document may occupy.
fn limit(memory_limit: u64) -> u64 {
    if memory_limit == 0 { u64::MAX } else { memory_limit }
}

/// Returns the beginning of what an edit was made of, on one line.
fn shortened(input: &str) -> String {
    const CHARACTERS: usize = 96;
    let line = input.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(CHARACTERS) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None if line.is_empty() => "no description".into(),
        None => line,
    }
}

/// Undoes the last edits.
pub fn undo(arguments: &Moved) -> Outcome {
    change(arguments, "undone", |log| &log.done, Journal::undo)
}

/// Makes undone edits again.
pub fn redo(arguments: &Moved) -> Outcome {
    change(arguments, "made again", |log| &log.undone, Journal::redo)
}

/// Appends to the journal that the last entries of a list change sides, all or none of them.
fn change(
    Moved { file, edits, memory_limit }: &Moved,
    done: &str,
    list: impl Fn(&Log) -> &Vec<Entry>,
    note: impl Fn(&mut Journal, u64) -> Result<()>,
) -> Outcome {
    let (_, log, mut journal) = Journal::open(file, limit(*memory_limit))?;
    let entries = list(&log);
    if entries.len() < *edits as usize {
        let what = format!("{} edits can be {done}, {edits} are asked for", entries.len());
        let error = Error::invalid(what).at(file.display().to_string());
        return Err(error.advise("`relievo doc log` lists the edits").into());
    }
    entries.iter().rev().take(*edits as usize).try_for_each(|entry| note(&mut journal, entry.sequence))?;
    journal.sync()?;
    crate::print(&lines(file, [format!("{edits} edits are {done}")]))?;
    Ok(ExitCode::SUCCESS)
}
