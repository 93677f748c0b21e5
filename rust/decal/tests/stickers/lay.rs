//! Decals on surfaces whose answer is known.

use crate::disks::lay_as_disk;
use crate::sheets::{on_sheet, sheet, turns};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_decal::{
    Decal, DecalSettings, Pin, Pose, Projection, Quality, Scatter, Sticker, exponential, lay, nearest, project, scatter,
};

fn laid(mesh: &Mesh, sticker: &Sticker, pins: &[Pin]) -> Decal {
    let pose = Pose { width: 0.5, up: [0.0, 1.0, 0.0] };
    let decal = lay_as_disk(mesh, sticker, pins, Some(pose), &DecalSettings::default());
    let decal = decal.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(decal.quality.flips, 0);
    assert!(decal.is_disk().expect("a manifold"));
    let size = [100.0, 100.0];
    for (pin, vertex) in pins.iter().zip(&decal.pins) {
        let uv = decal.uv[*vertex as usize];
        for axis in 0..2 {
            assert!((uv[axis] - pin.image[axis] / size[axis]).abs() < 1e-6, "{pin:?} is at {uv:?}");
        }
    }
    decal
}

/// Pins of a square image of 100 pixels over the middle half of the sheet.
fn half(count: u32, places: &[[f64; 2]]) -> Vec<Pin> {
    let pin = |[x, y]: &[f64; 2]| Pin { image: [*x, *y], place: on_sheet(count, 0.25 + 0.005 * x, 0.25 + 0.005 * y) };
    places.iter().map(pin).collect()
}

#[test]
fn a_plane_keeps_the_image_for_any_number_of_pins() {
    let mesh = sheet(24, |u, v| [u, v, 0.0]);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let places = [[31.0, 33.0], [72.0, 40.0], [55.0, 81.0], [20.0, 64.0], [48.0, 52.0]];
    for count in 1..=places.len() {
        let decal = laid(&mesh, &sticker, &half(24, &places[..count]));
        assert!((decal.quality.l2 - 1.0).abs() < 1e-5, "{count} pins: {:?}", decal.quality);
        for (point, uv) in decal.points.iter().zip(&decal.uv) {
            for axis in 0..2 {
                let expected = (point[axis] - 0.25) / 0.5;
                assert!((uv[axis] - expected).abs() < 1e-5, "{count} pins: {point:?} is at {uv:?}");
            }
        }
        // Every corner of the image lies on a triangle.
        let low = decal.uv.iter().fold(1.0_f64, |low, uv| low.min(uv[0]).min(uv[1]));
        let high = decal.uv.iter().fold(0.0_f64, |high, uv| high.max(uv[0]).max(uv[1]));
        assert!(low <= 0.0 && high >= 1.0, "{low} {high}");
    }
}

#[test]
fn a_cylinder_and_a_cone_develop_without_stretch() {
    let angle = 2.0;
    let shapes: [(&str, Box<dyn Fn(f64, f64) -> [f64; 3]>); 2] = [
        (
            "cylinder",
            Box::new(move |u, v| {
                let radius = 1.0 / angle;
                [radius * (angle * u).sin(), v, radius * (angle * u).cos()]
            }),
        ),
        // A sheet rolled into a cone: the apex lies below it.
        (
            "cone",
            Box::new(|u, v| {
                let (x, y) = (u - 0.5, v + 0.5);
                let (radius, turn) = (x.hypot(y), x.atan2(y));
                let slope: f64 = 0.8;
                let wound = turn / slope;
                [slope * radius * wound.sin(), (1.0 - slope * slope).sqrt() * radius, slope * radius * wound.cos()]
            }),
        ),
    ];
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    for (name, shape) in shapes {
        let mesh = sheet(80, shape);
        for places in [&[[30.0, 30.0], [70.0, 30.0], [70.0, 70.0], [30.0, 75.0]][..], &[[30.0, 50.0], [80.0, 60.0]]] {
            let decal = laid(&mesh, &sticker, &half(80, places));
            assert!((decal.quality.l2 - 1.0).abs() < 1e-3, "{name}: {:?}", decal.quality);
        }
    }
}

