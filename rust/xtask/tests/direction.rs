//! Dependencies between our crates point one way: a crate may use those of lower layers, and none of its own. And what
//! is built twice is built of the same.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

/// Layers from the bottom. Crates that share one do not know each other. Levels are sculpted with the brushes of details.
const LAYERS: &[&[&str]] = &[
    &["relievo-core"],
    &[
        "relievo-opensubdiv",
        "relievo-embree",
        "relievo-openvdb",
        "relievo-openmesh",
        "relievo-openmpi",
        "relievo-meshio",
        "relievo-ptex",
        "relievo-document",
        "relievo-gpu",
        "relievo-client",
    ],
    &["relievo-testing"],
    &["relievo-surface", "relievo-particleio", "relievo-repair", "relievo-tissue"],
    &["relievo-tiles"],
    &["relievo-render", "relievo-procedural"],
    &["relievo-detail", "relievo-comparison"],
    &["relievo-bake", "relievo-lod", "relievo-fluid", "relievo-decal"],
    &["relievo-crowd", "relievo-shaderlab"],
    &["relievo-scene", "relievo-view"],
    &["relievo-simulation"],
    &["relievo-server"],
    &["relievo-capi", "relievo-cli", "relievo-mpi"],
    &["relievo-bench"],
];

/// What nothing that is shipped may use: it is for tests, and for benches.
const UNSHIPPED: &str = "relievo-testing";
const BENCHES: &str = "relievo-bench";

/// Crates that use none of ours.
const APART: &[&str] = &["bindings", "xtask"];

#[test]
fn dependencies_point_down_the_layers() {
    let metadata = metadata("Cargo.toml");
    let layer: BTreeMap<_, _> =
        LAYERS.iter().enumerate().flat_map(|(layer, names)| names.iter().map(move |name| (*name, layer))).collect();
    let mut seen = 0;
    for package in list(&metadata["packages"]) {
        let name = text(&package["name"]);
        // A path dependency is one of ours. Tests may look sideways and up, as peers and fixtures do.
        let ours = list(&package["dependencies"]).iter().filter(|used| used["path"].is_string());
        let ours = ours.filter(|used| used["kind"] != "dev").map(|used| text(&used["name"]));
        if APART.contains(&name) {
            assert_eq!(ours.count(), 0, "{name} uses one of our crates");
            continue;
        }
        let own = layer.get(name).unwrap_or_else(|| panic!("{name} has no layer yet: give it one in {}", file!()));
        for used in ours {
            let below = layer.get(used).unwrap_or_else(|| panic!("{used} has no layer yet"));
            assert!(used != UNSHIPPED || name == BENCHES, "{name} may use {used} in its tests alone");
            assert!(below < own, "{name} may not use {used}: it is not in a lower layer");
            seen += 1;
        }
    }
    assert!(seen > 0, "no dependency between our crates was seen");
}

/// The chapter of the design that draws the layers.
const DRAWN: &str = "docs/design/crates.md";

#[test]
fn the_design_draws_the_layers() {
    let layer = |names: &&[&str]| -> Option<String> {
        let short = names.iter().map(|name| name.trim_start_matches("relievo-"));
        let shipped: Vec<&str> = short.filter(|name| !["testing", "bench"].contains(name)).collect();
        (!shipped.is_empty()).then(|| format!("    {}", shipped.join(", ")))
    };
    let drawn: Vec<String> = LAYERS.iter().rev().filter_map(layer).collect();
    let drawn = drawn.join("\n");
    let path = format!("{}/../../{DRAWN}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the chapter");
    assert!(text.contains(&format!("\n\n{drawn}\n\n")), "{DRAWN} draws other layers than these:\n{drawn}");
}

#[test]
fn the_abi_that_is_fuzzed_has_the_dependencies_of_the_abi() {
    let used = |manifest: &str, package: &str| -> (BTreeSet<String>, Value) {
        let metadata = metadata(manifest);
        let found = list(&metadata["packages"]).iter().find(|it| text(&it["name"]) == package).expect("the package");
        let used = list(&found["dependencies"]).iter().filter(|used| used["kind"].is_null());
        let used = used.map(|used| format!("{}, optional: {}", text(&used["name"]), used["optional"]));
        (used.collect(), found["features"].clone())
    };
    assert_eq!(used("tests/fuzz/abi/Cargo.toml", "relievo-fuzz-abi"), used("Cargo.toml", "relievo-capi"));
}

fn metadata(manifest: &str) -> Value {
    let path = format!("{}/../../{manifest}", env!("CARGO_MANIFEST_DIR"));
    let arguments = ["metadata", "--format-version", "1", "--no-deps", "--manifest-path", &path];
    let output = Command::new(env!("CARGO")).args(arguments).output().expect("cargo metadata runs");
    serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}
