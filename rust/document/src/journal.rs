//! A document that is being worked on: its file, to whose end records are appended. One program at a time has it.
//!
//! Data in files of other forms may have a journal too, in a file of its own beside it: it begins with a head that
//! says what it belongs to, and its inputs say enough to make the edits again.
//!
//! A record is handed to the operating system before an edit counts as confirmed: killing the program loses none of
//! them. Against a failure of power [`Journal::sync`] waits until they are on the disk.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Cursor, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, ErrorKind, Result, file};

use crate::Document;
use crate::format::{self, Damage};
use crate::record::{self, Location, RecordKind};
use crate::replay::{self, Entry, Log};
use crate::storage::{self, Storage};

/// A file that records are appended to, or another storage.
#[derive(Debug)]
pub struct Journal {
    storage: Box<dyn Storage>,
    /// The file of the document; `None` for other storage.
    path: Option<PathBuf>,
    end: u64,
    next: u64,
}

/// Bytes of the text of an input.
pub const MAX_INPUT: usize = 16 << 20;

impl Journal {
    /// A journal in a temporary file, which is gone with it.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if no file can be made in the folder for temporary files.
    pub fn temporary() -> Result<Self> {
        Ok(Self { storage: Box::new(file::temporary()?), path: None, end: 0, next: 0 })
    }

    /// Writes `document` to `path`, in place of what may be there, and begins its journal.
    ///
    /// # Errors
    /// Fails with `Busy` if another program works on the file, with `Invalid` if what has its name is no file, and as
    /// [`Document::write`].
    pub fn create(path: &Path, document: &Document) -> Result<Self> {
        if path.exists() {
            // What is there may be in use; whether it is a document does not matter.
            lock(path)?;
        }
        document.write(path)?;
        let mut file = lock(path)?;
        let end = replay::length(&mut file)?;
        Ok(Self { storage: Box::new(file), path: Some(path.to_path_buf()), end, next: 0 })
    }

    /// Writes `document` to `storage`, in place of what may be there, and begins its journal.
    ///
    /// # Errors
    /// The storage cannot be written; what it holds then is no document.
    pub fn create_in(mut storage: Box<dyn Storage>, document: &Document) -> Result<Self> {
        storage::replace(&mut *storage, |out| document.write_to(out))?;
        let end = replay::length(&mut storage)?;
        Ok(Self { storage, path: None, end, next: 0 })
    }

    /// Opens the document at `path`, which may occupy `limit` bytes with what is made of it, to go on working on it.
    /// What a killed program left of an edit is cut off; the [`Log`] says so. Documents of earlier versions are written
    /// anew.
    ///
    /// # Errors
    /// Fails with `Busy` if another program works on it, with `NotFound` or `Io` if it cannot be read and written, with
    /// `Invalid` if it is no document or damaged, with `Unsupported` if its version is newer than this build reads, and
    /// with `Memory` if it needs more than `limit`.
    pub fn open(path: &Path, limit: u64) -> Result<(Document, Log, Self)> {
        let place = |error: Error| error.at(path.display().to_string());
        let mut file = lock(path)?;
        let found = format::read(&mut file, limit).map_err(place)?;
        let (document, log) = found.sound().map_err(place)?;
        if document.version < format::VERSION {
            let head = document.head()?;
            file::store(path, |out| {
                document.write_parts(&head, out)?;
                write_edits(&mut file, all(&log), out)
            })?;
            drop(file);
            let (mut renewed, mut edits, journal) = Self::open(path, limit)?;
            (renewed.notes, edits.under_way) = (document.notes, log.under_way);
            return Ok((renewed, edits, journal));
        }
        // An input without its edit is left behind too.
        let failed = |error: std::io::Error| Error::io(path, &error);
        file.set_len(log.end).map_err(failed)?;
        let journal = Self { storage: Box::new(file), path: Some(path.to_path_buf()), end: log.end, next: log.next };
        Ok((document.with_source(path), log, journal))
    }

