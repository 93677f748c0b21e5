//! Strips along curves on surfaces.

use relievo_core::Mesh;
use relievo_core::progress::Silent;
use relievo_decal::{Decal, DecalSettings, Place, Sticker, Strip, lay, strip};

use crate::sheets::{on_sheet, sheet};

const COUNT: u32 = 60;

fn laid(mesh: &Mesh, sticker: &Sticker, curve: &[Place]) -> (Strip, Decal) {
    let strip = strip(mesh, sticker, curve).unwrap_or_else(|error| panic!("{error}"));
    let decal = lay(mesh, sticker, &strip.pins, None, &DecalSettings::default(), &mut Silent);
    let decal = decal.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(decal.quality.flips, 0);
    assert!(decal.is_disk().expect("a manifold"));
    (strip, decal)
}

#[test]
fn a_helix_on_a_cylinder_is_straight() {
    let turn = 4.0;
    let mesh = sheet(COUNT, |u, v| [(turn * u).sin() / turn, v, (turn * u).cos() / turn]);
    let sticker = Sticker::whole([600, 60]).expect("a sticker");
    let (strip, decal) = laid(&mesh, &sticker, &[on_sheet(COUNT, 0.15, 0.3), on_sheet(COUNT, 0.85, 0.7)]);
    // The quads of the sheet are chords of the cylinder.
    let chord = 2.0 * (0.5 * turn / f64::from(COUNT)).sin() / turn * f64::from(COUNT);
    let expected = (0.7 * chord).hypot(0.4);
    assert!((strip.length / expected - 1.0).abs() < 1e-6, "{} {expected}", strip.length);
    assert!((decal.quality.l2 - 1.0).abs() < 1e-3 && decal.quality.coverage > 0.999, "{:?}", decal.quality);
    assert!((decal.scale * strip.length - 1.0).abs() < 1e-3);
    let middles = strip.pins.iter().map(|pin| pin.image[1]);
    assert!(middles.into_iter().all(|y| (y - 30.0).abs() < 1e-9));
    assert!(strip.pins.is_sorted_by(|a, b| a.image[0] < b.image[0]) && strip.pins.len() == 11);
}

#[test]
fn a_strip_follows_a_curve_that_bends() {
    let mesh = sheet(COUNT, |u, v| [u, v, 0.1 * (5.0 * u).sin()]);
    let sticker = Sticker::whole([800, 60]).expect("a sticker");
    let curve: Vec<Place> = (0..=20)
        .map(|step| f64::from(step) / 20.0)
        .map(|share| on_sheet(COUNT, 0.15 + 0.7 * share, 0.5 + 0.15 * (std::f64::consts::TAU * share).sin()))
        .collect();
    let (strip, decal) = laid(&mesh, &sticker, &curve);
    assert!(decal.quality.coverage > 0.99, "{:?}", decal.quality);
    for (pin, vertex) in strip.pins.iter().zip(&decal.pins) {
        let uv = decal.uv[*vertex as usize];
        assert!((uv[0] - pin.image[0] / 800.0).abs() < 1e-6 && (uv[1] - 0.5).abs() < 1e-6, "{pin:?} is at {uv:?}");
    }
}

#[test]
fn curves_that_are_none_are_refused() {
    let mesh = sheet(8, |u, v| [u, v, 0.0]);
    let sticker = Sticker::whole([80, 10]).expect("a sticker");
    let place = on_sheet(8, 0.4, 0.4);
    let nowhere = Place { face: 1 << 20, ..place };
    for (curve, expected) in [
        (vec![], "0 places"),
        (vec![place], "1 places"),
        (vec![place; 600], "600 places"),
        (vec![place, place], "same place"),
        (vec![place, nowhere], "does not exist"),
    ] {
        let error = strip(&mesh, &sticker, &curve).expect_err("no curve").to_string();
        assert!(error.contains(expected), "{error} should contain {expected}");
    }
}
