//! What `relievo view` plays and does not edit, on a display without a screen: particles, levels, soft tissue and scenes, all
//! made here.
#![cfg(feature = "view")]

mod display;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use relievo_core::{Context, ContextOptions};
use relievo_particleio::{Channel, Particles};

use display::{difference, is_possible, pictures, share, view};

/// The part of a picture that the view has.
const VIEW: [f32; 4] = [0.3, 0.1, 0.95, 0.85];

fn done(folder: &Path, arguments: &[&str]) {
    let done = Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn particles_are_played_coloured_and_recorded() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let context = Context::new(&ContextOptions::default()).unwrap();
    std::fs::create_dir(folder.join("drops")).unwrap();
    for frame in 0..4 {
        // Drops in a wall, which climbs from frame to frame. Their speed is their x coordinate.
        let place = |at: i32| [(at % 8) as f32, 0.0, (at / 8) as f32 + 2.0 * frame as f32];
        let points: Vec<[f32; 3]> = (0..64).map(place).chain([[3.5, 0.0, 14.0]]).collect();
        let values = points.iter().flat_map(|point| [0.0, 0.0, point[0]]).collect();
        let channels = vec![Channel { name: "velocity".into(), width: 3, values }];
        let particles = Particles { points, spacing: Some(1.0), channels, ..Particles::default() };
        relievo_particleio::write(&context, &folder.join(format!("drops/{frame:04}.bgeo")), &particles).unwrap();
    }
    let script = "resize 1000 620\nkey 1\nwait_frames 2\nscreenshot first.png\npress velocity\nwait_frames 1\n\
        screenshot fast.png\npress plain\nkey Right\nkey Right\nwait_frames 1\nscreenshot third.png\n\
        key Space\nwait_frames 2\nkey Space\npress Record\nwait_frames 2\npress Write pictures\nrest\nquit\n";
    view(folder, &["drops"], script);
    let [first, fast, third] = pictures(folder, ["first", "fast", "third"]);
    assert!(difference(&first, &third) > 0.1, "{}", difference(&first, &third));
    // Dark blue at first; by speed from violet at the left to yellow at the right.
    let is_yellow = |[r, g, b]: [f32; 3]| r > 0.3 && g > 0.3 && b < 0.3 * g;
    assert!(share(&first, VIEW, is_yellow) < 1e-3 && share(&fast, VIEW, is_yellow) > 0.005);
    // The pictures have the view alone.
    let recorded = pictures(folder, ["frames/0000", "frames/0001", "frames/0002", "frames/0003"]);
    assert!(recorded.iter().all(|image| image.width() < 900 && image.width() > 600 && image.height() > 450));
    assert!(difference(&recorded[0], &recorded[3]) > 0.1);
    assert!(!folder.join("frames/0004.png").exists());
}

/// Where the handle of the waves begins in the view, and parts of a picture around it and around the middle.
const HANDLE: &str = "0.81 0.95";
const CORNER: [f32; 4] = [0.79, 0.76, 0.86, 0.9];
const MIDDLE: [f32; 4] = [0.59, 0.45, 0.65, 0.56];

/// Writes waves over a square of 4 by 4 as a progressive mesh.
fn write_waves(folder: &Path) {
    let mut text = String::new();
    for at in 0..41 * 41 {
        let [x, y] = [at % 41, at / 41].map(|at| 0.1 * f64::from(at));
        writeln!(text, "v {x} {y} {}", 0.3 * (3.0 * x).sin() * (2.0 * y).cos()).unwrap();
    }
    for at in 0..40 * 40 {
        let first = 1 + at % 40 + 41 * (at / 40);
        writeln!(text, "f {} {} {} {}", first, first + 1, first + 42, first + 41).unwrap();
    }
    std::fs::write(folder.join("waves.obj"), text).unwrap();
    done(folder, &["progressive", "build", "waves.obj", "-o", "waves.rlvpm"]);
}

#[test]
fn a_slider_sets_the_level_of_a_progressive_mesh() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_waves(folder);
    // A click on the slider, right of its middle.
    let script = "resize 1000 620\nwait_frames 1\nkey w\npoint 0.02 0.02\nwait_frames 2\nscreenshot fine.png\n\
        press Triangles\npoint 0.02 0.02\nwait_frames 2\nscreenshot coarse.png\nquit\n";
    view(folder, &["waves.rlvpm"], script);
    let [fine, coarse] = pictures(folder, ["fine", "coarse"]);
    // Edges of triangles are dark lines, of which the coarse level has fewer.
    let is_line = |[r, g, b]: [f32; 3]| r < 0.012 && g < 0.014 && b < 0.02;
    let [many, few] = [&fine, &coarse].map(|image| share(image, VIEW, is_line));
    assert!(many > 0.02 && few > 1e-4 && few < 0.75 * many, "{many} {few}");
}

