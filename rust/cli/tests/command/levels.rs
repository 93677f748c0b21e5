//! `relievo progressive`.

use crate::program::build_bowl;
use crate::simplification::{bowl, corners_of_map, map};
use crate::{relievo, text};

#[test]
fn a_progressive_mesh_keeps_texture_coordinates_at_every_level() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.obj"), map()).unwrap();
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    let built = run(&["build", "map.obj", "-o", "map.rlvpm", "--faces", "50", "--weight", "uv=0.05"]);
    assert!(built.status.success() && built.stderr.is_empty(), "{built:?}");
    assert!(text(&run(&["show", "map.rlvpm"]).stdout).contains("attributes: uv"));
    // `relievo info` says what is in the file, as text and as JSON.
    let info = |more: &[&str]| text(&relievo(folder.path(), &[&["info", "map.rlvpm"], more].concat()).stdout);
    let shown = info(&[]);
    assert!(
        shown.starts_with("map.rlvpm\n  attributes: uv\n  finest: ") && shown.contains(" 800 triangles\n"),
        "{shown}"
    );
    let value: serde_json::Value = serde_json::from_str(&info(&["--json"])).unwrap();
    assert_eq!((&value["attributes"][0], &value["finest"]["triangles"]), (&"uv".into(), &800.into()));
    std::fs::write(folder.path().join("none.rlvpm"), "").unwrap();
    let refused = relievo(folder.path(), &["info", "none.rlvpm"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("no progressive mesh"), "{refused:?}");
    let export = |faces: &str, output: &str| run(&["export", "map.rlvpm", "--faces", faces, "-o", output]);
    for (faces, tolerances) in [("800", [1e-6; 2]), ("200", [0.01, 0.02]), ("60", [0.03, 0.05])] {
        assert!(export(faces, "level.obj").status.success());
        let level = std::fs::read_to_string(folder.path().join("level.obj")).unwrap();
        let most = 3 * faces.parse::<usize>().unwrap();
        let corners = corners_of_map(&level, tolerances);
        assert!((most - 3..=most).contains(&corners), "{corners}");
    }
    for output in ["level.ply", "level.glb"] {
        assert!(export("200", output).status.success());
        let made = relievo_meshio::read(&relievo_core::Context::serial(), &folder.path().join(output)).unwrap();
        assert!(made.attribute("uv").is_some(), "{output}");
    }
    let edits = "[[edit]]\nfaces = 200\n[[edit.handle]]\ncenter = [0, 0, 0]\nradius = 0.8\ntranslation = [0, 0, 2]\n";
    std::fs::write(folder.path().join("edits.toml"), edits).unwrap();
    assert!(run(&["edit", "map.rlvpm", "--script", "edits.toml", "-o", "edited.rlvpm"]).status.success());
    assert!(run(&["export", "edited.rlvpm", "-o", "level.obj"]).status.success());
    let level = std::fs::read_to_string(folder.path().join("level.obj")).unwrap();
    assert_eq!(level.lines().filter(|line| line.starts_with("vt ")).count(), 2 * 21 * 11);
    assert!(run(&["build", "map.obj", "-o", "map.rlvpm", "--without", "uv"]).status.success());
    assert!(!text(&run(&["show", "map.rlvpm"]).stdout).contains("attributes"));
}

