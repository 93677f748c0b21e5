//! Brushes that move triangle meshes sideways, pinch and vector stamps, against closed forms.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::parameter::Switch;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, Brush, Canvas, Dab, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage, StampSettings, Stroke,
    StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_surface::TriangleSurface;
use relievo_tiles::ColorTexel;
use relievo_tiles::triangle::{Node, Pattern, TriangleChannel, TriangleOptions, foot};

use crate::shapes::{centred_triangle_plane, fine_values, value_bytes};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

/// An octahedron, whose faces and edges have frames that differ much.
fn octahedron() -> Mesh {
    let points =
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let triangles =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]].map(|t: [u32; 3]| t);
    Mesh::from_triangles(points.to_vec(), &triangles)
}

fn object(context: &Context, mesh: &Mesh, segments: u32, budget: u64, transform: DAffine3) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let options = TriangleOptions { segments, budget };
    let topology = surface.topology().clone();
    let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
    let mut object = TriangleObject::new(context, surface, displacement, transform).unwrap();
    object.set_paint(TriangleChannel::of_color(topology.clone(), BLANK, &options).unwrap()).unwrap();
    object.set_vectors(TriangleChannel::vectors(topology, &options).unwrap()).unwrap();
    object.renew(context).unwrap();
    object
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

/// A vertex of the finest tessellation: where it is undisplaced, and how far it is moved, in object space.
struct Moved {
    knot: (u32, Pattern, Node),
    place: DVec3,
    way: DVec3,
}

fn moved(context: &Context, object: &mut TriangleObject) -> Vec<Moved> {
    object.renew(context).unwrap();
    let displaced = object.displaced().unwrap();
    let made = fine_values(object).map(|(face, pattern, node)| {
        let place = foot(object.surface(), face, pattern, node).point.as_dvec3();
        let way = displaced.point(face, pattern, node).as_dvec3() - place;
        Moved { knot: (face, pattern, node), place, way }
    });
    made.collect()
}

fn vectors(n: u32, at: impl Fn(f32, f32) -> [f32; 3]) -> Stamp {
    let side = |k: u32| (k as f32 + 0.5) / n as f32 * 2.0 - 1.0;
    let data: Vec<f32> = (0..n * n).flat_map(|k| at(side(k % n), -side(k / n))).collect();
    let settings = StampSettings { mid: 0.0, scale: 1.0, ..Default::default() };
    Stamp::new(StampImage::new(n, n, 3, &data).unwrap(), settings, StampChannel::Red).unwrap()
}

#[test]
fn a_pinch_contracts_distances_from_its_line_by_its_falloff() {
    let context = Context::serial();
    let turned = DAffine3::from_rotation_x(0.7) * DAffine3::from_scale(DVec3::new(2.0, 1.0, 0.5));
    for (mesh, transform) in [(centred_triangle_plane(4), DAffine3::IDENTITY), (octahedron(), turned)] {
        for height in [0.05, -0.05] {
            let mut object = object(&context, &mesh, 16, 1 << 24, transform);
            let found = object.nearest(&context, transform.transform_point3(DVec3::new(0.3, 0.4, 0.5)), 9.0);
            let found = found.unwrap().unwrap();
            let half = DVec3::new(0.9, 0.7, 0.8);
            // The second goes by what the first moved.
            for falloff in [Falloff::Linear, Falloff::Smooth] {
                let brush = Brush::on_surface(found.point, found.normal, found.tangent, half, falloff).unwrap();
                let before = moved(&context, &mut object);
                let dab = Dab { brush: brush.clone(), action: sculpt(SculptMode::Pinch, height), strength: 0.75 };
                let report = object.dab(&context, &dab).unwrap();
                assert!(report.changed_texels > 50 && report.refused.is_empty());
                let across = |p: DVec3| p - found.point - found.normal * (p - found.point).dot(found.normal);
                for (old, new) in before.iter().zip(moved(&context, &mut object)) {
                    let here = transform.transform_point3(old.place + old.way);
                    let at = brush.map().transform_point3(here);
                    let inside = at.abs().max_element() < 1.0;
                    let share = if inside { 0.75 * falloff.share(at.as_vec3().to_array()) } else { 0.0 };
                    let sign = if height < 0.0 { 1.0 } else { -1.0 };
                    let expected = here + across(here) * (sign * f64::from(share));
                    let off = transform.transform_point3(new.place + new.way).distance(expected);
                    let border = (at.abs().max_element() - 1.0).abs() < 1e-5;
                    assert!(border || off < 3e-3 * old.way.length().max(0.3) + 1e-5, "{}: {off}", old.place);
                }
            }
        }
    }
}

