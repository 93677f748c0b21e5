//! `relievo shader view` in a window on a display without a screen: the two case studies of Mindek et al. 2013, Section 7,
//! played by scripts. The photograph and the two scans are made here.
#![cfg(feature = "view")]

mod display;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use relievo_render::{Image, Picture, write_png};

use display::is_possible;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/shaders")
}

fn view(folder: &Path, project: &str, script: &str) -> Output {
    std::fs::write(folder.join("script.txt"), script).unwrap();
    let mut command = Command::new("xvfb-run");
    command.args(["--auto-servernum", "--server-args", "-screen 0 1440x860x24", "timeout", "240"]);
    command.arg(env!("CARGO_BIN_EXE_relievo")).args(["shader", "view", project, "--script", "script.txt"]);
    command.current_dir(folder).env_remove("WAYLAND_DISPLAY").output().unwrap()
}

fn played(folder: &Path, project: &str, script: &str) {
    let done = view(folder, project, script);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

fn read(path: PathBuf) -> Image {
    Picture::read(&path, 1 << 30).unwrap().color
}

/// Returns the share of a picture's pixels that a test of their colour holds for.
fn share(image: &Image, test: impl Fn([f32; 3]) -> bool) -> f64 {
    let pixels = image.data().chunks_exact(3);
    let count = pixels.len() as f64;
    pixels.filter(|pixel| test([pixel[0], pixel[1], pixel[2]])).count() as f64 / count
}

fn value(image: &Image, x: u32, y: u32) -> f32 {
    image.color(x, y)[0]
}

/// A board with strong edges on a ground with faint stripes.
fn photograph(path: &Path) {
    let mut image = Image::new(160, 120, 3).unwrap();
    for y in 0..120 {
        for x in 0..160 {
            let is_board = (40..120).contains(&x) && (30..90).contains(&y);
            let stripe = if x / 4 % 2 == 0 { 0.05 } else { 0.0 };
            let shade = if is_board { 0.8 } else { 0.2 + stripe };
            image.set_color(x, y, [shade, shade, shade]);
        }
    }
    write_png(path, &image).unwrap();
}

const BILATERAL: &str = "# A board\nversion = 1\nshader = \"bilateral.frag\"\nsize = [160, 120]\nexponent = 4.0\n\n\
    [set]\nradius = [3.0]\nthreshold = [0.3]\n\n[[input]]\nname = \"photo\"\nfile = \"photo.png\"\n";

#[test]
fn edges_are_found_in_a_photograph_and_faults_leave_the_picture() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    photograph(&folder.join("photo.png"));
    std::fs::copy(examples().join("bilateral.frag"), folder.join("bilateral.frag")).unwrap();
    std::fs::write(folder.join("board.toml"), BILATERAL).unwrap();
    let sound = std::fs::read_to_string(folder.join("bilateral.frag")).unwrap();
    std::fs::write(folder.join("faulty.frag"), sound.replace("float total = 0.0;", "float total = zero;")).unwrap();
    let script = "wait_frames 3\nscreenshot before.png\nclick 40 60\nclick 80 30\nright_click 100 60\nright_click 20 20\n\
        wait_frames 2\nscreenshot plots.png\nask 119 60\nwait_frames 2\nscreenshot why.png\npress Save picture\n\
        press Save mask\nkey s\nwait_frames 2\ntext faulty.frag\nwait_frames 3\nscreenshot faulty.png\n\
        text bilateral.frag\nwait_frames 3\npress Variables\nwait_frames 2\nscreenshot variables.png\npress Values\n\
        wait_frames 2\nscreenshot values.png\nquit\n";
    played(folder, "board.toml", script);
    let project = std::fs::read_to_string(folder.join("board.toml")).unwrap();
    assert!(project.starts_with("# A board\n") && project.matches("[[example]]").count() == 4, "{project}");
    assert!(project.contains("shader = \"bilateral.frag\""), "{project}");
    let mask = read(folder.join("board_mask.png"));
    assert!(value(&mask, 119, 60) > 0.8 && value(&mask, 80, 60) < 0.2 && value(&mask, 60, 89) > 0.8);
    // The picture that was saved is the one that the command draws of the project that was saved.
    let run = ["shader", "run", "board.toml", "-o", "again.png"];
    assert!(Command::new(env!("CARGO_BIN_EXE_relievo")).args(run).current_dir(folder).status().unwrap().success());
    assert_eq!(read(folder.join("board.png")).data(), read(folder.join("again.png")).data());
    // Green and orange marks are there after the clicks, and not before.
    let is_green = |[r, g, b]: [f32; 3]| r < 0.05 && (0.25..0.45).contains(&g) && (0.1..0.25).contains(&b);
    let [before, plots, why, faulty] =
        ["before", "plots", "why", "faulty"].map(|name| read(folder.join(format!("{name}.png"))));
    assert!(share(&before, is_green) < 1e-5 && share(&plots, is_green) > 1e-4);
    assert!(share(&plots, |_| true) == 1.0 && why.data() != plots.data());
    // A fault is shown at its line; the picture stays.
    let is_fault = |[r, g, b]: [f32; 3]| (0.1..0.2).contains(&r) && g < 0.03 && b < 0.03;
    assert!(share(&plots, is_fault) < 1e-4 && share(&faulty, is_fault) > 5e-4);
    assert!(share(&faulty, is_green) > 1e-4);
    // A column of numbers stands beside the variables.
    let [variables, values] = ["variables", "values"].map(|name| read(folder.join(format!("{name}.png"))));
    let differ = variables.data().iter().zip(values.data()).filter(|(a, b)| a != b).count();
    assert!(differ > 2000, "{differ}");
    if let Some(kept) = std::env::var_os("RELIEVO_SCREENSHOTS") {
        std::fs::copy(folder.join("plots.png"), Path::new(&kept).join("view_bilateral.png")).unwrap();
        std::fs::copy(folder.join("why.png"), Path::new(&kept).join("view_why.png")).unwrap();
        std::fs::copy(folder.join("values.png"), Path::new(&kept).join("view_values.png")).unwrap();
        std::fs::copy(folder.join("faulty.png"), Path::new(&kept).join("view_fault.png")).unwrap();
    }
}