/// A cap with bumps.
fn cap(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    [x, y, 0.6 * (1.0 - 0.5 * (x * x + y * y)) + 0.03 * (9.0 * x).sin() * (8.0 * y).cos()]
}

/// A grid of `side` by `side` pins, moved on the surface by a quarter of their spacing in directions that differ.
fn moved(count: u32, side: u32) -> Vec<Pin> {
    let pin = |index: u32| {
        let place = [index % side, index / side].map(|at| (f64::from(at) + 0.5) / f64::from(side));
        let turn = 2.4 * f64::from(index);
        let step = 0.25 / f64::from(side);
        let (u, v) = (place[0] + step * turn.cos(), place[1] + step * turn.sin());
        Pin { image: place.map(|value| 100.0 * value), place: on_sheet(count, 0.05 + 0.9 * u, 0.05 + 0.9 * v) }
    };
    (0..side * side).map(pin).collect()
}

#[test]
fn pins_moved_by_a_quarter_of_their_spacing_are_exact_and_nothing_flips() {
    let mesh = sheet(60, cap);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    for side in 2..=4 {
        let decal = laid(&mesh, &sticker, &moved(60, side));
        assert!(decal.quality.l2 <= 1.1, "{side}: {:?}", decal.quality);
        assert_eq!(decal.quality.overlaps, 0);
    }
}

#[test]
fn fronts_reach_pins_beyond_them_before_these_pull() {
    let mesh = sheet(104, cap);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    // Each step lowers the distortion of the whole patch, or of where it folded.
    let mut steps = 0;
    let mut count = |_: f32, stage: &str| {
        steps += u32::from(stage == "lowering the distortion");
        true
    };
    for side in 2..=4 {
        lay(&mesh, &sticker, &moved(104, side), None, &DecalSettings::default(), &mut count).expect("a decal");
    }
    assert!(steps <= 30, "{steps} steps");
}

#[test]
fn a_label_that_a_vase_stretches_differently_above_and_below_is_covered() {
    let on = |height: f64, turn: f64| {
        let radius = 0.25 + 0.08 * (std::f64::consts::TAU * height).sin();
        [radius * turn.sin(), height, radius * turn.cos()]
    };
    let vase = sheet(80, |u, v| on(v, 5.0 * (u - 0.5)));
    let sticker = Sticker::whole([400, 200]).expect("a sticker");
    let pin = |x: f64, y: f64| Pin {
        image: [x, y],
        place: on_sheet(80, 0.5 + 2.4 * (x / 400.0 - 0.5) / 5.0, 0.25 + 0.5 * y / 200.0),
    };
    let pins = [pin(40.0, 30.0), pin(40.0, 170.0), pin(360.0, 30.0), pin(360.0, 170.0)];
    let decal = lay_as_disk(&vase, &sticker, &pins, None, &DecalSettings::default());
    let decal = decal.unwrap_or_else(|error| panic!("{error}"));
    let Quality { flips, coverage, doubled, .. } = decal.quality;
    assert!(flips == 0 && coverage > 0.995 && doubled < 0.005, "{:?}", decal.quality);
}

#[test]
fn moving_turning_and_scaling_the_surface_changes_nothing() {
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let (sin, cos) = 0.7_f64.sin_cos();
    // Scaled by a power of two, so that coordinates are rounded alike.
    let mesh = sheet(30, cap);
    let mut other = mesh.clone();
    for point in &mut other.points {
        let [x, y, z] = point.map(f64::from);
        let turned = [cos * x - sin * z, y, sin * x + cos * z].map(|value| 4.0 * value);
        *point = [turned[0] + 3.0, turned[1] - 1.0, turned[2] + 0.5].map(|value| value as f32);
    }
    let pins = moved(30, 3);
    let (first, second) = (laid(&mesh, &sticker, &pins), laid(&other, &sticker, &pins));
    assert_eq!(first.triangles, second.triangles);
    for (a, b) in first.uv.iter().zip(&second.uv) {
        assert!((a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5, "{a:?} {b:?}");
    }
}

#[test]
fn a_sticker_that_is_larger_than_the_surface_ends_at_its_border() {
    let mesh = sheet(12, |u, v| [u, v, 0.0]);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let pins: Vec<Pin> = [[45.0, 45.0], [55.0, 45.0], [50.0, 55.0]]
        .map(|image: [f64; 2]| Pin {
            image,
            place: on_sheet(12, 0.5 + 0.05 * (image[0] - 50.0), 0.5 + 0.05 * (image[1] - 50.0)),
        })
        .to_vec();
    let decal = laid(&mesh, &sticker, &pins);
    let area: f64 = decal
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| decal.points[vertex as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        })
        .sum();
    assert!((area - 1.0).abs() < 1e-6, "{area}");
}

