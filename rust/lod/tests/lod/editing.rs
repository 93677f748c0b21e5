//! Edits of progressive meshes, and the levels that follow.

use std::sync::Arc;

use glam::{Quat, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, Handle, Region};

use crate::shapes::{Triangles, lifted, torus};

fn build((points, triangles): &Triangles) -> Arc<Progressive> {
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

fn pull(center: [f32; 3], radius: f32) -> Edit {
    let region = Region { center, radius, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.1, 0.2, 0.3], axis: [0.0, 0.6, 0.8], angle: 0.7 };
    Edit { handles: vec![handle], ..Edit::default() }
}

/// Everything turns and moves.
fn rigid() -> (Edit, impl Fn(Vec3) -> Vec3) {
    let region = Region { center: [0.3, 0.1, -0.2], radius: 100.0, falloff: Falloff::Constant };
    let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
    let handle = Handle { region, translation: [0.5, -0.3, 0.2], axis: axis.to_array(), angle: 2.0 };
    let motion = move |point: Vec3| {
        let center = Vec3::from(region.center);
        Quat::from_axis_angle(axis, 2.0) * (point - center) + center + Vec3::from(handle.translation)
    };
    (Edit { handles: vec![handle], ..Edit::default() }, motion)
}

/// The largest distance between points of the same number.
fn apart(one: &[[f32; 3]], other: impl Iterator<Item = Vec3>) -> f32 {
    one.iter().zip(other).map(|(one, other)| Vec3::from(*one).distance(other)).fold(0.0, f32::max)
}

fn vectors(points: &[[f32; 3]]) -> impl Iterator<Item = Vec3> {
    points.iter().map(|point| Vec3::from(*point))
}

fn bumps(n: u32) -> Triangles {
    lifted(n, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin())
}

#[test]
fn every_fine_vertex_follows_a_rigid_motion_of_the_base() {
    let context = Context::serial();
    for shape in [torus(120, 60), bumps(60)] {
        let mesh = build(&shape);
        let mut active = ActiveMesh::new(&mesh);
        let (edit, motion) = rigid();
        assert_eq!(active.edit(&context, &edit).unwrap(), mesh.base_vertices().len());
        active.adapt(&context, Cut::FINEST);
        let finest = active.extract();
        let worst = apart(&finest.points, vectors(&shape.0).map(motion));
        assert!(worst < 3e-6, "{worst}");
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 2.0);
        let mut plain = ActiveMesh::new(&mesh);
        plain.adapt(&context, Cut::FINEST);
        let worst = apart(&finest.normals, vectors(&plain.extract().normals).map(|normal| turn * normal));
        assert!(worst < 2e-5, "{worst}");
    }
}

#[test]
fn coarser_levels_follow_a_rigid_motion_of_the_finest() {
    let context = Context::serial();
    for shape in [torus(120, 60), bumps(60)] {
        let mesh = build(&shape);
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::FINEST);
        let (edit, motion) = rigid();
        assert_eq!(active.edit(&context, &edit).unwrap(), shape.0.len());
        for faces in [2000, 500, 60] {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            let mut plain = ActiveMesh::new(&mesh);
            plain.adapt(&context, cut);
            let worst = apart(&active.extract().points, vectors(&plain.extract().points).map(&motion));
            assert!(worst < 2e-4, "{faces}: {worst}");
        }
        active.adapt(&context, Cut::FINEST);
        let worst = apart(&active.extract().points, vectors(&shape.0).map(&motion));
        assert!(worst < 1e-5, "{worst}");
    }
}

#[test]
fn an_edit_is_the_same_whatever_way_finer_levels_were_reached() {
    let context = Context::serial();
    for (shape, center) in [(torus(120, 60), [1.4, 0.0, 0.0]), (bumps(60), [0.5, 0.5, 0.0])] {
        let mesh = build(&shape);
        let level = Cut::of_faces(&mesh, 600);
        let edited = || {
            let mut active = ActiveMesh::new(&mesh);
            active.adapt(&context, level);
            active.edit(&context, &pull(center, 0.5)).unwrap();
            active
        };
        let mut straight = edited();
        let before = straight.extract();
        straight.adapt(&context, Cut::FINEST);
        let straight = straight.extract();
        assert!(apart(&straight.points, vectors(&shape.0)) > 0.1);
        let mut about = edited();
        for faces in [300, 60, 900, 400, 0] {
            about.adapt(&context, Cut::of_faces(&mesh, faces));
        }
        about.adapt(&context, level);
        let worst = apart(&about.extract().points, vectors(&before.points));
        assert!(worst < 2e-6, "back at the level: {worst}");
        about.adapt(&context, Cut::FINEST);
        let worst = apart(&about.extract().points, vectors(&straight.points));
        assert!(worst < 1e-5, "finest: {worst}");
    }
}

