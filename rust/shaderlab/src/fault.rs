//! Faults of a shader: messages that point at bytes of the user's own text.

use std::fmt;
use std::ops::Range;

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;
use relievo_core::Error;

use crate::source::Source;

/// Bytes of the user's text.
pub type Span = Range<usize>;

/// One fault of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong, one sentence without a full stop.
    pub what: String,
    /// The bytes that it is about.
    pub span: Span,
    /// Other bytes that matter, with what to say beside them.
    pub related: Vec<(Span, String)>,
    /// What to do about it; may be empty.
    pub remedy: String,
}

impl Fault {
    /// Makes a fault at `span`.
    pub fn new(span: Span, what: impl Into<String>) -> Self {
        Self { what: what.into(), span, related: Vec::new(), remedy: String::new() }
    }

    /// Points at other bytes as well.
    pub fn relate(mut self, span: Span, label: impl Into<String>) -> Self {
        self.related.push((span, label.into()));
        self
    }

    /// Says what to do.
    pub fn advise(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }
}

/// All faults found in a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faults {
    /// The shader.
    pub source: Source,
    /// The faults, at least one.
    pub list: Vec<Fault>,
}

/// Faults without the shader that has them.
pub(crate) type Checked<T> = std::result::Result<T, Vec<Fault>>;

impl Faults {
    /// Gives the faults of a shader their text.
    pub(crate) fn of(source: &Source) -> impl FnOnce(Vec<Fault>) -> Self + use<> {
        let source = source.clone();
        |list| Self { source, list }
    }

    /// Returns line and column of the start of a span, counted from 1 in characters.
    pub fn place(&self, span: &Span) -> (usize, usize) {
        self.source.place(span)
    }
}

/// Returns the part of a span that lies in the text, between whole characters.
pub(crate) fn clip(text: &str, span: &Span) -> Span {
    let floor = |at: usize| (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let start = floor(span.start);
    start..floor(span.end).max(start)
}

impl fmt::Display for Faults {
    /// Writes each fault with its line and an underline.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = &*self.source.text;
        let files = SimpleFile::new(&self.source.name, text);
        let config = term::Config { chars: term::Chars::ascii(), ..term::Config::default() };
        for fault in &self.list {
            let mut labels = vec![Label::primary((), clip(text, &fault.span))];
            let related = fault.related.iter();
            labels.extend(related.map(|(span, label)| Label::secondary((), clip(text, span)).with_message(label)));
            let mut report = Diagnostic::error().with_message(&fault.what).with_labels(labels);
            if !fault.remedy.is_empty() {
                report = report.with_notes(vec![fault.remedy.clone()]);
            }
            out.write_str(&term::emit_into_string(&config, &files, &report).map_err(|_| fmt::Error)?)?;
        }
        Ok(())
    }
}

impl From<Faults> for Error {
    fn from(faults: Faults) -> Self {
        let Some(first) = faults.list.first() else { return Error::invalid("the shader cannot be used") };
        let more = match faults.list.len() {
            1 => String::new(),
            count => format!(" (and {} more)", count - 1),
        };
        let (line, column) = faults.place(&first.span);
        Error::invalid(format!("{}{more}", first.what))
            .at(format!("{}:{line}:{column}", faults.source.name))
            .advise(first.remedy.clone())
    }
}
