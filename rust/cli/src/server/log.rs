//! The log of the server: a line of `key=value` pairs an event, on standard error.

use std::fmt::{self, Write as _};
use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// Writes events of Relievo's crates down to a level.
struct Log {
    level: Level,
}

/// A line in the making.
struct Line(String);

impl Visit for Line {
    fn record_str(&mut self, field: &Field, value: &str) {
        // Quotes and escapes keep an event on its line, whatever a client sent.
        let _ = write!(self.0, " {}={value:?}", field.name());
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        let text = format!("{value:?}");
        let is_plain = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b".:/_-".contains(&byte));
        let _ = match is_plain {
            true => write!(self.0, " {}={text}", field.name()),
            false => write!(self.0, " {}={text:?}", field.name()),
        };
    }
}

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= &self.level && metadata.target().starts_with("relievo")
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let level = event.metadata().level();
        let mut line = Line(format!("time={}.{:03} level={level}", time.as_secs(), time.subsec_millis()));
        event.record(&mut line);
        line.0.push('\n');
        // A log that cannot be written is no reason to stop.
        let _ = std::io::stderr().lock().write_all(line.0.as_bytes());
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// Begins to write events down to a level.
pub fn begin(level: Level) {
    // A log that is there already stays.
    let _ = tracing::subscriber::set_global_default(Log { level });
}
