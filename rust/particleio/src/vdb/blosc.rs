//! What Blosc 1 packs, in which OpenVDB keeps values: blocks of bytes that are shuffled, so that the first bytes of all numbers
//! come first, and packed in one stream or one for each byte of a number.
//!
//! Little-endian: two versions, flags and the size of a number (u8 each), bytes unpacked, of a block, and packed (u32 each);
//! where each block is (u32); and of each of its streams how long it is (u32; as long as unpacked if it is not packed) and
//! its bytes.

use std::io::Read as _;

use relievo_core::{Budget, Error, Result};

use crate::bytes::Bytes;

const HEADER: usize = 16;
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const WHOLE: u8 = 16;
/// Numbers with more bytes, and blocks of fewer of them, are one stream.
const MAX_STREAMS: usize = 16;
const FEWEST: usize = 128;

/// The first `length` bytes of what is packed. `budget` is charged with all of it.
///
/// Fails where that is damaged, shorter, or packed by other means than LZ4, zlib and zstd.
pub fn unpack(packed: &[u8], length: usize, budget: &mut Budget) -> Result<Vec<u8>> {
    let mut bytes = Bytes(packed);
    let [_, _, flags, size] = bytes.array()?;
    let mut number = || bytes.array().map(|number| u32::from_le_bytes(number) as usize);
    let [all, block, _] = [number()?, number()?, number()?];
    if all < length || all > length.saturating_add(FEWEST) {
        return Err(damaged());
    }
    let mut out = budget.filled(all, 0u8)?;
    if flags & COPIED != 0 {
        out.copy_from_slice(bytes.take(all as u64)?);
        out.truncate(length);
        return Ok(out);
    }
    let size = usize::from(size);
    if flags & BITS_SHUFFLED != 0 || size == 0 || block == 0 {
        return Err(Error::unsupported("its values are packed in a way of Blosc that is not known")
            .advise("save it with zlib, or without compression"));
    }
    let mut room = vec![0; block.min(all)];
    for (number, out) in out.chunks_mut(block).enumerate() {
        let mut place = Bytes(packed.get(HEADER + 4 * number..).ok_or_else(damaged)?);
        let place = u32::from_le_bytes(place.array()?) as usize;
        let mut bytes = Bytes(packed.get(place..).ok_or_else(damaged)?);
        let is_split = flags & WHOLE == 0 && size <= MAX_STREAMS && block / size >= FEWEST && out.len() == block;
        let streams = if is_split { size } else { 1 };
        if out.len() % streams != 0 {
            return Err(damaged());
        }
        let room = &mut room[..out.len()];
        for stream in room.chunks_exact_mut(out.len() / streams) {
            let length = u32::from_le_bytes(bytes.array()?);
            let packed = bytes.take(length.into())?;
            if packed.len() == stream.len() {
                stream.copy_from_slice(packed);
            } else {
                unpack_stream(flags >> 5, packed, stream)?;
            }
        }
        if flags & SHUFFLED == 0 || size == 1 {
            out.copy_from_slice(room);
            continue;
        }
        let count = out.len() / size;
        let (numbers, rest) = out.split_at_mut(count * size);
        for (at, number) in numbers.chunks_exact_mut(size).enumerate() {
            number.iter_mut().zip(room[at..].iter().step_by(count)).for_each(|(to, from)| *to = *from);
        }
        rest.copy_from_slice(&room[count * size..]);
    }
    out.truncate(length);
    Ok(out)
}

fn unpack_stream(kind: u8, packed: &[u8], out: &mut [u8]) -> Result<()> {
    let count = match kind {
        1 => lz4_flex::block::decompress_into(packed, out).map_err(|_| damaged())?,
        3 => flate2::read::ZlibDecoder::new(packed).read_exact(out).map(|()| out.len()).map_err(|_| damaged())?,
        4 => zstd::bulk::decompress_to_buffer(packed, out).map_err(|_| damaged())?,
        _ => {
            return Err(Error::unsupported("its values are packed by a means of Blosc that is not known")
                .advise("save it with zlib, or without compression"));
        }
    };
    if count == out.len() { Ok(()) } else { Err(damaged()) }
}

fn damaged() -> Error {
    Error::invalid("values cannot be unpacked").advise("it is damaged; export it again")
}
