//! Checksums of the files that a scene reads.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use relievo_core::{Error, Result};

/// CRC-32 of the bytes of a file.
pub(crate) fn checksum(path: &Path) -> Result<u32> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::invalid("it is not a file").at(path.display().to_string()));
    }
    let mut file = File::open(path).map_err(failed)?;
    let mut hasher = crc32fast::Hasher::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer).map_err(failed)? {
            0 => return Ok(hasher.finalize()),
            count => hasher.update(&buffer[..count]),
        }
    }
}
