//! Reads what all grids have: the list of a file, metadata, the transform, and values of nodes.

use std::io::Read as _;

use relievo_core::{Budget, Error, Result};

use super::{ALL, SIGNATURE, ZIP, blosc};
use crate::bytes::Bytes;

/// Packed by what, beside zlib: values of active voxels alone, or Blosc.
const ACTIVE: u32 = 2;
const BLOSC: u32 = 4;
/// The oldest version that is read: that of OpenVDB 2.
const OLDEST: u32 = 222;
/// What follows the type of a grid of floats that have 16 bits in the file.
const HALVES: &str = "_HalfFloat";
/// Grids of a file at most, and entries of metadata.
const MAX: u32 = 1 << 16;

/// A grid of a file.
pub(super) struct Entry<'a> {
    pub name: String,
    /// The type of its tree.
    pub kind: String,
    pub is_half: bool,
    /// The file from where the grid begins.
    pub bytes: Bytes<'a>,
}

/// The grids of a file, without grids that share the tree of another.
pub(super) fn entries(file: &[u8]) -> Result<Vec<Entry<'_>>> {
    let mut bytes = Bytes(file);
    if u64::from_le_bytes(bytes.array()?) != SIGNATURE {
        return Err(Error::invalid("the file does not begin as OpenVDB's do").advise("check that it is a .vdb file"));
    }
    let [version, _, _] = [u32(&mut bytes)?, u32(&mut bytes)?, u32(&mut bytes)?];
    if version < OLDEST {
        return Err(Error::unsupported(format!(
            "it is of OpenVDB's version {version}, and those from {OLDEST} are read"
        ))
        .advise("save it by a newer OpenVDB"));
    }
    let [has_places] = bytes.array()?;
    if has_places == 0 {
        return Err(Error::unsupported("it does not say where its grids are").advise("save it as a file, not a stream"));
    }
    bytes.take(36)?;
    metadata(&mut bytes)?;
    let count = u32(&mut bytes)?;
    if count > MAX {
        return Err(damaged("there are too many grids"));
    }
    let mut list = Vec::new();
    for _ in 0..count {
        let (name, kind, parent) = (text(&mut bytes)?, text(&mut bytes)?, text(&mut bytes)?);
        let place = u64::from_le_bytes(bytes.array()?);
        let _ = bytes.array::<8>()?;
        let end = u64::from_le_bytes(bytes.array()?);
        let range = usize::try_from(place).ok().zip(usize::try_from(end).ok());
        let grid = range.and_then(|(place, end)| file.get(place..end)).ok_or_else(|| damaged("a grid is nowhere"))?;
        let is_half = kind.ends_with(HALVES);
        if parent.is_empty() {
            let kind = kind.trim_end_matches(HALVES).to_owned();
            // The names of grids that are called the same have numbers behind a separator.
            let name = name.split('\u{1e}').next().unwrap_or_default().to_owned();
            list.push(Entry { name, kind, is_half, bytes: Bytes(grid) });
        }
        bytes = Bytes(file.get(end as usize..).ok_or_else(|| damaged("a grid is nowhere"))?);
    }
    Ok(list)
}

/// What a grid has before its tree.
pub(super) struct Head {
    pub metadata: Vec<(String, Vec<u8>)>,
    /// From voxels to metres: what the axes go to, and the origin.
    pub transform: [[f64; 3]; 4],
    packing: u32,
}

impl Head {
    pub fn read(bytes: &mut Bytes) -> Result<Self> {
        let packing = u32(bytes)?;
        Ok(Self { packing, metadata: metadata(bytes)?, transform: transform(bytes)? })
    }

