//! Which files outside references may reach: those below given folders, after links are followed.

use std::path::{Component, Path, PathBuf};

use relievo_core::{Error, Result};

/// The folders below which files may be opened.
#[derive(Clone, Debug, Default)]
pub struct Root {
    folders: Vec<PathBuf>,
}

impl Root {
    /// No file may be opened.
    pub fn none() -> Self {
        Self::default()
    }

    /// Files below `folder`.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if `folder` does not exist or cannot be reached.
    pub fn below(folder: &Path) -> Result<Self> {
        Self::none().allow(folder)
    }

    /// Also files below `folder`.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if `folder` does not exist or cannot be reached.
    pub fn allow(mut self, folder: &Path) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        self.folders.push(folder.canonicalize().map_err(|error| Error::io(folder, &error))?);
        // Also as it is written, so that names which go through the same links are recognised.
        let here = std::env::current_dir().map_err(|error| Error::io(folder, &error))?;
        self.folders.extend(joined(&here, folder));
        Ok(self)
    }

    /// The path of the existing file that `name` means when it is written in a file of folder `base`.
    ///
    /// # Errors
    /// Fails with `Invalid` for addresses of the network, and for paths that lead out of the folders, by `..`, by a
    /// link, or because they are absolute, and with `NotFound` or `Io` if the file does not exist or cannot be reached.
    pub fn resolve(&self, base: &Path, name: &str) -> Result<PathBuf> {
        let refuse = |what: &str| {
            Error::invalid(format!("{name:?} {what}"))
                .advise("put the file below the folder of the one that names it, or allow its folder")
        };
        if scheme(name).is_some() {
            return Err(refuse("is not a file; nothing is fetched"));
        }
        if name.is_empty() || name.contains('\0') {
            return Err(refuse("is no name of a file"));
        }
        let base = if base.as_os_str().is_empty() { Path::new(".") } else { base };
        let base = base.canonicalize().map_err(|error| Error::io(base, &error))?;
        let outside = || refuse("is outside the folders that may be read");
        let within = |path: &Path| self.folders.iter().any(|folder| path.starts_with(folder));
        // First by its letters, so that nothing outside is even asked for; then with links followed.
        let path = joined(&base, Path::new(name)).ok_or_else(outside)?;
        if !within(&path) {
            return Err(outside());
        }
        let real = path.canonicalize().map_err(|error| Error::io(&path, &error))?;
        if within(&real) { Ok(real) } else { Err(outside()) }
    }
}

/// `name` seen from `base`, by its letters; `None` if it leads above the root.
fn joined(base: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = base.to_path_buf();
    for component in name.components() {
        match component {
            Component::Prefix(_) | Component::RootDir | Component::Normal(_) => path.push(component),
            Component::CurDir => {}
            Component::ParentDir => {
                if !path.pop() {
                    return None;
                }
            }
        }
    }
    Some(path)
}

/// The scheme of an address, such as `http` or `data`. One letter is a drive.
pub(crate) fn scheme(name: &str) -> Option<&str> {
    let (scheme, _) = name.split_once(':')?;
    let letters = scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.'));
    (scheme.len() > 1 && letters && scheme.starts_with(|first: char| first.is_ascii_alphabetic())).then_some(scheme)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_below_the_folders_are_reached() {
        let temporary = tempfile::tempdir().unwrap();
        let top = temporary.path().canonicalize().unwrap();
        let scene = top.join("scene");
        std::fs::create_dir_all(scene.join("deep")).unwrap();
        for file in ["secret", "scene/a.bin", "scene/deep/b.bin"] {
            std::fs::write(top.join(file), "x").unwrap();
        }
        let root = Root::below(&scene).unwrap();
        assert_eq!(root.resolve(&scene, "a.bin"), Ok(scene.join("a.bin")));
        assert_eq!(root.resolve(&scene, "./deep/b.bin"), Ok(scene.join("deep/b.bin")));
        assert_eq!(root.resolve(&scene.join("deep"), "../a.bin"), Ok(scene.join("a.bin")));
        let absolute = top.join("secret");
        let absolute = absolute.to_str().unwrap();
        for bad in ["../secret", "deep/../../secret", absolute, "http://x/a.bin", "file:a.bin", "", "a\0b", "none"] {
            assert!(root.resolve(&scene, bad).is_err(), "{bad}");
        }
        assert!(root.clone().allow(&top).unwrap().resolve(&scene, "../secret").is_ok());
        assert!(Root::none().resolve(&scene, "a.bin").is_err());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(top.join("secret"), scene.join("link")).unwrap();
            let message = root.resolve(&scene, "link").unwrap_err().to_string();
            assert!(message.contains("outside"), "{message}");
            // A folder that is allowed by the name of a link is reached by that name.
            std::os::unix::fs::symlink(&scene, top.join("alias")).unwrap();
            let alias = Root::below(&top.join("alias")).unwrap();
            let name = top.join("alias/a.bin");
            assert_eq!(alias.resolve(&top, name.to_str().unwrap()), Ok(scene.join("a.bin")));
        }
    }
}
