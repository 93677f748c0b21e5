//! The `relievo` command as a user sees it: standard output, standard error and exit codes.

use std::path::Path;
use std::process::{Command, Output};

fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn a_new_scene_checks_runs_and_leaves_only_results_on_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
    let new = relievo(folder.path(), &["new", "cube.obj", "-o", "scene.toml"]);
    assert!(new.status.success() && new.stdout.is_empty(), "{new:?}");
    assert!(!relievo(folder.path(), &["new", "cube.obj", "-o", "scene.toml"]).status.success());
    let check = relievo(folder.path(), &["check", "scene.toml"]);
    assert!(check.status.success() && text(&check.stdout).contains("no faults"), "{check:?}");
    // The starter scene as it is, but small and short.
    let scene = std::fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    let small = scene
        .replace("frames = 25", "frames = 14")
        .replace("width = 640", "width = 64")
        .replace("height = 480", "height = 48");
    let small = small
        .replace("samples = 16", "samples = 1\npicture_frames = \"last\"")
        .replace("tile_size = 128", "tile_size = 16");
    std::fs::write(folder.path().join("scene.toml"), small).unwrap();
    let run = relievo(folder.path(), &["run", "scene.toml", "--trace", "trace.json"]);
    assert!(run.status.success() && run.stderr.is_empty(), "{run:?}");
    assert!(text(&run.stdout).contains("imprint.raycast"));
    assert!(folder.path().join("scene-out/beauty-000013.png").exists());
    assert!(folder.path().join("scene-out/mesh-000013.glb").exists());
    let trace: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("trace.json")).unwrap()).unwrap();
    assert!(trace["traceEvents"].as_array().unwrap().len() > 20);
    let picture = "scene-out/beauty-000013.png";
    let compare = relievo(folder.path(), &["compare", picture, picture, "--json", "--max-error", "0"]);
    assert!(compare.status.success(), "{compare:?}");
    let found: serde_json::Value = serde_json::from_slice(&compare.stdout).unwrap();
    assert_eq!(found["flip_mean"], 0.0);
    // Two rows of three pictures, and their sheet.
    let row = [picture, picture, picture];
    let names =
        ["--row", "One", "--row", "Two", "--names", "A,B,C", "--sheet", "sheet.png", "--width", "400", "--json"];
    let compare = relievo(folder.path(), &[&["compare"][..], &row, &row, &names].concat());
    assert!(compare.status.success(), "{compare:?}");
    let found: serde_json::Value = serde_json::from_slice(&compare.stdout).unwrap();
    assert_eq!((found.as_array().unwrap().len(), &found[3]["row"], &found[3]["psnr"]), (4, &"Two".into(), &().into()));
    assert!(folder.path().join("sheet.png").exists());
    // A picture without depths is not within a limit of depths.
    let compare = relievo(folder.path(), &["compare", picture, picture, "--max-depth", "1"]);
    assert_eq!(compare.status.code(), Some(3));
    let compare = relievo(folder.path(), &[&["compare"][..], &row, &["--row", "a", "--row", "b"]].concat());
    assert!(compare.status.code() == Some(1) && text(&compare.stderr).contains("3 pictures"), "{compare:?}");
    // The last frame, from the cache, and one that is asked for.
    let export = relievo(folder.path(), &["export", "pov", "scene.toml"]);
    assert!(export.status.success() && text(&export.stdout) == "scene-out/scene-000013.pov\n", "{export:?}");
    let pov = std::fs::read_to_string(folder.path().join("scene-out/scene-000013.pov")).unwrap();
    assert!(pov.contains("#version 3.7;") && pov.contains("camera {") && pov.contains("mesh2 {"));
    let export = relievo(folder.path(), &["export", "pov", "scene.toml", "--out", "scene-out", "--frames", "3..4"]);
    assert!(export.status.success() && text(&export.stdout).lines().count() == 2, "{export:?}");
    assert_eq!(relievo(folder.path(), &["export", "pov", "none.toml"]).status.code(), Some(1));
    let export = relievo(folder.path(), &["export", "blender", "scene.toml"]);
    let files = "scene-out/scene-000013.py\nscene-out/scene-000013.bin\n";
    assert!(export.status.success() && text(&export.stdout) == files, "{export:?}");
    let script = std::fs::read_to_string(folder.path().join("scene-out/scene-000013.py")).unwrap();
    let (_, rest) = script.split_once("r'''").unwrap();
    let scene: serde_json::Value = serde_json::from_str(rest.split_once("'''").unwrap().0).unwrap();
    let bytes = std::fs::metadata(folder.path().join("scene-out/scene-000013.bin")).unwrap().len();
    let (objects, mut end) = (scene["objects"].as_array().unwrap(), 0);
    for array in objects.iter().flat_map(|object| object["mesh"].as_object().unwrap().values()) {
        end = end.max(array[0].as_u64().unwrap() + 4 * array[1].as_u64().unwrap());
    }
    assert!(objects.len() == 2 && end == bytes && scene["sky"].is_object(), "{end} of {bytes}");
}

