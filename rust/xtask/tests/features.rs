//! The library without its features depends on none of the large crates.

use std::process::Command;

/// Crates that a feature brings in, by the beginnings of their names.
const LARGE: [&str; 7] = ["wgpu", "naga", "ash", "gpu-", "openusd", "rapier", "parry"];

fn crates(features: &[&str]) -> Vec<String> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let tree =
        ["tree", "--package", "relievo-capi", "--edges", "normal", "--prefix", "none", "--manifest-path", manifest];
    let output = Command::new(env!("CARGO")).args(tree).args(features).output().expect("cargo tree runs");
    let output = String::from_utf8(output.stdout).expect("names are text");
    output.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

fn large(crates: &[String]) -> Vec<&String> {
    crates.iter().filter(|name| LARGE.iter().any(|large| name.starts_with(large))).collect()
}

#[test]
fn the_smallest_library_has_no_large_crate() {
    let smallest = crates(&["--no-default-features"]);
    assert!(smallest.iter().any(|name| name == "relievo-gpu"), "{smallest:?}");
    assert!(large(&smallest).is_empty(), "{:?}", large(&smallest));
    let whole = crates(&[]);
    assert!(large(&whole).iter().any(|name| *name == "wgpu"), "{whole:?}");
}
