//! Imprints on triangle meshes of a graphics device, which are those of the processor.

use glam::{DAffine3, DQuat, DVec3};
use half::f16;
use relievo_core::{Context, ErrorKind};
use relievo_detail::{
    Action, Collider, DisplacedObject, ImprintSettings, Imprinter, Moment, Motion, Pose, Report, SculptMode,
    StrokeSettings, Sweep, TriangleObject,
};
use relievo_testing::device;
use relievo_tiles::triangle::TriangleChannel;

use crate::device::imprints::{self, ball, deform_balls, lifted, moved_ball, order, settings};
use crate::device::triangle_vectors::bent;
use crate::device::triangles::{object, pairs, stroke};

/// Values that are more than one half float apart, and values that are displaced. What is allocated is the same.
fn difference(a: &TriangleObject, b: &TriangleObject) -> (usize, usize) {
    let pairs = pairs(a.displacement().field(), b.displacement().field());
    let all = pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b));
    let count = |(apart, moved): (usize, usize), (a, b): (&f16, &f16)| {
        (apart + usize::from((order(*a) - order(*b)).abs() > 1), moved + usize::from(*a != f16::ZERO))
    };
    all.fold((0, 0), count)
}

/// A ball on its way over the mesh, in the world of the object.
fn place(object: &TriangleObject, step: u32) -> DAffine3 {
    let local = DVec3::new(1.3 + 0.4 * f64::from(step), 1.9 + 0.3 * f64::from(step), 0.3);
    let turn = DQuat::from_rotation_x(0.2 * f64::from(step));
    DAffine3::from_rotation_translation(turn, object.transform().transform_point3(local))
}

/// Presses `collider` in at some places and returns what it did.
fn press(
    context: &Context,
    object: &mut TriangleObject,
    collider: &mut Collider,
    settings: &ImprintSettings,
) -> Report {
    let (mut imprinter, mut report) = (Imprinter::new(), Report::default());
    for frame in 0..4 {
        collider.set_transform(place(object, frame)).unwrap();
        let moment = Moment { frame: u64::from(frame), ..Moment::default() };
        report.merge(imprinter.imprint(context, object, collider, settings, moment).unwrap());
    }
    report
}

/// Fails unless both did the same, but for a few rays that graze voxels.
fn agree(found: &Report, expected: &Report) {
    assert_eq!((&found.changed, &found.refused), (&expected.changed, &expected.refused));
    assert_eq!((found.allocated, found.bytes), (expected.allocated, expected.bytes));
    let apart = found.changed_coefficients.abs_diff(expected.changed_coefficients);
    assert!(apart * 1000 <= expected.changed_coefficients, "{found:?} {expected:?}");
    for (found, expected) in
        [(found.volumes.pushed, expected.volumes.pushed), (found.volumes.raised, expected.volumes.raised)]
    {
        assert!((found - expected).abs() <= 2e-3 * expected, "{found} {expected}");
    }
}

#[test]
fn imprints_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let limited = ImprintSettings { share: 0.7, depth_limit: 0.2, smoothing: 0.4, ..settings() };
    let rimmed = ImprintSettings { rim: 0.4, rim_width: 0.2, ..settings() };
    let (mut apart, mut moved) = (0, 0);
    for (segments, settings, bends) in [
        (8, settings(), false),
        (16, limited, false),
        (32, settings(), false),
        (64, settings(), false),
        (16, rimmed, false),
        (16, settings(), true),
        (16, rimmed, true),
    ] {
        let make = || if bends { bent(&context) } else { object(&context, segments) };
        let [mut here, mut there] = [make(), make()];
        there.use_device(Some(&device)).unwrap();
        let mut collider = ball(&context, 0.7);
        let expected = press(&context, &mut here, &mut collider, &settings);
        context.stats().take();
        let found = press(&context, &mut there, &mut collider, &settings);
        let stages = context.stats().take();
        let submitted = stages.iter().filter(|event| event.stage == "imprint.device.submit").count();
        assert!(there.take_device_fault().is_none());
        agree(&found, &expected);
        let (differ, count) = difference(&here, &there);
        println!(
            "{segments} segments: {differ} of {count} values are more than one half apart, {submitted} submissions"
        );
        // Rooms for what rises around a contact grow once or twice.
        assert!(submitted == 4 || settings.rim > 0.0 && submitted > 4, "{submitted}");
        assert!(count > 10 * segments as usize, "{count}");
        (apart, moved) = (apart + differ, moved + count);
    }
    assert!(moved > 3_000 && apart * 10_000 < moved, "{apart} of {moved}");
}