#[test]
fn faults_point_into_the_scene_and_end_with_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.toml"), "version = 1\n[objects.a]\nmash = \"b\"\n").unwrap();
    for command in ["check", "run"] {
        let output = relievo(folder.path(), &[command, "bad.toml"]);
        assert_eq!(output.status.code(), Some(1));
        let shown = text(&output.stderr);
        assert!(output.stdout.is_empty() && shown.contains("bad.toml:3:1") && shown.contains("did you mean `mesh`?"));
    }
    assert!(!folder.path().join("bad-out").exists());
    let missing = relievo(folder.path(), &["check", "none.toml"]);
    assert!(missing.status.code() == Some(1) && text(&missing.stderr).contains("none.toml"));
    assert_eq!(relievo(folder.path(), &["fly"]).status.code(), Some(2));
}

#[test]
fn scenes_run_on_the_graphics_device_where_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "version = 1\n[meshes.a]\nshape = \"plane\"\nfaces = 4\n[surfaces.a]\nmesh = \"a\"\n[objects.a]\n\
                 surface = \"a\"\n[meshes.b]\nshape = \"box\"\nsize = [0.3, 0.3, 0.3]\n[objects.b]\nmesh = \"b\"\n\
                 translation = [0, 0, 0.1]\n[imprints]\nvoxels = 65536\n[colliders.b]\n[output]\nframes = 1\n\
                 pictures = []\nmesh = \"none\"\n";
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    let run = |more: &[&str]| relievo(folder.path(), &[&["run", "a.toml", "--out", more[0]], &more[1..]].concat());
    assert!(run(&["auto", "--device", "auto"]).status.success());
    // A device that is not there is told, and nothing is written.
    let missing = run(&["missing", "--device", "gpu", "--adapter", "no such device"]);
    assert!(missing.status.code() == Some(1) && text(&missing.stderr).contains("no such device"), "{missing:?}");
    assert!(!folder.path().join("missing").exists());
    let fallen = run(&["fallen", "--device", "auto", "--adapter", "no such device"]);
    assert!(fallen.status.success() && text(&fallen.stderr).contains("note: on the processor"), "{fallen:?}");
    if !relievo_gpu::adapters().is_empty() {
        let gpu = run(&["gpu", "--device", "gpu"]);
        assert!(gpu.status.success() && !text(&gpu.stderr).contains("processor"), "{gpu:?}");
        assert!(text(&gpu.stdout).contains("imprint.device.raycast"), "{}", text(&gpu.stdout));
    }
}

#[test]
fn devices_are_listed_as_others_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let listed = relievo(folder.path(), &["devices"]);
    assert!(listed.status.success() && text(&listed.stdout).starts_with("cpu  "), "{listed:?}");
    let listed = relievo(folder.path(), &["devices", "--json"]);
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    assert!(listed["cpu"]["threads"].as_u64().unwrap() > 0);
    let names: Vec<_> = listed["gpu"].as_array().unwrap().iter().map(|it| it["name"].as_str().unwrap()).collect();
    let expected: Vec<_> = relievo_gpu::adapters().into_iter().map(|it| it.name).collect();
    assert_eq!(names, expected);
}

