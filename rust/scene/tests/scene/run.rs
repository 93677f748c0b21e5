//! Whole runs of small scenes: what is written, that nothing is written elsewhere, and that a run that goes on from
//! the cache ends in the same bits as one that never stopped.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh, Progress};
use relievo_scene::cache::{Cache, Identity};
use relievo_scene::diagnostic::Failure;
use relievo_scene::file::read_file;
use relievo_scene::simulate;
use relievo_scene::stepper::{RunOptions, Summary, run};
use relievo_scene::world::{Item, World};

const SCENE: &str = r##"version = 1
[meshes.ground]
shape = "plane"
size = [1, 1, 1]
faces = 4
[meshes.ball]
shape = "spiked_ball"
radius = 0.12
spikes = 20
spike_length = 0.04
spike_radius = 0.02
[meshes.tool]
shape = "box"
size = [0.1, 0.1, 0.1]
faces = 2
[surfaces.ground]
mesh = "ground"
[details]
tile_size = 16
[objects.ground]
surface = "ground"
[objects.ball]
mesh = "ball"
translation = [-0.25, 0, 0.13]
[objects.tool]
mesh = "tool"
[bodies.ground]
motion = "fixed"
shape = "trimesh"
inset = 0.02
[bodies.ball]
shape = "ball"
radius = 0.12
mass = 1
velocity = [2, 0, 0]
[bodies.tool]
shape = "none"
keyframes = [{ time = 0, translation = [0.3, 0.3, 0.1] }, { time = 0.2, translation = [0.3, 0.2, 0.01], rotation = [0, 0, 45] }]
[imprints]
voxels = 65536
[colliders.ball]
[colliders.tool]
into = "ground"
[output]
frames = 6
width = 48
height = 32
samples = 1
sky_rays = 1
images = ["png", "exr"]
pictures = ["beauty", "wireframe", "tiles"]
picture_frames = "last"
mesh = "last"
mesh_formats = ["glb", "obj", "ply"]
tiles = "last"
rate = 4
"##;

fn context(threads: usize) -> Context {
    Context::new(&ContextOptions { threads, memory_limit: 1 << 30 }).unwrap()
}

fn options(out: &Path) -> RunOptions {
    RunOptions { out: out.to_path_buf(), frames: None, allowed: Vec::new(), rebake: false, device: None }
}

fn run_with(context: &Context, scene: &Path, options: &RunOptions) -> Result<Summary, Failure> {
    run(context, read_file(scene)?, options, &mut Silent)
}

/// Every file below `folder` with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// The files that two folders do not both have with the same bytes. The header of EXR files has no fixed order.
fn differing(a: &Path, b: &Path) -> Vec<PathBuf> {
    let (a, b) = (files(a), files(b));
    let exr = |path: &Path| path.extension().is_some_and(|extension| extension == "exr");
    let names = a.keys().chain(b.keys()).filter(|path| !exr(path) && a.get(*path) != b.get(*path));
    names.cloned().collect()
}

#[test]
fn a_run_writes_pictures_meshes_and_tiles_below_its_folder_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let out = folder.path().join("out");
    let summary = run_with(&context(0), &scene, &options(&out)).unwrap();
    assert_eq!((summary.baked, summary.opened), (6, 0));
    assert!(summary.tiles[0] > 0 && summary.tiles[0] < summary.tiles[1], "{:?}", summary.tiles);
    let names: Vec<String> =
        files(folder.path()).into_keys().map(|path| path.to_string_lossy().replace('\\', "/")).collect();
    for expected in [
        "out/beauty-000005.png",
        "out/beauty-000005.exr",
        "out/wireframe-000005.png",
        "out/tiles-000005.png",
        "out/mesh-000005.glb",
        "out/mesh-000005-ground.obj",
        "out/mesh-000005-ball.ply",
        "out/tiles-000005-ground.exr",
        "out/cache/frame-000000.rlvcache",
    ] {
        assert!(names.iter().any(|name| name == expected), "{expected} is missing in {names:?}");
    }
    assert!(names.iter().all(|name| name == "scene.toml" || name.starts_with("out/")), "{names:?}");
    // The dents are in the mesh: the plane goes below where it was.
    let mesh = relievo_meshio::read(&context(1), &out.join("mesh-000005-ground.obj")).unwrap();
    mesh.check().unwrap();
    let lowest = mesh.bounds().unwrap().0[2];
    assert!((-0.1..-0.01).contains(&lowest), "{lowest}");
    for stage in ["imprint.voxelise", "imprint.raycast", "physics", "render", "cache.write"] {
        assert!(summary.trace.table().contains(stage), "{stage}");
    }
    // Everything is there, so a second run opens the frames and ends in the same picture.
    let first = std::fs::read(out.join("beauty-000005.png")).unwrap();
    let again = run_with(&context(0), &scene, &options(&out)).unwrap();
    assert_eq!((again.baked, again.opened), (0, 6));
    assert_eq!(std::fs::read(out.join("beauty-000005.png")).unwrap(), first);
}

