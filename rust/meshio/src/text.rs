//! Words of a text file with the number of their line.

use relievo_core::{Error, Result};

/// What some editors put before UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Walks over the words of a text. Lines end with `\n`, `\r\n` or `\r`.
#[derive(Clone, Debug)]
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    comment: Option<u8>,
    continued: bool,
}

impl<'a> Words<'a> {
    /// Words separated by blanks. A byte order mark is stepped over.
    pub fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        Self { bytes, at: 0, line: 1, comment: None, continued: false }
    }

    /// A word that starts with `mark` begins a comment, which ends with its line.
    pub fn with_comments(self, mark: u8) -> Self {
        Self { comment: Some(mark), ..self }
    }

    /// A backslash at the end of a line continues it on the next one.
    pub fn with_continuation(self) -> Self {
        Self { continued: true, ..self }
    }

    /// Line of the word last returned, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// The bytes behind the last word or line end taken.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Bytes left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Steps over a line end at `at`.
    fn line_end(&self, at: usize) -> usize {
        match (self.bytes.get(at), self.bytes.get(at + 1)) {
            (Some(b'\r'), Some(b'\n')) => at + 2,
            (Some(_), _) => at + 1,
            (None, _) => at,
        }
    }

    /// The next word of this line.
    #[inline]
    pub fn next_in_line(&mut self) -> Option<&'a [u8]> {
        let mut at = self.at;
        loop {
            match self.bytes.get(at) {
                Some(b' ' | b'\t' | 0x0b | 0x0c) => at += 1,
                Some(b'\\') if self.continued && matches!(self.bytes.get(at + 1), Some(b'\n' | b'\r')) => {
                    at = self.line_end(at + 1);
                    self.line += 1;
                }
                _ => break,
            }
        }
        self.at = at;
        let rest = self.bytes.get(at..)?;
        let first = *rest.first()?;
        if matches!(first, b'\n' | b'\r') || Some(first) == self.comment {
            return None;
        }
        let mut length = rest
            .iter()
            .position(|byte| matches!(byte, b' ' | b'\t' | 0x0b | 0x0c | b'\n' | b'\r'))
            .unwrap_or(rest.len());
        // A backslash directly behind a word also continues the line.
        if self.continued && length > 1 && rest[length - 1] == b'\\' && matches!(rest.get(length), Some(b'\n' | b'\r'))
        {
            length -= 1;
        }
        self.at = at + length;
        Some(&rest[..length])
    }

    /// Goes to the start of the next line. `false` at the end of the file.
    #[inline]
    pub fn next_line(&mut self) -> bool {
        loop {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let Some(length) = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')) else {
                self.at = self.bytes.len();
                return false;
            };
            // Comments are continued too.
            let joined = self.continued && length > 0 && rest[length - 1] == b'\\';
            self.at = self.line_end(self.at + length);
            self.line += 1;
            if !joined {
                return self.at < self.bytes.len();
            }
        }
    }

    /// The rest of this line without blanks at its ends.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// The next word of this or a later line.
    pub fn next_word(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.next_in_line() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }
}

/// A finite number.
#[inline]
pub(crate) fn finite(word: &[u8]) -> Option<f32> {
    number(word).filter(|value| value.is_finite())
}

/// A number, perhaps not finite.
#[inline]
pub(crate) fn number(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A whole number.
pub(crate) fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word as it can be shown in a message: at most 40 bytes of it.
pub(crate) fn shown(word: &[u8]) -> String {
    let short = &word[..word.len().min(40)];
    let more = if short.len() < word.len() { "…" } else { "" };
    format!("{:?}{more}", String::from_utf8_lossy(short))
}

/// The finite number `word` at `line`, or an error that says which of the two it is not.
pub(crate) fn expect_finite(word: Option<&[u8]>, line: u64, what: &str) -> Result<f32> {
    let word = word.ok_or_else(|| at_line(Error::invalid(format!("{what} is missing")), line))?;
    finite(word).ok_or_else(|| {
        let problem = if number(word).is_some() { "is not finite" } else { "is not a number" };
        at_line(Error::invalid(format!("{what} {} {problem}", shown(word))).advise("repair it and export again"), line)
    })
}

/// The error at that line.
pub(crate) fn at_line(error: Error, line: u64) -> Error {
    error.at(format!("line {line}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(u64, String)> {
        let mut words = Words::new(text.as_bytes()).with_comments(b'#').with_continuation();
        std::iter::from_fn(|| words.next_word().map(<[u8]>::to_vec).map(|word| (words.line(), word)))
            .map(|(line, word)| (line, String::from_utf8(word).unwrap()))
            .collect()
    }

    #[test]
    fn words_know_their_lines_through_comments_continuations_and_all_line_ends() {
        let text = "a b\r\nc # x y\r\nd \\\r\n e\rf\\\ng\n\n#\n h";
        let expected = [(1, "a"), (1, "b"), (2, "c"), (3, "d"), (4, "e"), (5, "f"), (6, "g"), (9, "h")];
        assert_eq!(words(text), expected.map(|(line, word)| (line, word.to_string())));
    }

    #[test]
    fn numbers_are_finite_or_named() {
        assert_eq!(finite(b"-1.5e3"), Some(-1500.0));
        assert_eq!(finite(b"1e999"), None);
        let message = |word: &[u8]| expect_finite(Some(word), 7, "x").unwrap_err().to_string();
        assert_eq!(message(b"nan"), "line 7: x \"nan\" is not finite; repair it and export again");
        assert_eq!(message(b"1,5"), "line 7: x \"1,5\" is not a number; repair it and export again");
    }
}
