//! `relievo fluid` as a user sees it.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use relievo_core::simd::Level;

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
    let done = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"]);
    assert!(
        done.status.success() && text(&done.stdout).starts_with("360 particles 0.05 m apart, 3 frames"),
        "{done:?}"
    );
    let frame = |number: u32| std::fs::read(folder.path().join(format!("frames/{number:04}.rlvfluid"))).unwrap();
    assert!(frame(3).starts_with(b"RLVFLUID"));
    // As many threads as there are, or one.
    let again =
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "again", "--threads", "1", "--format", "cache"]);
    assert!(again.status.success(), "{again:?}");
    assert!((0..4).all(
        |number| frame(number) == std::fs::read(folder.path().join(format!("again/{number:04}.rlvfluid"))).unwrap()
    ));
    let mesh = |more: &[&str]| {
        relievo(folder.path(), &[&["fluid", "mesh", "frames/0003.rlvfluid", "-o", "surface.ply"], more].concat())
    };
    assert!(mesh(&[]).status.success());
    let header = std::fs::read(folder.path().join("surface.ply")).unwrap();
    assert!(String::from_utf8_lossy(&header).contains("property float vx"));
    let smoothed = mesh(&["--smooth", "5"]);
    assert!(smoothed.status.success(), "{smoothed:?}");
    assert_ne!(header, std::fs::read(folder.path().join("surface.ply")).unwrap());
    let info = relievo(folder.path(), &["info", "--json", "surface.ply"]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert!(found["faces"].as_u64().unwrap() > 1000, "{found}");
    for function in ["blobs", "density", "anisotropic"] {
        let done = mesh(&["--function", function, "--cell", "1"]);
        assert!(done.status.success() && text(&done.stdout).starts_with("360 particles, "), "{done:?}");
    }
}

