//! Columns of numbers in the chunks of files of progressive meshes: written, read, and what is said of a damaged one.

use relievo_core::{Error, Result};

const LEVEL: i32 = 5;

/// Columns that are written.
#[derive(Default)]
pub(super) struct Writer(pub(crate) Vec<u8>);

impl Writer {
    pub(super) fn column(&mut self, values: &[u32]) {
        for plane in 0..4 {
            self.0.extend(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
    }

    /// The bytes of a chunk.
    pub(super) fn chunk(self) -> std::io::Result<Vec<u8>> {
        let packed = zstd::bulk::compress(&self.0, LEVEL)?;
        let head = [self.0.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
        Ok(head.into_iter().flat_map(u32::to_le_bytes).chain(packed).collect())
    }
}

/// Columns that are read.
pub(super) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(super) fn column(&mut self, count: usize) -> Result<Vec<u32>> {
        let (bytes, rest) = self.0.split_at_checked(4 * count).ok_or_else(|| damaged("a chunk is too short"))?;
        self.0 = rest;
        let byte = |plane: usize, index: usize| u32::from(bytes[plane * count + index]) << (8 * plane);
        Ok((0..count).map(|index| byte(0, index) | byte(1, index) | byte(2, index) | byte(3, index)).collect())
    }
}

/// Returns the error of a file whose numbers contradict each other.
pub(crate) fn damaged(what: &str) -> Error {
    Error::invalid(what).advise("the file is damaged: build it again")
}
