//! Scenes whose imprints are made, and whose pictures are drawn, on a graphics device.

use std::path::Path;

use half::f16;
use relievo_comparison::{PIXELS_PER_DEGREE, compare};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_gpu::Device;
use relievo_render::{Picture, compare_geometry};
use relievo_scene::file::parse;
use relievo_scene::simulate::{Changes, Simulator};
use relievo_scene::stepper::{RunOptions, run, run_baked};
use relievo_scene::world::{Item, World};

/// The scene of the demo with fewer faces, texels and voxels, and without what the processor adds to imprints: rims and
/// smoothing take what one grazing ray changes to all of its contact.
fn snow() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/snow.toml");
    let mut text = std::fs::read_to_string(path).unwrap();
    for (long, short) in [
        ("faces = 60", "faces = 24"),
        ("tile_size = 128", "tile_size = 64"),
        ("[imprints]\n", "[imprints]\nvoxels = 131072\n"),
        ("smoothing = 0.5\nrim = 0.4", "smoothing = 0\nrim = 0"),
        ("frames = 60", "frames = 20"),
        ("images = [\"png\"]", "pictures = []"),
        ("mesh = \"last\"\nmesh_formats = [\"glb\", \"obj\"]\ntiles = \"last\"", "mesh = \"none\""),
    ] {
        assert!(text.contains(long), "{long}");
        text = text.replace(long, short);
    }
    text
}

fn world(context: &Context, device: Option<&Device>) -> World {
    let mut world = World::new(context, parse("snow.toml".as_ref(), &snow()).unwrap(), &[]).unwrap();
    world.use_device(device).unwrap();
    world
}

