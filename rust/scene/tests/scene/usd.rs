//! Cages from USD in the scene's units and axis, moving as the stage says; meshes of all frames of a run as one stage.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_meshio::{Model, read_model};
use relievo_scene::file::read_file;
use relievo_scene::stepper::{RunOptions, Summary, run};

/// A square of two metres that stands 1 m above the ground and rises, in centimetres with z up.
const STAGE: &str = r#"#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 1
    timeCodesPerSecond = 10
)
def Mesh "cage"
{
    point3f[] points = [(-100, -100, 100), (100, -100, 100), (100, 100, 100), (-100, 100, 100)]
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 11: (0, 0, 200) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"#;

fn written(folder: &Path, scene: &str, threads: usize, out: &str) -> Summary {
    std::fs::write(folder.join("cage.usda"), STAGE).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    let context = Context::new(&ContextOptions { threads, memory_limit: 1 << 30 }).unwrap();
    let options = RunOptions { out: folder.join(out), frames: None, allowed: Vec::new(), rebake: false, device: None };
    let scene = read_file(&path).unwrap_or_else(|faults| panic!("{faults}"));
    run(&context, scene, &options, &mut Silent).unwrap_or_else(|failure| panic!("{failure}"))
}

fn model(path: &Path) -> Model {
    read_model(&Context::serial(), path).unwrap()
}

#[test]
fn a_cage_stands_in_the_scenes_units_and_moves() {
    // A metre is 10 dm; up is where the scene has it.
    for (up, axis) in [("x", 0), ("y", 1), ("z", 2)] {
        let folder = tempfile::tempdir().unwrap();
        let scene = format!(
            "version = 1\nup = \"{up}\"\nunits = \"dm\"\nfps = 5\n[meshes.cage]\nfile = \"cage.usda\"\n\
             animation = \"stage\"\n[objects.cage]\nmesh = \"cage\"\n[output]\nframes = 6\npictures = []\n\
             mesh = \"every\"\nmesh_formats = [\"ply\", \"usda\"]\n"
        );
        let summary = written(folder.path(), &scene, 1, "out");
        let stage = folder.path().join("out/mesh-000000-000005.usda");
        assert_eq!(summary.files.last(), Some(&stage));
        let stage = model(&stage);
        for (frame, height) in [(0u8, 10.0), (2, 18.0), (5, 30.0)] {
            let placed = model(&folder.path().join(format!("out/mesh-{frame:06}-cage.ply")));
            let (low, high) = placed.meshes[0].mesh.bounds().unwrap();
            assert!((low[axis] - height).abs() < 1e-4 && (high[axis] - height).abs() < 1e-4, "{up}, {frame}: {low:?}");
            assert!((0..3).filter(|side| *side != axis).all(|side| (high[side] - 10.0).abs() < 1e-5));
            // Read again, it is in metres with y up.
            let pose = stage.pose(&Context::serial(), 0, f64::from(frame) / 5.0).unwrap();
            assert!(pose.merged_points().iter().all(|point| (point[1] - height / 10.0).abs() < 1e-5));
        }
    }
}

#[test]
fn a_dented_surface_keeps_its_frames_whatever_the_number_of_threads() {
    let scene = r#"
version = 1
up = "z"
fps = 24
[meshes.plate]
shape = "plane"
size = [2, 2, 1]
faces = 2
[meshes.ball]
shape = "sphere"
radius = 0.4
faces = 4
[surfaces.plate]
mesh = "plate"
[objects.plate]
surface = "plate"
detail = { tile_size = 16 }
[objects.ball]
mesh = "ball"
[bodies.ball]
shape = "none"
keyframes = [{ time = 0, translation = [0, 0, 0.5] }, { time = 0.125, translation = [0, 0, 0.2] }]
[colliders.ball]
[output]
frames = 4
pictures = []
mesh = "every"
mesh_formats = ["usda"]
rate = 4
"#;
    let folder = tempfile::tempdir().unwrap();
    written(folder.path(), scene, 1, "one");
    written(folder.path(), scene, 3, "three");
    {
        let name = "mesh-000000-000003.usda";
        let read = |out: &str| std::fs::read(folder.path().join(out).join(name)).unwrap();
        assert!(read("one") == read("three"), "{name}");
        let model = model(&folder.path().join("one").join(name));
        assert_eq!(model.meshes.len(), 2, "{:?}", model.notes);
        let heights = |seconds: f64| {
            let shapes = model.pose(&Context::serial(), 0, seconds).unwrap().shapes;
            [0, 1].map(|shape| shapes[shape].points.iter().map(|point| point[1]).fold(f32::INFINITY, f32::min))
        };
        let [plate, ball] = heights(3.0 / 24.0);
        assert!((ball + 0.2).abs() < 1e-3, "{ball}");
        assert!((plate - ball).abs() < 0.02, "{plate}");
        assert!(heights(0.0)[0].abs() < 1e-6);
    }
}
