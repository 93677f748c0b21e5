//! The module is opened on demand, and its absence is an error with advice. These run in processes of their own, since a
//! module stays open.

use std::process::Command;

use relievo_core::ErrorKind;
use relievo_openvdb::peer::is_available;
use relievo_openvdb::{Grid, Kind, Module, VARIABLE};

fn child(test: &str, module: Option<&str>) {
    let mut command = Command::new(std::env::current_exe().unwrap());
    if let Some(module) = module {
        command.env(VARIABLE, module);
    }
    let done = command.args(["--ignored", "--exact", &format!("opening::{test}")]).output().unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success() && text.contains("1 passed"), "{text}");
}

#[test]
fn without_a_module_an_error_names_the_package() {
    child("child_without_a_module", Some("/nowhere/librelievo_openvdb.so"));
    // A library that is something else.
    child("child_with_another_library", Some("libz.so.1"));
}

#[test]
#[ignore = "run by its parent"]
fn child_without_a_module() {
    let error = Grid::new(Kind::Float, [0.0; 3], 1.0).unwrap_err();
    assert_eq!(error.kind, ErrorKind::NotFound);
    let text = error.to_string();
    assert!(text.contains("relievo-openvdb") && text.contains(VARIABLE) && text.contains("/nowhere/"), "{text}");
    assert!(!Module::is_open());
}

#[test]
#[ignore = "run by its parent"]
fn child_with_another_library() {
    assert_eq!(Module::open().err().map(|error| error.kind), Some(ErrorKind::Unsupported));
}

#[test]
fn opening_starts_no_thread() {
    if is_available() {
        child("child_counts_threads", None);
    }
}

#[test]
#[ignore = "run by its parent"]
fn child_counts_threads() {
    let threads = || std::fs::read_dir("/proc/self/task").unwrap().count();
    let before = threads();
    assert!(!Module::is_open());
    let grid = crate::shapes::level_set([0.0; 3], [1.0; 3], 0.05);
    assert!(Module::is_open() && Module::open().unwrap().library_version()[0] >= 10);
    assert!(crate::shapes::inside(&grid, 0.0) > 0.9);
    // Counting voxels, copying and freeing are parallel in OpenVDB.
    assert!(grid.copy().unwrap().info().unwrap().active_voxels > 1000);
    drop(grid);
    assert_eq!(threads(), before);
}
