//! Documents on other meshes: what was where stays there, what has no place is told.

use glam::{DAffine3, DVec3, Vec4};
use relievo_bake::transfer::transfer;
use relievo_core::{Context, Mesh};
use relievo_detail::{Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode};
use relievo_document::Document;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displaced, Displacement, Paint, Points};

/// A rectangle from (0, 0) to `size`, of `n` × `n` faces.
fn sheet(n: u32, size: [f32; 2]) -> Mesh {
    let at = |k: u32, axis: usize| k as f32 / n as f32 * size[axis];
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i, 0), at(j, 1), 0.0])).collect();
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let corners = (0..n).flat_map(|j| {
        (0..n).flat_map(move |i| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)])
    });
    Mesh::new(points, vec![4; (n * n) as usize], corners.collect())
}

fn object(context: &Context, mesh: &Mesh, size: u32) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), Vec4::new(0.2, 0.2, 0.2, 1.0), &options).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(paint).unwrap();
    object
}

/// A sheet of 2 by 2 with a bump and a spot of paint around (0.8, 1.1).
fn document(context: &Context, mesh: &Mesh) -> Document {
    let mut object = object(context, mesh, 32);
    let brush = |radius: f64, falloff| {
        let half = DVec3::new(radius, radius, 1.0);
        Brush::on_surface(DVec3::new(0.8, 1.1, 0.0), DVec3::Z, DVec3::X, half, falloff).unwrap()
    };
    let sculpt = Action::Sculpt { mode: SculptMode::Draw, height: 0.2 };
    let color = [0.9, 0.1, 0.05, 1.0];
    let dab = |brush, action| Dab { brush, action, strength: 1.0 };
    dab(brush(0.6, Falloff::Smooth), sculpt).apply(context, &mut object).unwrap();
    let paint = Action::Paint { mode: PaintMode::Mix, color };
    dab(brush(0.4, Falloff::Smooth), paint).apply(context, &mut object).unwrap();
    let mut document = Document::new(mesh, "baseline").unwrap();
    object.store(context, &mut document).unwrap();
    document
}

/// Height and red at a lattice of places of the sheet, which is a rectangle of `size`.
fn seen(context: &Context, mesh: &Mesh, document: &Document, size: [f32; 2]) -> Vec<([f32; 2], [f32; 2])> {
    let mut object = object(context, mesh, 8);
    object.take_up(context, document, 1 << 30).unwrap();
    let n = (mesh.face_count() as f64).sqrt() as u32;
    let displaced = Displaced::new(object.surface(), object.displacement().field()).unwrap();
    let mut list = Vec::new();
    for j in 1..24 {
        for i in 1..24 {
            let [x, y] = [i, j].map(|k| 2.0 * k as f32 / 24.0 + 0.013);
            let [s, t] = [x / size[0] * n as f32, y / size[1] * n as f32];
            let tile = t as u32 * n + s as u32;
            let place = relievo_surface::Place::new(tile, s.fract(), t.fract());
            let mut points = Points::default();
            displaced.evaluate(context, &[place], &mut points).unwrap();
            let paint = object.paint().unwrap().field();
            list.push(([points.p[0][2], paint.color(paint.canonical(place)).x], [points.p[0][0], points.p[0][1]]));
        }
    }
    list
}

#[test]
fn layers_go_to_a_mesh_of_other_faces() {
    let context = Context::serial();
    let (old, size) = (sheet(4, [2.0; 2]), [2.0; 2]);
    let document = document(&context, &old);
    let before = seen(&context, &old, &document, size);
    let largest = before.iter().map(|(seen, _)| seen[0]).fold(0.0, f32::max);
    assert!(largest > 0.15);
    for n in [4, 7, 12] {
        let mesh = sheet(n, size);
        let (made, report) = transfer(&context, &document, None, &mesh, None).unwrap();
        assert_eq!(made.layers().iter().map(|layer| layer.name()).collect::<Vec<_>>(), ["displacement", "colour"]);
        assert!((report.area[0] - 4.0).abs() < 1e-3 && report.area[1] < 1e-6, "{report}");
        assert!(report.layers.iter().all(|(_, [all, lost])| *all > 0.5 && *lost < 0.3 * all), "{report}");
        let after = seen(&context, &mesh, &made, size);
        // Compared where both have the same places, which parameters beside borders do not give.
        let same = |a: &[f32; 2], b: &[f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 2e-3;
        let mut compared = 0;
        for ((seen, at), (now, there)) in before.iter().zip(&after) {
            if same(at, there) {
                compared += 1;
                assert!((seen[0] - now[0]).abs() < 0.004, "{n}: height {seen:?} {now:?} at {at:?}");
                assert!((seen[1] - now[1]).abs() < 0.03, "{n}: red {seen:?} {now:?} at {at:?}");
            }
        }
        assert!(compared > 100, "{n}: {compared}");
    }
}

#[test]
fn what_has_no_place_is_told() {
    let context = Context::serial();
    let old = sheet(4, [2.0; 2]);
    let document = document(&context, &old);
    // Twice as wide: the right half is bare.
    let (_, report) = transfer(&context, &document, None, &sheet(8, [4.0, 2.0]), Some(0.01)).unwrap();
    assert!((report.area[0] - 8.0).abs() < 1e-2 && (report.area[1] - 4.0).abs() < 0.1, "{report}");
    // Only its lower quarter: most of what was edited is lost.
    let (made, report) = transfer(&context, &document, None, &sheet(4, [2.0, 0.5]), Some(0.01)).unwrap();
    assert!(report.area[1] < 1e-6, "{report}");
    let (_, [all, lost]) = &report.layers[0];
    assert!(*lost > 0.4 * all && lost < all, "{report}");
    assert!(made.fit(&sheet(3, [2.0; 2])).unwrap_err().to_string().contains("relievo doc transfer"));
    let text = report.to_string();
    assert!(text.contains("uncovered") && text.contains("layer `displacement`: "), "{text}");
    // A document of another build has no points; the mesh it was made on has.
    let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo")).unwrap();
    let older = Document::parse(&bytes, 1 << 24).unwrap();
    let error = transfer(&context, &older, None, &old, None).unwrap_err().to_string();
    assert!(error.contains("--from"), "{error}");
    assert!(transfer(&context, &document, Some(&sheet(5, [2.0; 2])), &old, None).is_err(), "another old mesh");
    assert!(transfer(&context, &document, None, &old, Some(f64::NAN)).is_err());
}
