//! A folder with many files shows no design. This prints the fullest folders of the crates and of the add-on for Blender,
//! and holds the number of sources in each.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Sources that a folder may have.
const LARGEST: usize = 25;
/// Folders that are printed.
const PRINTED: usize = 8;

/// Returns the number of sources with an extension in `folder` and in every folder below it, build outputs left out.
fn counts(folder: &Path, extension: &str) -> BTreeMap<PathBuf, usize> {
    let mut counts = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let entry = entry.expect("an entry");
            let path = entry.path();
            if path.is_dir() {
                if entry.file_name() != "target" {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|found| found == extension) {
                *counts.entry(folder.clone()).or_insert(0) += 1;
            }
        }
    }
    counts
}

/// Returns the folders of `counts` with more sources than one may have, as text.
fn too_full(counts: &BTreeMap<PathBuf, usize>) -> Vec<String> {
    let full = counts.iter().filter(|(_, count)| **count > LARGEST);
    full.map(|(folder, count)| format!("{}: {count} sources where {LARGEST} may be", folder.display())).collect()
}

#[test]
fn folders_of_sources_stay_small() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut full = Vec::new();
    let mut looked_at = 0;
    for (below, extension) in [("rust", "rs"), ("plugins/blender", "py")] {
        let top = root.join(below);
        let counts = counts(&top, extension);
        let mut fullest: Vec<_> = counts.iter().collect();
        fullest.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        for (folder, count) in fullest.into_iter().take(PRINTED) {
            println!("{count} sources in {below}/{}", folder.strip_prefix(&top).expect("a folder inside").display());
        }
        looked_at += counts.len();
        full.extend(too_full(&counts));
    }
    assert!(looked_at > 100, "only {looked_at} folders were looked at");
    assert!(full.is_empty(), "sort sources into folders by what they do:\n{}", full.join("\n"));
}

#[test]
fn a_full_folder_is_seen_and_those_beside_it_are_not() {
    let counts = BTreeMap::from([("a".into(), LARGEST + 1), ("a/b".into(), LARGEST), ("c".into(), 1)]);
    assert_eq!(too_full(&counts), [format!("a: {} sources where {LARGEST} may be", LARGEST + 1)]);
}
