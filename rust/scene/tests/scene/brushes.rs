//! Stamps, strokes over several objects, brushes that ride on objects, and lists of strokes that are replayed.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3, Vec4};
use relievo_core::progress::Silent;
use relievo_core::{Context, Progress};
use relievo_document::Document;
use relievo_render::{Channel, Content, Image, Layer, Samples, write_exr, write_png};
use relievo_scene::file::{parse, read_file};
use relievo_scene::replay::{Replay, replay};
use relievo_scene::stepper::{self, RunOptions, Summary};
use relievo_scene::world::{Item, World};

const GROUND: &str = concat!(painted_ground!(),);

/// A box that walks: down at 0.2 s and 0.6 s, up between.
const WALK: &str = r##"
[meshes.foot]
shape = "box"
size = [0.4, 0.2, 0.2]
[objects.foot]
mesh = "foot"
[bodies.foot]
keyframes = [
    { time = 0, translation = [-1, 0, 1] }, { time = 0.2, translation = [-1, 0, 0.1] },
    { time = 0.4, translation = [0, 0, 1] }, { time = 0.6, translation = [1, 0, 0.1] },
    { time = 0.8, translation = [1, 0, 0.1] }, { time = 1, translation = [1, 0, 1] },
]
[stamps.sole]
pattern = "sole"
[[brushes]]
by = "foot"
place = [0, 0, -0.1]
along = [1, 0, 0]
once = true
paint = "mix"
colour = [0, 0, 0]
stamp = "sole"
falloff = "constant"
radius = 0.5
reach = 0.1
[output]
frames = 11
pictures = []
mesh = "none"
documents = "last"
"##;

fn run(scene: &Path, out: &Path, frames: Option<(u32, u32)>) -> Summary {
    let options = RunOptions { out: out.into(), frames, allowed: Vec::new(), rebake: false, device: None };
    stepper::run(&Context::serial(), read_file(scene).unwrap(), &options, &mut relievo_core::progress::Silent).unwrap()
}

/// The colour of the ground of a document, at some places.
fn colors(scene: &Path, document: &Path, places: &[[f64; 2]]) -> Vec<Vec4> {
    let context = Context::serial();
    let text = std::fs::read_to_string(scene).unwrap();
    let name = document.file_name().unwrap().to_str().unwrap();
    let text = text.replace("surface = \"ground\"\n", &format!("surface = \"ground\"\ndocument = \"{name}\"\n"));
    let world = World::new(&context, parse(document, &text).unwrap(), &[]).unwrap();
    let Item::Surface(surface) = &world.items()[0] else { panic!("the ground is a surface") };
    let field = surface.paint().unwrap().field();
    let color = |p: &[f64; 2]| {
        let found = surface.nearest(&context, DVec3::new(p[0], p[1], 0.0), 1.0).unwrap().unwrap();
        field.color(field.canonical(found.place))
    };
    places.iter().map(color).collect()
}

/// Notes how often it is asked, and stops the call once it was asked `patience` times.
#[derive(Default)]
struct Asked {
    fractions: Vec<f32>,
    patience: Option<usize>,
}

impl Progress for Asked {
    fn report(&mut self, fraction: f32, _: &str) -> bool {
        let go_on = self.patience.is_none_or(|patience| self.fractions.len() < patience);
        self.fractions.push(fraction);
        go_on
    }
}

#[test]
fn a_foot_leaves_a_print_each_time_it_touches() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("walk.toml");
    std::fs::write(&scene, format!("{GROUND}{WALK}")).unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    run(&scene, &whole, None);
    for (first, last) in [(0, 4), (5, 5), (6, 10)] {
        run(&scene, &parts, Some((first, last)));
    }
    let document = "document-000010-ground.relievo";
    assert_eq!(std::fs::read(whole.join(document)).unwrap(), std::fs::read(parts.join(document)).unwrap());
    // The ball of the sole has ribs: its mean is dark, between the prints nothing is.
    let mean = |x: f64| {
        let places: Vec<[f64; 2]> =
            (0..64).map(|k| [x + 0.02 * f64::from(k % 8), 0.03 * f64::from(k / 8) - 0.1]).collect();
        colors(&scene, &whole.join(document), &places).iter().map(|color| color.x).sum::<f32>() / 64.0
    };
    for (x, printed) in [(-0.95, true), (0.0, false), (1.05, true)] {
        assert_eq!(mean(x) < 0.35, printed, "{x}: {}", mean(x));
    }
}

