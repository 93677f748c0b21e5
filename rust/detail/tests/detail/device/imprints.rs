//! Imprints on a graphics device: coefficients, allocated tiles and history are the processor's.

use glam::{DAffine3, DQuat, DVec3};
use half::f16;
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Collider, DisplacedObject, History, ImprintSettings, Imprinter, LayeredObject, Moment, Motion, Pose, Press, Report,
    Sweep,
};
use relievo_document::Document;
use relievo_gpu::Device;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_testing::{device, grid};
use relievo_tiles::{Displacement, DisplacementOptions, Field, Traces};

/// A wavy sheet with faces of all kinds.
pub(crate) fn sheet() -> Mesh {
    let mut mesh = grid(7, false, &[3, 1, 7, 2, 0, 3, 2], false);
    for point in &mut mesh.points {
        point[2] = 0.2 * (1.1 * point[0]).sin() * (0.8 * point[1]).cos();
    }
    mesh
}

pub(crate) fn object(context: &Context, size: u32, transform: DAffine3) -> DisplacedObject {
    object_of(context, sheet(), size, transform)
}

pub(crate) fn object_of(context: &Context, mesh: Mesh, size: u32, transform: DAffine3) -> DisplacedObject {
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size, face_sizes: vec![(3, 64), (8, 8)], ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap()
}

/// A ball of 2,208 triangles.
pub(crate) fn ball(context: &Context, radius: f32) -> Collider {
    let (n, m) = (48u32, 24u32);
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    let at = |i: u32, j: u32| match j {
        0 => 0,
        j if j == m => 1,
        j => 2 + (j - 1) * n + i % n,
    };
    for j in 1..m {
        for i in 0..n {
            let (a, b) =
                (i as f32 / n as f32 * std::f32::consts::TAU, (j as f32 / m as f32 - 0.5) * std::f32::consts::PI);
            points.push([radius * b.cos() * a.cos(), radius * b.cos() * a.sin(), radius * b.sin()]);
        }
    }
    let mut triangles = Vec::new();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        if j > 0 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        }
        if j + 1 < m {
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Collider::new(context, points, triangles, DAffine3::IDENTITY).unwrap()
}

pub(crate) fn settings() -> ImprintSettings {
    ImprintSettings { voxels: 1 << 18, max_displacement: 0.6, ..ImprintSettings::default() }
}

fn allocated(field: &Field) -> Vec<u32> {
    field.allocated().collect()
}

/// Half floats in order, so that neighbours are one apart.
pub(crate) fn order(half: f16) -> i32 {
    let bits = i32::from(half.to_bits());
    if bits & 0x8000 == 0 { bits } else { 0x8000 - bits }
}

/// Coefficients that are more than one half float apart, and all.
pub(crate) fn difference(a: &Field, b: &Field) -> (usize, usize) {
    assert_eq!(allocated(a), allocated(b), "the tiles that are allocated");
    let pairs = a.allocated().flat_map(|tile| a.block(tile).unwrap().iter().zip(b.block(tile).unwrap()));
    pairs.fold((0, 0), |(apart, all), (a, b)| (apart + usize::from((order(*a) - order(*b)).abs() > 1), all + 1))
}

pub(crate) fn bits(field: &Field) -> Vec<(u32, Vec<u16>)> {
    field.allocated().map(|tile| (tile, field.block(tile).unwrap().iter().map(|it| it.to_bits()).collect())).collect()
}

/// Gives `to` the displacement of `from`.
fn copy(from: &DisplacedObject, to: &mut DisplacedObject) {
    for tile in 0..from.surface().tile_count() as u32 {
        let bytes = from.displacement().read(tile).unwrap();
        to.displacement_mut().write(tile, bytes.as_deref()).unwrap();
    }
}

/// A ball on its way over the sheet, in the world of the object.
pub(crate) fn place(object: &DisplacedObject, step: u32) -> DAffine3 {
    let local = DVec3::new(1.6 + 0.45 * f64::from(step), 2.4 + 0.3 * f64::from(step), 0.55);
    let turn = DQuat::from_rotation_x(0.2 * f64::from(step));
    DAffine3::from_rotation_translation(turn, object.transform().transform_point3(local))
}

