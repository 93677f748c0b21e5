//! How diffuse particles move, by their kinds (Ihmsen et al. 2012, Sections 3.3 and 3.4).

use glam::Vec3;
use relievo_core::Context;

use super::options::DiffuseOptions;
use super::surroundings::Surroundings;
use super::{DiffuseKind, DiffuseParticles, PART};

/// Moves particles by a step of so many seconds and gives them their kinds. Foam loses as much of its lifetime.
pub fn advance(
    context: &Context,
    options: &DiffuseOptions,
    fluid: &Surroundings,
    seconds: f32,
    particles: &mut DiffuseParticles,
) {
    let DiffuseParticles { positions, velocities, kinds, ages, lifetimes, .. } = particles;
    let parts = ((positions.as_mut_slice(), velocities.as_mut_slice()), kinds.as_mut_slice());
    let lists = (parts, (ages.as_mut_slice(), lifetimes.as_mut_slice()));
    let done = context.for_each_part(lists, PART, |_, (((positions, velocities), kinds), (ages, lifetimes))| {
        for (at, position) in positions.iter_mut().enumerate() {
            let velocity = &mut velocities[at];
            let (kind, flow) = about(options, fluid, *position);
            kinds[at] = kind;
            ages[at] += seconds;
            match kind {
                // The parabola of the step, to which no step is too long.
                DiffuseKind::Spray => {
                    *position += seconds * (*velocity + 0.5 * seconds * options.gravity);
                    *velocity += seconds * options.gravity;
                }
                DiffuseKind::Foam => {
                    *velocity = flow;
                    *position += seconds * flow;
                    lifetimes[at] -= seconds;
                }
                DiffuseKind::Bubble => {
                    *velocity += -seconds * options.settings.buoyancy * options.gravity + options.settings.drag * (flow - *velocity);
                    *position += seconds * *velocity;
                }
            }
        }
        Ok(())
    });
    // The work above has no error.
    debug_assert!(done.is_ok());
}

/// Returns the kind of a particle by the number of its neighbours, and their mean velocity (Equation 10).
fn about(options: &DiffuseOptions, fluid: &Surroundings, position: Vec3) -> (DiffuseKind, Vec3) {
    let (mut count, mut sum, mut weights) = (0, Vec3::ZERO, 0.0);
    fluid.around(position, |other, _, _, share| {
        let weight = spline(share);
        count += 1;
        sum += weight * fluid.velocities[other];
        weights += weight;
    });
    let kind = match count {
        _ if count < options.settings.spray_below => DiffuseKind::Spray,
        _ if count > options.settings.bubbles_above => DiffuseKind::Bubble,
        _ => DiffuseKind::Foam,
    };
    (kind, if weights > 0.0 { sum / weights } else { Vec3::ZERO })
}

/// Returns the cubic spline (Monaghan 1992) at a share of the support radius, without its constant factor.
fn spline(share: f32) -> f32 {
    let q = 2.0 * share;
    if q < 1.0 { 1.0 - 1.5 * q * q + 0.75 * q * q * q } else { 0.25 * (2.0 - q).max(0.0).powi(3) }
}
