//! Little-endian numbers, one behind the other, in a piece of a file.

use relievo_core::{Error, Result};

/// Reads numbers from the front of what is left.
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    /// Where `bytes` began in the file or block.
    start: u64,
    length: usize,
}

impl<'a> Fields<'a> {
    /// Numbers in `bytes`, which lie `start` bytes behind the beginning of the file or block.
    pub fn new(bytes: &'a [u8], start: u64) -> Self {
        Self { bytes, start, length: bytes.len() }
    }

    /// Where the next number is.
    pub fn offset(&self) -> u64 {
        self.start + (self.length - self.bytes.len()) as u64
    }

    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let Some((piece, rest)) = self.bytes.split_at_checked(count) else {
            let what = format!("{count} bytes are expected, but {} are left", self.bytes.len());
            return Err(damaged(what, self.offset()));
        };
        self.bytes = rest;
        Ok(piece)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub fn u8(&mut self) -> Result<u8> {
        self.array().map(u8::from_le_bytes)
    }

    pub fn u16(&mut self) -> Result<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }
}

/// The error for what cannot be in a sound file, at `offset`.
pub(crate) fn damaged(what: impl Into<String>, offset: u64) -> Error {
    Error::invalid(what).at(format!("byte {offset}")).advise("the file is damaged or cut off: write it again")
}

/// The `length` bytes at `start` of a file; `what` names them.
pub(crate) fn section<'a>(bytes: &'a [u8], start: u64, length: u64, what: &str) -> Result<&'a [u8]> {
    let range = usize::try_from(start).ok().zip(start.checked_add(length).and_then(|end| usize::try_from(end).ok()));
    range.and_then(|(start, end)| bytes.get(start..end)).ok_or_else(|| {
        damaged(format!("{what} of {length} bytes would end behind the file, which has {}", bytes.len()), start)
    })
}
