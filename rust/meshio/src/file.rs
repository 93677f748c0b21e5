//! Whole files in and out: bounded reads, and writes that appear under their name only when complete.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use relievo_core::{Error, Result};

/// The bytes of the file at `path`, at most `limit` of them.
pub(crate) fn load(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    let named = |error: Error| error.at(path.display().to_string());
    // A pipe or device could wait or go on for ever, even when it is only opened.
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(named(Error::invalid("it is not a file").advise("name a mesh file")));
    }
    let file = File::open(path).map_err(failed)?;
    let too_large = || {
        named(Error::memory(format!("the file is larger than the memory limit of {limit} bytes")))
            .advise("raise the memory limit, or split the mesh")
    };
    if metadata.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(metadata.len()).map_err(|_| too_large())?;
    bytes.try_reserve_exact(length).map_err(|_| too_large())?;
    // The file may grow while it is read.
    file.take(metadata.len()).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}
