//! Blocks of texels as they are stored: channels apart, perhaps as differences, compressed by zlib, perhaps in tiles.

use flate2::{Compress, Compression, Decompress, FlushCompress, FlushDecompress, Status};
use relievo_core::{Budget, Error, Result};

use crate::fields::{Fields, damaged, section};
use crate::format::{DataType, Format, Resolution};

/// How a block is stored, in the upper two bits of its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Constant,
    Zipped,
    ZippedDifferences,
    Tiled,
}

/// Size and encoding of a block, as files hold them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct BlockHeader(pub u32);

impl BlockHeader {
    /// Bytes of the largest block.
    pub const LARGEST: usize = (1 << 30) - 1;

    pub fn new(encoding: Encoding, size: usize) -> Result<Self> {
        if size > Self::LARGEST {
            return Err(Error::unsupported(format!("its texels take {size} bytes when they are compressed"))
                .advise("use fewer texels: a face may take 1 GiB"));
        }
        let code = match encoding {
            Encoding::Constant => 0,
            Encoding::Zipped => 1,
            Encoding::ZippedDifferences => 2,
            Encoding::Tiled => 3u32,
        };
        Ok(Self(code << 30 | size as u32))
    }

    pub fn size(self) -> u64 {
        u64::from(self.0 & Self::LARGEST as u32)
    }

    pub fn encoding(self) -> Encoding {
        match self.0 >> 30 {
            0 => Encoding::Constant,
            1 => Encoding::Zipped,
            2 => Encoding::ZippedDifferences,
            _ => Encoding::Tiled,
        }
    }
}

/// Deflate makes at most 1032 bytes of one: a stored run of 258 bytes takes two bits.
const LARGEST_RATIO: u64 = 1032;

/// Decompresses `zipped`, which lies at `offset`, into exactly `size` bytes.
///
/// A size that so few bytes cannot give is refused before anything is allocated.
pub(crate) fn inflate(zipped: &[u8], offset: u64, size: u64, budget: &mut Budget) -> Result<Vec<u8>> {
    if size == 0 && zipped.is_empty() {
        return Ok(Vec::new());
    }
    let possible = (zipped.len() as u64).saturating_mul(LARGEST_RATIO);
    let length = usize::try_from(size).ok().filter(|_| size <= possible);
    let length = length
        .ok_or_else(|| damaged(format!("{} bytes are said to be {size} when decompressed", zipped.len()), offset))?;
    let mut out = budget.filled(length, 0)?;
    let mut stream = Decompress::new(true);
    let status = stream.decompress(zipped, &mut out, FlushDecompress::Finish);
    if stream.total_out() != size || !matches!(status, Ok(Status::StreamEnd)) {
        let what = format!("the compressed data is damaged, or is not of {size} bytes");
        return Err(damaged(what, offset + stream.total_in()));
    }
    Ok(out)
}

/// Compresses `bytes`.
pub(crate) fn deflate(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut stream = Compress::new(Compression::default(), true);
    let mut out = Vec::with_capacity(bytes.len() / 2 + 64);
    loop {
        let rest = bytes.get(stream.total_in() as usize..).unwrap_or_default();
        match stream.compress_vec(rest, &mut out, FlushCompress::Finish) {
            Ok(Status::StreamEnd) => return Ok(out),
            Ok(_) => out.reserve(out.capacity().max(64)),
            Err(error) => return Err(Error::internal(format!("compression failed: {error}"))),
        }
    }
}

/// A rectangle of texels in a larger one.
#[derive(Clone, Copy)]
struct Window {
    /// Its first byte.
    first: usize,
    /// Bytes from row to row of the larger one.
    stride: usize,
    resolution: Resolution,
}

impl Window {
    fn whole(resolution: Resolution, texel: usize) -> Self {
        Self { first: 0, stride: resolution.width() * texel, resolution }
    }

    /// Windows of `tile` side by side, row by row.
    fn tiles(resolution: Resolution, tile: Resolution, texel: usize) -> impl Iterator<Item = Self> {
        let stride = resolution.width() * texel;
        let rows = resolution.height() / tile.height();
        let columns = resolution.width() / tile.width();
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| Self {
                first: row * tile.height() * stride + column * tile.width() * texel,
                stride,
                resolution: tile,
            })
        })
    }

    fn rows<'a>(&self, texels: &'a [u8], texel: usize) -> impl Iterator<Item = &'a [u8]> {
        let width = self.resolution.width() * texel;
        texels[self.first..].chunks(self.stride).take(self.resolution.height()).map(move |row| &row[..width])
    }

    fn rows_mut<'a>(&self, texels: &'a mut [u8], texel: usize) -> impl Iterator<Item = &'a mut [u8]> {
        let width = self.resolution.width() * texel;
        texels[self.first..].chunks_mut(self.stride).take(self.resolution.height()).map(move |row| &mut row[..width])
    }
}

