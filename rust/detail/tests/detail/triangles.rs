//! Dabs and strokes on triangle meshes against closed forms, against every vertex of the tessellation looked at one by
//! one, and against themselves.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, Brush, Canvas, Collider, Dab, DabReport, Falloff, ImprintSettings, Imprinter, Moment, Motion, PaintMode,
    Pose, SculptMode, Stroke, StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{Node, Pattern, TriangleChannel, TriangleOptions, TriangleValues};
use relievo_tiles::{ColorTexel, Rgba8, Vector};

use crate::shapes::{fine_values, octahedral_ball, triangle_plane, value_bytes};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);
const RED: [f32; 4] = [0.8, 0.05, 0.02, 1.0];

fn object(context: &Context, mesh: &Mesh, segments: u32, budget: u64, transform: DAffine3) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let options = TriangleOptions { segments, budget };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
    let paint = TriangleChannel::of_color(surface.topology().clone(), BLANK, &options).unwrap();
    let mut object = TriangleObject::new(context, surface, displacement, transform).unwrap();
    object.set_paint(paint).unwrap();
    object
}

fn small(context: &Context) -> TriangleObject {
    object(context, &triangle_plane(6), 16, 1 << 24, DAffine3::IDENTITY)
}

fn dab(center: DVec3, half: DVec3, falloff: Falloff, action: Action) -> Dab {
    Dab { brush: Brush::new(center, DMat3::IDENTITY, half, falloff).unwrap(), action, strength: 1.0 }
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

fn paint(mode: PaintMode) -> Action {
    Action::Paint { mode, color: RED }
}

fn line(points: &[[f64; 3]], settings: StrokeSettings, action: Action) -> Stroke {
    let points = points.iter().map(|p| StrokePoint::new(DVec3::from(*p), 1.0)).collect();
    Stroke::new(points, settings, Falloff::Smooth, action)
}

#[test]
fn a_dab_of_draw_has_its_falloff_at_every_vertex_of_the_tessellation() {
    let context = Context::serial();
    let center = DVec3::new(2.9, 3.2, 0.0);
    let half = DVec3::new(1.2, 0.8, 0.5);
    for (falloff, name) in Falloff::NAMES {
        let mut object = small(&context);
        let bytes = object.displacement().bytes();
        let report = object.dab(&context, &dab(center, half, falloff, sculpt(SculptMode::Draw, 0.25))).unwrap();
        let displaced = object.displaced().unwrap();
        for (face, pattern, node) in fine_values(&object) {
            let (foot, height) = displaced.at(face, pattern, node);
            let expected = 0.25 * falloff.share(((foot.point.as_dvec3() - center) / half).as_vec3().to_array());
            // Where the box ends a constant falloff is either.
            let near = ((foot.point.as_dvec3() - center).abs() / half).max_element();
            if falloff != Falloff::Constant || (near - 1.0).abs() > 1e-5 {
                assert!((height - expected).abs() < 2e-4, "{name} face {face} {node:?}: {height} {expected}");
            }
        }
        let faces = object.displacement().field().allocated().count();
        assert!(report.allocated as usize == faces && faces > 8 && faces < 40, "{faces}");
        let edges = object.displacement().field().allocated_edges().count() as u64;
        assert_eq!(report.bytes, bytes + 2 * (169 * faces as u64 + 15 * edges));
        assert!(report.changed_texels > 0 && report.refused.is_empty());
    }
}

#[test]
fn erasing_everything_leaves_the_bytes_there_were() {
    let context = Context::serial();
    let mut object = small(&context);
    let [before, painted] = [object.displacement().bytes(), object.paint().unwrap().bytes()];
    let settings = StrokeSettings { radius: 0.7, ..Default::default() };
    let way = [[0.5, 0.5, 0.0], [5.5, 4.0, 0.0], [3.0, 6.5, 0.0]];
    line(&way, settings, sculpt(SculptMode::Draw, 0.1)).apply(&context, &mut object).unwrap();
    line(&way, settings, paint(PaintMode::Mix)).apply(&context, &mut object).unwrap();
    assert!(object.displacement().bytes() > before && object.paint().unwrap().bytes() > painted);
    let all = |action| dab(DVec3::new(3.0, 3.0, 0.0), DVec3::splat(30.0), Falloff::Constant, action);
    let report = object.dab(&context, &all(sculpt(SculptMode::Erase, 0.0))).unwrap();
    assert!(report.freed > 0);
    object.dab(&context, &all(paint(PaintMode::Erase))).unwrap();
    assert_eq!([object.displacement().bytes(), object.paint().unwrap().bytes()], [before, painted]);
    assert!(object.displacement().field().vertices().flatten().all(|value| value.to_f32() == 0.0));
}

#[test]
fn colours_are_mixed_at_every_vertex_and_continuous_between() {
    let context = Context::serial();
    let mut object = small(&context);
    let (center, half) = (DVec3::new(3.1, 2.8, 0.0), DVec3::splat(1.1));
    object.dab(&context, &dab(center, half, Falloff::Linear, paint(PaintMode::Mix))).unwrap();
    let field = object.paint().unwrap().field();
    for (face, pattern, node) in fine_values(&object) {
        let place = object.displaced().unwrap().point(face, pattern, node).as_dvec3();
        let share = Falloff::Linear.share(((place - center) / half).as_vec3().to_array());
        let expected = Rgba8::of_color(BLANK + (Vec4::from(RED) - BLANK) * share);
        let found = field.texel(face, pattern, node);
        let off = found.0.iter().zip(expected.0).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(off <= 1, "face {face} {node:?}: {found:?} {expected:?}");
    }
}

#[test]
fn a_dab_between_the_vertices_of_faces_takes_no_memory() {
    let context = Context::serial();
    let mut object = small(&context);
    let bytes = object.displacement().bytes();
    let tiny = dab(DVec3::new(2.31, 2.11, 0.0), DVec3::splat(1e-3), Falloff::Constant, sculpt(SculptMode::Draw, 0.1));
    let report = object.dab(&context, &tiny).unwrap();
    assert_eq!((report.changed_texels, report.bytes), (0, bytes));
    let beside = dab(DVec3::new(2.31, 2.11, 3.0), DVec3::splat(1.0), Falloff::Constant, sculpt(SculptMode::Draw, 0.1));
    assert_eq!(object.dab(&context, &beside).unwrap(), DabReport { bytes, ..Default::default() });
    let mut unpainted = TriangleObject::new(
        &context,
        object.surface().clone(),
        TriangleChannel::displacement(object.surface().topology().clone(), &TriangleOptions::default()).unwrap(),
        DAffine3::IDENTITY,
    )
    .unwrap();
    assert!(unpainted.dab(&context, &Dab { action: paint(PaintMode::Mix), ..tiny.clone() }).is_err());
    assert!(object.dab(&context, &Dab { strength: f32::NAN, ..tiny }).is_err());
}

#[test]
fn what_the_budget_refuses_stays_as_it_was_without_cracks() {
    let context = Context::serial();
    let mesh = triangle_plane(6);
    let vertices = 4 * mesh.points.len() as u64;
    let mut object = object(&context, &mesh, 16, vertices + 6 * 4 * (169 + 45), DAffine3::IDENTITY);
    let big = dab(DVec3::new(3.0, 3.0, 0.0), DVec3::splat(2.0), Falloff::Constant, sculpt(SculptMode::Draw, 0.2));
    let report = object.dab(&context, &big).unwrap();
    assert!(!report.refused.is_empty() && report.bytes <= object.displacement().budget());
    // A vertex has moved only where all its faces have blocks.
    let field = object.displacement().field();
    let topology = field.topology();
    for vertex in 0..topology.vertex_count() as u32 {
        let whole = topology.faces_around(vertex).all(|(face, _)| field.is_allocated(face));
        assert!(whole || field.vertex(vertex).to_f32() == 0.0);
    }
    let again = object.dab(&context, &Dab { action: paint(PaintMode::Mix), ..big }).unwrap();
    assert!(!again.refused.is_empty());
}

#[test]
fn strokes_are_sums_of_dabs_and_the_same_with_any_number_of_threads() {
    let settings = StrokeSettings { radius: 0.6, spacing: 0.5, ..Default::default() };
    let way = [[0.6, 0.9, 0.02], [5.1, 3.0, -0.01]];
    let mut results = Vec::new();
    for threads in [1, 2, 5] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut object = small(&context);
        let stroke = line(&way, settings, sculpt(SculptMode::Draw, 0.05));
        let report = stroke.apply(&context, &mut object).unwrap();
        assert_eq!((report.dabs as usize, report.missed), (stroke.stations().unwrap().len(), 0));
        if threads == 1 {
            let centers: Vec<DVec3> =
                stroke.stations().unwrap().iter().map(|station| station.position.with_z(0.0)).collect();
            let displaced = object.displaced().unwrap();
            for (face, pattern, node) in fine_values(&object) {
                let (foot, height) = displaced.at(face, pattern, node);
                let share = |center: &DVec3| {
                    Falloff::Smooth.share(((foot.point.as_dvec3() - *center) / 0.6).as_vec3().to_array())
                };
                let expected: f32 = 0.05 * centers.iter().map(share).sum::<f32>();
                assert!((height - expected).abs() < 4e-4, "{height} {expected}");
            }
        }
        let mut report = line(&way, settings, paint(PaintMode::Mix)).apply(&context, &mut object).unwrap();
        report
            .report
            .merge(line(&way, settings, sculpt(SculptMode::Smooth, 0.0)).apply(&context, &mut object).unwrap().report);
        line(&way, settings, sculpt(SculptMode::Inflate, 0.01)).apply(&context, &mut object).unwrap();
        object.renew(&context).unwrap();
        let pieces: Vec<_> = report.report.changed.iter().map(|face| object.piece(*face).unwrap()).collect();
        results.push((value_bytes(object.displacement()), value_bytes(object.paint().unwrap()), report, pieces));
    }
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn every_mode_does_what_it_says() {
    let context = Context::serial();
    let heights = |object: &TriangleObject| -> Vec<f32> {
        fine_values(object)
            .map(|(face, pattern, node)| object.displacement().field().at(face, pattern, node) as f32)
            .collect()
    };
    let roughness = |object: &TriangleObject| -> f64 {
        let field = object.displacement().field();
        let pattern = field.pattern();
        let rings = fine_values(object).filter(|(_, _, node)| node.ring > 0).map(|(face, _, node)| {
            let ring = pattern.one_ring(node);
            let mean: f64 = ring.nodes().iter().map(|node| field.at(face, pattern, *node)).sum::<f64>() / 6.0;
            (field.at(face, pattern, node) - mean).powi(2)
        });
        rings.sum()
    };
    let center = DVec3::new(3.0, 3.0, 0.0);
    let apply = |object: &mut TriangleObject, mode, height| {
        object.dab(&context, &dab(center, DVec3::splat(1.5), Falloff::Smooth, sculpt(mode, height))).unwrap()
    };
    for (mode, name) in SculptMode::NAMES.into_iter().filter(|(mode, _)| !mode.needs_vectors()) {
        let mut object = small(&context);
        // Steep, so that it can be smoothed.
        for k in 0..5 {
            let at = DVec3::new(2.0 + 0.5 * f64::from(k), 3.0, 0.0);
            object
                .dab(&context, &dab(at, DVec3::new(0.2, 0.2, 1.0), Falloff::Constant, sculpt(SculptMode::Draw, 0.2)))
                .unwrap();
        }
        let (before, rough) = (heights(&object), roughness(&object));
        let report = apply(&mut object, mode, 0.3);
        let after = heights(&object);
        assert!(report.changed_texels > 0, "{name}");
        let (sum, most) =
            (after.iter().sum::<f32>() - before.iter().sum::<f32>(), after.iter().fold(0f32, |a, b| a.max(*b)));
        match mode {
            SculptMode::Draw | SculptMode::Inflate | SculptMode::Layer | SculptMode::Clay => {
                assert!(sum > 1.0, "{name}")
            }
            SculptMode::Smooth => assert!(roughness(&object) < 0.7 * rough, "{name}"),
            _ => assert!(sum < -1.0 && most < 0.21, "{name} {sum} {most}"),
        }
    }
}

#[test]
fn a_brush_finds_the_displaced_surface_and_its_normal() {
    let context = Context::serial();
    let turn = DAffine3::from_rotation_x(0.4) * DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0));
    let mut object = object(&context, &triangle_plane(6), 32, 1 << 24, turn);
    let at = |p: DVec3| turn.transform_point3(p);
    let brush = Brush::new(at(DVec3::new(3.0, 3.0, 0.0)), turn.matrix3, DVec3::splat(2.5), Falloff::Smooth).unwrap();
    object.dab(&context, &Dab { brush, action: sculpt(SculptMode::Draw, 0.5), strength: 1.0 }).unwrap();
    object.renew(&context).unwrap();
    let found = object.nearest(&context, at(DVec3::new(3.0, 3.0, 2.0)), 5.0).unwrap().unwrap();
    assert!((found.point - at(DVec3::new(3.0, 3.0, 0.5))).length() < 1e-3, "{found:?}");
    assert!((found.normal - turn.transform_vector3(DVec3::Z)).length() < 2e-2, "{found:?}");
    assert!((found.distance - 1.5).abs() < 1e-3);
    assert!(object.nearest(&context, at(DVec3::new(3.0, 3.0, 2.0)), 1.4).unwrap().is_none());
    assert!(object.nearest(&context, DVec3::NAN, 1.0).unwrap().is_none());
    // On the slope the normal leans away from the middle.
    let found = object.nearest(&context, at(DVec3::new(4.2, 3.0, 0.3)), 1.0).unwrap().unwrap();
    assert!(turn.inverse().transform_vector3(found.normal).x > 0.15, "{found:?}");
}

