//! Potentials of diffuse particles against a hand-made vortex: trapped air, wave crests and kinetic energy (Ihmsen et al.
//! 2012, Section 3.1).

use glam::{Vec2, Vec3};
use relievo_core::Context;
use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseSettings, FluidFrame};

const SPACING: f32 = 0.02;

/// A vortex about the axis z (Rankine): it turns as a body within a radius, and beyond as potential flow does.
fn vortex(place: Vec3, rate: f32, core: f32) -> Vec3 {
    let square = place.x * place.x + place.y * place.y;
    let rate = if square <= core * core { rate } else { rate * core * core / square };
    rate * Vec3::new(-place.y, place.x, 0.0)
}

/// The sum of Equation 2 for each particle, of all pairs in f64.
fn trapped(positions: &[Vec3], velocities: &[Vec3]) -> Vec<f64> {
    let support = 2.0 * f64::from(SPACING);
    let pair = |i: usize, j: usize| {
        let (apart, relative) = ((positions[i] - positions[j]).as_dvec3(), (velocities[i] - velocities[j]).as_dvec3());
        let distance = apart.length();
        match distance > 0.0 && distance < support {
            true => (1.0 - distance / support) * (relative.length() - relative.dot(apart) / distance),
            false => 0.0,
        }
    };
    (0..positions.len()).map(|i| (0..positions.len()).map(|j| pair(i, j)).sum()).collect()
}

#[test]
fn a_vortex_traps_air_by_its_shear_and_breaks_no_crest() {
    const RATE: f32 = 40.0;
    let settings = DiffuseSettings {
        air_min: 0.0,
        air_max: 100.0,
        crest_min: 0.0,
        crest_max: 100.0,
        energy_min: 0.0,
        energy_max: 100.0,
        ..DiffuseSettings::default()
    };
    let core = 4.5 * SPACING;
    // A cube of a lattice about the axis, in the core and beyond it.
    let place = |n: u32| Vec3::new((n % 17) as f32 - 8.0, (n / 17 % 17) as f32 - 8.0, (n / 289) as f32 - 2.0);
    let positions: Vec<_> = (0..17 * 17 * 5).map(|n| SPACING * place(n)).collect();
    let velocities: Vec<_> = positions.iter().map(|place| vortex(*place, RATE, core)).collect();
    let run = Diffuse::new(DiffuseOptions { spacing: SPACING, settings, ..DiffuseOptions::default() }).unwrap();
    let found = |positions: &[Vec3], velocities: &[Vec3]| {
        run.potentials(&Context::serial(), FluidFrame { positions, velocities }).unwrap()
    };
    let of_lattice = found(&positions, &velocities);
    for ((found, velocity), air) in of_lattice.iter().zip(&velocities).zip(trapped(&positions, &velocities)) {
        assert!((found.energy - (0.005 * velocity.length_squared()).min(1.0)).abs() < 1e-5);
        if found.energy > 0.0 {
            assert!((f64::from(found.air) - 0.01 * air).abs() < 1e-5, "{} is not {}", found.air, 0.01 * air);
        }
    }
    // In the core neighbours pass each other at the rate times their distance across the axis: of the six, twelve and eight
    // at 1, √2 and √3 spacings 4, 4 and 8, and 8 are across it.
    let expected = 0.01 * RATE * SPACING * (6.0 + 8.0 * 2.0_f32.sqrt() - 4.0 * 6.0_f32.sqrt());
    let inner = positions.iter().position(|place| place.distance(SPACING * Vec3::new(2.0, 1.0, 0.0)) < 1e-6).unwrap();
    assert!((of_lattice[inner].air - expected).abs() < 1e-5, "{} is not {expected}", of_lattice[inner].air);
    // A column of rings, whose surface has the vortex along it: no crest, but one where the same column bursts.
    let ring = |at: u32| {
        let count = ((std::f32::consts::TAU * at as f32).round() as u32).max(1);
        (0..count).map(move |n| SPACING * at as f32 * Vec2::from_angle(std::f32::consts::TAU * n as f32 / count as f32))
    };
    let layer: Vec<Vec2> = (0..9).flat_map(ring).collect();
    let column: Vec<_> = (0..9).flat_map(|z| layer.iter().map(move |at| at.extend(SPACING * z as f32))).collect();
    let turning: Vec<_> = column.iter().map(|place| vortex(*place, RATE, core)).collect();
    let bursting: Vec<_> = column.iter().map(|place| RATE * Vec3::new(place.x, place.y, 0.0)).collect();
    assert!(found(&column, &turning).iter().all(|found| found.crest == 0.0));
    let rim = |place: &Vec3| place.truncate().length() > 7.5 * SPACING && (3.5..4.5).contains(&(place.z / SPACING));
    let burst = found(&column, &bursting);
    assert!(column.iter().zip(&burst).all(|(place, found)| !rim(place) || found.crest > 0.0));
}