#[test]
fn a_sticker_longer_than_a_finger_is_round_overlaps_itself_where_that_is_allowed() {
    // A finger one unit round: the sticker of 1.5 by 0.5 units goes around it one and a half times.
    let turn = std::f64::consts::TAU;
    let finger = sheet(48, |u, v| [(turn * u).cos() / turn, v, -(turn * u).sin() / turn]);
    let mut closed = finger.clone();
    for corner in &mut closed.corners {
        if *corner % 49 == 48 {
            *corner -= 48;
        }
    }
    let sticker = Sticker::whole([300, 100]).expect("a sticker");
    let pin = Pin { image: [150.0, 50.0], place: on_sheet(48, 0.51, 0.5) };
    let pose = Pose { width: 1.5, up: [0.0, 1.0, 0.0] };
    let on = |overlap: bool| {
        let settings = DecalSettings { overlap, ..DecalSettings::default() };
        let decal = lay_as_disk(&closed, &sticker, &[pin], Some(pose), &settings);
        let decal = decal.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(decal.quality.flips, 0);
        assert!(decal.is_disk().expect("a manifold"));
        assert!((turns(&decal.triangles, &decal.uv) - 1.0).abs() < 1e-6, "faces turn around a vertex twice");
        assert!((decal.quality.l2 - 1.0).abs() < 1e-3 && decal.quality.doubled < 0.01, "{:?}", decal.quality);
        decal.quality
    };
    let apart = on(false);
    assert_eq!(apart.overlaps, 0);
    assert!((apart.coverage - 2.0 / 3.0).abs() < 0.02, "{apart:?}");
    let overlapping = on(true);
    assert!(overlapping.coverage > 0.999, "{overlapping:?}");
    // Half of the faces under a band of half the height of the finger, and the faces that its border crosses.
    let band = 0.5 * 0.5 * 2.0 * 48.0 * 48.0;
    assert!((0.9..1.3).contains(&(overlapping.overlaps as f64 / band)), "{overlapping:?}");
}

#[test]
fn a_refusal_proposes_a_place_where_the_sticker_lies() {
    let plane = sheet(24, |u, v| [u, v, 0.0]);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let mut pins = half(24, &[[20.0, 20.0], [80.0, 20.0], [80.0, 80.0], [20.0, 80.0], [50.0, 50.0]]);
    // The pin in the middle belongs on the far side of another one.
    pins[4].place = on_sheet(24, 0.8, 0.8);
    let settings = DecalSettings::default();
    let error = lay(&plane, &sticker, &pins, None, &settings, &mut Silent).expect_err("it folds");
    let text = error.to_string();
    let start = text.find("move its place to (").unwrap_or_else(|| panic!("{text}")) + 19;
    let numbers = text[start..].split(')').next().unwrap_or_default();
    let numbers: Vec<f64> = numbers.split(", ").map(|number| number.parse().expect("a number")).collect();
    let named = (0..pins.len()).find(|pin| text.contains(&format!("pin {pin}:"))).unwrap_or_else(|| panic!("{text}"));
    pins[named].place = nearest(&plane, [numbers[0], numbers[1], numbers[2]]).expect("a place").0;
    assert_eq!(lay(&plane, &sticker, &pins, None, &settings, &mut Silent).expect("it lies").quality.flips, 0);
}