#[test]
fn schema_and_info_print_for_people_and_programs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
    let schema = relievo(folder.path(), &["schema", "--json"]);
    let schema: serde_json::Value = serde_json::from_slice(&schema.stdout).unwrap();
    assert_eq!(schema["version"], 1);
    assert!(text(&relievo(folder.path(), &["schema"]).stdout).contains("max_displacement = 1"));
    let info = relievo(folder.path(), &["info", "cube.obj", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&info["faces"], &info["boundary_edges"]), (&6.into(), &0.into()));
    assert!(text(&relievo(folder.path(), &["info", "cube.obj"]).stdout).contains("6 quads"));
}

#[test]
fn info_looks_into_textures() {
    use relievo_ptex::{Borders, DataType, Face, Format, MeshType, MetaValue, Writer};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ptx");
    let format = Format { mesh: MeshType::Quad, data_type: DataType::U16, channels: 3, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 2).unwrap();
    writer.set(0, &Face::new(3, 2), &(0..192).collect::<Vec<u8>>()).unwrap();
    writer.set_constant(1, &Face::new(4, 4), &[1; 6]).unwrap();
    writer.set_meta("Title", MetaValue::Text("snow".into()));
    writer.write(&path).unwrap();
    let info = relievo(folder.path(), &["info", "a.ptx", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&info["data_type"], &info["channels"], &info["faces"]), (&"uint16".into(), &3.into(), &2.into()));
    assert_eq!((&info["constant_faces"], &info["texels"]), (&1.into(), &288.into()));
    let shown = text(&relievo(folder.path(), &["info", "a.ptx"]).stdout);
    assert!(shown.contains("8 x 4: 1 faces") && shown.contains("Title: 4 string"), "{shown}");
    // Too little memory, and a file that is cut off.
    assert_eq!(relievo(folder.path(), &["info", "a.ptx", "--memory-limit", "100"]).status.code(), Some(1));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    let output = relievo(folder.path(), &["info", "a.ptx"]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("a.ptx: "), "{output:?}");
}

#[test]
fn documents_are_looked_into_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo");
    let path = folder.path().join("a.relievo");
    std::fs::copy(golden, &path).unwrap();
    let info = relievo(folder.path(), &["info", "a.relievo", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&info["faces"], &info["tiles"], &info["version"]), (&3.into(), &9.into(), &1.into()));
    assert_eq!((&info["layers"][1]["name"], &info["layers"][1]["tiles"]), (&"colour".into(), &2.into()));
    let shown = text(&relievo(folder.path(), &["info", "a.relievo"]).stdout);
    assert!(shown.contains("layer `displacement`: scalar displacement, f16, tiles of 8 to 16, 2 of 9"), "{shown}");
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert!(check.status.success() && text(&check.stdout).contains("no damage, 6 blocks of 3 layers"), "{check:?}");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert_eq!(check.status.code(), Some(1));
    let told = text(&check.stdout);
    assert!(told.contains("a.relievo: layer `light`: tile 3 of face 1: the checksum"), "{told}");
    assert!(told.contains("1 parts are damaged, of 6 blocks"), "{told}");
    // Opening it says so as well.
    let info = relievo(folder.path(), &["info", "a.relievo"]);
    assert!(info.status.code() == Some(1) && text(&info.stderr).contains("relievo doc check"), "{info:?}");
    let repair = relievo(folder.path(), &["doc", "repair", "a.relievo"]);
    let told = text(&repair.stdout);
    assert!(told.contains("lost: layer `light`: tile 3") && told.contains("as it was: a.relievo.damaged"), "{told}");
    let shown = text(&relievo(folder.path(), &["info", "a.relievo"]).stdout);
    assert!(shown.contains("format version 3") && shown.contains("layer `light`: colour, RGBA16F, tiles of 8, 1 of 9"));
}

