//! Which files a scene may refer to: those below its own folder, and below folders the user allowed.

use std::path::{Path, PathBuf};

use relievo_core::error::nearest;
use relievo_core::{Error, ErrorKind, Result};
use relievo_meshio::Root;

/// Resolves paths of a scene file.
#[derive(Clone, Debug)]
pub struct Paths {
    folder: PathBuf,
    root: Root,
}

impl Paths {
    /// Paths of the scene file at `scene`, which may also lead below the folders `allowed`.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if one of these folders does not exist or cannot be reached.
    pub fn new(scene: &Path, allowed: &[PathBuf]) -> Result<Self> {
        let folder = scene.parent().unwrap_or(Path::new("")).to_path_buf();
        let root = allowed.iter().try_fold(Root::below(&folder)?, |root, folder| root.allow(folder))?;
        Ok(Self { folder, root })
    }

    /// What files that the scene's files name may be opened.
    pub fn root(&self) -> &Root {
        &self.root
    }

    /// The file that the scene calls `written`.
    ///
    /// # Errors
    /// Fails with `NotFound` if it is missing, with `Invalid` if it lies elsewhere (links are followed first) or is an
    /// address of the network, and with `Io` if it cannot be reached.
    pub fn resolve(&self, written: &str) -> Result<PathBuf> {
        self.root.resolve(&self.folder, written).map_err(|error| match error.kind {
            ErrorKind::NotFound => {
                let missing = Error::new(ErrorKind::NotFound, format!("there is no file `{written}`"));
                match similar(&self.folder.join(written)) {
                    Some(near) => missing.advise(format!("did you mean `{near}`?")),
                    None => missing.advise("paths are relative to the scene file"),
                }
            }
            ErrorKind::Invalid => {
                error.advise("move it below the scene's folder, or allow its folder with --allow-path")
            }
            _ => error,
        })
    }
}

/// A file beside `path` with a similar name.
fn similar(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let entries = std::fs::read_dir(path.parent()?).ok()?;
    let mut names: Vec<String> =
        entries.take(1000).filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    nearest(name, names.iter().map(String::as_str)).map(str::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_below_the_scene_and_allowed_folders_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let other = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        std::fs::write(folder.path().join("sub/mesh.obj"), "").unwrap();
        std::fs::write(other.path().join("secret.obj"), "").unwrap();
        let scene = folder.path().join("scene.toml");
        let paths = Paths::new(&scene, &[]).unwrap();
        assert!(paths.resolve("sub/mesh.obj").is_ok());
        assert!(paths.resolve("sub/../sub/mesh.obj").is_ok());
        let secret = other.path().join("secret.obj");
        let secret = secret.to_str().unwrap();
        for escape in [secret, "../x.obj", "sub/../../x.obj", "/etc/passwd", "../../../../../../../../../etc/passwd"] {
            let message = paths.resolve(escape).unwrap_err().to_string();
            assert!(message.contains("--allow-path"), "{escape}: {message}");
        }
        assert!(paths.resolve("http://a/b.obj").unwrap_err().to_string().contains("nothing is fetched"));
        assert!(paths.resolve("sub/mash.obj").unwrap_err().to_string().contains("did you mean `mesh.obj`"));
        let wide = Paths::new(&scene, &[other.path().to_path_buf()]).unwrap();
        assert!(wide.resolve(secret).is_ok());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(secret, folder.path().join("link.obj")).unwrap();
            assert!(paths.resolve("link.obj").is_err());
            assert!(wide.resolve("link.obj").is_ok());
        }
    }
}
