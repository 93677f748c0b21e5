//! The files that are written, or compared with what they should be.

use std::path::{Path, PathBuf};

/// Writes files, or compares them and remembers which differ.
pub struct Outputs {
    root: PathBuf,
    check: bool,
    different: Vec<String>,
}

impl Outputs {
    /// Files below `root`, compared instead of written if `check` is set.
    pub fn new(root: &Path, check: bool) -> Self {
        Self { root: root.to_owned(), check, different: Vec::new() }
    }

    /// Writes `text` to the file `name`, or compares it.
    pub fn put(&mut self, name: &str, text: &str) -> Result<(), String> {
        let path = self.root.join(name);
        let same = std::fs::read(&path).is_ok_and(|found| found == text.as_bytes());
        match (same, self.check) {
            (true, _) => println!("{name}: up to date"),
            (false, true) => {
                println!("{name}: differs from its headers");
                self.different.push(name.to_owned());
            }
            (false, false) => {
                std::fs::write(&path, text).map_err(|error| format!("{name}: {error}"))?;
                println!("{name}: written");
            }
        }
        Ok(())
    }

    /// Says that the file `name` is neither written nor compared, and why.
    pub fn skip(&mut self, name: &str, reason: &str) {
        println!("{name}: skipped, {reason}");
    }

    /// Fails if a compared file differed.
    pub fn finish(self) -> Result<(), String> {
        if self.different.is_empty() {
            return Ok(());
        }
        Err(format!("these files differ from their headers: {}; run `cargo xtask bindings`", self.different.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_written_or_named_with_the_command() {
        let folder = std::env::temp_dir().join(format!("relievo-bindings-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut written = Outputs::new(&folder, false);
        written.put("a.rs", "one\n").unwrap();
        written.finish().unwrap();
        let mut compared = Outputs::new(&folder, true);
        compared.put("a.rs", "one\n").unwrap();
        compared.put("a.rs", "two\n").unwrap();
        compared.put("missing.rs", "").unwrap();
        let error = compared.finish().unwrap_err();
        assert_eq!(error, "these files differ from their headers: a.rs, missing.rs; run `cargo xtask bindings`");
        assert_eq!(std::fs::read_to_string(folder.join("a.rs")).unwrap(), "one\n");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
