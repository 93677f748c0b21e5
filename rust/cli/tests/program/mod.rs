//! The program, run as its user runs it.
// No test uses all of it.
#![allow(dead_code)]

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a folder and returns what it said.
pub fn relievo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo")).args(arguments).current_dir(folder).output().unwrap()
}

/// Returns the text that bytes are.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs a command that succeeds and returns what it printed.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let done = relievo(folder, arguments);
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    text(&done.stdout)
}

/// Runs a command that fails with the exit code 1 and returns what it said.
pub fn refused(folder: &Path, arguments: &[&str]) -> String {
    let done = relievo(folder, arguments);
    assert_eq!(done.status.code(), Some(1), "{arguments:?}");
    text(&done.stderr)
}

/// Writes a bowl as `bowl.obj` and builds a progressive mesh of it, `bowl.rlvpm`.
pub fn build_bowl(folder: &Path, bowl: &str) {
    std::fs::write(folder.join("bowl.obj"), bowl).unwrap();
    let build = ["progressive", "build", "bowl.obj", "-o", "bowl.rlvpm", "--faces", "50"];
    assert!(relievo(folder, &build).status.success());
}
