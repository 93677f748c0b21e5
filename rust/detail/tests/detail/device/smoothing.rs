//! Imprints on a graphics device that are smoothed: those of a submission start from what the ones before them left.

use glam::DAffine3;
use relievo_core::Context;
use relievo_detail::{Collider, DisplacedObject, ImprintSettings, Imprinter, Moment, Press, Report};
use relievo_gpu::Device;
use relievo_testing::device;
use relievo_tiles::Traces;

use super::imprints::{assert_alike, ball, bits, check_refusals, object, place, settings, transforms};

/// Sheets with faces of all kinds and sizes, with traces.
fn sheets<const N: usize>(context: &Context, device: Option<&Device>) -> [DisplacedObject; N] {
    std::array::from_fn(|index| {
        let mut object = object(context, 32, transforms()[index]);
        let traces = Traces::of(object.displacement().field(), 1 << 30).unwrap();
        object.set_traces(traces).unwrap();
        object.use_device(device).unwrap();
        object
    })
}

/// Presses balls that overlap into the sheets, in turns, with `settings` in turns, and returns what each did and how often
/// something was submitted for it.
fn press<const N: usize>(
    context: &Context,
    imprinter: &mut Imprinter,
    objects: &mut [DisplacedObject; N],
    (radius, settings): (f32, &[ImprintSettings]),
    together: bool,
) -> (Vec<Report>, usize) {
    let balls: Vec<Collider> = (0..5 * N)
        .map(|pair| {
            let mut collider = ball(context, radius);
            collider.set_transform(place(&objects[pair % N], (pair / N) as u32)).unwrap();
            collider
        })
        .collect();
    let presses: Vec<Press<'_>> = balls
        .iter()
        .zip(0..)
        .map(|(collider, pair)| {
            let settings = &settings[pair as usize % settings.len()];
            Press { into: pair as usize % N, collider, settings, moment: Moment { pair, ..Moment::default() } }
        })
        .collect();
    let mut objects = objects.each_mut();
    context.stats().take();
    let size = if together { presses.len() } else { 1 };
    let each = presses.chunks(size).flat_map(|some| imprinter.imprint_all(context, &mut objects, some).unwrap());
    let reports = each.collect();
    let submitted = context.stats().take().iter().filter(|event| event.stage == "imprint.device.submit").count();
    (reports, submitted)
}

/// Compares imprints in a row on the processor, on a device in so many submissions, and there one by one.
fn compare<const N: usize>(imprinter: &mut Imprinter, settings: (f32, &[ImprintSettings]), submissions: usize) {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut here, mut there) = (sheets::<N>(&context, None), sheets::<N>(&context, Some(&device)));
    let mut alone = sheets::<N>(&context, Some(&device));
    let (expected, _) = press(&context, imprinter, &mut here, settings, true);
    let (found, submitted) = press(&context, imprinter, &mut there, settings, true);
    assert_eq!(submitted, submissions);
    let (apart, submitted) = press(&context, imprinter, &mut alone, settings, false);
    assert_eq!(submitted, 5 * N);
    for (there, alone) in there.iter().zip(&alone) {
        assert!(bits(there.displacement().field()) == bits(alone.displacement().field()));
    }
    let changed = |reports: &[Report]| reports.iter().map(|report| report.changed_coefficients).collect::<Vec<_>>();
    assert_eq!(changed(&found), changed(&apart));
    assert_alike(&here, &mut there, (&expected, &found));
}

#[test]
fn what_is_smoothed_on_one_object_is_one_submission() {
    let smooth = ImprintSettings { smoothing: 0.6, ..settings() };
    compare::<1>(&mut Imprinter::new(), (0.6, &[smooth]), 1);
    // Of five the last alone.
    let plain = settings();
    compare::<1>(&mut Imprinter::new(), (0.6, &[plain, plain, plain, plain, smooth]), 1);
}

#[test]
fn what_is_smoothed_on_two_objects_is_one_submission() {
    let often = ImprintSettings { smoothing: 0.4, smoothing_passes: 3, ..settings() };
    // Some are smoothed, some not.
    let strongly = ImprintSettings { smoothing: 1.0, ..often };
    compare::<2>(&mut Imprinter::new(), (0.6, &[often, strongly, settings()]), 1);
}

#[test]
fn what_has_no_room_to_be_smoothed_is_done_again_with_more() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let smooth = [ImprintSettings { smoothing: 0.6, ..settings() }];
    let mut imprinter = Imprinter::new();
    // Blocks of larger tiles than the next ones.
    let mut large = [object(&context, 128, DAffine3::IDENTITY)];
    large[0].use_device(Some(&device)).unwrap();
    let (_, submitted) = press(&context, &mut imprinter, &mut large, (0.6, &smooth), true);
    assert!(submitted == 1 && large[0].take_device_fault().is_none());
    compare::<3>(&mut imprinter, (1.3, &smooth), 2);
}

#[test]
fn what_a_budget_refuses_is_not_smoothed_for_those_that_follow() {
    check_refusals(&ImprintSettings { smoothing: 0.5, ..settings() });
}
