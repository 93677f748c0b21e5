//! Documents are made of Ptex files and taken along as files of all kinds.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DAffine3, Vec4};
use half::f16;
use relievo_core::{Context, Values};
use relievo_detail::{LayeredObject, TriangleObject};
use relievo_document::Document;
use relievo_ptex::{Borders, DataType, Face, Format, MeshType, Reader, Writer};
use relievo_render::{Value, read_exr, read_png};
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{Pattern, TriangleChannel, TriangleOptions, TriangleSets, TriangleValues};
use relievo_tiles::{ColorTexel, Rgba8};

fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().expect("relievo runs")
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = relievo(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn fails(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = relievo(folder, arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
    assert!(words.iter().all(|word| text.contains(word)), "{arguments:?}: {text}");
}

/// Two quads whose texture coordinates fill the UDIM tiles 1001 and 1002.
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 2 0\nvt 2 1\n\
                    f 1/1 2/2 5/3 4/4\nf 2/2 3/5 6/6 5/3\n";

/// A file of one number per face.
fn heights(path: &Path, data_type: DataType, channels: u16, values: [f32; 2]) {
    let format = Format { mesh: MeshType::Quad, data_type, channels, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 2).unwrap();
    for (face, value) in (0..).zip(values) {
        let value = data_type.encode(&vec![value; usize::from(channels)]);
        writer.set_constant(face, &Face::new(4, 4), &value).unwrap();
    }
    writer.write(path).unwrap();
}

#[test]
fn a_document_of_a_ptex_file_is_taken_along() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("mesh.obj"), MESH).unwrap();
    heights(&at("heights.ptx"), DataType::F16, 1, [0.25, 0.25]);
    let text = succeeds(folder.path(), &["doc", "import", "heights.ptx", "mesh.obj", "-o", "a.relievo"]);
    assert!(text.contains("2 faces, 2 of them constant") && text.contains("layer `displacement`"), "{text}");
    let export = |output: &str, more: &[&str]| {
        let first = ["doc", "export", "a.relievo", "mesh.obj", "-o", output];
        succeeds(folder.path(), &[&first[..], more].concat())
    };

    export("back.ptx", &[]);
    let back = Reader::open(&at("back.ptx"), u64::MAX).unwrap();
    assert_eq!((back.face_count(), back.format().data_type), (2, DataType::F16));
    let values = DataType::F16.decode(&back.texels(1).unwrap());
    assert!(values.len() == 256 && values.iter().all(|value| (value - 0.25).abs() < 1e-3));

    let text = export("d.exr", &["--bake", "displacement", "--size", "32", "--udim", "--dilate", "0"]);
    assert!(text.contains("d.1001.exr") && text.contains("2048 pixels covered") && text.contains("scale 1"), "{text}");
    let layer = read_exr(&at("d.1002.exr"), u64::MAX).unwrap().remove(0);
    assert!(layer.channel("Y").unwrap().to_f32().iter().all(|value| (value - 0.25).abs() < 1e-3));
    assert!(matches!(&layer.attributes[0].1, Value::Text(text) if text.contains("object units")));
    let text = export("d_<UDIM>.png", &["--bake", "normal", "--size", "16x8", "--udim", "--samples", "2"]);
    assert!(text.contains("d_1002.png"), "{text}");
    let image = read_png(&at("d_1002.png"), u64::MAX).unwrap();
    assert_eq!((image.width(), image.height(), image.channels()), (16, 8, 3));

    let text = export("t.exr", &["--atlas"]);
    assert!(text.contains("t.exr: 36 x 18 pixels, 2 tiles") && text.contains("t.exr.toml"), "{text}");
    succeeds(folder.path(), &["doc", "import", "t.exr.toml", "mesh.obj", "-o", "b.relievo"]);
    let info = |name: &str| succeeds(folder.path(), &["info", name]).lines().last().map(ToString::to_string);
    assert_eq!(info("a.relievo"), info("b.relievo"));
    let text = export("t.png", &["--tiles"]);
    // The files are called what the command says.
    let names: Vec<&str> = text.trim_end().trim_end_matches(": 2 tiles").split(" to ").collect();
    assert!(names == ["t.0.png", "t.1.png"] && names.iter().all(|name| at(name).exists()), "{text}");

    for (output, start) in [("m.ply", "ply"), ("m.obj", "# Relievo"), ("m.glb", "glTF")] {
        let text = export(output, &["--cells", "4"]);
        assert!(text.contains("64 triangles"), "{text}");
        assert!(std::fs::read(at(output)).unwrap().starts_with(start.as_bytes()));
    }
}