#[test]
fn posed_meshes_deforming_colliders_and_open_ones_too() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [object(&context, 16), object(&context, 16)];
    there.use_device(Some(&device)).unwrap();
    let points = here.surface().points().to_vec();
    for object in [&mut here, &mut there] {
        let mut imprinter = Imprinter::new();
        deform_balls(&context, |frame, colliders| {
            object.pose(&context, &lifted(&points, frame)).unwrap();
            for collider in colliders {
                collider.set_transform(place(object, frame)).unwrap();
                let moment = Moment { frame: u64::from(frame), ..Moment::default() };
                imprinter.imprint(&context, object, collider, &settings(), moment).unwrap();
            }
        });
    }
    assert!(there.take_device_fault().is_none());
    let (apart, moved) = difference(&here, &there);
    println!("{apart} of {moved} values are more than one half apart");
    assert!(moved > 400 && apart * 10_000 < moved, "{apart} of {moved}");
}

#[test]
fn more_values_than_there_is_room_for_at_first_are_done_again_and_budgets_refuse_the_same() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for budget in [1 << 30, 60_000] {
        let [mut here, mut there] = [0, 1].map(|_| object(&context, 64));
        let mut collider = ball(&context, 8.0);
        let low = here.transform().transform_point3(DVec3::new(2.5, 2.5, 4.2));
        collider.set_transform(DAffine3::from_translation(low)).unwrap();
        there.use_device(Some(&device)).unwrap();
        let press = |object: &mut TriangleObject| {
            object.displacement_mut().set_budget(budget);
            Imprinter::new().imprint(&context, object, &collider, &settings(), Moment::default()).unwrap()
        };
        let (expected, found) = (press(&mut here), press(&mut there));
        assert!(there.take_device_fault().is_none());
        agree(&found, &expected);
        assert_eq!(expected.refused.is_empty(), budget > 60_000, "{expected:?}");
        // 512 pieces of 256 values are the room at first.
        assert_eq!(context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count(), 2);
        let (apart, moved) = difference(&here, &there);
        println!("{apart} of {moved} values are more than one half apart");
        assert!(apart * 10_000 <= moved, "{apart} of {moved}");
    }
}

#[test]
fn sweeps_of_a_device_over_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let limited = ImprintSettings { depth_limit: 0.15, ..settings() };
    let (mut apart, mut moved) = (0, 0);
    for (settings, segments) in [(settings(), 16), (limited, 16), (settings(), 32), (settings(), 8)] {
        let [mut here, mut there] = [0, 1].map(|_| object(&context, segments));
        there.use_device(Some(&device)).unwrap();
        for object in [&mut here, &mut there] {
            let traces = TriangleChannel::of(object.displacement().field(), 1 << 30).unwrap();
            object.set_traces(traces).unwrap();
        }
        let expected = sweep(&context, &mut here, &settings);
        context.stats().take();
        let found = sweep(&context, &mut there, &settings);
        assert!(there.take_device_fault().is_none() && expected.sub_steps > 4, "{expected:?}");
        assert_eq!(found.sub_steps, expected.sub_steps);
        // Each starts from what those before it left, also inside triangles that have no block.
        let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
        println!("{submitted} submissions of {} imprints", found.sub_steps);
        assert!(2 * submitted as u64 <= found.sub_steps, "{submitted} of {}", found.sub_steps);
        agree(&found, &expected);
        let [traced, traced_there] = [&here, &there].map(|object| object.traces().unwrap().field());
        pairs(traced, traced_there);
        let (differ, count) = difference(&here, &there);
        println!("{differ} of {count} values are more than one half apart");
        (apart, moved) = (apart + differ, moved + count);
    }
    assert!(moved > 800 && apart * 10_000 < moved, "{apart} of {moved}");
}

/// Moves a ball over a mesh and returns what it did.
fn sweep(context: &Context, object: &mut TriangleObject, settings: &ImprintSettings) -> Report {
    let (mut ball, motion) = moved_ball(context, [0, 4].map(|step| place(object, step)));
    Imprinter::new().sweep(context, object, &mut ball, &motion, settings, Moment::default()).unwrap()
}

