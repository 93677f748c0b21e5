//! Input that cannot be used: every answer is an error that names the pin or the face, or a decal without flips.

use crate::sheets::{on_sheet, sheet};
use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Mesh, Result};
use relievo_decal::{Decal, DecalSettings, Pin, Place, Pose, Sticker, lay, nearest};

fn whole() -> Sticker {
    Sticker::whole([100, 100]).expect("a sticker")
}

fn pin(image: [f64; 2], u: f64, v: f64) -> Pin {
    Pin { image, place: on_sheet(8, u, v) }
}

fn on(mesh: &Mesh, pins: &[Pin]) -> Result<Decal> {
    lay(mesh, &whole(), pins, None, &DecalSettings::default(), &mut Silent)
}

fn refused(mesh: &Mesh, pins: &[Pin], expected: &[&str]) {
    let error = on(mesh, pins).expect_err("unusable").to_string();
    for word in expected {
        assert!(error.contains(word), "{error} should contain {word}");
    }
}

#[test]
fn unusable_pins_are_named() {
    let plane = sheet(8, |u, v| [u, v, 0.0]);
    let good = [pin([20.0, 20.0], 0.2, 0.2), pin([80.0, 20.0], 0.8, 0.2), pin([50.0, 80.0], 0.5, 0.8)];
    assert!(on(&plane, &good).is_ok());
    refused(&plane, &[], &["no pins"]);
    refused(&plane, &good[..1], &["a pose"]);
    let with = |change: &dyn Fn(&mut Pin)| {
        let mut pins = good;
        change(&mut pins[2]);
        pins
    };
    refused(&plane, &with(&|pin| pin.place = good[1].place), &["pin 2", "pin 1", "same place"]);
    refused(&plane, &with(&|pin| pin.image = good[1].image), &["pin 2", "pin 1"]);
    refused(&plane, &with(&|pin| pin.image = [50.0, 101.0]), &["pin 2", "outside"]);
    refused(&plane, &with(&|pin| pin.image[0] = f64::NAN), &["pin 2", "finite"]);
    refused(&plane, &with(&|pin| pin.place.face = 128), &["pin 2", "face 128"]);
    refused(&plane, &with(&|pin| pin.place.barycentric = [f64::NAN; 3]), &["pin 2", "weights"]);
    refused(&plane, &with(&|pin| pin.place.barycentric = [2.0, -1.0, 0.0]), &["pin 2", "weights"]);
}

#[test]
fn pins_on_two_components_are_named() {
    let mut mesh = sheet(8, |u, v| [u, v, 0.0]);
    let other = sheet(8, |u, v| [u, v, 1.0]);
    let count = mesh.points.len() as u32;
    mesh.points.extend(&other.points);
    mesh.corners.extend(other.corners.iter().map(|corner| corner + count));
    mesh.face_sizes.extend(&other.face_sizes);
    let mut pins = [pin([20.0, 20.0], 0.2, 0.2), pin([80.0, 20.0], 0.8, 0.2)];
    pins[1].place.face += 128;
    refused(&mesh, &pins, &["pins 0 and 1", "components"]);
}

#[test]
fn mirrored_pins_fold_the_sticker_and_are_named() {
    let plane = sheet(8, |u, v| [u, v, 0.0]);
    let pins = [
        pin([20.0, 20.0], 0.8, 0.2),
        pin([80.0, 20.0], 0.2, 0.2),
        pin([80.0, 80.0], 0.2, 0.8),
        pin([20.0, 80.0], 0.8, 0.8),
    ];
    refused(&plane, &pins, &["pin"]);
}

#[test]
fn poses_and_images_are_checked() {
    let plane = sheet(8, |u, v| [u, v, 0.0]);
    let pins = [pin([50.0, 50.0], 0.5, 0.5)];
    let posed = |width: f64, up: [f64; 3]| {
        lay(&plane, &whole(), &pins, Some(Pose { width, up }), &DecalSettings::default(), &mut Silent)
    };
    assert!(posed(0.5, [0.0, 1.0, 0.0]).is_ok());
    for (width, up) in
        [(0.0, [0.0, 1.0, 0.0]), (f64::NAN, [0.0, 1.0, 0.0]), (0.5, [0.0, 0.0, 1.0]), (0.5, [f64::NAN; 3])]
    {
        assert!(posed(width, up).expect_err("unusable").to_string().contains("pose"));
    }
    assert!(Sticker::whole([0, 10]).is_err() && Sticker::whole([60_000, 60_000]).is_err());
    let mut quads = sheet(2, |u, v| [u, v, 0.0]);
    quads = Mesh::new(quads.points, vec![4], vec![0, 1, 4, 3]);
    assert!(on(&quads, &pins).expect_err("a quad").to_string().contains("triangulate"));
}