#[test]
fn a_document_goes_to_another_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-2.relievo");
    std::fs::copy(golden, folder.path().join("a.relievo")).unwrap();
    // The document's strip is 6 by 1; this one is half as long.
    let half = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 0 1 0\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("half.obj"), half).unwrap();
    let moved = relievo(folder.path(), &["doc", "transfer", "a.relievo", "half.obj", "-o", "b.relievo"]);
    assert!(moved.status.success(), "{moved:?}");
    let told = text(&moved.stdout);
    assert!(told.contains("0.00 %) of the new surface") && told.contains("has no place on the new mesh"), "{told}");
    let info = text(&relievo(folder.path(), &["info", "b.relievo"]).stdout);
    assert!(info.contains("mesh: 1 faces") && info.contains("layer `first`"), "{info}");
}

#[test]
fn the_edits_of_a_document_are_checked_and_folded() {
    let folder = tempfile::tempdir().unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-2.relievo");
    let bytes = std::fs::read(golden).unwrap();
    let path = folder.path().join("a.relievo");
    std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let check = relievo(folder.path(), &["doc", "check", "a.relievo"]);
    assert!(check.status.success(), "{check:?}");
    let told = text(&check.stdout);
    assert!(told.contains("an edit was under way when the document was left, and is not in it: edit 15"), "{told}");
    assert!(told.contains("no damage"), "{told}");
    let compact = relievo(folder.path(), &["doc", "compact", "a.relievo"]);
    let told = text(&compact.stdout);
    assert!(told.contains("edits are folded into its layers and can no longer be undone"), "{told}");
    assert!(std::fs::metadata(&path).unwrap().len() < bytes.len() as u64);
    let check = text(&relievo(folder.path(), &["doc", "check", "a.relievo"]).stdout);
    assert!(check.contains("no damage") && !check.contains("under way"), "{check}");
}

/// A bowl of 400 squares.
fn bowl() -> String {
    let bowl = |index: u32| {
        let (x, y) = (index % 21, index / 21);
        let (x, y) = (f64::from(x) / 10.0 - 1.0, f64::from(y) / 10.0 - 1.0);
        format!("v {x} {y} {}\n", 0.3 * (x * x + y * y))
    };
    let square = |index: u32| {
        let at = index / 20 * 21 + index % 20 + 1;
        format!("f {at} {} {} {}\n", at + 1, at + 22, at + 21)
    };
    (0..441).map(bowl).chain((0..400).map(square)).collect()
}

#[test]
fn a_mesh_is_simplified_to_a_share_a_number_or_a_deviation() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bowl.obj"), bowl()).unwrap();
    let simplify =
        |goal: &[&str]| relievo(folder.path(), &[&["simplify", "bowl.obj", "-o", "less.ply"][..], goal].concat());
    let faces = || {
        let info = relievo(folder.path(), &["info", "--json", "less.ply"]);
        let found: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
        found["faces"].as_u64().unwrap()
    };
    let done = simplify(&["--ratio", "0.25"]);
    assert!(done.status.success() && text(&done.stdout).starts_with("800 triangles, "), "{done:?}");
    assert!((199..=200).contains(&faces()), "{}", faces());
    assert!(simplify(&["--faces", "100", "--threads", "1"]).status.success());
    assert!((99..=100).contains(&faces()), "{}", faces());
    assert!(simplify(&["--error", "0.02"]).status.success());
    assert!((8..100).contains(&faces()), "{}", faces());
    assert_eq!(simplify(&[]).status.code(), Some(2));
    let refused = simplify(&["--ratio", "1.5"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("use 0 to 1"), "{refused:?}");
}

