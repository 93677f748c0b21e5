//! Frames of foam beside the baked frames of a scene: `cache/foam/OBJECT-FRAME.rlvfluid`, each with what a run goes on from.
//!
//! A frame says what it is of: the settings, the scale and speed of the scene, the instruction level, and a checksum of the
//! beginnings of all files of the fluid up to it. A frame of anything else is not taken.

use std::io::Read;
use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, ErrorKind, Result, file};
use relievo_fluid::{Diffuse, DiffuseOptions};
use relievo_particleio::{EXTENSION, read_frame, write_frame};

use crate::out::output::Folder;

/// Bytes from the beginning of a file that say whether it is the same as before: caches have their checksums there.
const HEAD: u64 = 1 << 16;
/// The folder of the frames in the cache of a scene.
const FOLDER: &str = "foam";

/// What a run of foam is of: its settings, and the files of the fluid one after the other.
#[derive(Clone, Debug)]
pub struct Identity {
    settings: String,
    checksum: u32,
}

impl Identity {
    /// Begins before the first file, with all that decides the particles besides the files.
    pub fn new(settings: String) -> Self {
        Self { settings, checksum: 0 }
    }

    /// Adds the next file of the fluid and returns what the run is of up to it.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be read, and with `Invalid` if it is a folder, pipe or device.
    pub fn add(&mut self, path: &Path) -> Result<String> {
        let failed = |error: std::io::Error| Error::io(path, &error);
        let opened = file::open(path)?;
        let length = opened.metadata().map_err(failed)?.len();
        let mut head = Vec::new();
        opened.take(HEAD).read_to_end(&mut head).map_err(failed)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{} {name} {length} {}", self.checksum, crc32fast::hash(&head));
        self.checksum = crc32fast::hash(text.as_bytes());
        Ok(format!("{}, of {:08x}", self.settings, self.checksum))
    }
}

/// A cached frame as it was found.
pub(super) enum Found {
    /// There is none.
    Absent,
    /// It is of other settings or of another fluid.
    Stale,
    /// It is damaged, which the error says.
    Damaged(Error),
    /// The run after the frame.
    Run(Box<Diffuse>),
}

/// The cached frames of the foam of an object.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    folder: Folder,
    object: String,
}

impl Cache {
    /// Makes the folder for the frames of an object in the cache of a scene.
    pub fn new(cache: &Folder, object: &str) -> Result<Self> {
        Ok(Self { folder: cache.sub(FOLDER)?, object: object.to_owned() })
    }

    fn path(&self, frame: usize) -> PathBuf {
        self.folder.file(&format!("{}-{frame:06}.{EXTENSION}", self.object))
    }

    /// Writes a frame at a time in seconds. It appears when it is complete.
    pub fn store(&self, context: &Context, (frame, time): (usize, f64), run: &Diffuse, identity: &str) -> Result<()> {
        let particles = run.particles().to_file(time, run.options().spacing)?;
        write_frame(context, &self.path(frame), &particles, Some(&run.state(identity)))
    }

    /// Opens a frame. Fails where the system does not let it be read, or it exceeds the memory limit.
    pub fn open(&self, context: &Context, options: DiffuseOptions, frame: usize, identity: &str) -> Result<Found> {
        let path = self.path(frame);
        if !path.exists() {
            return Ok(Found::Absent);
        }
        let bytes = file::load(&path, context.memory_limit())?;
        let resumed = read_frame(context, &bytes).and_then(|frame| Diffuse::resume(options, &frame));
        match resumed {
            Ok(Some((found, run))) if found == identity && run.progress().0 == frame as u64 => {
                Ok(Found::Run(Box::new(run)))
            }
            Ok(_) => Ok(Found::Stale),
            Err(error) if error.kind == ErrorKind::Memory => Err(error.at(path.display().to_string())),
            Err(error) => Ok(Found::Damaged(error.at(path.display().to_string()))),
        }
    }
}

/// Removes the frames from `first` on of all objects from the cache of a scene.
pub(crate) fn truncate(cache: &Folder, first: u32) -> Result<()> {
    let folder = cache.path().join(FOLDER);
    let failed = |error: std::io::Error| Error::io(&folder, &error);
    if !folder.exists() {
        return Ok(());
    }
    for entry in std::fs::read_dir(&folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let is_frame = path.extension().is_some_and(|extension| extension == EXTENSION);
        let number = stem.rsplit_once('-').and_then(|(_, number)| number.parse::<u32>().ok());
        if is_frame && number.is_some_and(|number| number >= first) {
            std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
        }
    }
    Ok(())
}
