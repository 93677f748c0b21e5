//! Commands that make the surface of a cage: the default isolation is lowered where it does not fit the memory limit, with
//! a note, and `--isolation` is taken at its word.

use std::fmt::Write;
use std::process::Output;

use crate::{relievo, text};

/// Less than the surface of [`cage`] needs at six levels, and more than at two.
const LIMIT: &str = "50M";

/// A dab on its outside.
const STROKES: &str = "version = 1\n[[strokes]]\nsculpt = \"draw\"\nheight = 0.1\nradius = 0.2\n\
                       points = [{ position = [3, 0, 0] }]\n";

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
    std::fs::write(folder.path().join("list.toml"), STROKES).unwrap();
    let picture = ["--device", "cpu", "--size", "32x24", "--samples", "1", "--cells", "2"];
    let commands: [&[&str]; 4] = [
        &["doc", "stroke", "cage.obj", "list.toml", "-o", "a.relievo"],
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
        assert!(what.contains("memory limit of 52.4 MB") && what.contains("lower the isolation"), "{what}");
        assert_eq!(relievo(folder.path(), &[command, &["--isolation", "11"]].concat()).status.code(), Some(2));
    }
}

#[test]
fn what_a_stroke_says_is_about_the_mesh_and_no_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cage.obj"), cage()).unwrap();
    std::fs::write(folder.path().join("list.toml"), STROKES).unwrap();
    let stroke = ["doc", "stroke", "cage.obj", "list.toml", "-o", "a.relievo", "--memory-limit", LIMIT];
    let refused = relievo(folder.path(), &[&stroke[..], &["--isolation", "6"]].concat());
    let lowered = relievo(folder.path(), &stroke);
    assert_eq!((refused.status.code(), lowered.status.code()), (Some(1), Some(0)), "{refused:?} {lowered:?}");
    for what in [text(&refused.stderr), text(&lowered.stderr)] {
        assert!(what.contains("cage.obj: "), "{what}");
        // Words of a scene around the list, which nobody wrote.
        for word in ["list.toml", "replayed", "isolation = 6", "[surfaces"] {
            assert!(!what.contains(word), "{word}: {what}");
        }
    }
}