#[test]
fn a_dam_is_simulated_on_a_device_as_on_the_processor() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    let simulate = |arguments: &[&str]| {
        relievo(folder.path(), &[&["fluid", "sim", "dam.toml", "--format", "cache", "-o"], arguments].concat())
    };
    let missing = simulate(&["none", "--device", "gpu", "--adapter", "no such device"]);
    assert!(missing.status.code() == Some(1) && text(&missing.stderr).contains("no such device"), "{missing:?}");
    if relievo_gpu::adapters().is_empty() {
        return;
    }
    let (on_device, on_processor) = (simulate(&["gpu", "--device", "gpu"]), simulate(&["cpu"]));
    assert!(on_device.status.success() && on_processor.status.success(), "{on_device:?}");
    let energy = |name: &str| -> f64 {
        let rows = std::fs::read_to_string(folder.path().join(name).join("statistics.csv")).unwrap();
        let column = rows.lines().next().unwrap().split(',').position(|name| name.contains("energy")).unwrap();
        rows.lines().last().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    assert!((energy("gpu") / energy("cpu") - 1.0).abs() < 0.02, "{} {}", energy("gpu"), energy("cpu"));
    // Frames of the processor are no frames of the device.
    let other = simulate(&["cpu", "--device", "gpu"]);
    assert!(other.status.code() == Some(1) && text(&other.stderr).contains("--restart"), "{other:?}");
    std::fs::write(folder.path().join("dam.toml"), DAM.replace("[fluid]", "[fluid]\nsolver = \"dfsph\"")).unwrap();
    let refused = simulate(&["gpu", "--device", "gpu", "--restart"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--device cpu"), "{refused:?}");
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
    refused(&DAM.replace("[fluid]", "[fluid]\nsolver = \"none\""), "dfsph");
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
        relievo(folder.path(), &["fluid", "sim", "mill.toml", "-o", "frames", "--restart"])
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
        let first = ["fluid", "render", "frames/0000.rlvfluid", "frames/0003.rlvfluid", "--size", "96x64"];
        let done = relievo(folder.path(), &[&first[..], &["-o", name], more].concat());
        assert!(done.status.success(), "{done:?}");
        let lines = text(&done.stdout);
        assert!(lines.lines().count() == 2 && lines.contains("frames/0003.rlvfluid: 360 particles, "), "{lines}");
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
    let good = ["frames/0000.rlvfluid", "-o"];
    refused(&[&good[..], &["a.bmp"]].concat(), ".png");
    refused(&[&good[..], &["a.png", "--eye", "1,2"]].concat(), "X,Y,Z");
    refused(&[&good[..], &["a.png", "--fov", "200"]].concat(), "field of view");
    refused(&[&good[..], &["a.png", "--shutter=-1"]].concat(), "shutter");
    refused(&[&good[..], &["a.png", "--mesh", "9"]].concat(), "cell size");
    refused(&[&good[..], &["a.png", "--spacing", "0"]].concat(), "support radius");
}

#[test]
fn particles_that_the_surface_does_not_need_are_left_out_of_any_file() {
    let folder = tempfile::tempdir().unwrap();
    let block = "frames = 0\n[fluid]\nspacing = 0.05\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.8, 0.8, 0.8]\n";
    std::fs::write(folder.path().join("block.toml"), block).unwrap();
    let done = |arguments: &[&str]| {
        let done = relievo(folder.path(), &[&["fluid"], arguments].concat());
        assert!(done.status.success(), "{done:?}");
        text(&done.stdout)
    };
    done(&["sim", "block.toml", "-o", "frames"]);
    let frame = "frames/0000.rlvfluid";
    let told = done(&["convert", frame, "kept.vtk", "--particles", "blind"]);
    // 16 by 16 by 16 without what is 5 or more layers within.
    let number = |text: &str, after: &str| -> f64 {
        let rest = text.split_once(after).unwrap_or_else(|| panic!("{text}")).1;
        rest.split(' ').next().unwrap().parse().unwrap()
    };
    let kept = number(&told, "4096 particles, ");
    assert!((60.0..99.0).contains(&kept) && number(&told, " s, ") > 0.5 * (100.0 - kept), "{told}");
    assert!(told.contains("1 files, 4096 particles"), "{told}");
    let info = done(&["info", "kept.vtk"]);
    assert!(info.contains("blind (1)") && info.contains("velocity (3)"), "{info}");
    // The mesh of what was kept is that of all, and has no inner side.
    let mesh = |from: &str, to: &str, more: &[&str]| {
        let all = [&["mesh", from, "-o", to], more].concat();
        (done(&all), std::fs::read(folder.path().join(to)).unwrap())
    };
    let (_, whole) = mesh(frame, "whole.ply", &[]);
    let (told, left) = mesh(frame, "left.ply", &["--particles", "blind"]);
    assert!(number(&told, "4096 particles, ") == kept && left == whole, "{told}");
    let (_, again) = mesh("kept.vtk", "again.ply", &[]);
    assert!(again == whole);
    let (_, bare) = mesh(frame, "bare.ply", &["--particles", "surface"]);
    assert!(bare.len() > whole.len());
    let refused = relievo(folder.path(), &["fluid", "mesh", "kept.vtk", "-o", "kept.vdb"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("blind"), "{refused:?}");
    let sizes = ["--size", "32x24", "-o", "a.png"];
    let told = done(&[&["render", frame, "--particles", "blind", "--compare"], &sizes[..]].concat());
    assert!(number(&told, "4096 particles, ") == kept && told.contains(" with all\n"), "{told}");
    // What is not there cannot be compared with.
    let told = done(&[&["render", "kept.vtk", "--particles", "blind", "--compare"], &sizes[..]].concat());
    assert!(told.contains("100.0 % kept") && !told.contains("with all"), "{told}");
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
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "ply"]).status.success());
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

/// The files in a folder by name, but not the times in the statistics.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        if path.ends_with("statistics.csv") {
            let lines = text(&bytes);
            bytes =
                lines.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect::<String>().into();
        }
        (path.file_name().unwrap().to_str().unwrap().to_owned(), bytes)
    };
    std::fs::read_dir(folder).unwrap().map(read).collect()
}

