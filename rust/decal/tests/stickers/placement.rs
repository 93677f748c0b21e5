//! Stickers that follow dragged pins and posed surfaces.

use relievo_core::progress::Silent;
use relievo_decal::{Decal, DecalSettings, Pin, Placement, Sticker, lay};

use crate::sheets::{on_sheet, sheet};

const COUNT: u32 = 40;

fn bump(u: f64, v: f64) -> [f64; 3] {
    [u, v, 0.2 * (3.0 * u).sin() * (4.0 * v).cos()]
}

fn pins() -> Vec<Pin> {
    let pin = |x: f64, y: f64| Pin { image: [x, y], place: on_sheet(COUNT, 0.25 + 0.005 * x, 0.25 + 0.005 * y) };
    vec![pin(20.0, 20.0), pin(80.0, 22.0), pin(77.0, 81.0), pin(21.0, 79.0), pin(50.0, 50.0)]
}

fn placed() -> Placement {
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let placed = Placement::new(&sheet(COUNT, bump), &sticker, &pins(), None, &DecalSettings::default(), &mut Silent);
    placed.unwrap_or_else(|error| panic!("{error}"))
}

/// The point of the image at a point of space with the coordinates (u, v) of the sheet.
fn image_at(decal: &Decal, [u, v]: [f64; 2]) -> [f64; 2] {
    for triangle in &decal.triangles {
        let [a, b, c] = triangle.map(|vertex| decal.points[vertex as usize]);
        let turn = |p: [f64; 3], q: [f64; 3]| (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]);
        let weights = [turn(b, c), turn(c, a), turn(a, b)];
        let sum: f64 = weights.iter().sum();
        if weights.iter().all(|weight| *weight >= -1e-12) && sum > 0.0 {
            return std::array::from_fn(|axis| {
                (0..3).map(|corner| weights[corner] / sum * decal.uv[triangle[corner] as usize][axis]).sum()
            });
        }
    }
    panic!("the decal does not lie at ({u}, {v})");
}

#[test]
fn a_dragged_pin_stays_exact_and_settles_where_it_is_laid_anew() {
    let mut placed = placed();
    let mut place = [0.5, 0.5];
    for step in 1..=12 {
        place = [0.5 + 0.004 * f64::from(step), 0.5 + 0.0021 * f64::from(step)];
        placed.drag(4, on_sheet(COUNT, place[0], place[1])).unwrap_or_else(|error| panic!("{error}"));
        let decal = placed.decal();
        let at = image_at(&decal, place);
        assert!((at[0] - 0.5).abs() < 1e-6 && (at[1] - 0.5).abs() < 1e-6, "step {step}: {at:?}");
        assert_eq!(decal.quality.flips, 0);
    }
    placed.settle(&mut Silent).unwrap_or_else(|error| panic!("{error}"));
    let decal = placed.decal();
    assert!(decal.is_disk().expect("a manifold"));
    let uv = decal.uv[decal.pins[4] as usize];
    assert!((uv[0] - 0.5).abs() < 1e-6 && (uv[1] - 0.5).abs() < 1e-6, "{uv:?}");
    let mut moved = pins();
    moved[4].place = on_sheet(COUNT, place[0], place[1]);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let anew = lay(&sheet(COUNT, bump), &sticker, &moved, None, &DecalSettings::default(), &mut Silent);
    let anew = anew.unwrap_or_else(|error| panic!("{error}"));
    assert!((anew.quality.l2 - decal.quality.l2).abs() < 2e-3, "{:?} {:?}", anew.quality, decal.quality);
    assert!(decal.quality.coverage > 0.999, "{:?}", decal.quality);
}

#[test]
fn a_drag_that_cannot_follow_changes_nothing() {
    let mut placed = placed();
    let before = placed.decal().uv;
    assert!(
        placed.drag(4, on_sheet(COUNT, 0.01, 0.01)).expect_err("not under the sticker").to_string().contains("pin 4")
    );
    assert!(placed.drag(9, on_sheet(COUNT, 0.5, 0.5)).is_err());
    let mut nowhere = on_sheet(COUNT, 0.5, 0.5);
    nowhere.barycentric = [f64::NAN; 3];
    assert!(placed.drag(4, nowhere).is_err());
    nowhere.face = u32::MAX;
    assert!(placed.drag(4, nowhere).is_err());
    assert_eq!(placed.decal().uv, before);
}

#[test]
fn a_posed_surface_keeps_the_pins_and_a_moved_point_of_the_image_is_followed() {
    let mut placed = placed();
    let bent = sheet(COUNT, |u, v| [u, 1.1 * v, 0.3 * (3.0 * u).sin() * (4.0 * v).cos()]);
    placed.pose(&bent.points, &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    let decal = placed.decal();
    for (pin, vertex) in pins().iter().zip(&decal.pins) {
        let uv = decal.uv[*vertex as usize];
        assert!((0..2).all(|axis| (uv[axis] - 0.01 * pin.image[axis]).abs() < 1e-6), "{pin:?} is at {uv:?}");
    }
    assert!(decal.quality.flips == 0 && decal.quality.coverage > 0.999, "{:?}", decal.quality);
    placed.move_image(4, [54.0, 47.0], &mut Silent).unwrap_or_else(|error| panic!("{error}"));
    let decal = placed.decal();
    let uv = decal.uv[decal.pins[4] as usize];
    assert!((uv[0] - 0.54).abs() < 1e-6 && (uv[1] - 0.47).abs() < 1e-6, "{uv:?}");
    assert!(placed.move_image(4, [540.0, 47.0], &mut Silent).is_err());
    assert!(placed.pose(&bent.points[1..], &mut Silent).is_err());
}
