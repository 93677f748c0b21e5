//! Strokes of brushes on levels of progressive meshes.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_detail::{
    Action, PaintMode, SculptMode, Stamp, StampImage, StampSettings, Stroke, StrokePoint, StrokeSettings,
};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Extract};

use crate::shapes::{Triangles, lifted};

fn build((points, triangles): &Triangles) -> Arc<Progressive> {
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

fn finest(mesh: &Arc<Progressive>) -> ActiveMesh {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), Cut::FINEST);
    active
}

/// A dab in the middle of the unit square whose first axis is x.
fn dab(mode: SculptMode, height: f32, falloff: Falloff) -> Stroke {
    let points = [0.5, 0.51].map(|x| StrokePoint::new(DVec3::new(x, 0.5, 0.0), 1.0));
    let settings = StrokeSettings { radius: 0.3, spacing: 1.0, reach: 1.0, ..StrokeSettings::default() };
    Stroke::new(points.to_vec(), settings, falloff, Action::Sculpt { mode, height })
}

fn apart(one: &Extract, other: impl Fn(usize) -> Vec3) -> f32 {
    let points = one.points.iter().enumerate();
    points.map(|(index, point)| Vec3::from(*point).distance(other(index))).fold(0.0, f32::max)
}

#[test]
fn drawing_is_the_falloff_along_the_normal_and_is_taken_back_whole() {
    let context = Context::serial();
    let shape = lifted(60, |_, _| 0.0);
    let mesh = build(&shape);
    for mode in [SculptMode::Draw, SculptMode::Layer, SculptMode::Inflate] {
        let mut active = finest(&mesh);
        let before = active.extract();
        let done = active.sculpt(&context, &dab(mode, 0.1, Falloff::Linear)).unwrap();
        assert_eq!((done.dabs, done.missed), (1, 0));
        let made = active.extract();
        let expected = |index: usize| {
            let [x, y, _] = shape.0[index];
            let r = (x - 0.5).hypot(y - 0.5) / 0.3;
            Vec3::new(x, y, 0.1 * (1.0 - r).max(0.0))
        };
        assert!(apart(&made, expected) < 1e-5, "{mode:?}");
        // On the flank the normal leans outwards by the slope of a third.
        let flank = shape.0.iter().position(|[x, y, _]| (x - 0.6).abs() < 9e-3 && (y - 0.5).abs() < 1e-3).unwrap();
        let normal = Vec3::from(made.normals[flank]);
        assert!(normal.distance(Vec3::new(1.0, 0.0, 3.0).normalize()) < 0.02, "{normal}");
        assert!(active.undo(&context) && active.extract() == before && !active.undo(&context));
    }
}

