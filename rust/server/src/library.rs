//! Files that users sent: meshes and grids of their scenes, by content hash, and accelerations by hosts.
//!
//! Each user has a folder, so that nobody can use or detect the files of another. The names that descriptions give to files
//! never become paths: they are looked up in the list that came with the scene.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use relievo_client::{FileMap, FilePut, Hash, Hasher, MAX_PART};
use relievo_core::{Context, Error, ErrorKind, Mesh, Result};
use relievo_simulation::Files;

/// Formats whose readers open no other files.
const EXTENSIONS: [&str; 5] = ["obj", "ply", "stl", "vdb", "vtk"];
/// What files begin with whose readers open other files, whatever their names say: glTF, USD and archives of it.
const REFUSED: [&[u8]; 5] = [b"glTF", b"{", b"#usda", b"PXR-USDC", b"PK"];
/// The extension of accelerations.
const FORCES: &str = "forces";
/// Files of a user that may be on their way at the same time; the oldest is given up for a new one.
const UNFINISHED: usize = 8;

/// The files of all users.
pub struct Library {
    folder: PathBuf,
    unfinished: PathBuf,
    limit: u64,
    uploads: Mutex<Vec<Upload>>,
}

/// A file on its way.
struct Upload {
    user: String,
    hash: Hash,
    extension: String,
    size: u64,
    received: u64,
    hasher: Hasher,
    file: File,
    path: PathBuf,
}

fn extension(name: &str) -> Result<String> {
    let extension = Path::new(name).extension().and_then(|it| it.to_str()).unwrap_or_default().to_ascii_lowercase();
    match EXTENSIONS.contains(&extension.as_str()) {
        true => Ok(extension),
        false => Err(Error::unsupported(format!("the server takes no files with the extension {extension:?}"))
            .at(name)
            .advise(format!("convert it to one of {}", EXTENSIONS.join(", ")))),
    }
}