/// Presses `collider` in at some places and returns what it did.
fn press(
    context: &Context,
    object: &mut DisplacedObject,
    collider: &mut Collider,
    settings: &ImprintSettings,
) -> Report {
    let mut imprinter = Imprinter::new();
    let mut report = Report::default();
    for frame in 0..5 {
        collider.set_transform(place(object, frame)).unwrap();
        let moment = Moment { frame: u64::from(frame), ..Moment::default() };
        report.merge(imprinter.imprint(context, object, collider, settings, moment).unwrap());
    }
    report
}

/// Makes a ball and its motion from one place to another.
pub(crate) fn moved_ball(context: &Context, ends: [DAffine3; 2]) -> (Collider, Motion) {
    let collider = ball(context, 0.7);
    let [from, to] = ends.map(Pose::rigid);
    let motion = Motion::new(&collider, from, to).unwrap();
    (collider, motion)
}

/// Moves a ball over an object, from its first place to the one of a step, and returns what it did.
fn sweep(context: &Context, object: &mut DisplacedObject, step: u32, settings: &ImprintSettings) -> Report {
    let (mut ball, motion) = moved_ball(context, [0, step].map(|step| place(object, step)));
    Imprinter::new().sweep(context, object, &mut ball, &motion, settings, Moment::default()).unwrap()
}

/// Makes two objects with so many bytes for displacement, the second of a device.
pub(crate) fn limited(context: &Context, device: &Device, bytes: u64) -> [DisplacedObject; 2] {
    let [mut here, mut there] = [0, 1].map(|_| object(context, 32, DAffine3::IDENTITY));
    here.displacement_mut().set_budget(bytes);
    there.displacement_mut().set_budget(bytes);
    there.use_device(Some(device)).unwrap();
    [here, there]
}

/// Checks that a device that has too few bytes for a motion refuses and changes what the processor does.
pub(crate) fn check_refusals(settings: &ImprintSettings) {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut objects = limited(&context, &device, 9_000);
    let [expected, found] = objects.each_mut().map(|object| sweep(&context, object, 3, settings));
    assert!(!expected.refused.is_empty() && !expected.changed.is_empty(), "{expected:?}");
    assert_eq!((&found.refused, &found.changed, found.bytes), (&expected.refused, &expected.changed, expected.bytes));
    assert_eq!(found.sub_steps, expected.sub_steps);
    let [here, there] = objects.each_ref().map(|object| object.displacement().field());
    let (apart, all) = difference(here, there);
    assert!(apart * 1000 < all, "{apart} of {all}");
}

/// Stretches a ball, one with a hole at the bottom, which is covered, and the bottom alone, which is a sheet, three times, and
/// gives them to `press` with the number of the frame.
pub(crate) fn deform_balls(context: &Context, mut press: impl FnMut(u32, &mut [Collider; 3])) {
    let ball = ball(context, 0.7);
    let rest = ball.points().to_vec();
    let parts = [100..2208, 0..900].map(|range| ball.triangles()[range].to_vec());
    let [holed, sheet] = parts.map(|part| Collider::new(context, rest.clone(), part, DAffine3::IDENTITY).unwrap());
    assert!(!holed.is_closed() && !holed.is_sheet() && sheet.is_sheet());
    let mut colliders = [ball, holed, sheet];
    for frame in 0..3 {
        let lift = 0.05 * frame as f32;
        let stretched: Vec<_> = rest.iter().map(|p| [p[0], p[1] * (1.0 + lift), p[2]]).collect();
        for collider in &mut colliders {
            collider.set_points(context, &stretched).unwrap();
        }
        press(frame, &mut colliders);
    }
}

/// Stretches and shears points, more with every frame.
pub(crate) fn lifted(points: &[[f32; 3]], frame: u32) -> Vec<[f32; 3]> {
    let lift = 0.05 * frame as f32;
    points.iter().map(|p| [p[0], p[1] * (1.0 + lift), p[2] + lift * p[0]]).collect()
}

