//! What a window keeps from one start to the next: the brush, how the view is drawn, and the size of the window.
//!
//! They are a small text in the user's folder for configurations: `RELIEVO_CONFIG/view.txt`, or
//! `$XDG_CONFIG_HOME/relievo/view.txt`, or `~/.config/relievo/view.txt`. A line is a name and a value. Lines that cannot be
//! read, as in a damaged file or one of a later version, leave what is there by default.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::PathBuf;

use relievo_core::{Error, Result};

/// The variable that names the folder of configurations.
const FOLDER: &str = "RELIEVO_CONFIG";

/// Bytes of the file at most.
const MAX: u64 = 1 << 16;

/// Names and values that a window keeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preferences {
    file: Option<PathBuf>,
    values: BTreeMap<String, String>,
}

impl Preferences {
    /// Reads the preferences of the user; no preferences without a file, or where it cannot be read. Scripts use the file
    /// of `RELIEVO_CONFIG` alone, so that they do the same for every user.
    pub fn load(is_scripted: bool) -> Self {
        let file = folder(is_scripted).map(|folder| folder.join("view.txt"));
        let bytes = file.as_ref().and_then(|file| relievo_core::file::load(file, MAX).ok()).unwrap_or_default();
        Self { file, values: parse(&String::from_utf8_lossy(&bytes)) }
    }

    /// Returns a value, if it is there and `read` takes it.
    pub(crate) fn get<T>(&self, name: &str, read: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        self.values.get(name).and_then(|value| read(value))
    }

    /// Returns a number within a range, if there is one.
    pub(crate) fn number(&self, name: &str, range: std::ops::RangeInclusive<f64>) -> Option<f64> {
        self.get(name, |text| text.parse().ok().filter(|value| range.contains(value)))
    }

    /// Returns whether something is on, if that is there.
    pub(crate) fn switch(&self, name: &str) -> Option<bool> {
        self.get(name, |text| text.parse().ok())
    }

    /// Sets a value.
    pub(crate) fn set(&mut self, name: &str, value: impl std::fmt::Display) {
        self.values.insert(name.to_owned(), value.to_string().replace(['\n', '\r'], " "));
    }

    /// Writes them.
    ///
    /// # Errors
    /// The folder cannot be made, or the file not be written.
    pub(crate) fn save(&self) -> Result<()> {
        let Some(file) = &self.file else { return Ok(()) };
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
        }
        relievo_core::file::store(file, |out| {
            self.values.iter().try_for_each(|(name, value)| writeln!(out, "{name} {value}"))
        })
    }
}

fn folder(is_scripted: bool) -> Option<PathBuf> {
    let named = |name: &str| std::env::var_os(name).filter(|it| !it.is_empty()).map(PathBuf::from);
    let own = named(FOLDER);
    if own.is_some() || is_scripted {
        return own;
    }
    let common = named("XDG_CONFIG_HOME").or_else(|| Some(named("HOME")?.join(".config")));
    common.map(|folder| folder.join("relievo"))
}

fn parse(text: &str) -> BTreeMap<String, String> {
    let line = |line: &str| {
        let (name, value) = line.trim().split_once(' ')?;
        Some((name.to_owned(), value.trim().to_owned()))
    };
    text.lines().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_damage_leaves_the_rest() {
        let folder = tempfile::tempdir().unwrap();
        let file = Some(folder.path().join("deep/view.txt"));
        let mut kept = Preferences { file: file.clone(), values: BTreeMap::new() };
        kept.set("brush.strength", 0.25);
        kept.set("view.rays", true);
        kept.set("brush.tool", "paint mix");
        kept.save().unwrap();
        let text = std::fs::read_to_string(file.as_ref().unwrap()).unwrap();
        assert_eq!(parse(&text), kept.values);
        assert_eq!(kept.number("brush.strength", 0.0..=1.0), Some(0.25));
        assert_eq!((kept.switch("view.rays"), kept.switch("brush.tool")), (Some(true), None));
        // Bytes that are no text, half a line and numbers out of range.
        let damaged = format!("\u{fffd}\u{0}\nbrush.strength 7\n{}", &text[..text.len() - 3]);
        let read = Preferences { file: None, values: parse(&damaged) };
        assert_eq!(read.get("brush.tool", |it| Some(it.to_owned())).as_deref(), Some("paint mix"));
        assert_eq!(read.number("brush.strength", 0.0..=1.0), Some(0.25));
        assert_eq!(read.switch("view.rays"), None);
        assert_eq!(
            Preferences { file: None, values: parse("brush.strength 7\n") }.number("brush.strength", 0.0..=1.0),
            None
        );
    }
}
