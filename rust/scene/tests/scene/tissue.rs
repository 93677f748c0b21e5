//! Meshes that follow frames of soft tissue.

use std::path::Path;

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_scene::assets::Assets;
use relievo_scene::description::Up;
use relievo_scene::paths::Paths;
use relievo_scene::stepper::{RunOptions, Summary, run};
use relievo_tissue::{Binding, Material, Model, SavedState, State};

#[test]
fn a_surface_follows_frames_of_soft_tissue() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    let material = Material { name: "gel".into(), density: 1000.0, shear: 1000.0, bulk: 1e4 };
    let mut model = Model::block([0.0; 3], [1.0; 3], [1, 1, 1], material).unwrap();
    let points = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    model.bindings.push(Binding::new(&context, &model, "skin", &points, &[[0, 1, 2]]).unwrap());
    model.write(&folder.path().join("gel.rtissue")).unwrap();
    for frame in 0..3u16 {
        let rows = vec![[0.0, 0.0, f32::from(frame), 0.0]; 8];
        let state = State { displacements: rows.clone(), velocities: rows, ..State::default() };
        let saved = SavedState { state, ..SavedState::default() };
        saved.write(&folder.path().join(format!("{frame:04}.rtstate"))).unwrap();
    }
    let scene = |bound: &str| {
        let text = format!(
            "version = 1\n[objects.a]\nmesh = \"a\"\n[meshes.a]\nsequence = \"####.rtstate\"\ncount = 3\n\
             tissue = \"gel.rtissue\"\nbound = \"{bound}\"\n"
        );
        let path = folder.path().join("scene.toml");
        let scene = relievo_scene::file::parse(&path, &text).unwrap_or_else(|faults| panic!("{faults}"));
        (scene, Paths::new(&path, &[]).unwrap())
    };
    let (good, paths) = scene("skin");
    let mut assets = Assets::load(&context, &good, &paths).unwrap();
    assert!(assets.is_animated(0));
    let up = if good.up == Up::Z { 2 } else { 1 };
    for (frame, height) in [(0.0, 1.0), (0.5, 1.5), (2.0, 3.0), (9.0, 3.0)] {
        let found = assets.points(&context, 0, frame / 24.0, 24.0).unwrap();
        assert!((f64::from(found[0][up]) - height / good.metres).abs() < 1e-5, "{found:?}");
    }
    let (bad, paths) = scene("bone");
    assert!(Assets::load(&context, &bad, &paths).unwrap_err().to_string().contains("it has skin"));
}

/// A block of gel on the ground, and a box that comes down on a part of it and presses 0.1 m deep.
const PRESSED: &str = r#"
version = 1
[[tissue]]
name = "gel"
simulation = "rest.toml"
colliders = ["stamp"]
[meshes.gel]
simulated = "gel"
[meshes.stamp]
shape = "box"
size = [0.6, 0.6, 0.4]
[surfaces.gel]
mesh = "gel"
kind = "triangles"
[objects.gel]
surface = "gel"
translation = [0, 0, 1]
[objects.stamp]
mesh = "stamp"
[bodies.stamp]
keyframes = [{ time = 0, translation = [0, 0, 1.8] }, { time = 0.125, translation = [0, 0, 1.6], rotation = [0, 0, 90] }]
[colliders.stamp]
into = ["gel"]
[output]
frames = 4
images = []
mesh = "every"
"#;

const GEL: &str = r#"
voxel = 0.125
samples = 1
material = [{ name = "gel", young = 20000, poisson = 0.4 }]
volume = [{ name = "gel", material = "gel", body = { box = { low = [-1, -1, 0], high = [1, 1, 0.5] } } }]
bind = [{ name = "top", body = { box = { low = [-1, -1, 0], high = [1, 1, 0.5], side = "z+", divisions = 8 } } }]
"#;

const REST: &str = r#"
model = "gel.toml"
frames = 1
options = { gravity = [0, 0, 0], damping = 20.0, safety = 0.5 }
move = [{ set = "z-" }]
"#;

