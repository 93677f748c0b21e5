//! Chunks of frames: channels of some of the particles, exact or as 16-bit numbers, plain or compressed.
//!
//! The numbers of a column lie in rows, particle after particle, or in planes: first the lowest bytes of all numbers, then
//! the next ones. Differences are planes of `number - number of the particle before` of the bits, modulo the word, in
//! zigzag code. Particles of a frame follow a space-filling curve, so neighbours in the list are near each other.

use half::f16;
use relievo_core::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::protocol::MAX_CHUNK;

/// What a number of a column is. All are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// A float of 32 bits.
    F32,
    /// An unsigned integer of 32 bits.
    U32,
    /// A float of 16 bits.
    F16,
    /// A fraction `n / 65535` of the way from `low` to `high`, in 16 bits.
    Unorm16,
}

/// How the numbers of a column lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Particle after particle.
    Rows,
    /// Byte after byte of all numbers.
    Planes,
    /// As planes, of differences from the particle before.
    Differences,
}

/// How the bytes of a column are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// Not at all.
    #[default]
    None,
    /// As a frame of Zstandard.
    Zstd,
    /// As a block of LZ4.
    Lz4,
}

/// A channel of the particles of a chunk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// The name of the channel.
    pub name: String,
    /// Numbers per particle, 1 to 4.
    pub width: u32,
    /// What a number is.
    pub form: Form,
    /// How the numbers lie.
    pub layout: Layout,
    /// How the bytes are compressed.
    pub packing: Packing,
    /// For [`Form::Unorm16`], the least of each of the `width` numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub low: Vec<f32>,
    /// For [`Form::Unorm16`], the greatest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub high: Vec<f32>,
    /// The bytes.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// Some of the particles of a frame: the result of `frame.fetch`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chunk {
    /// The first particle.
    pub first: u64,
    /// Particles in this chunk.
    pub count: u32,
    /// Particles of the frame that were asked for in all.
    pub total: u64,
    /// The key of the frame in the server's cache. Chunks with other keys are of other contents.
    #[serde(default)]
    pub key: String,
    /// Their channels.
    pub columns: Vec<Column>,
}

/// The numbers of a channel, particle after particle.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floats.
    Floats(Vec<f32>),
    /// Integers.
    Integers(Vec<u32>),
}

/// The level of Zstandard: floats gain little by more.
const LEVEL: i32 = 1;

impl Column {
    /// Encodes floats, `width` a particle. With `half`, positions become fractions of their box, and others halves.
    ///
    /// # Errors
    /// Fails with `Internal` if zstd fails; the other packings do not.
    pub fn of_floats(
        name: &str,
        width: u32,
        values: &[f32],
        half: bool,
        layout: Layout,
        packing: Packing,
    ) -> Result<Self> {
        let size = width as usize;
        let mut column = Self::empty(name, width, Form::F32, layout, packing);
        if !half {
            column.data = column.pack(values.len(), |at| values[at].to_bits())?;
            return Ok(column);
        }
        if name != "position" {
            column.form = Form::F16;
            column.data = column.pack(values.len(), |at| u32::from(f16::from_f32(values[at]).to_bits()))?;
            return Ok(column);
        }
        let end = |first: f32, end: fn(f32, f32) -> f32| {
            (0..size).map(|axis| values.iter().skip(axis).step_by(size).copied().fold(first, end)).collect()
        };
        column.form = Form::Unorm16;
        let (low, high): (Vec<f32>, Vec<f32>) = match values.is_empty() {
            true => (vec![0.0; size], vec![0.0; size]),
            false => (end(f32::INFINITY, f32::min), end(f32::NEG_INFINITY, f32::max)),
        };
        let fraction = |at: usize| {
            let (low, high) = (f64::from(low[at % size]), f64::from(high[at % size]));
            let share = if high > low { (f64::from(values[at]) - low) / (high - low) } else { 0.0 };
            (share * 65535.0).round() as u32
        };
        column.data = column.pack(values.len(), fraction)?;
        (column.low, column.high) = (low, high);
        Ok(column)
    }

    /// Encodes integers, one a particle.
    ///
    /// # Errors
    /// Fails with `Internal` if zstd fails; the other packings do not.
    pub fn of_integers(name: &str, values: &[u32], layout: Layout, packing: Packing) -> Result<Self> {
        let mut column = Self::empty(name, 1, Form::U32, layout, packing);
        column.data = column.pack(values.len(), |at| values[at])?;
        Ok(column)
    }

    fn empty(name: &str, width: u32, form: Form, layout: Layout, packing: Packing) -> Self {
        Self { name: name.into(), width, form, layout, packing, low: Vec::new(), high: Vec::new(), data: Vec::new() }
    }

    /// Bytes of a number.
    fn size(&self) -> usize {
        match self.form {
            Form::F32 | Form::U32 => 4,
            Form::F16 | Form::Unorm16 => 2,
        }
    }

