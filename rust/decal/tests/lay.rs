//! Decals on surfaces whose answer is known.

use relievo_core::Mesh;
use relievo_core::progress::Silent;
use relievo_decal::{Decal, DecalSettings, Pin, Place, Pose, Sticker, lay};

/// A grid of `count` by `count` quads of two triangles over the unit square, moved by `shape`.
fn sheet(count: u32, shape: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for row in 0..=count {
        for column in 0..=count {
            let (u, v) = (f64::from(column) / f64::from(count), f64::from(row) / f64::from(count));
            points.push(shape(u, v).map(|value| value as f32));
            if row < count && column < count {
                let first = row * (count + 1) + column;
                let above = first + count + 1;
                triangles.extend([[first, first + 1, above + 1], [first, above + 1, above]]);
            }
        }
    }
    Mesh::from_triangles(points, &triangles)
}

/// The place of parameters (u, v) on such a grid.
fn on_sheet(count: u32, u: f64, v: f64) -> Place {
    let (x, y) = (u * f64::from(count), v * f64::from(count));
    let cell = [x, y].map(|value| (value as u32).min(count - 1));
    let (s, t) = (x - f64::from(cell[0]), y - f64::from(cell[1]));
    let face = 2 * (cell[1] * count + cell[0]);
    if s >= t {
        Place { face, barycentric: [1.0 - s, s - t, t] }
    } else {
        Place { face: face + 1, barycentric: [1.0 - t, s, t - s] }
    }
}

fn laid(mesh: &Mesh, sticker: &Sticker, pins: &[Pin]) -> Decal {
    let pose = Pose { width: 0.5, up: [0.0, 1.0, 0.0] };
    let decal = lay(mesh, sticker, pins, Some(pose), &DecalSettings::default(), &mut Silent);
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
