//! Dependencies between our crates point one way: a crate may use those of lower layers, and none of its own.

use std::collections::BTreeMap;

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Layers from the bottom. Systems share one layer: they do not know each other.
const LAYERS: &[&[&str]] = &[
    &["relievo-core"],
    &["relievo-opensubdiv", "relievo-embree", "relievo-openvdb", "relievo-meshio"],
    &["relievo-surface"],
    &["relievo-tiles"],
    &["relievo-render"],
    &["relievo-detail"],
    &["relievo-scene"],
    &["relievo-capi", "relievo-cli"],
    &["relievo-bench"],
];

/// Crates that use none of ours.
const APART: &[&str] = &["xtask"];

#[test]
fn dependencies_point_down_the_layers() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().expect("cargo metadata runs");
    let layer: BTreeMap<_, _> =
        LAYERS.iter().enumerate().flat_map(|(layer, names)| names.iter().map(move |name| (*name, layer))).collect();
    let mut seen = 0;
    for package in &metadata.packages {
        let name = package.name.as_str();
        // A path dependency is one of ours. Tests may look sideways and up, as peers and fixtures do.
        let ours = package.dependencies.iter().filter(|used| used.path.is_some());
        let ours = ours.filter(|used| used.kind != DependencyKind::Development);
        if APART.contains(&name) {
            assert_eq!(ours.count(), 0, "{name} uses one of our crates");
            continue;
        }
        let own = layer.get(name).unwrap_or_else(|| panic!("{name} has no layer yet: give it one in {}", file!()));
        for used in ours {
            let below = layer.get(used.name.as_str()).unwrap_or_else(|| panic!("{} has no layer yet", used.name));
            assert!(below < own, "{name} may not use {}: it is not in a lower layer", used.name);
            seen += 1;
        }
    }
    assert!(seen > 0, "no dependency between our crates was seen");
}
