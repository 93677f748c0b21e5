//! How long steps are.

use crate::solver::constants::Constants;
use crate::{FluidOptions, TimeStep};

/// Corrections beyond the least ones from which on steps become shorter, and below which they become longer.
const CORRECTIONS: [u32; 2] = [9, 3];
/// By how much they do.
const SHORTER: f32 = 0.85;
const LONGER: f32 = 1.1;
/// The part of h² / ν that a step may last, by which viscosity takes a share of a difference of velocities.
const VISCOUS: f32 = 0.1;
/// The share of the longest step below which one that does not converge is an error.
const SHORTEST: f32 = 1e-3;
/// How much faster than was reckoned with when a step began its particles may be when it ends.
const FASTER: f32 = 1.5;
/// The share of what a particle is too dense by when a step begins, as where two have met in the one before or begin in each
/// other, that a step of half the longest takes away where all at once does not converge.
const EASED: f32 = 0.5;

/// What the length of the next step follows from.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The largest acceleration of the step before, in m/s².
    pub pulled: f32,
    /// The share of the Courant step that is taken.
    pub share: f32,
}

impl Pace {
    /// That of a fluid which nothing has moved yet.
    pub fn new(options: &FluidOptions) -> Self {
        Self { pulled: options.gravity.length(), share: 1.0 }
    }

    /// The length of a step, in seconds, where the greatest speed is so much, in m/s.
    pub fn step(&self, options: &FluidOptions, constants: &Constants, speed: f32) -> f32 {
        match options.time_step {
            TimeStep::Fixed(step) => step,
            TimeStep::Courant { number, most } => {
                let (reach, pull) = (number * options.spacing, self.pulled);
                // The time in which reach = speed t + pull t² / 2.
                let step = 2.0 * reach / (speed + (speed * speed + 2.0 * pull * reach).sqrt()).max(f32::MIN_POSITIVE);
                let Constants { kernels, viscosity, friction, .. } = *constants;
                let viscous =
                    VISCOUS * kernels.support * kernels.support / viscosity.max(friction).max(f32::MIN_POSITIVE);
                // That of the shortest waves on the surface (Brackbill, Kothe, Zemach 1992, Equation 61), with the mean density
                // of the fluid and of nothing.
                let tension = 4.0 * std::f32::consts::PI * options.tension.max(f32::MIN_POSITIVE);
                let capillary = (options.density * options.spacing.powi(3) / tension).sqrt();
                self.share * step.min(most).min(viscous).min(capillary)
            }
        }
    }

    /// How far a particle may go in a step of so many seconds, in metres, where the greatest speed was so much. Corrections
    /// throw one out of some thousands where water meets walls, and by shorter steps ever faster.
    pub fn farthest(&self, options: &FluidOptions, constants: &Constants, speed: f32, seconds: f32) -> f32 {
        match options.time_step {
            TimeStep::Fixed(_) => options.spacing,
            TimeStep::Courant { number, .. } => {
                let whole = Self { share: 1.0, ..*self }.step(options, constants, speed);
                options.spacing * (FASTER * number * seconds / whole).min(1.0)
            }
        }
    }

    /// The length of the next try after a step of so many seconds did not converge, and the share that it may keep of what it
    /// is too dense by when it begins. `None` where steps are fixed or get too short.
    pub fn again(&mut self, options: &FluidOptions, seconds: f32) -> Option<(f32, f32)> {
        let TimeStep::Courant { most, .. } = options.time_step else { return None };
        if self.share <= SHORTEST {
            return None;
        }
        self.share *= 0.5;
        Some((0.5 * seconds, 1.0 - EASED * (seconds / most).min(1.0)))
    }

    /// Takes in a step that took so many corrections in all tries, and in which the greatest acceleration was so much.
    pub fn settle(&mut self, options: &FluidOptions, corrections: u32, pulled: f32) {
        let more = corrections.saturating_sub(options.corrections[0]);
        if more > CORRECTIONS[0] {
            self.share *= SHORTER;
        } else if more < CORRECTIONS[1] {
            self.share = (self.share * LONGER).min(1.0);
        }
        self.pulled = pulled;
    }
}

/// The length of the next step where so much time is left: two steps of the same length rather than a whole one and what is
/// left of it.
pub fn within(step: f32, left: f32) -> f32 {
    if step >= left {
        left
    } else if 2.0 * step > left {
        0.5 * left
    } else {
        step
    }
}
