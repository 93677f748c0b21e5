//! Fluids on a graphics device, against the processor's.

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::Context;
use relievo_fluid::{Batch, DeviceFluid, Fluid, FluidOptions, Force, KernelSet, State, TimeStep, basin, block};
use relievo_testing::device;

const SPACING: f32 = 0.02;

/// A block of water beside three sides of a basin.
fn dam(options: FluidOptions) -> Fluid {
    let mut fluid = Fluid::new(FluidOptions { spacing: SPACING, ..options }).unwrap();
    fluid.add(&block(Vec3::ZERO, Vec3::new(0.2, 0.2, 0.4), SPACING).unwrap(), Vec3::ZERO).unwrap();
    let walls = basin(Vec3::ZERO, Vec3::new(0.8, 0.2, 0.6), SPACING).unwrap();
    fluid.set_walls(&Context::serial(), &walls).unwrap();
    fluid
}

/// Places by the numbers of particles.
fn places(state: &State) -> Vec<Vec4> {
    let mut places = vec![Vec4::ZERO; state.numbers.len()];
    state.numbers.iter().zip(&state.places).for_each(|(number, place)| places[*number as usize] = *place);
    places
}

fn energy(state: &State) -> f32 {
    state.velocities.iter().map(|velocity| velocity.length_squared()).sum()
}

#[test]
fn a_step_on_a_device_is_that_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for kernels in [KernelSet::Wendland, KernelSet::Mueller] {
        let options = FluidOptions { kernels, cohesion: 1.0, viscosity: 1e-2, ..FluidOptions::default() };
        let mut fluid = dam(options);
        fluid.advance(&context, 0.15, |_, _| Ok(())).unwrap();
        fluid.accelerate(&vec![Vec3::new(1.0, 2.0, -0.5); fluid.len()]).unwrap();
        let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
        assert_eq!(sent.time_step(), fluid.time_step());
        let before = places(&fluid.state());
        let step = 0.5 * fluid.time_step();
        let (made, expected) = (sent.step(step).unwrap(), fluid.step(&context, step).unwrap());
        assert_eq!(made.seconds, expected.seconds);
        assert!(made.corrections.abs_diff(expected.corrections) <= 1, "{made:?} {expected:?}");
        assert!((made.excess.mean - expected.excess.mean).abs() < 1e-4, "{made:?} {expected:?}");
        let (made, expected) = (places(&sent.state().unwrap()), places(&fluid.state()));
        let moved = expected.iter().zip(&before).map(|(a, b)| a.xyz().distance(b.xyz())).fold(0.0, f32::max);
        let off = made.iter().zip(&expected).map(|(a, b)| a.xyz().distance(b.xyz())).fold(0.0, f32::max);
        assert!(moved > 0.02 * SPACING && off < 1e-3 * moved, "{off} of {moved}");
        assert!((sent.time_step() / fluid.time_step() - 1.0).abs() < 1e-2);
    }
}

/// One of each, as strong as gravity.
fn forces() -> [Force; 6] {
    let (place, radius) = (Vec3::new(0.1, 0.05, 0.2), 0.15);
    [
        Force::Gravity(Vec3::new(1.0, -2.0, 3.0)),
        Force::Wind { velocity: Vec3::new(2.0, 1.0, 0.0), share: 3.0 },
        Force::Drag { share: 2.0, square: 40.0 },
        Force::Vortex { place, axis: Vec3::new(0.0, 1.0, 2.0), strength: 8.0, radius },
        Force::Attractor { place, strength: 8.0, radius },
        Force::Turbulence { strength: 8.0, scale: 0.06, rate: 5.0, seed: 7 },
    ]
}

