//! `[[tissue]]` of a scene file, read.

use crate::format::description::TissueEntry;
use crate::format::diagnostic::Diagnostic;
use crate::format::names::Names;
use crate::format::reader::{Reader, Table};

/// Reads an item of `[[tissue]]`.
pub(crate) fn read_tissue(reader: &mut Reader, table: Table, objects: &Names) -> Option<TissueEntry> {
    for key in ["name", "simulation"] {
        if !table.has(key) {
            let what = format!("the tissue has no `{key}`");
            reader.fault(Diagnostic::new(table.span(), what).advise(format!("give it `{key}`")));
        }
    }
    let (name, simulation) = (reader.text(table, "name"), reader.text(table, "simulation"));
    if let Some(name) =
        name.as_ref().filter(|name| !name.text.chars().all(|c| c.is_alphanumeric() || "_- ".contains(c)))
    {
        reader.fault(
            Diagnostic::new(name.span.clone(), "the name of a tissue has letters, digits, spaces, _ and - alone")
                .advise("files of its frames have that name"),
        );
    }
    let friction = reader.number(table, "friction") as f32;
    let colliders = reader.texts(table, "colliders").unwrap_or_default();
    let colliders: Vec<_> = colliders.iter().map(|name| objects.find(reader, name)).collect();
    Some(TissueEntry {
        name: name?,
        simulation: simulation?,
        colliders: colliders.into_iter().collect::<Option<_>>()?,
        friction,
    })
}
