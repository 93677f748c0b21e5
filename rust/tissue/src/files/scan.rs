//! Labelled scans: volumes in NIfTI-1 (`.nii`, `.nii.gz`), whose values say what each voxel belongs to.
//!
//! Sizes come from `pixdim` and `xyzt_units`; orientations are not applied, so that x, y and z are the axes of the file.

use std::io::Read;
use std::path::Path;

use flate2::read::GzDecoder;
use relievo_core::{Context, Error, Result, file};

/// A volume of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Voxels along the axes.
    pub counts: [usize; 3],
    /// Size of a voxel in metres.
    pub cell: [f32; 3],
    /// The lowest corner in metres.
    pub low: [f32; 3],
    /// Values, x fastest.
    pub values: Vec<f32>,
}

/// Bytes of the header.
const HEADER: usize = 348;
/// Voxels along an axis at most: the format has 16 bits.
const MAX: i16 = i16::MAX;

impl Scan {
    /// Reads a file, compressed or not.
    ///
    /// # Errors
    /// Fails if the file cannot be read, and as [`Self::decode`]; the memory limit of the context holds for both.
    pub fn read(context: &Context, path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, context.memory_limit())?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            return Self::decode(GzDecoder::new(bytes.as_slice()), context.memory_limit()).map_err(named);
        }
        Self::decode(bytes.as_slice(), context.memory_limit()).map_err(named)
    }

    /// Reads a scan from uncompressed bytes.
    ///
    /// # Errors
    /// Fails if the bytes are not NIfTI-1 in one file, its numbers are of a kind that is not read, a size is out of
    /// range, it is shorter than it states, or its voxels do not fit into `limit` bytes.
    pub fn decode(mut input: impl Read, limit: u64) -> Result<Self> {
        let mut header = [0; HEADER];
        input.read_exact(&mut header).map_err(|_| cut())?;
        let swap = match i32::from_le_bytes(four(&header, 0)) {
            348 => false,
            size if size.swap_bytes() == 348 => true,
            _ => return Err(Error::invalid("it is not a file of NIfTI-1").advise("convert it to .nii or .nii.gz")),
        };
        let short = |at: usize| {
            let bytes = [header[at], header[at + 1]];
            if swap { i16::from_be_bytes(bytes) } else { i16::from_le_bytes(bytes) }
        };
        let float = |at: usize| {
            let bytes = four(&header, at);
            if swap { f32::from_be_bytes(bytes) } else { f32::from_le_bytes(bytes) }
        };
        if &header[344..347] != b"n+1" {
            return Err(
                Error::unsupported("its header and numbers are in two files").advise("convert it to .nii or .nii.gz")
            );
        }
        let dimensions = [1, 2, 3].map(|axis| short(40 + 2 * axis));
        if short(40) < 3 || dimensions.iter().any(|count| !(1..=MAX).contains(count)) {
            return Err(Error::invalid(format!("{dimensions:?} voxels of {} dimensions make no volume", short(40))));
        }
        let counts = dimensions.map(|count| count as usize);
        let unit = match header[123] & 7 {
            1 => 1.0,
            3 => 1e-6,
            // Most programs leave out that it is millimetres.
            _ => 1e-3,
        };
        let cell = [1, 2, 3].map(|axis| unit * float(76 + 4 * axis).abs());
        if !cell.iter().all(|size| *size > 0.0 && size.is_finite()) {
            return Err(Error::invalid(format!("voxels of {cell:?} m cannot be")));
        }
        let kind = Kind::of(short(70))?;
        let count: usize = counts.iter().product();
        let bytes = (count * kind.width()) as u64;
        if bytes.saturating_mul(5) > limit {
            return Err(
                Error::memory(format!("{count} voxels do not fit the memory limit")).advise("raise the memory limit")
            );
        }
        let offset = float(108);
        if !(offset >= HEADER as f32 && offset < 1e9) {
            return Err(Error::invalid(format!("its numbers begin at byte {offset}")));
        }
        let gap = offset as u64 - HEADER as u64;
        let skipped = std::io::copy(&mut input.by_ref().take(gap), &mut std::io::sink());
        let mut data = Vec::new();
        input.take(bytes).read_to_end(&mut data).map_err(|_| cut())?;
        if skipped.ok() != Some(gap) || data.len() as u64 != bytes {
            return Err(cut());
        }
        let (slope, intercept) = (float(112), float(116));
        let (slope, intercept) = if slope == 0.0 || !slope.is_finite() { (1.0, 0.0) } else { (slope, intercept) };
        let values =
            data.chunks_exact(kind.width()).map(|bytes| slope * kind.number(bytes, swap) + intercept).collect();
        Ok(Self { counts, cell, low: [0.0; 3], values })
    }
}

fn four(bytes: &[u8], at: usize) -> [u8; 4] {
    [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]
}

fn cut() -> Error {
    Error::invalid("it is shorter than it states, or damaged").advise("take a copy")
}

/// Kinds of numbers by their codes in NIfTI-1.
#[derive(Clone, Copy)]
enum Kind {
    U8,
    I16,
    I32,
    F32,
    I8,
    U16,
}

impl Kind {
    fn of(code: i16) -> Result<Self> {
        match code {
            2 => Ok(Self::U8),
            4 => Ok(Self::I16),
            8 => Ok(Self::I32),
            16 => Ok(Self::F32),
            256 => Ok(Self::I8),
            512 => Ok(Self::U16),
            _ => Err(Error::unsupported(format!("numbers of kind {code} are not read"))
                .advise("convert it to integers of 8, 16 or 32 bits, or floats of 32 bits")),
        }
    }

    fn width(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::F32 => 4,
        }
    }

    /// Returns the number in as many bytes as it is wide.
    fn number(self, bytes: &[u8], swap: bool) -> f32 {
        let mut native = [0; 4];
        let width = bytes.len().min(4);
        native[..width].copy_from_slice(&bytes[..width]);
        if swap {
            native[..width].reverse();
        }
        let [a, b, ..] = native;
        match self {
            Self::U8 => f32::from(a),
            Self::I8 => f32::from(a as i8),
            Self::I16 => f32::from(i16::from_le_bytes([a, b])),
            Self::U16 => f32::from(u16::from_le_bytes([a, b])),
            Self::I32 => i32::from_le_bytes(native) as f32,
            Self::F32 => f32::from_le_bytes(native),
        }
    }
}
