//! `relievo decal` as a user sees it.

#![cfg(feature = "decal")]

mod program;

use std::fmt::Write;
use std::path::Path;

use relievo_document::{Document, Kind};
use relievo_render::{Channel, Content, Image, Layer, Samples, read_png, write_exr, write_png};
use serde_json::Value;

use program::{done, relievo, text};

/// A plane of 6 by 6 quads from -3 to 3 that faces z, and a red image of 60 by 40 pixels.
fn files(folder: &Path) {
    let mut plane = String::new();
    for index in 0..49 {
        writeln!(plane, "v {} {} 0", index % 7 - 3, index / 7 - 3).unwrap();
    }
    for index in 0..36 {
        let first = index / 6 * 7 + index % 6 + 1;
        writeln!(plane, "f {} {} {} {}", first, first + 1, first + 8, first + 7).unwrap();
    }
    std::fs::write(folder.join("plane.obj"), plane).unwrap();
    let mut image = Image::new(60, 40, 3).unwrap();
    for y in 0..40 {
        for x in 0..60 {
            image.set_color(x, y, [1.0, 0.0, 0.0]);
        }
    }
    write_png(&folder.join("red.png"), &image).unwrap();
}

/// Counts the red pixels of a picture.
fn count_red(path: &Path) -> usize {
    let picture = read_png(path, u64::MAX).unwrap();
    let pixels = picture.data().chunks_exact(picture.channels() as usize);
    pixels.filter(|pixel| pixel[0] > 0.1 && pixel[1] < 0.05).count()
}

/// Pins that make the image 3 units wide, its centre at the origin.
const PINS: [&str; 6] = ["--pin", "10,10@-1,0.5,0", "--pin", "50,10@1,0.5,0", "--pin", "30,30@0,-0.5,0"];

#[test]
fn a_sticker_becomes_a_mesh_with_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    let refused = relievo(
        folder,
        &[&["decal", "mesh", "plane.obj", "-o", "none.obj", "--image", "red.png", "--depth", "1"][..], &PINS].concat(),
    );
    let said = text(&refused.stderr);
    assert!(!refused.status.success() && said.contains("1 depths for 3 pins"), "{said}");
    let info = |more: &[&str]| -> Value {
        let arguments = [&["decal", "info", "plane.obj", "--size", "60x40", "--json"][..], &PINS, more].concat();
        serde_json::from_str(&done(folder, &arguments)).unwrap()
    };
    let laid = info(&["--picture", "checker.png"]);
    assert_eq!((laid["coverage"].as_f64(), laid["flips"].as_u64()), (Some(1.0), Some(0)));
    assert!((laid["l2"].as_f64().unwrap() - 1.0).abs() < 1e-5, "{laid}");
    let picture = read_png(&folder.join("checker.png"), u64::MAX).unwrap();
    let is_blue = |pixel: &&[f32]| pixel[2] > 2.0 * pixel[0] && pixel[2] > 0.02;
    let is_yellow = |pixel: &&[f32]| pixel[0] > 1.2 * pixel[2] && pixel[0] > 0.1;
    let pixels = || picture.data().chunks_exact(picture.channels() as usize);
    assert!(pixels().filter(is_blue).count() > 10_000 && pixels().filter(is_yellow).count() > 10_000);
    assert_eq!(info(&["--outline", "0,0 60,0 60,32 40,40 0,40"])["coverage"].as_f64(), Some(1.0));
    let text = done(folder, &[&["decal", "info", "plane.obj", "--size", "60x40"][..], &PINS].concat());
    assert!(text.contains("covered                100.00 %") && text.contains("flipped triangles      0"), "{text}");

    for (file, mark) in [("out.obj", "vt "), ("out.glb", "TEXCOORD_0"), ("out.usda", "primvars:st")] {
        if file.ends_with("usda") && !cfg!(feature = "openusd") {
            continue;
        }
        let arguments = ["decal", "mesh", "plane.obj", "-o", file, "--image", "red.png", "--offset", "0.01"];
        done(folder, &[&arguments[..], &PINS].concat());
        let bytes = std::fs::read(folder.join(file)).unwrap();
        assert!(bytes.windows(mark.len()).any(|window| window == mark.as_bytes()), "{file} has no {mark}");
    }
}