#[test]
fn a_wheel_leaves_a_track_and_a_stroke_goes_over_all_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("roll.toml");
    let text = format!("{GROUND}{WALK}")
        .replace("once = true\n", "")
        .replace("stamp = \"sole\"\n", "")
        .replace("radius = 0.5", "radius = 0.2")
        .replace("reach = 0.1", "reach = 6\ndepth = 10")
        .replace(
            "[output]",
            "[[strokes]]\npaint = \"mix\"\ncolour = [0, 1, 0]\nradius = 0.2\npoints = [{ position = [0, 1.5, 0] }]\n[output]",
        );
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    run(&scene, &out, None);
    let places: Vec<[f64; 2]> = (0..21).map(|k| [0.1 * f64::from(k) - 1.0, 0.0]).collect();
    let found = colors(&scene, &out.join("document-000010-ground.relievo"), &places);
    assert!(found.iter().all(|color| color.x < 0.1), "{found:?}");
    let found = colors(&scene, &out.join("document-000010-ground.relievo"), &[[0.0, 1.5], [0.0, -1.5]]);
    assert!(found[0].y > 0.9 && found[0].x < 0.1 && (found[1].y - 0.5).abs() < 0.01, "{found:?}");
}

fn cage(folder: &Path) -> PathBuf {
    let path = folder.join("cage.obj");
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 3 -1 0\nv 3 1 0\nf 1 2 3 4\nf 2 5 6 3\n";
    std::fs::write(&path, text).unwrap();
    path
}

const LIST: &str = r##"version = 1
[details]
tile_size = 64
[stamps.hill]
image = "hill.png"
scale = 1
mid = 0
[[strokes]]
sculpt = "draw"
height = 0.2
stamp = "hill"
radius = 0.5
falloff = "constant"
points = [{ position = [0, 0, 0] }]
"##;
const MORE: &str = r##"
[[strokes]]
paint = "mix"
colour = "#ff0000"
radius = 0.3
points = [{ position = [1.5, 0, 0] }]
"##;