#[test]
fn going_on_from_the_cache_and_other_threads_end_in_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE.replace("picture_frames = \"last\"", "picture_frames = \"none\"")).unwrap();
    let straight = folder.path().join("straight");
    run_with(&context(1), &scene, &options(&straight)).unwrap();
    let resumed = folder.path().join("resumed");
    let part = |first: u32, last: u32| RunOptions { frames: Some((first, last)), ..options(&resumed) };
    run_with(&context(2), &scene, &part(0, 2)).unwrap();
    let rest = run_with(&context(2), &scene, &part(3, 5)).unwrap();
    assert_eq!((rest.baked, rest.opened), (3, 1));
    assert_eq!(differing(&straight, &resumed), Vec::<PathBuf>::new());
    // Frames in the middle can be asked for alone, and be computed again.
    let again = run_with(&context(2), &scene, &RunOptions { rebake: true, ..part(4, 5) }).unwrap();
    assert_eq!(again.baked, 2);
    assert_eq!(differing(&straight, &resumed), Vec::<PathBuf>::new());
}

/// A painted band at the start, a ridge later, and dabs beside the ground.
const STROKES: &str = concat!(
    "\n",
    red_band!(),
    r##"[[strokes]]
object = "ground"
time = 0.1
sculpt = "draw"
height = 0.01
falloff = "gaussian"
radius = 0.1
points = [{ position = [-0.2, -0.3, 0] }, { position = [0.2, -0.3, 0.02] }]
[[strokes]]
object = "ground"
time = 0.1
paint = "multiply"
colour = [0.5, 0.5, 0.5]
points = [{ position = [0, 0, 5] }]
[output]
"##,
);

#[test]
fn strokes_are_made_at_their_time_and_kept_in_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = SCENE.replace("[output]\n", STROKES).replace("picture_frames = \"last\"", "picture_frames = \"none\"");
    std::fs::write(&scene, &text).unwrap();
    let straight = folder.path().join("straight");
    let summary = run_with(&context(1), &scene, &options(&straight)).unwrap();
    assert!(summary.notes.iter().any(|note| note.starts_with("1 dabs of strokes")), "{:?}", summary.notes);
    let resumed = folder.path().join("resumed");
    let part = |first: u32, last: u32| RunOptions { frames: Some((first, last)), ..options(&resumed) };
    run_with(&context(2), &scene, &part(0, 1)).unwrap();
    let rest = run_with(&context(2), &scene, &part(2, 5)).unwrap();
    assert_eq!((rest.baked, rest.opened), (4, 1));
    assert_eq!(differing(&straight, &resumed), Vec::<PathBuf>::new());
    let glb = std::fs::read(straight.join("mesh-000005.glb")).unwrap();
    assert!(glb.windows(7).any(|name| name == b"COLOR_0"));
    // From the cache: painted from the start on, raised from frame 3 on, which is after 0.1 s.
    let context = context(1);
    let mut world = World::new(&context, read_file(&scene).unwrap(), &[]).unwrap();
    let identity = Identity { scene: world.fingerprint(), level: context.level() as u32 };
    let cache = Cache::new(&straight.join("cache"), identity).unwrap();
    let mut current = None;
    for frame in [5, 2, 3, 0] {
        let opened = cache.open(&context, frame).unwrap();
        simulate::restore(&context, &mut world, &opened, current.as_ref()).unwrap();
        current = Some(opened);
        let Item::Surface(surface) = &world.items()[0] else { panic!("the ground is a surface") };
        let place = surface.nearest(&context, glam::DVec3::new(0.0, -0.3, 0.0), 1.0).unwrap().unwrap();
        assert_eq!(place.point.z > 0.005, frame >= 3, "frame {frame}: {place:?}");
        let place = surface.nearest(&context, glam::DVec3::new(0.0, 0.15, 0.0), 1.0).unwrap().unwrap().place;
        let color = surface.paint().unwrap().field().color(place);
        assert!(color.x > 2.0 * color.y && color.y < 0.1, "{color}");
    }
    // Other strokes, or another colour below them, are another scene.
    for (from, to) in
        [("height = 0.01", "height = 0.02"), ("surface = \"ground\"", "surface = \"ground\"\ncolour = [0.1, 0.2, 0.3]")]
    {
        std::fs::write(&scene, text.replace(from, to)).unwrap();
        let other = World::new(&context, read_file(&scene).unwrap(), &[]).unwrap();
        assert_ne!(other.fingerprint(), identity.scene, "{to}");
    }
}

/// A ground and two strokes over it, of which `STROKES` stand for none, some or all.
const TAKEN_UP: &str = concat!(
    "version = 1\n",
    ground!("1", "FACES"),
    r##"[details]
tile_size = 64
paint_size = 32
[objects.ground]
surface = "ground"
DOCUMENT
STROKES
[output]
frames = 2
pictures = []
mesh = "none"
documents = "last"
"##,
);
const RIDGE: &str = concat!(
    r##"
[[strokes]]
object = "ground"
sculpt = "draw"
height = 0.02
radius = 0.1
points = [{ position = [-0.2, -0.3, 0] }, { position = [0.2, 0.3, 0.02] }]
"##,
    red_band!(),
);
const ERASER: &str = r##"
[[strokes]]
object = "ground"
sculpt = "erase"
radius = 0.3
points = [{ position = [-0.2, -0.3, 0] }, { position = [-0.2, -0.2, 0] }]
[[strokes]]
object = "ground"
paint = "multiply"
colour = [0.2, 0.9, 0.4]
radius = 0.1
points = [{ position = [0, 0.3, 0] }, { position = [0, -0.1, 0] }]
"##;

