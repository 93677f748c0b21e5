//! What the server remembers of a scene on disk: MessagePack behind its CRC-32, one file a scene. A file is written under
//! another name, brought to the disk and renamed, so that there is the old one or the new one after any crash.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use relievo_client::{FileMap, Hash, Hasher};
use relievo_core::{Error, Result, file};
use serde::{Deserialize, Serialize};

use crate::store::sync_folder;

const VERSION: u32 = 1;
/// Bytes of a record at most.
const LONGEST: u64 = 64 << 20;

/// What the user wants of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wish {
    Run,
    Pause,
    Cancel,
}

/// A description, and the frame after which it holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// The last frame that does not depend on it; the first segment also holds for frame 0.
    pub from: u64,
    pub description: String,
    /// All that decides the frames, as the simulation says it.
    pub identity: String,
    /// The number of the last frame.
    pub last: u64,
}

/// A scene as it is stored.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    version: u32,
    pub user: String,
    pub name: String,
    pub kind: String,
    pub files: FileMap,
    /// Whether each frame waits for accelerations by the host.
    pub forced: bool,
    pub segments: Vec<Segment>,
    /// Hashes of the accelerations on the way from a frame to the next.
    pub forces: BTreeMap<u64, Hash>,
    pub wish: Wish,
}

impl Record {
    /// Returns the record of a new scene.
    pub fn new(user: &str, name: &str, kind: &str, files: FileMap, forced: bool, segment: Segment) -> Self {
        let (user, name, kind) = (user.to_owned(), name.to_owned(), kind.to_owned());
        let (segments, forces) = (vec![segment], BTreeMap::new());
        Self { version: VERSION, user, name, kind, files, forced, segments, forces, wish: Wish::Run }
    }

    /// Returns the description that leads to a frame.
    pub fn segment(&self, frame: u64) -> &Segment {
        let after = self.segments.iter().rposition(|segment| segment.from < frame).unwrap_or(0);
        &self.segments[after]
    }

    /// Returns the number of the last frame.
    pub fn last(&self) -> u64 {
        self.segments.last().map_or(0, |segment| segment.last)
    }

    /// Returns the key of a frame, which follows one with the key `before`: the hash of all that it depends on.
    pub fn key(&self, frame: u64, before: Option<Hash>, level: &str) -> Hash {
        let mut hasher = Hasher::default();
        hasher.add_part(b"relievo frame 1");
        hasher.add_part(self.kind.as_bytes());
        hasher.add_part(level.as_bytes());
        hasher.add_part(self.segment(frame).identity.as_bytes());
        hasher.add_part(before.as_ref().map_or(&[], |key| &key.0));
        let force = frame.checked_sub(1).and_then(|frame| self.forces.get(&frame));
        hasher.add_part(force.map_or(&[], |hash| &hash.0));
        hasher.finish()
    }

    fn path(&self, folder: &Path) -> PathBuf {
        let mut hasher = Hasher::default();
        hasher.add_part(self.user.as_bytes());
        hasher.add_part(self.name.as_bytes());
        folder.join(format!("{}.scene", hasher.finish()))
    }

    /// Writes the record into a folder and brings it to the disk.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let path = self.path(folder);
        let body = rmp_serde::to_vec_named(self).map_err(|error| Error::internal(error.to_string()))?;
        file::store(&path, |out| {
            out.write_all(&crc32fast::hash(&body).to_le_bytes())?;
            out.write_all(&body)?;
            out.flush()?;
            out.get_ref().sync_all()
        })?;
        sync_folder(folder).map_err(|error| Error::io(folder, &error))
    }

    /// Removes the record from its folder.
    pub fn remove(&self, folder: &Path) -> Result<()> {
        let path = self.path(folder);
        std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))
    }

    /// Reads a record. Fails where it is damaged or of a newer version.
    pub fn load(path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, LONGEST)?;
        let damaged = || {
            named(Error::invalid("the record of a scene is damaged").advise("remove it, and submit the scene again"))
        };
        let (sum, body) = bytes.split_first_chunk::<4>().ok_or_else(damaged)?;
        if u32::from_le_bytes(*sum) != crc32fast::hash(body) {
            return Err(damaged());
        }
        let record: Self = rmp_serde::from_slice(body).map_err(|_| damaged())?;
        if record.version != VERSION || record.segments.is_empty() {
            return Err(named(
                Error::unsupported(format!("the record of a scene is of version {}", record.version))
                    .advise("take the Relievo that wrote it"),
            ));
        }
        Ok(record)
    }

    /// Reads the records in a folder. Records that cannot be read are left out, with a word in the log.
    pub fn all(folder: &Path) -> Result<Vec<Self>> {
        let failed = |error: std::io::Error| Error::io(folder, &error);
        std::fs::create_dir_all(folder).map_err(failed)?;
        let mut records = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.extension().is_none_or(|extension| extension != "scene") {
                continue;
            }
            match Self::load(&path) {
                Ok(record) => records.push(record),
                Err(error) => tracing::warn!(%error, "left out a scene"),
            }
        }
        Ok(records)
    }
}
