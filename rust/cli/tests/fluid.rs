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

#[test]
fn fluids_are_rendered_directly_and_as_meshes_alike() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames"]).status.success());
    let render = |name: &str, more: &[&str]| {
        let first = ["fluid", "render", "frames/0000.ply", "frames/0003.ply", "--spacing", "0.05", "--size", "96x64"];
        let done = relievo(folder.path(), &[&first[..], &["-o", name], more].concat());
        assert!(done.status.success(), "{done:?}");
        let lines = text(&done.stdout);
        assert!(lines.lines().count() == 2 && lines.contains("frames/0003.ply: 360 particles, "), "{lines}");
        assert!(more.contains(&"--particles") == lines.contains("% blind"), "{lines}");
        relievo_render::read_png(&folder.path().join(name), 1 << 24).unwrap()
    };
    // The mean distance of linear colours.
    let apart = |a: &relievo_render::Image, b: &relievo_render::Image| {
        let distances: Vec<f32> = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).collect();
        distances.iter().sum::<f32>() / distances.len() as f32
    };
    for material in ["opaque", "water"] {
        let direct = render("direct.png", &["--material", material]);
        assert_eq!((direct.width(), direct.height()), (192, 64));
        let threads = render("threads.png", &["--material", material, "--threads", "1"]);
        assert_eq!(direct.data(), threads.data());
        let mesh = render("mesh.png", &["--material", material, "--mesh", "0.25"]);
        let blind = render("blind.png", &["--material", material, "--particles", "blind"]);
        let bare = render("bare.png", &["--material", material, "--particles", "surface"]);
        let [mesh, blind, bare] = [mesh, blind, bare].map(|other| apart(&direct, &other));
        assert!(mesh < 0.02 && blind < 1e-3, "{material} {mesh} {blind}");
        // What was left out is seen from outside through water alone.
        assert!(material == "opaque" || bare > 5.0 * blind.max(1e-3), "{bare}");
    }
    let blurred = render("blurred.png", &["--shutter", "0.05"]);
    assert!(apart(&blurred, &render("still.png", &[])) > 1e-3);
    let refused = |arguments: &[&str], why: &str| {
        let done = relievo(folder.path(), &[&["fluid", "render"], arguments].concat());
        assert!(!done.status.success() && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    let good = ["frames/0000.ply", "--spacing", "0.05", "-o"];
    refused(&[&good[..], &["a.bmp"]].concat(), ".png");
    refused(&[&good[..], &["a.png", "--eye", "1,2"]].concat(), "X,Y,Z");
    refused(&[&good[..], &["a.png", "--fov", "200"]].concat(), "field of view");
    refused(&[&good[..], &["a.png", "--shutter=-1"]].concat(), "shutter");
    refused(&[&good[..], &["a.png", "--mesh", "9"]].concat(), "cell size");
    refused(&["frames/0000.ply", "--spacing", "0", "-o", "a.png"], "support radius");
}

const SCENE: &str = "version = 1\n[meshes.water]\nsequence = \"frames/%04d.ply\"\ncount = 4\n\
    [meshes.floor]\nshape = \"plane\"\nsize = [4, 4, 1]\n[objects.floor]\nmesh = \"floor\"\n\
    [objects.water]\nmesh = \"water\"\ndielectric = { index = 1.333 }\n\
    [camera]\nposition = [2, -2, 1.5]\ntarget = [0.5, 0.15, 0.2]\n\
    [output]\nframes = 1\nwidth = 64\nheight = 48\n[objects.water.fluid]\nspacing = 0.05\n";

#[test]
fn fluids_stand_in_scenes_beside_other_objects() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames"]).status.success());
    let run = |name: &str, scene: &str| {
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let done = relievo(folder.path(), &["run", "scene.toml", "--out", name]);
        assert!(done.status.success(), "{done:?}");
        let picture = folder.path().join(name).join("beauty-000000.png");
        relievo_render::read_png(&picture, 1 << 24).unwrap()
    };
    let apart = |a: &relievo_render::Image, b: &relievo_render::Image| {
        let distances = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs());
        distances.sum::<f32>() / a.data().len() as f32
    };
    let direct = run("direct", SCENE);
    let mesh = run("mesh", &format!("{SCENE}cell = 0.25\n"));
    let opaque = run("opaque", &SCENE.replace("dielectric = { index = 1.333 }\n", ""));
    let none = run("none", &SCENE.replace("mesh = \"water\"", "mesh = \"water\"\nvisible = false"));
    assert!(apart(&direct, &mesh) < 1e-3, "{}", apart(&direct, &mesh));
    for (a, b) in [(&direct, &opaque), (&direct, &none), (&opaque, &none)] {
        assert!(apart(a, b) > 2e-3, "{}", apart(a, b));
    }
}