#[test]
fn forces_on_a_device_are_those_of_the_processor_and_what_it_was_given_is_what_it_got() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut fluid = dam(FluidOptions::default());
    fluid.advance(&context, 0.1, |_, _| Ok(())).unwrap();
    let state = fluid.state();
    let step = 0.5 * fluid.time_step();
    for force in forces() {
        fluid.set_state(state.clone()).unwrap();
        fluid.set_forces(&[force]).unwrap();
        let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
        assert!(sent.state().unwrap() == fluid.state());
        let (made, expected) = (sent.step(step).unwrap(), fluid.step(&context, step).unwrap());
        let off = made.given.forces.distance(expected.given.forces) / expected.given.forces.length();
        let walls = made.given.walls.distance(expected.given.walls) / expected.given.walls.length();
        println!("{force:?}: {off:.1e} {walls:.1e}");
        assert!(off < 1e-4 && walls < 1e-2, "{made:?} {expected:?}");
        let (made, expected) = (places(&sent.state().unwrap()), places(&fluid.state()));
        let off = made.iter().zip(&expected).map(|(a, b)| a.xyz().distance(b.xyz())).fold(0.0, f32::max);
        assert!(off < 1e-4 * SPACING, "{force:?} {off}");
    }
    fluid.set_state(state).unwrap();
    fluid.set_forces(&forces()).unwrap();
    fluid.accelerate(&vec![Vec3::new(3.0, 1.0, 0.0); fluid.len()]).unwrap();
    let before = fluid.momentum();
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    let mut sums = [DVec3::ZERO; 4];
    let watch = |_: &mut DeviceFluid, done: &relievo_fluid::StepStatistics| {
        let given = [done.given.gravity, done.given.host, done.given.forces, done.given.walls];
        sums.iter_mut().zip(given).for_each(|(sum, given)| *sum += given);
        Ok(())
    };
    sent.advance(0.1, watch).unwrap();
    fluid.set_state(sent.state().unwrap()).unwrap();
    let gained = (fluid.momentum() - before).as_dvec3();
    let all: DVec3 = sums.iter().sum();
    assert!(gained.distance(all) < 1e-3 * sums[0].length(), "{gained} {sums:?}");
    assert!(sums.iter().all(|sum| sum.length() > 0.1 * sums[0].length()), "{sums:?}");
}

#[test]
fn pressures_of_a_device_are_those_that_moved_the_particles() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut fluid = dam(FluidOptions::default());
    fluid.advance(&context, 0.1, |_, _| Ok(())).unwrap();
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    let step = fluid.time_step();
    fluid.step(&context, step).unwrap();
    sent.step(step).unwrap();
    let by_number = |state: &State| {
        let mut told = vec![[0.0; 2]; state.numbers.len()];
        let pressures = state.pressures.iter().zip(&state.places).map(|(told, place)| [*told, place.w]);
        state.numbers.iter().zip(pressures).for_each(|(number, pressures)| told[*number as usize] = pressures);
        told
    };
    let (made, expected) = (by_number(&sent.state().unwrap()), by_number(&fluid.state()));
    for kind in 0..2 {
        let most = expected.iter().map(|pressures| pressures[kind]).fold(0.0, f32::max);
        let off = made.iter().zip(&expected).map(|(a, b)| (a[kind] - b[kind]).abs()).fold(0.0, f32::max);
        assert!(most > 500.0 && off < 1e-2 * most, "{kind}: {off} of {most}");
    }
    // A run that was sent anew after every step goes on as one that was not.
    let mut other = Fluid::new(fluid.options().clone()).unwrap();
    other.set_walls(&context, &basin(Vec3::ZERO, Vec3::new(0.8, 0.2, 0.6), SPACING).unwrap()).unwrap();
    other.set_state(sent.state().unwrap()).unwrap();
    for _ in 0..5 {
        let step = sent.time_step();
        let mut again = DeviceFluid::new(&device, &other).unwrap();
        let (made, anew) = (sent.step(step).unwrap(), again.step(step).unwrap());
        assert!(made.corrections.abs_diff(anew.corrections) <= 1, "{made:?} {anew:?}");
        other.set_state(again.state().unwrap()).unwrap();
    }
    let (made, anew) = (places(&sent.state().unwrap()), places(&other.state()));
    let off = made.iter().zip(&anew).map(|(a, b)| a.xyz().distance(b.xyz())).fold(0.0, f32::max);
    assert!(off < 1e-2 * SPACING, "{off}");
}