/// An example with some of its strokes, counted from 1, and other changes.
fn shortened(name: &str, changes: &[(&str, &str)], strokes: &[usize]) -> String {
    let path = format!("{}/../../examples/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let mut text = std::fs::read_to_string(path).unwrap();
    for (long, short) in changes {
        assert!(text.contains(long), "{long}");
        text = text.replace(long, short);
    }
    let (before, rest) = text.split_once("[camera]").unwrap();
    let parts: Vec<&str> = before.split("[[strokes]]").collect();
    let kept: Vec<&str> = [0].iter().chain(strokes).map(|at| parts[*at]).collect();
    kept.join("[[strokes]]") + "[camera]" + rest
}

/// The scene of the painted egg with some of its strokes, fewer texels and pixels, two frames, and depths and normals.
fn egg(strokes: &[usize]) -> String {
    let changes = [
        ("tile_size = 128\npaint_size = 128", "tile_size = 32\npaint_size = 32"),
        ("frames = 1\nwidth = 960\nheight = 720", "frames = 2\nwidth = 320\nheight = 240"),
        ("samples = 8\nsky_rays = 2", "samples = 1\nsky_rays = 0"),
        ("images = [\"png\"]", "images = [\"exr\"]"),
        ("mesh = \"last\"", "mesh = \"none\""),
        // Shadow maps have no penumbra.
        ("angle = 2", "angle = 0"),
        ("rate = 8", "rate = 32"),
        ("spacing = 0.1\n", "spacing = 1\n"),
        ("spacing = 0.15\n", "spacing = 1\n"),
    ];
    shortened("paint", &changes, strokes)
}

/// The scene of the ball of triangles with a band and a line, traces, and fewer pixels, with depths and normals.
fn ball() -> String {
    let changes = [
        ("width = 960\nheight = 720", "width = 320\nheight = 240"),
        ("samples = 8\nsky_rays = 2", "samples = 1\nsky_rays = 0"),
        ("images = [\"png\"]", "images = [\"exr\"]"),
        ("mesh = \"last\"\nmesh_formats = [\"glb\"]\ndocuments = \"last\"", "mesh = \"none\""),
        ("angle = 2", "angle = 0"),
        ("spacing = 0.1\n", "spacing = 2\n"),
    ];
    shortened("triangles", &changes, &[1, 4])
}

/// Half floats in order, so that neighbours are one apart.
fn order(half: f16) -> i32 {
    let bits = i32::from(half.to_bits());
    if bits & 0x8000 == 0 { bits } else { 0x8000 - bits }
}

#[test]
fn the_demo_on_a_graphics_device_is_that_of_the_processor() {
    let Some(device) = relievo_testing::device() else { return };
    let context = Context::serial();
    let frames = |device: Option<&Device>| {
        let mut world = world(&context, device);
        let mut simulator = Simulator::default();
        let mut all = vec![simulator.start(&context, &mut world).unwrap()];
        all.extend((1..20).map(|frame| simulator.advance(&context, &mut world, frame).unwrap()));
        assert_eq!(world.take_device_faults(), Vec::<String>::new());
        (world, all)
    };
    let (here, expected) = frames(None);
    context.stats().take();
    let (there, found) = frames(Some(&device));
    let imprints = found.iter().map(|changes: &Changes| changes.report.sub_steps).sum::<u64>();
    let stages = context.stats().take();
    // At a first touch voxels may be too small for a device.
    let count = |stage| stages.iter().filter(|event| event.stage == stage).count();
    let (there_made, here_made) = (count("imprint.device.raycast"), count("imprint.raycast"));
    assert!(there_made > 8 && here_made * 4 < there_made, "{there_made} {here_made} of {imprints}");
    for (a, b) in expected.iter().zip(&found) {
        assert_eq!((&a.written, a.report.allocated), (&b.written, b.report.allocated));
    }
    let (mut apart, mut all) = (0, 0);
    for (a, b) in here.items().iter().zip(there.items()) {
        let (Item::Surface(a), Item::Surface(b)) = (a, b) else { continue };
        let (a, b) = (a.displacement().field(), b.displacement().field());
        assert!(a.allocated().eq(b.allocated()), "the tiles that are allocated");
        for tile in a.allocated() {
            for (a, b) in a.block(tile).unwrap().iter().zip(b.block(tile).unwrap()) {
                apart += usize::from((order(*a) - order(*b)).abs() > 1);
                all += 1;
            }
        }
    }
    println!("{apart} of {all} coefficients are more than one half apart after {imprints} imprints");
    assert!(all > 5_000 && apart * 10_000 < all, "{apart} of {all}");
}

/// Two meshes and a surface under two balls that roll on, each over all three.
const FIELD: &str = r#"version = 1
[meshes.ground]
shape = "plane"
size = [1, 1, 1]
faces = 4
[meshes.ball]
shape = "sphere"
radius = 0.15
[surfaces.triangles]
mesh = "ground"
kind = "triangles"
longest_edge = 0.3
[surfaces.tiles]
mesh = "ground"
[details]
segments = 16
tile_size = 32
[objects.low]
surface = "triangles"
[objects.middle]
surface = "tiles"
translation = [0, 0, 0.02]
[objects.high]
surface = "triangles"
translation = [0.1, 0, 0.04]
[objects.one]
mesh = "ball"
[objects.other]
mesh = "ball"
[bodies.one]
keyframes = [{ time = 0, translation = [-0.3, 0, 0.12] }, { time = 0.125, translation = [0.3, 0, 0.12] }]
[bodies.other]
keyframes = [{ time = 0, translation = [-0.3, 0.2, 0.1] }, { time = 0.125, translation = [0.3, 0.1, 0.1] }]
[imprints]
voxels = 65536
[colliders.one]
[colliders.other]
[camera]
position = [0, 0, 2]
target = [0, 0, 0]
"#;

#[test]
fn pairs_of_a_frame_on_triangle_meshes_are_one_submission_beside_that_of_surfaces() {
    let Some(device) = relievo_testing::device() else { return };
    let context = Context::serial();
    let frames = |device: Option<&Device>| {
        let mut world = World::new(&context, parse("field.toml".as_ref(), FIELD).unwrap(), &[]).unwrap();
        world.use_device(device).unwrap();
        let mut simulator = Simulator::default();
        simulator.start(&context, &mut world).unwrap();
        context.stats().take();
        let all: Vec<_> = (1..4).map(|frame| simulator.advance(&context, &mut world, frame).unwrap()).collect();
        assert_eq!(world.take_device_faults(), Vec::<String>::new());
        let stages = context.stats().take();
        (world, all, stages.iter().filter(|event| event.stage == "imprint.device.submit").count())
    };
    let (here, expected, _) = frames(None);
    let (there, found, submitted) = frames(Some(&device));
    let imprints = found.iter().map(|changes: &Changes| changes.report.sub_steps).sum::<u64>();
    println!("{submitted} submissions of {imprints} imprints");
    assert!(submitted >= 6 && submitted as u64 * 3 < imprints, "{submitted} of {imprints}");
    for (a, b) in expected.iter().zip(&found) {
        assert_eq!((&a.written, a.report.sub_steps), (&b.written, b.report.sub_steps));
    }
    let (mut apart, mut all) = (0, 0);
    for (a, b) in here.items().iter().zip(there.items()) {
        let (Item::Triangles(a), Item::Triangles(b)) = (a, b) else { continue };
        let (a, b) = (a.object.displacement().field(), b.object.displacement().field());
        for face in a.allocated() {
            for (a, b) in a.face(face).unwrap().iter().zip(b.face(face).unwrap()) {
                apart += usize::from((order(*a) - order(*b)).abs() > 1);
                all += 1;
            }
        }
    }
    println!("{apart} of {all} values are more than one half apart");
    assert!(all > 1_000 && apart * 10_000 <= all, "{apart} of {all}");
}

#[test]
fn a_run_on_a_lost_device_goes_on_and_says_so() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    let go = |name: &str, device: Option<Device>| {
        let scene = parse("snow.toml".as_ref(), &snow()).unwrap();
        let (out, allowed) = (folder.path().join(name), Vec::new());
        let options = RunOptions { out, frames: Some((0, 3)), allowed, rebake: false, device };
        let mut lost = |fraction: f32, _: &str| {
            // In the middle of the frames.
            if fraction > 0.4 {
                options.device.iter().for_each(Device::abandon);
            }
            true
        };
        run(&context, scene, &options, &mut lost).unwrap()
    };
    let summary = go("lost", Some(device));
    assert_eq!(summary.baked, 4);
    let told = summary.notes.iter().filter(|note| note.contains("the processor took over for `snow`")).count();
    assert_eq!(told, 1, "{:?}", summary.notes);
    assert!(summary.trace.costs().iter().any(|cost| cost.stage == "imprint.device.cull"));
    // What was baked on a device is shown as it is, but it is not what the processor would have.
    let options = RunOptions {
        out: folder.path().join("lost"),
        frames: Some((0, 3)),
        allowed: Vec::new(),
        rebake: false,
        device: None,
    };
    let shown = run_baked(&context, parse("snow.toml".as_ref(), &snow()).unwrap(), &options, &mut Silent).unwrap();
    assert_eq!((shown.baked, shown.opened), (0, 4));
    let beyond = RunOptions { frames: Some((3, 4)), ..options.clone() };
    let again = run(&context, parse("snow.toml".as_ref(), &snow()).unwrap(), &options, &mut Silent).unwrap();
    assert_eq!((again.baked, again.opened), (4, 0));
    // What is missing is computed from what is the processor's.
    let more = run_baked(&context, parse("snow.toml".as_ref(), &snow()).unwrap(), &beyond, &mut Silent).unwrap();
    assert_eq!((more.baked, more.opened), (1, 2));
}

