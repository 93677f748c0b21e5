//! Meshes that follow frames of soft tissue.

use relievo_core::Context;
use relievo_scene::assets::Assets;
use relievo_scene::description::Up;
use relievo_scene::paths::Paths;
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