#[test]
fn a_dam_on_a_device_breaks_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut fluid = dam(FluidOptions::default());
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    let mut again = DeviceFluid::new(&device, &fluid).unwrap();
    let (mut steps, mut most) = ([0, 0], 0.0f32);
    for _ in 0..3 {
        let mut corrections = [0, 0];
        fluid
            .advance(&context, 0.1, |_, done| {
                (steps[0], corrections[0]) = (steps[0] + 1, corrections[0] + done.corrections);
                Ok(())
            })
            .unwrap();
        sent.advance(0.1, |_, done| {
            (steps[1], corrections[1]) = (steps[1] + 1, corrections[1] + done.corrections);
            // The first step has no pressures to begin with.
            most = if steps[1] > 1 { most.max(done.excess.most) } else { 0.0 };
            Ok(())
        })
        .unwrap();
        again.advance(0.1, |_, _| Ok(())).unwrap();
        let (made, expected) = (sent.state().unwrap(), fluid.state());
        assert!(made == again.state().unwrap());
        let front = |state: &State| state.places.iter().map(|place| place.x).fold(0.0, f32::max);
        let middle =
            |state: &State| state.places.iter().map(|place| place.xyz()).sum::<Vec3>() / state.places.len() as f32;
        println!(
            "steps {steps:?}, corrections {corrections:?}, front {} {}, energy {}",
            front(&made),
            front(&expected),
            energy(&made) / energy(&expected)
        );
        assert!((front(&made) / front(&expected) - 1.0).abs() < 0.03);
        assert!((energy(&made) / energy(&expected) - 1.0).abs() < 0.03);
        assert!(middle(&made).distance(middle(&expected)) < 0.1 * SPACING);
    }
    assert!(most <= 0.01, "{most}");
    // And on with the processor.
    fluid.set_state(sent.state().unwrap()).unwrap();
    fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
}

#[test]
fn momentum_on_a_device_stays_where_there_are_no_walls() {
    let Some(device) = device() else { return };
    let mut fluid =
        Fluid::new(FluidOptions { spacing: SPACING, gravity: Vec3::ZERO, ..FluidOptions::default() }).unwrap();
    let side = Vec3::new(0.2, 0.2, 0.1);
    fluid.add(&block(Vec3::ZERO, side, SPACING).unwrap(), Vec3::X).unwrap();
    fluid.add(&block(Vec3::X * 0.22, Vec3::X * 0.22 + side, SPACING).unwrap(), -Vec3::X).unwrap();
    fluid.add(&block(Vec3::Z * 0.12, Vec3::Z * 0.12 + side, SPACING).unwrap(), -Vec3::Z).unwrap();
    let before = fluid.momentum();
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    sent.advance(0.1, |_, _| Ok(())).unwrap();
    fluid.set_state(sent.state().unwrap()).unwrap();
    // What the blocks bring against each other.
    let exchanged = 2.0 * fluid.mass() * 500.0;
    assert!(fluid.momentum().distance(before) < 1e-4 * exchanged, "{before} {}", fluid.momentum());
}

#[test]
fn crowds_find_room_on_a_device_and_what_cannot_be_is_refused() {
    let Some(device) = device() else { return };
    let spread = |count: u32| -> Vec<Vec3> {
        let at = |i: u32, k: u32| (i.wrapping_mul(k) >> 8) as f32 / (1 << 24) as f32;
        let place = |i| Vec3::new(at(i, 0x9e37_79b1), at(i, 0x85eb_ca77), at(i, 0xc2b2_ae3d));
        (0..count).map(|i| 0.05 * place(i)).collect()
    };
    let options = FluidOptions { spacing: SPACING, gravity: Vec3::ZERO, ..FluidOptions::default() };
    let mut crowd = Fluid::new(options.clone()).unwrap();
    crowd.add(&spread(200), Vec3::ZERO).unwrap();
    let mut sent = DeviceFluid::new(&device, &crowd).unwrap();
    sent.step(1e-4).unwrap();
    let mut heap = Fluid::new(FluidOptions { time_step: TimeStep::Fixed(1e-3), ..options }).unwrap();
    heap.add(&[Vec3::ONE; 5000], Vec3::ZERO).unwrap();
    assert!(DeviceFluid::new(&device, &heap).unwrap().step(1e-3).is_err());
    let mut mortal = Fluid::new(FluidOptions::default()).unwrap();
    let batch = Batch { places: &[Vec3::ZERO], velocities: &[Vec3::ZERO], lifetime: 1.0, channels: &[] };
    mortal.add_batch(&batch).unwrap();
    assert!(DeviceFluid::new(&device, &mortal).unwrap_err().to_string().contains("lifetimes"));
    let tense = Fluid::new(FluidOptions { tension: 0.072, ..FluidOptions::default() }).unwrap();
    assert!(DeviceFluid::new(&device, &tense).unwrap_err().to_string().contains("tension"));
    let empty = Fluid::new(FluidOptions::default()).unwrap();
    let mut sent = DeviceFluid::new(&device, &empty).unwrap();
    assert!(sent.is_empty() && sent.step(0.01).unwrap().seconds == 0.01 && sent.state().unwrap().numbers.is_empty());
}