/// A block that is not in tiles, and the texels it is of.
struct Piece<'a> {
    bytes: &'a [u8],
    /// Where it lies in the file.
    start: u64,
    header: BlockHeader,
    window: Window,
}

impl Piece<'_> {
    /// Fails where the block cannot be as large as it should be when it is decoded.
    fn check_size(&self, texel: usize) -> Result<()> {
        let possible = match self.header.encoding() {
            Encoding::Constant => self.bytes.len() == texel,
            Encoding::Zipped | Encoding::ZippedDifferences => {
                let size = self.window.resolution.texels() * texel as u64;
                size <= (self.bytes.len() as u64).saturating_mul(LARGEST_RATIO)
            }
            Encoding::Tiled => return Err(damaged("there are tiles within a tile", self.start)),
        };
        let what = || format!("{} bytes cannot be its texels", self.bytes.len());
        if possible { Ok(()) } else { Err(damaged(what(), self.start)) }
    }

    /// Channels one behind the other, or `None` where the block is the one texel that all are.
    fn planes(&self, format: &Format, budget: &mut Budget) -> Result<Option<Vec<u8>>> {
        if self.header.encoding() == Encoding::Constant {
            return Ok(None);
        }
        let size = self.window.resolution.texels() * format.texel_size() as u64;
        let mut planes = inflate(self.bytes, self.start, size, budget)?;
        if self.header.encoding() == Encoding::ZippedDifferences {
            sum(&mut planes, format.data_type);
        }
        Ok(Some(planes))
    }
}

/// The block at `start` of `file`, or its tiles.
fn pieces<'a>(
    file: &'a [u8],
    start: u64,
    header: BlockHeader,
    format: &Format,
    resolution: Resolution,
    budget: &mut Budget,
) -> Result<Vec<Piece<'a>>> {
    let texel = format.texel_size();
    let bytes = section(file, start, header.size(), "the texels")?;
    let mut pieces = Vec::new();
    if header.encoding() == Encoding::Tiled {
        let mut fields = Fields::new(bytes, start);
        let tile = Resolution::new(fields.u8()?, fields.u8()?);
        if tile.u > resolution.u || tile.v > resolution.v {
            return Err(damaged(format!("tiles of {tile:?} do not fit into a face of {resolution:?}"), start));
        }
        let zipped = fields.u32()? as usize;
        let offset = fields.offset();
        let count = resolution.texels() / tile.texels();
        let headers = inflate(fields.take(zipped)?, offset, 4 * count, budget)?;
        budget.reserve(&mut pieces, headers.len() / 4)?;
        for (window, header) in Window::tiles(resolution, tile, texel).zip(headers.as_chunks().0) {
            let header = BlockHeader(u32::from_le_bytes(*header));
            let start = fields.offset();
            pieces.push(Piece { bytes: fields.take(header.size() as usize)?, start, header, window });
        }
    } else {
        pieces.push(Piece { bytes, start, header, window: Window::whole(resolution, texel) });
    }
    pieces.iter().try_for_each(|piece| piece.check_size(texel))?;
    Ok(pieces)
}

/// Decodes the block at `start` of `file` into texels, row v = 0 first, channels together.
pub(crate) fn decode(
    file: &[u8],
    start: u64,
    header: BlockHeader,
    format: &Format,
    resolution: Resolution,
    budget: &mut Budget,
) -> Result<Vec<u8>> {
    let texel = format.texel_size();
    let pieces = pieces(file, start, header, format, resolution, budget)?;
    let mut texels = spread(&[0], resolution.texels() * texel as u64, budget)?;
    for piece in pieces {
        // What a tile is decompressed to is let go before the next.
        let planes = piece.planes(format, &mut Budget::new(budget.left()))?;
        let Some(planes) = planes else {
            for row in piece.window.rows_mut(&mut texels, texel) {
                row.chunks_exact_mut(texel).for_each(|to| to.copy_from_slice(piece.bytes));
            }
            continue;
        };
        match format.data_type.size() {
            1 => interleave::<1>(&planes, &mut texels, piece.window, texel),
            2 => interleave::<2>(&planes, &mut texels, piece.window, texel),
            _ => interleave::<4>(&planes, &mut texels, piece.window, texel),
        }
    }
    Ok(texels)
}

