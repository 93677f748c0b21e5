//! Surfaces of triangles in scenes: painted, sculpted, pressed into, cached, shown and exported.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Values};
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
kind = "triangles"
longest_edge = 0.3
[details]
segments = 16
[objects.ground]
surface = "ground"
colour = [1, 1, 1]
[objects.tool]
mesh = "tool"
visible = false
[bodies.tool]
keyframes = [{ time = 0, translation = [-0.3, 0, 0.07] }, { time = 0.125, translation = [0.3, 0, 0.07] }]
[imprints]
voxels = 65536
[colliders.tool]
[[strokes]]
object = "ground"
paint = "mix"
colour = [0, 0, 1]
radius = 0.1
points = [{ position = [-0.3, 0.3, 0] }, { position = [0.3, 0.3, 0] }]
[[strokes]]
object = "ground"
time = 0.1
sculpt = "draw"
height = 0.02
radius = 0.1
points = [{ position = [-0.3, -0.3, 0] }, { position = [0.3, -0.3, 0] }]
[camera]
position = [0, 0, 2]
target = [0, 0, 0]
[output]
frames = 4
width = 64
height = 64
samples = 1
sky_rays = 1
images = ["png"]
pictures = ["beauty", "tiles"]
picture_frames = "every"
mesh = "last"
mesh_formats = ["ply", "glb"]
"##;

fn run_in(folder: &Path, name: &str, text: &str, frames: Option<(u32, u32)>, threads: usize) -> Summary {
    let scene = folder.join(format!("{name}.toml"));
    std::fs::write(&scene, text).unwrap();
    let options = RunOptions { out: folder.join(name), frames, allowed: Vec::new(), rebake: false };
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    run(&context, read_file(&scene).unwrap(), &options, &mut Silent).unwrap()
}

fn bytes(folder: &Path, name: &str, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(name).join(file)).unwrap()
}

#[test]
fn triangles_are_painted_sculpted_pressed_kept_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let whole = run_in(folder.path(), "whole", SCENE, None, 1);
    assert_eq!(whole.baked, 4);
    assert!(whole.notes.iter().any(|note| note.contains("split")), "{:?}", whole.notes);
    assert!(whole.tiles[0] > 10 && whole.tiles[0] < whole.tiles[1] && whole.tile_bytes[0] < whole.tile_bytes[1]);

    let mesh = relievo_meshio::read(&Context::serial(), &folder.path().join("whole/mesh-000003-ground.ply")).unwrap();
    let Values::F32(colors) = &mesh.attribute("color").unwrap().values else { panic!() };
    let (mut dented, mut raised, mut blue) = (0, 0, 0);
    for (point, color) in mesh.points.iter().zip(colors.chunks_exact(3)) {
        let [x, y, z] = *point;
        if y.abs() < 0.08 && x.abs() < 0.3 {
            assert!((z + 0.03).abs() < 0.01, "{point:?}");
            dented += 1;
        }
        raised += i32::from(z > 0.015 && y < -0.2);
        blue += i32::from(color[0] < 0.2 && y > 0.2);
    }
    assert!(dented > 100 && raised > 100 && blue > 100, "{dented} {raised} {blue}");

    // Broken off and gone on with, and with another number of threads, it ends the same.
    run_in(folder.path(), "parts", SCENE, Some((0, 1)), 3);
    let rest = run_in(folder.path(), "parts", SCENE, None, 2);
    assert_eq!((rest.baked, rest.opened), (2, 2));
    for file in ["mesh-000003-ground.ply", "mesh-000003.glb", "beauty-000003.png", "tiles-000003.png"] {
        assert_eq!(bytes(folder.path(), "parts", file), bytes(folder.path(), "whole", file), "{file}");
    }
    // From the cache alone too.
    let again = run_in(folder.path(), "whole", SCENE, Some((3, 3)), 1);
    assert_eq!((again.baked, again.opened), (0, 2));
    let file = "beauty-000003.png";
    assert_eq!(bytes(folder.path(), "whole", file), bytes(folder.path(), "parts", file));
}

#[test]
fn what_triangles_cannot_do_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |from: &str, to: &str, expected: &str| {
        let text = SCENE.replace(from, to);
        assert_ne!(text, SCENE);
        let scene = folder.path().join("refused.toml");
        std::fs::write(&scene, text).unwrap();
        let options = RunOptions { out: folder.path().join("out"), frames: None, allowed: Vec::new(), rebake: false };
        let done = read_file(&scene).and_then(|scene| run(&Context::serial(), scene, &options, &mut Silent));
        let message = format!("{}", done.unwrap_err());
        assert!(message.contains(expected), "{message}");
    };
    refused("longest_edge = 0.3", "isolation = 3", "`isolation` means nothing for triangles");
    refused("kind = \"triangles\"\n", "", "`longest_edge` means nothing for a Catmull-Clark surface");
    refused("voxels = 65536\n[colliders.tool]", "voxels = 65536\n[colliders.tool]\nrim = 0.5", "no rims");
    refused("colour = [1, 1, 1]\n", "colour = [1, 1, 1]\ntraces = { depth = 0.1 }\n", "traces of contact");
    refused("segments = 16", "segments = 12", "power of two");
}
