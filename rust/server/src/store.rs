//! The cache on disk: frames by keys of all that they depend on.
//!
//! A file is written under another name, brought to the disk and renamed, and then its folder is brought to the disk. A frame
//! counts as stored after that, so it is whole after any crash. The files are bounded in size: before one is written,
//! the files read or written longest ago are removed, but no pinned ones. The time of the last use is that of the
//! file's last change, so the order outlives the server.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use relievo_client::Hash;
use relievo_core::{Error, ErrorKind, Result};

use crate::object::{self, Object};

/// The folder of frames within that of the cache.
const FRAMES: &str = "frames";
/// The folder of files that are not complete.
const UNFINISHED: &str = "unfinished";
/// The file that is locked while a server uses the cache.
const LOCK: &str = "lock";

/// The cache of a server.
pub struct Store {
    folder: PathBuf,
    limit: u64,
    index: Mutex<Index>,
    /// Held as long as the store is open.
    _lock: Option<File>,
}

#[derive(Default)]
struct Index {
    entries: HashMap<Hash, Entry>,
    /// Keys by the time of their last use.
    order: BTreeMap<u64, Hash>,
    total: u64,
    /// The time of the next use, which only grows, whatever the clock does.
    next: u64,
    /// Number of unfinished files so far.
    written: u64,
}

struct Entry {
    bytes: u64,
    used: u64,
    pins: u32,
}

/// A frame in the cache.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its key.
    pub key: String,
    /// Bytes of its file.
    pub bytes: u64,
    /// Seconds since it was used last.
    pub idle: u64,
}

impl Store {
    /// Opens the cache in a folder, which is made if it is not there, and removes what is not complete.
    ///
    /// # Errors
    /// Fails with `Busy` if another server uses it, and with `NotFound` or `Io` if the folder cannot be made, read or
    /// written.
    pub fn open(folder: &Path, limit: u64) -> Result<Self> {
        let failed =
            |error: std::io::Error| Error::io(folder, &error).advise("check the folder, its rights and its space");
        std::fs::create_dir_all(folder.join(FRAMES)).map_err(failed)?;
        let unfinished = folder.join(UNFINISHED);
        std::fs::create_dir_all(&unfinished).map_err(failed)?;
        let lock = File::create(folder.join(LOCK)).map_err(failed)?;
        if lock.try_lock().is_err() {
            return Err(Error::new(ErrorKind::Busy, "another server uses the cache")
                .at(folder.display().to_string())
                .advise("name another folder by --cache, or stop that server"));
        }
        for entry in std::fs::read_dir(&unfinished).map_err(failed)? {
            std::fs::remove_file(entry.map_err(failed)?.path()).map_err(failed)?;
        }
        Self::of_folder(folder, limit, Some(lock))
    }

    /// Opens a cache to look at it, also while a server uses it.
    ///
    /// # Errors
    /// Fails with `NotFound` if the folder has no cache, and with `Io` if it cannot be read.
    pub fn look(folder: &Path) -> Result<Self> {
        if !folder.join(FRAMES).is_dir() {
            return Err(Error::new(ErrorKind::NotFound, "there is no cache")
                .at(folder.display().to_string())
                .advise("name the folder of a cache by --cache"));
        }
        Self::of_folder(folder, u64::MAX, None)
    }

    /// Lists the frames of a folder, least recently used first.
    fn of_folder(folder: &Path, limit: u64, lock: Option<File>) -> Result<Self> {
        let store = Self { folder: folder.to_owned(), limit, index: Mutex::default(), _lock: lock };
        let mut found = store.scan()?;
        found.sort_by_key(|(_, _, time)| *time);
        let mut index = store.index();
        for (key, bytes, _) in found {
            index.add(key, bytes);
        }
        drop(index);
        Ok(store)
    }