#[test]
fn meshes_that_are_no_manifold_or_degenerate_can_be_sculpted() {
    let context = Context::serial();
    let mut mesh = triangle_plane(3);
    let corner = mesh.points.len() as u32;
    // A third face on an edge, one without an area, one folded onto another and wound the other way, an unused point.
    mesh.points.extend([[1.5, 1.0, 1.0], [1.5, 1.0, 0.0], [9.0, 9.0, 9.0]]);
    for face in [[5, 6, corner], [5, 6, corner + 1], [6, 5, 9], [5, 9, 6]] {
        mesh.face_sizes.push(3);
        mesh.corners.extend(face);
    }
    let mut object = object(&context, &mesh, 8, 1 << 24, DAffine3::IDENTITY);
    let settings = StrokeSettings { radius: 0.8, ..Default::default() };
    for action in [sculpt(SculptMode::Draw, 0.2), sculpt(SculptMode::Smooth, 0.0), paint(PaintMode::Blur)] {
        let report = line(&[[0.5, 0.5, 0.1], [2.5, 1.5, 0.0]], settings, action).apply(&context, &mut object).unwrap();
        assert!(report.dabs > 0);
    }
    object.renew(&context).unwrap();
    for face in 0..object.surface().topology().face_count() as u32 {
        let (piece, colors) = object.piece(face).unwrap();
        assert!(piece.points.iter().chain(&piece.normals).flatten().all(|value| value.is_finite()));
        assert_eq!(colors.len(), piece.points.len());
    }
}

