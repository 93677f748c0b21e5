//! Where the files of a scene go.

use std::path::{Path, PathBuf};

/// Returns the folder that is named after a scene.
pub fn folder_of(scene: &Path) -> PathBuf {
    let mut name = scene.file_stem().unwrap_or_default().to_os_string();
    name.push("-out");
    PathBuf::from(name)
}
