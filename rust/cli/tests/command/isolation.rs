//! Commands that make the surface of a cage: the default isolation is lowered where it does not fit the memory limit, with
//! a note, and `--isolation` is taken at its word.

use std::fmt::Write;
use std::process::Output;

use crate::{relievo, text};

/// Less than the surface of [`cage`] needs at six levels, and more than at two.
const LIMIT: &str = "40M";

/// Returns a torus of 512 triangles.
fn cage() -> String {
    let mut out = String::new();
    let angle = |at: u32| f64::from(at) / 16.0 * std::f64::consts::TAU;
    for at in 0..256 {
        let (u, v) = (angle(at / 16), angle(at % 16));
        let radius = 2.0 + v.cos();
        writeln!(out, "v {} {} {}", radius * u.cos(), radius * u.sin(), v.sin()).unwrap();
    }
    let place = |u: u32, v: u32| u % 16 * 16 + v % 16 + 1;
    for at in 0..256 {
        let (u, v) = (at / 16, at % 16);
        let [a, b, c, d] = [place(u, v), place(u + 1, v), place(u + 1, v + 1), place(u, v + 1)];
        writeln!(out, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
    }
    out
}

fn said(output: &Output) -> String {
    text(&output.stdout) + &text(&output.stderr)
}

#[test]
fn isolation_is_lowered_with_a_note_or_taken_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cage.obj"), cage()).unwrap();
    let strokes = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.1\nradius = 0.2\n\
                   points = [{ position = [3, 0, 0] }]\n";
    std::fs::write(folder.path().join("list.toml"), strokes).unwrap();
    let picture = ["--device", "cpu", "--size", "32x24", "--samples", "1", "--cells", "2"];
    let commands: [&[&str]; 4] = [
        &["stroke", "cage.obj", "list.toml", "-o", "a.relievo"],
        &[&["draw", "a.relievo", "cage.obj", "-o", "a.png"][..], &picture].concat(),
        &["doc", "transfer", "a.relievo", "cage.obj", "-o", "b.relievo"],
        &["doc", "export", "a.relievo", "cage.obj", "-o", "a.ply", "--cells", "2"],
    ];
    for command in commands {
        let run = |more: &[&str]| relievo(folder.path(), &[command, &["--memory-limit", LIMIT], more].concat());
        let lowered = run(&[]);
        assert!(lowered.status.success(), "{command:?} {lowered:?}");
        assert!(said(&lowered).contains("irregular points are isolated by"), "{command:?} {lowered:?}");
        let coarse = run(&["--isolation", "2"]);
        assert!(coarse.status.success() && !said(&coarse).contains("isolated by"), "{command:?} {coarse:?}");
        let refused = run(&["--isolation", "6"]);
        assert_eq!(refused.status.code(), Some(1), "{command:?} {refused:?}");
        let what = text(&refused.stderr);
        assert!(what.contains("memory limit of 40.0 MB") && what.contains("lower the isolation"), "{what}");
        assert_eq!(relievo(folder.path(), &[command, &["--isolation", "11"]].concat()).status.code(), Some(2));
    }
}

#[test]
fn a_stroke_that_is_refused_is_about_the_mesh_and_no_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cage.obj"), cage()).unwrap();
    let strokes = "version = 1\n[[strokes]]\npoints = [{ position = [3, 0, 0] }]\n";
    std::fs::write(folder.path().join("list.toml"), strokes).unwrap();
    let arguments = ["stroke", "cage.obj", "list.toml", "-o", "a.relievo", "--memory-limit", LIMIT, "--isolation", "6"];
    let refused = relievo(folder.path(), &arguments);
    let what = text(&refused.stderr);
    assert!(refused.status.code() == Some(1) && what.contains("cage.obj"), "{what}");
    // Lines of a list of strokes that nobody wrote.
    for own in ["list.toml", "replayed", "isolation = 6", "[surfaces"] {
        assert!(!what.contains(own), "{own}: {what}");
    }
    assert!(!folder.path().join("a.relievo").exists());
}
