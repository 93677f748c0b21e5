//! Imprints of a graphics device into surfaces with vector displacement, which are those of the processor.

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Collider, Dab, DisplacedObject, Falloff, ImprintSettings, Imprinter, Moment, Press, Report,
    SculptMode,
};
use relievo_gpu::Device;
use relievo_testing::{Random, device};
use relievo_tiles::{ChannelOptions, Sets, Vector, VectorDisplacement};

use super::imprints::{assert_alike, ball, bits, difference, object_of, place, plate, settings, sheet, transforms};

/// Vectors of up to a tenth on two tiles of three, which have other sizes than those of the heights.
fn bend(context: &Context, object: &mut DisplacedObject, seed: u64) {
    let options = ChannelOptions { size: 16, face_sizes: vec![(2, 128), (8, 64)], ..ChannelOptions::default() };
    let mut vectors = VectorDisplacement::on(object.surface(), &options).unwrap();
    let tiles: Vec<u32> = (0..object.surface().tile_count() as u32).filter(|tile| tile % 3 != 1).collect();
    vectors.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let changes = vectors.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed + u64::from(tile));
        let mut number = || f16::from_f32(0.2 * random.unit() - 0.1);
        for row in 0..texels.size() {
            texels.row_mut(row).fill_with(|| Vector([number(), number(), number()]));
        }
    });
    vectors.settle(context, &changes.unwrap()).unwrap();
    object.set_vectors(vectors).unwrap();
}

fn bent(context: &Context, mesh: Mesh, transform: DAffine3, device: Option<&Device>) -> DisplacedObject {
    let mut object = object_of(context, mesh, 64, transform);
    bend(context, &mut object, 11);
    object.use_device(device).unwrap();
    object
}

/// Balls on their way over the objects, in turns.
fn balls(context: &Context, objects: &[DisplacedObject], count: usize) -> Vec<Collider> {
    let balls = (0..count).map(|pair| {
        let mut collider = ball(context, 0.7);
        collider.set_transform(place(&objects[pair % objects.len()], (pair / objects.len()) as u32)).unwrap();
        collider
    });
    balls.collect()
}

/// Presses balls in, together, with `settings` in turns, and says in how many submissions.
fn press<const N: usize>(
    context: &Context,
    objects: &mut [DisplacedObject; N],
    balls: &[Collider],
    settings: &[ImprintSettings],
) -> (Vec<Report>, usize) {
    let presses = balls.iter().enumerate().map(|(pair, collider)| {
        let moment = Moment { pair: pair as u32, ..Moment::default() };
        Press { into: pair % N, collider, settings: &settings[pair % settings.len()], moment }
    });
    let presses: Vec<_> = presses.collect();
    context.stats().take();
    let reports = Imprinter::new().imprint_all(context, &mut objects.each_mut(), &presses).unwrap();
    let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
    (reports, submitted)
}