fn picture(folder: &Path, run: &str, kind: &str, frame: u32) -> Picture {
    Picture::read(&folder.join(run).join(format!("{kind}-{frame:06}.exr")), 1 << 30).unwrap()
}

/// Compares the pictures of a frame of the run `there`, on a device, with those of `here`.
fn assert_alike(folder: &Path, frame: u32) {
    let [here, there] = ["here", "there"].map(|run| picture(folder, run, "beauty", frame));
    let geometry = compare_geometry(&here, &there, None).unwrap().unwrap();
    let (depth, normal) = (geometry.depth.unwrap(), geometry.normal.unwrap());
    println!("silhouette {:.6}, depth {depth:?}, normal {normal:?}", geometry.silhouette());
    assert!(geometry.inside > 20_000, "{}", geometry.inside);
    assert!(geometry.silhouette() < 0.002 && depth.p999 < 1e-4 && normal.median < 0.5_f64.to_radians());
    let colors = compare(&here, &there, PIXELS_PER_DEGREE).unwrap();
    println!("FLIP {:?}, SSIM {}", colors.flip, colors.ssim);
    // Rims of shadows have the texels of a map, and the ray caster's paint those of its triangles' corners.
    assert!(colors.flip.mean < 0.03 && colors.ssim > 0.97, "{:?} {}", colors.flip, colors.ssim);
    let [here, there] = ["here", "there"].map(|run| picture(folder, run, "tiles", frame));
    let colors = compare(&here, &there, PIXELS_PER_DEGREE).unwrap();
    assert!(colors.flip.mean < 0.05, "the states of tiles or faces: {:?}", colors.flip);
}

#[test]
fn pictures_of_a_run_on_a_graphics_device_are_those_of_the_ray_caster() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    let go = |name: &str, strokes: &[usize], device: Option<Device>, lost: bool| {
        let scene = parse("egg.toml".as_ref(), &egg(strokes)).unwrap();
        let (out, allowed) = (folder.path().join(name), Vec::new());
        let options = RunOptions { out, frames: None, allowed, rebake: false, device };
        let mut watch = |_: f32, stage: &str| {
            if lost && stage == "frame 1" {
                options.device.iter().for_each(Device::abandon);
            }
            true
        };
        run(&context, scene, &options, &mut watch).unwrap()
    };
    go("here", &[1, 7, 9, 10], None, false);
    let summary = go("there", &[1, 7, 9, 10], Some(device), false);
    assert!(summary.notes.iter().all(|note| !note.contains("processor")), "{:?}", summary.notes);
    assert_alike(folder.path(), 1);

    // A device that is lost on the way is no end of the run.
    let Some(device) = relievo_testing::device() else { return };
    let summary = go("lost", &[], Some(device), true);
    assert!(summary.notes.iter().any(|note| note.contains("from frame 1 on")), "{:?}", summary.notes);
    let [before, after] = [0, 1].map(|frame| picture(folder.path(), "lost", "beauty", frame));
    let colors = compare(&before, &after, PIXELS_PER_DEGREE).unwrap();
    assert!(colors.flip.mean < 0.05, "{:?}", colors.flip);
}

#[test]
fn triangle_meshes_of_a_run_are_drawn_from_what_the_device_has_of_them() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    let go = |name: &str, device: Option<Device>| {
        let scene = parse("ball.toml".as_ref(), &ball()).unwrap();
        let options =
            RunOptions { out: folder.path().join(name), frames: None, allowed: Vec::new(), rebake: false, device };
        run(&context, scene, &options, &mut Silent).unwrap()
    };
    go("here", None);
    go("there", Some(device));
    // Pressed into after it was drawn first.
    assert_alike(folder.path(), 2);
}
