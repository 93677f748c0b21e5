//! What laying a sticker takes of the memory of a process of its own.

#![cfg(target_os = "linux")]

use relievo_core::Mesh;
use relievo_core::progress::Silent;
use relievo_decal::{DecalSettings, Pin, Placement, Sticker, nearest};

/// Squares along each side of the sheet.
const SIDE: u32 = 200;
/// Bytes for each triangle of the patch, with the surface around it.
const MAX: f64 = 350.0;

/// Bytes that the process has, or had at most.
fn memory(what: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux says it");
    let line = status.lines().find_map(|line| line.strip_prefix(what)).expect("Linux says it");
    let number = line.trim_start_matches(':').trim().trim_end_matches("kB").trim();
    1024.0 * number.parse::<f64>().expect("a number")
}

fn sheet(u: f64, v: f64) -> [f64; 3] {
    [u, v, 0.1 * (7.0 * u).sin() * (5.0 * v).cos()]
}

/// Lays a sticker over a sheet of `side` squares along each side, and returns its triangles and the bytes that they took.
fn lay(side: u32) -> (u64, f64) {
    let place = |index: u32| f64::from(index) / f64::from(side);
    let points = (0..=side).flat_map(|row| (0..=side).map(move |column| sheet(place(column), place(row))));
    let points = points.map(|point| point.map(|value| value as f32)).collect();
    let squares = (0..side).flat_map(|row| (0..side).map(move |column| row * (side + 1) + column));
    let triangles = squares.flat_map(|first| {
        let above = first + side + 1;
        [[first, first + 1, above + 1], [first, above + 1, above]]
    });
    let mesh = Mesh::from_triangles(points, &triangles.collect::<Vec<_>>());
    let pin = |[x, y]: [f64; 2]| Pin {
        image: [x, y],
        place: nearest(&mesh, sheet(0.1 + 0.008 * x, 0.1 + 0.008 * y)).expect("a place").0,
    };
    let pins = [[20.0, 20.0], [80.0, 25.0], [75.0, 80.0], [25.0, 75.0]].map(pin);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let before = memory("VmRSS");
    let settings = DecalSettings::default();
    let placed = Placement::new(&mesh, &sticker, &pins, None, &settings, &mut Silent).expect("a decal");
    (placed.decal().quality.triangles as u64, memory("VmHWM") - before)
}

#[test]
fn a_sticker_takes_few_bytes_for_each_of_its_triangles() {
    // The pages of the program itself are read at first use, as many at a time as the system likes.
    lay(SIDE / 8);
    let (count, bytes) = lay(SIDE);
    assert!(count > 50_000, "{count}");
    assert!(bytes / count as f64 <= MAX, "{} bytes for each of {count} triangles", bytes / count as f64);
}
