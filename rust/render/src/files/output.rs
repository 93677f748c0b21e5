//! Files are written under a temporary name beside their place and renamed when complete, so that nobody ever finds
//! half a file, and an older file survives a failure.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use relievo_core::{Error, Result};

/// Writes the file `path` by `write`.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file: the process's mask takes away from it.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder).map_err(|error| Error::io(path, &error))?;
    let (file, temporary) = file.into_parts();
    let mut writer = BufWriter::new(file);
    write(&mut writer).map_err(|error| error.at(path.display().to_string()))?;
    writer.into_inner().map_err(|error| Error::io(path, error.error()))?;
    temporary.persist(path).map_err(|error| Error::io(path, &error.error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let put = |text: &'static str, end: Result<()>| {
            replace(&path, |file| {
                file.write_all(text.as_bytes()).unwrap();
                end
            })
        };
        put("first", Ok(())).unwrap();
        let error = put("second", Err(Error::invalid("no"))).unwrap_err();
        assert!(error.to_string().contains("file: no"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let lost = replace(&folder.path().join("none/file"), |_| Ok(())).unwrap_err().to_string();
        assert!(lost.contains("none/file") && !lost.contains(".relievo-"), "{lost}");
    }
}
