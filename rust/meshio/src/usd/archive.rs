//! Archives of USD (`.usdz`): zip files without compression, whose first file is the root layer (specification of USDZ,
//! "Zip Constraints").

use relievo_core::{Error, Result};

/// The first bytes of an archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// Bytes before the name of a file in an archive.
const HEAD: usize = 30;

/// Returns the root layer of an archive. Files that it names within the archive are not opened.
///
/// # Errors
/// The archive ends too early, its first file is packed, or that is no layer.
pub(super) fn root_layer(mut bytes: Vec<u8>) -> Result<Vec<u8>> {
    let damaged = || Error::invalid("the archive (.usdz) is damaged").advise("pack it again, by usdzip");
    let half = |at: usize| bytes.get(at..at + 2).map(|half| usize::from(u16::from_le_bytes([half[0], half[1]])));
    let (flags, method) = (half(6).ok_or_else(damaged)?, half(8).ok_or_else(damaged)?);
    let [name, extra] = [26, 28].map(half);
    let (name, extra) = (name.ok_or_else(damaged)?, extra.ok_or_else(damaged)?);
    let length = half(18).zip(half(20)).map(|(low, high)| low | high << 16).ok_or_else(damaged)?;
    if method != 0 || flags & 0b1001 != 0 {
        return Err(Error::unsupported("files of the archive (.usdz) are packed or encrypted, which USD rules out")
            .advise("pack it again, by usdzip"));
    }
    let label = String::from_utf8_lossy(bytes.get(HEAD..HEAD + name).ok_or_else(damaged)?).to_ascii_lowercase();
    if ![".usd", ".usda", ".usdc"].iter().any(|extension| label.ends_with(extension)) {
        return Err(Error::invalid(format!("the archive (.usdz) begins with {label:?}, which is no layer"))
            .advise("pack it again, by usdzip"));
    }
    let start = HEAD + name + extra;
    let end = start.checked_add(length).filter(|end| *end <= bytes.len()).ok_or_else(damaged)?;
    bytes.truncate(end);
    bytes.drain(..start);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An archive with one file, whose name is `label`.
    fn archive(label: &str, method: u16, file: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([10, 0, 0, 0]);
        bytes.extend(method.to_le_bytes());
        bytes.extend([0; 8]);
        bytes.extend([(file.len() as u32).to_le_bytes(); 2].as_flattened());
        bytes.extend((label.len() as u16).to_le_bytes());
        bytes.extend(3u16.to_le_bytes());
        bytes.extend(label.as_bytes());
        bytes.extend([9; 3]);
        bytes.extend(file);
        bytes.extend(b"PK\x01\x02 and so on");
        bytes
    }

    #[test]
    fn the_first_file_is_the_root_layer() {
        assert_eq!(root_layer(archive("a.usda", 0, b"#usda 1.0\n")).unwrap(), b"#usda 1.0\n");
        assert!(root_layer(archive("a.usda", 8, b"#usda 1.0\n")).unwrap_err().what.contains("packed"));
        assert!(root_layer(archive("a.png", 0, b"#usda 1.0\n")).unwrap_err().what.contains("a.png"));
        let whole = archive("a.usda", 0, b"#usda 1.0\n");
        for length in 0..whole.len() - 18 {
            assert!(root_layer(whole[..length].to_vec()).is_err(), "{length}");
        }
    }
}
