//! Particles that a surface needs, found on a graphics device, against the processor's.

use glam::Vec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_fluid::{
    Classes, DeviceFluid, Fluid, FluidOptions, Surface, SurfaceFunction, Visibility, block, classify, classify_on, mesh,
};
use relievo_testing::device;

use crate::shapes::{FUNCTIONS, hollow, lattice};

/// Of support radii, how far from a limit a particle may be whose class differs.
const BAND: f32 = 1e-4;

/// Asserts that classes differ in a share of the particles at most, and those within the band of a limit.
fn assert_same(points: &[[f32; 3]], surface: &Surface, [made, expected]: [&Classes; 2], share: f32) {
    let support = surface.function().support();
    let limits = [0.5 * support, surface.influence() + 3.0f32.sqrt() * 0.25 * support];
    let differing = (0..points.len()).filter(|at| made.of[*at] != expected.of[*at]);
    let differing: Vec<usize> = differing.collect();
    println!("{:?}: {} of {} differ", surface.function(), differing.len(), points.len());
    assert!(differing.len() as f32 <= share * points.len() as f32);
    let vertices = match differing.is_empty() {
        true => Vec::new(),
        false => mesh(&Context::serial(), surface, 0.25 * support, &[], &mut Silent).unwrap().points,
    };
    for at in differing {
        let own = Vec3::from(points[at]);
        let nearest = vertices.iter().map(|vertex| own.distance(Vec3::from(*vertex))).fold(f32::INFINITY, f32::min);
        assert!(limits.iter().any(|limit| (nearest - limit).abs() < BAND * support), "{at}: {nearest} {limits:?}");
    }
}

#[test]
fn classes_on_a_device_are_those_of_the_processor_and_leave_the_surface_as_it_is() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    // On both sides of 0.
    let points: Vec<[f32; 3]> = hollow(30).into_iter().map(|point| point.map(|at| at - 0.21)).collect();
    for function in [SurfaceFunction::blobs, SurfaceFunction::zhu_bridson, SurfaceFunction::density] {
        let surface = Surface::new(&context, &points, function(0.01)).unwrap();
        let expected = classify(&context, &points, &surface, None, &mut Silent).unwrap();
        let made = classify_on(&device, &points, function(0.01), None).unwrap();
        assert!(made == classify_on(&device, &points, function(0.01), None).unwrap());
        assert_same(&points, &surface, [&made, &expected], 1e-3);
        assert!(made.surface > 0 && made.blind > 0 && made.kept() < 1.0);
        let kept: Vec<[f32; 3]> = made.indices().map(|at| points[at]).collect();
        let reduced = Surface::new(&context, &kept, function(0.01)).unwrap();
        let (mut all, mut few) = (surface.probe(&context), reduced.probe(&context));
        for point in &mesh(&context, &surface, 0.01, &[], &mut Silent).unwrap().points {
            let (all, few) = (all.sample(*point).value, few.sample(*point).value);
            assert!((all - few).abs() < 1e-6, "{function:?} {all} {few}", function = surface.function());
        }
    }
}

#[test]
fn a_fluid_on_a_device_is_classified_there() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut fluid = Fluid::new(FluidOptions { spacing: 0.02, ..FluidOptions::default() }).unwrap();
    fluid.add(&block(Vec3::ZERO, Vec3::splat(0.24), 0.02).unwrap(), Vec3::ZERO).unwrap();
    fluid.add(&block(Vec3::X * 40.0, Vec3::X * 40.0 + 0.04, 0.02).unwrap(), Vec3::ZERO).unwrap();
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    sent.advance(0.01, |_, _| Ok(())).unwrap();
    let state = sent.state().unwrap();
    let points: Vec<[f32; 3]> = state.places.iter().map(|place| place.truncate().to_array()).collect();
    let function = SurfaceFunction::zhu_bridson(0.01);
    let made = sent.classify(function, None).unwrap();
    assert!(made == classify_on(&device, &points, function, None).unwrap());
    let surface = Surface::new(&context, &points, function).unwrap();
    let expected = classify(&context, &points, &surface, None, &mut Silent).unwrap();
    assert_same(&points, &surface, [&made, &expected], 1e-3);
    assert_eq!(made.of[points.len() - 1], Visibility::Surface);
}

#[test]
fn what_a_device_does_not_classify_is_refused() {
    let Some(device) = device() else { return };
    let points = lattice(4, 0.02);
    for (function, threshold, what) in [
        (FUNCTIONS[3](0.01), None, "anisotropic"),
        (FUNCTIONS[2](0.01), Some(1.0), "threshold of 1"),
        (FUNCTIONS[2](0.01), Some(-1.0), "threshold is -1"),
        (FUNCTIONS[2](0.01), Some(f32::NAN), "threshold is NaN"),
        (FUNCTIONS[0](-1.0), None, "support radius"),
    ] {
        let error = classify_on(&device, &points, function, threshold).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let function = FUNCTIONS[1](0.01);
    for (points, what) in [
        (vec![[0.0; 3]; 3000], "3000 particles"),
        (vec![[0.0; 3], [f32::NAN; 3]], "finite"),
        (vec![[0.0; 3], [0.0, f32::NEG_INFINITY, 0.0]], "finite"),
        (vec![[0.0; 3], [0.0, 1e9, 0.0]], "from 0"),
        (vec![[0.0; 3], [90.0, 90.0, 90.0]], "support radii"),
    ] {
        let error = classify_on(&device, &points, function, None).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    assert!(classify_on(&device, &[], function, None).unwrap().of.is_empty());
    // What is far from each other has bricks of its own.
    let far = classify_on(&device, &[[-50.0, 0.0, 0.0], [50.0, 0.0, 0.0]], function, Some(0.0)).unwrap();
    assert_eq!(far.of, [Visibility::Surface; 2]);
}
