//! Files below the output folder, by names that cannot leave it.

use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};

/// A folder that results go to.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder at `path`, which is made if it is missing.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if it cannot be made.
    pub fn new(path: &Path) -> Result<Self> {
        std::fs::create_dir_all(path).map_err(|error| Error::io(path, &error))?;
        Ok(Self { path: path.to_path_buf() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder called `name` in this one, which is made if it is missing.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if it cannot be made.
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

    #[test]
    fn names_cannot_leave_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let out = Folder::new(&folder.path().join("out")).unwrap();
        assert_eq!(out.file("../../a.png").parent(), Some(out.path()));
    }
}