    /// Opens the document in `storage`, as [`Self::open`] does with a file.
    ///
    /// # Errors
    /// It is damaged, or the storage cannot be read or cut off.
    pub fn open_in(mut storage: Box<dyn Storage>, limit: u64) -> Result<(Document, Log, Self)> {
        let (document, log) = format::read(&mut storage, limit)?.sound()?;
        if document.version < format::VERSION {
            let mut renewed = Cursor::new(Vec::new());
            document.write_to(&mut renewed)?;
            write_edits(&mut storage, all(&log), &mut renewed).map_err(record::failed)?;
            let renewed = renewed.into_inner();
            storage::replace(&mut *storage, |out| out.write_all(&renewed).map_err(record::failed))?;
            drop(renewed);
            let (mut again, mut edits, journal) = Self::open_in(storage, limit)?;
            (again.notes, edits.under_way) = (document.notes, log.under_way);
            return Ok((again, edits, journal));
        }
        storage.cut(log.end).map_err(record::failed)?;
        let journal = Self { storage, path: None, end: log.end, next: log.next };
        Ok((document, log, journal))
    }

    /// Returns all bytes of the document and its journal: those of the storage themselves, where it is memory.
    ///
    /// # Errors
    /// Fails with `Io` if the storage cannot be read, and with `Memory` if the system has no memory for the bytes.
    pub fn into_bytes(mut self) -> Result<Vec<u8>> {
        let length = usize::try_from(self.end).unwrap_or(usize::MAX);
        if let Some(mut bytes) = self.storage.take_bytes() {
            bytes.truncate(length);
            return Ok(bytes);
        }
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length).map_err(|_| Error::memory("the system has no memory for the document"))?;
        let read = self.storage.rewind().and_then(|()| (&mut self.storage).take(self.end).read_to_end(&mut bytes));
        read.map_err(|error| self.place(record::failed(error)))?;
        Ok(bytes)
    }

    /// Begins a journal of something else than a document at `path`, in place of what may be there. `head` says what it
    /// belongs to.
    ///
    /// # Errors
    /// Fails with `Busy` if another program works on the file, with `Invalid` if what has its name is no file, and with
    /// `NotFound` or `Io` if it cannot be written.
    pub fn beside(path: &Path, head: &[u8]) -> Result<Self> {
        if path.exists() {
            lock(path)?;
        }
        file::store(path, |out| out.write_all(head))?;
        let storage = Box::new(lock(path)?);
        Ok(Self { storage, path: Some(path.to_path_buf()), end: head.len() as u64, next: 0 })
    }

    /// Takes up a journal that [`Self::beside`] began with `head`, none of whose records has more than `limit` bytes.
    /// What a killed program left of an edit is cut off; the [`Log`] says so.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Busy` if another program works on it, with `Invalid` if it begins otherwise or
    /// is damaged, with `Memory` if a record has more than `limit` bytes, and with `NotFound` or `Io` if it cannot be
    /// read or cut off.
    pub fn take_up(path: &Path, head: &[u8], limit: u64) -> Result<(Log, Self)> {
        let place = |error: Error| error.at(path.display().to_string());
        let failed = |error: std::io::Error| Error::io(path, &error);
        let mut file = lock(path)?;
        let mut found = Vec::new();
        Read::take(&mut file, head.len() as u64).read_to_end(&mut found).map_err(failed)?;
        if found != head {
            return Err(place(Error::invalid("it is no journal of this")).advise("move it away, or name another file"));
        }
        let mut damage = Vec::new();
        let log = replay::walk(&mut file, head.len() as u64, limit, &mut damage, |_, _, _, _| Ok(())).map_err(place)?;
        if let Some(damage) = damage.first() {
            let what = format!("it is damaged: {}: {}", damage.place, damage.what);
            return Err(place(Error::invalid(what)).advise("move it away to begin another one"));
        }
        file.set_len(log.end).map_err(failed)?;
        let journal = Self { storage: Box::new(file), path: Some(path.to_path_buf()), end: log.end, next: log.next };
        Ok((log, journal))
    }

    /// Its file; `None` for a temporary one and for other storage.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Bytes of the file.
    pub fn bytes(&self) -> u64 {
        self.end
    }

    fn place(&self, error: Error) -> Error {
        match &self.path {
            Some(path) => error.at(path.display().to_string()),
            None => error.at("storage of the history"),
        }
    }

    /// Appends what an edit is going to be.
    ///
    /// # Errors
    /// Fails with `Invalid` if the text has more than [`MAX_INPUT`] bytes, and with `Io` if it cannot be written.
    pub fn input(&mut self, text: &str) -> Result<Location> {
        if text.len() > MAX_INPUT {
            let what = format!("the description of an edit has {} bytes", text.len());
            return Err(Error::invalid(what).advise(format!("use at most {MAX_INPUT}")));
        }
        Ok(self.append(RecordKind::Input, text.as_bytes())?.0)
    }

    /// Appends what an edit is going to be, where that is no text.
    ///
    /// # Errors
    /// Fails with `Io` if they cannot be written.
    pub fn input_bytes(&mut self, bytes: &[u8]) -> Result<Location> {
        Ok(self.append(RecordKind::Input, bytes)?.0)
    }

    /// Appends what an edit changed, see [`Edit::encode`](crate::Edit::encode). Returns where it is and its sequence
    /// number.
    ///
    /// # Errors
    /// Fails with `Io` if it cannot be written; the edit is not confirmed then.
    pub fn edit(&mut self, payload: &[u8]) -> Result<(Location, u64)> {
        self.append(RecordKind::Edit, payload)
    }

    /// Appends what an edit changed that the base has already, if it is `done`, or that was undone before.
    ///
    /// # Errors
    /// Fails with `Io` if it cannot be written.
    pub fn carry(&mut self, payload: &[u8], done: bool) -> Result<(Location, u64)> {
        self.append(if done { RecordKind::Past } else { RecordKind::Future }, payload)
    }

    /// Appends the layers of what the document was opened on, see [`Edit::encode`](crate::Edit::encode), where they are
    /// not those of the document.
    ///
    /// # Errors
    /// Fails with `Io` if they cannot be written.
    pub fn layers(&mut self, payload: &[u8]) -> Result<()> {
        self.append(RecordKind::Layers, payload).map(drop)
    }

    /// Takes back the input at `location` if nothing follows it: the edit was not made.
    ///
    /// # Errors
    /// Fails with `Io` if the storage cannot be cut off.
    pub fn withdraw(&mut self, location: Location) -> Result<()> {
        let start = location.offset - record::HEAD as u64;
        if self.end == location.offset + location.length + record::TAIL as u64 {
            self.storage.cut(start).map_err(|error| self.place(record::failed(error)))?;
            self.end = start;
            self.next -= 1;
        }
        Ok(())
    }

    /// Notes that the edit with the sequence number `edit` was undone.
    ///
    /// # Errors
    /// Fails with `Io` if the record cannot be written.
    pub fn undo(&mut self, edit: u64) -> Result<()> {
        self.append(RecordKind::Undo, &edit.to_le_bytes()).map(drop)
    }

    /// Notes that the edit with the sequence number `edit` was made again.
    ///
    /// # Errors
    /// Fails with `Io` if the record cannot be written.
    pub fn redo(&mut self, edit: u64) -> Result<()> {
        self.append(RecordKind::Redo, &edit.to_le_bytes()).map(drop)
    }

    /// The payload at `location`.
    ///
    /// # Errors
    /// Fails with `Invalid` if the file was changed since by somebody else, with `Io` if it cannot be read, and with
    /// `Memory` if the system has no memory for the payload.
    pub fn read(&mut self, location: Location) -> Result<Vec<u8>> {
        record::read_payload(&mut self.storage, location).map_err(|error| self.place(error))
    }

    /// The text of an input.
    ///
    /// # Errors
    /// Fails as [`Self::read`], and with `Invalid` if the input is not UTF-8.
    pub fn read_input(&mut self, location: Location) -> Result<String> {
        self.read(location).and_then(replay::text)
    }

    /// Waits until all records are on the disk.
    ///
    /// # Errors
    /// Fails with `Io` if the storage cannot write them.
    pub fn sync(&self) -> Result<()> {
        self.storage.sync().map_err(|error| self.place(record::failed(error)))
    }

    /// Where a record of that payload would be after this one: nothing of it is there yet.
    fn append(&mut self, kind: RecordKind, payload: &[u8]) -> Result<(Location, u64)> {
        let (bytes, crc) = record::frame(kind, self.next, payload);
        let written = self.storage.seek(SeekFrom::Start(self.end)).and_then(|_| self.storage.write_all(&bytes));
        if let Err(error) = written {
            // So that the next record does not follow half of this one.
            let _ = self.storage.cut(self.end);
            return Err(self.place(record::failed(error)).advise("make room on the disk; the edit is not confirmed"));
        }
        let offset = self.end + record::HEAD as u64;
        let (location, sequence) = (Location { offset, length: payload.len() as u64, crc }, self.next);
        self.end += bytes.len() as u64;
        self.next += 1;
        Ok((location, sequence))
    }
}

