//! `relievo foam` as a user sees it.

use std::path::Path;
use std::process::{Command, Output};

fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let done = relievo(folder, arguments);
    assert!(done.status.success(), "{done:?}");
    String::from_utf8(done.stdout).unwrap()
}

const DAM: &str = "frames = 8\nfps = 24\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [1.2, 0.3, 1]\n\
    [[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.3, 0.8]\nvelocity = [2, 0, 0]\n";
/// Settings at which so small a fluid foams.
const LOW: [&str; 8] = ["--energy", "0.5,5", "--trapped-air", "0.5,5", "--air-rate", "300", "--crest-rate", "300"];

#[test]
fn foam_of_a_dam_is_made_resumed_rendered_and_composited() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("dam.toml"), DAM).unwrap();
    done(at, &["fluid", "sim", "dam.toml", "-o", "frames"]);
    let generate = |output: &str, more: &[&str]| {
        relievo(at, &[&["foam", "generate", "frames", "-o", output], LOW.as_slice(), more].concat())
    };
    let made = generate("foam", &[]);
    assert!(made.status.success(), "{made:?}");
    let bytes = |folder: &str, frame: u32| std::fs::read(at.join(format!("{folder}/{frame:04}.rlvfluid"))).unwrap();
    let rows: serde_json::Value = serde_json::from_str(&done(at, &["foam", "info", "foam", "--json"])).unwrap();
    let last = &rows[8];
    assert!(last["particles"].as_u64().unwrap() > 500, "{rows}");
    assert_eq!(
        last["particles"].as_u64(),
        ["spray", "foam", "bubbles"].map(|kind| last[kind].as_u64().unwrap()).iter().sum::<u64>().into()
    );
    // One thread, interrupted after frame 4.
    assert!(generate("again", &["--threads", "1"]).status.success());
    (5..9).for_each(|frame| std::fs::remove_file(at.join(format!("again/{frame:04}.rlvfluid"))).unwrap());
    let resumed = generate("again", &["--threads", "1"]);
    assert!(String::from_utf8_lossy(&resumed.stderr).contains("goes on from again/0004.rlvfluid"), "{resumed:?}");
    assert!((0..9).all(|frame| bytes("foam", frame) == bytes("again", frame)));
    let other = generate("again", &["--seed", "2"]);
    assert!(!other.status.success() && String::from_utf8_lossy(&other.stderr).contains("--restart"));
    assert!(generate("again", &["--seed", "2", "--restart"]).status.success());
    assert_ne!(bytes("foam", 8), bytes("again", 8));
    // Other formats have the same particles, and velocities are found by numbers where there are none.
    assert!(generate("vtk", &["--format", "vtk"]).status.success() && at.join("vtk/0008.vtk").exists());
    let view = ["--eye", "2.5,-1.5,1.4", "--target", "0.6,0.15,0.3", "--set", "radius=0.03"];
    let render = |more: &[&str]| {
        let fixed = ["foam", "render", "foam/0008.rlvfluid", "--fluid", "frames/0008.rlvfluid", "--size", "96x64"];
        done(at, &[&fixed, view.as_slice(), more].concat())
    };
    let line = render(&["-o", "wave.png", "--layers", "layers.exr", "--samples", "1"]);
    assert!(line.contains("particles of foam in ") && !line.contains("in 0.0 %"), "{line}");
    render(&["-o", "wave.exr", "--samples", "1"]);
    let composite = |more: &[&str]| {
        let fixed = ["foam", "composite", "foam/0008.rlvfluid", "--picture", "wave.exr", "-o", "over.png"];
        relievo(at, &[&fixed, view.as_slice(), more].concat())
    };
    assert!(composite(&[]).status.success());
    let missing = composite(&["--solids", "wave.png"]);
    assert!(!missing.status.success(), "{missing:?}");
    let unknown = composite(&["--set", "rho_mop=2"]);
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("rho_mod"), "{unknown:?}");
    assert!(!relievo(at, &["foam", "render", "frames/0008.rlvfluid", "-o", "a.txt"]).status.success());
    assert!(done(at, &["foam", "info", "--settings"]).contains("ao_max_occl_dist"));
    assert!(!relievo(at, &["foam", "info", "frames"]).status.success());
}