#[test]
fn a_killed_simulation_goes_on_and_ends_to_the_bit_as_one_that_was_not() {
    let folder = tempfile::tempdir().unwrap();
    let more = "[[collider]]\nbox = { low = [0.5, 0.1, 0], high = [0.6, 0.2, 0.2] }\n\
        keys = [{ time = 0 }, { time = 0.24, move = [-0.1, 0, 0] }]\n\
        [[emitter]]\ndisc = { middle = [0.8, 0.15, 0.4], normal = [0, 0, -1], radius = 0.08 }\nspeed = 2\n\
        color = [1, 0.5, 0.25]\n[[force]]\nkind = \"turbulence\"\nstrength = 0.5\nscale = 0.3\nrate = 2\n";
    for (format, solver) in [("cache", "pcisph"), ("bgeo", "pcisph"), ("vtk", "dfsph")] {
        let solved =
            DAM.replace("frames = 3", "frames = 12").replace("[fluid]", &format!("[fluid]\nsolver = \"{solver}\""));
        std::fs::write(folder.path().join("dam.toml"), solved + more).unwrap();
        let options = ["fluid", "sim", "dam.toml", "--format", format, "--sub-frames", "2", "-o"];
        let whole = format!("whole-{format}");
        let done = relievo(folder.path(), &[&options[..], &[&whole]].concat());
        assert!(done.status.success(), "{done:?}");
        let expected = files(&folder.path().join(&whole));
        assert_eq!(expected.len(), if format == "cache" { 26 } else { 27 }, "{:?}", expected.keys());
        let killed = folder.path().join(format);
        // Killed whenever some more files are there, three times.
        for count in [3, 9, 17] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_relievo"));
            command.args(options).arg(format).current_dir(folder.path()).stderr(std::process::Stdio::null());
            let mut running = command.stdout(std::process::Stdio::null()).spawn().unwrap();
            let there = || std::fs::read_dir(&killed).map_or(0, Iterator::count);
            while there() < count && running.try_wait().unwrap().is_none() {
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            let _ = running.kill();
            running.wait().unwrap();
        }
        let last = relievo(folder.path(), &[&options[..], &[format]].concat());
        assert!(last.status.success() && text(&last.stderr).contains("goes on from"), "{last:?}");
        assert_eq!(last.stdout, done.stdout);
        let mut found = files(&killed);
        // What a killed program was writing has another name.
        found.retain(|name, _| !name.starts_with(".relievo-"));
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
        assert!(
            found == expected,
            "{:?}",
            found.keys().filter(|name| found[*name] != expected[*name]).collect::<Vec<_>>()
        );
    }
}

#[test]
fn a_run_goes_on_from_the_last_frame_that_is_whole_and_only_from_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let write = |description: &str| std::fs::write(folder.path().join("dam.toml"), description).unwrap();
    let sim = |more: &[&str]| {
        relievo(folder.path(), &[&["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"], more].concat())
    };
    write(DAM);
    assert!(sim(&[]).status.success());
    let expected = files(&folder.path().join("frames"));
    let last = folder.path().join("frames/0003.rlvfluid");
    std::fs::write(&last, &expected["0003.rlvfluid"][..1000]).unwrap();
    let done = sim(&[]);
    let told = text(&done.stderr);
    assert!(done.status.success() && told.contains("damaged") && told.contains("frames/0002.rlvfluid"), "{done:?}");
    assert!(files(&folder.path().join("frames")) == expected);
    // More frames of the same are a run that goes on.
    write(&DAM.replace("frames = 3", "# one more\nframes = 4"));
    assert!(sim(&[]).status.success());
    let more = files(&folder.path().join("frames"));
    assert!(more.len() == expected.len() + 1 && more["0003.rlvfluid"] == expected["0003.rlvfluid"]);
    let refused = |done: Output, why: &str| {
        assert!(done.status.code() == Some(1) && text(&done.stderr).contains(why), "{why}: {done:?}");
    };
    refused(sim(&["--sub-frames", "2"]), "another description");
    write(&DAM.replace("fps = 50", "fps = 60"));
    refused(sim(&[]), "--restart");
    write(DAM);
    assert!(sim(&["--restart"]).status.success());
    assert!(files(&folder.path().join("frames")) == expected);
    let level = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"])
        .env("RELIEVO_SIMD", if Level::detect().unwrap() == Level::Baseline { "avx2" } else { "baseline" })
        .current_dir(folder.path())
        .output()
        .unwrap();
    refused(level, "RELIEVO_SIMD");
    let converted = relievo(folder.path(), &["fluid", "convert", "frames/0001.rlvfluid", "frames/0009.rlvfluid"]);
    assert!(converted.status.success(), "{converted:?}");
    refused(sim(&[]), "no simulation can go on from");
}