fn run_in(folder: &Path, out: &str) -> (Summary, Vec<Vec<u8>>) {
    let path = folder.join("scene.toml");
    let scene = relievo_scene::file::parse(&path, PRESSED).unwrap_or_else(|faults| panic!("{faults}"));
    let options = RunOptions { out: folder.join(out), frames: None, allowed: Vec::new(), rebake: false, device: None };
    let summary = run(&Context::serial(), scene, &options, &mut Silent).unwrap();
    let states =
        (0..4).map(|frame| std::fs::read(folder.join(out).join(format!("cache/tissue/gel-{frame:06}.rtstate"))));
    (summary, states.map(Result::unwrap).collect())
}

#[test]
fn a_scene_simulates_tissue_that_its_bodies_press_and_goes_on_from_its_cache() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gel.toml"), GEL).unwrap();
    std::fs::write(folder.path().join("rest.toml"), REST).unwrap();
    let (summary, whole) = run_in(folder.path(), "out");
    assert_eq!((summary.baked, summary.opened), (4, 0));
    // The stamp is half of its height, 0.2, above where its lower side is, and the tissue begins at 1.
    let heights = |bytes: &[u8]| -> Vec<f32> {
        let saved = SavedState::decode(bytes).unwrap();
        saved.state.displacements.iter().map(|row| row[2]).collect()
    };
    let lowest = |bytes: &[u8]| heights(bytes).into_iter().fold(0f32, f32::min);
    assert_eq!(lowest(&whole[0]), 0.0);
    assert!((lowest(&whole[3]) + 0.1).abs() < 1e-4, "{}", lowest(&whole[3]));
    // What is not below the stamp stays, or rises beside it.
    assert!(heights(&whole[3]).iter().any(|height| *height > 0.0));

    // A frame of the scene and one of the tissue that are gone or damaged are made again, to the bit.
    let cache = folder.path().join("out/cache");
    let last = std::fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path());
    let mut frames: Vec<_> = last.filter(|path| path.is_file()).collect();
    frames.sort();
    std::fs::remove_file(frames.last().unwrap()).unwrap();
    std::fs::remove_file(cache.join("tissue/gel-000003.rtstate")).unwrap();
    let damaged = cache.join("tissue/gel-000002.rtstate");
    std::fs::write(&damaged, &whole[2][..whole[2].len() / 2]).unwrap();
    let (summary, again) = run_in(folder.path(), "out");
    assert_eq!((summary.baked, summary.opened), (1, 3));
    assert!(summary.notes.iter().any(|note| note.contains("simulated again")), "{:?}", summary.notes);
    assert!(whole == again);
    assert_eq!(run_in(folder.path(), "other").1, whole);
}

#[test]
fn tissue_that_cannot_be_used_is_an_error_at_its_place() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gel.toml"), GEL).unwrap();
    std::fs::write(folder.path().join("rest.toml"), REST).unwrap();
    let path = folder.path().join("scene.toml");
    for (from, to, says) in [
        ("simulated = \"gel\"", "simulated = \"jelly\"", "use `gel`"),
        ("simulation = \"rest.toml\"", "simulation = \"missing.toml\"", "there is no file"),
        ("simulation = \"rest.toml\"", "simulation = \"../rest.toml\"", "--allow-path"),
        ("colliders = [\"stamp\"]", "colliders = [\"gel\"]", "changes its shape"),
        ("colliders = [\"stamp\"]", "colliders = [\"stomp\"]", "did you mean `stamp`"),
        ("translation = [0, 0, 1]\n", "scale = [1, 2, 1]\n", "not scaled evenly"),
        (
            "[bodies.stamp]",
            "[bodies.gel]\nmotion = \"fixed\"\nshape = \"none\"\n[bodies.stamp]",
            "moves soft tissue as a whole",
        ),
    ] {
        assert!(PRESSED.contains(from), "{from}");
        let made =
            relievo_scene::file::parse(&path, &PRESSED.replacen(from, to, 1)).map_err(|faults| faults.to_string());
        let loaded = made.and_then(|scene| {
            relievo_scene::world::World::new(&Context::serial(), scene, &[]).map_err(|failure| failure.to_string())
        });
        let shown = loaded.map(|_| ()).unwrap_err();
        assert!(shown.contains(says), "{to}: {shown}");
    }
}
