//! Colours of half floats in scenes: painted frame by frame, kept in caches and documents, rendered and exported.

use std::path::Path;

use relievo_core::{Context, Values, progress::Silent};
use relievo_document::{Document, Kind};
use relievo_scene::file::read_file;
use relievo_scene::stepper::{RunOptions, Summary, run};

const SCENE: &str = concat!(
    "version = 1\nfps = 10\n",
    ground!("4", "8"),
    r##"KIND
[details]
tile_size = 16
paint_size = 32
paint_format = "rgba16f"
[objects.ground]
surface = "ground"
colour = [0.5, 0.5, 0.5]
[[objects.ground.layers]]
name = "glow"
kind = "colour"
blend = "add"
opacity = 0.5
[[strokes]]
object = "ground"
paint = "mix"
colour = [8000, 0.25, 0]
radius = 0.5
depth = 4
falloff = "constant"
points = [{ position = [-1, 0, 0] }]
[[strokes]]
object = "ground"
layer = "glow"
time = 0.2
paint = "mix"
colour = [2000, 0, 0]
radius = 0.5
depth = 4
falloff = "constant"
points = [{ position = [-1, 0, 0] }]
[camera]
position = [0, 0, 8]
target = [0, 0, 0]
[output]
frames = 4
width = 64
height = 48
samples = 1
pictures = ["beauty"]
picture_frames = "last"
images = ["exr"]
sky_rays = 1
mesh = "last"
mesh_formats = ["ply"]
documents = "last"
"##,
);

fn run_in(folder: &Path, name: &str, text: &str, frames: Option<(u32, u32)>) -> Summary {
    let scene = folder.join(format!("{name}.toml"));
    std::fs::write(&scene, text).unwrap();
    let options = RunOptions { out: folder.join(name), frames, allowed: Vec::new(), rebake: false, device: None };
    run(&Context::serial(), read_file(&scene).unwrap(), &options, &mut Silent).unwrap()
}

#[test]
fn light_goes_through_caches_documents_pictures_and_meshes() {
    for kind in ["", "kind = \"triangles\""] {
        let (folder, text) = (tempfile::tempdir().unwrap(), SCENE.replace("KIND", kind));
        run_in(folder.path(), "whole", &text, None);
        run_in(folder.path(), "parts", &text, Some((0, 1)));
        let rest = run_in(folder.path(), "parts", &text, None);
        assert_eq!((rest.baked, rest.opened), (2, 2));
        let bytes = |name: &str, file: &str| std::fs::read(folder.path().join(name).join(file)).unwrap();
        for file in ["document-000003-ground.relievo", "mesh-000003-ground.ply"] {
            assert!(bytes("parts", file) == bytes("whole", file), "{kind} {file}");
        }

        let document = Document::parse(&bytes("whole", "document-000003-ground.relievo"), 1 << 30).unwrap();
        let kinds: Vec<Kind> = document.layers().iter().map(|layer| layer.kind()).collect();
        assert_eq!(kinds, [Kind::Scalar, Kind::Rgba16, Kind::Rgba16]);

        let mesh = folder.path().join("whole/mesh-000003-ground.ply");
        let mesh = relievo_meshio::read(&Context::serial(), &mesh).unwrap();
        let Values::F32(colors) = &mesh.attribute("color").unwrap().values else { panic!("colours are numbers") };
        // In the middle of the strokes, and far from them.
        let (mut lit, mut plain) = (0, 0);
        for (point, color) in mesh.points.iter().zip(colors.chunks_exact(3)) {
            if (point[0] + 1.0).abs() < 0.3 && point[1].abs() < 0.3 {
                assert!((color[0] - 9000.0).abs() < 10.0 && (color[1] - 0.25).abs() < 0.01, "{kind} {color:?}");
                lit += 1;
            } else if point[0] > 0.5 {
                assert_eq!(color, [0.5; 3], "{kind} {point:?}");
                plain += 1;
            }
        }
        assert!(lit > 20 && plain > 20, "{lit} {plain}");

        let picture = folder.path().join("whole/beauty-000003.exr");
        let layers = relievo_render::read_exr(&picture, 1 << 30).unwrap();
        let samples = layers.iter().flat_map(|layer| &layer.channels);
        let brightest = samples.map(|channel| channel.samples.to_f32().into_iter().fold(0.0, f32::max));
        assert!(brightest.fold(0.0, f32::max) > 500.0);
    }
}
