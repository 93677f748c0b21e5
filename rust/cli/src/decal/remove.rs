//! `relievo decal remove`

use std::process::ExitCode;

use relievo_core::Result;
use relievo_decal::{Ground, Printable, Recipe};
use serde_json::json;

use super::kept::{self, Task, path};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo decal remove spot.obj spot.relievo --layer logo";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    kept: kept::Arguments,
}

struct Remove;

impl Task for Remove {
    type Done = u32;

    fn run<O: Printable>(self, ground: &mut Ground<'_, O>, id: u32, _recipe: Recipe) -> Result<u32> {
        ground.remove(id)?;
        Ok(id)
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let kept = &arguments.kept;
    let mut opened = kept.open()?;
    let id = kept.work(&mut opened, Remove)?;
    let file = path(&kept.document);
    let text = if kept.json {
        format!("{:#}\n", json!({ "file": file, "decal": id }))
    } else {
        let notes: String = opened.notes.iter().map(|note| format!("note: {note}\n")).collect();
        format!("{notes}{file}\n")
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
