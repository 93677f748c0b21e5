//! Pinches and stamps of vectors in scenes: baked, cached, shown, exported, in documents, and in lists that are
//! replayed.

use std::path::Path;

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_document::Document;
use relievo_render::{Channel, Content, Layer, Samples, read_exr, write_exr};
use relievo_scene::file::parse;
use relievo_scene::replay::{Replay, replay};

use crate::support::{bytes, run_in};

const SCENE: &str = concat!(
    "version = 1\n",
    ground!("1", "4"),
    r##"[details]
tile_size = 64
segments = 32
[objects.ground]
surface = "ground"
[stamps.cap]
pattern = "mushroom"
[[strokes]]
object = "ground"
sculpt = "vector"
stamp = "cap"
height = 0.3
radius = 0.3
falloff = "constant"
points = [{ position = [0, 0, 0] }]
[[strokes]]
object = "ground"
time = 0.1
sculpt = "pinch"
radius = 0.15
strength = 0.5
points = [{ position = [-0.35, -0.4, 0] }, { position = [0.35, -0.4, 0] }]
[camera]
position = [0, -2, 1]
target = [0, 0, 0.1]
[output]
frames = 4
"##,
    small_pictures!(),
    r##"pictures = ["beauty"]
picture_frames = "every"
mesh = "every"
mesh_rate = 64
mesh_formats = ["ply"]
tiles = "last"
"##,
);

/// Points of a mesh that hang over others: higher than 0.15, beside the stalk, which is under 0.1 wide there.
fn overhangs(path: &Path) -> usize {
    let mesh = relievo_meshio::read(&Context::serial(), path).unwrap();
    let caps = mesh.points.iter().filter(|p| p[2] > 0.19 && p[0].hypot(p[1]) > 0.15).count();
    let bare = mesh.points.iter().filter(|p| p[2] > 0.06 && p[2] < 0.17 && p[0].hypot(p[1]) > 0.12).count();
    if bare == 0 { caps } else { 0 }
}

#[test]
fn vectors_are_baked_kept_shown_and_exported() {
    for kind in ["", "kind = \"triangles\"\n"] {
        let folder = tempfile::tempdir().unwrap();
        let text = SCENE.replace("[surfaces.ground]\n", &format!("[surfaces.ground]\n{kind}"));
        let text = if kind.is_empty() { text } else { text.replace("tiles = \"last\"\n", "") };
        let whole = run_in(folder.path(), "whole", &text, None, 1);
        assert_eq!(whole.baked, 4);
        assert!(whole.tiles[0] > 3 && whole.tile_bytes[0] > 0);
        assert!(overhangs(&folder.path().join("whole/mesh-000000-ground.ply")) > 50, "{kind}");
        assert_ne!(
            bytes(folder.path(), "whole", "mesh-000000-ground.ply"),
            bytes(folder.path(), "whole", "mesh-000003-ground.ply")
        );
        // Broken off and gone on with, and with another number of threads, it ends the same.
        run_in(folder.path(), "parts", &text, Some((0, 1)), 3);
        let rest = run_in(folder.path(), "parts", &text, None, 2);
        assert_eq!((rest.baked, rest.opened), (2, 2));
        for file in ["mesh-000003-ground.ply", "beauty-000003.png"] {
            assert_eq!(bytes(folder.path(), "parts", file), bytes(folder.path(), "whole", file), "{kind}{file}");
        }
        // From the cache alone too.
        let again = run_in(folder.path(), "whole", &text, Some((3, 3)), 1);
        assert_eq!(again.baked, 0);
        let file = "beauty-000003.png";
        assert_eq!(bytes(folder.path(), "whole", file), bytes(folder.path(), "parts", file));
    }
}