#[test]
fn a_level_shows_its_deviation_and_is_finer_at_a_handle() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_waves(folder);
    // Key 7 looks from above. The handle begins at the corner of the waves that is at the lower right.
    let script = "resize 1000 620\nwait_frames 1\npress Triangles\npress deviation\nrest\nwait_frames 2\nscreenshot even.png\n\
        press at the handle\nkey 7\nkey Home\nkey w\nrest\nwait_frames 2\nscreenshot corner.png\n\
        drag left HANDLE 0.5 0.5\npoint 0.02 0.02\nrest\nwait_frames 2\nscreenshot middle.png\nquit\n";
    view(folder, &["waves.rlvpm"], &script.replace("HANDLE", HANDLE));
    let [even, corner, middle] = pictures(folder, ["even", "corner", "middle"]);
    // By deviation from violet to yellow.
    let is_violet = |[r, g, b]: [f32; 3]| b > 1.5 * g && r > 0.5 * g;
    let is_yellow = |[r, g, b]: [f32; 3]| r > 0.2 && g > 0.2 && b < 0.4 * g;
    assert!(share(&even, VIEW, is_violet) > 0.02, "{}", share(&even, VIEW, is_violet));
    assert!(share(&even, VIEW, is_yellow) > 1e-3, "{}", share(&even, VIEW, is_yellow));
    // It is the finest mesh where the handle is.
    let is_exact = |[r, g, b]: [f32; 3]| r > 2.0 * g && b > 4.0 * g;
    let within = |image| [CORNER, MIDDLE].map(|part| share(image, part, is_exact));
    let (at_corner, at_middle) = (within(&corner), within(&middle));
    assert!(at_corner[0] > 0.3 && at_corner[1] < 0.1, "{at_corner:?}");
    assert!(at_middle[1] > 0.3 && at_middle[0] < 0.1, "{at_middle:?}");
}

#[test]
fn tissue_is_coloured_by_stress_and_cut_and_a_scene_is_played() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let block = "voxel = 0.01\n[[material]]\nname = \"gel\"\nyoung = 8000\npoisson = 0.45\n[[volume]]\nname = \"block\"\n\
        body = { box = { low = [0, 0, 0], high = [0.06, 0.06, 0.03] } }\nmaterial = \"gel\"\n";
    let press = "model = \"block.rtissue\"\nframes = 2\nfps = 100\n[options]\ndamping = 20\n[[move]]\nset = \"z-\"\n\
        [[collider]]\nball = 0.02\nkeys = [{ time = 0, at = [0.03, 0.03, 0.051] }, { time = 0.02, at = [0.03, 0.03, 0.044] }]\n";
    std::fs::write(folder.join("block.toml"), block).unwrap();
    std::fs::write(folder.join("press.toml"), press).unwrap();
    done(folder, &["tissue", "build", "block.toml", "-o", "block.rtissue"]);
    done(folder, &["tissue", "sim", "press.toml", "-o", "states"]);
    let script = "resize 1000 620\nwait_frames 1\nscreenshot rest.png\npress stress\nkey Right\nkey Right\nwait_frames 2\n\
        screenshot pressed.png\npress x\nwait_frames 2\nscreenshot open.png\nquit\n";
    view(folder, &["press.toml", "states"], script);
    let [rest, pressed, open] = pictures(folder, ["rest", "pressed", "open"]);
    assert!(difference(&rest, &pressed) > 0.1 && difference(&pressed, &open) > 0.05);

    let scene = "version = 1\n[meshes.field]\nshape = \"plane\"\nsize = [4, 4, 1]\n[meshes.ball]\nshape = \"spiked_ball\"\n\
        [surfaces.field]\nmesh = \"field\"\n[objects.field]\nsurface = \"field\"\n[objects.ball]\nmesh = \"ball\"\n\
        [bodies.ball]\nkeyframes = [{ time = 0, translation = [-1.2, 0, 0.56] }, { time = 0.1, translation = [1.2, 0.6, 0.5] }]\n\
        [colliders.ball]\ninto = [\"field\"]\n[output]\nframes = 3\npictures = []\n";
    std::fs::write(folder.join("roll.toml"), scene).unwrap();
    // It is baked in the window, which follows, and again by the command, which has nothing left to do.
    let script = "resize 1000 620\nwait_frames 1\nscreenshot before.png\npress Bake\nrest\nwait_frames 2\nscreenshot baked.png\n\
        key Left\nkey Left\nwait_frames 2\nscreenshot first.png\npress Bake\nwait_frames 2\nquit\n";
    view(folder, &["roll.toml", "rolled"], script);
    let [before, baked, first] = pictures(folder, ["before", "baked", "first"]);
    assert!(difference(&before, &baked) > 0.02, "{}", difference(&before, &baked));
    // The first frame has a dent that the scene at its start has not.
    assert!(difference(&before, &first) < difference(&before, &baked));
    let again = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["scene", "run", "roll.toml", "--out", "rolled"])
        .current_dir(folder)
        .output()
        .unwrap();
    let report = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(report.contains("frames: 0 computed, 3 opened from the cache"), "{report}");
    let script = "resize 1000 620\nwait_frames 1\nscreenshot start.png\nkey Space\nkey Space\nwait_frames 1\n\
        screenshot later.png\nquit\n";
    view(folder, &["roll.toml", "rolled"], script);
    let [start, later] = pictures(folder, ["start", "later"]);
    assert!(difference(&start, &later) > 0.02, "{}", difference(&start, &later));
}

