//! `[[decals]]` of scenes.

use relievo_core::{Context, Values};
use relievo_document::Document;
use relievo_render::{Channel, Content, Image, Layer, Samples, read_png, write_exr, write_png};
use relievo_scene::file::{parse, read_file};
use relievo_scene::world::World;

use crate::support::{bytes, run_in};

const GROUND: &str = concat!(
    painted_ground!(),
    seen_from_above!(),
    r##"samples = 2
pictures = ["beauty"]
documents = "every"
mesh = "none"
"##,
);

/// A square of 2 by 2 units, of which each pixel is 0.1, around (1, 0).
const PINS: &str = r##"pins = [
    { image = [5, 5], position = [0.5, 0.5, 0] }, { image = [15, 5], position = [1.5, 0.5, 0] },
    { image = [10, 15], position = [1, -0.5, 0] },
]
"##;

/// A red square whose corner pixels are transparent.
fn image() -> Image {
    let mut image = Image::new(20, 20, 4).unwrap();
    for y in 0..20 {
        for x in 0..20 {
            image.set_color(x, y, [1.0, 0.0, 0.0]);
        }
    }
    for (at, pixel) in image.data_mut().chunks_exact_mut(4).enumerate() {
        let (x, y) = (at % 20, at / 20);
        pixel[3] = f32::from(u8::from((3..=16).contains(&x) || (3..=16).contains(&y)));
    }
    image
}

#[test]
fn decals_are_painted_and_embossed_at_their_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_png(&folder.join("red.png"), &image()).unwrap();
    let text = format!(
        "{GROUND}[[decals]]\nimage = \"red.png\"\ncontour = 0.5\ntime = 0.1\n{PINS}\
         [[decals]]\nimage = \"red.png\"\nheight = 0.2\ntime = 0.2\n{PINS}"
    );
    run_in(folder, "label", &text, None, 2);
    let document = |frame: u32| {
        let path = folder.join(format!("label/document-{frame:06}-ground.relievo"));
        Document::open(&path, u64::MAX).unwrap()
    };
    let blocks = |document: &Document, layer: &str| document.layer(layer).map_or(0, |layer| layer.blocks().len());
    assert_eq!((blocks(&document(0), "colour"), blocks(&document(0), "displacement")), (0, 0));
    // The square covers 4 by 4 of the faces, and its border lies on their neighbours.
    let painted = blocks(&document(1), "colour");
    assert!((16..=36).contains(&painted), "{painted} tiles");
    assert_eq!(blocks(&document(1), "displacement"), 0);
    assert!(blocks(&document(2), "displacement") >= 16);
    let picture = |frame: u32| read_png(&folder.join(format!("label/beauty-{frame:06}.png")), u64::MAX).unwrap();
    let is_red = |image: &Image, x: u32, y: u32| {
        let [red, green, _] = image.color(x, y);
        red > 4.0 * green
    };
    assert!(!is_red(&picture(0), 32, 32) && is_red(&picture(1), 32, 32));
    run_in(folder, "again", &text, None, 1);
    assert_eq!(document(2).to_bytes().unwrap(), {
        let path = folder.join("again/document-000002-ground.relievo");
        Document::open(&path, u64::MAX).unwrap().to_bytes().unwrap()
    });
}

/// An EXR file of a square whose left half is red and whose right half is dim blue with an alpha of a half.
fn write_halves(path: &std::path::Path) {
    let pixel = |at: u32| if at % 20 < 10 { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 0.0, 0.125, 0.5f32] };
    let channel = |(index, name): (usize, &str)| Channel {
        name: name.into(),
        samples: Samples::F32((0..400).map(|at| pixel(at)[index]).collect()),
    };
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect();
    let layer = Layer { name: None, width: 20, height: 20, channels, attributes: Vec::new() };
    write_exr(path, &[layer], Content::Color).unwrap();
}