#[test]
fn imprints_into_bent_surfaces_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let limited = ImprintSettings { share: 0.7, depth_limit: 0.3, smoothing: 0.4, ..settings() };
    let rimmed = ImprintSettings { rim: 0.4, rim_width: 0.3, ..settings() };
    let (mut apart, mut all) = (0, 0);
    for (transform, settings) in transforms().into_iter().zip([settings(), limited, rimmed]) {
        let [mut here, mut there] = [None, Some(&device)].map(|it| [bent(&context, sheet(), transform, it)]);
        let balls = balls(&context, &here, 4);
        let mut imprinter = Imprinter::new();
        let mut one_by_one = |object: &mut DisplacedObject| {
            let one = |(frame, ball): (u64, &Collider)| {
                let moment = Moment { frame, ..Moment::default() };
                imprinter.imprint(&context, object, ball, &settings, moment).unwrap()
            };
            (0..).zip(&balls).map(one).collect::<Vec<_>>()
        };
        let expected = one_by_one(&mut here[0]);
        context.stats().take();
        let found = one_by_one(&mut there[0]);
        let stages = context.stats().take();
        assert_eq!(stages.iter().filter(|event| event.stage == "imprint.device.raycast").count(), 4);
        assert!(expected.iter().all(|report| report.changed_coefficients > 100), "{expected:?}");
        for (a, b) in found.iter().zip(&expected) {
            assert_eq!((&a.changed, a.allocated, a.bytes), (&b.changed, b.allocated, b.bytes));
        }
        assert!(there[0].take_device_fault().is_none());
        let (differ, count) = difference(here[0].displacement().field(), there[0].displacement().field());
        println!("{differ} of {count} coefficients are more than one half apart");
        (apart, all) = (apart + differ, all + count);
        // They are others where nothing is bent.
        let mut straight = [object_of(&context, sheet(), 64, transform)];
        one_by_one(&mut straight[0]);
        assert!(bits(straight[0].displacement().field()) != bits(here[0].displacement().field()));
    }
    assert!(all > 20_000 && apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn imprints_into_several_objects_of_which_some_are_bent_are_one_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = |device: Option<&Device>| {
        let mut objects = transforms().map(|transform| bent(&context, plate(), transform, None));
        // Vectors come and go.
        objects[1] = object_of(&context, plate(), 32, transforms()[1]);
        objects.iter_mut().for_each(|object| object.use_device(device).unwrap());
        objects
    };
    let (mut here, mut there) = (make(None), make(Some(&device)));
    let balls = balls(&context, &here, 6);
    let settings = settings();
    let (mut expected, _) = press(&context, &mut here, &balls[..3], &[settings]);
    let (mut found, submitted) = press(&context, &mut there, &balls[..3], &[settings]);
    assert_eq!(submitted, 1);
    // Brushes and hosts change vectors between imprints.
    for objects in [&mut here, &mut there] {
        let at = objects[0].transform().transform_point3(DVec3::new(2.0, 2.6, 0.0));
        let brush = Brush::new(at, DMat3::IDENTITY, DVec3::splat(0.8), Falloff::Smooth).unwrap();
        let action = Action::Sculpt { mode: SculptMode::Pinch, height: 0.5 };
        Dab { brush, action, strength: 0.8 }.apply(&context, &mut objects[0]).unwrap();
        bend(&context, &mut objects[1], 5);
        bend(&context, &mut objects[2], 7);
    }
    let more = press(&context, &mut here, &balls[3..], &[settings]);
    expected.extend(more.0);
    let (more, submitted) = press(&context, &mut there, &balls[3..], &[settings]);
    found.extend(more);
    assert_eq!(submitted, 1);
    assert_alike(&here, &mut there, (&expected, &found));
}

#[test]
fn what_rises_and_is_smoothed_on_bent_surfaces_is_what_the_processor_makes() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = |device| [0, 1].map(|it| bent(&context, plate(), transforms()[it], device));
    let [mut here, mut there] = [make(None), make(Some(&device))];
    let rimmed = ImprintSettings { rim: 0.5, rim_width: 0.4, repose: 1.2, ..settings() };
    let smoothed = ImprintSettings { smoothing: 0.4, smoothing_passes: 2, ..settings() };
    let both = ImprintSettings { smoothing: 0.3, ..rimmed };
    let balls = balls(&context, &here, 8);
    let kinds = [rimmed, smoothed, rimmed, both, settings()];
    // What rises first decides how far boxes reach.
    let (mut expected, _) = press(&context, &mut here, &balls[..2], &kinds);
    let (mut found, _) = press(&context, &mut there, &balls[..2], &kinds);
    expected.extend(press(&context, &mut here, &balls[2..], &kinds).0);
    let (more, submitted) = press(&context, &mut there, &balls[2..], &kinds);
    found.extend(more);
    // What the ring update changes ends a submission once, and so does a box that reaches further where nothing rises.
    assert!(submitted <= 3, "{submitted}");
    assert!(expected.iter().filter(|it| it.volumes.raised > 1e-4).count() > 3, "{expected:?}");
    for (a, b) in found.iter().zip(&expected) {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-3 * a.max(b) + 1e-6;
        assert!(near(a.volumes.pushed, b.volumes.pushed) && near(a.volumes.raised, b.volumes.raised), "{a:?} {b:?}");
    }
    assert_alike(&here, &mut there, (&expected, &found));
}
