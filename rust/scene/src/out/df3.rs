//! Density files of POV-Ray, `.df3`: three sizes, then the values column after column, all big-endian of 16 bits.

use std::io::Write;
use std::path::Path;

use relievo_core::Result;

/// Writes a density file of so many columns, rows and layers.
///
/// # Errors
/// Fails with `NotFound` or `Io` if the file cannot be written.
pub fn write_df3(path: &Path, size: [usize; 3], values: &[u16]) -> Result<()> {
    relievo_core::file::store(path, |out| {
        for along in size {
            out.write_all(&(along as u16).to_be_bytes())?;
        }
        values.iter().try_for_each(|value| out.write_all(&value.to_be_bytes()))
    })
}
