//! Traces of contact in scenes: pictures tint them, meshes and documents carry them, caches keep them.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, Values};
use relievo_gpu::Device;
use relievo_scene::file::parse;
use relievo_scene::stepper::{RunOptions, run};

use crate::support::run_in;

const SCENE: &str = concat!(
    ground_and_tool!(),
    r##"[details]
tile_size = 16
[objects.ground]
surface = "ground"
colour = [1, 1, 1]
DOCUMENT
traces = { colour = [0, 0, 1], depth = 0.02, fade = 1 }
"##,
    pressing_tool!(),
    r##"[camera]
position = [0, 0, 2]
target = [0, 0, 0]
[output]
frames = 7
"##,
    small_pictures!(),
    r##"pictures = ["beauty"]
picture_frames = "every"
mesh = "last"
mesh_formats = ["ply"]
documents = "last"
"##,
);

/// How much bluer than red the middle of the picture of a frame is, 0 to 255.
fn blue(folder: &Path, frame: u32) -> f32 {
    let name = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let path = name.into_iter().find(|path| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.contains("beauty") && name.contains(&format!("{frame:06}"))
    });
    let image = relievo_render::read_png(&path.unwrap(), 1 << 24).unwrap();
    let at = &image.data()[(32 * 64 + 32) * image.channels() as usize..];
    255.0 * (at[2] - at[0])
}

#[test]
fn tracks_are_tinted_carried_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let text = SCENE.replace("DOCUMENT\n", "");
    let whole = run_in(folder.path(), "whole", &text, None, 1);
    assert_eq!(whole.baked, 7);
    let out = folder.path().join("whole");
    // The middle is touched on the way, and its tint fades after the tool left.
    let blues: Vec<f32> = (0..7).map(|frame| blue(&out, frame)).collect();
    assert!(blues[0] < 40.0 && blues[3] > 150.0, "{blues:?}");
    assert!(blues[5] < blues[4] && blues[6] < blues[5], "{blues:?}");

    let mesh = relievo_meshio::read(&Context::serial(), &out.join("mesh-000006-ground.ply")).unwrap();
    let list = |name: &str| match &mesh.attribute(name).unwrap().values {
        Values::F32(values) => values.clone(),
        Values::U32(_) => panic!("{name} holds integers"),
    };
    let (contact, depth, age) = (list("contact"), list("depth"), list("age"));
    let touched = contact.iter().filter(|contact| **contact == 1.0).count();
    assert!(touched > 100 && contact.contains(&0.0), "{touched}");
    for ((contact, depth), age) in contact.iter().zip(&depth).zip(&age) {
        assert!((*contact > 0.0) == (*depth > 0.0) && (*contact > 0.0) == (*age >= 0.0), "{contact} {depth} {age}");
        assert!(*age <= 0.25 && *depth < 0.05, "{depth} {age}");
    }
    assert!(age.iter().any(|age| *age > 0.2), "the beginning of the track is the oldest");

    // Broken off and gone on with, and taken up from the document, it ends the same.
    run_in(folder.path(), "parts", &text, Some((0, 2)), 1);
    let rest = run_in(folder.path(), "parts", &text, None, 1);
    assert_eq!((rest.baked, rest.opened), (4, 3));
    let document = |name: &str| std::fs::read(folder.path().join(name).join("document-000006-ground.relievo")).unwrap();
    assert_eq!(document("parts"), document("whole"));
    let last = |name: &str| std::fs::read(folder.path().join(name).join("mesh-000006-ground.ply")).unwrap();
    assert_eq!(last("parts"), last("whole"));
    let still = SCENE.replace("DOCUMENT", "document = \"whole/document-000006-ground.relievo\"");
    let still = still.replace("into", "").replace("[colliders.tool]\n", "");
    run_in(folder.path(), "still", &still, None, 1);
    assert_eq!(document("still"), document("whole"));
}

#[test]
fn a_graphics_device_tints_tracks_too() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = SCENE.replace("DOCUMENT\n", "").replace("sky_rays = 1", "sky_rays = 0");
    let text = text.replace("mesh = \"last\"\nmesh_formats = [\"ply\"]\ndocuments = \"last\"\n", "mesh = \"none\"\n");
    let go = |name: &str, device: Option<Device>| {
        let scene = parse("scene.toml".as_ref(), &text).unwrap();
        let options =
            RunOptions { out: folder.path().join(name), frames: None, allowed: Vec::new(), rebake: false, device };
        run(&Context::serial(), scene, &options, &mut Silent).unwrap();
        (0..7).map(|frame| blue(&folder.path().join(name), frame)).collect::<Vec<f32>>()
    };
    let (here, there) = (go("here", None), go("there", Some(device)));
    // It fades although nothing is written any more.
    assert!(there[0] < 40.0 && there[3] > 150.0 && there[5] < there[4] && there[6] < there[5], "{there:?}");
    assert!(here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 6.0), "{here:?} {there:?}");
}