pub(crate) fn transforms() -> [DAffine3; 3] {
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.3), DVec3::new(1.0, -2.0, 0.5));
    let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.2, 0.9)) * turned;
    [DAffine3::IDENTITY, turned, DAffine3::from_translation(DVec3::new(40.0, 70.0, -10.0)) * stretched]
}

#[test]
fn imprints_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut apart, mut all, mut changed) = (0, 0, 0);
    let limited = ImprintSettings { share: 0.7, depth_limit: 0.3, smoothing: 0.4, ..settings() };
    let rimmed = ImprintSettings { rim: 0.4, rim_width: 0.3, ..settings() };
    for (transform, settings) in transforms().into_iter().zip([settings(), limited, rimmed]) {
        let [mut here, mut there] = [object(&context, 32, transform), object(&context, 32, transform)];
        there.use_device(Some(&device)).unwrap();
        let mut collider = ball(&context, 0.7);
        let expected = press(&context, &mut here, &mut collider, &settings);
        let found = press(&context, &mut there, &mut collider, &settings);
        assert!(there.take_device_fault().is_none());
        let stages = context.stats().take();
        for stage in ["imprint.device", "imprint.device.raycast"] {
            assert_eq!(stages.iter().filter(|event| event.stage == stage).count(), 5, "{stage}");
        }
        assert_eq!(found.changed, expected.changed);
        assert_eq!((found.allocated, found.bytes), (expected.allocated, expected.bytes));
        assert!(
            found.changed_coefficients.abs_diff(expected.changed_coefficients) * 1000 < expected.changed_coefficients
        );
        let (differ, count) = difference(here.displacement().field(), there.displacement().field());
        println!(
            "{differ} of {count} coefficients are more than one half apart, {} changed",
            expected.changed_coefficients
        );
        apart += differ;
        all += count;
        changed += expected.changed_coefficients;
    }
    assert!(changed > 10_000, "{changed}");
    assert!(apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn what_has_no_room_at_first_is_done_again_with_more() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object(&context, 256, DAffine3::IDENTITY));
    there.use_device(Some(&device)).unwrap();
    let mut collider = ball(&context, 2.5);
    let low = DVec3::new(3.5, 3.5, 2.2);
    collider.set_transform(DAffine3::from_translation(low)).unwrap();
    let press = |object: &mut DisplacedObject| {
        Imprinter::new().imprint(&context, object, &collider, &settings(), Moment::default()).unwrap()
    };
    let (expected, found) = (press(&mut here), press(&mut there));
    assert!(there.take_device_fault().is_none());
    // 512 blocks of 256 coefficients are the room at first, for blocks that are looked at and blocks that change.
    assert!(expected.changed_coefficients > 512 * 256, "{expected:?}");
    assert_eq!(found.changed, expected.changed);
    let (apart, all) = difference(here.displacement().field(), there.displacement().field());
    println!("{apart} of {all} coefficients are more than one half apart");
    assert!(apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn animated_surfaces_deforming_colliders_and_open_ones_too() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let cage = sheet().points;
    let [mut here, mut there] = [0, 1].map(|_| object(&context, 32, DAffine3::IDENTITY));
    there.use_device(Some(&device)).unwrap();
    for object in [&mut here, &mut there] {
        let mut imprinter = Imprinter::new();
        deform_balls(&context, |frame, colliders| {
            object.pose(&context, &lifted(&cage, frame)).unwrap();
            for collider in colliders {
                collider.set_transform(place(object, frame)).unwrap();
                let moment = Moment { frame: u64::from(frame), ..Moment::default() };
                imprinter.imprint(&context, object, collider, &settings(), moment).unwrap();
            }
        });
    }
    assert!(there.take_device_fault().is_none());
    let (apart, all) = difference(here.displacement().field(), there.displacement().field());
    println!("{apart} of {all} coefficients are more than one half apart");
    assert!(all > 5_000 && apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn edits_of_a_device_are_undone_and_seen_by_what_follows() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object(&context, 32, DAffine3::IDENTITY));
    there.use_device(Some(&device)).unwrap();
    let mut collider = ball(&context, 0.7);
    for object in [&mut here, &mut there] {
        let traces = Traces::of(object.displacement().field(), 1 << 30).unwrap();
        object.set_traces(traces).unwrap();
        press(&context, object, &mut collider, &settings());
    }
    let first = bits(there.displacement().field());
    let mut saved = object(&context, 32, DAffine3::IDENTITY);
    copy(&there, &mut saved);
    let traced = |object: &DisplacedObject| object.traces().unwrap().field().allocated().collect::<Vec<_>>();
    assert_eq!(traced(&there), traced(&here));
    // Something else is written by the processor, and goes away again: what the device has follows.
    let lower = ImprintSettings { culling: 0, ..settings() };
    let press_at = |object: &mut DisplacedObject, collider: &mut Collider, settings: &ImprintSettings| {
        collider.set_transform(DAffine3::from_translation(DVec3::new(4.2, 4.1, 0.5))).unwrap();
        Imprinter::new().imprint(&context, object, collider, settings, Moment::default()).unwrap()
    };
    assert!(!press_at(&mut there, &mut collider, &lower).changed.is_empty());
    assert_ne!(bits(there.displacement().field()), first);
    copy(&saved, &mut there);
    assert_eq!(bits(there.displacement().field()), first);
    for object in [&mut here, &mut there] {
        assert!(!press_at(object, &mut collider, &settings()).changed.is_empty());
    }
    let (apart, all) = difference(here.displacement().field(), there.displacement().field());
    assert!(apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn the_processor_takes_over_from_a_lost_device_in_the_middle() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [0, 1].map(|_| object(&context, 32, DAffine3::IDENTITY));
    let mut collider = ball(&context, 0.7);
    let mut imprinter = Imprinter::new();
    for frame in 0..4 {
        if frame == 2 {
            // From here on both are the processor's, from the same state.
            copy(&there, &mut here);
            device.abandon();
        } else if frame == 0 {
            there.use_device(Some(&device)).unwrap();
        }
        for object in [&mut here, &mut there] {
            collider.set_transform(place(object, frame)).unwrap();
            let moment = Moment { frame: u64::from(frame), ..Moment::default() };
            let report = imprinter.imprint(&context, object, &collider, &settings(), moment).unwrap();
            assert!(!report.changed.is_empty());
        }
    }
    assert_eq!(bits(here.displacement().field()), bits(there.displacement().field()));
    let fault = there.take_device_fault().expect("it is told");
    assert_eq!(fault.kind, relievo_core::ErrorKind::Device, "{fault}");
    assert!(there.take_device_fault().is_none(), "once");
}

#[test]
fn sweeps_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let limited = ImprintSettings { depth_limit: 0.25, ..settings() };
    let (mut apart, mut all) = (0, 0);
    for settings in [settings(), limited] {
        let [mut here, mut there] = [0, 1].map(|_| object(&context, 32, transforms()[1]));
        there.use_device(Some(&device)).unwrap();
        let [expected, found] = [&mut here, &mut there].map(|object| sweep(&context, object, 4, &settings));
        assert!(there.take_device_fault().is_none() && expected.sub_steps > 4, "{expected:?}");
        assert_eq!((found.sub_steps, &found.changed), (expected.sub_steps, &expected.changed));
        assert_eq!((found.allocated, found.bytes), (expected.allocated, expected.bytes));
        let (differ, count) = difference(here.displacement().field(), there.displacement().field());
        println!("{differ} of {count} coefficients are more than one half apart");
        (apart, all) = (apart + differ, all + count);
    }
    assert!(apart * 10_000 < all, "{apart} of {all}");
}