#[test]
fn a_surface_is_taken_up_from_its_document() {
    let folder = tempfile::tempdir().unwrap();
    let run_scene = |name: &str, document: &str, strokes: &str, faces: &str| {
        let scene = folder.path().join(format!("{name}.toml"));
        let text = TAKEN_UP.replace("FACES", faces).replace("DOCUMENT", document).replace("STROKES", strokes);
        std::fs::write(&scene, text).unwrap();
        run_with(&context(1), &scene, &options(&folder.path().join(name)))
    };
    let bytes = |name: &str| std::fs::read(folder.path().join(name).join("document-000001-ground.relievo")).unwrap();
    let whole = run_scene("whole", "", &format!("{RIDGE}{ERASER}"), "4").unwrap();
    assert!(whole.files.iter().any(|file| file.ends_with("document-000001-ground.relievo")), "{:?}", whole.files);
    run_scene("first", "", RIDGE, "4").unwrap();
    assert_ne!(bytes("first"), bytes("whole"));

    // Nothing done to it, it is written as it was read; what is done after it is as if never interrupted.
    let from_first = "document = \"first/document-000001-ground.relievo\"";
    run_scene("same", from_first, "", "4").unwrap();
    assert_eq!(bytes("same"), bytes("first"));
    run_scene("second", from_first, ERASER, "4").unwrap();
    assert_eq!(bytes("second"), bytes("whole"));
    // Again from the cache, which begins with a document of which frame 0 erases tiles.
    let again = run_scene("second", from_first, ERASER, "4").unwrap();
    assert_eq!((again.baked, again.opened), (0, 2));
    assert_eq!(bytes("second"), bytes("whole"));
    // Another document is another scene.
    let other = run_scene("second", "document = \"whole/document-000001-ground.relievo\"", ERASER, "4").unwrap();
    assert_eq!((other.baked, other.opened), (2, 0));

    let fails = |document: &str, faces: &str| run_scene("bad", document, "", faces).unwrap_err().to_string();
    let misfit = fails(from_first, "5");
    assert!(misfit.contains("bad.toml:13:") && misfit.contains("document-000001-ground.relievo"), "{misfit}");
    assert!(misfit.contains("it has 16 faces and 64 corners, this one 25 and 100"), "{misfit}");
    let outside = fails("document = \"../a.relievo\"", "4");
    assert!(outside.contains("bad.toml:13:"), "{outside}");
    let mut damaged = bytes("first");
    // The blocks lie between the header with the index and the copies of both.
    let document = relievo_document::Document::parse(&damaged, u64::MAX).unwrap();
    let packed: usize =
        document.layers().iter().flat_map(|layer| layer.blocks()).map(|block| block.packed_bytes()).sum();
    let end = (damaged.len() + packed) / 2;
    damaged[end - 1] ^= 1;
    std::fs::write(folder.path().join("damaged.relievo"), damaged).unwrap();
    let damaged = fails("document = \"damaged.relievo\"", "4");
    assert!(damaged.contains("relievo doc check") && damaged.contains("layer `colour`"), "{damaged}");
    let small = fails(&format!("{from_first}\ndetail = {{ budget = 65536 }}"), "4");
    assert!(small.contains("budget"), "{small}");
}

const LAYERED: &str = r##"
[[objects.ground.layers]]
name = "dents"
opacity = 0.5
tile_size = 32
[[objects.ground.layers]]
name = "glaze"
kind = "colour"
blend = "multiply"
"##;

const ON_LAYERS: &str = r##"
[[strokes]]
object = "ground"
layer = "dents"
sculpt = "draw"
radius = 0.2
time = 0.04
points = [{ position = [-0.2, 0.1, 0] }, { position = [0.3, 0.1, 0] }]
[[strokes]]
object = "ground"
layer = "glaze"
paint = "mix"
radius = 0.15
points = [{ position = [0.1, 0.1, 0] }]
"##;

#[test]
fn layers_of_a_scene_are_kept_in_documents_and_in_cached_frames() {
    let folder = tempfile::tempdir().unwrap();
    let run_scene = |name: &str, document: &str, layers: &str, strokes: &str| {
        let scene = folder.path().join(format!("{name}.toml"));
        let text = TAKEN_UP.replace("FACES", "4").replace("DOCUMENT", document);
        std::fs::write(&scene, text.replace("STROKES", &format!("{layers}{strokes}"))).unwrap();
        run_with(&context(1), &scene, &options(&folder.path().join(name)))
    };
    let bytes = |name: &str| std::fs::read(folder.path().join(name).join("document-000001-ground.relievo")).unwrap();
    let layers = |name: &str| {
        let document = relievo_document::Document::parse(&bytes(name), 1 << 30).unwrap();
        let list = document.layers().iter().map(|layer| (layer.name().to_string(), layer.blocks().len()));
        list.collect::<Vec<_>>()
    };
    run_scene("whole", "", LAYERED, &format!("{RIDGE}{ON_LAYERS}")).unwrap();
    let found = layers("whole");
    assert_eq!(
        found.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["displacement", "dents", "colour", "glaze"]
    );
    assert!(found.iter().all(|(_, blocks)| *blocks > 0), "{found:?}");
    // From the cache the last frame is the same, layer by layer.
    let first = bytes("whole");
    let again = run_scene("whole", "", LAYERED, &format!("{RIDGE}{ON_LAYERS}")).unwrap();
    assert_eq!((again.baked, again.opened, bytes("whole") == first), (0, 2, true));
    // A document brings its layers, whether the scene names them or not.
    run_scene("same", "document = \"whole/document-000001-ground.relievo\"", "", "").unwrap();
    assert_eq!(layers("same"), found);
    run_scene("more", "document = \"whole/document-000001-ground.relievo\"", LAYERED, ERASER).unwrap();
    assert_eq!(layers("more").len(), 4);

    let fails = |layers: &str, strokes: &str| run_scene("bad", "", layers, strokes).unwrap_err().to_string();
    let unknown = fails("", &ON_LAYERS.replace("0.04", "0"));
    assert!(unknown.contains("no such layer") && unknown.contains("it has displacement, colour"), "{unknown}");
    let crossed = fails(LAYERED, &ON_LAYERS.replace("\"glaze\"", "\"dents\""));
    assert!(crossed.contains("cannot take the edit"), "{crossed}");
    let odd = fails(&LAYERED.replace("multiply", "subtract"), "");
    assert!(odd.contains("`subtract` means nothing for colour"), "{odd}");
}

