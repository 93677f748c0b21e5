//! Cohesion, and what no flow can be made of.

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;
use relievo_fluid::{Fluid, FluidOptions, PressureSolver, TimeStep, basin, block};

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
