//! Calls that take over a second show a bar on a terminal, which `script` of util-linux is to them, and none elsewhere.

use std::fmt::Write;
use std::process::{Command, Stdio};

use super::relievo;

/// A grid of quads with waves, so that no call is done within a second.
fn waves(side: usize) -> String {
    let mut mesh = String::new();
    for (x, y) in (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y))) {
        let height = (0.3 * x as f64).sin() * (0.2 * y as f64).cos();
        writeln!(mesh, "v {x} {y} {height}").unwrap();
    }
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let first = y * (side + 1) + x + 1;
        writeln!(mesh, "f {first} {} {} {}", first + 1, first + side + 2, first + side + 1).unwrap();
    }
    mesh
}

#[test]
fn calls_of_over_a_second_show_a_bar_on_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("waves.obj"), waves(700)).unwrap();
    let build = ["progressive", "build", "waves.obj", "-o", "waves.rlvpm"];
    let line = format!("'{}' {}", env!("CARGO_BIN_EXE_relievo"), build.join(" "));
    let shown = Command::new("script")
        .args(["--quiet", "--return", "--command", &line, "/dev/null"])
        .current_dir(folder.path())
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let terminal = String::from_utf8_lossy(&shown.stdout);
    assert!(shown.status.success(), "{terminal}");
    assert!(terminal.contains('█') && terminal.contains("%, "), "{terminal}");
    let elsewhere = relievo(folder.path(), &build);
    assert!(elsewhere.status.success() && elsewhere.stderr.is_empty(), "{elsewhere:?}");
}
