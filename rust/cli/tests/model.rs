//! `relievo view` in a window on a display without a screen, played by a script: a model is turned, painted and sculpted by
//! drags of the mouse, undone and saved. The model is made here.
#![cfg(feature = "view")]

mod display;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use relievo_document::Document;
use relievo_render::{Image, write_png};

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
    assert!(printed.contains("\nframes: ") && printed.contains("\nfirst picture: after "), "{printed}");
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

/// An image of blue to the left and green to the right.
fn flag(path: &Path) {
    let mut image = Image::new(64, 64, 3).unwrap();
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        image.set_color(x, y, if x < 32 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] });
    }
    write_png(path, &image).unwrap();
}

/// Makes a folder with a ball, a flag and preferences.
fn folder_of_ball(preferences: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    ball(&folder.path().join("ball.obj"));
    flag(&folder.path().join("flag.png"));
    std::fs::create_dir(folder.path().join("config")).unwrap();
    std::fs::write(folder.path().join("config/view.txt"), preferences).unwrap();
    folder
}

fn is_blue([r, g, b]: [f32; 3]) -> bool {
    b > 0.1 && b > 4.0 * r && b > 4.0 * g
}

fn is_green([r, g, b]: [f32; 3]) -> bool {
    g > 0.1 && g > 4.0 * r && g > 4.0 * b
}

#[test]
fn a_dropped_image_is_the_stamp_of_the_brush() {
    if !is_possible() {
        return;
    }
    let kept = "brush.tool paint mix\nbrush.size 3\nbrush.strength 1\nbrush.color 1 1 1\n";
    let folder = folder_of_ball(kept);
    let folder = folder.path();
    let whole = std::fs::read(folder.join("flag.png")).unwrap();
    std::fs::write(folder.join("cut.png"), &whole[..whole.len() / 2]).unwrap();
    let script = "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\npoint 0.02 0.02\ndrop cut.png\nscreenshot refused.png\n\
        drop flag.png\ndrag left 0.5 0.5 0.5 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot stamped.png\n\
        press remove stamp\nkey ctrl+z\npoint 0.02 0.02\nwait_frames 2\nscreenshot undone.png\n\
        drag left 0.5 0.5 0.5 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot plain.png\nquit\n";
    view(folder, &["ball.obj", "--cells", "32"], script);
    let [refused, stamped, undone, plain] = pictures(folder, ["refused", "stamped", "undone", "plain"]);
    let middle = [0.36, 0.3, 0.56, 0.7];
    let colored = |image: &Image| [share(image, middle, is_blue), share(image, middle, is_green)];
    // Half of the dab is of each colour of the image, and none without it.
    let [blue, green] = colored(&stamped);
    assert!(blue > 0.02 && green > 0.02 && (0.5..2.0).contains(&(blue / green)), "{blue} {green}");
    assert!([&refused, &undone, &plain].iter().all(|image| colored(image) == [0.0; 2]));
    assert!(difference(&undone, &plain) > 0.01);
    // The line at the bottom names the damaged file in the colour of faults.
    let is_fault = |[r, g, b]: [f32; 3]| r > 0.5 && (0.15..0.4).contains(&g) && b < 0.2;
    assert!(share(&refused, [0.0, 0.95, 0.5, 1.0], is_fault) > 0.005);
    // `--stamp` does what dropping it does. Nothing of the first window is to be recovered.
    std::fs::remove_file(folder.join("ball.autosave.relievo")).unwrap();
    let script = "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\ndrag left 0.5 0.5 0.5 0.5\npoint 0.02 0.02\nwait_frames 2\n\
        screenshot given.png\nquit\n";
    view(folder, &["ball.obj", "--cells", "32", "--stamp", "flag.png"], script);
    let [given] = pictures(folder, ["given"]);
    assert_eq!(colored(&given), [blue, green]);
}

