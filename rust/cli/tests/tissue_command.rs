//! `relievo tissue` as a user sees it.

mod program;

use std::path::Path;

use serde_json::Value;

use program::{done, refused};

const BLOCK: &str = r#"
voxel = 0.01
[[material]]
name = "gel"
young = 8000
poisson = 0.45
[[volume]]
name = "block"
body = { box = { low = [0, 0, 0], high = [0.06, 0.06, 0.03] } }
material = "gel"
[[bind]]
name = "top"
body = { box = { low = [0, 0, 0], high = [0.06, 0.06, 0.03], side = "z+" } }
"#;

const PRESS: &str = r#"
model = "block.rtissue"
frames = 3
fps = 100
[options]
damping = 20
[[move]]
set = "z-"
[[collider]]
ball = 0.02
friction = 0.2
keys = [{ time = 0, at = [0.03, 0.03, 0.051] }, { time = 0.03, at = [0.03, 0.03, 0.044] }]
"#;

fn info(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&done(folder, &["tissue", "info", file, "--json"])).unwrap()
}

#[test]
fn a_block_is_made_pressed_and_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("block.toml"), BLOCK).unwrap();
    std::fs::write(folder.join("press.toml"), PRESS).unwrap();
    let said = done(folder, &["tissue", "build", "block.toml", "-o", "block.rtissue"]);
    assert!(said.contains("6 × 6 × 3 voxels, 1.0800e-4 m³ inside") && said.contains("108 elements"), "{said}");
    let model = info(folder, "block.rtissue");
    assert_eq!((&model["nodes"], &model["bound surfaces"][0]), (&196.into(), &"top (4 points)".into()));
    done(folder, &["tissue", "sim", "press.toml", "-o", "frames", "--surfaces", "ply", "--vtu"]);
    for name in ["0000.rtstate", "0003.rtstate", "top.0003.ply", "0002.vtu"] {
        assert!(folder.join("frames").join(name).exists(), "{name}");
    }
    let last = std::fs::read(folder.join("frames/0003.rtstate")).unwrap();
    let frame = info(folder, "frames/0003.rtstate");
    let pressed = frame["largest displacement, m"].as_f64().unwrap();
    assert!((0.005..0.012).contains(&pressed), "{frame}");
    // An interrupted run gives the same bits.
    std::fs::remove_file(folder.join("frames/0003.rtstate")).unwrap();
    std::fs::write(folder.join("frames/0002.rtstate"), "cut off").unwrap();
    done(folder, &["tissue", "sim", "press.toml", "-o", "frames", "--threads", "1"]);
    assert_eq!(std::fs::read(folder.join("frames/0003.rtstate")).unwrap(), last);
    // A graphics device presses it as deep, and its frames are not taken for those of the processor.
    if std::env::var_os("RELIEVO_GPU_TESTS").is_some_and(|it| it == "required") {
        done(folder, &["tissue", "sim", "press.toml", "-o", "device", "--device", "gpu"]);
        let deep = info(folder, "device/0003.rtstate")["largest displacement, m"].as_f64().unwrap();
        assert!((deep - pressed).abs() < 1e-3 * pressed, "{deep} {pressed}");
        assert!(refused(folder, &["tissue", "sim", "press.toml", "-o", "device"]).contains("or device are there"));
    }
    // A description may be simulated at once.
    std::fs::write(folder.join("whole.toml"), PRESS.replace("block.rtissue", "block.toml")).unwrap();
    done(folder, &["tissue", "sim", "whole.toml", "-o", "whole"]);
    assert_eq!(std::fs::read(folder.join("whole/0003.rtstate")).unwrap().len(), last.len());
    let picture = ["tissue", "render", "press.toml", "frames/0000.rtstate", "frames/0003.rtstate", "-o", "a.png"];
    done(folder, &[&picture[..], &["--show", "stress", "--cut", "y=0.03", "--size", "80x60"]].concat());
    let sheet = relievo_render::read_png(&folder.join("a.png"), u64::MAX).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (160, 60));
    let differ = (0..60)
        .flat_map(|y| (0..80).map(move |x| (x, y)))
        .filter(|(x, y)| sheet.color(*x, *y) != sheet.color(x + 80, *y));
    assert!(differ.count() > 100);
}

