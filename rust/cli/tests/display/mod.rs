//! Windows on a display without a screen, played by scripts.
// No test uses all of it.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;

use relievo_render::{Image, Picture};

/// Whether there are a display server and a graphics device; where they are required, it fails without them.
pub fn is_possible() -> bool {
    let is_there = Command::new("xvfb-run").arg("--help").output().is_ok() && !relievo_gpu::adapters().is_empty();
    let is_required = std::env::var_os("RELIEVO_GPU_TESTS").is_some_and(|it| it == "required");
    assert!(is_there || !is_required, "there is no Xvfb or no graphics device");
    if !is_there {
        println!("skipped: there is no Xvfb or no graphics device");
    }
    is_there
}

/// Plays a script in the window of `relievo view` with some arguments, whose preferences are in `config`. Returns what is
/// printed.
pub fn view(folder: &Path, arguments: &[&str], script: &str) -> String {
    std::fs::write(folder.join("script.txt"), script).unwrap();
    let mut command = Command::new("xvfb-run");
    command.args(["--auto-servernum", "--server-args", "-screen 0 1440x860x24", "timeout", "240"]);
    command.arg(env!("CARGO_BIN_EXE_relievo")).arg("view").args(arguments).args(["--script", "script.txt"]);
    command.current_dir(folder).env_remove("WAYLAND_DISPLAY").env("RELIEVO_CONFIG", folder.join("config"));
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// Reads pictures, and copies them where `RELIEVO_SCREENSHOTS` says, to be looked at.
pub fn pictures<const N: usize>(folder: &Path, names: [&str; N]) -> [Image; N] {
    names.map(|name| {
        let path: PathBuf = folder.join(format!("{name}.png"));
        if let Some(kept) = std::env::var_os("RELIEVO_SCREENSHOTS") {
            std::fs::copy(&path, Path::new(&kept).join(format!("view_{}.png", name.replace('/', "_")))).unwrap();
        }
        Picture::read(&path, 1 << 30).unwrap().color
    })
}

/// The share of the middle of two pictures, without the bars above and below, that differs.
pub fn difference(a: &Image, b: &Image) -> f64 {
    let [width, height] = [a.width(), a.height()];
    let (columns, rows) = (width / 4..width / 10 * 7, height / 20..height - height / 10);
    let count = columns.len() as f64 * rows.len() as f64;
    let differs = |(x, y): &(u32, u32)| a.color(*x, *y).iter().zip(b.color(*x, *y)).any(|(a, b)| (a - b).abs() > 0.02);
    rows.flat_map(|y| columns.clone().map(move |x| (x, y))).filter(differs).count() as f64 / count
}

/// Returns the share of a part of a picture's pixels, in shares of its width and height, that a test of their colour holds for.
pub fn share(image: &Image, [left, top, right, bottom]: [f32; 4], test: impl Fn([f32; 3]) -> bool) -> f64 {
    let [width, height] = [image.width(), image.height()];
    let columns = (left * width as f32) as u32..(right * width as f32) as u32;
    let rows = (top * height as f32) as u32..(bottom * height as f32) as u32;
    let count = columns.len() * rows.len();
    let found = rows.flat_map(|y| columns.clone().map(move |x| (x, y))).filter(|(x, y)| test(image.color(*x, *y)));
    found.count() as f64 / count as f64
}
