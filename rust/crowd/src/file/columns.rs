//! Columns of numbers, split into planes of bytes.

use relievo_core::Result;

use super::damaged;

/// Bytes of a name at most.
const MAX_NAME: usize = 1 << 12;

/// Bytes of columns that are written.
#[derive(Default)]
pub(super) struct Columns(pub Vec<u8>);

impl Columns {
    pub fn planes(&mut self, values: &[u32], bytes: usize) {
        for plane in 0..bytes {
            self.0.extend(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
    }

    pub fn numbers(&mut self, values: &[u32]) {
        self.planes(values, 4);
    }

    pub fn number(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    pub fn floats(&mut self, values: impl Iterator<Item = f32>) {
        self.numbers(&values.map(f32::to_bits).collect::<Vec<_>>());
    }

    /// Writes a name, cut to what readers accept.
    pub fn text(&mut self, text: &str) {
        let mut end = text.len().min(MAX_NAME);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.number(end as u32);
        self.0.extend(&text.as_bytes()[..end]);
    }
}

/// Bytes of columns that are read.
pub(super) struct Rows<'a>(pub &'a [u8]);

impl<'a> Rows<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or_else(|| damaged("a chunk is too short"))?;
        self.0 = rest;
        Ok(bytes)
    }

    pub fn planes(&mut self, count: usize, width: usize) -> Result<Vec<u32>> {
        let length = count.checked_mul(width).ok_or_else(|| damaged("a count is too large"))?;
        let bytes = self.take(length)?;
        let value = |index: usize| (0..width).map(|plane| u32::from(bytes[plane * count + index]) << (8 * plane)).sum();
        Ok((0..count).map(value).collect())
    }

    pub fn numbers(&mut self, count: usize) -> Result<Vec<u32>> {
        self.planes(count, 4)
    }

    pub fn floats(&mut self, count: usize) -> Result<Vec<f32>> {
        let values: Vec<f32> = self.numbers(count)?.into_iter().map(f32::from_bits).collect();
        if values.iter().all(|value| value.is_finite()) { Ok(values) } else { Err(damaged("a number is not finite")) }
    }

    pub fn number(&mut self) -> Result<u32> {
        Ok(self.numbers(1)?[0])
    }

    pub fn long(&mut self) -> Result<u64> {
        let bytes = self.take(8)?;
        Ok(bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
    }

    pub fn text(&mut self) -> Result<String> {
        let length = self.number()? as usize;
        if length > MAX_NAME {
            return Err(damaged("a name is too long"));
        }
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| damaged("a name is no text"))
    }

    pub fn end(&self) -> Result<()> {
        if self.0.is_empty() { Ok(()) } else { Err(damaged("a chunk is too long")) }
    }
}

/// Returns a difference such that small ones of either sign are small numbers.
pub(super) fn folded(difference: u32) -> u32 {
    (difference << 1) ^ if difference >> 31 == 1 { u32::MAX } else { 0 }
}

/// Returns the difference that [`folded`] turned into a number.
pub(super) fn unfolded(number: u32) -> u32 {
    (number >> 1) ^ if number & 1 == 1 { u32::MAX } else { 0 }
}

/// Returns how many bytes an index below `count` has.
pub(super) fn index_bytes(count: usize) -> usize {
    match count {
        0..=0x100 => 1,
        0x101..=0x1_0000 => 2,
        _ => 4,
    }
}