#[test]
fn a_stamp_of_vectors_leaves_its_field_and_eraser_gives_its_memory_back() {
    let context = Context::serial();
    let field = |x: f32, y: f32| [0.3 * x * y, 0.2 - 0.1 * y, 0.5 * x + 0.25];
    for mesh in [centred_triangle_plane(4), octahedron()] {
        let mut object = object(&context, &mesh, 16, 1 << 24, DAffine3::IDENTITY);
        let (bytes, before) = (object.vectors().unwrap().bytes(), value_bytes(object.vectors().unwrap()));
        let axes = DMat3::from_rotation_z(0.4);
        let brush = Brush::new(DVec3::new(0.1, 0.2, 0.2), axes, DVec3::new(0.9, 0.8, 1.0), Falloff::Constant).unwrap();
        let brush = brush.with_stamp(vectors(256, field));
        let dab = Dab { brush: brush.clone(), action: sculpt(SculptMode::Vector, 2.0), strength: 0.5 };
        object.dab(&context, &dab).unwrap();
        let mut seen = 0;
        let all = moved(&context, &mut object);
        let field_of = object.vectors().unwrap().field();
        // A face without a block reads as its edges say.
        for Moved { place, way, .. } in all.iter().filter(|moved| field_of.is_allocated(moved.knot.0)) {
            let (place, way) = (*place, *way);
            let at = brush.map().transform_point3(place).as_vec3();
            // The image is filtered as coarsely as the vertices are apart, also with what is beside it.
            if (0.8..1.01).contains(&at.abs().max_element()) {
                continue;
            }
            let inside = at.abs().max_element() < 1.0;
            let share = if inside { 1.0 } else { 0.0 };
            let expected = axes * DVec3::from(field(at.x, at.y).map(f64::from)) * share;
            assert!((way - expected).length() < 1e-3, "{place}: {way} {expected}");
            seen += u32::from(inside);
        }
        assert!(seen > 300);
        let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(9.0), Falloff::Constant).unwrap();
        let report = object.dab(&context, &Dab { brush, action: sculpt(SculptMode::Erase, 0.0), strength: 1.0 });
        assert!(report.unwrap().freed > 0);
        assert_eq!((object.vectors().unwrap().bytes(), value_bytes(object.vectors().unwrap())), (bytes, before));
    }
}

#[test]
fn finer_blocks_beside_coarser_vectors_change_nothing_but_what_is_edited() {
    let context = Context::serial();
    let mut object = object(&context, &octahedron(), 16, 1 << 24, DAffine3::IDENTITY);
    let brush = |center, radius| Brush::new(center, DMat3::IDENTITY, DVec3::splat(radius), Falloff::Smooth).unwrap();
    let aside = vectors(8, |_, _| [0.5, 0.25, 0.125]);
    object.set_level(2).unwrap();
    let dab = |brush| Dab { brush, action: sculpt(SculptMode::Vector, 1.0), strength: 1.0 };
    object.dab(&context, &dab(brush(DVec3::new(0.5, 0.5, 0.0), 0.9).with_stamp(aside.clone()))).unwrap();
    let before = moved(&context, &mut object);
    object.set_level(0).unwrap();
    let at = before.iter().find(|moved| moved.place.distance(DVec3::new(0.5, 0.25, 0.25)) < 0.05).unwrap();
    let center = at.place + at.way;
    let report = object.dab(&context, &dab(brush(center, 0.1).with_stamp(aside))).unwrap();
    assert!(report.changed_texels > 2 && report.allocated == 0);
    let after = moved(&context, &mut object);
    let mut changed = 0;
    for (old, new) in before.iter().zip(&after) {
        let off = (new.way - old.way).length();
        if (old.place + old.way).distance(center) > 0.1 {
            assert!(off < 1e-3, "{}: {} {}", old.place, old.way, new.way);
        }
        changed += u32::from(off > 0.01);
    }
    assert!(changed > 2);
}

#[test]
fn brushes_go_by_the_mesh_that_vectors_moved() {
    let context = Context::serial();
    let mut object = object(&context, &centred_triangle_plane(6), 16, 1 << 24, DAffine3::IDENTITY);
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(0.8), Falloff::Smooth).unwrap();
    let brush = brush.with_stamp(vectors(8, |_, _| [0.75, 0.0, 1.0]));
    object.dab(&context, &Dab { brush, action: sculpt(SculptMode::Vector, 2.0), strength: 1.0 }).unwrap();
    let before = moved(&context, &mut object);
    let tip = DVec3::new(1.5, 0.0, 2.0);
    let found = object.nearest(&context, tip + DVec3::Z * 0.1, 0.3).unwrap().unwrap();
    assert!(found.point.distance(tip) < 0.02, "{found:?}");
    let brush = Brush::new(tip, DMat3::IDENTITY, DVec3::splat(0.4), Falloff::Linear).unwrap();
    let action = Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] };
    object.dab(&context, &Dab { brush, action, strength: 1.0 }).unwrap();
    let painted = object.paint().unwrap().field();
    let mut seen = 0;
    for Moved { knot: (face, pattern, node), place, way } in &before {
        let far = ((*place + *way - tip) / 0.4).length();
        let red = painted.texel(*face, *pattern, *node).color().x;
        assert!(far > 0.95 || red > 0.51, "{place} {way} {red}");
        assert!(far < 1.0 || (red - 0.5).abs() < 0.01, "{place} {way} {red}");
        seen += u32::from(far < 0.95);
    }
    assert!(seen > 10);
}

