//! `relievo view` in a window on a display without a screen, played by a script: a model is turned, painted and sculpted by
//! drags of the mouse, undone and saved. The model is made here.
#![cfg(feature = "view")]

mod display;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use relievo_document::Document;

use display::{difference, is_possible, pictures, share, view};

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
    let printed = view(folder, &["ball.obj", "--cells", "32", "--costs"], script);
    let [before, drawn, painted, turned, undone, resized] =
        pictures(folder, ["before", "drawn", "painted", "turned", "undone", "resized"]);
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
fn a_tool_is_pressed_in_colours_stand_for_tiles_and_preferences_stay() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ball(&folder.join("ball.obj"));
    std::fs::rename(folder.join("ball.obj"), folder.join("cube.obj")).unwrap();
    ball(&folder.join("ball.obj"));
    let script = "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\npoint 0.02 0.02\nscreenshot before.png\n\
        press press cube\ndrag left 0.46 0.5 0.54 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot pressed.png\n\
        key ctrl+z\nwait_frames 2\nscreenshot lifted.png\nkey ctrl+shift+z\npress show tiles\nwait_frames 1\n\
        screenshot tiles.png\npress show paint\nkey r\nrest\nscreenshot rays.png\nkey x\nwait_frames 1\nquit\n";
    view(folder, &["ball.obj", "--cells", "32", "--tool", "cube.obj"], script);
    let names = ["before", "pressed", "lifted", "tiles", "rays"];
    let [before, pressed, lifted, tiles, rays] = pictures(folder, names);
    assert!((0.003..0.2).contains(&difference(&before, &pressed)), "{}", difference(&before, &pressed));
    assert_eq!(difference(&before, &lifted), 0.0);
    // All faces of the ball are large, so the ones that were pressed fill what is seen: orange, the rest is grey.
    let middle = [0.35, 0.3, 0.65, 0.7];
    let is_orange = |[r, g, b]: [f32; 3]| r > 1.3 * g && g > 3.0 * b;
    assert!(share(&pressed, middle, is_orange) < 1e-3 && share(&tiles, middle, is_orange) > 0.1);
    // The caster's picture has shadows and another light; where the ball is, it is as grey as before.
    assert!(difference(&pressed, &rays) > 0.1);
    assert!(share(&rays, [0.45, 0.3, 0.55, 0.4], |[r, g, b]| r > 0.05 && (r - b).abs() < 0.2 * r && g > 0.05) > 0.9);
    let config = folder.join("config/view.txt");
    let text = std::fs::read_to_string(&config).unwrap();
    assert!(text.contains("brush.symmetry true") && text.contains("view.rays true"), "{text}");
    // A file that is damaged is as good as none, and is written anew.
    std::fs::write(&config, [0xff, 0xfe, b'\n', 0, b'v', b'i']).unwrap();
    view(folder, &["ball.obj", "--cells", "8"], "wait_frames 1\nquit\n");
    assert!(std::fs::read_to_string(&config).unwrap().contains("view.rays false"));
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
