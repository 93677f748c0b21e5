//! Surfaces of triangles in scenes: painted, sculpted, pressed into, cached, shown and exported.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, Values};
use relievo_document::{Document, Kind};
use relievo_scene::file::read_file;
use relievo_scene::replay::{Replay, replay};
use relievo_scene::stepper::run;

use crate::support::{bytes, plain_options, run_in};

const SCENE: &str = concat!(
    ground_and_tool!(),
    r##"kind = "triangles"
longest_edge = 0.3
[details]
segments = 16
[objects.ground]
surface = "ground"
colour = [1, 1, 1]
"##,
    pressing_tool!("{ time = 0, translation = [-0.3, 0, 0.07] }, { time = 0.125, translation = [0.3, 0, 0.07] }"),
    r##"[[strokes]]
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
"##,
    small_pictures!(),
    r##"pictures = ["beauty", "tiles"]
picture_frames = "every"
mesh = "last"
mesh_formats = ["ply", "glb"]
"##,
);

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
fn what_is_pushed_away_rises_beside_a_track() {
    let folder = tempfile::tempdir().unwrap();
    let scene = SCENE.replace("voxels = 65536\n", "voxels = 65536\nrim = 0.6\nrim_width = 0.06\nrepose = 60\n");
    let whole = run_in(folder.path(), "whole", &scene, None, 1);
    assert!(whole.notes.iter().any(|note| note.contains("rose as rims")), "{:?}", whole.notes);
    let mesh = points(folder.path(), "whole/mesh-000003-ground.ply");
    let (mut deep, mut beside, mut far) = (0.0f32, [0.0f32; 2], 0.0f32);
    for [_, y, z] in mesh.points.iter().filter(|[x, ..]| x.abs() < 0.25) {
        let side = &mut beside[usize::from(*y > 0.0)];
        match y.abs() {
            y if y < 0.08 => deep = deep.min(*z),
            y if (0.1..0.16).contains(&y) => *side = side.max(*z),
            y if (0.17..0.19).contains(&y) => far = far.max(z.abs()),
            _ => {}
        }
    }
    assert!(
        (deep + 0.03).abs() < 0.01 && beside.iter().all(|most| *most > 0.005) && far == 0.0,
        "{deep} {beside:?} {far}"
    );
    run_in(folder.path(), "parts", &scene, Some((0, 1)), 3);
    let rest = run_in(folder.path(), "parts", &scene, None, 2);
    assert_eq!((rest.baked, rest.opened), (2, 2));
    for file in ["mesh-000003-ground.ply", "beauty-000003.png"] {
        assert_eq!(bytes(folder.path(), "parts", file), bytes(folder.path(), "whole", file), "{file}");
    }
}

/// The same with layers and traces, which writes a document.
fn layered() -> String {
    let object = "colour = [1, 1, 1]\ntraces = { depth = 0.02, colour = [0, 1, 0], fade = 1 }\n\
                  [[objects.ground.layers]]\nname = \"ridge\"\nopacity = 0.5\n";
    let scene = SCENE.replace("colour = [1, 1, 1]\n", object);
    let scene = scene.replace("sculpt = \"draw\"\n", "sculpt = \"draw\"\nlayer = \"ridge\"\n");
    scene.replace("mesh = \"last\"\n", "mesh = \"last\"\ndocuments = \"last\"\n")
}

fn points(folder: &Path, name: &str) -> relievo_core::Mesh {
    relievo_meshio::read(&Context::serial(), &folder.join(name)).unwrap()
}

