//! `relievo fluid` as a user sees it.

use std::path::Path;
use std::process::{Command, Output};

fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const DAM: &str = "frames = 3\nfps = 50\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [1, 0.3, 0.6]\n\
    [[block]]\nlow = [0, 0, 0]\nhigh = [0.3, 0.3, 0.5]\n";

#[test]
fn a_dam_is_simulated_and_its_frames_are_meshed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    let done = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames"]);
    assert!(
        done.status.success() && text(&done.stdout).starts_with("360 particles 0.05 m apart, 3 frames"),
        "{done:?}"
    );
    let frame = |number: u32| std::fs::read(folder.path().join(format!("frames/{number:04}.ply"))).unwrap();
    assert!(text(&frame(3)[..187]).contains("property float vx"));
    // As many threads as there are, or one.
    let again = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "again", "--threads", "1"]);
    assert!(again.status.success(), "{again:?}");
    assert!((0..4).all(|number| frame(number) == std::fs::read(folder.path().join(format!("again/{number:04}.ply"))).unwrap()));
    let mesh = |more: &[&str]| {
        relievo(
            folder.path(),
            &[&["fluid", "mesh", "frames/0000.ply", "-o", "surface.ply", "--spacing", "0.05"], more].concat(),
        )
    };
    assert!(mesh(&[]).status.success());
    let info = relievo(folder.path(), &["info", "--json", "surface.ply"]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert!(found["faces"].as_u64().unwrap() > 1000, "{found}");
    for function in ["blobs", "density", "anisotropic"] {
        let done = mesh(&["--function", function, "--cell", "1"]);
        assert!(done.status.success() && text(&done.stdout).starts_with("360 particles, "), "{done:?}");
    }
}

#[test]
fn what_cannot_be_a_fluid_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |description: &str, why: &str| {
        std::fs::write(folder.path().join("dam.toml"), description).unwrap();
        let done = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames"]);
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused("", "frames");
    refused(&DAM.replace("spacing = 0.05", "spacing = 0"), "spacing");
    refused(&DAM.replace("spacing = 0.05", "space = 0.05"), "space");
    refused(&DAM.replace("fps = 50", "fps = 0"), "fps");
    refused(&DAM.replace("high = [1, 0.3, 0.6]", "high = [1, 0.3, nan]"), "basin");
    refused(&DAM.replace("high = [0.3, 0.3, 0.5]", "high = [3e9, 0.3, 0.5]"), "block 0");
    refused(&DAM.replace("[fluid]", "[fluid]\nkernels = \"none\""), "mueller");
    let lost = relievo(folder.path(), &["fluid", "mesh", "none.ply", "-o", "surface.ply", "--spacing", "0.05"]);
    assert!(lost.status.code() == Some(1) && text(&lost.stderr).contains("none.ply"), "{lost:?}");
}

#[test]
fn colliders_emitters_sinks_and_forces_act_in_the_example() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fluids/mill.toml");
    let text_of = std::fs::read_to_string(example).unwrap();
    let short = text_of.replace("frames = 48", "frames = 4").replace("spacing = 0.025", "spacing = 0.05");
    let run = |description: &str| {
        std::fs::write(folder.path().join("mill.toml"), description).unwrap();
        relievo(folder.path(), &["fluid", "sim", "mill.toml", "-o", "frames"])
    };
    let done = run(&short);
    let count = |done: &Output| -> u32 { text(&done.stdout).split(' ').next().unwrap().parse().unwrap() };
    // 24 by 8 by 4 that rest, and 6 layers of a jet.
    assert!(done.status.success() && count(&done) >= 768 + 6 * 4, "{done:?}");
    let without = run(&short.replace("speed = 2", "start = 100\nspeed = 2"));
    assert!(count(&without) == 768 && count(&done) < 768 + 7 * 12, "{without:?}");
    let refused = |from: &str, to: &str, why: &str| {
        assert!(short.contains(from), "{from}");
        let done = run(&short.replace(from, to));
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused("friction = 0.2", "friction = -1", "friction");
    refused("friction = 0.2", "rubs = 1", "rubs");
    refused("friction = 0.2", "contact = \"glue\"", "slip or stop");
    refused("time = 1.4", "time = 0.4", "collider 0: keys");
    refused("speed = 2", "speed = 0", "emitter 0");
    refused("particles = 40000\nstop = true", "particles = 780", "budget");
    refused("kind = \"wind\"", "kind = \"magic\"", "magic");
    refused("density = 600", "density = 0", "body 0");
    refused("share = 0.2", "share = 1e9", "force 0");
    refused("scale = 0.3", "scale = 0.3\nsize = 1", "size");
    refused("box = { low = [0, 0, 0], high = [1.2, 0.4, 0.2] }", "mesh = \"none.obj\"", "none.obj");
    refused("box = { low = [0, 0, 0], high = [1.2, 0.4, 0.2] }", "", "fill 0");
}