#[test]
fn scrubbing_to_any_frame_shows_that_frame() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let out = folder.path().join("out");
    let context = context(1);
    let none = SCENE.replace("picture_frames = \"last\"", "picture_frames = \"none\"");
    std::fs::write(&scene, none).unwrap();
    run_with(&context, &scene, &options(&out)).unwrap();
    let mut world = World::new(&context, read_file(&scene).unwrap(), &[]).unwrap();
    let identity = Identity { scene: world.fingerprint(), level: context.level() as u32 };
    let cache = Cache::new(&out.join("cache"), identity).unwrap();
    let state = |world: &World| -> Vec<(u32, Vec<u8>)> {
        let Item::Surface(surface) = &world.items()[0] else { panic!("the ground is a surface") };
        let tiles: Vec<u32> = surface.displacement().field().allocated().collect();
        tiles.iter().map(|tile| (*tile, surface.displacement().read(*tile).unwrap().unwrap())).collect()
    };
    let mut seen: BTreeMap<u32, Vec<(u32, Vec<u8>)>> = BTreeMap::new();
    let mut current = None;
    for frame in [5, 0, 3, 1, 5, 2, 0, 3] {
        let opened = cache.open(&context, frame).unwrap();
        simulate::restore(&context, &mut world, &opened, current.as_ref()).unwrap();
        let now = state(&world);
        assert_eq!(seen.entry(frame).or_insert_with(|| now.clone()), &now, "frame {frame}");
        current = Some(opened);
    }
    assert!(seen[&0].len() < seen[&5].len());
}

#[test]
fn a_resumed_frame_is_written_as_in_a_whole_run() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = SCENE.replace("tiles = \"last\"", "tiles = \"every\"");
    let text = text.replace("picture_frames = \"last\"", "picture_frames = \"every\"");
    // The camera is the automatic one, which sees what is there at the start, not what is there in the first picture.
    std::fs::write(&scene, text).unwrap();
    let (whole, part) = (folder.path().join("whole"), folder.path().join("part"));
    run_with(&context(1), &scene, &options(&whole)).unwrap();
    let frames = RunOptions { frames: Some((3, 4)), ..options(&part) };
    let notes = run_with(&context(2), &scene, &frames).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("frames 0 to 2 are not baked yet")), "{notes:?}");
    let names: Vec<_> = std::fs::read_dir(&part).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.iter().any(|name| name == "tiles-000003.png"), "{names:?}");
    let pictures = |name: &str| name.ends_with(".png") || name.ends_with(".exr");
    for name in names.iter().filter(|name| pictures(&name.to_string_lossy())) {
        let [first, second] = [&whole, &part].map(|out| std::fs::read(out.join(name)).unwrap());
        assert!(first == second, "{name:?}");
    }
}

#[test]
fn changed_tiles_of_animated_surfaces_are_shown_as_changed() {
    let folder = tempfile::tempdir().unwrap();
    let plane = "v -0.5 -0.5 0\nv 0 -0.5 0\nv 0.5 -0.5 0\nv -0.5 0 0\nv 0 0 0\nv 0.5 0 0\nv -0.5 0.5 0\nv 0 0.5 0\n\
        v 0.5 0.5 0\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n";
    for frame in 0..6 {
        std::fs::write(folder.path().join(format!("plane.{frame}.obj")), plane).unwrap();
    }
    // The legend is orange in every picture; without colliders nothing else is.
    let orange = |colliders: bool| {
        let scene = folder.path().join("scene.toml");
        let text =
            SCENE.replace("shape = \"plane\"\nsize = [1, 1, 1]\nfaces = 4", "sequence = \"plane.#.obj\"\ncount = 6");
        let text = text.replace("[bodies.ground]\nmotion = \"fixed\"\nshape = \"trimesh\"\ninset = 0.02\n", "");
        let text =
            if colliders { text } else { text.replace("[colliders.ball]\n[colliders.tool]\ninto = \"ground\"\n", "") };
        std::fs::write(&scene, text.replace("width = 48\nheight = 32", "width = 240\nheight = 160")).unwrap();
        let out = tempfile::tempdir().unwrap();
        run_with(&context(1), &scene, &options(out.path())).unwrap();
        let picture = relievo_render::read_png(&out.path().join("tiles-000005.png"), 1 << 30).unwrap();
        let pixels = picture.data().chunks_exact(picture.channels() as usize);
        pixels.filter(|pixel| pixel[0] > 0.1 && pixel[2] < 0.3 * pixel[0] && pixel[1] < pixel[0]).count()
    };
    let (with, without) = (orange(true), orange(false));
    assert!(with > without + 500, "{with} {without}");
}