#[test]
fn a_list_of_strokes_in_two_goes_is_the_list_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // A PNG of heights: 51 of 255 on the left, 204 on the right, which are not colours here.
    let at = |k: u32| if k % 16 < 8 { 51.0f32 } else { 204.0 } / 255.0;
    let pixels: Vec<f32> = (0..256).map(|k| relievo_render::color::decode_srgb(at(k))).collect();
    write_png(&path("hill.png"), &Image::from_data(16, 16, 1, pixels).unwrap()).unwrap();
    std::fs::write(path("first.toml"), LIST).unwrap();
    std::fs::write(path("second.toml"), format!("version = 1\n{MORE}")).unwrap();
    std::fs::write(path("both.toml"), format!("{LIST}{MORE}")).unwrap();
    let context = Context::serial();
    let watched = |strokes: &str, document: Option<&str>, outputs: &[&str], progress: &mut dyn Progress| {
        let wanted = Replay {
            triangles: false,
            isolation: None,
            mesh: cage(folder.path()),
            strokes: path(strokes),
            document: document.map(path),
            outputs: outputs.iter().map(|name| path(name)).collect(),
            allowed: Vec::new(),
            device: None,
        };
        replay(&context, &wanted, progress)
    };
    let go = |strokes: &str, document: Option<&str>, outputs: &[&str]| watched(strokes, document, outputs, &mut Silent);
    // Progress is asked before every stroke and file, rises, and stops the call before anything is written.
    let mut asked = Asked::default();
    watched("both.toml", None, &["asked.ply"], &mut asked).unwrap();
    assert!(asked.fractions.len() >= 3 && asked.fractions.is_sorted(), "{:?}", asked.fractions);
    for patience in 0..asked.fractions.len() {
        let mut asked = Asked { patience: Some(patience), ..Asked::default() };
        assert!(watched("both.toml", None, &["stopped.ply"], &mut asked).is_err());
        assert!(!path("stopped.ply").exists(), "after {patience}");
    }
    let (done, _) = go("first.toml", None, &["first.relievo"]).unwrap();
    assert_eq!((done.dabs, done.missed, done.report.changed.len()), (1, 0, 1));
    go("second.toml", Some("first.relievo"), &["two.relievo"]).unwrap();
    go("both.toml", None, &["one.relievo", "one.ply", "one.obj", "one.glb"]).unwrap();
    let open = |name: &str| Document::open(&path(name), u64::MAX).unwrap();
    let (one, two) = (open("one.relievo"), open("two.relievo"));
    for layer in one.layers() {
        let other = two.layer(layer.name()).unwrap();
        assert_eq!(layer.blocks().len(), other.blocks().len(), "{}", layer.name());
        for at in 0..layer.blocks().len() {
            assert_eq!(layer.unpack(one.topology(), at).unwrap(), other.unpack(two.topology(), at).unwrap());
        }
    }
    let mesh = relievo_meshio::read(&context, &path("one.ply")).unwrap();
    let height = |x: f32, y: f32| {
        let far = |p: &&[f32; 3]| (p[0] - x).hypot(p[1] - y);
        mesh.points.iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()[2]
    };
    assert!((height(-0.25, 0.0) - 0.04).abs() < 2e-3 && (height(0.25, 0.0) - 0.16).abs() < 2e-3);
    assert!(mesh.attribute("color").is_some());
    // What cannot be is said and nothing is written.
    for (strokes, output, says) in [
        ("first.toml", "a.fbx", ".relievo, .obj"),
        ("none.toml", "a.ply", "none.toml"),
        ("bad.toml", "a.ply", "truncated"),
        ("scene.toml", "a.ply", "relievo scene run"),
    ] {
        let bytes = std::fs::read(path("hill.png")).unwrap();
        std::fs::write(path("truncated.png"), &bytes[..bytes.len() / 2]).unwrap();
        std::fs::write(path("bad.toml"), LIST.replace("hill.png", "truncated.png")).unwrap();
        std::fs::write(path("scene.toml"), GROUND).unwrap();
        let said = go(strokes, None, &[output]).unwrap_err().to_string();
        assert!(said.contains(says), "{strokes}: {said}");
        assert!(!path(output).exists());
    }
}

#[test]
fn a_scene_whose_tiles_leave_memory_writes_the_same_document() {
    let folder = tempfile::tempdir().unwrap();
    let stroke = r##"
[[strokes]]
paint = "mix"
colour = [0.8, 0.1, 0.1]
radius = 0.3
points = [
    { position = [-1.9, -1.5, 0] }, { position = [1.9, -1.5, 0] }, { position = [1.9, 0, 0] },
    { position = [-1.9, 0, 0] }, { position = [-1.9, 1.5, 0] }, { position = [1.9, 1.5, 0] },
]
[output]
frames = 1
pictures = []
mesh = "none"
documents = "last"
"##;
    let made = |name: &str, detail: &str| {
        let scene = folder.path().join(format!("{name}.toml"));
        let ground = GROUND.replace("paint_size = 32\n", &format!("paint_size = 32\n{detail}"));
        std::fs::write(&scene, format!("{ground}{stroke}")).unwrap();
        let out = folder.path().join(name);
        let notes = run(&scene, &out, None).notes;
        let mut files = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
        let file = files.find(|path| path.extension().is_some_and(|found| found == "relievo")).unwrap();
        (std::fs::read(file).unwrap(), notes)
    };
    let (whole, notes) = made("whole", "");
    assert_eq!(notes, Vec::<String>::new());
    // Ten tiles of colour with their mips.
    let paged = made("paged", "budget = 65536\npage = true\n");
    assert!(paged == (whole.clone(), notes));
    let (refused, notes) = made("refused", "budget = 65536\n");
    assert!(refused != whole);
    assert!(notes.iter().any(|note| note.contains("tiles of faces ") && note.contains("object `ground`")), "{notes:?}");
}

