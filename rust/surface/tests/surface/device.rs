//! Surfaces on a graphics device against the processor's.

use relievo_core::{Context, ContextOptions, Mesh};
use relievo_gpu::{Buffer, Device};
use relievo_surface::{DeviceSurface, Order, Place, Samples, Surface, SurfaceOptions};
use relievo_testing::{Random, cage, device, grid};

fn places(random: &mut Random, tiles: usize, count: usize) -> Vec<Place> {
    let ends = [0.0, 1.0, 0.5, 0.25];
    let mut parameter = |k: usize| if k.is_multiple_of(5) { ends[k / 5 % 4] } else { random.unit() };
    (0..count).map(|k| Place::new((k % tiles) as u32, parameter(k), parameter(k / 3))).collect()
}

/// Samples of a device, in the order of [`Samples`]: quantity, axis, place.
fn evaluated(device: &Device, surface: &DeviceSurface, places: &[Place], order: Order, pose: bool) -> Vec<f32> {
    let on_device = Buffer::of(device, "places", places).expect("a buffer");
    let numbers = 3 * order.quantities() * places.len();
    let samples = Buffer::new(device, "samples", numbers).expect("a buffer");
    let evaluation = surface.evaluation(device, &on_device, order, &samples).expect("an evaluation");
    let mut frame = device.frame().expect("a frame");
    if pose {
        surface.pose(&mut frame.pass("pose")).expect("a pose");
    }
    surface.evaluate(&mut frame.pass("evaluate"), &evaluation, places.len() as u32).expect("an evaluation");
    let result = frame.read(&samples, 0..numbers).expect("a copy");
    let _ = frame.submit().expect("a submission");
    result.get(device).expect("samples")
}

/// The largest difference of every quantity over the largest value of that quantity that the processor has.
fn differences(ours: &[f32], expected: &Samples, order: Order) -> Vec<f32> {
    let quantities = [&expected.p, &expected.du, &expected.dv, &expected.duu, &expected.duv, &expected.dvv];
    let count = order.quantities();
    let stride = 3 * count;
    quantities[..count]
        .iter()
        .enumerate()
        .map(|(quantity, values)| {
            let (mut worst, mut most) = (0.0_f32, f32::MIN_POSITIVE);
            for (axis, values) in values.iter().enumerate() {
                for (place, value) in values.iter().enumerate() {
                    worst = worst.max((ours[stride * place + 3 * quantity + axis] - value).abs());
                    most = most.max(value.abs());
                }
            }
            worst / most
        })
        .collect()
}

fn check(name: &str, device: &Device, mesh: &Mesh, options: &SurfaceOptions) {
    let context = Context::new(&ContextOptions::default()).expect("a context");
    let surface = Surface::new(&context, mesh, options).expect("a surface");
    let mut random = Random(5);
    let places = places(&mut random, surface.tile_count(), 20_000);
    let mut on_device = DeviceSurface::new(device, &surface).expect("a surface on the device");
    let mut expected = Samples::default();
    surface.evaluate(&context, &places, Order::Second, &mut expected).expect("samples");
    let ours = evaluated(device, &on_device, &places, Order::Second, false);
    let same_data = differences(&ours, &expected, Order::Second);
    println!("{name}: same control data {same_data:?}");
    // Second derivatives are divided by the squares of the sizes of patches, which magnifies rounding.
    let limits = [2e-7, 2e-6, 2e-6, 1e-5, 1e-5, 1e-5];
    assert!(same_data.iter().zip(limits).all(|(it, limit)| *it < limit), "{name}: {same_data:?}");

    // Another pose, far from the origin, made on the device.
    let moved: Vec<[f32; 3]> =
        mesh.points.iter().map(|p| [p[0] + 0.1 * (5.0 * p[1]).sin() + 3.0, 1.3 * p[1], p[2] - p[0]]).collect();
    let posed = surface.posed(&context, &moved).expect("a pose");
    on_device.set_points(device, &moved).expect("points");
    for order in [Order::Position, Order::First, Order::Second] {
        posed.evaluate(&context, &places, order, &mut expected).expect("samples");
        let ours = evaluated(device, &on_device, &places, order, true);
        let other_pose = differences(&ours, &expected, order);
        println!("{name}: pose of the device {other_pose:?}");
        // Second derivatives of the smallest patches magnify what rounds their points.
        let limits = [3e-7, 3e-6, 3e-6, 1e-5, 1e-5, 1e-5];
        assert!(other_pose.iter().zip(limits).all(|(it, limit)| *it < limit), "{name}: {other_pose:?}");
    }
}

#[test]
fn surfaces_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let mut creased = grid(8, false, &[2, 3, 2, 2, 0, 2, 1], false);
    let edge = |a: u32, b: u32, sharpness: f32| relievo_core::Crease { points: [a, b], sharpness };
    creased.creases.extend((0..6).map(|k| edge(37 + k, 38 + k, 2.5)));
    creased.creases.extend((0..5).map(|k| edge(4 + 9 * k, 13 + 9 * k, 10.0)));
    check("creased grid", &device, &creased, &SurfaceOptions::default());
    for name in ["bigguy.obj", "monsterfrog.obj"] {
        let Some(mesh) = cage(name) else { continue };
        check(name, &device, &mesh, &SurfaceOptions::default());
    }
}

#[test]
fn places_that_are_not_there_are_zeros() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut mesh = grid(3, false, &[2], false);
    mesh.holes.push(4);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).expect("a surface");
    let mut on_device = DeviceSurface::new(&device, &surface).expect("a surface on the device");
    let strange =
        [(4, 0.5, 0.5), (9, 0.5, 0.5), (u32::MAX, 0.5, 0.5), (0, -0.1, 0.5), (0, 0.5, 1.5), (0, f32::NAN, 0.5)];
    let places = strange.map(|(tile, u, v)| Place::new(tile, u, v));
    let samples = evaluated(&device, &on_device, &places, Order::First, false);
    assert!(samples.iter().all(|value| *value == 0.0), "{samples:?}");
    assert!(on_device.set_points(&device, &[[0.0; 3]; 15]).is_err(), "too few points");
    let mut points = mesh.points.clone();
    points[3][1] = f32::NAN;
    assert!(on_device.set_points(&device, &points).is_err(), "a point that is not finite");
}
