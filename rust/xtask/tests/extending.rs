//! The page on how to add something, and all other documents, name files and folders that exist.

use std::fs;
use std::path::{Path, PathBuf};

/// Placeholders of names, and a noun of the C ABI that stands for them.
const PLACEHOLDERS: [(&str, &str); 2] = [("NOUN", "collider"), ("SUBJECT", "details")];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns what stands between backticks in a text and is a path from the root: a name with a slash, or a file there.
fn paths(text: &str) -> Vec<&str> {
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|word| !word.contains(' ') && (word.contains('/') || word.ends_with(".md"))).collect()
}

/// Returns the path with a name in place of each placeholder.
fn example(path: &str) -> String {
    PLACEHOLDERS.iter().fold(path.to_owned(), |path, (placeholder, name)| path.replace(placeholder, name))
}

#[test]
fn the_page_names_files_that_exist() {
    let text = fs::read_to_string(root().join("docs/extending.md")).expect("the page can be read");
    let paths = paths(&text);
    assert!(paths.len() > 60, "only {} paths are named", paths.len());
    let missing: Vec<_> = paths.iter().filter(|path| !root().join(example(path)).exists()).collect();
    assert!(missing.is_empty(), "docs/extending.md names files that do not exist: {missing:#?}");
    for part in ["## A brush mode", "## A collider", "## A pass", "## A noun of the C ABI"] {
        assert!(text.contains(part), "the page has no part {part:?}");
    }
}

/// Folders of the root whose files documents name.
const FOLDERS: [&str; 8] = ["cmake/", "examples/", "include/", "packaging/", "plugins/", "rust/", "shaders/", "tests/"];

#[test]
fn documents_name_files_that_exist() {
    let folders = [root().join("docs"), root().join("docs/design")];
    let files = folders
        .iter()
        .flat_map(|folder| fs::read_dir(folder).expect("a folder"))
        .map(|entry| entry.expect("a file").path());
    let pages: Vec<_> = files.filter(|path| path.extension().is_some_and(|it| it == "md")).collect();
    assert!(pages.len() > 40, "only {} documents are there", pages.len());
    let mut missing = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).expect("the page can be read");
        let named = paths(&text).into_iter().map(|path| path.trim_end_matches('*'));
        let named = named.filter(|path| FOLDERS.iter().any(|folder| path.starts_with(folder)));
        missing.extend(
            named.filter(|path| !root().join(example(path)).exists()).map(|path| (page.clone(), path.to_owned())),
        );
    }
    assert!(missing.is_empty(), "documents name files that do not exist: {missing:#?}");
}

#[test]
fn paths_are_told_from_other_code() {
    let text = "`a/b.rs` and `NAMES`, `cargo xtask a/b`, `CHANGELOG.md`\n`include/relievo/NOUN.h`";
    assert_eq!(paths(text), ["a/b.rs", "CHANGELOG.md", "include/relievo/NOUN.h"]);
    assert_eq!(example("rust/SUBJECT/NOUN.rs"), "rust/details/collider.rs");
}
