//! How likely each particle of a fluid makes diffuse ones (Ihmsen et al. 2012, Section 3.1).

use glam::Vec3;
use relievo_core::Context;

use super::options::DiffuseOptions;
use super::surroundings::Surroundings;

/// The share of the support radius that the mean of the neighbours is away from a particle at the surface.
const SURFACE: f32 = 0.1;
/// The cosine between velocity and normal from which a crest breaks.
const BREAKING: f32 = 0.6;

/// The potentials of a particle, each from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Potentials {
    /// Trapped air (Equations 2 and 3).
    pub air: f32,
    /// Wave crests (Equations 4 to 7).
    pub crest: f32,
    /// Kinetic energy (Section 3.1.3).
    pub energy: f32,
}

/// Returns the potentials of all particles of a fluid, in the order of cells.
pub fn potentials(context: &Context, options: &DiffuseOptions, fluid: &Surroundings) -> Vec<Potentials> {
    let count = fluid.places.len();
    let normals = context.map(count, |number| normal(fluid, options, number));
    context.map(count, |number| potential(fluid, options, &normals, number))
}

/// Returns the outward normal of a particle at the surface, or zero of another.
fn normal(fluid: &Surroundings, options: &DiffuseOptions, number: usize) -> Vec3 {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    fluid.around(fluid.places[number], |_, from, _, share| {
        sum += (1.0 - share) * from;
        weights += 1.0 - share;
    });
    if sum.length() > SURFACE * options.support() * weights { sum.normalize_or_zero() } else { Vec3::ZERO }
}

fn potential(fluid: &Surroundings, options: &DiffuseOptions, normals: &[Vec3], number: usize) -> Potentials {
    let (velocity, normal) = (fluid.velocities[number], normals[number]);
    let settings = &options.settings;
    let energy = between([settings.energy_min, settings.energy_max], 0.5 * velocity.length_squared());
    // Without energy nothing is born, and most of a fluid is calm.
    if energy == 0.0 {
        return Potentials::default();
    }
    let is_breaking = normal != Vec3::ZERO && velocity.normalize_or_zero().dot(normal) >= BREAKING;
    let (mut air, mut crest) = (0.0, 0.0);
    fluid.around(fluid.places[number], |other, from, distance, share| {
        if distance == 0.0 {
            return;
        }
        let (weight, direction) = (1.0 - share, from / distance);
        let relative = velocity - fluid.velocities[other];
        let speed = relative.length();
        if speed > 0.0 {
            air += weight * (speed - relative.dot(direction));
        }
        // Where the surface is convex its neighbours lie below its tangent plane.
        if is_breaking && normals[other] != Vec3::ZERO && direction.dot(normal) > 0.0 {
            crest += weight * (1.0 - normal.dot(normals[other]));
        }
    });
    Potentials {
        air: between([settings.air_min, settings.air_max], air),
        crest: between([settings.crest_min, settings.crest_max], crest),
        energy,
    }
}

/// Returns how far a value is between limits, from 0 to 1 (Equation 1).
fn between([low, high]: [f32; 2], value: f32) -> f32 {
    (value.clamp(low, high) - low) / (high - low)
}