#[test]
fn a_changed_scene_is_baked_anew_and_a_changed_camera_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let quiet = SCENE.replace("picture_frames = \"last\"", "picture_frames = \"none\"");
    std::fs::write(&scene, &quiet).unwrap();
    let out = folder.path().join("out");
    run_with(&context(1), &scene, &options(&out)).unwrap();
    std::fs::write(&scene, format!("{quiet}[camera]\nposition = [2, 2, 2]\n")).unwrap();
    assert_eq!(run_with(&context(1), &scene, &options(&out)).unwrap().opened, 6);
    std::fs::write(&scene, quiet.replace("inset = 0.02", "inset = 0.03")).unwrap();
    let summary = run_with(&context(1), &scene, &options(&out)).unwrap();
    assert_eq!(summary.baked, 6);
    assert!(summary.notes.iter().any(|note| note.contains("another version of the scene")), "{:?}", summary.notes);
}

#[test]
fn wishes_that_cannot_be_met_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let out = folder.path().join("out");
    let beyond = RunOptions { frames: Some((3, 9)), ..options(&out) };
    let message = run_with(&context(1), &scene, &beyond).unwrap_err().to_string();
    assert!(message.contains("0..5"), "{message}");
    struct Stop;
    impl Progress for Stop {
        fn report(&mut self, fraction: f32, _: &str) -> bool {
            fraction < 0.3
        }
    }
    let stopped = run(&context(1), read_file(&scene).unwrap(), &options(&out), &mut Stop).unwrap_err();
    assert!(stopped.to_string().contains("cancelled"), "{stopped}");
    // What was baked before the stop is whole.
    assert!(run_with(&context(1), &scene, &options(&out)).unwrap().opened > 0);
}

#[test]
fn two_deformable_objects_share_a_dent() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = r#"version = 1
[meshes.block]
shape = "box"
size = [1, 1, 1]
faces = 2
[surfaces.block]
mesh = "block"
[details]
tile_size = 16
[objects.low]
surface = "block"
[objects.high]
surface = "block"
translation = [0.05, 0.03, 0.7]
rotation = [0, 0, 20]
[imprints]
voxels = 262144
[colliders.low]
into = "high"
[colliders.high]
into = "low"
[output]
pictures = []
mesh = "last"
mesh_formats = ["obj"]
rate = 4
"#;
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    let context = context(2);
    run_with(&context, &scene, &options(&out)).unwrap();
    let bounds = |name: &str| {
        let mesh = relievo_meshio::read(&context, &out.join(format!("mesh-000000-{name}.obj"))).unwrap();
        // Near the axis, away from the rounded rims.
        let near = mesh.points.iter().filter(|p| p[0].abs() < 0.12 && p[1].abs() < 0.12);
        near.fold((f32::MAX, f32::MIN), |(low, high), p| (low.min(p[2]), high.max(p[2])))
    };
    let undented = {
        let world = World::new(&context, read_file(&scene).unwrap(), &[]).unwrap();
        let Item::Surface(surface) = &world.items()[0] else { panic!("a surface") };
        surface.surface().sample(relievo_core::simd::Level::best(), relievo_surface::Place::new(0, 0.5, 0.5)).unwrap();
        let (_, high) = (0..surface.surface().tile_count() as u32)
            .map(|tile| surface.surface().tile_bounds(tile))
            .fold((f32::MAX, f32::MIN), |(low, high), (a, b)| (low.min(a[2]), high.max(b[2])));
        high
    };
    let (low_top, high_bottom) = (bounds("low").1, bounds("high").0);
    assert!(low_top < undented - 0.02, "the lower one gave way: {low_top} of {undented}");
    assert!(high_bottom > 0.7 - undented + 0.02, "the upper one gave way: {high_bottom}");
    assert!(low_top - high_bottom < 0.03, "they meet: {low_top} and {high_bottom}");
}

#[test]
fn numbered_meshes_press_in_where_they_are_at_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    // A tetrahedron whose tip goes down.
    for (number, tip) in [(1, 0.1), (2, 0.0), (3, -0.2)] {
        let text =
            format!("v -0.2 -0.2 0.3\nv 0.2 -0.2 0.3\nv 0 0.2 0.3\nv 0 0 {tip}\nf 1 2 3\nf 2 1 4\nf 3 2 4\nf 1 3 4\n");
        std::fs::write(folder.path().join(format!("tip.{number}.obj")), text).unwrap();
    }
    let text = "version = 1\n[meshes.ground]\nshape = \"plane\"\nfaces = 4\n[meshes.tip]\nsequence = \"tip.#.obj\"\n\
        first = 1\ncount = 3\n[surfaces.ground]\nmesh = \"ground\"\n[details]\ntile_size = 32\n[objects.ground]\n\
        surface = \"ground\"\n[objects.tip]\nmesh = \"tip\"\n[imprints]\nvoxels = 262144\n[colliders.tip]\n\
        [output]\nframes = 3\npictures = []\nmesh = \"every\"\nmesh_formats = [\"obj\"]\nrate = 4\n";
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    let context = context(2);
    run_with(&context, &scene, &options(&out)).unwrap();
    let lowest = |frame: u32| {
        let path = out.join(format!("mesh-{frame:06}-ground.obj"));
        relievo_meshio::read(&context, &path).unwrap().bounds().unwrap().0[2]
    };
    assert_eq!(lowest(0), 0.0);
    assert!(lowest(1) > -0.03, "{}", lowest(1));
    assert!((-0.22..-0.15).contains(&lowest(2)), "{}", lowest(2));
}

