//! Whole files in and out: bounded reads, and writes that appear under their name only when complete.

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use crate::{Error, Result};

/// Opens the file at `path` for reading.
///
/// # Errors
/// Fails with `Invalid` if it is not a file: a pipe or device could wait or go on for ever. Fails with `NotFound` or
/// `Io` if the system does not find or open it.
pub fn open(path: &Path) -> Result<File> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    // It is not even opened.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::invalid("it is not a file").at(path.display().to_string()).advise("name a file"));
    }
    File::open(path).map_err(failed)
}

/// A file without a name, which is gone when it is closed.
///
/// # Errors
/// Fails with `NotFound` or `Io` if the folder for temporary files does not exist or takes no file.
pub fn temporary() -> Result<File> {
    let failed = |error: std::io::Error| Error::io(&std::env::temp_dir(), &error);
    tempfile::tempfile().map_err(|error| failed(error).advise("check the folder for temporary files and its space"))
}

/// As [`temporary`], in `folder`.
///
/// # Errors
/// Fails with `NotFound` or `Io` if `folder` does not exist or takes no file.
pub fn temporary_in(folder: &Path) -> Result<File> {
    tempfile::tempfile_in(folder).map_err(|error| Error::io(folder, &error).advise("check the folder and its space"))
}

/// The bytes of the file at `path`.
///
/// # Errors
/// Fails with `Invalid` if it is not a file, with `Memory` if it has more than `limit` bytes or the system has no room
/// for them, and with `NotFound` or `Io` if it does not exist or cannot be read.
pub fn load(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    let named = |error: Error| error.at(path.display().to_string());
    // A pipe or device could wait or go on for ever, even when it is only opened.
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(named(Error::invalid("it is not a file").advise("name a file")));
    }
    let file = File::open(path).map_err(failed)?;
    let too_large = || {
        named(Error::memory(format!("the file is larger than the memory limit of {limit} bytes")))
            .advise("raise the memory limit, or split the file")
    };
    if metadata.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(metadata.len()).map_err(|_| too_large())?;
    bytes.try_reserve_exact(length).map_err(|_| too_large())?;
    // The file may grow while it is read.
    file.take(metadata.len()).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Makes the file at `path` from what `write` writes. It appears under its name when it is complete; until then it
/// has another name in the same folder, and after an error it is gone. A file that is replaced leaves its permissions, and
/// of a symbolic link the file that it names is replaced.
///
/// # Errors
/// Fails with `NotFound` or `Io` if the folder takes no new file, `write` returns an error, or the file cannot be
/// renamed.
pub fn store(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>) -> Result<()> {
    let failed = |error: std::io::Error| Error::io(path, &error).advise("check the folder, its rights and its space");
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let replaced = std::fs::metadata(&target).ok().filter(std::fs::Metadata::is_file);
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-");
    #[cfg(unix)]
    {
        // As any new file, not only for its owner; the process's mask still applies.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.tempfile_in(folder).map_err(failed)?;
    let mut out = BufWriter::with_capacity(1 << 18, temporary.as_file_mut());
    write(&mut out).and_then(|()| out.flush()).map_err(failed)?;
    drop(out);
    if let Some(replaced) = replaced {
        temporary.as_file().set_permissions(replaced.permissions()).map_err(failed)?;
    }
    temporary.persist(&target).map(drop).map_err(|error| failed(error.error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["a.bin", "b.bin"].map(|name| folder.path().join(name));
        std::fs::write(&file, b"old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink("a.bin", &link).unwrap();
        store(&link, |out| out.write_all(b"new")).unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        store(&path, |out| out.write_all(b"old")).unwrap();
        let error = store(&path, |out| {
            out.write_all(b"new")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(error.unwrap_err().to_string().contains("disk full"));
        assert_eq!(load(&path, 100).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(load(&path, 2).unwrap_err().kind, crate::ErrorKind::Memory);
        assert!(load(folder.path(), 100).is_err());
        let lost = store(&folder.path().join("none/b.bin"), |_| Ok(())).unwrap_err().to_string();
        assert!(lost.contains("b.bin: ") && !lost.contains(".relievo-"), "{lost}");
    }
}
