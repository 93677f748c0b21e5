//! `[stamps.NAME]` of a scene file, read.

use relievo_detail::{StampChannel, StampSettings};

use crate::format::description::{StampEntry, StampSource};
use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Name, Reader, Table};
use crate::format::strokes::named;

pub(crate) fn read_stamp(reader: &mut Reader, name: &Name, table: Table) -> Option<StampEntry> {
    let channel = named(&StampChannel::NAMES, reader.choice(table, "channel"));
    let mut settings = StampSettings::default();
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    let (image, pattern) = (reader.text(table, "image"), reader.choice(table, "pattern"));
    let source = match (image, pattern) {
        (Some(file), None) => StampSource::File(file),
        (None, Some(pattern)) => StampSource::Pattern(pattern),
        (Some(file), Some(_)) => {
            reader.fault(
                Diagnostic::new(table.span_of("pattern"), "a stamp cannot be a file and a pattern")
                    .relate(file.span, "it is this file")
                    .advise("keep one of them"),
            );
            return None;
        }
        (None, None) => {
            reader.fault(
                Diagnostic::new(name.span.clone(), "the stamp has no image").advise("give it `image` or `pattern`"),
            );
            return None;
        }
    };
    Some(StampEntry { name: name.clone(), source, channel, settings })
}