/// A flat sheet without extraordinary vertices, at which imprints are not independent of the ring update.
pub fn plate() -> Mesh {
    let points = (0..64).map(|k| [(k % 8) as f32, (k / 8) as f32, 0.0]).collect();
    let corners = (0..49u32).map(|k| 8 * (k / 7) + k % 7).flat_map(|a| [a, a + 1, a + 9, a + 8]).collect();
    Mesh::new(points, vec![4; 49], corners)
}

/// Compares objects that a device imprinted, and what was reported of it, with the processor's.
pub(crate) fn assert_alike(
    here: &[DisplacedObject],
    there: &mut [DisplacedObject],
    (expected, found): (&[Report], &[Report]),
) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert_eq!((&a.changed, a.sub_steps, a.allocated, a.bytes), (&b.changed, b.sub_steps, b.allocated, b.bytes));
    }
    let (mut apart, mut all) = (0, 0);
    for (here, there) in here.iter().zip(there) {
        assert!(there.take_device_fault().is_none());
        let (differ, count) = difference(here.displacement().field(), there.displacement().field());
        (apart, all) = (apart + differ, all + count);
    }
    println!("{apart} of {all} coefficients are more than one half apart");
    assert!(apart * 10_000 < all, "{apart} of {all}");
}

#[test]
fn pairs_of_a_frame_are_one_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || transforms().map(|transform| object_of(&context, plate(), 32, transform));
    let [mut here, mut there] = [make(), make()];
    for object in &mut there {
        object.use_device(Some(&device)).unwrap();
    }
    // Balls that overlap on each of three sheets, in turns.
    let balls: Vec<Collider> = (0..9)
        .map(|pair| {
            let mut collider = ball(&context, 0.7);
            collider.set_transform(place(&here[pair % 3], pair as u32 / 3)).unwrap();
            collider
        })
        .collect();
    let settings = settings();
    let press = |objects: &mut [DisplacedObject; 3]| {
        let presses = balls.iter().enumerate().map(|(pair, collider)| {
            let moment = Moment { pair: pair as u32, ..Moment::default() };
            Press { into: pair % 3, collider, settings: &settings, moment }
        });
        let presses: Vec<_> = presses.collect();
        let mut objects = objects.each_mut();
        Imprinter::new().imprint_all(&context, &mut objects, &presses).unwrap()
    };
    let expected = press(&mut here);
    context.stats().take();
    let found = press(&mut there);
    let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
    assert_eq!(submitted, 1);
    assert_alike(&here, &mut there, (&expected, &found));
    let missing = [Press { into: 3, collider: &balls[0], settings: &settings, moment: Moment::default() }];
    assert!(Imprinter::new().imprint_all(&context, &mut there.each_mut(), &missing).is_err());
}