#[test]
fn frames_are_told_of_and_converted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"]).status.success()
    );
    let info = |path: &str| -> serde_json::Value {
        let done = relievo(folder.path(), &["fluid", "info", "--json", path]);
        serde_json::from_slice(&done.stdout).unwrap_or_else(|_| panic!("{done:?}"))
    };
    let cached = info("frames/0002.rlvfluid");
    assert_eq!((cached["particles"].as_u64(), cached["goes_on"].as_bool()), (Some(360), Some(true)));
    assert!((cached["seconds"].as_f64().unwrap() - 0.04).abs() < 1e-6, "{cached}");
    assert!(cached["fastest"].as_f64().unwrap() > 0.1 && cached["bounds"][1][0].as_f64().unwrap() > 0.27, "{cached}");
    let all = info("frames");
    assert_eq!((all["frames"].as_u64(), all["last"]["frame"].as_str()), (Some(4), Some("0003")));
    for (format, direct) in [("bgeo", "a"), ("vtk", "b"), ("ply", "c")] {
        let done = relievo(folder.path(), &["fluid", "convert", "frames", format, "--format", format]);
        assert!(done.status.success() && text(&done.stdout) == "4 files, 1440 particles\n", "{done:?}");
        let found = info(&format!("{format}/0002.{format}"));
        for key in ["particles", "bounds", "fastest", "numbered", "channels"] {
            assert_eq!(found[key], cached[key], "{format}: {key}");
        }
        if format != "ply" {
            assert!((found["seconds"].as_f64().unwrap() - 0.04).abs() < 1e-6, "{found}");
            assert_eq!(found["spacing"], cached["spacing"]);
        }
        // The frames that a simulation writes in that format are the same.
        let done = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", direct, "--format", format]);
        assert!(done.status.success(), "{done:?}");
        let name = format!("0003.{format}");
        assert!(files(&folder.path().join(direct))[&name] == files(&folder.path().join(format))[&name]);
    }
    let other = relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "a", "--format", "vtk"]);
    assert!(other.status.code() == Some(1) && text(&other.stderr).contains("another format"), "{other:?}");
    let text_form = relievo(folder.path(), &["fluid", "info", "frames"]);
    assert!(text(&text_form.stdout).contains("velocity (3)"), "{text_form:?}");
    let empty = relievo(folder.path(), &["fluid", "info", "."]);
    assert!(empty.status.code() == Some(1) && text(&empty.stderr).contains("no frames"), "{empty:?}");
}

#[test]
fn frames_of_a_folder_are_meshed_and_a_fluid_of_nothing_is_an_empty_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let none = DAM.split("[[block]]").next().unwrap();
    std::fs::write(folder.path().join("none.toml"), none.replace("frames = 3", "frames = 1")).unwrap();
    assert!(
        relievo(folder.path(), &["fluid", "sim", "none.toml", "-o", "frames", "--format", "cache"]).status.success()
    );
    let done = relievo(folder.path(), &["fluid", "mesh", "frames", "-o", "meshes"]);
    assert!(done.status.success() && text(&done.stdout) == "2 frames, 0 particles, 0 triangles\n", "{done:?}");
    assert!(text(&std::fs::read(folder.path().join("meshes/0001.ply")).unwrap()).contains("element vertex 0"));
    let refused = relievo(folder.path(), &["fluid", "mesh", "frames/0000.rlvfluid", "-o", "surface.glb"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("no surface"), "{refused:?}");
    let particles = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n0 0 0\n";
    std::fs::write(folder.path().join("one.ply"), particles).unwrap();
    let unknown = relievo(folder.path(), &["fluid", "mesh", "one.ply", "-o", "surface.ply"]);
    assert!(unknown.status.code() == Some(1) && text(&unknown.stderr).contains("--spacing"), "{unknown:?}");
}