#[test]
fn coarser_levels_are_edited_without_losing_what_finer_ones_have() {
    let context = Context::serial();
    let center = DVec3::new(2.9, 3.2, 0.0);
    // Tall, so that what is there does not matter.
    let big = dab(center, DVec3::new(1.6, 1.6, 100.0), Falloff::Smooth, sculpt(SculptMode::Draw, 0.3));
    let fine = dab(center, DVec3::new(0.7, 0.7, 100.0), Falloff::Linear, sculpt(SculptMode::Draw, 0.1));
    let heights = |object: &TriangleObject| -> Vec<f32> {
        let displaced = object.displaced().unwrap();
        fine_values(object).map(|(face, pattern, node)| displaced.at(face, pattern, node).1).collect()
    };
    let coarse = |level: u32, dabs: &[(u32, &Dab)]| {
        let mut object = small(&context);
        for (at, dab) in dabs {
            object.set_level(*at).unwrap();
            object.dab(&context, dab).unwrap();
        }
        object.set_level(level).unwrap();
        object
    };
    for level in [1, 2] {
        // A coarse edit alone is the brush at the coarser vertices and linear between them, in less memory.
        let alone = coarse(level, &[(level, &big)]);
        let pattern = alone.displacement().field().pattern().coarser(level);
        let field = alone.displacement().field();
        assert!(field.allocated().all(|face| field.face_pattern(face) == Some(pattern)));
        assert!(alone.displacement().bytes() < coarse(0, &[(0, &big)]).displacement().bytes() / 2);
        let whole = coarse(0, &[(0, &big)]);
        let off = heights(&alone).iter().zip(heights(&whole)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 0.02, "{off}");
        // The detail that was there stays on top of it.
        let first = coarse(level, &[(0, &fine)]);
        let both = coarse(level, &[(0, &fine), (level, &big)]);
        let added: Vec<f32> = heights(&both).iter().zip(heights(&first)).map(|(a, b)| a - b).collect();
        for (added, alone) in added.iter().zip(heights(&alone)) {
            assert!((added - alone).abs() < 2e-3, "{added} {alone}");
        }
        // At the coarser vertices it is exact but for rounding, however fine the face is.
        for (face, fine, node) in fine_values(&both) {
            let node = fine.weights(node).map(|weight| weight >> level);
            let Some(node) = pattern.at_weights(node) else { continue };
            let [a, b] = [&both, &alone].map(|object| object.displacement().field().at(face, pattern, node));
            let detail = first.displacement().field().at(face, pattern, node);
            assert!((a - b - detail).abs() < 1e-3);
        }
        // The finest level after a coarser one refines what is there.
        let after = coarse(0, &[(level, &big), (0, &fine)]);
        let off = heights(&after).iter().zip(heights(&both)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 2e-2, "{level} {off}");
    }
    assert!(small(&context).set_level(3).is_err());
    // Colours too.
    let mut object = small(&context);
    object.dab(&context, &Dab { action: paint(PaintMode::Mix), ..fine.clone() }).unwrap();
    object.set_level(2).unwrap();
    let report = object.dab(&context, &Dab { action: paint(PaintMode::Multiply), ..big }).unwrap();
    assert!(report.changed_texels > 100);
}

