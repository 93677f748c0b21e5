//! Births of diffuse particles (Ihmsen et al. 2012, Section 3.2).

use std::f32::consts::TAU;

use glam::Vec3;
use relievo_core::{Context, Error, Result};

use super::options::DiffuseOptions;
use super::potential::{Potentials, potentials};
use super::surroundings::Surroundings;
use super::{CHUNK_LEN, DiffuseKind, DiffuseParticles, random};

/// A diffuse particle when it is born.
#[derive(Clone, Copy, Debug)]
pub struct Born {
    position: Vec3,
    velocity: Vec3,
    lifetime: f32,
}

/// The particles that are born in a step.
#[derive(Debug, Default)]
pub struct Births {
    /// The particles that there is room for.
    pub born: Vec<Born>,
    /// How many there is no room for.
    pub refused: u64,
}

/// Returns the particles that are born in a step of so many seconds, in the order of the fluid's cells, of which the first
/// `room` are made. Births are counted before they are made, so that no rate of the settings exceeds the memory. Fails if
/// the particles that are made exceed the memory limit.
pub fn give(
    context: &Context,
    options: &DiffuseOptions,
    fluid: &Surroundings,
    seconds: f32,
    seed: u64,
    room: usize,
) -> Result<Births> {
    let found = potentials(context, options, fluid);
    let parts = found.len().div_ceil(CHUNK_LEN);
    let range = |part: usize| part * CHUNK_LEN..found.len().min((part + 1) * CHUNK_LEN);
    let count = |number: usize| count(options, &found[number], seconds, random::mix(seed, number as u64));
    let counts: Vec<u64> = context.map(parts, |part| range(part).map(|number| u64::from(count(number))).sum());
    let mut total = 0;
    let starts: Vec<u64> = counts
        .iter()
        .map(|count| {
            let start = total;
            total += count;
            start
        })
        .collect();
    let (room, limit) = (room as u64, context.memory_limit());
    let admitted = total.min(room);
    // Parts and their concatenation are there at a time, then the lists.
    let bytes = 2 * size_of::<Born>() + DiffuseParticles::BYTES;
    if admitted.saturating_mul(bytes as u64) > limit {
        return Err(Error::memory(format!("{admitted} diffuse particles are born in one step"))
            .at("births")
            .advise("lower air_rate, crest_rate or most, or raise the memory limit"));
    }
    let parts = context.map(parts, |part| {
        let mut left = room.saturating_sub(starts[part]).min(counts[part]);
        let mut born = Vec::with_capacity(left as usize);
        for number in range(part) {
            let made = u64::from(count(number)).min(left);
            let seed = random::mix(seed, number as u64);
            of_particle(options, fluid, &found[number], (number, made), (seconds, seed), &mut born);
            left -= made;
        }
        born
    });
    Ok(Births { born: parts.concat(), refused: total - admitted })
}

/// Returns the rate of births of a particle of the fluid, in 1/s (Equation 8).
fn rate(options: &DiffuseOptions, found: &Potentials) -> f32 {
    let Potentials { air, crest, energy } = *found;
    energy * (options.settings.air_rate * air + options.settings.crest_rate * crest)
}

/// Returns the number of births of a particle of the fluid.
fn count(options: &DiffuseOptions, found: &Potentials, seconds: f32, seed: u64) -> u32 {
    match rate(options, found) {
        // The part below one is a chance, so that the mean is right at any rate.
        rate if rate > 0.0 => (rate * seconds + random::unit(seed, 0)) as u32,
        _ => 0,
    }
}

/// Adds `count` particles that one of the fluid makes, in a cylinder along its way in the step (Figure 6).
fn of_particle(
    options: &DiffuseOptions,
    fluid: &Surroundings,
    found: &Potentials,
    (number, count): (usize, u64),
    (seconds, seed): (f32, u64),
    born: &mut Vec<Born>,
) {
    if count == 0 {
        return;
    }
    let settings = &options.settings;
    let greatest = settings.air_rate + settings.crest_rate;
    let [shortest, longest] = [settings.lifetime_min, settings.lifetime_max];
    let lifetime = shortest + (longest - shortest) * rate(options, found) / greatest;
    let velocity = fluid.velocity(number);
    let axis = velocity.normalize_or_zero();
    let (across, other) = axis.any_orthonormal_pair();
    let (radius, height) = (0.5 * options.spacing, seconds * velocity.length());
    for index in 0..count {
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
