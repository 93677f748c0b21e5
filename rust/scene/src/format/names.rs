//! Names of one section of a scene file, by which other sections refer to its entries.

use relievo_core::error::nearest;

use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Name, Reader, Table};

/// Names of one section, by which others refer to it.
pub(crate) struct Names<'n> {
    section: &'static str,
    list: Vec<&'n Name>,
}

impl<'n> Names<'n> {
    pub(crate) fn new<T>(section: &'static str, entries: &'n [(Name, T)]) -> Self {
        Self { section, list: entries.iter().map(|(name, _)| name).collect() }
    }

    pub(crate) fn find(&self, reader: &mut Reader, name: &Name) -> Option<usize> {
        let found = self.list.iter().position(|known| known.text == name.text);
        if found.is_none() {
            let fault =
                Diagnostic::new(name.span.clone(), format!("there is no `{}` in [{}]", name.text, self.section));
            reader.fault(match nearest(&name.text, self.list.iter().map(|known| known.text.as_str())) {
                Some(near) => fault.advise(format!("did you mean `{near}`?")),
                None => fault.advise(format!("add [{}.{}]", self.section, name.text)),
            });
        }
        found
    }
}

/// The object at `key`, or the object that has the entry's own name.
pub(crate) fn own_object(reader: &mut Reader, name: &Name, table: Table, objects: &Names) -> Option<usize> {
    match reader.text(table, "object") {
        Some(object) => objects.find(reader, &object),
        None if table.has("object") => None,
        None => objects.find(reader, name),
    }
}
