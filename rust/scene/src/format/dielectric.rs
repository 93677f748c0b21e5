//! What a scene file says of bodies that light passes through.

use relievo_render::Dielectric;

use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Reader, Table};

/// Returns the dielectric of an object's table; `None` if it has none.
pub(crate) fn read_dielectric(reader: &mut Reader, table: Table) -> Option<Dielectric> {
    if !table.has("dielectric") {
        return None;
    }
    let table = reader.sub_table(table, "dielectric");
    let absorption = reader.vector(table, "absorption").map(|value| value as f32);
    let dielectric = Dielectric { index: reader.number(table, "index") as f32, absorption };
    if let Err(error) = dielectric.check() {
        reader.fault(Diagnostic::from_error(table.span_of("absorption"), &error));
    }
    Some(dielectric)
}
