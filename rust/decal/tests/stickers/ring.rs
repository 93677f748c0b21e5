//! A sticker shaped like the letter C around the middle of a sheet that is curved like a saddle (Figure 10 of the paper).

use relievo_decal::{DecalSettings, Pin, Quality, Sticker, nearest};

use crate::disks::lay_as_disk;
use crate::sheets::{sheet, turns};

/// The point of the sheet over a point of the plane.
fn lift(x: f64, y: f64) -> [f64; 3] {
    let (radius, turn) = (x.hypot(y), y.atan2(x));
    [x, y, 0.42 * radius * radius * (3.0 * turn).cos()]
}

/// The point of the image at a distance from its middle in pixels, in a direction in degrees.
fn around(radius: f64, turn: f64) -> [f64; 2] {
    let (sin, cos) = turn.to_radians().sin_cos();
    [300.0 + radius * cos, 300.0 + radius * sin]
}

#[test]
fn a_letter_goes_around_the_middle_of_a_saddle_on_sheets_of_any_fineness() {
    let turn = |step: i32| 170.0 * f64::from(step) / 60.0;
    let outer = (-60..=60).map(|step| around(285.0, turn(step)));
    let inner = (-60..=60).rev().map(|step| around(130.0, turn(step)));
    let sticker = Sticker::new([600, 600], outer.chain(inner).collect()).expect("a sticker");
    for side in [48, 56, 80] {
        let mesh = sheet(side, |u, v| lift(2.4 * u - 1.2, 2.4 * v - 1.2));
        let pin = |index: u32| {
            let image = around(207.5, 38.75 * f64::from(index) - 155.0).map(f64::round);
            let [x, y] = image.map(|value| (value - 300.0) * 1.05 / 285.0);
            Pin { image, place: nearest(&mesh, lift(x, y)).expect("a place").0 }
        };
        let pins: Vec<Pin> = (0..9).map(pin).collect();
        let decal = lay_as_disk(&mesh, &sticker, &pins, None, &DecalSettings::default());
        let decal = decal.unwrap_or_else(|error| panic!("{side} squares: {error}"));
        let Quality { flips, turned_twice, coverage, doubled, l2, .. } = decal.quality;
        assert_eq!((flips, turned_twice), (0, 0), "{side} squares");
        assert!((turns(&decal.triangles, &decal.uv) - 1.0).abs() < 1e-6, "{side} squares");
        assert!(coverage > 0.999 && doubled < 0.001 && l2 < 1.02, "{side} squares: {:?}", decal.quality);
    }
}
