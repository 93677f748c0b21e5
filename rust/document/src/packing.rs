//! Zstandard for blocks. Each thread keeps what it packs and unpacks in: making that anew takes longer than a block of
//! a small tile does.

use std::cell::RefCell;
use std::io::Result;

use zstd::bulk::{Compressor, Decompressor};

thread_local! {
    static PACKER: RefCell<Option<Compressor<'static>>> = const { RefCell::new(None) };
    static UNPACKER: RefCell<Option<Decompressor<'static>>> = const { RefCell::new(None) };
}

/// Bytes from the middle of a block that say whether packing it pays. Smaller blocks than four times that are packed.
const SAMPLE: usize = 4096;
/// The level at which Zstandard copies blocks that repeat nothing.
const STORED: i32 = -1;

/// Packs the bytes of a block at a level of Zstandard's. Blocks are stored where a sample becomes smaller by less than an
/// eighth.
pub(crate) fn pack_block(bytes: &[u8], level: i32) -> Result<Vec<u8>> {
    if bytes.len() >= 4 * SAMPLE {
        let sample = &bytes[(bytes.len() - SAMPLE) / 2..][..SAMPLE];
        if pack(sample, level)?.len() > SAMPLE - SAMPLE / 8 {
            return pack(bytes, STORED);
        }
    }
    pack(bytes, level)
}

/// The bytes packed at a level of Zstandard's.
pub(crate) fn pack(bytes: &[u8], level: i32) -> Result<Vec<u8>> {
    PACKER.with_borrow_mut(|kept| {
        let packer = match kept {
            Some(packer) => packer,
            None => kept.insert(Compressor::new(level)?),
        };
        packer.set_compression_level(level)?;
        packer.compress(bytes)
    })
}

/// What was packed, `length` bytes at most. Fails if there are more, or the packed bytes are damaged.
pub(crate) fn unpack(packed: &[u8], length: usize) -> Result<Vec<u8>> {
    UNPACKER.with_borrow_mut(|kept| {
        let unpacker = match kept {
            Some(unpacker) => unpacker,
            None => kept.insert(Decompressor::new()?),
        };
        unpacker.decompress(packed, length)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_stored_and_the_rest_is_packed() {
        let mut random = 7u32;
        let mut noise = |mask: u16| -> Vec<u8> {
            let mut half = || {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (random >> 16) as u16 & mask
            };
            (0..258 * 258).flat_map(|_| half().to_le_bytes()).collect()
        };
        // Words of 16 bits, of which 16, 13 and 10 are random.
        for (mask, stored) in [(0xffff, true), (0xabff, true), (0x3ff, false)] {
            let block = noise(mask);
            let packed = pack_block(&block, 3).unwrap();
            assert_eq!(packed.len() >= block.len(), stored, "{mask:x}: {} of {}", packed.len(), block.len());
            assert_eq!(unpack(&packed, block.len()).unwrap(), block);
            assert_eq!(packed, pack_block(&block, 3).unwrap());
        }
        let smooth: Vec<u8> = (0..258 * 258u32).flat_map(|at| (at as u16 / 64).to_le_bytes()).collect();
        assert_eq!(pack_block(&smooth, 3).unwrap(), pack(&smooth, 3).unwrap());
    }

    #[test]
    fn what_is_kept_changes_no_byte_and_outlives_damage() {
        let mut seed = 7u32;
        for round in 0..40usize {
            let block: Vec<u8> = (0..round * 97)
                .map(|at| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    if at % 3 == 0 { (seed >> 24) as u8 } else { 0 }
                })
                .collect();
            for level in [1, 3] {
                let packed = pack(&block, level).unwrap();
                assert_eq!(packed, zstd::bulk::compress(&block, level).unwrap());
                assert_eq!(unpack(&packed, block.len()).unwrap(), block);
                assert!(block.is_empty() || unpack(&packed, block.len() - 1).is_err());
                assert!(unpack(&packed[..packed.len() - 1], block.len()).is_err());
            }
        }
    }
}
