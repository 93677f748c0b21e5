//! Forces on all particles beside gravity and what hosts add, as accelerations that follow from places, velocities and time.

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Error, Result};

use crate::solver::noise::curl;

/// Particles of a task.
const CHUNK_LEN: usize = 4096;
/// The share of a difference of velocities that drags take away in a second, at most: they are not to turn it in a step.
const FASTEST: f32 = 100.0;

/// An acceleration of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    /// The same everywhere, in m/s².
    Gravity(Vec3),
    /// Particles are taken along by air of a velocity in m/s, by this share of the difference in a second.
    Wind {
        /// Of the air, in m/s.
        velocity: Vec3,
        /// In 1/s, 0 to 100.
        share: f32,
    },
    /// Particles are slowed down.
    Drag {
        /// By this share of their velocity in a second, 0 to 100.
        share: f32,
        /// And by as much more a metre, in 1/m; 0 or more.
        square: f32,
    },
    /// Pushes around an axis, counter-clockwise seen from where it points.
    Vortex {
        /// A place on the axis, in metres.
        place: Vec3,
        /// Its direction, of any length.
        axis: Vec3,
        /// At the radius and beyond it ever less, as the inverse of the distance; within, in proportion to it. In m/s².
        strength: f32,
        /// In metres; positive.
        radius: f32,
    },
    /// Pulls towards a place, as strongly as at the radius within it, and beyond it by the inverse square of the distance.
    Attractor {
        /// In metres.
        place: Vec3,
        /// In m/s²; negative pushes away.
        strength: f32,
        /// In metres; positive.
        radius: f32,
    },
    /// Eddies without sources, the curl of noise (Bridson, Hourihan, Nordenstam 2007, Section 2), the same in every run.
    Turbulence {
        /// About how strong, in m/s².
        strength: f32,
        /// The size of eddies, in metres; positive.
        scale: f32,
        /// How often they change in a second; 0 or more.
        rate: f32,
        /// Others for each number.
        seed: u32,
    },
}

impl Force {
    /// Checks the numbers of the force.
    ///
    /// # Errors
    /// Fails if a number is not finite, a radius or scale is not between 10⁻⁹ and 10⁹, an axis has no length, a share
    /// is not from 0 to 100 a second, or a rate is not from 0 to 10⁶.
    pub fn check(&self) -> Result<()> {
        let is_share = |share: f32| (0.0..=FASTEST).contains(&share);
        let is_length = |length: f32| length > 1e-9 && length < 1e9;
        let is_sound = match *self {
            Self::Gravity(acceleration) => acceleration.is_finite(),
            Self::Wind { velocity, share } => velocity.is_finite() && is_share(share),
            Self::Drag { share, square } => is_share(share) && square >= 0.0 && square.is_finite(),
            Self::Vortex { place, axis, strength, radius } => {
                place.is_finite() && axis.normalize_or_zero() != Vec3::ZERO && strength.is_finite() && is_length(radius)
            }
            Self::Attractor { place, strength, radius } => {
                place.is_finite() && strength.is_finite() && is_length(radius)
            }
            Self::Turbulence { strength, scale, rate, .. } => {
                strength.is_finite() && is_length(scale) && (0.0..1e6).contains(&rate)
            }
        };
        if is_sound {
            return Ok(());
        }
        Err(Error::invalid(format!("a force cannot be {self:?}"))
            .advise("use finite numbers, positive lengths, an axis of some length, and shares from 0 to 100 a second"))
    }

    /// The acceleration of a particle at a time in seconds, in m/s².
    pub fn acceleration(&self, place: Vec3, velocity: Vec3, time: f64) -> Vec3 {
        match *self {
            Self::Gravity(acceleration) => acceleration,
            Self::Wind { velocity: air, share } => share * (air - velocity),
            Self::Drag { share, square } => -(share + square * velocity.length()).min(FASTEST) * velocity,
            Self::Vortex { place: middle, axis, strength, radius } => {
                let axis = axis.normalize_or_zero();
                let around = axis.cross(place - middle);
                around * (strength * radius / around.length_squared().max(radius * radius))
            }
            Self::Attractor { place: middle, strength, radius } => {
                let to = middle - place;
                let distance = to.length();
                let fall = (radius / distance.max(radius)).powi(2);
                if distance > 0.0 { to * (strength * fall / distance) } else { Vec3::ZERO }
            }
            Self::Turbulence { strength, scale, rate, seed } => {
                strength * curl(place / scale, time * f64::from(rate), seed)
            }
        }
    }
}

