//! A file of the cache: bytes under a key, with checksums of its chunks. Little-endian:
//!
//! - header, 56 bytes: `RLVCACHE`, version (u32), key (32 bytes), bytes of the content (u64), CRC-32 of the header (u32);
//! - CRC-32 of each chunk of 1 MiB of the content (u32 each), and CRC-32 of these (u32);
//! - the content.

use std::io::{Read, Seek, SeekFrom, Write};

use relievo_client::Hash;
use relievo_core::{Error, Result};

const MAGIC: [u8; 8] = *b"RLVCACHE";
const VERSION: u32 = 1;
/// Bytes of the header.
const HEADER: usize = 56;
/// Bytes of a chunk.
const CHUNK: usize = 1 << 20;
/// Bytes of a content at most: 256 GiB, so that the table of checksums stays small.
const MAX: u64 = 1 << 38;

/// Returns the bytes of the file of a content of so many bytes.
pub fn file_size(content: u64) -> u64 {
    HEADER as u64 + 4 * content.div_ceil(CHUNK as u64) + 4 + content
}

/// Writes a content under a key.
pub fn write(out: &mut impl Write, key: Hash, content: &[u8]) -> std::io::Result<()> {
    let mut header = MAGIC.to_vec();
    header.extend(VERSION.to_le_bytes());
    header.extend(key.0);
    header.extend((content.len() as u64).to_le_bytes());
    header.extend(crc32fast::hash(&header).to_le_bytes());
    let mut sums: Vec<u8> = content.chunks(CHUNK).flat_map(|chunk| crc32fast::hash(chunk).to_le_bytes()).collect();
    sums.extend(crc32fast::hash(&sums).to_le_bytes());
    out.write_all(&header)?;
    out.write_all(&sums)?;
    out.write_all(content)
}

/// The head of a file, checked.
pub struct Object<F> {
    file: F,
    key: Hash,
    size: u64,
    sums: Vec<u8>,
}

fn damaged(what: &str) -> Error {
    Error::invalid(format!("the file of the cache is damaged: {what}"))
        .advise("`relievo server cache verify --remove` removes damaged files; their frames are computed again")
}

impl<F: Read + Seek> Object<F> {
    /// Reads the head of a file of so many bytes. Fails where it is damaged, of a newer version or not as long as it says.
    pub fn open(mut file: F, length: u64) -> Result<Self> {
        let mut header = [0; HEADER];
        file.read_exact(&mut header).map_err(|_| damaged("it is shorter than its header"))?;
        let (body, sum) = header.split_at(HEADER - 4);
        if header[..8] != MAGIC || crc32fast::hash(body).to_le_bytes() != sum {
            return Err(damaged("its header is wrong"));
        }
        let number = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| header[at + byte]));
        if number(8) != VERSION {
            return Err(Error::unsupported(format!("the file of the cache is of version {}", number(8)))
                .advise("take the Relievo that wrote it"));
        }
        let size = u64::from(number(44)) | u64::from(number(48)) << 32;
        if size > MAX || file_size(size) != length {
            return Err(damaged("it is not as long as it says"));
        }
        let mut key = [0; 32];
        key.copy_from_slice(&header[12..44]);
        let mut sums = vec![0; 4 * size.div_ceil(CHUNK as u64) as usize + 4];
        file.read_exact(&mut sums).map_err(|_| damaged("it is shorter than its checksums"))?;
        let (body, sum) = sums.split_at(sums.len() - 4);
        if crc32fast::hash(body).to_le_bytes() != sum {
            return Err(damaged("its checksums are wrong"));
        }
        Ok(Self { file, key: Hash(key), size, sums })
    }

    /// Returns the key.
    pub fn key(&self) -> Hash {
        self.key
    }

    /// Returns the bytes of the content.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Reads `length` bytes from `offset` on, fewer at the end, and checks the chunks that they lie in. Fails where a
    /// chunk is damaged.
    pub fn part(&mut self, offset: u64, length: usize) -> Result<Vec<u8>> {
        let end = offset.saturating_add(length as u64).min(self.size);
        let offset = offset.min(end);
        let first = offset / CHUNK as u64;
        let start = first * CHUNK as u64;
        let whole = end.div_ceil(CHUNK as u64).saturating_mul(CHUNK as u64).min(self.size);
        let too_large = || Error::memory("a frame is larger than the memory of this machine");
        let room = usize::try_from(whole.saturating_sub(start)).map_err(|_| too_large())?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(room).map_err(|_| too_large())?;
        bytes.resize(room, 0);
        let place = HEADER as u64 + self.sums.len() as u64 + start;
        let read = self.file.seek(SeekFrom::Start(place)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map_err(|_| damaged("it cannot be read to its end"))?;
        for (number, chunk) in bytes.chunks(CHUNK).enumerate() {
            let at = 4 * (first as usize + number);
            if self.sums[at..at + 4] != crc32fast::hash(chunk).to_le_bytes() {
                return Err(damaged(&format!("the checksum of chunk {} is wrong", first as usize + number)));
            }
        }
        bytes.truncate((end - start) as usize);
        bytes.drain(..(offset - start) as usize);
        Ok(bytes)
    }
}