fn stroke(mode: SculptMode) -> Stroke {
    let points = [[-1.5, 0.1, 0.0], [0.2, -0.7, 0.0], [1.3, 1.1, 0.0]];
    let points = points.map(|p| StrokePoint::new(p.into(), 0.8)).to_vec();
    let settings = StrokeSettings { radius: 0.5, strength: 0.4, symmetry_x: Switch::ON, ..Default::default() };
    let mut stroke = Stroke::new(points, settings, Falloff::Smooth, sculpt(mode, 0.3));
    stroke.stamp = (mode == SculptMode::Vector).then(|| vectors(32, |x, y| [0.3 * y, -0.3 * x, 0.5 * (1.0 - x * x)]));
    stroke
}

#[test]
fn strokes_are_symmetric_and_the_same_on_any_number_of_threads() {
    for mode in [SculptMode::Pinch, SculptMode::Vector, SculptMode::Smooth, SculptMode::Erase] {
        let made = |threads| {
            let context = Context::new(&ContextOptions { threads, ..Default::default() }).unwrap();
            let mut object = object(&context, &centred_triangle_plane(4), 16, 1 << 24, DAffine3::IDENTITY);
            stroke(SculptMode::Vector).apply(&context, &mut object).unwrap();
            let report = stroke(mode).apply(&context, &mut object).unwrap();
            assert!(report.report.changed_texels > 0);
            // What was kept up to date on the way is what is made anew.
            let before: Vec<DVec3> = moved(&context, &mut object).iter().map(|moved| moved.way).collect();
            object.vectors_mut();
            let after: Vec<DVec3> = moved(&context, &mut object).iter().map(|moved| moved.way).collect();
            assert_eq!(before, after, "{mode:?}");
            value_bytes(object.vectors().unwrap())
        };
        assert_eq!(made(1), made(3), "{mode:?}");
    }
}

#[test]
fn a_budget_smaller_than_a_block_refuses_and_changes_nothing() {
    let context = Context::serial();
    let vertices = 25 * 6;
    for budget in [vertices, vertices + 100] {
        let mut object = object(&context, &centred_triangle_plane(4), 16, budget, DAffine3::IDENTITY);
        let before = value_bytes(object.vectors().unwrap());
        for mode in [SculptMode::Vector, SculptMode::Pinch] {
            let report = stroke(mode).apply(&context, &mut object).unwrap();
            assert!(report.dabs > 1 && !report.report.refused.is_empty(), "{mode:?}");
            assert_eq!(value_bytes(object.vectors().unwrap()), before);
        }
        let colour = Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] };
        for action in [colour, sculpt(SculptMode::Draw, 0.2)] {
            let report = Stroke { action, ..stroke(SculptMode::Pinch) }.apply(&context, &mut object).unwrap();
            assert!(report.report.changed_texels == 0 || report.report.refused.is_empty(), "{budget} {action:?}");
        }
        for mode in [SculptMode::Smooth, SculptMode::Erase] {
            assert!(stroke(mode).apply(&context, &mut object).is_ok());
        }
    }
    let surface = TriangleSurface::new(&context, &centred_triangle_plane(4)).unwrap();
    let few = TriangleOptions { segments: 16, budget: vertices - 1 };
    let error = TriangleChannel::vectors(surface.topology().clone(), &few).unwrap_err().to_string();
    assert!(error.contains("budget"), "{error}");
}

#[test]
fn meshes_without_vectors_say_so() {
    let context = Context::serial();
    let surface = TriangleSurface::new(&context, &centred_triangle_plane(2)).unwrap();
    let none = TriangleChannel::displacement(surface.topology().clone(), &TriangleOptions::default()).unwrap();
    let mut object = TriangleObject::new(&context, surface, none, DAffine3::IDENTITY).unwrap();
    assert!(!object.is_bendable());
    let error = stroke(SculptMode::Pinch).apply(&context, &mut object).unwrap_err().to_string();
    assert!(error.contains("no vector displacement"), "{error}");
}