#[test]
fn images_of_stickers_may_be_exr_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    let channel = |(name, value): (&str, f32)| Channel { name: name.into(), samples: Samples::F32(vec![value; 2400]) };
    let channels = [("R", 0.5), ("G", 0.0), ("B", 0.0), ("A", 0.5)].map(channel).to_vec();
    let layer = Layer { name: None, width: 60, height: 40, channels, attributes: Vec::new() };
    write_exr(&folder.join("red.exr"), &[layer], Content::Color).unwrap();
    let layers = |image: &str, more: &[&str]| {
        let arguments = ["decal", "apply", "plane.obj", "-o", "made.relievo", "--cells", "2", "--texels", "32"];
        done(folder, &[&arguments[..], &PINS, &["--image", image], more].concat());
        Document::open(&folder.join("made.relievo"), u64::MAX).unwrap().layer("decal").unwrap().blocks().to_vec()
    };
    // Its red of a half is multiplied by the alpha of a half: the same as whole red of which half is seen.
    assert!(layers("red.exr", &[]) == layers("red.png", &["--opacity", "0.5"]));
    done(folder, &["decal", "update", "plane.obj", "made.relievo", "--image", "red.png"]);
    let refused = relievo(folder, &["decal", "update", "plane.obj", "made.relievo", "--image", "red.exr"]);
    assert!(!refused.status.success(), "the image is another one");
    done(folder, &["decal", "update", "plane.obj", "made.relievo", "--image", "red.exr", "--replace"]);
}

#[test]
fn a_sticker_is_painted_and_embossed_into_layers_of_a_document() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    let apply = |more: &[&str]| {
        let arguments = ["decal", "apply", "plane.obj", "--image", "red.png", "--cells", "4"];
        relievo(folder, &[&arguments[..], &PINS, more].concat())
    };
    let painted =
        apply(&["-o", "painted.relievo", "--layer", "logo", "--texels", "32", "--picture", "painted.png", "--json"]);
    assert!(painted.status.success(), "{}", text(&painted.stderr));
    let report: Value = serde_json::from_str(&text(&painted.stdout)).unwrap();
    // The sticker is 3 by 2 units, a face of the cage one by one with 32 by 32 texels.
    let texels = report["texels"].as_f64().unwrap();
    assert!((texels / (6.0 * 32.0 * 32.0) - 1.0).abs() < 0.1, "{report}");
    let document = Document::open(&folder.join("painted.relievo"), u64::MAX).unwrap();
    let layer = document.layer("logo").expect("a layer");
    assert!(layer.kind() == Kind::Rgba8 && layer.blocks().len() >= 6);
    assert!(count_red(&folder.join("painted.png")) > 20_000);

    let raised =
        apply(&["-o", "raised.relievo", "--document", "painted.relievo", "--layer", "relief", "--height", "0.2"]);
    assert!(raised.status.success(), "{}", text(&raised.stderr));
    let document = Document::open(&folder.join("raised.relievo"), u64::MAX).unwrap();
    assert!(document.layer("logo").is_some());
    let relief = document.layer("relief").expect("a layer");
    assert!(relief.kind() == Kind::Scalar && !relief.blocks().is_empty());
    assert_eq!(document.recipes().len(), 2, "each decal is in a layer of its own");

    // A pin moves: the same as if it had been there at first, in the same document.
    let update = |more: &[&str]| {
        let arguments = ["decal", "update", "plane.obj", "raised.relievo", "--image", "red.png"];
        relievo(folder, &[&arguments[..], more].concat())
    };
    let changed = update(&["--layer", "logo", "--move", "0@-0.9,0.55,0", "--json"]);
    assert!(changed.status.success(), "{}", text(&changed.stderr));
    let report: Value = serde_json::from_str(&text(&changed.stdout)).unwrap();
    assert!(report["flips"] == 0 && report["l2"].as_f64().unwrap() > 1.0001, "{report}");
    let after = Document::open(&folder.join("raised.relievo"), u64::MAX).unwrap();
    assert_eq!((after.layers().len(), after.recipes().len()), (document.layers().len(), 2));
    let blocks = |document: &Document, name: &str| document.layer(name).expect("a layer").blocks().to_vec();
    assert!(
        blocks(&after, "relief") == blocks(&document, "relief") && blocks(&after, "logo") != blocks(&document, "logo")
    );
    for (more, why) in [
        (["--layer", "logo", "--move", "9@1,1,0"], "pins, counted from 0"),
        (["--layer", "none", "--move", "0@1,1,0"], "no decal lies in a layer"),
    ] {
        let refused = update(&more);
        assert!(!refused.status.success() && text(&refused.stderr).contains(why), "{}", text(&refused.stderr));
    }

    for (more, why) in [
        (&["--document", "painted.relievo", "--layer", "logo", "--height", "1"][..], "layer `logo`"),
        (&["--opacity", "2"], "opacity"),
        (&["--depth", "1"], "1 depths for 3 pins"),
        (&["--texels", "7"], "7"),
        (&["--document", "absent.relievo"], "absent.relievo"),
        (&["--pin", "70,20@0,0,0"], "outside"),
        (&["--pin", "1,2,3"], "no @"),
    ] {
        let refused = apply(&[more, &["-o", "none.relievo"]].concat());
        let said = text(&refused.stderr);
        assert!(!refused.status.success() && said.contains(why), "{why}: {said}");
    }
    assert!(!folder.join("none.relievo").exists());
}

