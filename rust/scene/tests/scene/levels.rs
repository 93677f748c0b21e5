//! Strokes of scenes at coarser levels of detail, also across a run that goes on from its cache.

use std::path::Path;

use relievo_document::Document;
use relievo_scene::file::parse;

use crate::support::run_in;

const SCENE: &str = concat!(
    "version = 1\nfps = 10\n",
    ground!("4", "4"),
    r##"[details]
tile_size = 64
paint_size = 32
[objects.ground]
surface = "ground"
[[objects.ground.layers]]
name = "hills"
tile_size = 32
opacity = 0.5
[[strokes]]
sculpt = "draw"
radius = 0.3
points = [{ position = [-1.5, -1.5, 0] }, { position = [-0.5, -1.5, 0] }]
[[strokes]]
sculpt = "draw"
level = 2
time = 0.1
radius = 0.6
points = [{ position = [-1, 1, 0] }, { position = [1, 1, 0] }]
[[strokes]]
paint = "mix"
level = 1
time = 0.1
radius = 0.6
points = [{ position = [-1, 1, 0] }, { position = [1, 1, 0] }]
[[strokes]]
sculpt = "draw"
layer = "hills"
level = 1
time = 0.2
radius = 0.6
points = [{ position = [1, -1, 0] }, { position = [1, 1, 0] }]
[[strokes]]
sculpt = "draw"
time = 0.3
radius = 0.2
points = [{ position = [-1, 1, 0] }, { position = [-1, 0.5, 0] }]
[[strokes]]
sculpt = "erase"
time = 0.4
radius = 3
points = [{ position = [0, 0, 0] }]
[output]
frames = 6
picture_frames = "none"
mesh = "none"
documents = "every"
"##,
);

#[test]
fn strokes_at_coarser_levels_take_coarser_tiles_also_from_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let document =
        |name: &str, frame: u32| folder.path().join(name).join(format!("document-{frame:06}-ground.relievo"));
    run_in(folder.path(), "whole", SCENE, None, 1);
    for last in [1, 3, 5] {
        let part = run_in(folder.path(), "parts", SCENE, Some((0, last)), 1);
        assert_eq!(part.baked, 2, "the rest is opened: {:?}", part.notes);
    }
    for frame in 0..6 {
        let [a, b] = ["whole", "parts"].map(|name| std::fs::read(document(name, frame)).unwrap());
        assert!(a == b, "frame {frame}");
    }
    let document = Document::open(&document("whole", 2), 1 << 30).unwrap();
    let sizes = |name: &str| document.layer(name).unwrap().face_sizes().to_vec();
    let count = |sizes: &[u32], size: u32| sizes.iter().filter(|other| **other == size).count();
    assert!(count(&sizes("displacement"), 16) >= 3 && count(&sizes("displacement"), 64) >= 2);
    assert!(count(&sizes("colour"), 16) >= 3 && count(&sizes("colour"), 32) >= 3);
    assert_eq!(document.layer("displacement").unwrap().head().given_sizes, [64; 16]);
}

#[test]
fn levels_that_are_none_are_told_where_they_are() {
    let text = SCENE.replace("level = 2", "level = 3");
    let faults = parse(Path::new("scene.toml"), &text).unwrap_err().to_string();
    assert!(faults.contains("`level` is out of range") && faults.contains("scene.toml:24:"), "{faults}");
}