#[test]
fn level_sets_are_written_as_openvdb_has_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM.replace("frames = 3", "frames = 1")).unwrap();
    assert!(
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"]).status.success()
    );
    let mesh = |more: &[&str]| {
        let all = [&["fluid", "mesh", "frames/0001.rlvfluid", "-o", "surface.vdb"], more].concat();
        relievo(folder.path(), &all)
    };
    let written = || std::fs::read(folder.path().join("surface.vdb")).unwrap();
    assert!(mesh(&[]).status.success());
    let first = written();
    assert!(first.starts_with(b" BDV\0\0\0\0\xe0\0\0\0") && first.windows(9).any(|it| it == b"level set"));
    assert!(mesh(&["--threads", "1"]).status.success());
    assert!(first == written());
    let refused = mesh(&["--smooth", "3"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--smooth"), "{refused:?}");
}

#[test]
fn statistics_are_plotted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(
        relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "cache"]).status.success()
    );
    let plot = |from: &str, to: &str| relievo(folder.path(), &["plot", from, "-o", to]);
    for (from, to) in [("frames", "a.png"), ("frames/statistics.csv", "a.svg")] {
        let done = plot(from, to);
        assert!(done.status.success() && text(&done.stdout) == "4 frames\n", "{done:?}");
    }
    assert!(std::fs::read(folder.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    let drawing = text(&std::fs::read(folder.path().join("a.svg")).unwrap());
    assert!(
        ["Too dense (%)", "Kinetic energy (J)", "corrections", "Time a frame (s)"]
            .iter()
            .all(|it| drawing.contains(it))
    );
    let refused = plot("frames", "a.gif");
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains(".png or .svg"), "{refused:?}");
    let refused = plot("dam.toml", "a.png");
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("statistics"), "{refused:?}");
}

#[test]
fn fluids_are_blobs_and_grids_in_scenes_for_pov_ray() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("dam.toml"), DAM).unwrap();
    assert!(relievo(folder.path(), &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "ply"]).status.success());
    let export = |form: &str| {
        let scene = format!("{SCENE}povray = \"{form}\"\n");
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let done = relievo(folder.path(), &["export", "pov", "scene.toml", "--out", form]);
        assert!(done.status.success(), "{done:?}");
        std::fs::read_to_string(folder.path().join(form).join("scene-000000.pov")).unwrap()
    };
    let blobs = export("blobs");
    assert_eq!((blobs.matches("blob {").count(), blobs.matches("\n  sphere {").count()), (1, 360));
    assert!(export("mesh").matches("mesh2 {").count() == 2 && blobs.matches("mesh2 {").count() == 1);
    let grid = export("df3");
    assert!(grid.contains("isosurface {") && grid.contains("density_file df3 \"fluid-water-000000.df3\""), "{grid}");
    let file = std::fs::read(folder.path().join("df3/fluid-water-000000.df3")).unwrap();
    let (sizes, values) = file.split_at(6);
    let sizes: Vec<usize> = sizes.chunks(2).map(|size| usize::from(u16::from_be_bytes([size[0], size[1]]))).collect();
    assert_eq!(values.len(), 2 * sizes.iter().product::<usize>());
    // Cells of half a spacing: as many within as fill the block of 0.3 by 0.3 by 0.5 m, whose edges are round.
    let within = values.chunks(2).filter(|value| value[0] >= 128).count() as f64 * 0.025f64.powi(3);
    assert!((0.7..1.05).contains(&(within / 0.045)), "{within}");
}