#[test]
fn stickers_are_cut_along_their_alpha_and_lie_along_curves() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    // A disk of 15 pixels around the middle of the image.
    let mut disk = Image::new(60, 40, 4).unwrap();
    for (index, pixel) in disk.data_mut().chunks_exact_mut(4).enumerate() {
        let (x, y) = (index % 60, index / 60);
        let away = (x as f32 - 29.5).hypot(y as f32 - 19.5);
        pixel.copy_from_slice(&[0.0, 1.0, 0.0, (15.5 - away).clamp(0.0, 1.0)]);
    }
    write_png(&folder.join("disk.png"), &disk).unwrap();
    let info = |more: &[&str]| -> Value {
        let arguments = [&["decal", "info", "plane.obj", "--json"][..], more].concat();
        serde_json::from_str(&done(folder, &arguments)).unwrap()
    };
    let cut = info(&["--image", "disk.png", "--contour", "0.5", "--pin", "20,20@-0.5,0,0", "--pin", "40,20@0.5,0,0"]);
    let whole = info(&["--image", "disk.png", "--pin", "20,20@-0.5,0,0", "--pin", "40,20@0.5,0,0"]);
    assert_eq!((cut["coverage"].as_f64(), whole["coverage"].as_f64()), (Some(1.0), Some(1.0)));
    assert!(cut["triangles"].as_u64() < whole["triangles"].as_u64(), "{cut} {whole}");

    let along = info(&["--size", "200x20", "--along", "-2,0,0 0,0.4,0 2,0,0"]);
    assert!((along["length"].as_f64().unwrap() - 2.0 * 4.16_f64.sqrt()).abs() < 1e-5, "{along}");
    assert_eq!(along["flips"].as_u64(), Some(0));
    for (arguments, why) in [
        (&["--image", "red.png", "--contour", "0.5", "--pin", "1,1@0,0,0", "--width", "1"][..], "no alpha"),
        (&["--image", "disk.png", "--contour", "2", "--pin", "1,1@0,0,0", "--width", "1"], "the level is 2"),
        (&["--size", "9x9", "--contour", "0.5", "--pin", "1,1@0,0,0"], "--image"),
        (&["--size", "9x9", "--along", "0,0,0"], "1 places"),
        (&["--size", "9x9"], "--pin"),
    ] {
        let refused = relievo(folder, &[&["decal", "info", "plane.obj"][..], arguments].concat());
        let said = text(&refused.stderr);
        assert!(!refused.status.success() && said.contains(why), "{why}: {said}");
    }
}

#[test]
fn a_sticker_is_painted_and_embossed_on_the_triangles_of_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    let apply = |more: &[&str]| {
        let arguments = ["decal", "apply", "plane.obj", "--image", "red.png", "--texels", "16"];
        relievo(folder, &[&arguments[..], &PINS, more].concat())
    };
    let painted = apply(&["-o", "painted.relievo", "--triangles", "--picture", "painted.png", "--json"]);
    assert!(painted.status.success(), "{}", text(&painted.stderr));
    let report: Value = serde_json::from_str(&text(&painted.stdout)).unwrap();
    // The sticker is 3 by 2 units, and touches at most 5 by 4 squares of two triangles.
    let faces = report["tiles"].as_u64().unwrap();
    assert!((12..=40).contains(&faces) && report["refused"] == 0, "{report}");
    assert!(count_red(&folder.join("painted.png")) > 20_000);

    // The document is of triangles, so that the flag is not needed again.
    let raised =
        apply(&["-o", "raised.relievo", "--document", "painted.relievo", "--layer", "relief", "--height", "0.2"]);
    assert!(raised.status.success(), "{}", text(&raised.stderr));
    let document = Document::open(&folder.join("raised.relievo"), u64::MAX).unwrap();
    assert!(document.topology().is_of_triangles() && document.recipes().len() == 2);
    assert!(document.layer("decal").is_some_and(|layer| layer.kind() == Kind::Rgba8 && !layer.blocks().is_empty()));
    assert!(document.layer("relief").is_some_and(|layer| layer.kind() == Kind::Scalar && !layer.blocks().is_empty()));
    done(folder, &["doc", "export", "raised.relievo", "plane.obj", "-o", "raised.ply"]);
    let mesh = relievo_meshio::read(&relievo_core::Context::serial(), &folder.join("raised.ply")).unwrap();
    let relievo_core::Values::F32(colors) = &mesh.attribute("color").unwrap().values else { panic!() };
    let mut counts = [0; 2];
    for (point, color) in mesh.points.iter().zip(colors.chunks_exact(3)) {
        let [x, y, z] = point.map(f64::from);
        // Red has a luminance of 0.2126. A segment is up to 0.09 long.
        let (part, red, height) = match (x.abs() - 1.5).max(y.abs() - 1.0) {
            away if away > 0.1 => (0, 0.5, 0.0),
            away if away < -0.1 => (1, 1.0, 0.2 * 0.2126),
            _ => continue,
        };
        counts[part] += 1;
        assert!((f64::from(color[0]) - red).abs() < 0.01 && (z - height).abs() < 1e-3, "{point:?} {color:?}");
    }
    assert!(counts[0] > 30 && counts[1] > 500, "{counts:?}");

    // A pin moves, one layer changes; then the decal is gone with its layer and its recipe.
    let change = |task: &str, more: &[&str]| {
        done(folder, &[&["decal", task, "plane.obj", "raised.relievo"][..], more].concat());
        Document::open(&folder.join("raised.relievo"), u64::MAX).unwrap()
    };
    let blocks = |document: &Document, name: &str| document.layer(name).expect("a layer").blocks().to_vec();
    let moved = change("update", &["--image", "red.png", "--move", "0@-0.9,0.55,0", "--opacity", "0.5"]);
    assert!(
        blocks(&moved, "relief") == blocks(&document, "relief")
            && blocks(&moved, "decal") != blocks(&document, "decal")
    );
    assert_eq!((moved.layer("decal").unwrap().settings().opacity, moved.recipes().len()), (0.5, 2));
    let removed = change("remove", &["--layer", "decal"]);
    assert!(removed.layer("decal").is_none() && blocks(&removed, "relief") == blocks(&document, "relief"));
    assert_eq!(removed.recipes().len(), 1);
    let gone = relievo(folder, &["decal", "remove", "plane.obj", "raised.relievo", "--layer", "decal"]);
    assert!(!gone.status.success() && text(&gone.stderr).contains("no decal lies in a layer"));

    let refused =
        apply(&["-o", "none.relievo", "--document", "painted.relievo", "--layer", "decal", "--height", "0.2"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("the layer holds"));
    assert!(!folder.join("none.relievo").exists());
}