/// Writes shells as a scan: values of brain, skull and skin by the distance from the middle.
fn scan(path: &Path, [brain, skull, skin]: [u8; 3]) {
    const EDGE: usize = 40;
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, &348_i32.to_le_bytes());
    for (axis, edge) in [3_i16, EDGE as i16, EDGE as i16, EDGE as i16].into_iter().enumerate() {
        put(40 + 2 * axis, &edge.to_le_bytes());
    }
    put(70, &2_i16.to_le_bytes());
    for (at, value) in [(80, 1.0_f32), (84, 1.0), (88, 1.0), (108, 352.0), (112, 1.0)] {
        put(at, &value.to_le_bytes());
    }
    put(344, b"n+1\0");
    for index in 0..EDGE * EDGE * EDGE {
        let at = [index % EDGE, index / EDGE % EDGE, index / EDGE / EDGE].map(|it| it as f32 + 0.5 - 0.5 * EDGE as f32);
        let distance = at.iter().map(|it| it * it).sum::<f32>().sqrt();
        bytes.push(match distance {
            ..11.0 => brain,
            11.0..14.0 => skull,
            14.0..17.0 => skin,
            _ => 0,
        });
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_brain_is_found_in_two_scans() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    scan(&folder.join("mri.nii"), [200, 60, 150]);
    scan(&folder.join("ct.nii"), [90, 250, 80]);
    std::fs::copy(examples().join("dual.wgsl"), folder.join("dual.wgsl")).unwrap();
    let text = std::fs::read_to_string(examples().join("dual.toml")).unwrap().replace(".nii.gz", ".nii");
    let text = text.replace("[640, 480]", "[160, 120]").replace("[300]", "[80]");
    std::fs::write(folder.join("dual.toml"), text).unwrap();
    let script = "wait_frames 3\nclick 80 60\nclick 86 66\nright_click 80 26\nright_click 80 14\nwait_frames 2\n\
        drag 0 1 0.5 0.1 1 0.9\nwait_frames 2\nscreenshot plots.png\npress profile CT\nwait_frames 2\n\
        screenshot profiles.png\npress Diagnosis\nask 84 58\nwait_frames 2\nscreenshot why.png\npress Save mask\nkey s\nquit\n";
    played(folder, "dual.toml", script);
    let mask = read(folder.join("dual_mask.png"));
    assert!(value(&mask, 80, 62) > 0.7 && value(&mask, 80, 30) < 0.3 && value(&mask, 60, 18) < 0.3);
    let is_brushed = |[r, g, b]: [f32; 3]| r > 0.8 && (0.7..0.85).contains(&g) && b < 0.1;
    assert!(share(&read(folder.join("plots.png")), is_brushed) > 1e-4);
    if let Some(kept) = std::env::var_os("RELIEVO_SCREENSHOTS") {
        std::fs::copy(folder.join("plots.png"), Path::new(&kept).join("view_dual.png")).unwrap();
        std::fs::copy(folder.join("profiles.png"), Path::new(&kept).join("view_profiles.png")).unwrap();
        std::fs::copy(folder.join("why.png"), Path::new(&kept).join("view_dual_why.png")).unwrap();
    }
}

#[test]
fn without_a_display_the_command_says_so() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    photograph(&folder.path().join("photo.png"));
    std::fs::copy(examples().join("bilateral.frag"), folder.path().join("bilateral.frag")).unwrap();
    std::fs::write(folder.path().join("board.toml"), BILATERAL).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_relievo"));
    command.args(["shader", "view", "board.toml"]).current_dir(folder.path());
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    let done = command.output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.code() == Some(1) && said.contains("no window can be opened"), "{said}");
}
