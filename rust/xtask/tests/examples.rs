//! Examples in doc comments run: a crate whose manifest turns its doc tests off, which saves a run of rustdoc, has none.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the Rust files under a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.expect("entries of folders can be read").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found
}

/// Returns the line of the first example of Rust in doc comments.
fn example(text: &str) -> Option<usize> {
    let mut is_open = false;
    for (line, number) in text.lines().zip(1..) {
        let line = line.trim_start();
        let comment = ["///", "//!"].iter().find_map(|mark| line.strip_prefix(mark));
        let Some(language) = comment.and_then(|comment| comment.trim().strip_prefix("```")) else { continue };
        if !is_open && !["text", "toml", "json", "sh", "c"].contains(&language) {
            return Some(number);
        }
        is_open = !is_open;
    }
    None
}

#[test]
fn crates_without_doc_tests_have_no_examples() {
    let mut silent = 0;
    for folder in ["rust", "rust/native"] {
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let folder = entry.unwrap().path();
            let Ok(manifest) = fs::read_to_string(folder.join("Cargo.toml")) else { continue };
            if !manifest.lines().any(|line| line.trim() == "doctest = false") {
                continue;
            }
            silent += 1;
            for source in sources(&folder.join("src")) {
                let line = example(&fs::read_to_string(&source).unwrap());
                assert!(line.is_none(), "{}: the example in line {line:?} would not run", source.display());
            }
        }
    }
    assert_eq!(example("//! ```text\n//! a\n//! ```\n/// ```\n/// f();\n/// ```\n"), Some(4));
    assert!(silent > 20, "{silent} crates without doc tests");
}
