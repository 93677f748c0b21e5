//! The pressures of a step.

use relievo_core::{Context, Result};

use super::{Fluid, StepStatistics};
use crate::PressureSolver;
use crate::boundary::sweep::Step;
use crate::solver::dfsph::slow;
use crate::solver::pairs::Rows;
use crate::solver::pcisph::{Correction, correct, predict, pressure_velocities};

/// The share of a step's pressures that the next begins with (Ihmsen et al. 2014, Section 3): with all of them they lag
/// behind, do work on what expands, and a fluid at rest boils.
pub const CARRIED: f32 = 0.5;
/// What velocities may make the fluid denser by in a step, in the mean, as a share of the mean excess that is allowed.
const GROWTH: f32 = 0.5;
/// Corrections of velocities, at least and at most: what is left is taken away by densities.
const SLOWED: [u32; 2] = [2, 20];

impl Fluid {
    /// Finds the pressures by which the fluid is not too dense after so many seconds, and where its particles are then.
    /// A share of what it is too dense by now may be kept. Returns whether it is not denser. Fails if another domain has ended.
    pub(super) fn press(&mut self, context: &Context, seconds: f32, kept: f32) -> Result<(StepStatistics, bool)> {
        let count = self.len();
        let gravity = self.options.gravity.extend(0.0);
        self.wall.predict(seconds);
        let mut done = StepStatistics { seconds, ..StepStatistics::default() };
        self.advected.clone_from(&self.particles.velocities);
        let pulls = self.accelerations.iter().zip(&self.particles.pushes);
        self.advected.iter_mut().zip(pulls).for_each(|(to, (pull, push))| *to += seconds * (*pull + *push + gravity));
        self.domain.refresh(&mut self.advected[..count])?;
        if self.options.solver == PressureSolver::Dfsph {
            done.divergence_corrections = self.slow(context, seconds)?;
        }
        let places = &mut self.particles.places;
        let correction = Correction {
            constants: self.constants,
            near: &self.near,
            walls: &self.near_walls,
            found: &self.found,
            velocities: &self.advected,
            step: seconds,
            begun_limit: (1.0 + self.options.excess.most) * self.constants.density,
            allowed_share: kept,
        };
        places.iter_mut().for_each(|place| place.w *= CARRIED);
        self.predicted.clone_from(places);
        let [least, most] = self.options.corrections;
        loop {
            let rows = Rows { fluid: places, walls: &self.wall.places };
            predict(context, &correction, rows, &mut self.predicted[..count]);
            let step = Step { seconds, spacing: self.options.spacing };
            self.sweep.hold(context, &self.colliders, &places[..count], &mut self.predicted[..count], step);
            self.domain.refresh(&mut self.predicted[..count])?;
            let rows = Rows { fluid: &self.predicted, walls: self.wall.ends() };
            let sums = correct(context, &correction, rows, &mut places[..count]);
            self.domain.refresh_last(&mut places[..count])?;
            let [excess, over] = self.domain.mean(sums, count)?;
            done.excess = excess;
            done.corrections += 1;
            let is_enough = over.most <= self.options.excess.most && over.mean <= self.options.excess.mean;
            if done.corrections >= if is_enough { least } else { most } {
                return Ok((done, is_enough));
            }
        }
    }

    /// Finds the pressures by which velocities do not compress the fluid, and those velocities, with the pressures. Returns how
    /// many corrections it took.
    fn slow(&mut self, context: &Context, seconds: f32) -> Result<u32> {
        let count = self.len();
        let places = &self.particles.places;
        let correction = Correction {
            constants: self.constants,
            near: &self.near,
            walls: &self.near_walls,
            found: &self.found,
            velocities: &self.advected,
            step: seconds,
            begun_limit: self.constants.density,
            allowed_share: 0.0,
        };
        self.predicted.clone_from(places);
        self.predicted.iter_mut().zip(&self.advected).for_each(|(row, velocity)| row.w = velocity.w);
        self.slowed.clone_from(&self.advected);
        let [least, most] = SLOWED;
        let mut corrections = 0;
        loop {
            let pressed = Rows { fluid: &self.predicted, walls: &self.wall.places };
            pressure_velocities(context, &correction, pressed, &mut self.slowed[..count]);
            self.domain.refresh(&mut self.slowed[..count])?;
            let moving = Rows { fluid: &self.slowed, walls: &self.wall.velocities };
            let places = Rows { fluid: places, walls: &self.wall.places };
            let sums = slow(context, &correction, places, moving, &mut self.predicted[..count]);
            self.domain.refresh_last(&mut self.predicted[..count])?;
            let [over] = self.domain.mean(sums, count)?;
            corrections += 1;
            if corrections >= if over.mean <= GROWTH * self.options.excess.mean { least } else { most } {
                break;
            }
        }
        std::mem::swap(&mut self.advected, &mut self.slowed);
        Ok(corrections)
    }
}
