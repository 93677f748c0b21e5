//! Which files a scene may refer to: those below its own folder, and below folders the user allowed.

use std::path::{Component, Path, PathBuf};

use relievo_core::error::nearest;
use relievo_core::{Error, ErrorKind, Result};

/// Resolves paths of a scene file.
#[derive(Clone, Debug)]
pub struct Paths {
    folder: PathBuf,
    allowed: Vec<PathBuf>,
}

impl Paths {
    /// Paths of the scene file at `scene`, which may also lead below the folders `allowed`. Fails if one of them does
    /// not exist.
    pub fn new(scene: &Path, allowed: &[PathBuf]) -> Result<Self> {
        let parent = scene.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let real = |folder: &Path| std::fs::canonicalize(folder).map_err(|error| Error::io(folder, &error));
        let folder = real(parent)?;
        let mut list = vec![folder.clone()];
        for path in allowed {
            list.push(real(path)?);
        }
        Ok(Self { folder, allowed: list })
    }

    /// The file that the scene calls `written`. Fails if it lies elsewhere (links are followed first) or is missing.
    pub fn resolve(&self, written: &str) -> Result<PathBuf> {
        if written.contains("://") {
            return Err(Error::invalid(format!("`{written}` is an address, and scenes fetch nothing"))
                .advise("download the file and name its path"));
        }
        let outside = || {
            Error::invalid(format!("`{written}` lies outside the scene's folder"))
                .advise("move it below the scene's folder, or allow its folder with --allow-path")
        };
        let path = lexical(&self.folder.join(written)).ok_or_else(outside)?;
        // Checked before the file system is asked, so that a scene cannot find out what exists elsewhere.
        if !self.contains(&path) && !self.allowed_by_link(&path) {
            return Err(outside());
        }
        let real = std::fs::canonicalize(&path).map_err(|error| {
            if error.kind() != std::io::ErrorKind::NotFound {
                return Error::io(&path, &error);
            }
            let missing = Error::new(ErrorKind::NotFound, format!("there is no file `{written}`"));
            match similar(&path) {
                Some(near) => missing.advise(format!("did you mean `{near}`?")),
                None => missing.advise("paths are relative to the scene file"),
            }
        })?;
        if !self.contains(&real) {
            return Err(outside());
        }
        Ok(real)
    }

    fn contains(&self, path: &Path) -> bool {
        self.allowed.iter().any(|folder| path.starts_with(folder))
    }

    /// Whether the folder of `path` is, by its real name, one of the allowed.
    fn allowed_by_link(&self, path: &Path) -> bool {
        path.parent().and_then(|parent| std::fs::canonicalize(parent).ok()).is_some_and(|parent| self.contains(&parent))
    }
}

/// `path` without `.` and `..`; `None` if it climbs above the root.
fn lexical(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                if !out.pop() {
                    return None;
                }
            }
            other => out.push(other),
        }
    }
    Some(out)
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

/// The file of a numbered sequence: `pattern` with its run of `#` replaced by `number`, padded with zeros.
pub fn numbered(pattern: &str, number: u64) -> String {
    let (Some(first), Some(last)) = (pattern.find('#'), pattern.rfind('#')) else { return pattern.to_string() };
    format!("{}{number:0width$}{}", &pattern[..first], &pattern[last + 1..], width = last + 1 - first)
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
        assert!(paths.resolve("http://a/b.obj").unwrap_err().to_string().contains("fetch nothing"));
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

    #[test]
    fn numbers_are_padded_to_the_run() {
        assert_eq!(numbered("a/walk.####.obj", 7), "a/walk.0007.obj");
        assert_eq!(numbered("#.ply", 123), "123.ply");
    }
}