#[test]
fn vectors_move_what_is_shown_and_found() {
    let context = Context::serial();
    let mut object = small(&context);
    let options = TriangleOptions { segments: 16, budget: 1 << 24 };
    let mut vectors = TriangleChannel::vectors(object.surface().topology().clone(), &options).unwrap();
    // The vertex in the middle, whose first face has the side along x there or against it.
    let up = Vector([0.0, 0.0, 0.5].map(half::f16::from_f32));
    vectors.write(TriangleValues { vertices: vec![(24, up)], ..Default::default() }).unwrap();
    object.set_vectors(vectors).unwrap();
    object.commit(&context).unwrap();
    let found = object.nearest(&context, DVec3::new(3.0, 3.0, 2.0), 3.0).unwrap().unwrap();
    assert!((found.point - DVec3::new(3.0, 3.0, 0.5)).length() < 1e-3, "{found:?}");
    let around: Vec<u32> = object.surface().topology().faces_around(24).map(|(face, _)| face).collect();
    for face in around {
        let (piece, _) = object.piece(face).unwrap();
        assert!(piece.points.iter().any(|point| point[2] == 0.5));
    }
    object
        .vectors_mut()
        .unwrap()
        .write(TriangleValues { vertices: vec![(24, Vector::ZERO)], ..Default::default() })
        .unwrap();
    object.commit(&context).unwrap();
    assert_eq!(object.nearest(&context, DVec3::new(3.0, 3.0, 2.0), 3.0).unwrap().unwrap().distance, 2.0);
}