/// The bowl with texture coordinates: columns 0 to 10 are on the left half of the texture, 10 to 20 on the right half, and
/// both have column 10.
fn map() -> String {
    let place = |index: u32| [index % 21, index / 21].map(|it| f64::from(it) / 20.0);
    let coordinates = |shift: f64| (0..441).map(place).map(move |[x, y]| format!("vt {} {y}\n", 0.4 * x + shift));
    let square = |index: u32| {
        let (column, at) = (index % 20, index / 20 * 21 + index % 20 + 1);
        let corner = |at: u32| format!("{at}/{}", if column < 10 { at } else { at + 441 });
        format!("f {} {} {} {}\n", corner(at), corner(at + 1), corner(at + 22), corner(at + 21))
    };
    let points = bowl().lines().filter(|line| line.starts_with('v')).fold(String::new(), |all, line| all + line + "\n");
    let coordinates: String = coordinates(0.0).chain(coordinates(0.5)).collect();
    let faces: String = (0..400).map(square).collect();
    points + &coordinates + &faces
}

/// Checks the texture coordinates of a bowl with fewer triangles, each within tolerances. Returns how many corners it has.
fn corners_of_map(less: &str, [most_u, most_v]: [f64; 2]) -> usize {
    let numbers = |keyword: &str| -> Vec<Vec<f64>> {
        let lines = less.lines().filter_map(|line| line.strip_prefix(keyword));
        lines.map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect()
    };
    let (points, coordinates) = (numbers("v "), numbers("vt "));
    let (mut corners, mut at_seam) = (0, std::collections::HashSet::new());
    for corner in less.lines().filter_map(|line| line.strip_prefix("f ")).flat_map(|line| line.split(' ')) {
        let (point, value) = corner.split_once('/').unwrap();
        let [point, value] = [point, value].map(|number| number.parse::<usize>().unwrap() - 1);
        let (x, y) = ((points[point][0] + 1.0) / 2.0, (points[point][1] + 1.0) / 2.0);
        let [u, v] = [coordinates[value][0], coordinates[value][1]];
        let shift = if u > 0.45 { 0.5 } else { 0.0 };
        assert!((u - shift - 0.4 * x).abs() < most_u && (v - y).abs() < most_v, "{x} {y}: {u} {v}");
        if (x - 0.5).abs() < 1e-3 {
            at_seam.insert((point, shift > 0.0));
        }
        corners += 1;
    }
    assert!(at_seam.len() >= 4 && at_seam.iter().all(|(point, side)| at_seam.contains(&(*point, !side))));
    corners
}

#[test]
fn a_simplified_mesh_keeps_its_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.obj"), map()).unwrap();
    let simplify = |more: &[&str]| {
        relievo(folder.path(), &[&["simplify", "map.obj", "-o", "less.obj", "--faces", "200"][..], more].concat())
    };
    let done = simplify(&["--weight", "uv=0.05"]);
    assert!(done.status.success() && done.stderr.is_empty(), "{done:?}");
    let less = std::fs::read_to_string(folder.path().join("less.obj")).unwrap();
    let corners = corners_of_map(&less, [0.01, 0.02]);
    assert!((597..=600).contains(&corners), "{corners}");
    assert!(simplify(&["--without", "uv"]).status.success());
    assert!(!std::fs::read_to_string(folder.path().join("less.obj")).unwrap().contains("vt "));
    assert!(text(&simplify(&["--weight", "paint=1"]).stderr).contains("no attribute `paint`"));
}

#[test]
fn a_progressive_mesh_keeps_texture_coordinates_at_every_level() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.obj"), map()).unwrap();
    let run = |arguments: &[&str]| relievo(folder.path(), &[&["progressive"], arguments].concat());
    let built = run(&["build", "map.obj", "-o", "map.rlvpm", "--faces", "50", "--weight", "uv=0.05"]);
    assert!(built.status.success() && built.stderr.is_empty(), "{built:?}");
    assert!(text(&run(&["show", "map.rlvpm"]).stdout).contains("attributes: uv"));
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
    std::fs::write(path("bowl.obj"), bowl()).unwrap();
    assert!(run(&["build", "bowl.obj", "-o", "bowl.rlvpm", "--faces", "50"]).status.success());
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
