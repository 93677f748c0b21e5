//! Pages: blocks of bytes that leave memory for a file and come back when somebody looks at them.
//!
//! Bytes that the file of a document has already are read from there again ([`crate::Document::page`]). All others go
//! to a [`PageFile`], a file without a name, so that nothing of it is left when the program ends, however it does, and
//! the document is not written to. A place that is given back is used again for the next page of its length: the file
//! has at most the bytes of the most pages of each length that there ever were at a time, and none without pages.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use relievo_core::{Error, Result, file};

use crate::packing;
use crate::record::failed;

/// Bytes that are not in memory. Its place is given back when it is dropped.
pub trait Page: Debug + Send + Sync {
    /// The bytes.
    ///
    /// # Errors
    /// Fails with `Io` if they cannot be read, with `Invalid` if they are not the bytes that were stored, and with
    /// `Memory` if the system has no memory for them.
    fn load(&self) -> Result<Vec<u8>>;
}

/// Where pages are made.
pub trait PageStore: Debug + Send + Sync {
    /// Takes the bytes out of memory.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if there is no place for them or no room.
    fn store(&self, bytes: &[u8]) -> Result<Arc<dyn Page>>;
}

/// Pages in a file without a name, which is made when the first of them is stored.
#[derive(Clone, Debug)]
pub struct PageFile(Arc<Mutex<Places>>);

#[derive(Debug)]
struct Places {
    /// Where the file is to be.
    folder: Option<PathBuf>,
    file: Option<File>,
    end: u64,
    pages: u64,
    /// Places that were given back, by length.
    free: BTreeMap<u64, Vec<u64>>,
}

impl PageFile {
    /// No pages yet. Their file will be in `folder`, say that of a document, or where temporary files are.
    pub fn new(folder: Option<&Path>) -> Self {
        let folder = folder.map(Path::to_path_buf);
        Self(Arc::new(Mutex::new(Places { folder, file: None, end: 0, pages: 0, free: BTreeMap::new() })))
    }

    /// Bytes of the file.
    pub fn bytes(&self) -> u64 {
        self.places().end
    }

    /// Number of pages.
    pub fn pages(&self) -> u64 {
        self.places().pages
    }

    /// What a thread left that panicked is sound: places are only noted once they are written.
    fn places(&self) -> MutexGuard<'_, Places> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Places {
    fn write(&mut self, bytes: &[u8]) -> Result<u64> {
        let length = bytes.len() as u64;
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                // A folder that cannot be written to may still hold a document that can be.
                let beside = self.folder.as_deref().and_then(|folder| file::temporary_in(folder).ok());
                none.insert(beside.map_or_else(file::temporary, Ok)?)
            }
        };
        let used = self.free.get_mut(&length).and_then(Vec::pop);
        let at = used.unwrap_or(self.end);
        if let Err(error) = file.seek(SeekFrom::Start(at)).and_then(|_| file.write_all(bytes)) {
            if used.is_some() {
                self.free.entry(length).or_default().push(at);
            }
            return Err(failed(error).at("file of paged tiles").advise("make room on the disk, or raise the budget"));
        }
        self.end = self.end.max(at + length);
        self.pages += 1;
        Ok(at)
    }

    fn give_back(&mut self, at: u64, length: u64) {
        self.pages -= 1;
        if self.pages > 0 {
            self.free.entry(length).or_default().push(at);
            return;
        }
        self.free.clear();
        if let Some(file) = &self.file
            && file.set_len(0).is_ok()
        {
            self.end = 0;
        }
    }
}

impl PageStore for PageFile {
    fn store(&self, bytes: &[u8]) -> Result<Arc<dyn Page>> {
        let at = self.places().write(bytes)?;
        let (length, crc) = (bytes.len() as u64, crc32fast::hash(bytes));
        Ok(Arc::new(FilePage { pages: self.clone(), at, length, crc }))
    }
}

/// A page of a [`PageFile`].
#[derive(Debug)]
struct FilePage {
    pages: PageFile,
    at: u64,
    length: u64,
    crc: u32,
}

impl Page for FilePage {
    fn load(&self) -> Result<Vec<u8>> {
        let mut places = self.pages.places();
        let place = |error: Error| error.at("file of paged tiles");
        let file = places.file.as_mut().ok_or_else(|| place(Error::internal("it is not there")))?;
        let bytes = read_at(file, self.at, self.length).map_err(place)?;
        sound(bytes, self.crc).map_err(place)
    }
}

impl Drop for FilePage {
    fn drop(&mut self) {
        self.pages.places().give_back(self.at, self.length);
    }
}

