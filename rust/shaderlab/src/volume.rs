//! Volumes on regular grids, read from NIfTI-1 and OpenVDB files.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use relievo_core::progress::Silent;
use relievo_core::{Budget, Context, Error, Result};
use relievo_openvdb::Kind;

/// A volume of numbers, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Voxels along each axis.
    pub size: [u32; 3],
    /// Edges of a voxel in the unit of the file; NIfTI usually has millimetres.
    pub spacing: [f32; 3],
    /// The numbers.
    pub values: Vec<f32>,
}

/// Largest edge of a volume in voxels.
const MAX_EDGE: u32 = 16_384;

impl Volume {
    /// Reads a volume: NIfTI-1 (`.nii`, `.nii.gz`) of one volume of numbers, or the first grid of floats of an OpenVDB file
    /// (`.vdb`), as far as its voxels are active.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is damaged or of another kind, has no active voxel or an edge of more than
    /// 16,384 voxels, or needs more than the context's memory limit.
    pub fn read(context: &Context, path: &Path) -> Result<Self> {
        let name = path.to_string_lossy().to_lowercase();
        let named = |error: Error| error.at(path.display().to_string());
        if name.ends_with(".vdb") {
            return Self::read_openvdb(context, path);
        }
        let bytes = relievo_core::file::load(path, context.memory_limit())?;
        let bytes = match bytes.starts_with(&[0x1f, 0x8b]) {
            true => unpacked(&bytes, context.memory_limit()).map_err(named)?,
            false => bytes,
        };
        Self::of_nifti(&bytes, context.memory_limit()).map_err(named)
    }

    /// Reads a NIfTI-1 file in memory.
    ///
    /// # Errors
    /// Fails if the bytes end too early, are no NIfTI-1 file of one volume, have numbers of a kind that is not read or
    /// an edge of more than 16,384 voxels, or if the volume needs more than `memory_limit` bytes.
    pub fn of_nifti(bytes: &[u8], memory_limit: u64) -> Result<Self> {
        let header = Header::of(bytes)?;
        let size = header.size()?;
        let count = size.iter().try_fold(1_usize, |count, edge| count.checked_mul(*edge as usize));
        let (width, decode) = decoder(header.short(70))?;
        let start = header.float(108);
        let end = count.and_then(|count| count.checked_mul(width)).zip((start >= 0.0).then_some(start as usize));
        let data = end.and_then(|(length, start)| bytes.get(start..start.checked_add(length)?));
        let data = data.ok_or_else(|| {
            Error::invalid("the file ends before its last voxel").advise("copy the file again: it is damaged")
        })?;
        let mut values = Budget::new(memory_limit).filled(data.len() / width, 0.0_f32)?;
        let (slope, intercept) = match header.float(112) {
            slope if slope == 0.0 || !slope.is_finite() => (1.0, 0.0),
            slope => (slope, header.float(116)),
        };
        for (value, bytes) in values.iter_mut().zip(data.chunks_exact(width)) {
            let mut word = [0; 8];
            word[..width].copy_from_slice(bytes);
            if header.is_big {
                word[..width].reverse();
            }
            let scaled = decode(word) * slope + intercept;
            *value = if scaled.is_finite() { scaled } else { 0.0 };
        }
        let spacing = [80, 84, 88].map(|at| header.float(at).abs());
        let spacing = spacing.map(|edge| if edge > 0.0 && edge.is_finite() { edge } else { 1.0 });
        Ok(Self { size, spacing, values })
    }

    fn read_openvdb(context: &Context, path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let grid = relievo_openvdb::read(context, path, None, None, &mut Silent)?;
        let info = grid.info()?;
        if info.kind != Some(Kind::Float) {
            let error = Error::unsupported(format!("the grid `{}` has no floats", info.name));
            return Err(named(error.advise("convert it with `relievo grid convert`")));
        }
        let [low, high] = info.bounds.ok_or_else(|| named(Error::invalid("no voxel of the grid is active")))?;
        let size = [0, 1, 2].map(|axis| (i64::from(high[axis]) - i64::from(low[axis]) + 1).clamp(0, 1 << 31) as u32);
        check_edges(size).map_err(named)?;
        let block = grid.block(context, low, size).map_err(named)?;
        let mut values = Budget::new(context.memory_limit()).filled(block.bytes.len() / 4, 0.0_f32)?;
        let [x_count, y_count, z_count] = size.map(|edge| edge as usize);
        for (index, bytes) in block.bytes.chunks_exact(4).enumerate() {
            // Blocks have x slowest.
            let (x, y, z) = (index / (y_count * z_count), index / z_count % y_count, index % z_count);
            let value = f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            values[(z * y_count + y) * x_count + x] = if value.is_finite() { value } else { 0.0 };
        }
        Ok(Self { size, spacing: info.transform.voxel_size.map(|edge| edge as f32), values })
    }