#[test]
fn layers_and_traces_are_cached_and_a_document_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let scene = layered();
    run_in(folder.path(), "whole", &scene, None, 1);
    let plain = run_in(folder.path(), "plain", SCENE, None, 1);
    assert_eq!(plain.baked, 4);
    let files = ["mesh-000003-ground.ply", "mesh-000003.glb", "beauty-000003.png", "document-000003-ground.relievo"];
    run_in(folder.path(), "parts", &scene, Some((0, 2)), 3);
    let rest = run_in(folder.path(), "parts", &scene, None, 2);
    assert_eq!((rest.baked, rest.opened), (1, 3));
    for file in files {
        assert_eq!(bytes(folder.path(), "parts", file), bytes(folder.path(), "whole", file), "{file}");
    }
    let mesh = points(folder.path(), "whole/mesh-000003-ground.ply");
    let numbers = |name: &str| match &mesh.attribute(name).unwrap().values {
        Values::F32(values) => values.clone(),
        _ => panic!(),
    };
    let (contact, depth, age) = (numbers("contact"), numbers("depth"), numbers("age"));
    let mut touched = 0;
    for (at, [x, y, z]) in mesh.points.iter().enumerate() {
        if y.abs() < 0.08 && x.abs() < 0.3 {
            // Nothing else moved it.
            assert!(contact[at] == 1.0 && (depth[at] + z).abs() < 2e-3 && (0.0..=0.125).contains(&age[at]));
            touched += 1;
        } else if y.abs() > 0.2 {
            assert!(contact[at] == 0.0 && age[at] == -1.0);
        }
    }
    assert!(touched > 100);
    // A ridge on a layer at half its opacity is as high as one that is on none.
    let highest = |mesh: &relievo_core::Mesh| mesh.points.iter().map(|point| point[2]).fold(0.0, f32::max);
    let [one, other] = [&mesh, &points(folder.path(), "plain/mesh-000003-ground.ply")].map(highest);
    assert!((one - other).abs() < 1e-4 && one > 0.015, "{one} {other}");

    // What goes on from the document has all of it, where nothing presses any more.
    let from = scene.replace("colour = [1, 1, 1]\n", "colour = [1, 1, 1]\ndocument = \"ground.relievo\"\n");
    let cut = |text: &str| {
        let first = text.find("[[strokes]]").unwrap();
        let text = format!("{}{}", &text[..first], &text[text.find("[camera]").unwrap()..]);
        text.replace("[colliders.tool]\n", "")
    };
    let from = cut(&from).replace("frames = 4", "frames = 1");
    let written = folder.path().join("whole/document-000003-ground.relievo");
    std::fs::copy(&written, folder.path().join("ground.relievo")).unwrap();
    run_in(folder.path(), "on", &from, None, 1);
    let again = points(folder.path(), "on/mesh-000000-ground.ply");
    assert_eq!(again.points, mesh.points);
    let document = Document::open(&folder.path().join("on/document-000000-ground.relievo"), 1 << 30).unwrap();
    assert_eq!(document.layers(), Document::open(&written, 1 << 30).unwrap().layers());
    // But not as a Catmull-Clark surface, nor on other triangles.
    for (old, new, expected) in [
        ("kind = \"triangles\"\nlongest_edge = 0.3\n", "", "on a surface of triangles"),
        ("longest_edge = 0.3", "longest_edge = 0.2", "on other triangles"),
    ] {
        let text = from.replace(old, new);
        assert_ne!(text, from);
        let scene = folder.path().join("misfit.toml");
        std::fs::write(&scene, text).unwrap();
        let options = plain_options(folder.path().join("out"));
        let done = run(&Context::serial(), read_file(&scene).unwrap(), &options, &mut Silent);
        let message = format!("{}", done.unwrap_err());
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn faces_that_page_are_those_of_a_mesh_with_room() {
    /// What one edit touches has to fit, all of them need not.
    const BUDGET: u64 = 160 << 10;
    let folder = tempfile::tempdir().unwrap();
    let fine = SCENE.replace("segments = 16", "segments = 64");
    let small = fine.replace("segments = 64", &format!("segments = 64\nbudget = {BUDGET}"));
    let large = run_in(folder.path(), "large", &fine, None, 2);
    assert!(large.tile_bytes[0] > 2 * BUDGET, "{:?}", large.tile_bytes);
    let refusing = run_in(folder.path(), "refusing", &small, None, 1);
    let refusal = refusing.notes.iter().find(|note| note.contains("budget refused")).unwrap();
    assert!(refusal.contains("of face") && refusal.contains("of object `ground`"), "{refusal}");
    let paging = small.replace("segments = 64", "segments = 64\npage = true");
    let paged = run_in(folder.path(), "paged", &paging, None, 1);
    assert!(!paged.notes.iter().any(|note| note.contains("refused")), "{:?}", paged.notes);
    assert!(paged.tile_bytes[0] <= 2 * BUDGET && paged.tiles == large.tiles, "{:?}", paged.tile_bytes);
    for file in ["mesh-000003-ground.ply", "mesh-000003.glb", "beauty-000003.png"] {
        assert_eq!(bytes(folder.path(), "paged", file), bytes(folder.path(), "large", file), "{file}");
    }
}

#[test]
fn edits_that_fade_are_gone_on_with_and_give_all_bytes_back() {
    let folder = tempfile::tempdir().unwrap();
    let fading = |duration: &str| {
        let decay = format!("colour = [1, 1, 1]\ndecay = {{ delay = 0.04, duration = {duration} }}\n");
        SCENE.replace("colour = [1, 1, 1]\n", &decay).replace("frames = 4", "frames = 8")
    };
    let scene = fading("0.2");
    run_in(folder.path(), "whole", &scene, None, 1);
    run_in(folder.path(), "parts", &scene, Some((0, 4)), 3);
    let rest = run_in(folder.path(), "parts", &scene, None, 2);
    assert_eq!((rest.baked, rest.opened), (3, 5));
    for file in ["mesh-000007-ground.ply", "beauty-000007.png", "beauty-000006.png"] {
        assert_eq!(bytes(folder.path(), "parts", file), bytes(folder.path(), "whole", file), "{file}");
    }
    // All that was painted and sculpted has faded, and what presses is out of the mesh.
    let gone = fading("0.01")
        .replace("time = 0.125, translation = [0.3, 0, 0.07] }", "time = 0.125, translation = [0.3, 0, 9] }");
    let summary = run_in(folder.path(), "gone", &gone, None, 1);
    let mesh = points(folder.path(), "gone/mesh-000007-ground.ply");
    assert!(mesh.points.iter().all(|point| point[2] == 0.0));
    assert_eq!(summary.tiles[0], 0);
}

#[test]
fn a_list_of_strokes_is_replayed_on_triangles_and_on_a_document_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    let list = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.01\nradius = 0.2\n\
                points = [{ position = [0.3, 0.5, 0] }, { position = [0.7, 0.5, 0] }]\n";
    std::fs::write(at("list.toml"), list).unwrap();
    let replayed = |triangles: bool, document: Option<&str>, output: &str| {
        let wanted = Replay {
            mesh: at("mesh.obj"),
            triangles,
            isolation: None,
            strokes: at("list.toml"),
            document: document.map(at),
            outputs: vec![at(output)],
            allowed: Vec::new(),
            device: None,
        };
        replay(&Context::serial(), &wanted, &mut Silent).unwrap();
    };
    replayed(true, None, "once.relievo");
    replayed(false, Some("once.relievo"), "twice.relievo");
    replayed(false, Some("once.relievo"), "twice.ply");
    let bytes = |name: &str| {
        let document = Document::open(&at(name), 1 << 30).unwrap();
        assert!(document.topology().is_of_triangles());
        document.layers().iter().map(|layer| layer.bytes(document.topology())).sum::<u64>()
    };
    assert!(bytes("once.relievo") > 0 && bytes("twice.relievo") >= bytes("once.relievo"));
    let highest = points(folder.path(), "twice.ply").points.iter().map(|point| point[2]).fold(0.0, f32::max);
    assert!(highest > 0.015, "{highest}");
}

