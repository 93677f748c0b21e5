//! Bézier patches as a user of the command sees them: looked into, made into meshes, exported and drawn.

mod program;

use relievo_render::{Picture, compare_geometry};

use program::{relievo, text};

/// A quarter of a cylinder and a bump, with weights.
const PATCHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fuzz/seeds/patches/seed.bpt");

#[test]
fn patches_are_looked_into_and_become_meshes_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let info = relievo(folder, &["info", PATCHES]);
    assert!(info.status.success() && text(&info.stdout).contains("2 rational bicubic Bézier patches"), "{info:?}");
    let info = relievo(folder, &["info", "--json", PATCHES]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&found["patches"], &found["border_edges"]), (&2.into(), &8.into()));
    let made = relievo(folder, &["mesh", "tessellate", PATCHES, "-o", "mesh.ply", "--level", "2"]);
    assert!(made.status.success(), "{made:?}");
    let info = relievo(folder, &["info", "--json", "mesh.ply"]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&found["faces"], &found["problem"]), (&(2 * 2 * 7 * 7).into(), &serde_json::Value::Null));
    // Raised to degree 3, which is what the copy has.
    assert!(relievo(folder, &["mesh", "tessellate", PATCHES, "-o", "copy.bpt"]).status.success());
    let copy = relievo(folder, &["info", "copy.bpt"]);
    assert!(text(&copy.stdout).contains("2 rational bicubic"), "{copy:?}");
    let refused = relievo(folder, &["scene", "export", "pov", PATCHES, "--out", "scene"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("relievo mesh tessellate"), "{refused:?}");
    let level = relievo(folder, &["mesh", "tessellate", PATCHES, "-o", "mesh.ply", "--level", "9"]);
    assert_eq!(level.status.code(), Some(2));
    let plain = std::fs::read_to_string(folder.join("copy.bpt")).unwrap();
    let plain: String = plain
        .lines()
        .map(|line| match line.rsplit_once(' ') {
            Some((point, _)) if line.matches(' ').count() == 3 => format!("{point}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    std::fs::write(folder.join("plain.bpt"), plain).unwrap();
    let exported = relievo(folder, &["scene", "export", "pov", "plain.bpt", "--out", "scene"]);
    assert!(exported.status.success(), "{exported:?}");
    let scene = std::fs::read_to_string(folder.join("scene/scene-000000.pov")).unwrap();
    assert_eq!(scene.matches("bicubic_patch").count(), 2);
}

#[test]
fn a_graphics_device_draws_what_the_processor_casts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let draw = |device: &str, output: &str| {
        let shape = ["--size", "96x72", "--samples", "1", "--level", "5", "-o", output];
        relievo(folder, &[&["draw", PATCHES, "--device", device][..], &shape].concat())
    };
    let cast = draw("cpu", "cast.exr");
    assert!(cast.status.success(), "{cast:?}");
    if relievo_gpu::adapters().is_empty() {
        let error = draw("gpu", "drawn.exr");
        assert!(!error.status.success() && text(&error.stderr).contains("graphics device"), "{error:?}");
        println!("skipped: there is no graphics device");
        return;
    }
    let drawn = draw("gpu", "drawn.exr");
    assert!(drawn.status.success() && text(&drawn.stderr).contains("2 patches in 1 draws"), "{drawn:?}");
    let [cast, drawn] = ["cast.exr", "drawn.exr"].map(|name| Picture::read(&folder.join(name), u64::MAX).unwrap());
    let difference = compare_geometry(&cast, &drawn, None).unwrap().unwrap();
    assert!(difference.covered > 500 && difference.silhouette() < 0.01, "{difference:?}");
    assert!(difference.depth.unwrap().p999 < 1e-4, "{difference:?}");
    let tuned = relievo(folder, &["draw", PATCHES, "--tune", "--size", "32x24", "-o", "tuned.png"]);
    assert!(tuned.status.success() && text(&tuned.stdout).contains("N_DP"), "{tuned:?}");
    let none = relievo(folder, &["draw", PATCHES, "--adapter", "no such device", "-o", "none.png"]);
    assert!(!none.status.success() && text(&none.stderr).contains("no graphics device is called"), "{none:?}");
}
