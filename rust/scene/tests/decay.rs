//! Objects of scenes whose edits fade: also across a run that goes on from its cache, and until no memory is left.

use std::path::Path;

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_scene::file::read_file;
use relievo_scene::stepper::{RunOptions, Summary, run};

const SCENE: &str = r##"version = 1
[meshes.ground]
shape = "plane"
size = [1, 1, 1]
faces = 4
[meshes.tool]
shape = "box"
size = [0.2, 0.2, 0.2]
[surfaces.ground]
mesh = "ground"
[details]
tile_size = 16
paint_size = 16
[objects.ground]
surface = "ground"
decay = { delay = 0.1, duration = 0.3 }
[objects.tool]
mesh = "tool"
visible = false
[bodies.tool]
keyframes = [{ time = 0, translation = [-0.2, 0, 0.07] }, { time = 0.125, translation = [0.2, 0, 0.07] }, { time = 0.25, translation = [0.2, 0, 1] }]
[imprints]
voxels = 65536
[colliders.tool]
[[strokes]]
object = "ground"
paint = "mix"
time = 0.1
radius = 0.1
points = [{ position = [-0.3, -0.3, 0] }, { position = [0.3, -0.3, 0] }]
[output]
frames = 16
picture_frames = "none"
mesh = "none"
documents = "every"
"##;

fn run_in(folder: &Path, name: &str, frames: Option<(u32, u32)>) -> Summary {
    let scene = folder.join(format!("{name}.toml"));
    std::fs::write(&scene, SCENE).unwrap();
    let options = RunOptions { out: folder.join(name), frames, allowed: Vec::new(), rebake: false };
    run(&Context::serial(), read_file(&scene).unwrap(), &options, &mut Silent).unwrap()
}

#[test]
fn edits_fade_until_nothing_is_left_also_from_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let whole = run_in(folder.path(), "whole", None);
    assert_eq!((whole.tile_bytes[0], whole.tiles[0]), (0, 0));
    let first = run_in(folder.path(), "parts", Some((0, 5)));
    assert!(first.tile_bytes[0] > 0 && first.tiles[0] > 0, "{first:?}");
    let second = run_in(folder.path(), "parts", Some((0, 9)));
    assert_eq!((second.opened, second.baked), (6, 4));
    let rest = run_in(folder.path(), "parts", None);
    assert_eq!((rest.opened, rest.baked), (10, 6));
    for frame in 0..16 {
        let read = |name: &str| {
            std::fs::read(folder.path().join(name).join(format!("document-{frame:06}-ground.relievo"))).unwrap()
        };
        assert_eq!(read("whole"), read("parts"), "frame {frame}");
    }
}
