//! Rims of imprints on a graphics device: within the submission of the imprints, and what the processor raises.

use glam::{DAffine3, DVec3};
use relievo_core::{Context, ContextOptions};
use relievo_detail::{Collider, DisplacedObject, ImprintSettings, Imprinter, Moment, Press, Report};
use relievo_testing::device;

use crate::device::imprints::{assert_alike, ball, difference, limited, object_of, plate, settings, transforms};

fn rimmed() -> ImprintSettings {
    ImprintSettings { rim: 0.6, rim_width: 0.3, repose: 0.9, ..settings() }
}

/// Balls in the world of an object, at places of the plate.
fn balls_on(context: &Context, object: &DisplacedObject, places: &[DVec3]) -> Collider {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for place in places {
        let ball = ball(context, 0.7);
        let first = points.len() as u32;
        points.extend(ball.points().iter().map(|p| (DVec3::from(p.map(f64::from)) + *place).as_vec3().to_array()));
        triangles.extend(ball.triangles().iter().map(|corners| corners.map(|point| point + first)));
    }
    Collider::new(context, points, triangles, *object.transform()).unwrap()
}

fn assert_same_volumes(found: &[Report], expected: &[Report]) {
    for (found, expected) in found.iter().zip(expected) {
        let (a, b) = (found.volumes, expected.volumes);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * b;
        assert!(near(a.pushed, b.pushed) && near(a.raised, b.raised), "{a:?} {b:?}");
        let changed = [found, expected].map(|report| report.changed_coefficients);
        assert!(changed[0].abs_diff(changed[1]) * 1000 <= changed[1], "{changed:?}");
    }
}

#[test]
fn imprints_with_rims_are_one_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || [0, 1].map(|it| object_of(&context, plate(), 32, transforms()[it]));
    let [mut here, mut there, mut single] = [make(), make(), make()];
    for object in there.iter_mut().chain(&mut single) {
        object.use_device(Some(&device)).unwrap();
    }
    let (rimmed, plain) = (rimmed(), settings());
    // The first raises most, so that boxes need not reach further for the next imprints, which overlap.
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let ways = [
        [at(2.0, 2.3, 0.3), at(3.1, 2.6, 0.55), at(3.4, 2.9, 0.6), at(2.6, 3.3, 0.6), at(2.3, 2.9, 0.62)],
        [at(4.3, 4.1, 0.25), at(3.7, 3.9, 0.6), at(3.2, 4.3, 0.55), at(4.0, 3.1, 0.6), at(4.4, 4.9, 0.6)],
    ];
    let colliders: Vec<(usize, Collider)> =
        (0..10).map(|pair| (pair % 2, balls_on(&context, &here[pair % 2], &[ways[pair % 2][pair / 2]]))).collect();
    let presses = |range: std::ops::Range<usize>| {
        let presses = range.map(|pair| {
            let moment = Moment { pair: pair as u32, ..Moment::default() };
            let (into, collider) = &colliders[pair];
            // One of the last raises nothing.
            Press { into: *into, collider, settings: if pair == 8 { &plain } else { &rimmed }, moment }
        });
        presses.collect::<Vec<_>>()
    };
    let submitted = || context.stats().take().iter().filter(|it| it.stage == "imprint.device.submit").count();
    let press = |objects: &mut [DisplacedObject; 2], range| {
        Imprinter::new().imprint_all(&context, &mut objects.each_mut(), &presses(range)).unwrap()
    };
    let mut expected = press(&mut here, 0..2);
    let mut found = press(&mut there, 0..2);
    expected.extend(press(&mut here, 2..10));
    submitted();
    found.extend(press(&mut there, 2..10));
    assert_eq!(submitted(), 1);
    assert_alike(&here, &mut there, (&expected, &found));
    assert_same_volumes(&found, &expected);
    assert!(expected.iter().all(|it| it.volumes.pushed > 0.0 || it.volumes.raised == 0.0));
    assert!(expected[..8].iter().all(|it| it.volumes.raised > 1e-4), "{expected:?}");
    // One by one.
    let mut imprinter = Imprinter::new();
    let one = |press: &Press<'_>| {
        imprinter.imprint(&context, &mut single[press.into], press.collider, press.settings, press.moment).unwrap()
    };
    let alone: Vec<Report> = presses(0..10).iter().map(one).collect();
    assert_alike(&there, &mut single, (&found, &alone));
}