    pub fn metadata(&self, name: &str) -> Option<&[u8]> {
        self.metadata.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_slice())
    }

    /// Whether values of attributes and indices may be packed by Blosc.
    pub fn is_blosc(&self) -> bool {
        self.packing & BLOSC != 0
    }

    /// The values of a node of `mask.len() * 8` voxels, of which those in the mask are active.
    pub fn values(
        &self,
        bytes: &mut Bytes,
        budget: &mut Budget,
        mask: &[u8],
        background: f32,
        is_half: bool,
    ) -> Result<Vec<f32>> {
        let [form] = bytes.array()?;
        let mut number = || bytes.array().map(f32::from_le_bytes);
        // Values that are not active, by the bits of a selection.
        let others = match form {
            0 => [background, background],
            1 | 3 => [-background, background],
            2 | 4 => [number()?, background],
            5 => [number()?, number()?],
            ALL => [background; 2],
            _ => return Err(damaged("values have a form that is not known")),
        };
        let chosen = if matches!(form, 3..=5) { bytes.take(mask.len() as u64)? } else { &[] };
        let all = 8 * mask.len();
        let is_sparse = self.packing & ACTIVE != 0 && form != ALL;
        let count = if is_sparse { mask.iter().map(|byte| byte.count_ones() as usize).sum() } else { all };
        let size = if is_half { 2 } else { 4 };
        let plain = if is_half && count == 0 { Vec::new() } else { self.unpack(bytes, budget, count * size)? };
        let value = |at: usize| match plain[at * size..][..size] {
            [a, b] => half::f16::from_le_bytes([a, b]).to_f32(),
            ref bytes => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        };
        let mut out = Vec::new();
        budget.reserve(&mut out, all)?;
        let bit = |bits: &[u8], at: usize| bits.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1);
        let mut next = 0;
        for at in 0..all {
            let is_there = !is_sparse || bit(mask, at);
            out.push(if is_there { value(next) } else { others[usize::from(bit(chosen, at))] });
            next += usize::from(is_there);
        }
        Ok(out)
    }

    /// Bytes that are packed as the grid says.
    fn unpack(&self, bytes: &mut Bytes, budget: &mut Budget, length: usize) -> Result<Vec<u8>> {
        if self.packing & (BLOSC | ZIP) == 0 {
            return Ok(bytes.take(length as u64)?.to_vec());
        }
        let packed = i64::from_le_bytes(bytes.array()?);
        let plain = packed.checked_neg().and_then(|length| u64::try_from(length).ok());
        if let Some(count) = plain {
            return match count == length as u64 {
                true => Ok(bytes.take(count)?.to_vec()),
                false => Err(damaged("values are not as many as they should be")),
            };
        }
        let packed = bytes.take(packed as u64)?;
        if self.is_blosc() {
            return blosc::unpack(packed, length, budget);
        }
        let mut out = budget.filled(length, 0)?;
        let read = flate2::read::ZlibDecoder::new(packed).read_exact(&mut out);
        read.map_err(|_| damaged("values cannot be unpacked"))?;
        Ok(out)
    }
}

/// Names and values; types do not matter.
pub(super) fn metadata(bytes: &mut Bytes) -> Result<Vec<(String, Vec<u8>)>> {
    let count = u32(bytes)?;
    if count > MAX {
        return Err(damaged("there is too much metadata"));
    }
    let entry = |_| {
        let (name, _) = (text(bytes)?, text(bytes)?);
        let length = u32(bytes)?;
        Ok((name, bytes.take(length.into())?.to_vec()))
    };
    (0..count).map(entry).collect()
}

fn transform(bytes: &mut Bytes) -> Result<[[f64; 3]; 4]> {
    let kind = text(bytes)?;
    let mut vector = || -> Result<[f64; 3]> {
        let mut number = || bytes.array().map(f64::from_le_bytes);
        Ok([number()?, number()?, number()?])
    };
    let scaled = |[x, y, z]: [f64; 3], origin| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], origin];
    let found = match kind.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector()?;
            (0..4).try_for_each(|_| vector().map(drop))?;
            scaled(scale, [0.0; 3])
        }
        "TranslationMap" => scaled([1.0; 3], vector()?),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (origin, scale) = (vector()?, vector()?);
            (0..4).try_for_each(|_| vector().map(drop))?;
            scaled(scale, origin)
        }
        // Rows of a matrix for row vectors, each with the last column of 0, 0, 0 and 1 behind it.
        "AffineMap" | "UnitaryMap" => {
            let mut all = Vec::new();
            for _ in 0..5 {
                all.extend(vector()?);
            }
            bytes.take(8)?;
            [0, 1, 2, 3].map(|row| [0, 1, 2].map(|column| all[4 * row + column]))
        }
        _ => {
            return Err(Error::unsupported(format!("its transform is a {kind:?}"))
                .advise("resample the grid to voxels that are boxes"));
        }
    };
    if found.iter().flatten().all(|value| value.is_finite()) {
        Ok(found)
    } else {
        Err(damaged("its transform is not finite"))
    }
}

pub(super) fn u32(bytes: &mut Bytes) -> Result<u32> {
    bytes.array().map(u32::from_le_bytes)
}

pub(super) fn text(bytes: &mut Bytes) -> Result<String> {
    let length = u32(bytes)?;
    Ok(String::from_utf8_lossy(bytes.take(length.into())?).into_owned())
}

pub(super) fn damaged(what: &str) -> Error {
    Error::invalid(format!("the file is damaged: {what}")).advise("export it again")
}
