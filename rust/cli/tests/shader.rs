//! `relievo shader` as a user sees it.
#![cfg(feature = "shader")]

mod program;

use std::path::Path;

use serde_json::Value;

use program::{done, refused};

const SHADER: &str = "struct Look { gain: f32, resolution: vec2<f32> }\n@group(0) @binding(0) var<uniform> look: Look;\n\
    @fragment fn draw(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {\n    \
    //. name Column\n    let column = at.x / look.resolution.x;\n    let row = at.y / look.resolution.y;\n    \
    let shade = column * look.gain;\n    return vec4<f32>(shade, row, 0.0, 1.0 /*. * confidence */);\n}\n";

#[test]
fn shaders_are_checked_marked_and_augmented_without_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("plain.wgsl"), SHADER).unwrap();
    let listed = done(folder, &["shader", "check", "plain.wgsl"]);
    assert!(listed.contains("Column: float, line 5, in draw") && listed.contains("vectors        none"), "{listed}");
    let mark = ["shader", "mark", "plain.wgsl", "-o", "marked.wgsl", "--variable", "column", "--variable"];
    let misspelt = refused(folder, &[&mark[..], &["rwo"]].concat());
    assert!(misspelt.contains("did you mean `row`?"), "{misspelt}");
    done(folder, &[&mark[..], &["row"]].concat());
    let listed: Value = serde_json::from_str(&done(folder, &["shader", "check", "marked.wgsl", "--json"])).unwrap();
    assert_eq!(listed["vectors"]["features"][0]["name"], "Column");
    assert_eq!(listed["vectors"]["features"][1]["expression"], "row");
    done(folder, &["shader", "augment", "marked.wgsl", "-o", "augmented.wgsl", "--layout", "layout.json"]);
    let layout: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("layout.json")).unwrap()).unwrap();
    assert_eq!(layout["examples"]["group"], 1);
    let again = refused(folder, &["shader", "check", "augmented.wgsl"]);
    assert!(again.contains("belong to the augmentation") && again.contains("augmented.wgsl:"), "{again}");
    std::fs::write(folder.join("wrong.wgsl"), SHADER.replace("let row", "//. vector column; 1.0; columm\n    let row"))
        .unwrap();
    let wrong = refused(folder, &["shader", "check", "wrong.wgsl"]);
    assert!(wrong.contains("wrong.wgsl:6:") && wrong.contains("^^^^^^"), "{wrong}");
}

/// Whether there is a graphics device; where one is required, it fails without.
fn has_device() -> bool {
    let is_there = !relievo_gpu::adapters().is_empty();
    let is_required = std::env::var_os("RELIEVO_GPU_TESTS").is_some_and(|it| it == "required");
    assert!(is_there || !is_required, "there is no graphics device");
    if !is_there {
        println!("skipped: there is no graphics device");
    }
    is_there
}

#[test]
fn vertex_shaders_run_with_a_fragment_shader_and_alone() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/shaders");
    for name in ["terrain.toml", "terrain.vert", "terrain.frag"] {
        std::fs::copy(examples.join(name), folder.join(name)).unwrap();
    }
    let classify =
        ["shader", "classify", "terrain.toml", "--size", "160x90", "--positive", "88,34", "--negative", "60,48"];
    let rest = ["--why", "80,54", "-o", "classes.json", "--json"];
    let found: Value = serde_json::from_str(&done(folder, &[&classify[..], &rest[..]].concat())).unwrap();
    assert_eq!((&found["names"][0], &found["pixels"][0]["taken"]), (&"Height".into(), &3.into()), "{found}");
    let picture = ["shader", "run", "terrain.toml", "--size", "160x90", "--classes", "classes.json", "-o", "pair.exr"];
    done(folder, &[&picture[..], &["--mask", "mask.png"]].concat());
    // The fragment shader hands the colour on: the vertex shader alone draws the same.
    let alone =
        ["shader", "run", "terrain.vert", "--vertices", "55296", "--size", "160x90", "--classes", "classes.json"];
    let set =
        ["--set", "turn=0.6", "--set", "tilt=0.75", "--set", "aspect=1.7778", "-o", "alone.exr", "--mask", "again.png"];
    done(folder, &[&alone[..], &set[..]].concat());
    for names in [["pair.exr", "alone.exr"], ["mask.png", "again.png"]] {
        let [a, b] = names.map(|name| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{names:?}");
    }
    let values =
        ["shader", "values", "terrain.vert", "--vertices", "55296", "--set", "aspect=1.5", "--pixel", "320,200"];
    let values = done(folder, &values);
    assert!(values.contains("Slope") && values.contains("the mean of 3"), "{values}");
    let wrong = refused(folder, &["shader", "run", "terrain.frag", "--vertex", "terrain.frag", "-o", "x.png"]);
    assert!(wrong.contains("no vertex entry point"), "{wrong}");
}