#[test]
fn a_tool_sinks_until_the_material_carries_its_force() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = |force: f64| {
        format!(
            r#"version = 1
[meshes.ground]
shape = "plane"
size = [2, 2, 1]
faces = 4
[meshes.pen]
shape = "sphere"
radius = 0.3
faces = 24
{TILED_GROUND}translation = [0, 0, 0.5]
[objects.pen]
mesh = "pen"
[bodies.pen]
shape = "none"
keyframes = [{{ time = 0, translation = [-0.4, 0.1, 3] }}, {{ time = 0.1, translation = [0.4, 0.1, 2] }}]
[imprints]
voxels = 262144
[colliders.pen]
tool = {{ force = [0, 0, -{force}], stiffness = 1000, max_depth = 0.3 }}
[output]
frames = 4
pictures = []
mesh = "every"
mesh_formats = ["obj"]
mesh_rate = 32
"#
        )
    };
    let context = context(2);
    let depth = |force: f64| {
        std::fs::write(&scene, text(force)).unwrap();
        let out = folder.path().join(format!("out-{force}"));
        run_with(&context, &scene, &options(&out)).unwrap();
        let read = |frame: u32, name: &str| {
            relievo_meshio::read(&context, &out.join(format!("mesh-{frame:06}-{name}.obj"))).unwrap()
        };
        // Where the pen is at the end its dent is; between the places of the first and the last frame there is a track.
        let ground = read(3, "ground");
        let track = ground.points.iter().filter(|p| p[0].abs() < 0.3 && (p[1] - 0.1).abs() < 0.02);
        let shallowest = track.map(|p| p[2]).fold(f32::NEG_INFINITY, f32::max);
        let deepest = ground.points.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
        let pen = read(3, "pen").points.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
        (0.5 - deepest, 0.5 - shallowest, 0.5 - pen)
    };
    let mut before = 0.0;
    for force in [1.0, 4.0, 16.0] {
        // The depth at which the cap of the ball has the volume that carries the force.
        let cap = |d: f64| std::f64::consts::PI * d * d * (0.9 - d) / 3.0 * 1000.0;
        let (mut low, mut high) = (0.0, 0.3);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if cap(middle) > force { high = middle } else { low = middle }
        }
        let (deepest, shallowest, pen) = depth(force);
        assert!((f64::from(pen) - low).abs() < 0.05 * low, "{force}: {pen} {low}");
        assert!((deepest - pen).abs() < 0.01 && deepest - shallowest < 0.015, "{force}: {deepest} {shallowest} {pen}");
        assert!(deepest > before + 0.01, "{force}: {deepest} {before}");
        before = deepest;
    }
    let open = text(1.0).replace("shape = \"sphere\"\nradius = 0.3\nfaces = 24", "shape = \"plane\"");
    std::fs::write(&scene, open).unwrap();
    let refused = run_with(&context, &scene, &options(&folder.path().join("open"))).unwrap_err().to_string();
    assert!(refused.contains("closed mesh") && refused.contains("scene.toml:"), "{refused}");
}

/// The coefficients of the first object of a scene after its frames, tile by tile.
fn baked(scene: &Path, text: &str) -> Vec<Vec<f32>> {
    std::fs::write(scene, text).unwrap();
    let context = context(2);
    let mut world = World::new(&context, read_file(scene).unwrap(), &[]).unwrap();
    let mut simulator = simulate::Simulator::default();
    simulator.start(&context, &mut world).unwrap();
    for frame in 1..world.scene.output.frames {
        simulator.advance(&context, &mut world, frame).unwrap();
    }
    let Item::Surface(surface) = &world.items()[0] else { panic!("the first object is a surface") };
    let field = surface.displacement().field();
    let values = |tile: u32| {
        let side = field.size(tile) as usize + 2;
        let block = field.block(tile).map(|block| block.iter().map(|value| value.to_f32()).collect());
        block.unwrap_or_else(|| vec![0.0; side * side])
    };
    (0..field.tile_count() as u32).map(values).collect()
}

/// A ground whose tiles have 32 texels a side.
const TILED_GROUND: &str =
    "[surfaces.ground]\nmesh = \"ground\"\n[details]\ntile_size = 32\n[objects.ground]\nsurface = \"ground\"\n";

/// A ball crosses a plane in two frames, or the plane passes below the ball.
fn crossing(ground: &str, ball: &str, more: &str) -> String {
    format!(
        r#"version = 1
[meshes.ground]
{ground}
[meshes.ball]
shape = "sphere"
radius = 0.1
faces = 12
{TILED_GROUND}[objects.ball]
mesh = "ball"
translation = [0, 0.03, 0.06]
[bodies.ball]
shape = "none"
keyframes = [{ball}]
[imprints]
voxels = 262144
max_displacement = 0.1
[colliders.ball]
into = "ground"
[output]
frames = 3
{more}
"#
    )
}