/// Decompresses the block without laying out its texels: a time that the length of the file bounds, however large
/// constant tiles are.
pub(crate) fn check(
    file: &[u8],
    start: u64,
    header: BlockHeader,
    format: &Format,
    resolution: Resolution,
    budget: &mut Budget,
) -> Result<()> {
    for piece in pieces(file, start, header, format, resolution, budget)? {
        piece.planes(format, &mut Budget::new(budget.left()))?;
    }
    Ok(())
}

/// `size` bytes, `value` again and again.
pub(crate) fn spread(value: &[u8], size: u64, budget: &mut Budget) -> Result<Vec<u8>> {
    let length = usize::try_from(size).map_err(|_| Error::memory(format!("its texels take {size} bytes")))?;
    if let [byte] = value {
        return budget.filled(length, *byte);
    }
    let mut bytes = budget.filled(length, 0)?;
    bytes.chunks_exact_mut(value.len().max(1)).for_each(|to| to.copy_from_slice(value));
    Ok(bytes)
}

fn interleave<const N: usize>(planes: &[u8], texels: &mut [u8], window: Window, texel: usize) {
    let size = window.resolution.texels() as usize * N;
    for (channel, plane) in planes.chunks_exact(size).enumerate() {
        let rows = plane.chunks_exact(window.resolution.width() * N);
        for (row, from) in window.rows_mut(texels, texel).zip(rows) {
            for (to, from) in row.chunks_exact_mut(texel).zip(from.as_chunks::<N>().0) {
                to[channel * N..][..N].copy_from_slice(from);
            }
        }
    }
}

fn deinterleave<const N: usize>(texels: &[u8], window: Window, texel: usize) -> Vec<u8> {
    let mut planes = Vec::with_capacity(window.resolution.texels() as usize * texel);
    for channel in 0..texel / N {
        for row in window.rows(texels, texel) {
            planes.extend(row.chunks_exact(texel).flat_map(|from| &from[channel * N..][..N]));
        }
    }
    planes
}

/// Turns differences of whole numbers into the numbers. Floats have none.
fn sum(planes: &mut [u8], data_type: DataType) {
    match data_type {
        DataType::U8 => {
            let mut last = 0u8;
            for value in planes {
                last = last.wrapping_add(*value);
                *value = last;
            }
        }
        DataType::U16 => {
            let mut last = 0u16;
            for value in planes.as_chunks_mut().0 {
                last = last.wrapping_add(u16::from_le_bytes(*value));
                *value = last.to_le_bytes();
            }
        }
        DataType::F16 | DataType::F32 => {}
    }
}

/// Turns whole numbers into differences from the one before. Returns whether there are any.
fn difference(planes: &mut [u8], data_type: DataType) -> bool {
    match data_type {
        DataType::U8 => {
            let mut last = 0u8;
            for value in planes {
                let own = *value;
                *value = own.wrapping_sub(last);
                last = own;
            }
            true
        }
        DataType::U16 => {
            let mut last = 0u16;
            for value in planes.as_chunks_mut().0 {
                let own = u16::from_le_bytes(*value);
                *value = own.wrapping_sub(last).to_le_bytes();
                last = own;
            }
            true
        }
        DataType::F16 | DataType::F32 => false,
    }
}

/// Bytes of the texels of a tile, at most: so much is decompressed to get at one texel.
const LARGEST_TILE: u64 = 128 << 10;

/// The tiles a face is cut into: as square as it goes.
fn tile_of(resolution: Resolution, texel: usize) -> Resolution {
    let texels = (LARGEST_TILE / texel as u64).max(1).ilog2() as u8;
    if texels >= resolution.u + resolution.v {
        return resolution;
    }
    let u = texels.div_ceil(2).min(resolution.u);
    let v = (texels - u).min(resolution.v);
    Resolution::new((texels - v).min(resolution.u), v)
}

/// Encodes texels of a face.
pub(crate) fn encode(texels: &[u8], format: &Format, resolution: Resolution) -> Result<(BlockHeader, Vec<u8>)> {
    let texel = format.texel_size();
    let tile = tile_of(resolution, texel);
    if tile == resolution {
        return encode_window(texels, format, Window::whole(resolution, texel));
    }
    let (mut headers, mut blocks) = (Vec::new(), Vec::new());
    for window in Window::tiles(resolution, tile, texel) {
        let (header, block) = encode_window(texels, format, window)?;
        headers.extend(header.0.to_le_bytes());
        blocks.extend(block);
    }
    let headers = deflate(&headers)?;
    let mut out = vec![tile.u, tile.v];
    out.extend((headers.len() as u32).to_le_bytes());
    out.extend(headers);
    out.extend(blocks);
    Ok((BlockHeader::new(Encoding::Tiled, out.len())?, out))
}

