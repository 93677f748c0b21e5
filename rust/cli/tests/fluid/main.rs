//! `relievo fluid` as a user sees it.

#[path = "../program/mod.rs"]
mod program;

mod displaced;
mod entries;
mod pictures;
#[cfg(feature = "server")]
mod ranks;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use relievo_core::simd::Level;

use program::{relievo, text};

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
    let energy = |name: &str| -> f64 {
        let rows = std::fs::read_to_string(folder.path().join(name).join("statistics.csv")).unwrap();
        let column = rows.lines().next().unwrap().split(',').position(|name| name.contains("energy")).unwrap();
        rows.lines().last().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    let board = "[[collider]]\nbox = { low = [0.35, 0, 0.1], high = [0.45, 0.3, 0.5] }\nfriction = 0.2\n\
        keys = [{ time = 0 }, { time = 0.1, move = [-0.04, 0, 0] }]\n\
        [[force]]\nkind = \"vortex\"\nplace = [0.3, 0.1, 0.3]\naxis = [0, 1, 0]\nstrength = 9\nradius = 0.2\n";
    for more in [board, ""] {
        std::fs::write(folder.path().join("dam.toml"), DAM.to_owned() + more).unwrap();
        let on_device = simulate(&["gpu", "--device", "gpu", "--restart"]);
        let on_processor = simulate(&["cpu", "--restart"]);
        assert!(on_device.status.success() && on_processor.status.success(), "{on_device:?} {on_processor:?}");
        assert!((energy("gpu") / energy("cpu") - 1.0).abs() < 0.02, "{} {}", energy("gpu"), energy("cpu"));
    }
    // Frames of the processor are no frames of the device.
    let other = simulate(&["cpu", "--device", "gpu"]);
    assert!(other.status.code() == Some(1) && text(&other.stderr).contains("--restart"), "{other:?}");
    std::fs::write(folder.path().join("dam.toml"), DAM.replace("[fluid]", "[fluid]\nsolver = \"dfsph\"")).unwrap();
    let refused = simulate(&["gpu", "--device", "gpu", "--restart"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--device cpu"), "{refused:?}");
    let sink = DAM.to_owned() + "[[sink]]\noutside = { low = [-1, -1, -1], high = [2, 1, 1] }\n";
    std::fs::write(folder.path().join("dam.toml"), sink).unwrap();
    let refused = simulate(&["gpu", "--device", "gpu", "--restart"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("emitters and sinks"), "{refused:?}");
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
    refused(&DAM.replace("spacing = 0.05", "spacng = 0.05"), "perhaps `spacing` is meant");
    refused(&DAM.replace("[[block]]", "[[blok]]"), "perhaps `block` is meant");
    refused(&DAM.replace("spacing = 0.05", "spacing = \"wide\""), "expected f32");
    refused(&DAM.replace("fps = 50", "fps = 0"), "use more than 0.001");
    refused(&DAM.replace("[fluid]", "[fluid]\ntension = -0.072"), "-0.072 is no tension");
    refused(&DAM.replace("high = [1, 0.3, 0.6]", "high = [1, 0.3, nan]"), "basin");
    refused(&DAM.replace("high = [0.3, 0.3, 0.5]", "high = [3e9, 0.3, 0.5]"), "block 0");
    refused(&DAM.replace("[fluid]", "[fluid]\nkernels = \"none\""), "mueller");
    refused(&DAM.replace("[fluid]", "[fluid]\nsolver = \"none\""), "dfsph");
    let lost = relievo(folder.path(), &["fluid", "mesh", "none.ply", "-o", "surface.ply", "--spacing", "0.05"]);
    assert!(lost.status.code() == Some(1) && text(&lost.stderr).contains("none.ply"), "{lost:?}");
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
    // What a description begins as, and files of particles, for users who ask about any file.
    let begun = info("dam.toml");
    assert_eq!((begun["particles"].as_u64(), begun["frames"].as_u64()), (Some(360), Some(3)));
    let any = relievo(folder.path(), &["info", "--json", "frames/0002.rlvfluid"]);
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&any.stdout).unwrap(), cached);
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
        } else {
            // PLY has no place for it: it is estimated, or given.
            let mesh = relievo(folder.path(), &["fluid", "mesh", "ply/0000.ply", "-o", "estimated.ply"]);
            let note = text(&mesh.stderr);
            assert!(mesh.status.success() && note.contains(" m is the median distance"), "{mesh:?}");
            let given = ["fluid", "convert", "ply/0002.ply", "given.rlvfluid", "--spacing", "0.0625"];
            assert!(relievo(folder.path(), &given).status.success());
            assert_eq!(info("given.rlvfluid")["spacing"], 0.0625);
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
        text(&relievo(folder.path(), &["fluid", "sim", "none.toml", "-o", "frames", "--format", "cache"]).stderr)
            .contains("there is no fluid")
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
