//! Files of frames in a folder: `0012.ply`, and with sub-frames `0012.250.ply`.

use std::fmt;
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};

use crate::Format;

/// Which frame, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FrameNumber(pub u64);

impl fmt::Display for FrameNumber {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 % 1000 {
            0 => write!(out, "{}", self.0 / 1000),
            part => write!(out, "{}.{part:03}", self.0 / 1000),
        }
    }
}

impl FrameNumber {
    /// That of step `step`, where frames have `parts` steps each: at most 1,000.
    pub fn of_step(step: u64, parts: u32) -> Self {
        Self(step * 1000 / u64::from(parts.max(1)))
    }

    /// The number in the name of a file, if it is one of a frame.
    fn of(path: &Path) -> Option<Self> {
        let stem = path.file_stem()?.to_str()?;
        let (whole, part) = stem.split_once('.').unwrap_or((stem, "000"));
        let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(whole) || !digits(part) || whole.len() > 9 || part.len() != 3 {
            return None;
        }
        Some(Self(whole.parse::<u64>().ok()? * 1000 + part.parse::<u64>().ok()?))
    }
}

/// The file in `folder` of step `step`, where frames have `parts` steps each: at most 1,000.
pub fn path(folder: &Path, step: u64, parts: u32, format: Format) -> PathBuf {
    let FrameNumber(number) = FrameNumber::of_step(step, parts);
    let (frame, part, extension) = (number / 1000, number % 1000, format.extension());
    folder.join(match parts {
        0 | 1 => format!("{frame:04}.{extension}"),
        _ => format!("{frame:04}.{part:03}.{extension}"),
    })
}

/// The frames in `folder` of formats that can be written, in order.
///
/// # Errors
/// The folder cannot be read.
pub fn frames(folder: &Path) -> Result<Vec<(FrameNumber, PathBuf)>> {
    let failed = |error: std::io::Error| Error::io(folder, &error);
    let mut list = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if let (Some(number), Ok(_)) = (FrameNumber::of(&path), Format::named(&path)) {
            list.push((number, path));
        }
    }
    list.sort();
    Ok(list)
}