#[test]
fn a_stroke_adds_its_dabs_and_mirrors_them() {
    let context = Context::serial();
    let shape = lifted(60, |_, _| 0.0);
    let mesh = build(&(shape.0.iter().map(|[x, y, z]| [x - 0.5, y - 0.5, *z]).collect(), shape.1.clone()));
    let mut active = finest(&mesh);
    let points = [0.2, 0.31].map(|x| StrokePoint::new(DVec3::new(x, 0.0, 0.0), 1.0)).to_vec();
    let settings = StrokeSettings { radius: 0.1, spacing: 0.5, symmetry_x: Switch::ON, ..StrokeSettings::default() };
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.02 };
    let done = active.sculpt(&context, &Stroke::new(points, settings, Falloff::Linear, action)).unwrap();
    assert_eq!((done.dabs, done.missed), (6, 0));
    let expected = |index: usize| {
        let [x, y] = [shape.0[index][0] - 0.5, shape.0[index][1] - 0.5];
        // A dab reaches less of what those before it have raised.
        let share = |center: f32, z: f32| (1.0 - Vec3::new(x.abs() - center, y, z).length() / 0.1).max(0.0);
        Vec3::new(x, y, [0.2, 0.25, 0.3].into_iter().fold(0.0, |z, center| z + 0.02 * share(center, z)))
    };
    let worst = apart(&active.extract(), expected);
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn flattening_smoothing_pinching_and_erasing_do_what_they_say() {
    let context = Context::serial();
    let shape = lifted(40, |x, y| 0.02 * (20.0 * x).sin() * (16.0 * y).cos());
    let mesh = build(&shape);
    let inside = |[x, y, _]: [f32; 3]| (x - 0.5).abs() < 0.25 && (y - 0.5).abs() < 0.25;
    let built_inside = |points: &[[f32; 3]]| -> Vec<Vec3> {
        let all = points.iter().zip(&shape.0).filter(|(_, built)| inside(**built));
        all.map(|(point, _)| (*point).into()).collect()
    };
    let run = |mode, height| {
        let mut active = finest(&mesh);
        active.sculpt(&context, &dab(mode, height, Falloff::Constant)).unwrap();
        active
    };
    // All in the box comes to one plane.
    let flat = run(SculptMode::Flatten, 0.0).extract();
    let box_points = built_inside(&flat.points);
    let center = box_points.iter().sum::<Vec3>() / box_points.len() as f32;
    let [mut xx, mut xy, mut yy, mut xz, mut yz] = [0.0f32; 5];
    for point in &box_points {
        let d = *point - center;
        (xx, xy, yy, xz, yz) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y, xz + d.x * d.z, yz + d.y * d.z);
    }
    let det = xx * yy - xy * xy;
    let (u, v) = ((xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det);
    let off = |point: &Vec3| (point.z - center.z - u * (point.x - center.x) - v * (point.y - center.y)).abs();
    assert!(box_points.iter().map(off).fold(0.0, f32::max) < 1e-5);
    // Every vertex comes to the mean of its neighbours.
    let smooth = run(SculptMode::Smooth, 0.0).extract();
    let n = 41;
    for (index, built) in shape.0.iter().enumerate().filter(|(_, built)| inside(**built)) {
        let around = [index - 1, index + 1, index - n, index + n, index - n - 1, index + n + 1];
        let mean = around.iter().map(|other| Vec3::from(shape.0[*other])).sum::<Vec3>() / 6.0;
        assert!(Vec3::from(smooth.points[index]).distance(mean) < 1e-5, "{built:?}");
    }
    // To the line through the middle, along the normal there.
    let pinched = run(SculptMode::Pinch, 1.0).extract();
    let line = built_inside(&pinched.points);
    let far = line.iter().map(|point| point.truncate().distance(line[0].truncate())).fold(0.0, f32::max);
    assert!(far < 0.05, "{far}");
    // What was drawn goes again.
    let mut erased = run(SculptMode::Draw, 0.1);
    erased.sculpt(&context, &dab(SculptMode::Erase, 0.0, Falloff::Constant)).unwrap();
    let erased = erased.extract();
    for (index, built) in shape.0.iter().enumerate().filter(|(_, built)| inside(**built)) {
        assert!(Vec3::from(erased.points[index]).distance((*built).into()) < 1e-6);
    }
}

#[test]
fn an_image_is_drawn_across_the_brush() {
    let context = Context::serial();
    let shape = lifted(80, |_, _| 0.0);
    let mesh = build(&shape);
    let mut active = finest(&mesh);
    let ramp: Vec<f32> = (0..64 * 64).map(|index| (index % 64) as f32 / 64.0 + 0.5 / 64.0).collect();
    let image = StampImage::new(64, 64, 1, &ramp).unwrap();
    let stamp = Stamp::new(image, StampSettings::default(), Default::default()).unwrap();
    let stroke = Stroke { stamp: Some(stamp), ..dab(SculptMode::Draw, 0.1, Falloff::Constant) };
    active.sculpt(&context, &stroke).unwrap();
    for ([x, y, _], [.., z]) in shape.0.iter().zip(active.extract().points) {
        let [across, along] = [(x - 0.5) / 0.3, (y - 0.5) / 0.3];
        if across.abs() < 0.9 && along.abs() < 0.9 {
            // Twice as far from the mean as the number is: from −1 to 1 over the box.
            assert!((z - 0.1 * across).abs() < 2e-3, "{x} {y}: {z}");
        } else if across.abs() > 1.1 || along.abs() > 1.1 {
            assert_eq!(z, 0.0);
        }
    }
}