#[test]
fn what_rises_is_smoothed_for_those_that_follow() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object_of(&context, plate(), 32, transforms()[1]));
    there.use_device(Some(&device)).unwrap();
    let rimmed = rimmed();
    let smoothed = ImprintSettings { smoothing: 0.4, ..rimmed };
    let only = ImprintSettings { smoothing: 0.3, smoothing_passes: 2, ..settings() };
    let kinds = [&rimmed, &smoothed, &rimmed, &only, &smoothed, &settings()];
    let place = |pair: usize| {
        let x = 0.5 * pair as f64;
        DVec3::new(2.0 + x, 2.3 + 0.4 * x, if pair == 0 { 0.3 } else { 0.55 })
    };
    let colliders: Vec<Collider> = (0..kinds.len()).map(|pair| balls_on(&context, &here, &[place(pair)])).collect();
    let submitted = || context.stats().take().iter().filter(|it| it.stage == "imprint.device.submit").count();
    let press = |object: &mut DisplacedObject, range: std::ops::Range<usize>| {
        let press = |pair: usize| {
            let moment = Moment { pair: pair as u32, ..Moment::default() };
            Press { into: 0, collider: &colliders[pair], settings: kinds[pair], moment }
        };
        let presses: Vec<Press<'_>> = range.map(press).collect();
        Imprinter::new().imprint_all(&context, &mut [object], &presses).unwrap()
    };
    let mut expected = press(&mut here, 0..1);
    let mut found = press(&mut there, 0..1);
    expected.extend(press(&mut here, 1..6));
    submitted();
    found.extend(press(&mut there, 1..6));
    assert_eq!(submitted(), 1);
    assert!(expected[4].volumes.raised > 1e-4, "{expected:?}");
    assert_alike(&[here], std::slice::from_mut(&mut there), (&expected, &found));
    assert_same_volumes(&found, &expected);
}

#[test]
fn patches_of_contact_have_rims_of_their_own() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object_of(&context, plate(), 64, DAffine3::IDENTITY));
    there.use_device(Some(&device)).unwrap();
    let places = [DVec3::new(1.4, 1.6, 0.6), DVec3::new(3.4, 1.5, 0.5), DVec3::new(2.5, 4.6, 0.62)];
    let collider = balls_on(&context, &here, &places);
    let settings = ImprintSettings { rim: 0.9, repose: 1.3, ..rimmed() };
    let press = |object: &mut DisplacedObject| {
        vec![Imprinter::new().imprint(&context, object, &collider, &settings, Moment::default()).unwrap()]
    };
    let (expected, found) = (press(&mut here), press(&mut there));
    let stages = context.stats().take();
    // The processor raises and voxelises only for the one that it made.
    for stage in ["imprint.rim", "imprint.voxelise"] {
        assert_eq!(stages.iter().filter(|event| event.stage == stage).count(), 1, "{stage}");
    }
    assert!(expected[0].volumes.raised > 0.85 * expected[0].volumes.pushed, "{expected:?}");
    assert_alike(&[here], std::slice::from_mut(&mut there), (&expected, &found));
    assert_same_volumes(&found, &expected);
}

#[test]
fn rims_that_have_no_room_at_first_are_raised_again_with_more() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object_of(&context, plate(), 256, DAffine3::IDENTITY));
    there.use_device(Some(&device)).unwrap();
    // Narrow beside its contact, so that there are many cells, and more blocks than there is room for at first.
    let settings = ImprintSettings { rim_width: 0.06, ..rimmed() };
    let mut collider = ball(&context, 2.5);
    collider.set_transform(DAffine3::from_translation(DVec3::new(3.5, 3.5, 2.0))).unwrap();
    let press = |object: &mut DisplacedObject| {
        vec![Imprinter::new().imprint(&context, object, &collider, &settings, Moment::default()).unwrap()]
    };
    let (expected, found) = (press(&mut here), press(&mut there));
    assert!(expected[0].volumes.raised > 1e-3, "{expected:?}");
    assert_alike(&[here], std::slice::from_mut(&mut there), (&expected, &found));
    assert_same_volumes(&found, &expected);
}

#[test]
fn rims_that_a_budget_refuses_are_counted_in_none() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = limited(&context, &device, 12_000);
    let settings = rimmed();
    let colliders = [0.0, 0.6, 1.2].map(|x| balls_on(&context, &here, &[DVec3::new(1.8 + x, 2.6, 0.6)]));
    let press = |object: &mut DisplacedObject| {
        let press = |(pair, collider): (u32, _)| Press {
            into: 0,
            collider,
            settings: &settings,
            moment: Moment { pair, ..Moment::default() },
        };
        let presses: Vec<Press<'_>> = (0..).zip(&colliders).map(press).collect();
        Imprinter::new().imprint_all(&context, &mut [object], &presses).unwrap()
    };
    let (expected, found) = (press(&mut here), press(&mut there));
    assert!(expected.iter().any(|it| !it.refused.is_empty()), "{expected:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(
            (&found.refused, &found.changed, found.bytes),
            (&expected.refused, &expected.changed, expected.bytes)
        );
    }
    assert_same_volumes(&found, &expected);
    let (apart, all) = difference(here.displacement().field(), there.displacement().field());
    assert!(apart * 1000 < all, "{apart} of {all}");
}

#[test]
fn a_rim_too_wide_for_memory_is_refused_on_a_device_too() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let narrow = Context::new(&ContextOptions { threads: 1, memory_limit: 100_000 }).unwrap();
    let mut there = object_of(&context, plate(), 32, DAffine3::IDENTITY);
    there.use_device(Some(&device)).unwrap();
    let collider = balls_on(&context, &there, &[DVec3::new(2.5, 2.6, 0.6)]);
    let settings = ImprintSettings { rim_width: 50_000.0, ..rimmed() };
    let done = Imprinter::new().imprint(&narrow, &mut there, &collider, &settings, Moment::default());
    assert!(done.unwrap_err().to_string().contains("rim_width"));
    assert_eq!(there.displacement().bytes(), 0);
}
