//! Zstandard for blocks. Each thread keeps what it packs and unpacks in: making that anew takes longer than a block of
//! a small tile does.

use std::cell::RefCell;
use std::io::Result;

use zstd::bulk::{Compressor, Decompressor};

thread_local! {
    static PACKER: RefCell<Option<Compressor<'static>>> = const { RefCell::new(None) };
    static UNPACKER: RefCell<Option<Decompressor<'static>>> = const { RefCell::new(None) };
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