#[test]
fn a_fluid_is_baked_with_its_foam_in_the_window() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let dam = "frames = 16\nfps = 24\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [1.4, 0.6, 1.5]\n\
        [[fill]]\nbox = { low = [0, 0, 0], high = [0.5, 0.6, 0.8] }\nvelocity = [1.5, 0, 0]\n";
    std::fs::write(folder.join("dam.toml"), dam).unwrap();
    let script = "resize 1000 620\nkey 1\nwait_frames 2\nscreenshot start.png\npress Bake\nrest\nwait_frames 2\n\
        screenshot balls.png\npress surface\nwait_frames 2\nscreenshot surface.png\nquit\n";
    view(folder, &["dam.toml"], script);
    let [start, balls, surface] = pictures(folder, ["start", "balls", "surface"]);
    assert!(difference(&start, &balls) > 0.1 && difference(&balls, &surface) > 0.02);
    // Foam is white, water blue.
    let is_white = |[r, g, b]: [f32; 3]| r > 0.3 && r > 0.7 * b && g > 0.7 * b;
    assert!(share(&start, VIEW, is_white) < 1e-4, "{}", share(&start, VIEW, is_white));
    assert!(share(&balls, VIEW, is_white) > 1e-3, "{}", share(&balls, VIEW, is_white));
    assert!(folder.join("dam-out/0016.rlvfluid").exists() && folder.join("dam-out/foam/0016.rlvfluid").exists());
    // The command finds the frames done: they are its own.
    let again = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["fluid", "sim", "dam.toml", "-o", "dam-out"])
        .current_dir(folder)
        .output()
        .unwrap();
    let notes = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(again.status.success() && notes.contains("goes on from dam-out/0016.rlvfluid"), "{notes}");
    // Foam that lives for a moment and is rare is baked anew, and the water is not.
    let water = std::fs::read(folder.join("dam-out/0016.rlvfluid")).unwrap();
    let foam = || {
        let context = Context::new(&ContextOptions::default()).unwrap();
        relievo_particleio::read(&context, &folder.join("dam-out/foam/0016.rlvfluid")).unwrap().particles.points.len()
    };
    let before = foam();
    let script = "resize 1000 860\nkey 1\npress frame\nwait_frames 2\npress kinds\npress Amount of foam\npress Bake\nrest\n\
        wait_frames 2\nscreenshot kinds.png\npress hidden\nwait_frames 2\nscreenshot hidden.png\nquit\n";
    view(folder, &["dam.toml"], script);
    let [kinds, hidden] = pictures(folder, ["kinds", "hidden"]);
    let after = foam();
    assert!(before > 100 && after > 5 * before / 4, "{before} {after}");
    assert_eq!(std::fs::read(folder.join("dam-out/0016.rlvfluid")).unwrap(), water);
    let is_spray = |[r, g, b]: [f32; 3]| r > 0.25 && g < 0.8 * r && b < 0.5 * g;
    assert!(share(&kinds, VIEW, is_spray) > 1e-4, "{}", share(&kinds, VIEW, is_spray));
    assert!(share(&hidden, VIEW, is_spray) < 1e-5 && share(&hidden, VIEW, is_white) < 1e-4);
    // What is there is shown without a bake.
    view(folder, &["dam.toml"], "resize 1000 620\nkey 1\nkey Right\nwait_frames 2\nscreenshot second.png\nquit\n");
    let [second] = pictures(folder, ["second"]);
    assert!(difference(&start, &second) > 0.02);
}
