//! `[[brushes]]` of a scene file, read: brushes that ride on objects.

use glam::DVec3;

use crate::format::description::{ObjectEntry, RiderEntry};
use crate::format::diagnostic::Diagnostic;
use crate::format::names::Names;
use crate::format::reader::{Reader, Table};
use crate::format::strokes::{read_brush, read_objects};

pub(crate) fn read_rider(
    reader: &mut Reader,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
    stamps: &Names,
) -> Option<RiderEntry> {
    let place = DVec3::from(reader.vector(table, "place"));
    let along = DVec3::from(reader.optional_vector(table, "along").unwrap_or_default());
    let once = reader.flag(table, "once");
    let time = [reader.number(table, "from"), reader.number(table, "until")];
    let brush = read_brush(reader, table, stamps);
    let Some(name) = reader.text(table, "by") else {
        if !table.has("by") {
            reader.fault(Diagnostic::new(table.span(), "the brush rides on nothing").advise("give it `by`"));
        }
        return None;
    };
    let by = objects.find(reader, &name)?;
    let objects = read_objects(reader, table, objects, entries, Some(by))?;
    if objects.contains(&by) {
        reader.fault(
            Diagnostic::new(table.span_of("object"), "the brush rides on what it is made on")
                .relate(name.span.clone(), "it rides on this")
                .advise("name another object"),
        );
    }
    let (brush, stamp) = brush?;
    if let Err(error) = brush.check_brush()
        && reader.faults.is_empty()
    {
        reader.fault(Diagnostic::from_error(table.span(), &error));
    }
    Some(RiderEntry { by, objects, place, along, once, time, brush, stamp })
}