/// A closed box from `low` to `high`.
fn solid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let points =
        (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect();
    let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh::new(points, vec![4; 6], quads.concat())
}

#[test]
fn a_box_leaves_its_print_and_nothing_beside_it() {
    let mut results = Vec::new();
    for threads in [1, 3] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let turn = DAffine3::from_rotation_y(0.7) * DAffine3::from_scale(DVec3::splat(2.0));
        let mut object = object(&context, &triangle_plane(6), 16, 1 << 24, turn);
        let collider = Collider::of_mesh(&context, &solid([2.1, 2.3, -0.2], [4.3, 3.6, 1.0]), turn).unwrap();
        let settings = ImprintSettings { jitter: 0.05, ..Default::default() };
        let report = Imprinter::new().imprint(&context, &mut object, &collider, &settings, Moment::default()).unwrap();
        assert!(report.changed_coefficients > 800 && report.refused.is_empty() && report.clamped < 20, "{report:?}");
        let slack = report.voxel_diagonal as f32;
        assert!(slack < 0.1);
        let displaced = object.displaced().unwrap();
        for (face, pattern, node) in fine_values(&object) {
            let (foot, height) = displaced.at(face, pattern, node);
            let [x, y, _] = foot.point.to_array();
            let inside = (x - 2.1).min(4.3 - x).min(y - 2.3).min(3.6 - y);
            if inside > slack {
                assert!(height <= -0.2 + 0.5 * slack && height > -0.2 - slack, "{x} {y}: {height}");
            } else if inside < -slack {
                assert_eq!(height, 0.0, "{x} {y}");
            }
        }
        // Once out, nothing moves any more but by the voxels.
        let again = Imprinter::new()
            .imprint(&context, &mut object, &collider, &settings, Moment { frame: 1, ..Default::default() })
            .unwrap();
        assert!(again.changed_coefficients < report.changed_coefficients / 4);
        results.push((value_bytes(object.displacement()), report));
    }
    assert!(results[0] == results[1]);
}

