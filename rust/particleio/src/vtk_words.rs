//! Words and numbers of VTK's legacy files: lines of text, between them numbers as text or big-endian.

use relievo_core::{Budget, Error, Result};

use crate::bytes::{Bytes, cut_off};

/// The type of an array's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    pub fn named(name: &str) -> Result<Self> {
        Ok(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" => Self::I8,
            "unsigned_char" => Self::U8,
            "short" => Self::I16,
            "unsigned_short" => Self::U16,
            // VTK writes its own indices in 32 bits.
            "int" | "vtkidtype" => Self::I32,
            "unsigned_int" => Self::U32,
            "long" | "vtktypeint64" => Self::I64,
            "unsigned_long" | "vtktypeuint64" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => {
                return Err(Error::unsupported(format!("numbers of the type {name:?} cannot be read"))
                    .advise("leave the array out, or save it as floats"));
            }
        })
    }

    fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// A big-endian number of as many bytes as the type has.
    fn decode(self, bytes: &[u8]) -> f64 {
        let word = bytes.iter().fold(0u64, |word, byte| word << 8 | u64::from(*byte));
        match self {
            Self::I8 => f64::from(word as i8),
            Self::U8 => f64::from(word as u8),
            Self::I16 => f64::from(word as i16),
            Self::U16 => f64::from(word as u16),
            Self::I32 => f64::from(word as i32),
            Self::U32 => f64::from(word as u32),
            Self::I64 => word as i64 as f64,
            Self::U64 => word as f64,
            Self::F32 => f64::from(f32::from_bits(word as u32)),
            Self::F64 => f64::from_bits(word),
        }
    }
}

/// What is left of a file.
pub(crate) struct Words<'a> {
    bytes: Bytes<'a>,
    pub is_text: bool,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes: Bytes(bytes), is_text: true }
    }

    /// The rest of the line, without blanks at its ends; the next one is left.
    pub fn line(&mut self) -> Result<&'a str> {
        let rest = self.bytes.0;
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.bytes.0 = &rest[(end + 1).min(rest.len())..];
        std::str::from_utf8(rest[..end].trim_ascii()).map_err(|_| Error::invalid("a line is not UTF-8 text"))
    }

    /// The next line that is not empty, or `None` at the end of the file.
    pub fn next_line(&mut self) -> Result<Option<&'a str>> {
        self.bytes.0 = self.bytes.0.trim_ascii_start();
        if self.bytes.0.is_empty() { Ok(None) } else { self.line().map(Some) }
    }

    /// Whether the next line that is not empty begins with `word`.
    pub fn continues(&self, word: &str) -> bool {
        self.bytes.0.trim_ascii_start().starts_with(word.as_bytes())
    }

    fn word(&mut self) -> Result<&'a [u8]> {
        let rest = self.bytes.0.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.bytes.0 = &rest[end..];
        if end == 0 { Err(cut_off()) } else { Ok(&rest[..end]) }
    }

    /// Fails if fewer than `count` numbers can be left.
    fn expect(&self, count: u64, kind: Kind) -> Result<()> {
        let size = if self.is_text { 2 } else { kind.size() };
        let needed = count.checked_mul(size).ok_or_else(cut_off)?;
        // The last separator of a text may be missing.
        if needed > self.bytes.0.len() as u64 + 1 { Err(cut_off()) } else { Ok(()) }
    }

    /// Steps over `count` numbers.
    pub fn skip(&mut self, count: u64, kind: Kind) -> Result<()> {
        self.expect(count, kind)?;
        match self.is_text {
            true => (0..count).try_for_each(|_| self.word().map(drop)),
            false => self.bytes.take(count * kind.size()).map(drop),
        }
    }

    /// The next `count` numbers.
    pub fn numbers(&mut self, count: u64, kind: Kind, budget: &mut Budget) -> Result<Vec<f64>> {
        self.expect(count, kind)?;
        let mut numbers = Vec::new();
        budget.reserve(&mut numbers, count as usize)?;
        if !self.is_text {
            let bytes = self.bytes.take(count * kind.size())?;
            numbers.extend(bytes.chunks_exact(kind.size() as usize).map(|bytes| kind.decode(bytes)));
            return Ok(numbers);
        }
        for _ in 0..count {
            let word = self.word()?;
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
            numbers.push(number.ok_or_else(|| {
                let shown: String = String::from_utf8_lossy(word).chars().take(40).collect();
                Error::invalid(format!("{shown:?} is not a number"))
            })?);
        }
        Ok(numbers)
    }
}