#[test]
fn holes_degenerate_doubled_and_third_faces_give_an_answer() {
    let sound = sheet(8, |u, v| [u, v, 0.1 * (3.0 * u).sin()]);
    let pins = [pin([20.0, 20.0], 0.21, 0.22), pin([80.0, 20.0], 0.8, 0.2), pin([50.0, 80.0], 0.5, 0.8)];
    let mut hole = sound.clone();
    hole.corners.drain(3 * 72..3 * 74);
    hole.face_sizes.truncate(126);
    let mut degenerate = sound.clone();
    degenerate.points[40] = degenerate.points[41];
    let mut doubled = sound.clone();
    doubled.corners.extend_from_slice(&sound.corners[3 * 60..3 * 63]);
    doubled.face_sizes.extend([3; 3]);
    let mut third = sound.clone();
    third.points.push([0.5, 0.5, 1.0]);
    third.corners.extend([40, 41, 81]);
    third.face_sizes.push(3);
    for mesh in [hole, degenerate, doubled, third] {
        match on(&mesh, &pins) {
            Ok(decal) => assert_eq!(decal.quality.flips, 0),
            Err(error) => assert!(!error.remedy.is_empty(), "{error}"),
        }
    }
}

#[test]
fn a_cancelled_decal_stops() {
    let plane = sheet(8, |u, v| [u, v, 0.0]);
    let pins = [pin([20.0, 20.0], 0.2, 0.2), pin([80.0, 20.0], 0.8, 0.2)];
    let mut left = 3;
    let mut cancel = |_: f32, _: &str| {
        left -= 1;
        left > 0
    };
    let error = lay(&plane, &whole(), &pins, None, &DecalSettings::default(), &mut cancel).expect_err("cancelled");
    assert_eq!(error.kind, relievo_core::ErrorKind::Cancelled);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]
    #[test]
    fn any_pins_on_a_bumpy_sheet_give_exact_pins_or_an_error(
        places in prop::collection::vec((0.05..0.95_f64, 0.05..0.95_f64, 5.0..95.0_f64, 5.0..95.0_f64), 2..6)
    ) {
        let mesh = sheet(8, |u, v| [u, v, 0.1 * (7.0 * u).sin() * (5.0 * v).cos()]);
        let pins: Vec<Pin> = places.iter().map(|(u, v, x, y)| pin([*x, *y], *u, *v)).collect();
        match on(&mesh, &pins) {
            Ok(decal) => {
                prop_assert_eq!(decal.quality.flips, 0);
                for (pin, vertex) in pins.iter().zip(&decal.pins) {
                    let uv = decal.uv[*vertex as usize];
                    prop_assert!((uv[0] - pin.image[0] / 100.0).abs() < 1e-6);
                    prop_assert!((uv[1] - pin.image[1] / 100.0).abs() < 1e-6);
                }
            }
            Err(error) => prop_assert!(!error.remedy.is_empty(), "{}", error),
        }
    }
}

#[test]
fn the_nearest_place_on_a_sheet_is_below_the_point() {
    let plane = sheet(8, |u, v| [u, v, 0.0]);
    let (Place { face, barycentric }, distance) = nearest(&plane, [0.3, 0.6, 0.5]).expect("a place");
    let triangle = &plane.corners[3 * face as usize..3 * face as usize + 3];
    let x: f64 = (0..3).map(|corner| barycentric[corner] * f64::from(plane.points[triangle[corner] as usize][0])).sum();
    assert!((x - 0.3).abs() < 1e-6 && (distance - 0.5).abs() < 1e-6);
    assert!(nearest(&plane, [f64::NAN; 3]).is_err());
}
