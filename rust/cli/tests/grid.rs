//! `relievo grid` as a user sees it.

mod program;

use std::path::Path;
use std::process::Command;

use relievo_openvdb::peer::is_available;
use serde_json::Value;

use program::{done, relievo, text};

const BOX: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n";

fn grids(folder: &Path, file: &str) -> Vec<Value> {
    let list: Value = serde_json::from_str(&done(folder, &["grid", "info", file, "--json"])).unwrap();
    list["grids"].as_array().unwrap().clone()
}

#[test]
fn meshes_become_grids_and_meshes_again() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("box.obj"), BOX).unwrap();
    let moved = BOX.replace("v 0", "v 0.5").replace("v 1", "v 1.5");
    std::fs::write(folder.join("moved.obj"), moved).unwrap();
    done(folder, &["grid", "convert", "box.obj", "-o", "box.vdb", "--voxel", "0.05"]);
    let info = &grids(folder, "box.vdb")[0];
    assert_eq!((info["name"].as_str(), info["class"].as_str()), (Some("box"), Some("level set")));
    assert_eq!((info["kind"].as_str(), info["voxel_size"][0].as_f64()), (Some("float"), Some(0.05)));
    assert!(done(folder, &["grid", "info", "box.vdb"]).contains("active voxels"));
    assert!(done(folder, &["grid", "mesh", "box.vdb", "-o", "again.ply"]).contains("0 triangles"));
    let coarse = done(folder, &["grid", "mesh", "box.vdb", "-o", "coarse.obj", "--adaptivity", "0.5"]);
    assert!(!coarse.contains(" 0 triangles"), "{coarse}");

    let convert =
        ["grid", "convert", "box.vdb", "-o", "fog.vdb", "--to", "fog", "--offset", "0.1", "--smooth", "mean", "--half"];
    done(folder, &convert);
    let fog = &grids(folder, "fog.vdb")[0];
    assert_eq!((fog["class"].as_str(), fog["half"].as_bool()), (Some("fog volume"), Some(true)));
    done(folder, &["grid", "convert", "fog.vdb", "-o", "mask.vdb", "--kind", "mask", "--pack", "zip"]);
    assert_eq!(grids(folder, "mask.vdb")[0]["kind"], "mask");
    done(folder, &["grid", "mesh", "mask.vdb", "-o", "mask.ply"]);

    let combine = ["grid", "combine", "box.vdb", "moved.obj", "-o", "both.vdb", "--operation"];
    let count = |operation: &str| {
        done(folder, &[&combine[..], &[operation]].concat());
        grids(folder, "both.vdb")[0]["active_voxels"].as_u64().unwrap()
    };
    let (union, intersection) = (count("union"), count("intersection"));
    assert!(union > intersection && intersection > 100, "{union} {intersection}");
    count("labels");
    assert_eq!(grids(folder, "both.vdb")[0]["kind"], "int32");
    done(folder, &["grid", "mesh", "both.vdb", "-o", "label.ply", "--label", "2"]);

    for (arguments, why) in [
        (&["grid", "mesh", "both.vdb", "-o", "none.ply", "--label", "7"][..], "no surface"),
        (&["grid", "mesh", "box.vdb", "-o", "none.ply", "--grid", "smoke"], "box (Tree_float_5_4_3)"),
        (&["grid", "convert", "box.obj", "-o", "none.vdb", "--voxel", "0.0001"], "memory limit"),
        (&["grid", "combine", "box.vdb", "fog.vdb", "-o", "none.vdb"], "kind and class"),
        (&["grid", "info", "box.obj"], "not begin as OpenVDB"),
    ] {
        let refused = relievo(folder, arguments);
        assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains(why), "{why}: {refused:?}");
    }
    assert!(!folder.join("none.ply").exists() && !folder.join("none.vdb").exists());
    let usage = relievo(folder, &["grid", "combine", "box.vdb", "-o", "none.vdb"]);
    assert_eq!(usage.status.code(), Some(2));
}

#[test]
fn without_the_module_files_are_listed_and_the_package_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("box.obj"), BOX).unwrap();
    std::fs::write(
        folder.join("dam.toml"),
        "frames = 1\nfps = 50\n[fluid]\nspacing = 0.1\n[basin]\nlow = [0, 0, 0]\n\
        high = [1, 1, 1]\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.5, 0.5, 0.5]\n",
    )
    .unwrap();
    done(folder, &["fluid", "sim", "dam.toml", "-o", "frames", "--format", "vdb"]);
    let without = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relievo"));
        command.args(arguments).current_dir(folder).env("RELIEVO_OPENVDB", "/nowhere.so").output().unwrap()
    };
    let listed = without(&["grid", "info", "frames/0001.vdb"]);
    assert!(listed.status.success() && text(&listed.stdout).contains("points"), "{listed:?}");
    let refused = without(&["grid", "convert", "box.obj", "-o", "box.vdb", "--voxel", "0.1"]);
    assert!(refused.status.code() == Some(1) && text(&refused.stderr).contains("relievo-openvdb"), "{refused:?}");
}