#[test]
fn colours_and_wrong_use() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("mesh.obj"), MESH).unwrap();
    std::fs::write(at("bare.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 5 4\nf 2 3 6 5\n")
        .unwrap();
    std::fs::write(at("other.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    heights(&at("c.ptx"), DataType::U8, 3, [1.0, 0.5]);
    let import = |mesh: &'static str, more: &[&'static str]| {
        [&["doc", "import", "c.ptx", mesh, "-o", "c.relievo"][..], more].concat()
    };
    fails(folder.path(), &import("other.obj", &[]), &["c.ptx", "it has 2 faces, and the mesh takes 1", "same order"]);
    assert!(!at("c.relievo").exists());
    let text = succeeds(folder.path(), &import("mesh.obj", &[]));
    assert!(text.contains("layer `colour`"), "{text}");
    let export = |output: &'static str, more: &[&'static str]| {
        [&["doc", "export", "c.relievo", "mesh.obj", "-o", output][..], more].concat()
    };
    succeeds(folder.path(), &export("c.png", &["--bake", "colour", "--size", "8", "--dilate", "0"]));
    let image = read_png(&at("c.png"), u64::MAX).unwrap();
    // Of UDIM tile 1001.
    assert_eq!(image.pixel(2, 3), [1.0; 4]);
    fails(folder.path(), &export("d.exr", &["--bake", "displacement"]), &["no displacement", "relievo info"]);
    fails(folder.path(), &export("d.exr", &[]), &["add --bake", "--atlas"]);
    fails(folder.path(), &export("d.jpg", &[]), &["d.jpg", ".ptx, .exr"]);
    fails(folder.path(), &export("d.exr", &["--bake", "colour", "--size", "99999"]), &["1 to 32768"]);
    fails(folder.path(), &export("d.ptx", &["--layer", "color"]), &["no layer `color`", "perhaps `colour`"]);
    let bare = ["doc", "export", "c.relievo", "bare.obj", "-o", "d.exr", "--bake", "colour"];
    fails(folder.path(), &bare, &["bare.obj", "no attribute `uv`", "unwrap the mesh"]);
    let other = ["doc", "export", "c.relievo", "other.obj", "-o", "d.exr", "--bake", "colour"];
    fails(folder.path(), &other, &["other.obj", "another mesh"]);
    assert!(!at("d.exr").exists() && !at("d.ptx").exists());
}

/// A document of two triangles of which one corner is 0.5 higher, and what paints the other.
fn triangles(folder: &Path) {
    let context = Context::serial();
    let mesh = relievo_meshio::read(&context, &folder.join("mesh.obj")).unwrap();
    let surface = TriangleSurface::new(&context, &mesh).unwrap();
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: 8, budget: 1 << 20 };
    let mut heights = TriangleChannel::displacement(topology.clone(), &options).unwrap();
    let mut colors = TriangleChannel::of_color(topology, Vec4::ONE, &options).unwrap();
    let sets = TriangleSets { allocate: vec![0, 1], ..Default::default() };
    heights.apply(&context, Pattern::new(8).unwrap(), &sets).unwrap();
    heights.write(TriangleValues { vertices: vec![(0, f16::from_f32(0.5))], ..Default::default() }).unwrap();
    let red = Rgba8::of_color(Vec4::new(1.0, 0.0, 0.0, 1.0));
    colors.write(TriangleValues { vertices: vec![(3, red)], ..Default::default() }).unwrap();
    let mut object = TriangleObject::new(&context, surface, heights, DAffine3::IDENTITY).unwrap();
    object.set_paint(colors).unwrap();
    let mut document = Document::of_triangles(&mesh, context.level().name()).unwrap();
    object.store(&context, &mut document).unwrap();
    document.write(&folder.join("t.relievo")).unwrap();
}

#[test]
fn documents_of_triangle_meshes_are_taken_along_as_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let square = format!("{points}f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    std::fs::write(folder.path().join("mesh.obj"), &square).unwrap();
    std::fs::write(folder.path().join("other.obj"), square.replace("f 1/1 3/3 4/4", "f 1/1 4/4 3/3")).unwrap();
    triangles(folder.path());
    let export = |output: &'static str| vec!["doc", "export", "t.relievo", "mesh.obj", "-o", output];
    let text = succeeds(folder.path(), &export("t.ply"));
    let read = |name: &str| relievo_meshio::read(&Context::serial(), &folder.path().join(name)).unwrap();
    let made = read("t.ply");
    assert!(text.contains(&format!("{} points, {} triangles", made.points.len(), made.face_count())), "{text}");
    assert!(made.face_count() > 100);
    let top = made.points.iter().map(|point| point[2]).fold(f32::MIN, f32::max);
    assert_eq!(top, 0.5);
    let Values::F32(colors) = &made.attribute("color").unwrap().values else { panic!() };
    assert!(colors.chunks(3).any(|color| color[0] > 0.99 && color[1] < 0.01));
    assert!(colors.chunks(3).any(|color| color[1] > 0.99));
    succeeds(folder.path(), &[export("u.glb"), vec!["--layer", "colour"]].concat());
    fails(folder.path(), &[export("u.obj"), vec!["--layer", "none"]].concat(), &["no layer `none`", "displacement"]);
    let bake = |output: &'static str, what: &'static str| {
        [export(output), vec!["--bake", what, "--size", "32", "--dilate", "0"]].concat()
    };
    let text = succeeds(folder.path(), &bake("h.exr", "displacement"));
    assert!(text.contains("1 picture, 1024 pixels covered, 0 in the gutter; scale 1, mid-level 0"), "{text}");
    let heights = read_exr(&folder.path().join("h.exr"), u64::MAX).unwrap().remove(0);
    let heights = heights.channel("Y").unwrap().to_f32();
    // The corner is in the first column and the last row.
    assert!(heights[31 * 32] > 0.3 && heights.iter().all(|height| *height <= 0.5) && heights[16 * 32 + 16] == 0.0);
    succeeds(folder.path(), &bake("c.png", "colour"));
    assert_eq!(read_png(&folder.path().join("c.png"), u64::MAX).unwrap().width(), 32);
    fails(folder.path(), &bake("u.exr", "depth"), &["no traces"]);
    fails(folder.path(), &export("u.exr"), &["--bake"]);
    fails(folder.path(), &export("u.ptx"), &["as meshes and bakes alone"]);
    fails(folder.path(), &["doc", "export", "t.relievo", "other.obj", "-o", "u.ply"], &["other triangles"]);
}