#[test]
fn strokes_on_a_document_that_fades_fade_too() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["", "kind = \"triangles\"\n"] {
        let scene = format!(
            "version = 1\n[meshes.ground]\nfile = \"mesh.obj\"\n[surfaces.ground]\nmesh = \"ground\"\n{kind}\
             [objects.ground]\nsurface = \"ground\"\ndecay = {{ delay = 0.1, duration = 0.3 }}\n\
             [details]\nsegments = 16\ntile_size = 32\n[output]\nframes = 4\npicture_frames = \"none\"\n\
             mesh = \"none\"\ndocuments = \"last\"\n"
        );
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
        run_in(folder.path(), "begun", &scene, None, 1);
        let list = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.01\nradius = 0.2\n\
                    points = [{ position = [0.3, 0.5, 0] }, { position = [0.7, 0.5, 0] }]\n";
        std::fs::write(at("list.toml"), list).unwrap();
        let wanted = Replay {
            mesh: at("mesh.obj"),
            triangles: false,
            isolation: None,
            strokes: at("list.toml"),
            document: Some(at("begun").join("document-000003-ground.relievo")),
            outputs: vec![at("added.relievo")],
            allowed: Vec::new(),
            device: None,
        };
        replay(&Context::serial(), &wanted, &mut Silent).unwrap();
        let added = Document::open(&at("added.relievo"), 1 << 30).unwrap();
        let blocks = |kind: Kind| added.layers().iter().find(|layer| layer.kind() == kind).unwrap().blocks().len();
        assert!(blocks(Kind::Scalar) > 0 && blocks(Kind::Stamps) > 0, "{kind}");
        // A scene that goes on from there loses it.
        let from = "surface = \"ground\"\ndocument = \"added.relievo\"\n";
        let later = scene.replace("surface = \"ground\"\n", from).replace("frames = 4", "frames = 12");
        let summary = run_in(folder.path(), "later", &later, None, 1);
        assert_eq!(summary.tiles[0], 0, "{kind}");
        std::fs::remove_dir_all(at("later")).unwrap();
        std::fs::remove_dir_all(at("begun")).unwrap();
    }
}

#[test]
fn what_triangles_cannot_do_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |from: &str, to: &str, expected: &str| {
        let text = SCENE.replace(from, to);
        assert_ne!(text, SCENE);
        let scene = folder.path().join("refused.toml");
        std::fs::write(&scene, text).unwrap();
        let options = plain_options(folder.path().join("out"));
        let done = read_file(&scene).and_then(|scene| run(&Context::serial(), scene, &options, &mut Silent));
        let message = format!("{}", done.unwrap_err());
        assert!(message.contains(expected), "{message}");
    };
    refused("longest_edge = 0.3", "isolation = 3", "`isolation` means nothing for triangles");
    refused("kind = \"triangles\"\n", "", "`longest_edge` means nothing for a Catmull-Clark surface");
    refused("segments = 16", "segments = 12", "power of two");
}