#[test]
fn detail_turns_with_the_coarse_shape() {
    // A plate with fine grooves; its coarse half turns upright.
    let context = Context::serial();
    let shape = lifted(100, |x, _| 0.004 * (90.0 * x).sin());
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::of_error(0.01));
    assert!(active.triangle_count() < 400);
    let region = Region { center: [0.5, 0.5, 0.0], radius: 10.0, falloff: Falloff::Constant };
    let quarter = std::f32::consts::FRAC_PI_2;
    let handle = Handle { region, translation: [0.0; 3], axis: [1.0, 0.0, 0.0], angle: quarter };
    active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    active.adapt(&context, Cut::FINEST);
    for (point, built) in active.extract().points.iter().zip(&shape.0) {
        // y goes to z, and the grooves to −y.
        assert!((point[1] - (0.5 - built[2])).abs() < 2e-5 && (point[2] - (built[1] - 0.5)).abs() < 2e-5);
    }
}

#[test]
fn what_is_far_from_an_edit_stays_bit_for_bit() {
    let context = Context::serial();
    let shape = torus(120, 60);
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::of_faces(&mesh, 2000));
    active.edit(&context, &pull([1.4, 0.0, 0.0], 0.4)).unwrap();
    active.adapt(&context, Cut::FINEST);
    let finest = active.extract();
    for (now, before) in finest.points.iter().zip(&shape.0) {
        let (now, before) = (Vec3::from(*now), Vec3::from(*before));
        match before.distance(Vec3::new(1.4, 0.0, 0.0)) {
            1.6.. => assert_eq!(now, before),
            1.0.. => assert!(now.distance(before) < 1e-4),
            _ => {}
        }
    }
}

#[test]
fn influences_fall_and_anchors_hold() {
    let context = Context::serial();
    let shape = lifted(40, |_, _| 0.0);
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::FINEST);
    let region = |x: f32, radius: f32| Region { center: [x, 0.5, 0.0], radius, falloff: Falloff::Linear };
    let handle = |x: f32| Handle { region: region(x, 0.4), translation: [0.0, 0.0, 1.0], axis: [0.0; 3], angle: 0.0 };
    let edit = Edit { handles: vec![handle(0.3), handle(0.7)], anchors: vec![region(0.5, 0.1)] };
    active.edit(&context, &edit).unwrap();
    for [x, y, z] in active.extract().points {
        let near = |center: f32, radius: f32| (1.0 - (x - center).hypot(y - 0.5) / radius).max(0.0);
        let sum = near(0.3, 0.4) + near(0.7, 0.4);
        assert!((z - sum.min(1.0) * (1.0 - near(0.5, 0.1))).abs() < 1e-5, "{x} {y} {z}");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let shape = bumps(80);
    let mesh = build(&shape);
    let run = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::of_faces(&mesh, 3000));
        active.edit(&context, &pull([0.4, 0.6, 0.0], 0.5)).unwrap();
        active.adapt(&context, Cut::BASE);
        active.edit(&context, &pull([0.7, 0.2, 0.0], 0.4)).unwrap();
        active.adapt(&context, Cut::FINEST);
        active.extract()
    };
    let one = run(1);
    assert!(run(2) == one && run(5) == one);
}

#[test]
fn edits_that_reach_nothing_or_mean_nothing_are_refused() {
    let shape = torus(40, 20);
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    let before = active.extract();
    let context = Context::serial();
    let mut fails = |edit: Edit| active.edit(&context, &edit).unwrap_err().to_string();
    assert!(fails(pull([9.0, 9.0, 9.0], 0.5)).contains("no vertex"));
    assert!(fails(Edit::default()).contains("no vertex"));
    assert!(fails(pull([1.4, 0.0, 0.0], -1.0)).contains("handle 0"));
    assert!(fails(pull([1.4, f32::NAN, 0.0], 1.0)).contains("handle 0"));
    let mut endless = pull([1.4, 0.0, 0.0], 1.0);
    endless.handles[0].translation[1] = f32::INFINITY;
    assert!(fails(endless).contains("handle 0"));
    let mut far = pull([1.4, 0.0, 0.0], 1.0);
    far.handles[0].translation = [f32::MAX; 3];
    far.handles.push(far.handles[0]);
    far.anchors.push(Region { center: [0.0; 3], radius: 0.0, falloff: Falloff::Smooth });
    assert!(fails(far).contains("anchor 0"));
    assert_eq!(active.extract(), before);
}

#[test]
fn edits_are_taken_back_and_made_again_at_any_level() {
    let context = Context::serial();
    let mesh = build(&torus(120, 60));
    let mut active = ActiveMesh::new(&mesh);
    let levels = [600, 60, 3000].map(|faces| Cut::of_faces(&mesh, faces));
    let mut seen = Vec::new();
    for (cut, center) in levels.into_iter().zip([[1.4, 0.0, 0.0], [-1.2, 0.3, 0.0], [1.3, 0.3, 0.1]]) {
        active.adapt(&context, Cut::FINEST);
        seen.push(active.extract());
        active.adapt(&context, cut);
        active.edit(&context, &pull(center, 0.5)).unwrap();
    }
    active.adapt(&context, Cut::FINEST);
    seen.push(active.extract());
    for expected in seen.iter().rev().skip(1) {
        assert!(active.undo(&context));
        let worst = apart(&active.extract().points, vectors(&expected.points));
        assert!(worst < 1e-5, "{worst}");
    }
    assert!(!active.undo(&context) && active.extract() == seen[0]);
    for expected in &seen[1..] {
        assert!(active.redo(&context));
        let worst = apart(&active.extract().points, vectors(&expected.points));
        assert!(worst < 1e-5, "{worst}");
    }
    assert!(!active.redo(&context));
}