#[test]
fn contact_pressure_and_strain_are_shown_where_the_ball_presses() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("block.toml"), BLOCK).unwrap();
    std::fs::write(folder.join("press.toml"), PRESS.replace("block.rtissue", "block.toml")).unwrap();
    done(folder, &["tissue", "sim", "press.toml", "-o", "frames", "--vtu"]);
    let vtu = String::from_utf8_lossy(&std::fs::read(folder.join("frames/0003.vtu")).unwrap()).into_owned();
    assert!(vtu.contains("\"contact_pressure\"") && vtu.contains("\"principal_strain\""));
    // Seen from above: the darkest colour at the rim, brighter ones in the middle where the ball is, which is left out.
    let picture = |show: &str| {
        let view = ["--show", show, "--eye", "0.03,0.029,0.3", "--target", "0.03,0.03,0", "--size", "60x60"];
        done(folder, &[&["tissue", "render", "press.toml", "frames/0003.rtstate", "-o", "a.png"], &view[..]].concat());
        relievo_render::read_png(&folder.join("a.png"), u64::MAX).unwrap()
    };
    for show in ["pressure", "strain", "volume"] {
        let sheet = picture(show);
        let differ = (0..60).any(|x| sheet.color(x, 30) != sheet.color(x, 12));
        assert!(differ, "{show}");
    }
    done(folder, &["tissue", "build", "block.toml", "-o", "block.rtissue"]);
    let refusal = refused(folder, &["tissue", "render", "block.rtissue", "-o", "a.png", "--show", "pressure"]);
    assert!(refusal.contains("description (.toml)"), "{refusal}");
}

#[test]
fn a_collider_that_swallows_the_model_leaves_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("block.toml"), BLOCK).unwrap();
    let (keys, _) = PRESS.split_once("[[collider]]").unwrap();
    let ball = "[[collider]]\nball = 0.2\nkeys = [{ time = 0.02, at = [0.03, 0.03, 0.5] }, \
        { time = 0.021, at = [0.03, 0.03, 0.02] }]\n";
    std::fs::write(folder.join("press.toml"), keys.replace("block.rtissue", "block.toml") + ball).unwrap();
    for _ in 0..2 {
        let said = refused(folder, &["tissue", "sim", "press.toml", "-o", "frames", "--vtu"]);
        assert!(said.contains("frame 3") && said.contains("collider 0") && said.contains("begin outside"), "{said}");
        for frame in ["0000", "0001", "0002"] {
            info(folder, &format!("frames/{frame}.rtstate"));
            let vtu = std::fs::read(folder.join(format!("frames/{frame}.vtu"))).unwrap();
            assert!(vtu.ends_with(b"</VTKFile>\n"));
        }
        assert_eq!(std::fs::read_dir(folder.join("frames")).unwrap().count(), 6, "nothing else is there");
    }
}

#[test]
fn models_go_to_abaqus_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("block.toml"), BLOCK).unwrap();
    done(folder, &["tissue", "build", "block.toml", "-o", "block.inp"]);
    done(folder, &["tissue", "build", "block.inp", "-o", "again.rtissue"]);
    assert_eq!(info(folder, "again.rtissue")["elements"], 108);
}

#[test]
fn what_cannot_be_made_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let spoilt = |from: &str, to: &str| {
        std::fs::write(folder.join("a.toml"), BLOCK.replacen(from, to, 1)).unwrap();
        refused(folder, &["tissue", "build", "a.toml", "-o", "a.rtissue"])
    };
    assert!(spoilt("poisson", "poison").contains("perhaps `poisson` is meant"));
    assert!(spoilt("material = \"gel\"", "material = \"gell\"").contains("use one of gel"));
    assert!(spoilt("voxel = 0.01", "voxel = 0").contains("voxel"));
    assert!(spoilt("young = 8000", "").contains("moduli"));
    assert!(spoilt("box = {", "mesh = \"b.obj\", box = {").contains("one of mesh, box"));
    assert!(refused(folder, &["tissue", "build", "a.toml", "-o", "a.obj"]).contains(".rtissue"));
    std::fs::write(folder.join("press.toml"), PRESS).unwrap();
    assert!(refused(folder, &["tissue", "sim", "press.toml", "-o", "frames"]).contains("block.rtissue"));
}