#[test]
fn a_sticker_is_painted_into_a_texture_with_a_gutter() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder);
    // Two islands: the left half of the plane below, the right half above, with pixels between them.
    let mut plane = std::fs::read_to_string(folder.join("plane.obj")).unwrap();
    let faces = plane.split_off(plane.find("f ").unwrap());
    for side in 0..2 {
        for index in 0..49 {
            let (column, row) = (f64::from(index % 7), f64::from(index / 7));
            let (u, v) =
                (0.125 * column - 0.375 * f64::from(side) + 0.125, 0.0625 * row + 0.0625 + 0.5 * f64::from(side));
            writeln!(plane, "vt {u} {v}").unwrap();
        }
    }
    for (index, face) in faces.lines().enumerate() {
        let first = if index % 6 < 3 { 0 } else { 49 };
        let corners = face.split_whitespace().skip(1).map(|corner| corner.parse::<usize>().unwrap());
        let corners: Vec<String> = corners.map(|corner| format!("{corner}/{}", first + corner)).collect();
        writeln!(plane, "f {}", corners.join(" ")).unwrap();
    }
    std::fs::write(folder.join("islands.obj"), plane).unwrap();
    let paint = |more: &[&str]| {
        let arguments = ["decal", "texture", "islands.obj", "-o", "painted.png", "--image", "red.png", "--json"];
        let size = ["--texture-size", "128x128"];
        relievo(folder, &[&arguments[..], &size, &PINS, more].concat())
    };
    let painted = paint(&["--gutter", "3"]);
    assert!(painted.status.success(), "{}", text(&painted.stderr));
    let report: Value = serde_json::from_str(&text(&painted.stdout)).unwrap();
    // The sticker is 3 by 2 units, a unit 16 by 8 pixels.
    assert_eq!(report["pixels"].as_u64(), Some(3 * 2 * 16 * 8), "{report}");
    let picture = read_png(&folder.join("painted.png"), u64::MAX).unwrap();
    let is_red = |x: u32, y: u32| picture.color(x, y)[0] > 0.9 && picture.color(x, y)[1] < 0.1;
    // The middle of the plane is at u = 0.5 of the island below and at u = 0.125 of that above.
    let below = 127 - 32;
    assert!(is_red(63, below) && is_red(64, below) && is_red(66, below) && !is_red(67, below));
    let above = 127 - 96;
    assert!(is_red(16, above) && is_red(13, above) && !is_red(12, above));
    assert_eq!(report["gutter"].as_u64(), Some(2 * 3 * 16));

    let refused =
        relievo(folder, &[&["decal", "texture", "plane.obj", "-o", "a.png", "--image", "red.png"][..], &PINS].concat());
    assert!(!refused.status.success() && text(&refused.stderr).contains("no texture coordinates"));
    assert!(!folder.join("a.png").exists());
}