/// The file that a document was read from, for pages; no two documents differ by it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Source {
    /// What the file begins with.
    head: Vec<u8>,
    file: Option<Arc<Mutex<File>>>,
}

impl PartialEq for Source {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Source {
    /// A file that begins with `head`, which tells its blocks apart from all others by their checksums, not open yet.
    pub fn of(head: &[u8]) -> Self {
        Self { head: head.to_vec(), file: None }
    }

    /// Opens it, if it is at `path` and can be read beside whoever works on it. Where a lock keeps readers out there is
    /// no page to be had.
    pub fn open(&mut self, path: &Path) {
        let Ok(mut file) = file::open(path) else { return };
        let found = read_at(&mut file, 0, self.head.len() as u64);
        self.file = found.is_ok_and(|found| found == self.head).then(|| Arc::new(Mutex::new(file)));
    }

    /// The compressed block at byte `at`.
    pub fn page(&self, at: u64, length: u64, crc: u32, unpacked: usize) -> Option<Arc<dyn Page>> {
        let file = self.file.clone()?;
        Some(Arc::new(BlockPage { file, at, length, crc, unpacked }))
    }
}

/// A compressed block of a document.
#[derive(Debug)]
struct BlockPage {
    file: Arc<Mutex<File>>,
    at: u64,
    length: u64,
    crc: u32,
    unpacked: usize,
}

impl Page for BlockPage {
    fn load(&self) -> Result<Vec<u8>> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let packed = read_at(&mut file, self.at, self.length).and_then(|bytes| sound(bytes, self.crc));
        drop(file);
        let unpacked = packing::unpack(&packed.map_err(|error| error.at("document"))?, self.unpacked);
        unpacked.ok().filter(|bytes| bytes.len() == self.unpacked).ok_or_else(changed)
    }
}

fn read_at(file: &mut File, at: u64, length: u64) -> Result<Vec<u8>> {
    let length = usize::try_from(length).map_err(|_| changed())?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).map_err(|_| Error::memory("the system has no memory for a page"))?;
    file.seek(SeekFrom::Start(at)).and_then(|_| file.take(length as u64).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() == length { Ok(bytes) } else { Err(changed()) }
}

fn sound(bytes: Vec<u8>, crc: u32) -> Result<Vec<u8>> {
    if crc32fast::hash(&bytes) == crc { Ok(bytes) } else { Err(changed()) }
}

fn changed() -> Error {
    Error::invalid("a page is not what was stored").advise("close the document without saving, and open it again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pages_are_what_was_stored_and_places_are_used_again(actions in prop::collection::vec((0u8..3, 0usize..4), 0..200)) {
            let store = PageFile::new(None);
            let lengths = [0, 200, 1000, 4096];
            let (mut pages, mut most) = (Vec::new(), [0; 4]);
            for (step, (action, which)) in actions.into_iter().enumerate() {
                if action > 0 {
                    let bytes: Vec<u8> = (0..lengths[which]).map(|at| (at * 7 + step) as u8).collect();
                    pages.push((which, store.store(&bytes).unwrap(), bytes));
                } else if !pages.is_empty() {
                    pages.swap_remove(which % pages.len());
                }
                let mut held = [0; 4];
                pages.iter().for_each(|(which, ..)| held[*which] += lengths[*which]);
                (0..4).for_each(|k| most[k] = held[k].max(most[k]));
                prop_assert!(store.bytes() <= most.iter().sum::<usize>() as u64);
                prop_assert_eq!(store.pages(), pages.len() as u64);
            }
            for (_, page, bytes) in &pages {
                prop_assert_eq!(&page.load().unwrap(), bytes);
            }
            pages.clear();
            prop_assert_eq!(store.bytes(), 0);
        }
    }

    #[test]
    fn a_page_that_was_changed_or_cut_off_is_an_error() {
        let store = PageFile::new(None);
        let pages = [store.store(&[1; 100]).unwrap(), store.store(&[2; 100]).unwrap()];
        let write = |at: u64, byte: u8| {
            let mut places = store.places();
            let file = places.file.as_mut().unwrap();
            file.seek(SeekFrom::Start(at)).unwrap();
            file.write_all(&[byte]).unwrap();
        };
        write(50, 3);
        assert!(pages[0].load().is_err());
        assert_eq!(pages[1].load().unwrap(), [2; 100]);
        write(50, 1);
        assert!(pages[0].load().is_ok());
        store.places().file.as_mut().unwrap().set_len(150).unwrap();
        assert!(pages[0].load().is_ok() && pages[1].load().is_err());
    }
}