fn encode_window(texels: &[u8], format: &Format, window: Window) -> Result<(BlockHeader, Vec<u8>)> {
    let texel = format.texel_size();
    if let Some(value) = constant(window.rows(texels, texel), texel) {
        return Ok((BlockHeader::new(Encoding::Constant, texel)?, value.to_vec()));
    }
    let mut planes = match format.data_type.size() {
        1 => deinterleave::<1>(texels, window, texel),
        2 => deinterleave::<2>(texels, window, texel),
        _ => deinterleave::<4>(texels, window, texel),
    };
    let encoding =
        if difference(&mut planes, format.data_type) { Encoding::ZippedDifferences } else { Encoding::Zipped };
    let block = deflate(&planes)?;
    Ok((BlockHeader::new(encoding, block.len())?, block))
}

/// The texel that all of `rows` are, bit by bit, if they are one.
pub(crate) fn constant<'a>(rows: impl Iterator<Item = &'a [u8]>, texel: usize) -> Option<&'a [u8]> {
    let mut rows = rows.peekable();
    let first = rows.peek()?.get(..texel)?;
    rows.all(|row| row.chunks_exact(texel).all(|value| value == first)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::MeshType;

    #[test]
    fn tiles_hold_at_most_their_bytes_and_are_square_where_they_can_be() {
        let new = Resolution::new;
        assert_eq!(tile_of(new(7, 7), 4), new(7, 7));
        assert_eq!(tile_of(new(10, 10), 4), new(8, 7));
        assert_eq!(tile_of(new(16, 0), 12), new(13, 0));
        assert_eq!(tile_of(new(2, 16), 4), new(2, 13));
        assert_eq!(tile_of(new(16, 2), 4), new(13, 2));
        assert_eq!(tile_of(new(3, 3), 400_000), new(0, 0));
        for u in 0..=16 {
            for v in 0..=16 {
                let tile = tile_of(new(u, v), 8);
                assert!(tile.u <= u && tile.v <= v && tile.texels() * 8 <= LARGEST_TILE);
                assert!(tile == new(u, v) || tile.texels() * 8 == LARGEST_TILE);
            }
        }
    }

    #[test]
    fn every_type_comes_back_whole_and_in_tiles() {
        for data_type in [DataType::U8, DataType::U16, DataType::F16, DataType::F32] {
            let format = Format { mesh: MeshType::Quad, data_type, channels: 3, alpha: None };
            for resolution in [Resolution::new(0, 3), Resolution::new(5, 2), Resolution::new(8, 9)] {
                let length = resolution.texels() as usize * format.texel_size();
                let mut random = 1u32;
                let texels: Vec<u8> = (0..length)
                    .map(|index| {
                        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        // The upper half of the larger one is constant in part.
                        if index > length / 2 && length > 1000 { 7 } else { (random >> 24) as u8 }
                    })
                    .collect();
                let (header, bytes) = encode(&texels, &format, resolution).unwrap();
                let mut budget = Budget::new(1 << 24);
                assert_eq!(header.size(), bytes.len() as u64);
                assert_eq!(header.encoding() == Encoding::Tiled, length > LARGEST_TILE as usize);
                assert_eq!(decode(&bytes, 0, header, &format, resolution, &mut budget).unwrap(), texels);
                let mut tight = Budget::new(length as u64 - 1);
                assert!(decode(&bytes, 0, header, &format, resolution, &mut tight).is_err());
            }
        }
    }

    #[test]
    fn sizes_that_cannot_be_are_refused_before_they_are_allocated() {
        let zipped = deflate(&[0; 100_000]).unwrap();
        let mut budget = Budget::new(u64::MAX);
        assert_eq!(inflate(&zipped, 0, 100_000, &mut budget).unwrap().len(), 100_000);
        for size in [0, 99_999, 100_001, u64::MAX] {
            assert!(inflate(&zipped, 0, size, &mut budget).is_err());
        }
        assert!(inflate(&zipped[..zipped.len() - 1], 0, 100_000, &mut budget).is_err());
        assert!(inflate(&[], 0, 0, &mut budget).unwrap().is_empty());
        assert!(inflate(&[], 0, 1, &mut budget).is_err());
    }
}