    fn pack(&self, count: usize, word: impl Fn(usize) -> u32) -> Result<Vec<u8>> {
        let (size, width) = (self.size(), self.width as usize);
        let mut bytes = vec![0; count * size];
        let mut planes = |word: &dyn Fn(usize) -> u32| {
            for (plane, bytes) in bytes.chunks_exact_mut(count.max(1)).enumerate() {
                bytes.iter_mut().enumerate().for_each(|(at, byte)| *byte = (word(at) >> (8 * plane)) as u8);
            }
        };
        match (self.layout, size) {
            (Layout::Rows, 4) => {
                let rows = bytes.as_chunks_mut::<4>().0.iter_mut().enumerate();
                rows.for_each(|(at, bytes)| *bytes = word(at).to_le_bytes());
            }
            (Layout::Rows, _) => {
                let rows = bytes.as_chunks_mut::<2>().0.iter_mut().enumerate();
                rows.for_each(|(at, bytes)| *bytes = (word(at) as u16).to_le_bytes());
            }
            (Layout::Planes, _) => planes(&word),
            (Layout::Differences, _) => {
                let before = |at: usize| at.checked_sub(width).map_or(0, &word);
                let words: Vec<u32> = (0..count).map(|at| zigzag(word(at), before(at), size)).collect();
                planes(&|at| words[at]);
            }
        }
        match self.packing {
            Packing::None => Ok(bytes),
            Packing::Lz4 => Ok(lz4_flex::block::compress(&bytes)),
            Packing::Zstd => zstd::bulk::compress(&bytes, LEVEL).map_err(|error| Error::internal(error.to_string())),
        }
    }

    /// Decodes the numbers of `count` particles.
    ///
    /// # Errors
    /// Fails with `Invalid` if the column is not as long as that, whatever it unpacks to: no more is unpacked. Fails so
    /// too if it cannot be unpacked, a particle has not 1 to 4 numbers, or fractions lack their box.
    pub fn values(&self, count: u32) -> Result<Values> {
        let refused = |what: &str| {
            Err(Error::invalid(format!("the channel {:?} of a chunk {what}", self.name))
                .advise("fetch the frame again"))
        };
        let (size, width) = (self.size(), self.width as usize);
        if count > MAX_CHUNK || !(1..=4).contains(&self.width) {
            return refused("has too many particles or numbers a particle");
        }
        let numbers = count as usize * width;
        let length = numbers * size;
        let unpacked;
        let bytes = match self.packing {
            Packing::None => self.data.as_slice(),
            Packing::Zstd => {
                let Ok(bytes) = zstd::bulk::decompress(&self.data, length) else {
                    return refused("cannot be unpacked");
                };
                unpacked = bytes;
                &unpacked
            }
            Packing::Lz4 => {
                let mut bytes = vec![0; length];
                match lz4_flex::block::decompress_into(&self.data, &mut bytes) {
                    Ok(count) => bytes.truncate(count),
                    Err(_) => return refused("cannot be unpacked"),
                }
                unpacked = bytes;
                &unpacked
            }
        };
        if bytes.len() != length {
            return refused("is not as long as its particles need");
        }
        let plane =
            |at: usize| (0..size).fold(0, |word, plane| word | u32::from(bytes[plane * numbers + at]) << (8 * plane));
        let words: Vec<u32> = match (self.layout, size) {
            (Layout::Rows, 4) => bytes.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect(),
            (Layout::Rows, _) => {
                bytes.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes).into()).collect()
            }
            (Layout::Planes, _) => (0..numbers).map(plane).collect(),
            (Layout::Differences, _) => {
                let mut words: Vec<u32> = Vec::with_capacity(numbers);
                for at in 0..numbers {
                    let before = at.checked_sub(width).map_or(0, |at| words[at]);
                    words.push(unzigzag(plane(at), before, size));
                }
                words
            }
        };
        let ends = |axis: usize| self.low.get(axis).zip(self.high.get(axis));
        Ok(match self.form {
            Form::U32 => Values::Integers(words),
            Form::F32 => Values::Floats(words.into_iter().map(f32::from_bits).collect()),
            Form::F16 => Values::Floats(words.into_iter().map(|word| f16::from_bits(word as u16).to_f32()).collect()),
            Form::Unorm16 => {
                if (0..width).any(|axis| ends(axis).is_none()) {
                    return refused("does not say its box");
                }
                let number = |(at, word): (usize, u32)| {
                    let (low, high) = (f64::from(self.low[at % width]), f64::from(self.high[at % width]));
                    (low + (high - low) * f64::from(word) / 65535.0) as f32
                };
                Values::Floats(words.into_iter().enumerate().map(number).collect())
            }
        })
    }
}

/// The difference of two words of `size` bytes, with its sign in the lowest bit.
fn zigzag(word: u32, before: u32, size: usize) -> u32 {
    if size == 4 {
        let difference = word.wrapping_sub(before) as i32;
        return ((difference << 1) ^ (difference >> 31)) as u32;
    }
    let difference = (word as u16).wrapping_sub(before as u16) as i16;
    u32::from(((difference << 1) ^ (difference >> 15)) as u16)
}

fn unzigzag(code: u32, before: u32, size: usize) -> u32 {
    let difference = (code >> 1) ^ (code & 1).wrapping_neg();
    let word = before.wrapping_add(difference);
    if size == 4 { word } else { word & 0xffff }
}