/// Adds the accelerations of forces to those of particles, and returns their sum, in m/s². Some particles may be skipped; an
/// empty list skips none.
pub fn apply(
    context: &Context,
    forces: &[Force],
    [places, velocities]: [&[Vec4]; 2],
    time: f64,
    skipped: &[bool],
    accelerations: &mut [Vec4],
) -> DVec3 {
    if forces.is_empty() {
        return DVec3::ZERO;
    }
    let mut parts: Vec<_> = accelerations.chunks_mut(CHUNK_LEN).map(|part| (part, DVec3::ZERO)).collect();
    context.for_each_mut(&mut parts, |part, (accelerations, sum)| {
        for (particle, acceleration) in (part * CHUNK_LEN..).zip(accelerations.iter_mut()) {
            if skipped.get(particle).is_some_and(|skipped| *skipped) {
                continue;
            }
            let [place, velocity] = [places[particle].xyz(), velocities[particle].xyz()];
            let all: Vec3 = forces.iter().map(|force| force.acceleration(place, velocity, time)).sum();
            *acceleration += all.extend(0.0);
            *sum += all.as_dvec3();
        }
    });
    parts.iter().map(|(_, sum)| *sum).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fluid, FluidOptions};

    #[test]
    fn forces_are_what_they_say() {
        let at =
            |force: Force, place: [f32; 3], velocity: [f32; 3]| force.acceleration(place.into(), velocity.into(), 0.0);
        let wind = Force::Wind { velocity: Vec3::X * 3.0, share: 2.0 };
        assert_eq!(at(wind, [0.0; 3], [1.0, 0.0, 0.0]), Vec3::X * 4.0);
        assert_eq!(at(Force::Drag { share: 1.0, square: 0.5 }, [0.0; 3], [0.0, 2.0, 0.0]), Vec3::Y * -4.0);
        let vortex = Force::Vortex { place: Vec3::ZERO, axis: Vec3::Z * 2.0, strength: 6.0, radius: 1.0 };
        assert_eq!(at(vortex, [2.0, 0.0, 7.0], [0.0; 3]), Vec3::Y * 3.0);
        assert_eq!(at(vortex, [0.5, 0.0, 0.0], [0.0; 3]), Vec3::Y * 3.0);
        let attractor = Force::Attractor { place: Vec3::X, strength: 8.0, radius: 1.0 };
        assert_eq!(at(attractor, [3.0, 0.0, 0.0], [0.0; 3]), Vec3::X * -2.0);
        assert_eq!(at(attractor, [1.0, 0.0, 0.0], [0.0; 3]), Vec3::ZERO);
        assert!(Force::Wind { velocity: Vec3::X, share: 101.0 }.check().is_err());
        assert!(Force::Attractor { place: Vec3::X, strength: 8.0, radius: 0.0 }.check().is_err());
        assert!(Force::Vortex { place: Vec3::X, axis: Vec3::ZERO, strength: 8.0, radius: 1.0 }.check().is_err());
        assert!(Force::Turbulence { strength: f32::NAN, scale: 1.0, rate: 1.0, seed: 0 }.check().is_err());
    }

    #[test]
    fn what_gravity_hosts_forces_and_walls_give_is_what_a_fluid_gets() {
        let (context, spacing) = (Context::serial(), 0.05);
        let mut fluid = Fluid::new(FluidOptions { spacing, ..FluidOptions::default() }).unwrap();
        fluid.set_walls(&context, &crate::basin(Vec3::ZERO, Vec3::new(0.6, 0.4, 0.6), spacing).unwrap()).unwrap();
        let places = crate::block(Vec3::ZERO, Vec3::new(0.4, 0.4, 0.4), spacing).unwrap();
        fluid.add(&places, Vec3::ZERO).unwrap();
        let turbulence = Force::Turbulence { strength: 5.0, scale: 0.2, rate: 4.0, seed: 1 };
        fluid.set_forces(&[turbulence, Force::Drag { share: 2.0, square: 0.0 }]).unwrap();
        assert!(fluid.set_forces(&[Force::Gravity(Vec3::NAN)]).is_err());
        fluid.accelerate(&vec![Vec3::new(3.0, 1.0, 0.0); fluid.len()]).unwrap();
        let before = fluid.momentum();
        let mut sums = [DVec3::ZERO; 4];
        let watch = |_: &mut Fluid, done: &crate::StepStatistics| {
            let given = [done.given.gravity, done.given.host, done.given.forces, done.given.walls];
            sums.iter_mut().zip(given).for_each(|(sum, given)| *sum += given);
            Ok(())
        };
        fluid.advance(&context, 0.2, watch).unwrap();
        let gained = (fluid.momentum() - before).as_dvec3();
        let all: DVec3 = sums.iter().sum();
        assert!(gained.distance(all) < 1e-4 * sums[0].length(), "{gained} {sums:?}");
        let mass = f64::from(fluid.mass()) * places.len() as f64;
        assert!((sums[0] / mass - DVec3::new(0.0, 0.0, -9.81 * 0.2)).length() < 1e-3);
        assert!((sums[1] / mass - DVec3::new(0.6, 0.2, 0.0)).length() < 1e-3);
        assert!(sums[3].z > 0.3 * -sums[0].z && sums[2].length() > 0.0);
    }
}