#[test]
fn edits_of_a_progressive_mesh_go_on_where_a_command_ended() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    build_bowl(folder.path(), &bowl());
    let strokes = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.3\n\
                   radius = 0.5\nfalloff = \"smooth\"\npoints = [{ position = [0, 0, 0] }]\n";
    std::fs::write(path("strokes.toml"), strokes).unwrap();
    let edits = "[[edit]]\nfaces = 200\n[[edit.handle]]\ncenter = [0, 0, 0]\nradius = 0.8\ntranslation = [0, 0, 2]\n\
                 [[edit]]\nfaces = 400\nstrokes = \"strokes.toml\"\n\
                 [[edit]]\n[[edit.handle]]\ncenter = [0.5, 0, 0.25]\nradius = 0.4\ntranslation = [0, 1, 0]\n";
    std::fs::write(path("edits.toml"), edits).unwrap();
    let edit = |output: &str| run(&["edit", "bowl.rlvpm", "--script", "edits.toml", "-o", output]);
    let points = |file: &str| -> Vec<f64> {
        assert!(run(&["export", file, "-o", "level.obj"]).status.success());
        let list = std::fs::read_to_string(path("level.obj")).unwrap();
        let lines = list.lines().filter_map(|line| line.strip_prefix("v "));
        lines.flat_map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<_>>()).collect()
    };
    assert!(edit("whole.rlvpm").status.success() && !path("whole.rlvpm.journal").exists());
    let whole = points("whole.rlvpm");
    // All are made, and cannot be written.
    std::fs::create_dir(path("out.rlvpm")).unwrap();
    assert_eq!(edit("out.rlvpm").status.code(), Some(1));
    let journal = std::fs::read(path("out.rlvpm.journal")).unwrap();
    std::fs::remove_dir(path("out.rlvpm")).unwrap();
    let mut taken = Vec::new();
    for kept in (0..=8).map(|part| journal.len() * part / 8).filter(|kept| *kept > 100) {
        std::fs::write(path("out.rlvpm.journal"), &journal[..kept]).unwrap();
        let done = edit("out.rlvpm");
        assert!(done.status.success() && !path("out.rlvpm.journal").exists(), "{done:?}");
        taken.push(text(&done.stdout).matches("from the journal").count());
        // Last bits follow from the levels that the mesh went through.
        let made = points("out.rlvpm");
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-5;
        assert!(made.len() == whole.len() && made.iter().zip(&whole).all(near), "{kept} of {}", journal.len());
    }
    assert!(taken.is_sorted() && taken.contains(&1) && taken.last() == Some(&3), "{taken:?}");
    // A journal of other edits, or of more, is not built upon.
    std::fs::write(path("out.rlvpm.journal"), &journal).unwrap();
    let fewer = &edits[..edits.rfind("[[edit]]").unwrap()];
    for other in [edits.replace("radius = 0.8", "radius = 0.7").as_str(), fewer] {
        std::fs::write(path("edits.toml"), other).unwrap();
        let refused = edit("out.rlvpm");
        assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("has other edits"), "{refused:?}");
        assert!(std::fs::read(path("out.rlvpm.journal")).unwrap() == journal);
    }
}