/// Opens a file for this program alone.
fn lock(path: &Path) -> Result<File> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    // A pipe or device could wait for ever.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::invalid("it is not a file").at(path.display().to_string()).advise("name a file"));
    }
    let file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Error::new(ErrorKind::Busy, "another program works on the document")
            .at(path.display().to_string())
            .advise("close it there first")),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// An edit of a document, as [`list_edits`] reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedEdit {
    /// Whether it is made; otherwise it is undone.
    pub is_done: bool,
    /// Bytes of what it changed.
    pub bytes: u64,
    /// What it was made of; empty where the journal does not have it.
    pub input: String,
}

/// Lists the edits of the document at `path`, the oldest first; undone ones follow in the order in which they are made
/// again. The file is not changed, and may be in use. Returns the note of [`Log::note`] too.
///
/// # Errors
/// The file cannot be read, or is damaged.
pub fn list_edits(path: &Path, limit: u64) -> Result<(Vec<ListedEdit>, Option<String>)> {
    let place = |error: Error| error.at(path.display().to_string());
    let mut file = file::open(path)?;
    let (_, log) = format::read(&mut file, limit).and_then(format::Found::sound).map_err(place)?;
    let done = log.done.iter().map(|entry| (true, entry));
    let edits = done.chain(log.undone.iter().rev().map(|entry| (false, entry))).map(|(is_done, entry)| {
        let input = entry.input.map(|input| record::read_payload(&mut file, input).map_err(place)).transpose()?;
        let input = String::from_utf8_lossy(&input.unwrap_or_default()).into_owned();
        Ok(ListedEdit { is_done, bytes: entry.edit.length, input })
    });
    Ok((edits.collect::<Result<_>>()?, log.note()))
}