impl Library {
    /// Opens the library in the folder of a cache. A user may have files of `limit` bytes.
    pub fn open(cache: &Path, limit: u64) -> Result<Self> {
        let [folder, unfinished] = ["files", "unfinished"].map(|name| cache.join(name));
        std::fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, &error))?;
        Ok(Self { folder, unfinished, limit, uploads: Mutex::default() })
    }

    fn folder(&self, user: &str) -> PathBuf {
        self.folder.join(Hash::of(user.as_bytes()).to_string())
    }

    fn path(&self, user: &str, hash: Hash, extension: &str) -> PathBuf {
        self.folder(user).join(format!("{hash}.{extension}"))
    }

    /// Returns the files that the user has not sent yet.
    pub fn missing(&self, user: &str, files: &FileMap) -> Result<FileMap> {
        let mut missing = FileMap::new();
        for (name, hash) in files {
            if !self.path(user, *hash, &extension(name)?).is_file() {
                missing.insert(name.clone(), *hash);
            }
        }
        Ok(missing)
    }

    /// Returns the bytes of the user's files.
    fn size(&self, user: &str) -> u64 {
        let Ok(entries) = std::fs::read_dir(self.folder(user)) else { return 0 };
        entries.filter_map(|entry| entry.ok()?.metadata().ok()).map(|metadata| metadata.len()).sum()
    }

    /// Takes a part of a file. Returns how many bytes of it are there; a part that begins elsewhere is left out. Fails
    /// where the user has too many bytes, or the whole is not what its hash says.
    pub fn put(&self, user: &str, put: &FilePut) -> Result<u64> {
        let FilePut { name, hash, size, offset, data } = put;
        let extension = extension(name)?;
        if self.path(user, *hash, &extension).is_file() {
            return Ok(*size);
        }
        if data.len() > MAX_PART || offset.saturating_add(data.len() as u64) > *size {
            return Err(Error::invalid("a part is too long, or reaches beyond the end of its file").at(name));
        }
        let mut uploads = self.uploads.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same =
            |it: &Upload| it.user == user && it.hash == *hash && it.extension == extension && it.size == *size;
        let mut upload = match uploads.iter().position(is_same) {
            Some(at) => uploads.remove(at),
            None => {
                let on_their_way: u64 = uploads.iter().filter(|it| it.user == user).map(|it| it.size).sum();
                let all = self.size(user).saturating_add(on_their_way).saturating_add(*size);
                if all > self.limit {
                    return Err(Error::memory(format!("the files of a user may have {} bytes in all", self.limit))
                        .at(name)
                        .advise("remove scenes, or send smaller meshes"));
                }
                while uploads.iter().filter(|it| it.user == user).count() >= UNFINISHED {
                    if let Some(oldest) = uploads.iter().position(|it| it.user == user) {
                        uploads.remove(oldest).give_up();
                    }
                }
                let stem = Hash::of(user.as_bytes());
                let path = self.unfinished.join(format!("{stem}-{hash}.{extension}"));
                let file = File::create(&path).map_err(|error| Error::io(&path, &error))?;
                let (user, hasher) = (user.to_owned(), Hasher::default());
                Upload { user, hash: *hash, extension, size: *size, received: 0, hasher, file, path }
            }
        };
        if *offset == upload.received {
            if *offset == 0 && REFUSED.iter().any(|head| data.trim_ascii_start().starts_with(head)) {
                upload.give_up();
                return Err(Error::unsupported("the server takes no glTF and USD, which may name other files")
                    .at(name)
                    .advise("convert it to PLY"));
            }
            let path = upload.path.clone();
            if let Err(error) = upload.file.write_all(data) {
                upload.give_up();
                return Err(Error::io(&path, &error));
            }
            upload.hasher.add(data);
            upload.received += data.len() as u64;
        }
        let received = upload.received;
        if received < upload.size {
            uploads.push(upload);
            return Ok(received);
        }
        drop(uploads);
        self.finish(upload).map(|()| received).map_err(|error| error.at(name))
    }

    fn finish(&self, upload: Upload) -> Result<()> {
        let Upload { user, hash, extension, hasher, file, path, .. } = upload;
        if hasher.finish() != hash {
            let _ = std::fs::remove_file(&path);
            return Err(Error::invalid("the content is not what its hash says").advise("send the file again"));
        }
        let to = self.path(&user, hash, &extension);
        let folder = self.folder(&user);
        let failed = |error: std::io::Error| Error::io(&to, &error);
        std::fs::create_dir_all(&folder).map_err(failed)?;
        file.sync_all().and_then(|()| std::fs::rename(&path, &to)).map_err(failed)
    }

    /// Stores accelerations, and returns their hash.
    pub fn put_forces(&self, user: &str, bytes: &[u8]) -> Result<Hash> {
        let hash = Hash::of(bytes);
        if self.size(user).saturating_add(bytes.len() as u64) > self.limit {
            return Err(Error::memory(format!("the files of a user may have {} bytes in all", self.limit)));
        }
        let path = self.path(user, hash, FORCES);
        std::fs::create_dir_all(self.folder(user)).map_err(|error| Error::io(&path, &error))?;
        relievo_core::file::store(&path, |out| out.write_all(bytes))?;
        Ok(hash)
    }

    /// Returns accelerations by their hash.
    pub fn forces(&self, user: &str, hash: Hash) -> Result<Vec<[f32; 3]>> {
        let bytes = relievo_core::file::load(&self.path(user, hash, FORCES), u64::MAX)?;
        let vector =
            |bytes: &[u8; 12]| [0, 4, 8].map(|at| f32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[at + byte])));
        Ok(bytes.as_chunks::<12>().0.iter().map(vector).collect())
    }

    /// Returns the files of a scene.
    pub fn files(&self, user: &str, files: &FileMap) -> Result<SceneFiles> {
        let path = |(name, hash): (&String, &Hash)| Ok((name.clone(), self.path(user, *hash, &extension(name)?)));
        Ok(SceneFiles(files.iter().map(path).collect::<Result<_>>()?))
    }

    /// Removes those of a user's files that no scene of the user names any more.
    pub fn remove(&self, user: &str, files: &FileMap, forces: &[Hash]) {
        for (name, hash) in files {
            if let Ok(extension) = extension(name) {
                let _ = std::fs::remove_file(self.path(user, *hash, &extension));
            }
        }
        for hash in forces {
            let _ = std::fs::remove_file(self.path(user, *hash, FORCES));
        }
    }
}

impl Upload {
    fn give_up(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The paths of a scene's files by the names that its description gives them.
#[derive(Debug)]
pub struct SceneFiles(BTreeMap<String, PathBuf>);

impl Files for SceneFiles {
    fn path(&self, name: &Path) -> Result<PathBuf> {
        let named = name.to_str().and_then(|name| self.0.get(name));
        let missing = || {
            Error::new(ErrorKind::NotFound, "the description names a file that did not come with the scene")
                .at(name.display().to_string())
                .advise("send it by `file.put`, and list it in `files` of `scene.submit`")
        };
        named.filter(|path| path.is_file()).cloned().ok_or_else(missing)
    }

    fn displaced(&self, _: &Context, document: &Path, _: &Mesh, _: (Option<&str>, u32)) -> Result<Mesh> {
        Err(Error::unsupported("the server displaces no meshes by documents")
            .at(document.display().to_string())
            .advise("write the displaced mesh by `relievo doc export`, and name that"))
    }
}
