//! Cohesion, and what no flow can be made of.

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;
use relievo_fluid::{
    ColliderOptions, Excess, Fluid, FluidOptions, PressureSolver, TimeStep, basin, block, cuboid, sphere,
};

/// Corners come nearer to the middle, and particles in the mean.
#[test]
fn cohesion_makes_a_cube_rounder() {
    let context = Context::serial();
    let options = FluidOptions { spacing: 0.05, gravity: Vec3::ZERO, viscosity: 0.01, ..FluidOptions::default() };
    let mut fluid = Fluid::new(FluidOptions { cohesion: 0.02, ..options }).unwrap();
    fluid.add(&block(Vec3::splat(-0.25), Vec3::splat(0.25), 0.05).unwrap(), Vec3::ZERO).unwrap();
    let distances = |fluid: &Fluid| {
        let squares = fluid.places().iter().map(|place| place.xyz().length_squared());
        (squares.clone().fold(0.0, f32::max).sqrt(), squares.sum::<f32>() / fluid.len() as f32)
    };
    let before = distances(&fluid);
    fluid.advance(&context, 1.25, |_, _| Ok(())).unwrap();
    let after = distances(&fluid);
    println!("{before:?} m and m², then {after:?}");
    assert!(after.0 < 0.95 * before.0 && after.1 < 0.995 * before.1, "{before:?} {after:?}");
    assert!(fluid.momentum().length() < 1e-4 * fluid.mass() * fluid.len() as f32);
}

/// Steps that are too long, forces without bounds and particles on each other end in an error or in numbers that are finite.
#[test]
fn what_no_flow_can_be_made_of_ends_well() {
    let context = Context::serial();
    let options = FluidOptions { spacing: 0.05, ..FluidOptions::default() };
    let side = Vec3::splat(0.5);
    let is_bounded = |options: &FluidOptions, places: &[Vec3], push: f32| {
        let mut fluid = Fluid::new(options.clone()).unwrap();
        fluid.add(places, Vec3::ZERO).unwrap();
        fluid.set_walls(&context, &basin(Vec3::ZERO, side, 0.05).unwrap()).unwrap();
        fluid.accelerate(&vec![Vec3::X * push; fluid.len()]).unwrap();
        for _ in 0..20 {
            if let Err(error) = fluid.step(&context, fluid.time_step()) {
                assert!(!error.remedy.is_empty(), "{error}");
                break;
            }
        }
        assert!(fluid.places().iter().chain(fluid.velocities()).all(|row| row.is_finite()));
        assert!(fluid.pressures().iter().all(|pressure| pressure.is_finite()));
    };
    let filled = block(Vec3::ZERO, side, 0.05).unwrap();
    for solver in [PressureSolver::Pcisph, PressureSolver::Dfsph] {
        let options = FluidOptions { solver, corrections: [3, 30], ..options.clone() };
        for fixed in [1e-6, 0.01, 1.0, 1e6] {
            is_bounded(&FluidOptions { time_step: TimeStep::Fixed(fixed), ..options.clone() }, &filled, 0.0);
        }
        for push in [1e4, 1e12, 1e30] {
            is_bounded(&options, &filled, push);
        }
        is_bounded(&options, &[Vec3::splat(0.25); 200], 0.0);
        is_bounded(&options, &[Vec3::splat(0.25); 5000], 0.0);
    }
}

/// Fluid that begins inside a collider, which takes its room, ends in an error that says so after a few steps, or goes on.
#[test]
fn fluid_that_begins_inside_a_collider_ends_well() {
    let (context, spacing, side) = (Context::serial(), 0.05, Vec3::splat(0.5));
    let shapes = [cuboid(Vec3::splat(0.14), Vec3::splat(0.36)), sphere(Vec3::splat(0.25), 0.13)];
    for (solver, shape) in [PressureSolver::Pcisph, PressureSolver::Dfsph].into_iter().zip(&shapes) {
        let options = FluidOptions { spacing, solver, ..FluidOptions::default() };
        let mut fluid = Fluid::new(options).unwrap();
        fluid.set_walls(&context, &basin(Vec3::ZERO, side + Vec3::Z * 0.3, spacing).unwrap()).unwrap();
        fluid.add(&block(Vec3::ZERO, side, spacing).unwrap(), Vec3::ZERO).unwrap();
        fluid.add_collider(&context, &shape.0, &shape.1, ColliderOptions::default()).unwrap();
        let (mut steps, mut shortest) = (0, f32::MAX);
        while fluid.seconds() < 0.1 && steps < 200 {
            steps += 1;
            match fluid.step(&context, fluid.time_step()) {
                Ok(done) => shortest = shortest.min(done.seconds),
                Err(error) => {
                    assert!(error.remedy.contains("colliders"), "{error}");
                    break;
                }
            }
        }
        println!("{solver:?}: {} s in {steps} steps of {shortest:.1e} s at least", fluid.seconds());
        assert!(steps < 200 && fluid.places().iter().chain(fluid.velocities()).all(|row| row.is_finite()));
    }
}

/// A fluid that may be a tenth too dense is held to that, and is not thrown much farther than others.
#[test]
fn a_loose_bound_of_density_is_kept() {
    for solver in [PressureSolver::Pcisph, PressureSolver::Dfsph] {
        let (context, spacing, side) = (Context::serial(), 0.025, Vec3::new(0.3, 0.2, 0.6));
        let excess = Excess { most: 0.1, mean: 0.1 };
        let mut fluid = Fluid::new(FluidOptions { spacing, solver, excess, ..FluidOptions::default() }).unwrap();
        fluid.add(&block(Vec3::ZERO, side, spacing).unwrap(), Vec3::ZERO).unwrap();
        fluid.set_walls(&context, &basin(Vec3::ZERO, Vec3::new(1.2, 0.2, 0.9), spacing).unwrap()).unwrap();
        let (mut steps, mut fastest, mut densest) = (0, 0.0f32, 0.0f32);
        fluid
            .advance(&context, 0.6, |fluid, done| {
                let speeds = fluid.velocities().iter().map(|velocity| velocity.xyz().length());
                (steps, fastest) = (steps + 1, speeds.fold(fastest, f32::max));
                densest = densest.max(done.excess.most);
                Ok(())
            })
            .unwrap();
        let fastest = fastest / (2.0 * 9.81 * side.z).sqrt();
        println!("{solver:?}: {steps} steps, {fastest:.2} √(2 g h) at most, {densest:.3} too dense");
        assert!(steps < 2000 && fastest < 6.0 && densest <= 0.1, "{steps} {fastest} {densest}");
    }
}