#[test]
fn an_edited_mesh_becomes_one_of_its_own_with_the_same_levels() {
    let context = Context::serial();
    let shape = torus(120, 60);
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::of_faces(&mesh, 600));
    active.edit(&context, &pull([1.4, 0.0, 0.0], 0.6)).unwrap();
    let before = active.extract();
    let settled = active.settled(&context);
    assert!(apart(&active.extract().points, vectors(&before.points)) < 2e-6, "the view has not changed");
    let mut bytes = Vec::new();
    settled.write(&context, &mut bytes).unwrap();
    let read = Arc::new(Progressive::read(&context, &mut bytes.as_slice(), usize::MAX).unwrap());
    let mut again = ActiveMesh::new(&read);
    for cut in [Cut::FINEST, Cut::of_faces(&mesh, 4000), Cut::of_faces(&mesh, 600), Cut::BASE] {
        active.adapt(&context, cut);
        again.adapt(&context, cut);
        let (expected, made) = (active.extract(), again.extract());
        assert_eq!(made.triangles, expected.triangles);
        assert!(apart(&made.points, vectors(&expected.points)) < 4e-6);
    }
}

#[test]
fn fine_vertices_go_with_a_surface_that_is_stretched() {
    let context = Context::serial();
    let shape = lifted(80, |x, y| 0.01 * (5.0 * x).sin() * (4.0 * y).sin());
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::of_faces(&mesh, 300));
    let region = Region { center: [0.5, 0.5, 0.0], radius: 0.45, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.15, 0.0, 0.0], axis: [0.0; 3], angle: 0.0 };
    active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    active.adapt(&context, Cut::FINEST);
    let finest = active.extract();
    let up = |[a, b, c]: &[u32; 3]| {
        let corner = |vertex: &u32| Vec3::from(finest.points[*vertex as usize]);
        (corner(b) - corner(a)).cross(corner(c) - corner(a)).normalize_or_zero().z
    };
    let least = finest.triangles.iter().map(up).fold(1.0, f32::min);
    assert!(least > 0.9, "{least}");
}

#[test]
fn an_edit_costs_what_it_touches_and_reaches_the_base() {
    let context = Context::serial();
    let mesh = build(&torus(400, 200));
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::FINEST);
    let vertices = active.vertex_count();
    let near = active.edit(&context, &pull([1.4, 0.0, 0.0], 0.2)).unwrap();
    assert!(near > 300 && near < 1000, "{near}");
    assert!(active.moved_last() < vertices / 20, "{} for {near}", active.moved_last());
    let (everything, _) = rigid();
    assert_eq!(active.edit(&context, &everything).unwrap(), vertices);
    // Every vertex at every level: as many more as there are splits.
    assert_eq!(active.moved_last(), vertices + mesh.splits().count());
    active.adapt(&context, Cut::BASE);
    let mut plain = ActiveMesh::new(&mesh);
    let moved = apart(&active.extract().points, vectors(&plain.extract().points));
    assert!(moved > 0.5, "{moved}");
    plain.edit(&context, &everything).unwrap();
    assert_eq!(plain.moved_last(), mesh.base_vertices().len());
}

#[test]
fn where_a_region_moves_rigidly_all_coarser_levels_do() {
    // Half of a plate is lifted; far from the fold every level is the plate it was, there or up.
    let context = Context::serial();
    let shape = bumps(120);
    let mesh = build(&shape);
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::FINEST);
    let region = Region { center: [0.5, -0.4, 0.0], radius: 0.9, falloff: Falloff::Constant };
    let lift = Handle { region, translation: [0.0, 0.0, 0.05], axis: [0.0; 3], angle: 0.0 };
    active.edit(&context, &Edit { handles: vec![lift], anchors: Vec::new() }).unwrap();
    for faces in [8000, 3000, 1000] {
        let cut = Cut::of_faces(&mesh, faces);
        active.adapt(&context, cut);
        let mut plain = ActiveMesh::new(&mesh);
        plain.adapt(&context, cut);
        let mut counts = [0; 2];
        for (now, before) in active.extract().points.iter().zip(plain.extract().points) {
            let up = match Vec3::from(before).distance(Vec3::from(region.center)) {
                ..0.6 => 0.05,
                1.2.. => 0.0,
                _ => continue,
            };
            counts[usize::from(up > 0.0)] += 1;
            let expected = Vec3::from(before) + Vec3::Z * up;
            assert!(Vec3::from(*now).distance(expected) < 2e-4, "{faces}: {now:?}, not {expected:?}");
        }
        assert!(counts.iter().all(|count| *count > 20), "{faces}: {counts:?}");
    }
}
