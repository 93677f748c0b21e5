//! Files and folders that are put together for packages.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::paths;
use crate::stage::{Outcome, call};

/// Removes a folder with all that is in it, if it is there.
pub fn remove(folder: &Path) -> Outcome {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(format!("{}: {error}", folder.display())),
        _ => Ok(()),
    }
}

/// Copies a file, with the folder it goes to.
pub fn copy(from: &Path, to: &Path) -> Outcome {
    let made = to.parent().map_or(Ok(()), std::fs::create_dir_all);
    made.and_then(|()| std::fs::copy(from, to)).map(|_| ()).map_err(|error| format!("{}: {error}", from.display()))
}

/// Copies the files of a folder, without folders in it.
pub fn copy_files(from: &Path, to: &Path) -> Outcome {
    let entries = std::fs::read_dir(from).map_err(|error| format!("{}: {error}", from.display()))?;
    for path in entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()) {
        copy(&path, &to.join(path.file_name().unwrap_or_default()))?;
    }
    Ok(())
}

/// Copies an executable or a library without what only debuggers read, and without the names of folders of this machine.
pub fn strip(from: &Path, to: &Path) -> Outcome {
    copy(from, to)?;
    call(Command::new("strip").arg("--strip-unneeded").arg(to))?;
    paths::hide(to)
}

/// The file of a folder that has one.
pub fn only_file(folder: &Path) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    match files.pop() {
        Some(file) if files.is_empty() => Ok(file),
        _ => Err(format!("{}: one file was to be there", folder.display())),
    }
}