#[test]
fn a_stroke_at_a_coarse_level_keeps_fine_detail_whatever_way_that_is_reached() {
    let context = Context::serial();
    // A plate with fine grooves.
    let shape = lifted(100, |x, _| 0.004 * (90.0 * x).sin());
    let mesh = build(&shape);
    let level = Cut::of_faces(&mesh, 390);
    let sculpted = |mode, falloff| {
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, level);
        assert!(active.triangle_count() < 400);
        let mut stroke = dab(mode, 0.1, falloff);
        stroke.settings.radius = if falloff == Falloff::Constant { 9.0 } else { 0.4 };
        active.sculpt(&context, &stroke).unwrap();
        active
    };
    // All of it moves the same way, and every groove with it.
    let mut whole = sculpted(SculptMode::Vector, Falloff::Constant);
    whole.adapt(&context, Cut::FINEST);
    let whole = whole.extract();
    let way = Vec3::from(whole.points[0]) - Vec3::from(shape.0[0]);
    assert!((way.length() - 0.1).abs() < 1e-5 && way.z > 0.08, "{way}");
    let worst = apart(&whole, |index| Vec3::from(shape.0[index]) + way);
    assert!(worst < 1e-5, "{worst}");
    let mut straight = sculpted(SculptMode::Draw, Falloff::Smooth);
    let seen = straight.extract();
    straight.adapt(&context, Cut::FINEST);
    let straight = straight.extract();
    let summit = straight.points.iter().map(|point| point[2]).fold(0.0, f32::max);
    assert!(summit > 0.05, "{summit}");
    let mut about = sculpted(SculptMode::Draw, Falloff::Smooth);
    for faces in [100, 900, 60, 5000, 300] {
        about.adapt(&context, Cut::of_faces(&mesh, faces));
    }
    about.adapt(&context, level);
    assert!(apart(&about.extract(), |index| seen.points[index].into()) < 2e-6);
    about.adapt(&context, Cut::FINEST);
    assert!(apart(&about.extract(), |index| straight.points[index].into()) < 1e-5);
}

#[test]
fn strokes_do_not_depend_on_threads() {
    let mesh = build(&lifted(80, |x, y| 0.02 * (9.0 * x).sin() * (7.0 * y).cos()));
    let run = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut active = finest(&mesh);
        let mut stroke = dab(SculptMode::Inflate, 0.02, Falloff::Smooth);
        stroke.points[1].position.x = 0.8;
        stroke.settings.spacing = 0.2;
        active.sculpt(&context, &stroke).unwrap();
        active.adapt(&context, Cut::BASE);
        active.sculpt(&context, &dab(SculptMode::Smooth, 0.0, Falloff::Smooth)).ok();
        active.adapt(&context, Cut::FINEST);
        active.extract()
    };
    let one = run(1);
    assert!(run(2) == one && run(5) == one);
}

#[test]
fn strokes_that_mean_nothing_here_are_refused() {
    let context = Context::serial();
    let mesh = build(&lifted(40, |_, _| 0.0));
    let mut active = finest(&mesh);
    let before = active.extract();
    let good = dab(SculptMode::Draw, 0.1, Falloff::Smooth);
    let mut fails = |spoil: &dyn Fn(&mut Stroke)| {
        let mut bad = good.clone();
        spoil(&mut bad);
        active.sculpt(&context, &bad).unwrap_err().to_string()
    };
    assert!(fails(&|bad| bad.points[0].position.x = f64::NAN).contains("point 0"));
    assert!(fails(&|bad| bad.action = Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] }).contains("colours"));
    assert!(fails(&|bad| bad.settings.level = 1).contains("level"));
    assert!(fails(&|bad| bad.points.iter_mut().for_each(|point| point.position.z = 5.0)).contains("no vertex"));
    assert_eq!(active.extract(), before);
}
