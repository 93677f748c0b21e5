//! Storage of documents: what a [`Journal`](crate::Journal) reads, appends to and cuts off.

use std::fmt::Debug;
use std::fs::File;
use std::io::{Cursor, Read, Result, Seek, SeekFrom, Write};

/// Bytes that can be read, written at any place, and cut off: a file, memory, or a stream of a host.
///
/// What is written beyond the end extends it. One journal at a time has a storage.
pub trait Storage: Read + Write + Seek + Debug + Send {
    /// Cuts the storage off after `length` bytes, if it has more.
    ///
    /// # Errors
    /// Fails with the error of the system or the host if the storage cannot be cut off.
    fn cut(&mut self, length: u64) -> Result<()>;

    /// Waits until all that was written is safe against a failure of power, as far as the storage knows one.
    ///
    /// # Errors
    /// Fails with the error of the system or the host if something could not be written.
    fn sync(&self) -> Result<()>;

    /// Gives up all that the storage holds, where that is memory of its own.
    fn take_bytes(&mut self) -> Option<Vec<u8>> {
        None
    }
}

impl Storage for File {
    fn cut(&mut self, length: u64) -> Result<()> {
        if length < self.metadata()?.len() { File::set_len(self, length) } else { Ok(()) }
    }

    fn sync(&self) -> Result<()> {
        self.sync_data()
    }
}

impl Storage for Cursor<Vec<u8>> {
    fn cut(&mut self, length: u64) -> Result<()> {
        self.get_mut().truncate(usize::try_from(length).unwrap_or(usize::MAX));
        Ok(())
    }

    fn sync(&self) -> Result<()> {
        Ok(())
    }

    fn take_bytes(&mut self) -> Option<Vec<u8>> {
        self.set_position(0);
        Some(std::mem::take(self.get_mut()))
    }
}

/// Replaces all that `storage` holds by what `write` writes. What is there when `write` fails is neither.
pub(crate) fn replace(
    storage: &mut dyn Storage,
    write: impl FnOnce(&mut dyn Write) -> relievo_core::Result<()>,
) -> relievo_core::Result<()> {
    storage.cut(0).and_then(|()| storage.seek(SeekFrom::Start(0))).map_err(crate::record::failed)?;
    let mut out = std::io::BufWriter::with_capacity(1 << 16, storage);
    write(&mut out)?;
    out.flush().map_err(crate::record::failed)
}