#[test]
fn decals_are_painted_and_embossed_on_triangle_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_halves(&folder.join("halves.exr"));
    let ground = GROUND
        .replace("mesh = \"ground\"", "mesh = \"ground\"\nkind = \"triangles\"")
        .replace("tile_size = 16\npaint_size = 32", "segments = 16")
        .replace("mesh = \"none\"", "mesh = \"every\"\nmesh_formats = [\"ply\"]");
    let text = format!(
        "{ground}[[decals]]\nimage = \"halves.exr\"\ntime = 0.1\n{PINS}\
         [[decals]]\nimage = \"halves.exr\"\nheight = 0.2\ntime = 0.2\n{PINS}"
    );
    run_in(folder, "label", &text, None, 2);
    // The second one lies on the surface that the first one left flat.
    let linear = |red: f64, green: f64, blue: f64| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    for (frame, is_painted, height) in [(0, 0.0, 0.0), (1, 1.0, 0.0), (2, 1.0, 0.2)] {
        let path = folder.join(format!("label/mesh-{frame:06}-ground.ply"));
        let mesh = relievo_meshio::read(&Context::serial(), &path).unwrap();
        let Values::F32(colors) = &mesh.attribute("color").unwrap().values else { panic!() };
        let mut counts = [0; 3];
        for (point, color) in mesh.points.iter().zip(colors.chunks_exact(3)) {
            let [x, y, z] = point.map(f64::from);
            let away = (x - 1.0).abs().max(y.abs());
            // A segment is 0.03 long, a pixel 0.1.
            let (part, expected, raised) = match (away, x) {
                (away, _) if away > 1.04 => (0, [0.5; 3], 0.0),
                (away, x) if away < 0.9 && x < 0.9 => (1, [1.0, 0.0, 0.0], linear(1.0, 0.0, 0.0)),
                (away, x) if away < 0.9 && x > 1.1 => (2, [0.25, 0.25, 0.375], 0.5 * linear(0.0, 0.0, 0.25)),
                _ => continue,
            };
            counts[part] += 1;
            for (found, expected) in color.iter().zip(expected) {
                let expected = 0.5 + is_painted * (expected - 0.5);
                assert!((f64::from(*found) - expected).abs() < 0.01, "{frame} {point:?} {color:?}");
            }
            assert!((z - height * raised).abs() < 1e-3, "{frame} {point:?}");
        }
        assert!(frame == 0 || counts.iter().all(|count| *count > 500), "{counts:?}");
    }
    run_in(folder, "again", &text, None, 1);
    let file = "document-000002-ground.relievo";
    assert_eq!(bytes(folder, "label", file), bytes(folder, "again", file));
    // Too little memory leaves a part out, and says where.
    let text = text.replace("segments = 16", "segments = 64\nbudget = 65536");
    let summary = run_in(folder, "small", &text, None, 1);
    assert!(summary.notes.iter().any(|note| note.contains("faces") && note.contains("ground")), "{:?}", summary.notes);
}

#[test]
fn strips_and_single_pins_are_laid() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_png(&folder.join("red.png"), &image()).unwrap();
    let strip = "strip = true\noutline = [[0, 8], [20, 8], [20, 12], [0, 12]]\n\
                 pins = [{ position = [0, 0.5, 0] }, { position = [1, 0.7, 0] }, { position = [2, 0.5, 0] }]\n";
    let one = "width = 1\nup = [0, 1, 0]\npins = [{ image = [10, 10], position = [1, 0, 0] }]\n";
    for (name, decal) in [("strip", strip), ("one", one)] {
        let text = format!("{GROUND}[[decals]]\nobject = \"ground\"\nimage = \"red.png\"\n{decal}");
        run_in(folder, name, &text, Some((0, 0)), 1);
        let path = folder.join(name).join("document-000000-ground.relievo");
        let document = Document::open(&path, u64::MAX).unwrap();
        let blocks = document.layer("colour").unwrap().blocks().len();
        assert!((4..=20).contains(&blocks), "{name}: {blocks} tiles");
    }
}

#[test]
fn wrong_decals_are_told() {
    for (decal, expected) in [
        ("image = \"a.png\"\n", "0 pins"),
        ("image = \"a.png\"\npins = [{ position = [0, 0, 0] }]\n", "no point of the image"),
        ("image = \"a.png\"\npins = [{ image = [1, 2], position = [0, 0, 0] }]\n", "one pin gives no size"),
        ("image = \"a.png\"\nstrip = true\npins = [{ image = [1, 2], position = [0, 0, 0] }]\n", "pins of a strip"),
        ("image = \"a.png\"\nwidth = 1\npins = [{ image = [1, 2] }]\n", "has no place"),
        ("image = \"a.png\"\nwidth = 1\npins = [{ image = [1, 2, 3], position = [0, 0, 0] }]\n", "a pair of numbers"),
        ("width = 1\npins = [{ image = [1, 2], position = [0, 0, 0] }]\n", "has no image"),
        ("image = \"a.png\"\ncontour = 0.5\noutline = [[0, 0]]\n", "two outlines"),
        ("image = \"a.png\"\nobject = \"grund\"\n", "did you mean `ground`"),
        ("image = \"a.png\"\ncells = 7\n", "power of two"),
    ] {
        let text = format!("{GROUND}[[decals]]\n{decal}");
        let said = parse("a.toml".as_ref(), &text).unwrap_err().to_string();
        assert!(said.contains(expected), "{decal:?} should say {expected:?}, but said {said}");
    }
}

#[test]
fn images_that_are_missing_or_changed_matter() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, format!("{GROUND}[[decals]]\nimage = \"red.png\"\n{PINS}")).unwrap();
    let world = || World::new(&Context::serial(), read_file(&scene).unwrap(), &[]);
    let said = world().map(drop).unwrap_err().to_string();
    assert!(said.contains("red.png"), "{said}");
    let mut red = image();
    write_png(&folder.path().join("red.png"), &red).unwrap();
    let before = world().unwrap().fingerprint();
    assert_eq!(before, world().unwrap().fingerprint());
    red.set_color(3, 3, [0.0, 1.0, 0.0]);
    write_png(&folder.path().join("red.png"), &red).unwrap();
    assert_ne!(before, world().unwrap().fingerprint());
}
