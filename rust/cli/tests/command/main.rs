//! The `relievo` command as a user sees it: standard output, standard error and exit codes.

#[path = "../program/mod.rs"]
mod program;

mod documents;
mod isolation;
mod levels;
mod progress;
mod repair;
mod simplification;
mod spelling;

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use program::{relievo, text};

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn a_new_scene_of_meshes_elsewhere_says_how_to_run_it() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    for name in ["meshes/one.obj", "meshes/two.obj", "three.obj"] {
        std::fs::write(folder.path().join(name), CUBE).unwrap();
    }
    let meshes = ["../meshes/one.obj", "../meshes/two.obj", "../three.obj"];
    let new = relievo(&scenes, &[&["scene", "new"][..], &meshes, &["-o", "scene.toml"]].concat());
    let said = text(&new.stderr);
    let command = said.split('`').nth(1).unwrap();
    assert_eq!(command, "relievo scene run scene.toml --allow-path ../meshes --allow-path ..");
    // The options that it names are enough, and needed.
    let options: Vec<&str> = command.split(' ').skip(4).collect();
    let check = relievo(&scenes, &[&["scene", "check", "scene.toml"], options.as_slice()].concat());
    assert!(check.status.success(), "{check:?}");
    assert_eq!(relievo(&scenes, &["scene", "check", "scene.toml"]).status.code(), Some(1));
}

#[test]
fn a_run_says_how_large_its_meshes_will_be_before_it_writes_them() {
    let scene = "version = 1\n[meshes.cube]\nfile = \"cube.obj\"\n[surfaces.cube]\nmesh = \"cube\"\n[objects.cube]\n\
                 surface = \"cube\"\n[output]\nframes = 200\npicture_frames = \"none\"\nmesh = \"every\"\n\
                 mesh_formats = [\"obj\"]\nrate = 64\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let mut run = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["scene", "run", "scene.toml"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(run.stderr.take().unwrap()).read_line(&mut line).unwrap();
    run.kill().unwrap();
    run.wait().unwrap();
    assert!(line.starts_with("note: meshes will take about ") && line.contains(" MiB"), "{line}");
    // Of one frame nothing is said, and its size is the one that was foreseen.
    let one = relievo(folder.path(), &["scene", "run", "scene.toml", "--frames", "0..0"]);
    assert!(one.status.success() && one.stderr.is_empty(), "{one:?}");
    let size = std::fs::metadata(folder.path().join("scene-out/mesh-000000-cube.obj")).unwrap().len();
    let foreseen: u64 = line.split(' ').nth(5).unwrap().parse().unwrap();
    let share = (foreseen << 20) as f64 / (200 * size) as f64;
    assert!((0.7..1.4).contains(&share), "{foreseen} MiB of {}", (200 * size) >> 20);
}

#[test]
fn a_new_scene_checks_runs_and_leaves_only_results_on_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
    let new = relievo(folder.path(), &["scene", "new", "cube.obj", "-o", "scene.toml"]);
    assert!(new.status.success() && new.stdout.is_empty(), "{new:?}");
    assert!(!relievo(folder.path(), &["scene", "new", "cube.obj", "-o", "scene.toml"]).status.success());
    let check = relievo(folder.path(), &["scene", "check", "scene.toml"]);
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
    let run = relievo(folder.path(), &["scene", "run", "scene.toml", "--trace", "trace.json"]);
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
    let export = relievo(folder.path(), &["scene", "export", "pov", "scene.toml"]);
    assert!(export.status.success() && text(&export.stdout) == "scene-out/scene-000013.pov\n", "{export:?}");
    let pov = std::fs::read_to_string(folder.path().join("scene-out/scene-000013.pov")).unwrap();
    assert!(pov.contains("#version 3.7;") && pov.contains("camera {") && pov.contains("mesh2 {"));
    let export =
        relievo(folder.path(), &["scene", "export", "pov", "scene.toml", "--out", "scene-out", "--frames", "3..4"]);
    assert!(export.status.success() && text(&export.stdout).lines().count() == 2, "{export:?}");
    assert_eq!(relievo(folder.path(), &["scene", "export", "pov", "none.toml"]).status.code(), Some(1));
    let export = relievo(folder.path(), &["scene", "export", "blender", "scene.toml"]);
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
    for verb in ["check", "run"] {
        let output = relievo(folder.path(), &["scene", verb, "bad.toml"]);
        assert_eq!(output.status.code(), Some(1));
        let shown = text(&output.stderr);
        assert!(output.stdout.is_empty() && shown.contains("bad.toml:3:1") && shown.contains("did you mean `mesh`?"));
    }
    assert!(!folder.path().join("bad-out").exists());
    let missing = relievo(folder.path(), &["scene", "check", "none.toml"]);
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
    let run =
        |more: &[&str]| relievo(folder.path(), &[&["scene", "run", "a.toml", "--out", more[0]], &more[1..]].concat());
    assert!(run(&["auto", "--device", "auto"]).status.success());
    // A device that is not there is an error, and nothing is written.
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
    // Without a desktop drivers have nothing to say about it.
    let bare = |command: &mut Command| {
        command
            .env_remove("XDG_RUNTIME_DIR")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("NODEVICE_SELECT")
            .output()
            .unwrap()
    };
    let listed = bare(Command::new(env!("CARGO_BIN_EXE_relievo")).arg("devices").current_dir(folder.path()));
    assert!(listed.status.success() && text(&listed.stdout).starts_with("cpu  "), "{listed:?}");
    assert_eq!(text(&listed.stderr), "");
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
    let schema = relievo(folder.path(), &["scene", "schema", "--json"]);
    let schema: serde_json::Value = serde_json::from_slice(&schema.stdout).unwrap();
    assert_eq!(schema["version"], 1);
    assert!(text(&relievo(folder.path(), &["scene", "schema"]).stdout).contains("max_displacement = 1"));
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
fn files_without_particles_are_refused_with_the_formats_of_particles() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.rlvfluid", "a.bgeo", "a.vtk", "a.vdb"] {
        for bytes in ["", "nothing of the kind"] {
            std::fs::write(folder.path().join(name), bytes).unwrap();
            let done = relievo(folder.path(), &["info", name]);
            let said = text(&done.stderr);
            assert!(done.status.code() == Some(1) && said.contains(".rlvfluid, .bgeo, .vtk, .ply or .vdb"), "{done:?}");
        }
    }
}