#[test]
fn a_surface_that_passes_a_resting_ball_gets_the_trail_of_a_ball_that_passes_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let plane = "shape = \"plane\"\nsize = [2, 1, 1]\nfaces = 6";
    let way = |sign: f64, y: f64, z: f64| {
        let key = |time: f64, x: f64| format!("{{ time = {time}, translation = [{x}, {y}, {z}] }}");
        format!("{}, {}", key(0.0, -0.6 * sign), key(2.0 / 24.0, 0.6 * sign))
    };
    let rest = "{ time = 0, translation = [0, 0.03, 0.06] }";
    let ball_moves = baked(&scene, &crossing(plane, &way(1.0, 0.03, 0.06), ""));
    let ground_moves = way(-1.0, 0.0, 0.0);
    let keyed = format!("[bodies.ground]\nshape = \"none\"\nkeyframes = [{ground_moves}]");
    let ground_moves = baked(&scene, &crossing(plane, rest, &keyed));
    // The same motion in the points of the cage.
    let (context, mut cage) = (context(1), Mesh::default());
    for frame in 0..3 {
        if frame == 0 {
            std::fs::write(&scene, crossing(plane, rest, "")).unwrap();
            cage = World::new(&context, read_file(&scene).unwrap(), &[]).unwrap().cage(0).clone();
        }
        let points = cage.points.iter().map(|p| format!("v {} {} {}\n", p[0] + 0.6 - 0.6 * frame as f32, p[1], p[2]));
        let faces = cage.corners.chunks(4).map(|c| {
            let list: Vec<String> = c.iter().map(|corner| (corner + 1).to_string()).collect();
            format!("f {}\n", list.join(" "))
        });
        let text: String = points.chain(faces).collect();
        std::fs::write(folder.path().join(format!("slide.{frame}.obj")), text).unwrap();
    }
    let points_move = baked(&scene, &crossing("sequence = \"slide.%d.obj\"\ncount = 3", rest, ""));
    // A voxel of this overlap is about 0.01 long in the plane and 0.002 deep.
    let dented = ball_moves.iter().flatten().filter(|value| **value < -0.02).count();
    assert!(dented > 300, "{dented}");
    for moved in [ground_moves, points_move] {
        for (tile, (a, b)) in ball_moves.iter().zip(&moved).enumerate() {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                assert!((a - b).abs() < 0.012, "tile {tile}, coefficient {index}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_press_through_a_thin_part_is_noted_as_folded() {
    let folder = tempfile::tempdir().unwrap();
    let notes = |name: &str, z: f64| {
        let scene = folder.path().join(format!("{name}.toml"));
        let rest = format!("{{ time = 0, translation = [0, 0, {z}] }}");
        let text = crossing("shape = \"sphere\"\nradius = 0.08\nfaces = 6", &rest, "");
        std::fs::write(&scene, text.replace("max_displacement = 0.1", "max_displacement = 1")).unwrap();
        let out = folder.path().join(name);
        let options = RunOptions { out, frames: Some((0, 1)), allowed: Vec::new(), rebake: false, device: None };
        run(&context(2), read_file(&scene).unwrap(), &options, &mut Silent).unwrap().notes
    };
    // The ball holds the middle of the surface, whose front goes beyond it.
    let through = notes("through", 0.06);
    let note =
        through.iter().find(|note| note.contains("object `ground` is folded")).unwrap_or_else(|| panic!("{through:?}"));
    let numbers: Vec<u64> = note.split(' ').filter_map(|word| word.trim_end_matches(';').parse().ok()).collect();
    // Two triangles for each coefficient of the displaced tiles, and the tile with most of them.
    let [folded, triangles, tile] = numbers[..] else { panic!("{note}") };
    assert!(note.contains(&format!("turns {folded} of {triangles} triangles over")), "{note}");
    assert!(folded > 0 && folded < triangles && triangles % (2 * 32 * 32) == 0 && tile < 216, "{note}");
    // A dent that is shallow beside the radius of the surface.
    let dented = notes("dented", 0.16);
    assert!(dented.iter().all(|note| !note.contains("folded")), "{dented:?}");
}

#[test]
fn a_plate_that_spins_below_a_resting_ball_gets_a_ring() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let plane = "shape = \"plane\"\nsize = [2, 2, 1]\nfaces = 4";
    let rest = "{ time = 0, translation = [0.7, 0, 0.06] }";
    let spin = "[bodies.ground]\nshape = \"none\"\nkeyframes = [{ time = 0 }, { time = 0.04166666666666667, rotation = [0, 0, 360] }]";
    let tiles = baked(&scene, &crossing(plane, rest, spin));
    let (mut inside, mut shallowest) = (0, -1.0f32);
    for (tile, values) in tiles.iter().enumerate() {
        for j in 0..32 {
            for i in 0..32 {
                let at = |cell: usize, index: usize| (cell as f32 + (index as f32 + 0.5) / 32.0) * 0.5 - 1.0;
                let radius = at(tile % 4, i).hypot(at(tile / 4, j));
                let value = values[(j + 1) * 34 + i + 1];
                // The ball is 0.04 deep, where it is 0.08 wide to each side.
                assert!((radius - 0.7).abs() < 0.09 || value == 0.0, "{radius}: {value}");
                if (radius - 0.7).abs() < 0.01 {
                    (inside, shallowest) = (inside + 1, shallowest.max(value));
                }
            }
        }
    }
    assert!(inside > 200 && shallowest < -0.03, "{inside} {shallowest}");
}

#[test]
fn a_flat_plane_presses_with_the_side_behind_its_front() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    for (turn, expected) in [(180.0, -0.06), (0.0, 0.0)] {
        let text = crossing(
            "shape = \"plane\"\nsize = [2, 2, 1]\nfaces = 4",
            &format!(
                "{{ time = 0, translation = [0, 0, 0.2], rotation = [{turn}, 0, 0] }}, \
                 {{ time = 0.08, translation = [0, 0, -0.06] }}"
            ),
            "",
        );
        let sheet = "shape = \"plane\"\nsize = [1.01, 1.01, 1]\nfaces = 5";
        let text = text.replace("shape = \"sphere\"\nradius = 0.1\nfaces = 12", sheet);
        let tiles = baked(&scene, &text);
        for (tile, values) in tiles.iter().enumerate() {
            let middle = [tile % 4, tile / 4].iter().all(|index| (1..=2).contains(index));
            for value in (1..33).flat_map(|j| values[j * 34 + 1..j * 34 + 33].iter()) {
                let wanted = if middle { expected } else { 0.0 };
                // Half a coefficient of the tiles beside lies under the sheet.
                assert!((value - wanted).abs() < 0.004 || !middle && expected < 0.0, "tile {tile}: {value}");
            }
        }
        let world = World::new(&context(1), read_file(&scene).unwrap(), &[]).unwrap();
        assert!(world.notes().iter().any(|note| note.contains("open edges")), "{:?}", world.notes());
    }
}

