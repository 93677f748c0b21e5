//! Reads a file forwards, with every size checked against what is left of it.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result, file};

/// A place in a file of known length.
pub(crate) struct Cursor {
    input: BufReader<File>,
    path: PathBuf,
    place: u64,
    length: u64,
}

/// An error about what is in a file.
pub(crate) fn damaged(what: &str) -> Error {
    Error::invalid(format!("the file is damaged: {what}")).advise("export it again")
}

impl Cursor {
    pub fn open(path: &Path) -> Result<Self> {
        let input = file::open(path)?;
        let length = input.metadata().map_err(|error| Error::io(path, &error))?.len();
        Ok(Self { input: BufReader::with_capacity(1 << 16, input), path: path.to_owned(), place: 0, length })
    }

    pub fn place(&self) -> u64 {
        self.place
    }

    pub fn left(&self) -> u64 {
        self.length - self.place
    }

    /// Goes to a place counted from the beginning.
    pub fn go(&mut self, place: u64) -> Result<()> {
        if place > self.length {
            return Err(damaged("a place lies behind its end"));
        }
        self.input.seek(SeekFrom::Start(place)).map_err(|error| Error::io(&self.path, &error))?;
        self.place = place;
        Ok(())
    }

    /// Goes on by a number of bytes.
    pub fn skip(&mut self, bytes: u64) -> Result<()> {
        self.within(bytes)?;
        let step = i64::try_from(bytes).map_err(|_| damaged("a size is too large"))?;
        self.input.seek_relative(step).map_err(|error| Error::io(&self.path, &error))?;
        self.place += bytes;
        Ok(())
    }

    fn within(&self, bytes: u64) -> Result<()> {
        if bytes <= self.left() { Ok(()) } else { Err(damaged("it ends too early")) }
    }

    /// Fills a buffer.
    pub fn fill(&mut self, out: &mut [u8]) -> Result<()> {
        self.within(out.len() as u64)?;
        self.input.read_exact(out).map_err(|error| Error::io(&self.path, &error))?;
        self.place += out.len() as u64;
        Ok(())
    }

    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut out = [0; N];
        self.fill(&mut out)?;
        Ok(out)
    }

    /// Reads bytes that are left of the file and at most `most`.
    pub fn bytes(&mut self, count: u64, most: u64) -> Result<Vec<u8>> {
        self.within(count)?;
        if count > most {
            return Err(damaged("a text is too long"));
        }
        let mut out = vec![0; count as usize];
        self.fill(&mut out)?;
        Ok(out)
    }

    pub fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn i64(&mut self) -> Result<i64> {
        self.array().map(i64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// Reads a text with its length before it.
    pub fn text(&mut self) -> Result<String> {
        let length = self.u32()?;
        let bytes = self.bytes(length.into(), 1 << 20)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}