#[test]
fn motions_of_a_frame_are_one_submission() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (settings, limited) = (settings(), ImprintSettings { depth_limit: 0.25, ..settings() });
    // Three balls on their way over two sheets; the last motion begins where those before have ended.
    let cases = [(0, 0, 0, &settings), (1, 1, 0, &settings), (0, 2, 1, &settings), (1, 0, 2, &limited)];
    let sweep = |objects: &mut [DisplacedObject; 2], together: bool| {
        let mut balls = [0.7, 0.6, 0.5].map(|radius| ball(&context, radius));
        let motions = cases.map(|(into, by, step, _)| {
            let ends = [step, step + 1].map(|step| Pose::rigid(place(&objects[into], step)));
            let [from, to] = ends;
            Motion::new(&balls[by], from, to).unwrap()
        });
        let moment = |pair| Moment { pair, ..Moment::default() };
        let mut imprinter = Imprinter::new();
        if !together {
            let one = |(pair, ((into, by, _, settings), motion)): (usize, (&(usize, usize, u32, &_), &Motion))| {
                let (object, ball) = (&mut objects[*into], &mut balls[*by]);
                imprinter.sweep(&context, object, ball, motion, settings, moment(pair as u32)).unwrap()
            };
            return cases.iter().zip(&motions).enumerate().map(one).collect::<Vec<_>>();
        }
        let sweeps: Vec<_> = (0..)
            .zip(cases.iter().zip(&motions))
            .map(|(pair, (&(into, by, _, settings), motion))| Sweep {
                into,
                by,
                motion,
                settings,
                moment: moment(pair),
            })
            .collect();
        imprinter.sweep_all(&context, &mut objects.each_mut(), &mut balls.each_mut(), &sweeps).unwrap()
    };
    let make = || [transforms()[0], transforms()[1]].map(|it| object_of(&context, plate(), 32, it));
    let [mut one_by_one, mut here, mut there] = [make(), make(), make()];
    for object in &mut there {
        object.use_device(Some(&device)).unwrap();
    }
    let expected = sweep(&mut one_by_one, false);
    assert_eq!(sweep(&mut here, true), expected);
    context.stats().take();
    let found = sweep(&mut there, true);
    let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
    assert!(submitted == 2 && expected.iter().map(|report| report.sub_steps).sum::<u64>() > 6, "{submitted}");
    assert_alike(&here, &mut there, (&expected, &found));
}