/// Moves three balls over two meshes, of which the last one has a depth limit, in a row or one after another. Returns what
/// each did and how many submissions there were.
fn sweep_pairs(
    context: &Context,
    objects: &mut [TriangleObject; 2],
    settings: &ImprintSettings,
    together: bool,
) -> (Vec<Report>, usize) {
    let limited = ImprintSettings { depth_limit: 0.15, ..*settings };
    let cases = [(0, 0, 0, settings), (1, 1, 0, settings), (0, 2, 1, settings), (1, 0, 2, &limited)];
    let mut balls = [0.7, 0.6, 0.5].map(|radius| ball(context, radius));
    let motions = cases.map(|(into, by, step, _)| {
        let [from, to] = [step, step + 1].map(|step| Pose::rigid(place(&objects[into], step)));
        Motion::new(&balls[by], from, to).unwrap()
    });
    let moment = |pair| Moment { pair, ..Moment::default() };
    let mut imprinter = Imprinter::new();
    context.stats().take();
    let reports = if together {
        let all = (0..).zip(cases.iter().zip(&motions));
        let sweep =
            |(pair, (&(into, by, _, settings), motion))| Sweep { into, by, motion, settings, moment: moment(pair) };
        let sweeps: Vec<_> = all.map(sweep).collect();
        imprinter.sweep_all(context, &mut objects.each_mut(), &mut balls.each_mut(), &sweeps).unwrap()
    } else {
        let one = |(pair, (&(into, by, _, settings), motion)): (u32, (&(usize, usize, u32, &_), &Motion))| {
            let (object, ball) = (&mut objects[into], &mut balls[by]);
            imprinter.sweep(context, object, ball, motion, settings, moment(pair)).unwrap()
        };
        (0..).zip(cases.iter().zip(&motions)).map(one).collect()
    };
    let stages = context.stats().take();
    (reports, stages.iter().filter(|event| event.stage == "imprint.device.submit").count())
}

#[test]
fn pairs_over_several_triangle_meshes_are_one_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    // Of different segments, as two meshes of a scene may have.
    let make = || [16, 32].map(|segments| object(&context, segments));
    let [mut alone, mut here, mut apart, mut there] = [make(), make(), make(), make()];
    for object in apart.iter_mut().chain(&mut there) {
        object.use_device(Some(&device)).unwrap();
    }
    let (expected, _) = sweep_pairs(&context, &mut alone, &settings(), false);
    assert_eq!(sweep_pairs(&context, &mut here, &settings(), true).0, expected);
    let (one_by_one, several) = sweep_pairs(&context, &mut apart, &settings(), false);
    let (found, submitted) = sweep_pairs(&context, &mut there, &settings(), true);
    // The limited one begins where those before have ended.
    assert!(submitted == 2 && several == 4, "{submitted} {several}");
    assert!(expected.iter().map(|report| report.sub_steps).sum::<u64>() > 6);
    assert_eq!(found, one_by_one);
    let (mut differ, mut moved) = (0, 0);
    expected.iter().zip(&found).for_each(|(expected, found)| agree(found, expected));
    for k in 0..2 {
        assert!(there[k].take_device_fault().is_none());
        let all = pairs(apart[k].displacement().field(), there[k].displacement().field());
        assert!(all.into_iter().all(|(a, b)| a == b), "the same as pair after pair");
        let (own, count) = difference(&here[k], &there[k]);
        println!("{own} of {count} values are more than one half apart");
        (differ, moved) = (differ + own, moved + count);
    }
    assert!(moved > 800 && differ * 10_000 < moved, "{differ} of {moved}");
}

#[test]
fn what_rises_and_what_is_smoothed_is_there_for_those_that_follow_in_the_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let smoothed = ImprintSettings { smoothing: 0.5, smoothing_passes: 2, ..settings() };
    let rimmed = ImprintSettings { rim: 0.5, rim_width: 0.4, repose: 1.0, ..settings() };
    let both = ImprintSettings { smoothing: 0.5, ..rimmed };
    let (mut apart, mut moved) = (0, 0);
    for (settings, segments, bends) in [
        (smoothed, 8, false),
        (smoothed, 16, false),
        (smoothed, 32, false),
        (rimmed, 16, false),
        (both, 32, false),
        (smoothed, 16, true),
        (both, 16, true),
    ] {
        let make = || if bends { bent(&context) } else { object(&context, segments) };
        let [mut here, mut there] = [make(), make()];
        there.use_device(Some(&device)).unwrap();
        let expected = sweep(&context, &mut here, &settings);
        context.stats().take();
        let found = sweep(&context, &mut there, &settings);
        let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
        println!("{submitted} submissions of {} imprints", found.sub_steps);
        assert!(there.take_device_fault().is_none() && found.sub_steps == expected.sub_steps);
        agree(&found, &expected);
        let (differ, count) = difference(&here, &there);
        println!("{segments} segments: {differ} of {count} values are more than one half apart");
        // A rim on a flat mesh raises the reach of boxes by another step again and again, as the ball comes nearer.
        let steady = settings.rim <= 0.0 || bends;
        assert!(!steady || 2 * submitted as u64 <= found.sub_steps, "{submitted} of {}", found.sub_steps);
        (apart, moved) = (apart + differ, moved + count);
    }
    assert!(moved > 3_000 && apart * 10_000 < moved, "{apart} of {moved}");
}

