//! Errors are values that say what went wrong, where, and what to do about it.

use std::fmt;

/// What kind of failure an [`Error`] is; the C ABI maps each kind to one `RLV_ERROR_…` value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// Data or an argument that cannot be used: out of range, not finite, malformed.
    Invalid,
    /// Valid input that this build or device does not handle.
    Unsupported,
    /// A file, name or element that does not exist.
    NotFound,
    /// The operating system refused to read or write.
    Io,
    /// A memory budget or limit would be exceeded; nothing was changed.
    Memory,
    /// Somebody else is using the object exclusively.
    Busy,
    /// The caller's progress callback asked to stop.
    Cancelled,
    /// A graphics device failed or was lost. What was committed is kept: open the device again, or use the processor.
    Device,
    /// A fault of Relievo or of a library below it.
    Internal,
}

/// An error with what happened, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The kind, for programs.
    pub kind: ErrorKind,
    /// What went wrong, one sentence without a full stop.
    pub what: String,
    /// Where: a file and line, an element, a key. Empty if `what` says it all.
    pub place: String,
    /// What the user can do. Empty if there is nothing to advise.
    pub remedy: String,
}

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of `kind` that says `what` happened.
    pub fn new(kind: ErrorKind, what: impl Into<String>) -> Self {
        Self { kind, what: what.into(), place: String::new(), remedy: String::new() }
    }

    /// An [`ErrorKind::Invalid`] error.
    pub fn invalid(what: impl Into<String>) -> Self {
        Self::new(ErrorKind::Invalid, what)
    }

    /// An [`ErrorKind::Unsupported`] error.
    pub fn unsupported(what: impl Into<String>) -> Self {
        Self::new(ErrorKind::Unsupported, what)
    }

    /// An [`ErrorKind::Memory`] error.
    pub fn memory(what: impl Into<String>) -> Self {
        Self::new(ErrorKind::Memory, what)
    }

    /// An [`ErrorKind::Internal`] error.
    pub fn internal(what: impl Into<String>) -> Self {
        Self::new(ErrorKind::Internal, what)
    }

    /// An error of the operating system about `path`, without the name of a temporary file, which says nothing to the user.
    pub fn io(path: &std::path::Path, cause: &std::io::Error) -> Self {
        let kind = match cause.kind() {
            std::io::ErrorKind::NotFound => ErrorKind::NotFound,
            _ => ErrorKind::Io,
        };
        let what = match cause.kind() {
            std::io::ErrorKind::UnexpectedEof => "the file ends too early".into(),
            _ => {
                let text = cause.to_string();
                let end = text.rfind(" at path \"").filter(|_| cause.raw_os_error().is_none());
                end.map_or(text.clone(), |end| text[..end].to_owned())
            }
        };
        let error = Self::new(kind, what).at(path.display().to_string());
        match cause.kind() {
            std::io::ErrorKind::UnexpectedEof => error.advise("it was cut off: copy it or write it again"),
            std::io::ErrorKind::NotFound => error.advise("check the name and the folder it is sought in"),
            std::io::ErrorKind::PermissionDenied => error.advise("check the rights of the file and its folder"),
            _ => error,
        }
    }

    /// Says where it happened. A place given earlier stays, as the inner part.
    pub fn at(mut self, place: impl Into<String>) -> Self {
        let place = place.into();
        self.place = if self.place.is_empty() { place } else { format!("{place}: {}", self.place) };
        self
    }

    /// Says what to do about it.
    pub fn advise(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.is_empty() {
            write!(out, "{}: ", self.place)?;
        }
        out.write_str(&self.what)?;
        if !self.remedy.is_empty() {
            write!(out, "; {}", self.remedy)?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// The candidate nearest to `word` by edit distance, if it is near enough to be a likely misspelling.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().max(word.len()) / 3)
        .min()
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_reads_place_what_remedy() {
        let error = Error::invalid("index 9 is out of range").at("face 3").at("a.obj").advise("use 0 to 7");
        assert_eq!(error.to_string(), "a.obj: face 3: index 9 is out of range; use 0 to 7");
    }

    #[test]
    fn nearest_finds_misspellings_and_rejects_strangers() {
        assert_eq!(nearest("tile_sise", ["tile_size", "budget"]), Some("tile_size"));
        assert_eq!(nearest("zebra", ["tile_size", "budget"]), None);
    }
}