#[test]
fn a_progressive_mesh_is_built_shown_and_taken_at_any_level() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    let built = run(&["build", "bowl.obj", "-o", "bowl.rlvpm", "--faces", "50"]);
    let told = text(&built.stdout);
    assert!(["800 triangles, 49 in the base", "800 triangles, 50 in the base"].contains(&told.trim()), "{built:?}");
    let shown = run(&["show", "bowl.rlvpm", "--error", "0.01"]);
    assert!(text(&shown.stdout).contains("finest: 441 vertices, 800 triangles"), "{shown:?}");
    let faces = || {
        let info = relievo(folder.path(), &["info", "--json", "level.ply"]);
        let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
        found["faces"].as_u64().unwrap()
    };
    let export = |level: &[&str]| run(&[&["export", "bowl.rlvpm", "-o", "level.ply"], level].concat());
    assert!(export(&[]).status.success() && faces() == 800);
    assert!(export(&["--ratio", "0.5"]).status.success() && (399..=400).contains(&faces()), "{}", faces());
    assert!(export(&["--faces", "100", "--threads", "1"]).status.success() && (99..=100).contains(&faces()));
    assert!(export(&["--error", "0.02"]).status.success() && faces() < 400, "{}", faces());
    assert_eq!(export(&["--error", "1", "--faces", "3"]).status.code(), Some(2));
    let refused = export(&["--error=-1"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("use 0 or more"), "{refused:?}");
    // A device makes the level and draws it.
    let show = |device: &str| {
        let picture = format!("{device}.png");
        run(&["show", "bowl.rlvpm", "--faces", "300", "--size", "96x72", "--device", device, "--picture", &picture])
    };
    assert!(show("cpu").status.success());
    if !relievo_gpu::adapters().is_empty() {
        let drawn = show("gpu");
        assert!(drawn.status.success(), "{drawn:?}");
        let pictures = ["cpu.png", "gpu.png"].map(|name| {
            let picture = relievo_render::read_png(&folder.path().join(name), 1 << 20).unwrap();
            (0..72).flat_map(|y| (0..96).map(move |x| (x, y))).map(|(x, y)| picture.color(x, y)).collect::<Vec<_>>()
        });
        // At outlines colours are taken elsewhere in the pixel.
        let difference = |[a, b]: [&[f32; 3]; 2]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let differences = pictures[0].iter().zip(&pictures[1]).map(|(cast, drawn)| difference([cast, drawn]));
        let covered = pictures[0].iter().filter(|color| **color != pictures[0][0]).count();
        let mean = differences.sum::<f32>() / covered as f32;
        assert!(covered > 1000 && mean < 0.01, "{mean} of {covered}");
    }
    let edits = "[[edit]]\nfaces = 200\n[[edit.handle]]\ncenter = [0, 0, 0]\nradius = 0.8\ntranslation = [0, 0, 2]\n";
    std::fs::write(folder.path().join("edits.toml"), edits).unwrap();
    // The mesh, the edit with its ball, and what becomes of it.
    let show =
        |picture: &str| run(&["show", "bowl.rlvpm", "--script", "edits.toml", "--picture", picture, "--size", "48x32"]);
    assert!(show("edits.png").status.success());
    let picture = relievo_render::read_png(&folder.path().join("edits.png"), 1 << 20).unwrap();
    assert_eq!((picture.width(), picture.height()), (3 * 48, 32));
    let has_purple = |column: u32| {
        let pixels = (0..32).flat_map(|y| (48 * column..48 * column + 48).map(move |x| (x, y)));
        pixels.map(|(x, y)| picture.color(x, y)).any(|[r, g, b]| b > 1.5 * g && r > g)
    };
    assert_eq!([0, 1, 2].map(has_purple), [false, true, false]);
    let refused = show("edits.jpg");
    assert!(
        refused.status.code() == Some(1) && text(&refused.stderr).contains("use the extension .png"),
        "{refused:?}"
    );
    let edited = run(&["edit", "bowl.rlvpm", "--script", "edits.toml", "-o", "edited.rlvpm"]);
    assert!(edited.status.success() && text(&edited.stdout).starts_with("edit 1: "), "{edited:?}");
    assert!(run(&["export", "edited.rlvpm", "-o", "level.ply"]).status.success());
    let info = relievo(folder.path(), &["info", "--json", "level.ply"]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert!(found["faces"] == 800 && found["bounds"][1][2].as_f64().unwrap() > 1.2, "{found}");
    // What was flat is a peak now; built anew its order is that.
    assert!(text(&edited.stderr).contains("--rebuild puts them in order"), "{edited:?}");
    let misplaced = |file: &str| {
        let told = text(&run(&["check", file]).stdout).to_owned();
        told.split(' ').nth(1).unwrap().parse::<usize>().unwrap()
    };
    assert!(misplaced("bowl.rlvpm") == 0 && misplaced("edited.rlvpm") > 10);
    let edited = run(&["edit", "bowl.rlvpm", "--script", "edits.toml", "--rebuild", "-o", "rebuilt.rlvpm"]);
    assert!(edited.status.success() && edited.stderr.is_empty() && misplaced("rebuilt.rlvpm") == 0, "{edited:?}");
    // A list over time, at the finest level: half of the way at half of the time.
    let keys = "[[edit]]\n[[edit.handle]]\ncenter = [0, 0, 0]\nradius = 0.8\nfalloff = \"constant\"\n\
                [[edit.handle.key]]\ntime = 1\n[[edit.handle.key]]\ntime = 2\ntranslation = [0, 0, -2]\n";
    std::fs::write(folder.path().join("keys.toml"), keys).unwrap();
    let lowest = |time: &[&str]| {
        let done = run(&[&["export", "bowl.rlvpm", "--script", "keys.toml", "-o", "level.ply"], time].concat());
        let info = relievo(folder.path(), &["info", "--json", "level.ply"]);
        let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
        (done, found["bounds"][0][2].as_f64().unwrap())
    };
    for (time, height) in [("0", 0.0), ("1.5", -1.0), ("9", -2.0)] {
        let (done, low) = lowest(&["--time", time]);
        assert!(done.status.success() && (low - height).abs() < 1e-5, "{time}: {low} {done:?}");
    }
    let (refused, _) = lowest(&[]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("--time"), "{refused:?}");
    // A stroke at a coarse level, and what becomes of the finest.
    let strokes = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.5\n\
                   radius = 0.6\nfalloff = \"smooth\"\npoints = [{ position = [0, 0, 0] }]\n";
    std::fs::write(folder.path().join("strokes.toml"), strokes).unwrap();
    std::fs::write(folder.path().join("sculpt.toml"), "[[edit]]\nfaces = 400\nstrokes = \"strokes.toml\"\n").unwrap();
    let sculpted = run(&["edit", "bowl.rlvpm", "--script", "sculpt.toml", "-o", "sculpted.rlvpm"]);
    assert!(sculpted.status.success() && text(&sculpted.stdout).starts_with("edit 1: "), "{sculpted:?}");
    assert!(run(&["export", "sculpted.rlvpm", "-o", "level.ply"]).status.success());
    let info = relievo(folder.path(), &["info", "--json", "level.ply"]);
    let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    // The bottom, 0 before, has risen by half.
    assert!(found["faces"] == 800 && found["bounds"][0][2].as_f64().unwrap() > 0.05, "{found}");
    std::fs::write(folder.path().join("edits.toml"), edits.replace("radius", "size")).unwrap();
    let refused = run(&["edit", "bowl.rlvpm", "--script", "edits.toml", "-o", "edited.rlvpm"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("unknown field `size`"), "{refused:?}");
    let bytes = std::fs::read(folder.path().join("bowl.rlvpm")).unwrap();
    std::fs::write(folder.path().join("bowl.rlvpm"), &bytes[..bytes.len() - 9]).unwrap();
    let refused = export(&[]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("ends too early"), "{refused:?}");
}
