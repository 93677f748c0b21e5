//! Diffuse particles: the spray, foam and bubbles of a fluid, made from its frames without running the solver again
//! (Ihmsen, Akinci, Akinci, Teschner 2012, *Unified Spray, Foam and Air Bubbles for Particle-Based Fluids*).
//!
//! A frame gives the particles of a fluid and their velocities. Where fluid that moves fast traps air or forms crests,
//! diffuse particles are born (Section 3.1 and 3.2); the fluid around each decides whether it is spray, foam or a bubble,
//! and how it moves (Section 3.3); foam dissolves (Section 3.4). Everything is decided by the settings, their seed and the
//! frames, for any number of threads.

mod birth;
mod difference;
mod entry;
mod frame;
mod motion;
mod options;
mod potential;
mod random;
mod surroundings;

use glam::Vec3;
use relievo_core::{Context, Error, Progress, Result};

pub use difference::{differences, positions_and_velocities};
pub use entry::DiffuseEntry;
pub use options::{DiffuseOptions, DiffuseSettings};
pub use potential::Potentials;
use surroundings::Surroundings;

/// Particles of a task.
const CHUNK_LEN: usize = 1024;
/// Speed along an axis, in m/s, up to which sums of its squares over all neighbours are finite.
const FASTEST: f32 = 1e15;

/// The kind of a diffuse particle, by the fluid around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum DiffuseKind {
    /// Flies through air.
    #[default]
    Spray,
    /// Floats with the surface, and dissolves.
    Foam,
    /// Rises within the fluid.
    Bubble,
}

/// Diffuse particles, one entry a particle in each list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiffuseParticles {
    /// Positions, in metres.
    pub positions: Vec<Vec3>,
    /// Velocities, in m/s.
    pub velocities: Vec<Vec3>,
    /// Kinds.
    pub kinds: Vec<DiffuseKind>,
    /// Seconds since birth.
    pub ages: Vec<f32>,
    /// Seconds of foam that are left.
    pub lifetimes: Vec<f32>,
    /// Numbers that no other particle of the run has, in order of birth.
    pub ids: Vec<u64>,
}

impl DiffuseParticles {
    /// Bytes of a particle in all lists.
    const BYTES: usize = 2 * size_of::<Vec3>() + size_of::<DiffuseKind>() + 2 * size_of::<f32>() + size_of::<u64>();

    /// Returns the number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Returns the share of its life that has passed for a particle, 0 to 1.
    pub fn life(&self, particle: usize) -> f32 {
        let (age, left) = (self.ages[particle], self.lifetimes[particle].max(0.0));
        if age > 0.0 { age / (age + left) } else { 0.0 }
    }

    /// Checks that the lists have one length and hold numbers that a run can continue from.
    fn check(&self) -> Result<()> {
        let lengths = [self.velocities.len(), self.kinds.len(), self.ages.len(), self.lifetimes.len(), self.ids.len()];
        if lengths.iter().any(|length| *length != self.len()) {
            return Err(Error::invalid("the lists of diffuse particles have different lengths").at("particles"));
        }
        let is_finite = |vectors: &[Vec3]| vectors.iter().all(|vector| vector.is_finite());
        if !is_finite(&self.positions) || !is_finite(&self.velocities) {
            return Err(Error::invalid("a diffuse particle is not finite").at("particles"));
        }
        Ok(())
    }

    /// Removes the particles for which `is_gone` returns true, and returns how many they were.
    fn remove(&mut self, is_gone: impl Fn(&Self, usize) -> bool) -> usize {
        let mut to = 0;
        for from in 0..self.len() {
            if is_gone(self, from) {
                continue;
            }
            self.positions[to] = self.positions[from];
            self.velocities[to] = self.velocities[from];
            self.kinds[to] = self.kinds[from];
            self.ages[to] = self.ages[from];
            self.lifetimes[to] = self.lifetimes[from];
            self.ids[to] = self.ids[from];
            to += 1;
        }
        let gone = self.len() - to;
        self.positions.truncate(to);
        self.velocities.truncate(to);
        self.kinds.truncate(to);
        self.ages.truncate(to);
        self.lifetimes.truncate(to);
        self.ids.truncate(to);
        gone
    }
}

/// The particles of a fluid at the end of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FluidFrame<'a> {
    /// Positions, in metres.
    pub positions: &'a [Vec3],
    /// Velocities, in m/s, one a particle.
    pub velocities: &'a [Vec3],
}

impl FluidFrame<'_> {
    /// Checks that each particle has a velocity, and that sums of squares of velocities are finite.
    fn check(&self) -> Result<()> {
        let [positions, velocities] = [self.positions.len(), self.velocities.len()];
        if positions != velocities {
            return Err(Error::invalid(format!("{positions} particles have {velocities} velocities")).at("velocities"));
        }
        if let Some(velocity) = self.velocities.iter().find(|at| !at.abs().cmple(Vec3::splat(FASTEST)).all()) {
            return Err(Error::invalid(format!("a particle's velocity is {velocity}"))
                .at("velocities")
                .advise(format!("give velocities that are finite and at most {FASTEST:e} along an axis")));
        }
        Ok(())
    }
}