#[test]
fn what_is_pressed_goes_against_the_interpolated_normal() {
    let context = Context::serial();
    let mut object = object(&context, &octahedral_ball(3, 1.0), 32, 1 << 26, DAffine3::IDENTITY);
    assert!(object.surface().volume() > 0.0);
    let collider = Collider::of_mesh(&context, &solid([0.8, -1.5, -1.5], [2.0, 1.5, 1.5]), DAffine3::IDENTITY).unwrap();
    let settings = ImprintSettings { voxels: 1 << 22, max_displacement: 0.5, ..Default::default() };
    let report = Imprinter::new().imprint(&context, &mut object, &collider, &settings, Moment::default()).unwrap();
    let slack = report.voxel_diagonal as f32;
    assert!(slack < 0.02 && report.refused.is_empty(), "{report:?}");
    let displaced = object.displaced().unwrap();
    let (mut pressed, mut bent) = (0, 0);
    for (face, pattern, node) in fine_values(&object) {
        let (foot, height) = displaced.at(face, pattern, node);
        if foot.point.x < 0.8 - slack {
            assert_eq!(height, 0.0, "{}", foot.point);
        }
        if foot.point.x < 0.8 + slack {
            continue;
        }
        // To the plane, against a normal.
        let along = |normal: Vec3| (0.8 - foot.point.x) / normal.x;
        assert!((height - along(foot.normal)).abs() < slack, "{}: {height} {}", foot.point, along(foot.normal));
        let [a, b, c] = object.surface().corner_points(face).map(Vec3::from);
        let flat = (b - a).cross(c - a).normalize();
        pressed += 1;
        bent += i32::from((height - along(flat)).abs() > slack);
    }
    assert!(pressed > 300 && bent > 50, "{pressed} {bent}");
}

#[test]
fn what_travels_leaves_a_track_without_gaps() {
    let context = Context::serial();
    let mut object = object(&context, &triangle_plane(6), 16, 1 << 24, DAffine3::IDENTITY);
    let start = DAffine3::from_translation(DVec3::new(-2.0, 0.0, 0.0));
    let mut collider = Collider::of_mesh(&context, &solid([2.8, 2.8, -0.1], [3.2, 3.2, 0.5]), start).unwrap();
    let pose = |transform| Pose { transform, points: None };
    let end = DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0));
    let motion = Motion::new(&collider, pose(start), pose(end)).unwrap();
    let settings = ImprintSettings::default();
    let report =
        Imprinter::new().sweep(&context, &mut object, &mut collider, &motion, &settings, Moment::default()).unwrap();
    assert!(report.sub_steps > 20);
    let displaced = object.displaced().unwrap();
    for (face, pattern, node) in fine_values(&object) {
        let (foot, height) = displaced.at(face, pattern, node);
        if (foot.point.y - 3.0).abs() < 0.15 && (foot.point.x - 3.0).abs() < 2.0 {
            assert!((height + 0.1).abs() < 0.03, "{} {height}", foot.point);
        }
    }
}

