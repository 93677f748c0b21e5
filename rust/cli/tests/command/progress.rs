//! Calls that take over a second show a bar on a terminal, which `script` of util-linux is to them, and none elsewhere.

use std::fmt::Write;
use std::path::Path;
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

/// Runs a command on a terminal; returns what that shows.
fn on_terminal(folder: &Path, arguments: &[&str]) -> String {
    let line = format!("'{}' {}", env!("CARGO_BIN_EXE_relievo"), arguments.join(" "));
    let shown = Command::new("script")
        .args(["--quiet", "--return", "--command", &line, "/dev/null"])
        .current_dir(folder)
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let terminal = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(shown.status.success(), "{terminal}");
    terminal
}

#[test]
fn calls_of_over_a_second_show_a_bar_on_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("waves.obj", &waves(700));
    write("few.obj", &waves(300));
    write("many.obj", &waves(1000));
    write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    write(
        "list.toml",
        "version = 1\n[[strokes]]\nradius = 0.3\nsculpt = \"draw\"\nheight = 0.1\n\
         points = [{ position = [0.5, 0.5, 0] }]\n",
    );
    let stroke = ["doc", "stroke", "square.obj", "list.toml", "-o", "square.relievo"];
    assert!(relievo(folder.path(), &stroke).status.success());
    // A bake has as many threads as the machine. Four times the samples take as long on four times the threads.
    let threads = std::thread::available_parallelism().map_or(1.0, |threads| threads.get() as f64);
    let samples = (2.0 * (threads / 2.0).sqrt()).ceil().clamp(2.0, 8.0).to_string();
    let map = ["square.relievo", "square.obj", "-o", "map.exr", "--bake", "displacement"];
    let commands: [&[&str]; 4] = [
        &["progressive", "build", "waves.obj", "-o", "waves.rlvpm", "--threads", "1"],
        &["mesh", "simplify", "few.obj", "-o", "less.obj", "--error", "1", "--threads", "1"],
        &["doc", "stroke", "many.obj", "list.toml", "-o", "many.relievo", "--threads", "1"],
        &[&["doc", "export"][..], &map, &["--samples", &samples]].concat(),
    ];
    for command in commands {
        let terminal = on_terminal(folder.path(), command);
        assert!(terminal.contains('█') && terminal.contains("%, "), "{command:?}: {terminal}");
    }
    let elsewhere = relievo(folder.path(), commands[0]);
    assert!(elsewhere.status.success() && elsewhere.stderr.is_empty(), "{elsewhere:?}");
}