#[test]
fn what_a_budget_refuses_is_not_there_for_those_that_follow() {
    check_refusals(&settings());
}

#[test]
fn journals_of_imprints_on_a_device_undo_and_recover_them() {
    const LIMIT: u64 = 1 << 30;
    let Some(device) = device() else { return };
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("imprints.relievo");
    let settings = ImprintSettings { smoothing: 0.4, ..settings() };
    let mut collider = ball(&context, 0.7);
    let mut make = |object: &mut DisplacedObject, number: u32| {
        collider.set_transform(place(object, number)).unwrap();
        let moment = Moment { frame: u64::from(number), ..Moment::default() };
        let report = Imprinter::new().imprint(&context, object, &collider, &settings, moment).unwrap();
        assert!(!report.changed.is_empty());
    };
    let is = |object: &DisplacedObject, state: &Vec<(u32, Vec<u16>)>| bits(object.displacement().field()) == *state;
    let fresh = || {
        let mut object = object(&context, 32, DAffine3::IDENTITY);
        object.use_device(Some(&device)).unwrap();
        object
    };
    let mut object = fresh();
    let mut document = Document::new(&sheet(), context.level().name()).unwrap();
    object.store(&context, &mut document).unwrap();
    let mut history = History::new(LIMIT);
    history.save(&path, &document).unwrap();
    let mut states = vec![bits(object.displacement().field())];
    for number in 0..4 {
        history.begin(&context, &mut object, &format!("imprint {number}")).unwrap();
        make(&mut object, number);
        history.end(&context, &mut object).unwrap().unwrap();
        states.push(bits(object.displacement().field()));
    }
    for state in states[..4].iter().rev() {
        history.undo(&context, &mut object).unwrap().unwrap();
        assert!(is(&object, state));
    }
    // Made after something was undone and made again, an imprint is what it was.
    for _ in 0..3 {
        history.redo(&context, &mut object).unwrap().unwrap();
    }
    history.begin(&context, &mut object, "imprint 3").unwrap();
    make(&mut object, 3);
    assert!(is(&object, &states[4]));
    // The program ends before the texels are journalled: its input is there, and what it changed is not.
    assert!(object.take_device_fault().is_none() && history.is_under_way());
    drop((object, history));
    let under_way = Document::open(&path, LIMIT).unwrap().notes;
    assert!(under_way.iter().any(|note| note.contains("not in it: imprint 3")), "{under_way:?}");
    let (document, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
    let mut object = fresh();
    object.take_up(&context, &document, LIMIT).unwrap();
    assert!(history.undo_count() == 3 && is(&object, &states[3]));
    // Only that one is made again, once it is the device that does it and once, after its loss, the processor.
    history.begin(&context, &mut object, "imprint 3").unwrap();
    make(&mut object, 3);
    assert!(is(&object, &states[4]));
    history.abandon(&context, &mut object).unwrap();
    assert!(is(&object, &states[3]));
    history.begin(&context, &mut object, "imprint 3").unwrap();
    device.abandon();
    make(&mut object, 3);
    history.end(&context, &mut object).unwrap().unwrap();
    assert!(object.take_device_fault().is_some());
    let last = bits(object.displacement().field());
    history.undo(&context, &mut object).unwrap().unwrap();
    assert!(is(&object, &states[3]));
    drop(history);
    let (document, history) = History::open(&path, LIMIT, LIMIT).unwrap();
    let mut opened = self::object(&context, 32, DAffine3::IDENTITY);
    opened.take_up(&context, &document, LIMIT).unwrap();
    assert_eq!((history.undo_count(), history.redo_count()), (3, 1));
    assert!(is(&opened, &states[3]));
    let mut history = history;
    history.redo(&context, &mut opened).unwrap().unwrap();
    assert!(is(&opened, &last));
}
