//! Births of diffuse particles (Ihmsen et al. 2012, Section 3.2).

use std::f32::consts::TAU;

use glam::Vec3;
use relievo_core::Context;

use super::options::DiffuseOptions;
use super::potential::{Potentials, potentials};
use super::surroundings::Surroundings;
use super::{DiffuseKind, DiffuseParticles, PART, random};

/// A diffuse particle when it is born.
#[derive(Clone, Copy, Debug)]
pub struct Born {
    position: Vec3,
    velocity: Vec3,
    lifetime: f32,
}

/// Returns the particles that are born in a step of so many seconds, in the order of the fluid's cells.
pub fn give(context: &Context, options: &DiffuseOptions, fluid: &Surroundings, seconds: f32, seed: u64) -> Vec<Born> {
    let found = potentials(context, options, fluid);
    let parts = context.map(found.len().div_ceil(PART), |part| {
        let mut born = Vec::new();
        for number in part * PART..found.len().min((part + 1) * PART) {
            of_particle(options, fluid, &found[number], number, seconds, random::mix(seed, number as u64), &mut born);
        }
        born
    });
    parts.concat()
}

/// Adds the particles that one of the fluid makes, in a cylinder along its way in the step (Equation 8 and Figure 6).
fn of_particle(
    options: &DiffuseOptions,
    fluid: &Surroundings,
    found: &Potentials,
    number: usize,
    seconds: f32,
    seed: u64,
    born: &mut Vec<Born>,
) {
    let Potentials { air, crest, energy } = *found;
    let settings = &options.settings;
    let rate = energy * (settings.air_rate * air + settings.crest_rate * crest);
    if rate <= 0.0 {
        return;
    }
    // The part below one is a chance, so that the mean is right at any rate.
    let count = (rate * seconds + random::unit(seed, 0)) as u32;
    let greatest = settings.air_rate + settings.crest_rate;
    let [shortest, longest] = [settings.lifetime_min, settings.lifetime_max];
    let lifetime = shortest + (longest - shortest) * rate / greatest;
    let velocity = fluid.velocity(number);
    let axis = velocity.normalize_or_zero();
    let (across, other) = axis.any_orthonormal_pair();
    let (radius, height) = (0.5 * options.spacing, seconds * velocity.length());
    for index in 0..u64::from(count) {
        let [r, angle, along] = [1, 2, 3].map(|k| random::unit(seed, 3 * index + k));
        let (r, angle) = (radius * r.sqrt(), TAU * angle);
        let offset = r * (angle.cos() * across + angle.sin() * other);
        // In the step it has moved away from the axis already, as the paper lets it start.
        let position = fluid.place(number) + offset + along * height * axis;
        born.push(Born { position, velocity: velocity + offset, lifetime });
    }
}

/// Adds particles that were born, with ids from `first` on.
pub fn add(particles: &mut DiffuseParticles, born: &[Born], first: u64) {
    particles.positions.extend(born.iter().map(|born| born.position));
    particles.velocities.extend(born.iter().map(|born| born.velocity));
    particles.kinds.extend(born.iter().map(|_| DiffuseKind::Spray));
    particles.ages.extend(born.iter().map(|_| 0.0));
    particles.lifetimes.extend(born.iter().map(|born| born.lifetime));
    particles.ids.extend((first..).take(born.len()));
}
