//! `relievo mesh`: reports, exit codes and files.

use serde_json::Value;

use crate::{CUBE, relievo, text};

/// A cube without its lid, one side turned over.
fn torn() -> String {
    CUBE.replace("f 5 6 7 8\n", "").replace("f 1 2 6 5", "f 5 6 2 1")
}

#[test]
fn a_torn_cube_is_reported_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("torn.obj"), torn()).unwrap();
    let check = relievo(folder.path(), &["mesh", "check", "torn.obj"]);
    assert_eq!(check.status.code(), Some(3), "{check:?}");
    let report = text(&check.stdout);
    assert!(report.contains("misoriented edges     3 (") && report.contains("holes                 1 ("), "{report}");
    let json = relievo(folder.path(), &["mesh", "check", "torn.obj", "--json", "--listed", "1"]);
    let value: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(value["defects"]["misoriented_edges"]["count"], 3);
    assert_eq!(value["defects"]["misoriented_edges"]["first"].as_array().map(Vec::len), Some(1));
    assert_eq!((&value["solid"], &value["mesh"]["boundary_edges"]), (&Value::Bool(false), &Value::from(4)));

    let repair = relievo(folder.path(), &["mesh", "repair", "torn.obj", "-o", "torn.obj", "--json"]);
    assert!(repair.status.success() && repair.stderr.is_empty(), "{repair:?}");
    let value: Value = serde_json::from_slice(&repair.stdout).unwrap();
    assert_eq!((&value["turned_faces"], &value["filled_holes"]), (&Value::from(1), &Value::from(1)));
    assert!((value["repaired"]["volume"].as_f64().unwrap() - 8.0).abs() < 1e-6, "{value}");
    let again = relievo(folder.path(), &["mesh", "check", "torn.obj"]);
    assert!(again.status.success(), "{again:?}");
}

#[test]
fn steps_are_left_out_and_failures_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("torn.obj"), torn()).unwrap();
    let repair = relievo(folder.path(), &["mesh", "repair", "torn.obj", "-o", "open.ply", "--skip", "fill"]);
    assert!(text(&repair.stdout).contains("1 holes left open"), "{repair:?}");
    let open = |more: &[&str]| {
        let code = relievo(folder.path(), &[&["mesh", "check", "open.ply"], more].concat()).status.code();
        code.unwrap()
    };
    assert_eq!((open(&[]), open(&["--open"])), (3, 0));
    let missing = relievo(folder.path(), &["mesh", "check", "missing.obj"]);
    assert_eq!(missing.status.code(), Some(1));
    let unknown = relievo(folder.path(), &["mesh", "repair", "torn.obj", "-o", "out.xyz"]);
    assert!(text(&unknown.stderr).contains(".ply") && !unknown.status.success(), "{unknown:?}");
    let fin = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n";
    std::fs::write(folder.path().join("fin.obj"), fin).unwrap();
    let noted = relievo(folder.path(), &["mesh", "simplify", "fin.obj", "-o", "less.ply", "--faces", "1"]);
    assert!(text(&noted.stderr).contains("relievo mesh repair fin.obj"), "{noted:?}");
    let help = text(&relievo(folder.path(), &["mesh", "repair", "--help"]).stdout);
    assert!(help.contains("Example: relievo mesh repair"), "{help}");
}