#[test]
fn pixels_are_classified_and_classes_exported() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let marked = SHADER.replace("    let shade", "    //. vector column; row; 1.0\n    let shade");
    std::fs::write(folder.join("marked.wgsl"), marked).unwrap();
    std::fs::write(
        folder.join("project.toml"),
        "# Ours\nversion = 1\nshader = \"marked.wgsl\"\nsize = [40, 20]\n[set]\ngain = [0.5]\n",
    )
    .unwrap();
    let classify =
        ["shader", "classify", "project.toml", "--positive", "4,4", "--negative", "35,15", "--negative", "36,5"];
    let rest = ["-o", "classes.json", "--why", "5,5", "--save", "--json"];
    let found: Value = serde_json::from_str(&done(folder, &[&classify[..], &rest[..]].concat())).unwrap();
    assert!((found["pixels"][0]["vector"][0].as_f64().unwrap() - 5.5 / 40.0).abs() < 1e-5);
    assert!(found["pixels"][0]["membership"].as_f64().unwrap() > 0.9);
    assert_eq!(found["pixels"][0]["neighbours"][0]["example"], 0);
    let project = std::fs::read_to_string(folder.join("project.toml")).unwrap();
    assert!(project.starts_with("# Ours\n") && project.matches("[[example]]").count() == 3, "{project}");
    done(folder, &["shader", "run", "project.toml", "-o", "one.exr", "--mask", "one.png"]);
    done(
        folder,
        &[
            "shader",
            "run",
            "marked.wgsl",
            "--size",
            "40x20",
            "--set",
            "gain=0.5",
            "--classes",
            "classes.json",
            "-o",
            "two.exr",
            "--mask",
            "two.png",
        ],
    );
    for ending in ["exr", "png"] {
        let files = ["one", "two"].map(|name| std::fs::read(folder.join(format!("{name}.{ending}"))).unwrap());
        assert_eq!(files[0], files[1]);
    }
    let values = done(folder, &["shader", "values", "project.toml", "--pixel", "5,5"]);
    assert!(values.contains("line 5     Column           0.137500\n"), "{values}");
    let values = done(folder, &["shader", "values", "project.toml", "--pixel", "5,5", "--json"]);
    let values: Value = serde_json::from_str(&values).unwrap();
    let shade = values.as_array().unwrap().iter().find(|it| it["name"] == "shade").unwrap();
    assert!((shade["mean"][0].as_f64().unwrap() - 0.5 * 5.5 / 40.0).abs() < 1e-6 && shade["taken"] == 1, "{shade}");
    done(folder, &["shader", "export", "classes.json", "-o", "transfer.png"]);
    done(folder, &["shader", "export", "classes.json", "-o", "near.wgsl", "--name", "near"]);
    assert!(std::fs::read_to_string(folder.join("near.wgsl")).unwrap().contains("fn near(f0: f32, f1: f32) -> f32"));
    let wrong = refused(folder, &["shader", "run", "marked.wgsl", "-o", "x.png", "--set", "gian=1"]);
    assert!(wrong.contains("did you mean `gain`?"), "{wrong}");
}