#[test]
fn the_exponential_map_is_exact_on_a_plane_and_close_on_a_cap() {
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let pose = Pose { width: 0.5, up: [0.0, 1.0, 0.0] };
    let plane = sheet(24, |u, v| [u, v, 0.0]);
    let pin = Pin { image: [50.0, 50.0], place: on_sheet(24, 0.513, 0.494) };
    let decal = exponential(&plane, &sticker, &pin, pose).expect("a decal");
    for (point, uv) in decal.points.iter().zip(&decal.uv) {
        let expected = [0.5 + (point[0] - 0.513) / 0.5, 0.5 + (point[1] - 0.494) / 0.5];
        assert!((uv[0] - expected[0]).abs() < 1e-5 && (uv[1] - expected[1]).abs() < 1e-5, "{point:?} is at {uv:?}");
    }
    let curved =
        exponential(&sheet(60, cap), &sticker, &moved(60, 1)[0], Pose { width: 1.0, ..pose }).expect("a decal");
    assert!(curved.quality.l2 < 1.2, "{:?}", curved.quality);
}

#[test]
fn scattered_stickers_are_as_many_as_their_density_says_for_any_number_of_threads() {
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let plane = sheet(30, |u, v| [u, v, 0.0]);
    let settings =
        Scatter { density: 200.0, width: [0.02, 0.04], up: [0.0, 1.0, 0.0], turn: std::f64::consts::PI, seed: 7 };
    let on = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).expect("a context");
        scatter(&context, &plane, &sticker, &settings).expect("decals")
    };
    let decals = on(1);
    assert_eq!(decals.len(), 200);
    let mut halves = [0, 0];
    for decal in &decals {
        assert!(decal.quality.flips == 0 && (decal.quality.l2 - 1.0).abs() < 1e-6, "{:?}", decal.quality);
        halves[usize::from(decal.points[decal.pins[0] as usize][0] > 0.5)] += 1;
        let width = decal.scale.recip();
        assert!((0.0199..0.0401).contains(&width), "{width}");
    }
    assert!(halves.iter().all(|count| (70..=130).contains(count)), "{halves:?}");
    for (a, b) in decals.iter().zip(on(4)) {
        assert!(a.uv == b.uv && a.triangles == b.triangles);
    }
    let context = Context::serial();
    for wrong in [
        Scatter { density: f64::NAN, ..settings },
        Scatter { density: 1e9, ..settings },
        Scatter { width: [0.0, 1.0], ..settings },
        Scatter { up: [0.0; 3], ..settings },
        Scatter { turn: 4.0, ..settings },
    ] {
        assert!(scatter(&context, &plane, &sticker, &wrong).is_err());
    }
}

#[test]
fn a_projection_keeps_to_its_limits() {
    let sticker = Sticker::whole([100, 50]).expect("a sticker");
    // Half a cylinder around the y axis.
    let mesh = sheet(40, |u, v| [-(3.1 * u).cos(), v, (3.1 * u).sin()]);
    let projection = Projection {
        center: [0.0, 0.5, 1.0],
        towards: [0.0, 0.0, 2.0],
        up: [0.0, 1.0, 0.3],
        width: 4.0,
        angle: 0.5,
        depth: 1.0,
    };
    let decal = project(&mesh, &sticker, &projection).expect("a decal");
    assert_eq!(decal.quality.flips, 0);
    for (point, uv) in decal.points.iter().zip(&decal.uv) {
        assert!((uv[0] - (0.5 + point[0] / 4.0)).abs() < 1e-6 && (uv[1] - (0.5 + (point[1] - 0.5) / 2.0)).abs() < 1e-6);
        assert!(point[0].abs() < (0.5_f64 + 0.08).sin(), "{point:?}");
    }
    assert!(project(&mesh, &sticker, &Projection { depth: 0.01, angle: 0.0, ..projection }).is_err());
    assert!(project(&mesh, &sticker, &Projection { up: [0.0, 0.0, 1.0], ..projection }).is_err());
}