#[test]
fn tiles_of_vectors_are_written_beside_those_of_displacement() {
    let folder = tempfile::tempdir().unwrap();
    run_in(folder.path(), "tiles", &SCENE.replace("frames = 4", "frames = 1"), None, 1);
    let layers = read_exr(&folder.path().join("tiles/tiles-000000-ground.exr"), 1 << 30).unwrap();
    assert!(layers.iter().all(|layer| layer.name.as_deref().is_some_and(|name| name.starts_with("vectors."))));
    let names: Vec<&str> = layers[0].channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!((names.len(), names.contains(&"up")), (3, true));
}

#[test]
fn a_list_with_an_image_of_vectors_is_replayed_on_a_mesh_and_its_document_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    // Every pixel says the same: aside and up.
    let channels = [("R", 0.5f32), ("G", 0.25), ("B", 1.0)];
    let channels = channels.map(|(name, value)| Channel { name: name.into(), samples: Samples::F32(vec![value; 64]) });
    let layer = Layer { name: None, width: 8, height: 8, channels: channels.to_vec(), attributes: Vec::new() };
    write_exr(&file("aside.exr"), &[layer], Content::Data).unwrap();
    let list = r##"version = 1
[details]
tile_size = 32
[stamps.aside]
image = "aside.exr"
mid = 0
scale = 1
[[strokes]]
sculpt = "vector"
stamp = "aside"
height = 0.5
radius = 0.4
points = [{ position = [0, 0, 0] }]
"##;
    std::fs::write(file("list.toml"), list).unwrap();
    let points: Vec<[f32; 3]> = (0..25).map(|k| [(k % 5) as f32 - 2.0, (k / 5) as f32 - 2.0, 0.0]).collect();
    let corners = (0..16).flat_map(|k| [0, 1, 6, 5].map(|at| k / 4 * 5 + k % 4 + at)).collect();
    let mesh = relievo_core::Mesh::new(points, vec![4; 16], corners);
    relievo_meshio::write(&file("mesh.ply"), &mesh).unwrap();
    let context = Context::serial();
    let wanted = |document: Option<&str>, outputs: &[&str]| Replay {
        triangles: false,
        isolation: None,
        mesh: file("mesh.ply"),
        strokes: file("list.toml"),
        document: document.map(&file),
        outputs: outputs.iter().map(|name| file(name)).collect(),
        allowed: Vec::new(),
        device: None,
    };
    let (done, _) = replay(&context, &wanted(None, &["once.relievo", "once.ply"]), &mut Silent).unwrap();
    assert!(done.dabs == 1 && done.report.changed_texels > 50);
    let top = |name: &str| {
        let mesh = relievo_meshio::read(&context, &file(name)).unwrap();
        mesh.points.into_iter().max_by(|a, b| a[2].total_cmp(&b[2])).unwrap()
    };
    let [x, y, z] = top("once.ply");
    assert!((z - 0.5).abs() < 0.02 && (x - 0.25).abs() < 0.06 && (y - 0.125).abs() < 0.06, "{x} {y} {z}");
    let document = Document::open(&file("once.relievo"), 1 << 30).unwrap();
    assert!(document.layers().iter().any(|layer| layer.name() == "vectors"));
    // Again, on what the document holds: the top is under the brush no more, and erased it is gone.
    let erase = list.replace(
        "sculpt = \"vector\"\nstamp = \"aside\"\nheight = 0.5\nradius = 0.4",
        "sculpt = \"erase\"\nradius = 3\nfalloff = \"constant\"",
    );
    std::fs::write(file("list.toml"), erase).unwrap();
    replay(&context, &wanted(Some("once.relievo"), &["gone.ply"]), &mut Silent).unwrap();
    assert!(top("gone.ply")[2].abs() < 1e-6);
}

#[test]
fn vectors_have_no_layers() {
    let text = SCENE.replacen("time = 0.1\n", "time = 0.1\nlayer = \"displacement\"\n", 1);
    let error = parse(Path::new("layer.toml"), &text).unwrap_err().to_string();
    assert!(error.contains("vector displacement has no layers"), "{error}");
}
