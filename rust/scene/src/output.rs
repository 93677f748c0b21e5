//! Files below the output folder: written under a temporary name beside their place and renamed when whole.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};

/// Writes the file at `path` with `write`; it appears only when that succeeded.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>) -> Result<()> {
    let failed = |error: &std::io::Error| Error::io(path, error);
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut temporary = tempfile::Builder::new()
        .prefix(".relievo-")
        .permissions_like_new()
        .tempfile_in(folder)
        .map_err(|error| failed(&error))?;
    {
        let mut out = BufWriter::new(temporary.as_file_mut());
        write(&mut out).map_err(|error| failed(&error))?;
        std::io::Write::flush(&mut out).map_err(|error| failed(&error))?;
    }
    temporary.persist(path).map_err(|error| failed(&error.error))?;
    Ok(())
}

trait Permissions {
    /// Asks for the permissions that a newly made file has, not for those of a private temporary one.
    fn permissions_like_new(&mut self) -> &mut Self;
}

impl Permissions for tempfile::Builder<'_, '_> {
    #[cfg(unix)]
    fn permissions_like_new(&mut self) -> &mut Self {
        use std::os::unix::fs::PermissionsExt;
        self.permissions(std::fs::Permissions::from_mode(0o666))
    }

    #[cfg(not(unix))]
    fn permissions_like_new(&mut self) -> &mut Self {
        self
    }
}

/// A folder that results go to.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder at `path`, which is made if it is missing.
    pub fn new(path: &Path) -> Result<Self> {
        std::fs::create_dir_all(path).map_err(|error| Error::io(path, &error))?;
        Ok(Self { path: path.to_path_buf() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder called `name` in this one, which is made if it is missing.
    pub fn sub(&self, name: &str) -> Result<Self> {
        Self::new(&self.path.join(name))
    }

    /// The file called `name` in this one. Only the last part of `name` counts, so that it cannot lead elsewhere.
    pub fn file(&self, name: &str) -> PathBuf {
        let plain: String = name
            .chars()
            .map(|letter| if letter == '/' || letter == '\\' || letter == ':' { '_' } else { letter })
            .collect();
        self.path.join(plain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, |out| out.write_all(b"old")).unwrap();
        let fail = |out: &mut BufWriter<&mut File>| {
            out.write_all(b"new")?;
            Err(std::io::Error::other("full"))
        };
        assert!(write_whole(&path, fail).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn names_cannot_leave_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let out = Folder::new(&folder.path().join("out")).unwrap();
        assert_eq!(out.file("../../a.png").parent(), Some(out.path()));
    }
}