    /// Returns the smallest and the largest number.
    pub fn range(&self) -> [f32; 2] {
        let low = self.values.iter().copied().fold(f32::INFINITY, f32::min);
        [low, self.values.iter().copied().fold(f32::NEG_INFINITY, f32::max)]
    }

    /// Returns the numbers mapped to 0 to 1, as shaders get them.
    pub fn normalized(&self) -> Vec<f32> {
        let [low, high] = self.range();
        let span = if high > low { high - low } else { 1.0 };
        self.values.iter().map(|value| (value - low) / span).collect()
    }

    /// Returns the edges of the volume relative to its longest.
    pub fn proportions(&self) -> [f32; 3] {
        let edges = [0, 1, 2].map(|axis| self.size[axis] as f32 * self.spacing[axis]);
        let longest = edges.into_iter().fold(0.0, f32::max);
        edges.map(|edge| if longest > 0.0 { edge / longest } else { 1.0 })
    }
}

/// Unpacks gzip, up to `limit` bytes.
fn unpacked(bytes: &[u8], limit: u64) -> Result<Vec<u8>> {
    let mut out = Vec::new();
    let read = MultiGzDecoder::new(bytes).take(limit.saturating_add(1)).read_to_end(&mut out);
    read.map_err(|error| Error::invalid(format!("the file cannot be unpacked: {error}")).advise("copy it again"))?;
    if out.len() as u64 > limit {
        return Err(Error::memory(format!("the volume has more than the memory limit of {limit} bytes"))
            .advise("raise the memory limit"));
    }
    Ok(out)
}

fn check_edges(size: [u32; 3]) -> Result<()> {
    if size.iter().all(|edge| (1..=MAX_EDGE).contains(edge)) {
        return Ok(());
    }
    let [x, y, z] = size;
    Err(Error::unsupported(format!("the volume has {x} × {y} × {z} voxels"))
        .advise(format!("use 1 to {MAX_EDGE} along each axis")))
}

/// Decodes a number from little-endian bytes.
type Decode = fn([u8; 8]) -> f32;

/// Returns the bytes of a number of a NIfTI type, and what decodes it.
fn decoder(code: i16) -> Result<(usize, Decode)> {
    Ok(match code {
        2 => (1, |it| f32::from(it[0])),
        256 => (1, |it| f32::from(it[0] as i8)),
        4 => (2, |it| f32::from(i16::from_le_bytes([it[0], it[1]]))),
        512 => (2, |it| f32::from(u16::from_le_bytes([it[0], it[1]]))),
        8 => (4, |it| i32::from_le_bytes([it[0], it[1], it[2], it[3]]) as f32),
        768 => (4, |it| u32::from_le_bytes([it[0], it[1], it[2], it[3]]) as f32),
        16 => (4, |it| f32::from_le_bytes([it[0], it[1], it[2], it[3]])),
        64 => (8, |it| f64::from_le_bytes(it) as f32),
        _ => {
            return Err(Error::unsupported(format!("the voxels have the NIfTI type {code}"))
                .advise("convert them to integers or floats"));
        }
    })
}

/// The header of a NIfTI-1 file.
struct Header<'a> {
    bytes: &'a [u8; 348],
    is_big: bool,
}

impl<'a> Header<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self> {
        let refused = || Error::unsupported("the file is no NIfTI-1 volume").advise("use .nii, .nii.gz or .vdb");
        let bytes: &[u8; 348] = bytes.first_chunk().ok_or_else(refused)?;
        let is_big = match [bytes[0], bytes[1], bytes[2], bytes[3]] {
            [0x5c, 1, 0, 0] => false,
            [0, 0, 1, 0x5c] => true,
            _ => return Err(refused()),
        };
        match &bytes[344..] {
            b"n+1\0" => Ok(Self { bytes, is_big }),
            b"ni1\0" => Err(Error::unsupported("the voxels are in another file (.img)").advise("convert it to .nii")),
            _ => Err(refused()),
        }
    }

    fn short(&self, at: usize) -> i16 {
        let pair = [self.bytes[at], self.bytes[at + 1]];
        if self.is_big { i16::from_be_bytes(pair) } else { i16::from_le_bytes(pair) }
    }

    fn float(&self, at: usize) -> f32 {
        let word = [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2], self.bytes[at + 3]];
        if self.is_big { f32::from_be_bytes(word) } else { f32::from_le_bytes(word) }
    }

    fn size(&self) -> Result<[u32; 3]> {
        let count = self.short(40);
        let edge = |axis: i16| if axis <= count { self.short(40 + 2 * axis as usize) } else { 1 };
        if !(1..=7).contains(&count) || (4..=count).any(|axis| edge(axis) > 1) {
            return Err(Error::unsupported("the file has more than one volume, or none")
                .advise("extract one volume of the series"));
        }
        let size = [1, 2, 3].map(|axis| u32::try_from(edge(axis)).unwrap_or(0));
        check_edges(size)?;
        Ok(size)
    }
}