#[test]
fn materials_of_the_cage_keep_their_names_in_written_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let cage =
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nusemtl deep snow\nf 1 2 5 4\nusemtl ice\nf 2 3 6 5\n";
    std::fs::write(folder.path().join("cage.obj"), cage).unwrap();
    let text = "version = 1\n[meshes.cage]\nfile = \"cage.obj\"\n[surfaces.cage]\nmesh = \"cage\"\n[objects.cage]\n\
        surface = \"cage\"\n[output]\npictures = []\nmesh_formats = [\"glb\", \"obj\"]\nrate = 4\n";
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    let context = context(1);
    run_with(&context, &scene, &options(&out)).unwrap();
    for name in ["mesh-000000.glb", "mesh-000000-cage.obj"] {
        let model = relievo_meshio::read_model(&context, &out.join(name)).unwrap();
        assert_eq!(model.materials, ["deep snow", "ice"], "{name}");
        let slots = &model.meshes[0].mesh.attribute("material").unwrap().values;
        let expected: Vec<u32> = (0..64).map(|triangle| u32::from(triangle >= 32)).collect();
        assert_eq!(*slots, relievo_core::Values::U32(expected), "{name}");
    }
}

/// A cow with n-gons and triangles by Keenan Crane, public domain, dented by a wheel.
#[test]
fn a_real_model_is_dented() {
    let Some(cage) = relievo_testing::file("cages/spot_control_mesh.obj") else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = format!(
        r#"version = 1
up = "y"
[meshes.spot]
file = {:?}
[meshes.ball]
shape = "spiked_ball"
radius = 0.2
spikes = 40
spike_length = 0.06
spike_radius = 0.03
[surfaces.spot]
mesh = "spot"
[details]
tile_size = 32
[objects.spot]
surface = "spot"
[objects.ball]
mesh = "ball"
[bodies.ball]
keyframes = [{{ time = 0, translation = [0.75, 0.1, 0.1] }}, {{ time = 0.1, translation = [0.42, 0.1, 0.1] }}]
[imprints]
voxels = 1048576
[colliders.ball]
into = "spot"
[output]
frames = 3
width = 64
height = 48
picture_frames = "last"
mesh = "none"
"#,
        cage.display().to_string()
    );
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    let refused = run_with(&context(2), &scene, &options(&out)).unwrap_err().to_string();
    assert!(refused.contains("--allow-path") && refused.contains("scene.toml:4:8"), "{refused}");
    let allowed = RunOptions { allowed: vec![relievo_testing::folder()], ..options(&out) };
    let summary = run_with(&context(2), &scene, &allowed).unwrap();
    assert!(summary.tiles[0] > 0, "{:?}", summary.tiles);
    assert!(out.join("beauty-000002.png").exists());
}

#[test]
fn meshes_of_every_frame_refine_the_texture_coordinates_once() {
    let folder = tempfile::tempdir().unwrap();
    let quads = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                 f 1/1 2/2 3/3 4/4\nf 2/1 5/2 6/3 3/4\n";
    std::fs::write(folder.path().join("quads.obj"), quads).unwrap();
    let scene = folder.path().join("scene.toml");
    let refinements = |frames: u32| {
        let text = format!(
            "version = 1\n[meshes.ground]\nfile = \"quads.obj\"\n[surfaces.ground]\nmesh = \"ground\"\n[objects.ground]\n\
             surface = \"ground\"\n[output]\nframes = {frames}\npicture_frames = \"none\"\nmesh = \"every\"\nmesh_formats = [\"obj\"]\nrate = 4\n"
        );
        std::fs::write(&scene, text).unwrap();
        let out = folder.path().join(format!("out-{frames}"));
        let summary = run_with(&context(1), &scene, &options(&out)).unwrap();
        assert_eq!(summary.files.len(), frames as usize);
        let costs = summary.trace.costs();
        costs.iter().find(|cost| cost.stage == "surface.refine").unwrap().calls
    };
    // The surface, and its texture coordinates.
    assert_eq!((refinements(1), refinements(5)), (2, 2));
}
