//! Stickers wound around a finger more than once, and a face on a head.

use crate::disks::lay_as_disk;
use crate::sheets::turns;
use relievo_core::Mesh;
use relievo_decal::{Decal, DecalSettings, Pin, Sticker, nearest};

use crate::sheets::sheet;

/// A finger that is one unit round, tapered towards its tip, with a half ball at each end; `count` edges around it.
fn finger(count: u32, taper: f64) -> Mesh {
    let radius = std::f64::consts::TAU.recip();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let quarter = count / 4;
    let bow = |step: u32| std::f64::consts::FRAC_PI_2 * f64::from(step) / f64::from(quarter);
    let below = (1..=quarter).map(|step| (radius * bow(step).sin(), -radius * bow(step).cos()));
    let middle = (1..count).map(|step| (radius, f64::from(step) / f64::from(count)));
    let above = (1..=quarter).rev().map(|step| (radius * bow(step).sin(), 1.0 + radius * bow(step).cos()));
    let rings: Vec<(f64, f64)> = below.chain(middle).chain(above).collect();
    points.push(place(0.0, -radius, 0.0, taper));
    for (radius, height) in &rings {
        points.extend((0..count).map(|at| place(*radius, *height, f64::from(at) / f64::from(count), taper)));
    }
    points.push(place(0.0, 1.0 + radius, 0.0, taper));
    let at = |ring: u32, column: u32| 1 + ring * count + column % count;
    let (last, tip) = (rings.len() as u32 - 1, points.len() as u32 - 1);
    for column in 0..count {
        triangles.push([0, at(0, column + 1), at(0, column)]);
        for ring in 0..last {
            let (a, b) = (at(ring, column), at(ring, column + 1));
            let (c, d) = (at(ring + 1, column + 1), at(ring + 1, column));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(last, column), at(last, column + 1), tip]);
    }
    Mesh::from_triangles(points.iter().map(|point| point.map(|value| value as f32)).collect(), &triangles)
}

fn place(radius: f64, height: f64, turns: f64, taper: f64) -> [f64; 3] {
    let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
    let radius = radius * (1.0 - taper * (height - 0.5));
    [radius * sin, height, radius * cos]
}

/// The farthest that a pin is from its point of the image, in widths of the image.
fn off(decal: &Decal, pins: &[Pin], [width, height]: [f64; 2]) -> f64 {
    let off = pins.iter().zip(&decal.pins).map(|(pin, vertex)| {
        let [u, v] = decal.uv[*vertex as usize];
        (u - pin.image[0] / width).hypot((v - pin.image[1] / height) * height / width)
    });
    off.fold(0.0, f64::max)
}

#[test]
fn a_sticker_with_many_pins_goes_around_a_finger_one_and_a_half_times() {
    let sticker = Sticker::whole([300, 100]).expect("a sticker");
    let settings = DecalSettings { overlap: true, ..DecalSettings::default() };
    // Columns and rows of pins, the taper of the finger, and how far pins are moved.
    let cases =
        [(3, 2, 0.0, 0.02), (6, 1, 0.0, 0.0), (6, 2, 0.0, 0.02), (6, 2, 0.2, 0.01), (4, 3, 0.3, 0.0), (4, 3, 0.6, 0.0)];
    for (columns, rows, taper, step) in cases {
        let mesh = finger(48, taper);
        let pin = |index: u32| {
            let x = (f64::from(index % columns) + 0.5) / f64::from(columns);
            let y = if rows == 1 { 0.5 } else { 0.2 + 0.6 * f64::from(index / columns) / f64::from(rows - 1) };
            let (sin, cos) = (2.4 * f64::from(index)).sin_cos();
            // The second turn lies a little higher than the first.
            let height = 0.25 + 0.5 * y + 0.08 * (x - 0.5) + step * sin;
            let radius = std::f64::consts::TAU.recip();
            let point = place(radius, height, 1.5 * (x - 0.5) + step * cos, taper);
            Pin { image: [300.0 * x, 100.0 * y], place: nearest(&mesh, point).expect("a place").0 }
        };
        let pins: Vec<Pin> = (0..columns * rows).map(pin).collect();
        let name = format!("{} pins, taper {taper}", pins.len());
        let decal = lay_as_disk(&mesh, &sticker, &pins, None, &settings);
        let decal = decal.unwrap_or_else(|error| panic!("{name}: {error}"));
        let quality = decal.quality;
        assert!(off(&decal, &pins, [300.0, 100.0]) < 1e-9, "{name}");
        assert!(decal.is_disk().expect("a manifold"), "{name}");
        assert!((turns(&decal.triangles, &decal.uv) - 1.0).abs() < 1e-6, "{name}");
        assert!(quality.flips == 0 && quality.l2 < 1.1, "{name}: {quality:?}");
        assert!(quality.coverage > 0.999 && quality.doubled < 0.01, "{name}: {quality:?}");
        // Half a turn of a band of half the height, of two triangles a quad.
        let band = 0.5 * 0.5 * 2.0 * 48.0 * 48.0;
        assert!((0.7..1.5).contains(&(quality.overlaps as f64 / band)), "{name}: {quality:?}");
    }
}