#[test]
fn a_stroke_on_a_scanned_mesh_costs_only_what_it_touches() {
    let data = std::env::var_os("RELIEVO_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")), PathBuf::from);
    let path = data.join("meshes/horse.ply");
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mesh = relievo_meshio::read(&context, &path).unwrap();
    let mut object = object(&context, &mesh, 16, 1 << 30, DAffine3::IDENTITY);
    assert!(object.surface().topology().face_count() > 90_000);
    let (low, high) = mesh.bounds().unwrap();
    let [low, high] = [low, high].map(|p| DVec3::from(p.map(f64::from)));
    let size = (high - low).length();
    let settings = StrokeSettings { radius: (0.01 * size) as f32, reach: 1000.0, ..Default::default() };
    let middle = 0.5 * (low + high);
    let way = [middle + (high - low) * DVec3::new(0.0, 0.6, 0.1), middle + (high - low) * DVec3::new(0.0, 0.6, -0.1)];
    let stroke = line(&way.map(|p| p.to_array()), settings, sculpt(SculptMode::Draw, (0.002 * size) as f32));
    let report = stroke.apply(&context, &mut object as &mut dyn Canvas).unwrap();
    assert!(report.missed == 0 && report.report.changed.len() > 50, "{:?}", report.missed);
    let allocated = object.displacement().field().allocated().count();
    assert!(allocated < 10_000, "{allocated}");
    println!("{} faces of {}, {} bytes", allocated, mesh.face_count(), object.displacement().bytes());
}

#[test]
fn smoothing_moves_what_is_near_a_dent_toward_the_mean_of_its_neighbours() {
    let points = (0..8).map(|k: u32| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f32 - 0.5)).collect();
    let cube =
        Mesh::new(points, vec![4; 6], vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]);
    let place = DAffine3::from_translation(DVec3::new(2.9, 3.2, 0.3));
    let moment = Moment { frame: 0, step: 0, pair: 0 };
    let pressed = |smoothing: f32, threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut object = small(&context);
        let collider = Collider::of_mesh(&context, &cube, place).unwrap();
        let settings = ImprintSettings { voxels: 1 << 16, smoothing, smoothing_passes: 1, ..Default::default() };
        Imprinter::new().imprint(&context, &mut object, &collider, &settings, moment).unwrap();
        object
    };
    let (sharp, smooth) = (pressed(0.0, 1), pressed(0.5, 1));
    assert!(value_bytes(smooth.displacement()) == value_bytes(pressed(0.5, 3).displacement()));
    let height = |object: &TriangleObject, (face, pattern, node): (u32, Pattern, Node)| {
        object.displacement().field().at(face, pattern, node) as f32
    };
    let near = |(face, pattern, node): (u32, Pattern, Node)| {
        let ring = pattern.one_ring(node);
        ring.nodes().iter().map(|node| (face, pattern, *node)).collect::<Vec<_>>()
    };
    let (mut moved, mut still) = (0, 0);
    // Those whose second neighbours are in the face too.
    for knot in fine_values(&sharp).filter(|(_, _, node)| node.ring > 2) {
        let [old, new] = [&sharp, &smooth].map(|object| height(object, knot));
        let rings: Vec<_> = near(knot).into_iter().flat_map(|knot| near(knot).into_iter().chain([knot])).collect();
        let reached = rings.iter().any(|knot| height(&sharp, *knot) != 0.0);
        let around: Vec<f32> = near(knot).iter().map(|knot| height(&sharp, *knot)).collect();
        let mean = around.iter().sum::<f32>() / around.len() as f32;
        let expected = if reached { old + 0.5 * (mean - old) } else { 0.0 };
        assert!((new - expected).abs() < 2e-4, "{knot:?}: {new} {expected}");
        moved += i32::from((new - old).abs() > 1e-2);
        still += i32::from(!reached);
    }
    assert!(moved > 20 && still > 100, "{moved} {still}");
}
