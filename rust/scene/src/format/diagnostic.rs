//! What is wrong with a scene file: messages that point at the offending bytes of the file.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use codespan_reporting::diagnostic as codespan;
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;
use relievo_core::Error;

/// Bytes of the scene file, from and up to.
pub type Span = Range<usize>;

/// One fault of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// What is wrong, one sentence without a full stop.
    pub what: String,
    /// The bytes it is about.
    pub span: Span,
    /// Said beside those bytes; may be empty.
    pub label: String,
    /// Other bytes that matter, with what to say beside them.
    pub related: Vec<(Span, String)>,
    /// What to do about it; may be empty.
    pub remedy: String,
}

impl Diagnostic {
    /// A fault at `span`.
    pub fn new(span: Span, what: impl Into<String>) -> Self {
        Self { what: what.into(), span, label: String::new(), related: Vec::new(), remedy: String::new() }
    }

    /// Says `label` beside the offending bytes.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
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

    /// The fault that `error` reports about what is written at `span`.
    pub fn from_error(span: Span, error: &Error) -> Self {
        let place = if error.place.is_empty() { String::new() } else { format!("{}: ", error.place) };
        Self::new(span, format!("{place}{}", error.what)).advise(error.remedy.clone())
    }
}

/// All faults found in one scene file, and the file they point into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faults {
    /// Name of the file as the user gave it.
    pub name: String,
    /// The text of the file.
    pub text: Arc<str>,
    /// The faults, in the order of the file.
    pub list: Vec<Diagnostic>,
}

impl Faults {
    fn files(&self) -> SimpleFile<&str, &str> {
        SimpleFile::new(&self.name, &self.text)
    }

    fn reports(&self) -> impl Iterator<Item = codespan::Diagnostic<()>> + '_ {
        // A span at the very end of a file has no line of its own.
        let clip = |span: &Span| span.start.min(self.text.len())..span.end.min(self.text.len());
        self.list.iter().map(move |fault| {
            let mut labels = vec![codespan::Label::primary((), clip(&fault.span)).with_message(&fault.label)];
            labels.extend(
                fault.related.iter().map(|(span, text)| codespan::Label::secondary((), clip(span)).with_message(text)),
            );
            let mut report = codespan::Diagnostic::error().with_message(&fault.what).with_labels(labels);
            if !fault.remedy.is_empty() {
                report = report.with_notes(vec![fault.remedy.clone()]);
            }
            report
        })
    }

    /// Writes the faults, each with its line and an underline, to a terminal or a file.
    ///
    /// # Errors
    /// Fails with the error of `out` if it cannot be written.
    pub fn write(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        write!(out, "{self}")
    }

    /// Line and column of the first fault, counted from 1.
    pub fn first_line(&self) -> Option<(usize, usize)> {
        let start = self.list.first()?.span.start.min(self.text.len());
        let before = self.text.get(..start)?;
        let line = before.matches('\n').count() + 1;
        Some((line, start - before.rfind('\n').map_or(0, |at| at + 1) + 1))
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let config = term::Config { chars: term::Chars::ascii(), ..term::Config::default() };
        let files = self.files();
        for report in self.reports() {
            let text = term::emit_into_string(&config, &files, &report).map_err(|_| fmt::Error)?;
            out.write_str(&text)?;
        }
        Ok(())
    }
}

impl From<&Faults> for Error {
    fn from(faults: &Faults) -> Self {
        let Some(first) = faults.list.first() else { return Error::invalid("the scene cannot be used") };
        let more = match faults.list.len() {
            1 => String::new(),
            count => format!(" (and {} more)", count - 1),
        };
        let (line, column) = faults.first_line().unwrap_or((1, 1));
        Error::invalid(format!("{}{more}", first.what))
            .at(format!("{}:{line}:{column}", faults.name))
            .advise(first.remedy.clone())
    }
}

/// Why a scene was not read or not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The scene file has faults.
    Scene(Faults),
    /// Anything else.
    Other(Error),
}

impl From<Faults> for Failure {
    fn from(faults: Faults) -> Self {
        Failure::Scene(faults)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Other(error)
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Scene(faults) => Error::from(&faults),
            Failure::Other(error) => error,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Scene(faults) => faults.fmt(out),
            Failure::Other(error) => writeln!(out, "error: {error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_shows_its_line_and_underlines_the_span() {
        let text = "version = 1\nfpz = 24\n";
        let list = vec![Diagnostic::new(12..15, "unknown key `fpz`").advise("did you mean `fps`?")];
        let faults = Faults { name: "a.toml".into(), text: text.into(), list };
        let shown = faults.to_string();
        assert!(shown.contains("a.toml:2:1"), "{shown}");
        assert!(shown.contains("fpz = 24") && shown.contains("^^^"), "{shown}");
        assert!(shown.contains("did you mean `fps`?"), "{shown}");
        assert_eq!(Error::from(&faults).to_string(), "a.toml:2:1: unknown key `fpz`; did you mean `fps`?");
    }

    #[test]
    fn a_span_beyond_the_text_is_clipped() {
        let faults = Faults { name: "a".into(), text: "x".into(), list: vec![Diagnostic::new(5..9, "late")] };
        assert!(faults.to_string().contains("late"));
    }
}