/// What a frame did to diffuse particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DiffuseReport {
    /// Particles that were born.
    pub born: u64,
    /// Particles that dissolved, or left the bounds.
    pub gone: u64,
    /// Births that the greatest number of particles did not allow.
    pub refused: u64,
}

/// A run of diffuse particles over the frames of a fluid.
#[derive(Clone, Debug)]
pub struct Diffuse {
    options: DiffuseOptions,
    particles: DiffuseParticles,
    /// Frames so far, and particles born in them.
    frames: u64,
    births: u64,
}

impl Diffuse {
    /// Makes a run without particles.
    ///
    /// # Errors
    /// Fails if a setting is out of range.
    pub fn new(options: DiffuseOptions) -> Result<Self> {
        options.check()?;
        Ok(Self { options, particles: DiffuseParticles::default(), frames: 0, births: 0 })
    }

    /// Continues a run after `frames` frames in which `births` particles were born.
    ///
    /// # Errors
    /// Fails if a setting is out of range, the lists of particles have different lengths, or a position or velocity is
    /// not finite.
    pub fn restore(options: DiffuseOptions, particles: DiffuseParticles, frames: u64, births: u64) -> Result<Self> {
        options.check()?;
        particles.check()?;
        Ok(Self { options, particles, frames, births })
    }

    /// Returns the particles.
    pub fn particles(&self) -> &DiffuseParticles {
        &self.particles
    }

    /// Returns the options.
    pub fn options(&self) -> &DiffuseOptions {
        &self.options
    }

    /// Returns the frames so far and the particles that were born in them, as [`Self::restore`] takes them.
    pub fn progress(&self) -> (u64, u64) {
        (self.frames, self.births)
    }

    /// Returns the potentials of the particles of a fluid, in their order.
    ///
    /// # Errors
    /// Fails if the lists of the frame have different lengths, a number is not finite, a velocity is above 10¹⁵ m/s
    /// along an axis, or the particles are too far from each other.
    pub fn potentials(&self, context: &Context, frame: FluidFrame<'_>) -> Result<Vec<Potentials>> {
        frame.check()?;
        let surroundings = Surroundings::new(context, &self.options, frame.positions, frame.velocities)?;
        let sorted = potential::potentials(context, &self.options, &surroundings);
        let mut found = vec![Potentials::default(); sorted.len()];
        for (number, potentials) in surroundings.order().iter().zip(sorted) {
            found[*number as usize] = potentials;
        }
        Ok(found)
    }

    /// Moves the particles by `seconds` to the end of a frame, and adds the new particles of the frame.
    ///
    /// Within the frame the fluid moves by its velocities, in as many steps as the settings have.
    ///
    /// # Errors
    /// Fails, and changes nothing, if `seconds` is not above 0 or not finite, the lists of the frame have different
    /// lengths, a number is not finite, a velocity is above 10¹⁵ m/s along an axis, the particles are too far from each
    /// other, the particles that are born exceed the memory limit, or `progress` asks to stop.
    pub fn advance(
        &mut self,
        context: &Context,
        frame: FluidFrame<'_>,
        seconds: f32,
        progress: &mut dyn Progress,
    ) -> Result<DiffuseReport> {
        frame.check()?;
        if !(seconds > 0.0 && seconds.is_finite()) {
            return Err(Error::invalid(format!("{seconds} seconds are no length of a frame")).at("seconds"));
        }
        let (steps, mut particles) = (self.options.settings.steps, self.particles.clone());
        let (mut report, mut births) = (DiffuseReport::default(), self.births);
        let step = seconds / steps as f32;
        for number in 0..steps {
            progress.step(number as f32 / steps as f32, "diffuse particles")?;
            let left = step * (steps - 1 - number) as f32;
            let fluid = frame.positions.iter().zip(frame.velocities);
            let points: Vec<Vec3> = fluid.map(|(at, velocity)| *at - left * *velocity).collect();
            let surroundings = Surroundings::new(context, &self.options, &points, frame.velocities)?;
            motion::advance(context, &self.options, &surroundings, step, &mut particles);
            let bounds = self.options.bounds;
            report.gone += particles.remove(|all, index| {
                let is_outside = bounds.is_some_and(|[low, high]| {
                    let at = all.positions[index];
                    !(at.cmpge(low).all() && at.cmple(high).all())
                });
                is_outside || all.lifetimes[index] <= 0.0
            }) as u64;
            let seed =
                random::mix(u64::from(self.options.settings.seed), self.frames * u64::from(steps) + u64::from(number));
            let room = (self.options.settings.most as usize).saturating_sub(particles.len());
            let given = birth::give(context, &self.options, &surroundings, step, seed, room)?;
            report.refused += given.refused;
            report.born += given.born.len() as u64;
            birth::add(&mut particles, &given.born, births);
            births += given.born.len() as u64;
        }
        (self.particles, self.births) = (particles, births);
        self.frames += 1;
        Ok(report)
    }
}

#[cfg(test)]
mod tests;