#[test]
fn a_pen_paints_as_hard_as_it_presses_and_wider_where_it_leans() {
    if !is_possible() {
        return;
    }
    let folder = folder_of_ball("brush.tool paint mix\nbrush.strength 1\nbrush.color 0 0 1\nbrush.falloff constant\n");
    let folder = folder.path();
    let dab = |pen: &str, name: &str| {
        format!("{pen}\ndrag left 0.5 0.5 0.5 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot {name}.png\nkey ctrl+z\n")
    };
    let script = format!(
        "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\n{}{}{}{}quit\n",
        dab("wait_frames 1", "mouse"),
        dab("pen 0.3 30", "light"),
        dab("pen 1 30", "hard"),
        dab("pen 1 70", "flat")
    );
    view(folder, &["ball.obj", "--cells", "32"], &script);
    let [mouse, light, hard, flat] = pictures(folder, ["mouse", "light", "hard", "flat"]);
    let middle = [0.35, 0.3, 0.65, 0.7];
    let size = |image: &Image| share(image, middle, |[r, _, b]| b > 0.2 && b > 1.1 * r);
    // A pen that stands and presses fully is as a mouse; one that presses less leaves more of the grey.
    assert_eq!(difference(&mouse, &hard), 0.0);
    assert!(share(&hard, middle, is_blue) > 0.01 && share(&light, middle, is_blue) < 1e-4);
    assert!((0.8..1.2).contains(&(size(&light) / size(&hard))), "{} {}", size(&light), size(&hard));
    // Flat it is twice as wide.
    assert!((3.2..4.8).contains(&(size(&flat) / size(&hard))), "{} {}", size(&flat), size(&hard));
}

#[test]
fn an_image_is_laid_by_its_pins_written_and_undone() {
    if !is_possible() {
        return;
    }
    let folder = folder_of_ball("brush.size 3\n");
    let folder = folder.path();
    let script = "resize 1000 620\nwait_frames 1\nkey 1\nwait_frames 2\npoint 0.02 0.02\nscreenshot before.png\n\
        press decal\ndrop flag.png\ndrag left 0.5 0.5 0.5 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot laid.png\n\
        drag left 0.45 0.5 0.45 0.5\ndrag left 0.55 0.5 0.55 0.5\npoint 0.02 0.02\nwait_frames 2\nscreenshot pins.png\n\
        drag left 0.55 0.5 0.58 0.42\npoint 0.02 0.02\nwait_frames 2\nscreenshot dragged.png\n\
        key Delete\npress pin 2\nkey Delete\nwait_frames 2\nscreenshot removed.png\n\
        key Enter\nwait_frames 2\nscreenshot written.png\nkey ctrl+z\nwait_frames 2\nscreenshot undone.png\n\
        key ctrl+shift+z\nwait_frames 2\nkey ctrl+s\nwait_frames 2\nquit\n";
    view(folder, &["ball.obj", "--cells", "32"], script);
    let names = ["before", "laid", "pins", "dragged", "removed", "written", "undone"];
    let [before, laid, pins, dragged, removed, written, undone] = pictures(folder, names);
    let middle = [0.36, 0.3, 0.56, 0.7];
    let colored = |image: &Image| [share(image, middle, is_blue), share(image, middle, is_green)];
    assert!(colored(&before) == [0.0; 2] && difference(&before, &undone) == 0.0);
    let [blue, green] = colored(&laid);
    assert!(blue > 0.02 && green > 0.02 && (0.7..1.4).contains(&(blue / green)), "{blue} {green}");
    // Two more pins change little until one of them is dragged, which pulls the green half along.
    assert!(difference(&laid, &pins) < 0.03 && difference(&pins, &dragged) > 0.04);
    assert!(colored(&removed).iter().zip([blue, green]).all(|(it, was)| (0.8..1.25).contains(&(it / was))));
    // What is written is what was shown.
    let [new_blue, new_green] = colored(&written);
    assert!((0.8..1.25).contains(&(new_blue / blue)) && (0.8..1.25).contains(&(new_green / green)));
    let document = Document::open(&folder.join("ball.relievo"), 1 << 30).unwrap();
    assert!(document.layers().iter().any(|layer| !layer.blocks().is_empty()));
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