/// What [`compact`] did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compacted {
    /// Edits that were folded into the base, and can no longer be undone.
    pub edits: usize,
    /// Edits that were undone, and can no longer be made again.
    pub undone: usize,
    /// Bytes of the file before and after.
    pub bytes: [u64; 2],
    /// What the user should know of how the document was left.
    pub note: Option<String>,
}

/// Folds the journal of the document at `path` into its base: what is seen stays the same. Of the history the last
/// `keep` edits can still be undone, and if there are any, what was undone made again. The file is replaced as a whole
/// or not at all.
///
/// # Errors
/// Fails, and changes nothing, with `Busy` if another program works on it, with `Invalid` if it is damaged, with
/// `Unsupported` if its version is newer than this build reads, with `Memory` if it needs more than `limit`, and with
/// `NotFound` or `Io` if it cannot be read or written.
pub fn compact(path: &Path, limit: u64, keep: usize) -> Result<Compacted> {
    let size = || std::fs::metadata(path).map(|metadata| metadata.len()).map_err(|error| Error::io(path, &error));
    let before = size()?;
    let mut file = lock(path)?;
    let found = format::read(&mut file, limit).map_err(|error| error.at(path.display().to_string()))?;
    let (document, log) = found.sound().map_err(|error| error.at(path.display().to_string()))?;
    let edits = log.done.len().saturating_sub(keep);
    let undone = if keep > 0 { log.undone.as_slice() } else { &[] };
    let kept = log.done[edits..].iter().map(|entry| (entry, true)).chain(undone.iter().map(|entry| (entry, false)));
    let head = document.head()?;
    let locked = held(&file, path)?;
    file::store(path, move |out| {
        document.write_parts(&head, out)?;
        // The file is closed once its edits are read.
        write_edits(&mut { file }, kept, out)
    })?;
    drop(locked);
    let undone = log.undone.len() - undone.len();
    Ok(Compacted { edits, undone, bytes: [before, size()?], note: log.note() })
}