#[test]
fn images_of_files_are_painted_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // Red over 0.25 of it on the left, blue on the right, once as bytes and once as floats.
    let texel = |k: u32| if k % 16 < 8 { [1.0, 0.25, 0.0] } else { [0.0, 0.0, 0.5f32] };
    let pixels: Vec<f32> = (0..256).flat_map(texel).collect();
    write_png(&path("two.png"), &Image::from_data(16, 16, 3, pixels.clone()).unwrap()).unwrap();
    let channels = ["R", "G", "B"].into_iter().enumerate().map(|(channel, name)| Channel {
        name: name.into(),
        samples: Samples::F32(pixels.iter().skip(channel).step_by(3).copied().collect()),
    });
    let layer = Layer { name: None, width: 16, height: 16, channels: channels.collect(), attributes: Vec::new() };
    write_exr(&path("two.exr"), &[layer], Content::Color).unwrap();
    for image in ["two.png", "two.exr"] {
        let (scene, out) = (path("paint.toml"), path("out"));
        let stroke = format!(
            "[stamps.two]\nimage = \"{image}\"\n[[strokes]]\npaint = \"mix\"\ncolour = [1, 1, 1]\nstamp = \"two\"\n\
             radius = 0.5\nfalloff = \"constant\"\npoints = [{{ position = [0, 0, 0] }}]\n\
             [output]\nframes = 1\npictures = []\nmesh = \"none\"\ndocuments = \"last\"\n"
        );
        std::fs::write(&scene, format!("{GROUND}{stroke}")).unwrap();
        run(&scene, &out, None);
        // The scene goes on from there.
        std::fs::copy(path(image), out.join(image)).unwrap();
        let found = colors(&scene, &out.join("document-000000-ground.relievo"), &[[-0.2, 0.1], [0.2, 0.1]]);
        for (found, expected) in found.into_iter().zip([[1.0, 0.25, 0.0], [0.0, 0.0, 0.5]]) {
            assert!((found.truncate() - Vec3::from(expected)).abs().max_element() < 0.01, "{image}: {found}");
        }
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn a_list_of_strokes_is_the_same_on_a_graphics_device() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let stroke = |sculpt: &str, place: &str| {
        format!("[[strokes]]\nsculpt = \"{sculpt}\"\nheight = 0.1\nradius = 0.6\npoints = [{place}]\n")
    };
    let there = "{ position = [-0.5, 0, 0] }, { position = [0.5, 0.4, 0] }";
    let list =
        format!("version = 1\n{}{}{MORE}", stroke("draw", there), stroke("smooth", "{ position = [0.3, 0.2, 0] }"));
    std::fs::write(path("list.toml"), list).unwrap();
    let context = Context::serial();
    let heights = |device: Option<relievo_gpu::Device>, name: &str| {
        let wanted = Replay {
            triangles: false,
            isolation: None,
            mesh: cage(folder.path()),
            strokes: path("list.toml"),
            document: None,
            outputs: vec![path(name)],
            allowed: Vec::new(),
            device,
        };
        let (done, notes) = replay(&context, &wanted, &mut Silent).unwrap();
        assert!(done.dabs > 4 && notes.is_empty(), "{notes:?}");
        relievo_meshio::read(&context, &path(name)).unwrap().points
    };
    let [here, there] = [heights(None, "cpu.ply"), heights(Some(device), "gpu.ply")];
    assert_eq!(here.len(), there.len());
    assert!(here.iter().any(|point| point[2] > 0.05));
    for (a, b) in here.iter().zip(&there) {
        // One step of a half float at these heights.
        assert!((a[2] - b[2]).abs() < 2e-4 && a[..2] == b[..2], "{a:?} {b:?}");
    }
}