#[test]
fn what_a_budget_refuses_and_coarser_blocks_end_a_submission_and_nothing_else_differs() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut apart, mut moved) = (0, 0);
    for (segments, budget, level) in [(32, 12_000, None), (16, 1 << 30, Some(1)), (32, 1 << 30, Some(2))] {
        let [mut here, mut there] = [0, 1].map(|_| object(&context, segments));
        let settings = settings();
        let sweep = |object: &mut TriangleObject, device| {
            object.displacement_mut().set_budget(budget);
            if let Some(level) = level {
                let settings = StrokeSettings { radius: 0.9, spacing: 0.5, level, ..StrokeSettings::default() };
                let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.05 };
                let points = [[1.2, 2.0, 0.0], [3.2, 3.4, 0.0]];
                stroke(object, &points, action, settings).apply(&context, object).unwrap();
            }
            object.use_device(device).unwrap();
            let mut collider = ball(&context, 0.7);
            let mut report = Report::default();
            for (from, to) in [(0, 4), (4, 1)] {
                let [from, to] = [from, to].map(|step| Pose::rigid(place(object, step)));
                let motion = Motion::new(&collider, from, to).unwrap();
                let moment = Moment { frame: u64::from(report.sub_steps > 0), ..Moment::default() };
                let mut imprinter = Imprinter::new();
                let made = imprinter.sweep(&context, object, &mut collider, &motion, &settings, moment);
                report.merge(made.unwrap());
            }
            report
        };
        let expected = sweep(&mut here, None);
        context.stats().take();
        let found = sweep(&mut there, Some(&device));
        assert!(there.take_device_fault().is_none());
        let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
        println!("{submitted} submissions of {} imprints", found.sub_steps);
        assert!(submitted > 2 && found.sub_steps == expected.sub_steps, "{submitted} of {}", found.sub_steps);
        agree(&found, &expected);
        assert_eq!(expected.refused.is_empty(), budget > 12_000, "{expected:?}");
        let (differ, count) = difference(&here, &there);
        println!("{differ} of {count} values are more than one half apart");
        (apart, moved) = (apart + differ, moved + count);
    }
    assert!(moved > 3_000 && apart * 10_000 < moved, "{apart} of {moved}");
}

#[test]
fn surfaces_and_triangle_meshes_share_the_colliders_of_an_imprinter() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || (object(&context, 16), imprints::object(&context, 32, imprints::transforms()[1]));
    let [(mut here, mut tiled_here), (mut there, mut tiled_there)] = [make(), make()];
    there.use_device(Some(&device)).unwrap();
    tiled_there.use_device(Some(&device)).unwrap();
    // The imprinter meets more of them with every frame, so that what it has of them is made anew.
    let mut balls = [0.5, 0.7, 0.6, 0.4].map(|radius| ball(&context, radius));
    let mut press = |mesh: &mut TriangleObject, tiled: &mut DisplacedObject| {
        let mut imprinter = Imprinter::new();
        for (frame, count) in [1, 2, 4, 3].into_iter().enumerate() {
            for (pair, ball) in balls[..count].iter_mut().enumerate() {
                let moment = Moment { frame: frame as u64, pair: pair as u32, ..Moment::default() };
                ball.set_transform(place(mesh, pair as u32)).unwrap();
                imprinter.imprint(&context, mesh, ball, &settings(), moment).unwrap();
                ball.set_transform(imprints::place(tiled, pair as u32)).unwrap();
                imprinter.imprint(&context, tiled, ball, &settings(), moment).unwrap();
            }
        }
    };
    press(&mut here, &mut tiled_here);
    press(&mut there, &mut tiled_there);
    assert!(there.take_device_fault().is_none() && tiled_there.take_device_fault().is_none());
    let (apart, moved) = difference(&here, &there);
    let fields = [&tiled_here, &tiled_there].map(|object| object.displacement().field());
    let (tiled_apart, all) = imprints::difference(fields[0], fields[1]);
    println!("{apart} of {moved} values and {tiled_apart} of {all} coefficients are more than one half apart");
    assert!(moved > 300 && apart * 10_000 < moved, "{apart} of {moved}");
    assert!(all > 3_000 && tiled_apart * 10_000 < all, "{tiled_apart} of {all}");
}

#[test]
fn the_processor_takes_over_on_triangles_from_a_lost_device_in_the_middle() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object(&context, 16));
    let mut collider = ball(&context, 0.7);
    let mut imprinter = Imprinter::new();
    there.use_device(Some(&device)).unwrap();
    for frame in 0..4 {
        if frame == 2 {
            device.abandon();
        }
        for object in [&mut here, &mut there] {
            collider.set_transform(place(object, frame)).unwrap();
            let moment = Moment { frame: u64::from(frame), ..Moment::default() };
            let report = imprinter.imprint(&context, object, &collider, &settings(), moment).unwrap();
            assert!(!report.changed.is_empty());
        }
    }
    let (apart, moved) = difference(&here, &there);
    assert!(apart * 1000 < moved, "{apart} of {moved}");
    assert_eq!(there.take_device_fault().expect("it is told").kind, ErrorKind::Device);
    assert!(there.take_device_fault().is_none(), "once");
}
