//! `relievo view` in a window on a display without a screen, played by a script: a model is turned, painted and sculpted by
//! drags of the mouse, undone and saved. The model is made here.
#![cfg(feature = "view")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use relievo_document::Document;
use relievo_render::{Image, Picture};

/// Whether there are a display server and a graphics device; where they are required, it fails without them.
fn is_possible() -> bool {
    let is_there = Command::new("xvfb-run").arg("--help").output().is_ok() && !relievo_gpu::adapters().is_empty();
    let is_required = std::env::var_os("RELIEVO_GPU_TESTS").is_some_and(|it| it == "required");
    assert!(is_there || !is_required, "there is no Xvfb or no graphics device");
    if !is_there {
        println!("skipped: there is no Xvfb or no graphics device");
    }
    is_there
}

/// A ball of six quads that are divided until they are round.
fn ball(path: &Path) {
    const SIDES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::new();
    for corner in 0..8 {
        let at = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
        writeln!(text, "v {} {} {}", at(0), at(1), at(2)).unwrap();
    }
    for side in SIDES {
        let [a, b, c, d] = side.map(|at| at + 1);
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

fn view(folder: &Path, script: &str) -> String {
    std::fs::write(folder.join("script.txt"), script).unwrap();
    let mut command = Command::new("xvfb-run");
    command.args(["--auto-servernum", "--server-args", "-screen 0 1440x860x24", "timeout", "60"]);
    command.arg(env!("CARGO_BIN_EXE_relievo")).args([
        "view",
        "ball.obj",
        "--cells",
        "32",
        "--script",
        "script.txt",
        "--costs",
    ]);
    let done = command.current_dir(folder).env_remove("WAYLAND_DISPLAY").output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

fn read(path: PathBuf) -> Image {
    Picture::read(&path, 1 << 30).unwrap().color
}

/// Returns the share of a part of a picture's pixels, in shares of its width and height, that a test of their colour holds for.
fn share(image: &Image, [left, top, right, bottom]: [f32; 4], test: impl Fn([f32; 3]) -> bool) -> f64 {
    let [width, height] = [image.width(), image.height()];
    let columns = (left * width as f32) as u32..(right * width as f32) as u32;
    let rows = (top * height as f32) as u32..(bottom * height as f32) as u32;
    let count = columns.len() * rows.len();
    let found = rows.flat_map(|y| columns.clone().map(move |x| (x, y))).filter(|(x, y)| test(image.color(*x, *y)));
    found.count() as f64 / count as f64
}

/// The share of the middle of two pictures that differs.
fn difference(a: &Image, b: &Image) -> f64 {
    let [width, height] = [a.width(), a.height()];
    let columns = width / 4..width / 10 * 7;
    let count = columns.len() as f64 * f64::from(height);
    let differs = |(x, y): &(u32, u32)| a.color(*x, *y).iter().zip(b.color(*x, *y)).any(|(a, b)| (a - b).abs() > 0.02);
    (0..height).flat_map(|y| columns.clone().map(move |x| (x, y))).filter(differs).count() as f64 / count
}

#[test]
fn a_ball_is_turned_sculpted_painted_undone_and_saved() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ball(&folder.join("ball.obj"));
    let script = "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\npoint 0.02 0.02\nscreenshot before.png\n\
        drag left 0.42 0.4 0.58 0.4\npoint 0.02 0.02\nscreenshot drawn.png\n\
        drag ctrl+left 0.42 0.6 0.58 0.6\npress paint mix\ndrag left 0.42 0.5 0.58 0.5\n\
        point 0.5 0.5\nwait_frames 2\nscreenshot painted.png\n\
        drag middle 0.4 0.5 0.6 0.6\npoint 0.02 0.02\nwait_frames 1\nscreenshot turned.png\n\
        key 1\npoint 0.02 0.02\nkey ctrl+z\nkey ctrl+z\nwait_frames 2\nscreenshot undone.png\nkey ctrl+shift+z\nkey ctrl+shift+z\n\
        key w\nresize 800 560\nwait_frames 2\nscreenshot resized.png\nkey ctrl+s\nwait_frames 2\nquit\n";
    let printed = view(folder, script);
    if let Some(kept) = std::env::var_os("RELIEVO_SCREENSHOTS") {
        for name in ["before", "drawn", "painted", "turned", "undone", "resized"] {
            std::fs::copy(folder.join(format!("{name}.png")), Path::new(&kept).join(format!("model_{name}.png")))
                .unwrap();
        }
    }
    let [before, drawn, painted, turned, undone, resized] =
        ["before", "drawn", "painted", "turned", "undone", "resized"]
            .map(|name| read(folder.join(format!("{name}.png"))));
    // A ridge changes a strip of the ball, the turn all of it; two edits are undone to the pixel, but for the lists beside.
    assert!((0.01..0.2).contains(&difference(&before, &drawn)), "{}", difference(&before, &drawn));
    assert!(difference(&painted, &turned) > 0.1);
    assert_eq!(difference(&drawn, &undone), 0.0);
    let middle = [0.35, 0.3, 0.65, 0.7];
    let is_red = |[r, g, b]: [f32; 3]| r > 0.1 && r > 4.0 * g && r > 4.0 * b;
    assert!(share(&drawn, middle, is_red) < 1e-4 && share(&painted, middle, is_red) > 0.02);
    assert!((resized.width(), resized.height()) == (800, 560) && share(&resized, middle, is_red) > 0.01);
    // Three strokes made events, and the document has them.
    let document = Document::open(&folder.join("ball.relievo"), 1 << 30).unwrap();
    assert!(document.layers().iter().filter(|layer| !layer.blocks().is_empty()).count() >= 2);
    assert!(!folder.join("ball.autosave.relievo").exists());
    assert!(printed.starts_with("brush events: ") && !printed.starts_with("brush events: 0"), "{printed}");
}

#[test]
fn without_a_display_or_a_sound_file_the_command_says_so() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    ball(&folder.path().join("ball.obj"));
    let said = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relievo"));
        command.arg("view").args(arguments).current_dir(folder.path());
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(name);
        }
        let done = command.output().unwrap();
        assert_eq!(done.status.code(), Some(1));
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let display = said(&["ball.obj"]);
    assert!(display.contains("no window can be opened") && display.contains("relievo doc stroke"), "{display}");
    let missing = said(&["nothing.relievo"]);
    assert!(missing.contains("no mesh of the same name"), "{missing}");
    let second = said(&["ball.obj", "ball.obj"]);
    assert!(second.contains("name a document, then its mesh"), "{second}");
}