/// Returns a second handle of a locked file, which keeps the lock while the file is replaced. Windows replaces no file that is
/// open, and has no such handle.
fn held(file: &File, path: &Path) -> Result<Option<File>> {
    let second = cfg!(unix).then(|| file.try_clone()).transpose();
    second.map_err(|error| Error::io(path, &error))
}

/// Copies a locked file, which on Windows only its handle reads.
fn copy(file: &mut File, to: &Path) -> std::io::Result<()> {
    file.rewind()?;
    let mut made = File::create(to)?;
    std::io::copy(file, &mut made)?;
    made.set_permissions(file.metadata()?.permissions())
}

/// All edits of a journal, with whether they can be undone (true) or made again.
fn all(log: &Log) -> impl Iterator<Item = (&Entry, bool)> {
    log.done.iter().map(|entry| (entry, true)).chain(log.undone.iter().map(|entry| (entry, false)))
}

/// Writes `edits` of the journal in `source`, which can be undone (true) or made again, as the journal of another base.
fn write_edits<'a>(
    source: &mut (impl Read + Seek),
    edits: impl Iterator<Item = (&'a Entry, bool)>,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let mut next = 0;
    for (entry, done) in edits {
        let kind = if done { RecordKind::Past } else { RecordKind::Future };
        let input = entry.input.map(|input| (RecordKind::Input, input));
        for (kind, location) in input.into_iter().chain([(kind, entry.edit)]) {
            let payload = record::read_payload(source, location).map_err(std::io::Error::other)?;
            out.write_all(&record::frame(kind, next, &payload).0)?;
            next += 1;
        }
    }
    Ok(())
}

/// What [`repair`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaired {
    /// What was damaged, and whether it is lost.
    pub damage: Vec<Damage>,
    /// What the user should know of how the document was left.
    pub note: Option<String>,
    /// Where the file is as it was, if it was damaged.
    pub kept: Option<PathBuf>,
}

/// Makes the document at `path` one that opens: cuts off what a killed program left of an edit, and leaves out what is
/// damaged. Blocks of which later edits are damaged are as they last were known. If anything was damaged the journal is
/// folded into the base, and the file as it was is kept beside it, with `.damaged` after its name.
///
/// # Errors
/// Fails, and does not change the file, with `Busy` if another program works on it, with `Invalid` if it is no document
/// or neither copy of its header or of its index can be read, with `Unsupported` if its version is newer than this
/// build reads, with `Memory` if it needs more than the context's memory limit, and with `NotFound` or `Io` if it
/// cannot be read, copied or written.
pub fn repair(context: &Context, path: &Path) -> Result<Repaired> {
    let mut file = lock(path)?;
    let (found, damage) = format::examined(context, &mut file).map_err(|error| error.at(path.display().to_string()))?;
    let note = found.log.note();
    if damage.is_empty() {
        if found.document.version == format::VERSION {
            file.set_len(found.log.end).map_err(|error| Error::io(path, &error))?;
        }
        return Ok(Repaired { damage, note, kept: None });
    }
    let mut name = path.as_os_str().to_owned();
    name.push(".damaged");
    let kept = PathBuf::from(name);
    copy(&mut file, &kept).map_err(|error| Error::io(&kept, &error))?;
    let locked = held(&file, path)?;
    drop(file);
    found.document.without_damage(context).write(path)?;
    drop(locked);
    Ok(Repaired { damage, note, kept: Some(kept) })
}
