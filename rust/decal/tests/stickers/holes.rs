//! Faces of a mesh that are holes, which have no surface.

use crate::disks::lay_as_disk;
use crate::sheets::{on_sheet, sheet};
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh};
use relievo_decal::{
    Decal, DecalSettings, Pin, Placement, Projection, Scatter, Sticker, lay, nearest, project, scatter, shortest_path,
};

/// Squares along each side of the sheet.
const SIDE: u32 = 24;

/// A flat sheet whose four squares in the middle are holes.
fn sheet_with_holes() -> Mesh {
    let mut mesh = sheet(SIDE, |u, v| [u, v, 0.0]);
    let squares = [[12, 12], [11, 12], [12, 11], [11, 11]].map(|[column, row]| 2 * (SIDE * row + column));
    mesh.holes = squares.iter().flat_map(|first| [first + 1, *first]).collect();
    mesh
}

fn sticker() -> Sticker {
    Sticker::whole([100, 100]).expect("a sticker")
}

fn pin(x: f64, y: f64) -> Pin {
    Pin { image: [x, y], place: on_sheet(SIDE, 0.25 + 0.005 * x, 0.25 + 0.005 * y) }
}

fn lies_beside_holes(mesh: &Mesh, decal: &Decal) {
    assert!(!decal.faces.is_empty() && decal.faces.iter().all(|face| !mesh.holes.contains(face)));
}

#[test]
fn stickers_with_pins_within_faces_leave_holes_free() {
    let mesh = sheet_with_holes();
    let pins = [pin(21.0, 23.0), pin(79.0, 22.0), pin(51.0, 78.0)];
    let decal = lay_as_disk(&mesh, &sticker(), &pins, None, &DecalSettings::default()).expect("a decal");
    lies_beside_holes(&mesh, &decal);
    // Two of twelve squares along each side.
    let expected = 1.0 - 1.0 / 36.0;
    assert!((decal.quality.coverage - expected).abs() < 0.003 && decal.quality.flips == 0, "{:?}", decal.quality);
    // The surface is divided again where a pin is dropped.
    let mut placed =
        Placement::new(&mesh, &sticker(), &pins, None, &DecalSettings::default(), &mut Silent).expect("a decal");
    placed.drag(2, on_sheet(SIDE, 0.51, 0.63)).expect("it follows");
    placed.settle(&mut Silent).expect("it lies");
    lies_beside_holes(&mesh, &placed.decal());
}

#[test]
fn paths_go_around_holes() {
    let mesh = sheet_with_holes();
    let places = [on_sheet(SIDE, 0.3, 0.51), on_sheet(SIDE, 0.7, 0.52)];
    let path = shortest_path(&mesh, places).expect("a path");
    assert!(path.iter().all(|[x, y, _]| (x - 0.5).abs().max((y - 0.5).abs()) > 1.0 / 24.0 - 1e-6), "{path:?}");
}

#[test]
fn no_place_is_on_a_hole() {
    let mesh = sheet_with_holes();
    let (place, distance) = nearest(&mesh, [0.51, 0.5, 0.0]).expect("a place");
    assert!(!mesh.holes.contains(&place.face) && (distance - (1.0 / 24.0 - 0.01)).abs() < 1e-6, "{distance}");
    let pins = [pin(20.0, 20.0), pin(52.0, 51.0)];
    let error = lay(&mesh, &sticker(), &pins, None, &DecalSettings::default(), &mut Silent).expect_err("a hole");
    assert!(error.to_string().contains("pin 1") && error.to_string().contains("is a hole"), "{error}");
    let settings = Scatter { density: 300.0, width: [0.01; 2], up: [0.0, 1.0, 0.0], turn: 0.0, seed: 3 };
    let decals = scatter(&Context::serial(), &mesh, &sticker(), &settings).expect("decals");
    decals.iter().for_each(|decal| lies_beside_holes(&mesh, decal));
    assert_eq!(decals.len(), (300.0_f64 * (1.0 - 1.0 / 144.0)).round() as usize);
    let projection = Projection {
        center: [0.5, 0.5, 0.0],
        towards: [0.0, 0.0, 1.0],
        up: [0.0, 1.0, 0.0],
        width: 0.5,
        angle: 1.0,
        depth: 1.0,
    };
    lies_beside_holes(&mesh, &project(&mesh, &sticker(), &projection).expect("a decal"));
}