    /// Returns the folder of the cache.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Lists the files of frames with their sizes and the times of their last use.
    fn scan(&self) -> Result<Vec<(Hash, u64, SystemTime)>> {
        let failed = |error: std::io::Error| Error::io(&self.folder, &error);
        let mut found = Vec::new();
        for folder in std::fs::read_dir(self.folder.join(FRAMES)).map_err(failed)? {
            let folder = folder.map_err(failed)?.path();
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            for entry in entries {
                let entry = entry.map_err(failed)?;
                let Some(key) = entry.file_name().to_str().and_then(|name| name.parse::<Hash>().ok()) else { continue };
                // A file that another process removes meanwhile is none of the cache.
                let Ok(metadata) = entry.metadata() else { continue };
                found.push((key, metadata.len(), metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH)));
            }
        }
        Ok(found)
    }

    fn index(&self) -> MutexGuard<'_, Index> {
        self.index.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, key: Hash) -> PathBuf {
        let name = key.to_string();
        self.folder.join(FRAMES).join(&name[..2]).join(name)
    }

    /// Returns whether there is a frame with this key.
    pub fn contains(&self, key: Hash) -> bool {
        self.index().entries.contains_key(&key)
    }

    /// Returns the bytes of all files and how many there are.
    pub fn size(&self) -> (u64, usize) {
        let index = self.index();
        (index.total, index.entries.len())
    }

    /// Stores a content under a key. It is there, whatever happens afterwards, once this returns. Older contents are
    /// removed where the limit would be exceeded.
    ///
    /// # Errors
    /// Fails, and stores nothing, with `Memory` if the content and the pinned frames exceed the limit, and with
    /// `NotFound` or `Io` if a file cannot be written or removed.
    pub fn put(&self, key: Hash, content: &[u8]) -> Result<()> {
        let bytes = object::file_size(content.len() as u64);
        let number = {
            let mut index = self.index();
            if index.entries.contains_key(&key) {
                return Ok(());
            }
            let pinned: u64 = index.entries.values().filter(|entry| entry.pins > 0).map(|entry| entry.bytes).sum();
            if pinned.saturating_add(bytes) > self.limit {
                let what = format!("a frame of {bytes} bytes does not fit into the cache of {} bytes", self.limit);
                return Err(Error::memory(what).advise("raise the limit of the cache, or cancel other scenes"));
            }
            self.make_room(&mut index, self.limit - bytes)?;
            index.number()
        };
        let path = self.path(key);
        let unfinished = self.unfinished(number);
        let written = self.write(&unfinished, &path, |file| object::write(file, key, content));
        if written.is_err() {
            // What cannot be removed now is removed when the cache is opened next.
            let _ = std::fs::remove_file(&unfinished);
        }
        written?;
        self.index().add(key, bytes);
        Ok(())
    }

    /// Returns the path of a file that is not there, for what is made before it is stored. What its user leaves there is
    /// removed when the cache is opened next.
    pub fn scratch(&self) -> PathBuf {
        let number = self.index().number();
        self.unfinished(number)
    }

    fn unfinished(&self, number: u64) -> PathBuf {
        self.folder.join(UNFINISHED).join(format!("{}-{number}", std::process::id()))
    }

    /// Writes a file under another name, brings it to the disk and renames it.
    fn write(
        &self,
        unfinished: &Path,
        path: &Path,
        content: impl FnOnce(&mut File) -> std::io::Result<()>,
    ) -> Result<()> {
        let failed = |error: std::io::Error| Error::io(path, &error).advise(advice(&error));
        let Some(folder) = path.parent() else { return Err(Error::internal("a frame has no folder")) };
        if !folder.is_dir() {
            std::fs::create_dir_all(folder).map_err(failed)?;
            sync_folder(&self.folder.join(FRAMES)).map_err(failed)?;
        }
        let mut file = File::create(unfinished).map_err(failed)?;
        content(&mut file).map_err(failed)?;
        // The system's time of a write may lag behind the clock by which uses are counted.
        let _ = file.set_modified(SystemTime::now());
        file.sync_all().map_err(failed)?;
        drop(file);
        std::fs::rename(unfinished, path).and_then(|()| sync_folder(folder)).map_err(failed)
    }

    /// Removes the files that were used longest ago until at most `limit` bytes are left, or only pinned ones.
    fn make_room(&self, index: &mut Index, limit: u64) -> Result<Vec<Hash>> {
        let mut removed = Vec::new();
        let oldest: Vec<Hash> = index.order.values().copied().collect();
        for key in oldest {
            if index.total <= limit {
                break;
            }
            if index.entries.get(&key).is_some_and(|entry| entry.pins > 0) {
                continue;
            }
            self.forget(index, key)?;
            removed.push(key);
        }
        Ok(removed)
    }

    fn forget(&self, index: &mut Index, key: Hash) -> Result<()> {
        let path = self.path(key);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&path, &error)),
            _ => index.remove(key),
        }
        Ok(())
    }

    /// Opens the file of a key and counts it as used.
    fn object(&self, key: Hash) -> Result<Object<File>> {
        let path = self.path(key);
        if !self.index().touch(key) {
            return Err(Error::new(ErrorKind::NotFound, "the frame is no longer in the cache")
                .advise("wait until it is computed again"));
        }
        let failed = |error: std::io::Error| Error::io(&path, &error);
        let file = File::open(&path).map_err(failed)?;
        // A clock that jumps back changes the order after a restart, and nothing else.
        let _ = file.set_modified(SystemTime::now());
        let length = file.metadata().map_err(failed)?.len();
        let object = Object::open(file, length)?;
        match object.key() == key {
            true => Ok(object),
            false => Err(Error::invalid("the file of the cache is that of another frame")),
        }
    }

    /// Removes a file that turned out to be damaged or gone, so that its frame is computed again. One that cannot be read now, for
    /// want of memory or of file handles, stays.
    fn checked<T>(&self, key: Hash, result: Result<T>) -> Result<T> {
        let is_gone = || std::fs::metadata(self.path(key)).is_err_and(|it| it.kind() == std::io::ErrorKind::NotFound);
        let is_lost = |error: &Error| match error.kind {
            ErrorKind::Invalid | ErrorKind::Unsupported => true,
            ErrorKind::Io | ErrorKind::NotFound => is_gone(),
            _ => false,
        };
        if let Err(error) = &result
            && self.contains(key)
            && is_lost(error)
        {
            tracing::warn!(%key, %error, "removed a damaged or missing frame from the cache");
            self.forget(&mut self.index(), key)?;
        }
        result
    }

    /// Returns the content under a key.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is none, with `Io` if its file cannot be opened, with `Invalid` if it is damaged,
    /// with `Unsupported` if it is of another version, and with `Memory` if memory does not suffice. A file that is damaged or
    /// of another version is removed.
    pub fn get(&self, key: Hash) -> Result<Vec<u8>> {
        let content = self.object(key).and_then(|mut object| object.part(0, usize::MAX));
        self.checked(key, content)
    }

    /// Returns a part of the content under a key, and its whole size.
    ///
    /// # Errors
    /// Fails as [`Self::get`]; only the chunks of the part are checked.
    pub fn part(&self, key: Hash, offset: u64, length: usize) -> Result<(Vec<u8>, u64)> {
        let part = self.object(key).and_then(|mut object| Ok((object.part(offset, length)?, object.size())));
        self.checked(key, part)
    }

    /// Returns the bytes of the content under a key.
    ///
    /// # Errors
    /// Fails as [`Self::get`]; only the head of the file is checked.
    pub fn content_size(&self, key: Hash) -> Result<u64> {
        let size = self.object(key).map(|object| object.size());
        self.checked(key, size)
    }

    /// Keeps a frame from being removed until [`Self::unpin`].
    pub fn pin(&self, key: Hash) {
        if let Some(entry) = self.index().entries.get_mut(&key) {
            entry.pins += 1;
        }
    }

    /// Takes a pin from a frame.
    pub fn unpin(&self, key: Hash) {
        if let Some(entry) = self.index().entries.get_mut(&key) {
            entry.pins = entry.pins.saturating_sub(1);
        }
    }

    /// Lists the frames, least recently used first.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the folder cannot be read.
    pub fn list(&self) -> Result<Vec<Listed>> {
        let mut found = self.scan()?;
        found.sort_by_key(|(_, _, time)| *time);
        let idle = |time: SystemTime| SystemTime::now().duration_since(time).unwrap_or(Duration::ZERO).as_secs();
        Ok(found
            .into_iter()
            .map(|(key, bytes, time)| Listed { key: key.to_string(), bytes, idle: idle(time) })
            .collect())
    }

    /// Checks every chunk of every frame. Returns the damaged ones with what is wrong, and removes them where `remove` says
    /// so.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the folder cannot be read or a damaged frame cannot be removed.
    pub fn verify(&self, remove: bool) -> Result<Vec<(String, Error)>> {
        let mut damaged = Vec::new();
        for (key, length, _) in self.scan()? {
            let path = self.path(key);
            let opened = File::open(&path).map_err(|error| Error::io(&path, &error));
            let checked = opened.and_then(|file| Object::open(file, length)).and_then(|mut object| {
                let mut offset = 0;
                while offset < object.size() {
                    offset += object.part(offset, 64 << 20)?.len() as u64;
                }
                if object.key() == key { Ok(()) } else { Err(Error::invalid("it is the file of another frame")) }
            });
            if let Err(error) = checked {
                if remove {
                    self.forget(&mut self.index(), key)?;
                }
                damaged.push((key.to_string(), error));
            }
        }
        Ok(damaged)
    }

    /// Removes the frames that were used longest ago until at most `limit` bytes are left. Returns how many were removed.
    ///
    /// # Errors
    /// Fails with `Io` if a file cannot be removed.
    pub fn collect(&self, limit: u64) -> Result<usize> {
        let mut index = self.index();
        Ok(self.make_room(&mut index, limit)?.len())
    }
}

impl Index {
    fn add(&mut self, key: Hash, bytes: u64) {
        self.remove(key);
        let used = self.next;
        self.next += 1;
        self.entries.insert(key, Entry { bytes, used, pins: 0 });
        self.order.insert(used, key);
        self.total += bytes;
    }

    /// Returns the number of the next unfinished file.
    fn number(&mut self) -> u64 {
        self.written += 1;
        self.written
    }

    fn remove(&mut self, key: Hash) {
        if let Some(entry) = self.entries.remove(&key) {
            self.order.remove(&entry.used);
            self.total -= entry.bytes;
        }
    }

    /// Counts a frame as used now. Returns whether it is there.
    fn touch(&mut self, key: Hash) -> bool {
        let Some(entry) = self.entries.get_mut(&key) else { return false };
        self.order.remove(&entry.used);
        entry.used = self.next;
        self.order.insert(self.next, key);
        self.next += 1;
        true
    }
}

/// Returns what to do where a frame cannot be written.
fn advice(error: &std::io::Error) -> &'static str {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    match error.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => {
            "make space on its disk, and resume the scene; its earlier frames are whole"
        }
        _ => "check the folder, its rights and its space",
    }
}

/// Brings the names in a folder to the disk.
pub fn sync_folder(folder: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}