/// The band of a sticker goes around a finger one and a third times, and two arms that rise from its ends cross on the way. Each
/// arm is held by one pin, whose path crosses that of the other arm and encloses no region with it.
#[test]
fn paths_between_separate_parts_of_a_sticker_may_cross() {
    let outline = [
        [0.1, 0.0],
        [1.45, 0.0],
        [1.45, 0.25],
        [1.2, 0.95],
        [1.0, 0.95],
        [1.25, 0.25],
        [0.3, 0.25],
        [0.55, 0.95],
        [0.35, 0.95],
        [0.1, 0.25],
    ];
    let sticker = Sticker::new([200, 100], outline.map(|point| point.map(|value| 100.0 * value)).into());
    let sticker = sticker.expect("a sticker");
    let mesh = finger(48, 0.0);
    let pins = [
        [0.2, 0.18],
        [0.4, 0.07],
        [0.6, 0.18],
        [0.8, 0.07],
        [1.0, 0.18],
        [1.2, 0.07],
        [1.35, 0.18],
        [0.45, 0.88],
        [1.1, 0.88],
    ]
    .map(|[x, y]| {
        let point = place(std::f64::consts::TAU.recip(), y, x, 0.0);
        Pin { image: [100.0 * x, 100.0 * y], place: nearest(&mesh, point).expect("a place").0 }
    });
    let settings = DecalSettings { overlap: true, ..DecalSettings::default() };
    let decal = lay_as_disk(&mesh, &sticker, &pins, None, &settings).unwrap_or_else(|error| panic!("{error}"));
    let quality = decal.quality;
    assert!(off(&decal, &pins, [200.0, 100.0]) < 1e-9);
    assert!(decal.is_disk().expect("a manifold"));
    assert!((turns(&decal.triangles, &decal.uv) - 1.0).abs() < 1e-6);
    assert!(quality.flips == 0 && quality.l2 < 1.001, "{quality:?}");
    assert!(quality.coverage > 0.999 && quality.doubled < 0.001, "{quality:?}");
    // Where the arms cross, above the band, faces lie under both.
    let lies_above = |triangle: &[u32; 3]| triangle.iter().all(|vertex| decal.points[*vertex as usize][1] > 0.3);
    let mut above: Vec<u32> =
        decal.triangles.iter().zip(&decal.faces).filter(|(triangle, _)| lies_above(triangle)).map(|it| *it.1).collect();
    let count = above.len();
    above.sort_unstable();
    above.dedup();
    assert!(count > above.len() + 50, "{count} triangles on {} faces", above.len());
}

/// A head that looks along z: a ball with a nose, sockets of eyes, a chin and ears.
fn head([x, y, z]: [f64; 3]) -> [f64; 3] {
    let bump = |center: [f64; 3], width: f64| {
        let away = (x - center[0]).powi(2) + (y - center[1]).powi(2) + (z - center[2]).powi(2);
        (-away / (width * width)).exp()
    };
    let sockets = bump([0.33, 0.25, 0.9], 0.18) + bump([-0.33, 0.25, 0.9], 0.18);
    let ears = bump([1.0, 0.0, 0.0], 0.2) + bump([-1.0, 0.0, 0.0], 0.2);
    let radius =
        1.0 + 0.35 * bump([0.0, 0.0, 1.0], 0.16) - 0.08 * sockets + 0.06 * bump([0.0, -0.4, 0.9], 0.2) + 0.4 * ears;
    [0.8 * radius * x, 1.1 * radius * y, radius * z]
}

#[test]
fn a_face_lies_on_a_head_by_twelve_pins() {
    let on = |longitude: f64, latitude: f64| {
        head([latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos()])
    };
    let mesh = sheet(120, |u, v| on(std::f64::consts::TAU * (u - 0.5), 3.1 * (v - 0.5)));
    let sticker = Sticker::whole([200, 200]).expect("a sticker");
    // Points of the image with longitude and latitude: eyes, nose, mouth, chin, forehead, temples, jaws.
    let spots = [
        ([60.0, 130.0], -0.36, 0.25),
        ([140.0, 130.0], 0.36, 0.25),
        ([100.0, 95.0], 0.0, 0.0),
        ([65.0, 55.0], -0.28, -0.42),
        ([135.0, 55.0], 0.28, -0.42),
        ([100.0, 65.0], 0.0, -0.35),
        ([100.0, 20.0], 0.0, -0.75),
        ([100.0, 170.0], 0.0, 0.65),
        ([35.0, 150.0], -0.7, 0.45),
        ([165.0, 150.0], 0.7, 0.45),
        ([30.0, 60.0], -0.85, -0.35),
        ([170.0, 60.0], 0.85, -0.35),
    ];
    let pins = spots.map(|(image, longitude, latitude)| Pin {
        image,
        place: nearest(&mesh, on(longitude, latitude)).expect("a place").0,
    });
    let decal = lay_as_disk(&mesh, &sticker, &pins, None, &DecalSettings::default());
    let decal = decal.unwrap_or_else(|error| panic!("{error}"));
    assert!(off(&decal, &pins, [200.0, 200.0]) < 1e-9);
    assert!(decal.is_disk().expect("a manifold"));
    assert!(decal.quality.flips == 0 && decal.quality.l2 < 1.12, "{:?}", decal.quality);
    assert!(decal.quality.coverage > 0.99 && decal.quality.doubled < 0.01, "{:?}", decal.quality);
}
