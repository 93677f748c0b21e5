//! `[[crowds]]` of a scene file, read.

use crate::format::description::CrowdEntry;
use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Reader, Table};

/// Reads an item of `[[crowds]]`.
pub(crate) fn read_crowd(reader: &mut Reader, table: Table) -> Option<CrowdEntry> {
    let (file, agents) = (reader.text(table, "file"), reader.text(table, "agents"));
    for key in ["file", "agents"] {
        if !table.has(key) {
            let what = format!("the crowd has no `{key}`");
            reader.fault(Diagnostic::new(table.span(), what).advise(format!("give it `{key}`")));
        }
    }
    Some(CrowdEntry {
        name: reader.text(table, "name"),
        clip: reader.text(table, "clip"),
        pixels: reader.number(table, "pixels") as f32,
        colour: reader.colour(table, "colour"),
        file: file?,
        agents: agents?,
    })
}
