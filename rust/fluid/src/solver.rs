//! A fluid of particles, and its steps.

pub(crate) mod cells;
pub(crate) mod constants;
mod dfsph;
pub(crate) mod domain;
pub(crate) mod force;
pub(crate) mod kernel;
mod migration;
pub(crate) mod neighbours;
pub(crate) mod noise;
pub(crate) mod options;
pub(crate) mod pace;
pub(crate) mod pairs;
pub(crate) mod particles;
pub(crate) mod pcisph;
mod prepare;
pub(crate) mod radix;
mod tension;
pub(crate) mod transport;

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Error, Result};

use crate::FluidOptions;
use crate::boundary::collider::Collider;
use crate::boundary::exchange::{Given, Impulse};
use crate::boundary::sweep::Sweep;
use crate::boundary::wall::Wall;
use crate::solver::cells::{Cells, bounds};
use crate::solver::constants::Constants;
use crate::solver::domain::{Domain, Traffic};
use crate::solver::force::Force;
use crate::solver::neighbours::Neighbours;
use crate::solver::pace::{Pace, within};
use crate::solver::pairs::Rows;
use crate::solver::particles::{Batch, ParticleChannel, Particles};
use crate::solver::pcisph::Excess;
use crate::solver::prepare::{Begin, Neighborhood, prepare};
use crate::solver::tension::Tension;
use crate::solver::transport::Transport;
use crate::state::State;

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepStatistics {
    /// How long it was, in seconds.
    pub seconds: f32,
    /// Corrections of pressures by densities.
    pub corrections: u32,
    /// Those by what velocities compress; 0 without [`crate::PressureSolver::Dfsph`].
    pub divergence_corrections: u32,
    /// How much denser than at rest the fluid is.
    pub excess: Excess,
    /// What the fluid was given.
    pub given: Given,
}

/// A fluid of particles. They are along a curve through space, in another order after every step; numbers tell which is
/// which.
pub struct Fluid {
    options: FluidOptions,
    constants: Constants,
    particles: Particles,
    /// The particles of walls, then of colliders.
    wall: Wall,
    wall_count: usize,
    colliders: Vec<Collider>,
    sweep: Sweep,
    /// What walls and each collider got in the last step.
    impulses: Vec<Impulse>,
    forces: Vec<Force>,
    /// The sum of their accelerations.
    forced: DVec3,
    /// Since the beginning.
    seconds: f64,
    /// What a step works with.
    predicted: Vec<Vec4>,
    advected: Vec<Vec4>,
    slowed: Vec<Vec4>,
    accelerations: Vec<Vec4>,
    normals: Vec<Vec4>,
    found: Vec<Neighborhood>,
    cells: Cells,
    near: Neighbours,
    near_walls: Neighbours,
    pace: Pace,
    domain: Domain,
}

impl Fluid {
    /// A fluid without particles and walls.
    ///
    /// # Errors
    /// Fails if an option is out of range.
    pub fn new(options: FluidOptions) -> Result<Self> {
        options.check()?;
        Ok(Self {
            constants: Constants::new(&options),
            particles: Particles::default(),
            wall: Wall::default(),
            wall_count: 0,
            colliders: Vec::new(),
            sweep: Sweep::default(),
            impulses: vec![Impulse::default()],
            forces: Vec::new(),
            forced: DVec3::ZERO,
            seconds: 0.0,
            predicted: Vec::new(),
            advected: Vec::new(),
            slowed: Vec::new(),
            accelerations: Vec::new(),
            normals: Vec::new(),
            found: Vec::new(),
            cells: Cells::default(),
            near: Neighbours::default(),
            near_walls: Neighbours::default(),
            pace: Pace::new(&options),
            domain: Domain::default(),
            options,
        })
    }

    /// What the fluid is, and how it is simulated.
    pub fn options(&self) -> &FluidOptions {
        &self.options
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the mass of a particle, in kg: 3.3 % below the density times the cube of the spacing, 1.0 % with the kernels of
    /// Müller et al., so that a lattice of particles one spacing apart has the density at rest by its kernels.
    pub fn mass(&self) -> f32 {
        self.constants.mass
    }

    /// Seconds since the beginning.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The number of each particle, counted in the order in which they were added. It stays with the particle, and no other
    /// gets it after that is removed.
    pub fn numbers(&self) -> &[u32] {
        &self.particles.numbers
    }

    /// The pressure of each particle in Pa: what it adds to the virial of the forces (Clausius 1870) over its volume at rest,
    /// with the pressures that moved it in the last step. Over a part of the fluid, their sum times that volume over the part's
    /// is the pressure there. In disorder particles take 3 % more room than at rest, so that single ones tell as much more.
    pub fn pressures(&self) -> &[f32] {
        &self.particles.pressures
    }

    /// Places in metres; the fourth numbers are what a step begins with.
    pub fn places(&self) -> &[Vec4] {
        &self.particles.places[..self.len()]
    }

    /// Velocities in m/s; the fourth numbers are what corrections of velocities begin with.
    pub fn velocities(&self) -> &[Vec4] {
        &self.particles.velocities[..self.len()]
    }

    /// When each particle was added, in seconds since the beginning.
    pub fn births(&self) -> &[f64] {
        self.particles.births()
    }

    /// What particles carry, in the order of [`Self::numbers`].
    pub fn channels(&self) -> &[ParticleChannel] {
        &self.particles.channels
    }

    /// Gives each particle so many numbers of a channel, in the order of [`Self::numbers`], and makes the channel if
    /// there is none of the name.
    ///
    /// # Errors
    /// Fails if there are not `width` finite numbers a particle, 1 to 4, the channel has another width, the name is
    /// reserved, or there are as many channels as a fluid can have.
    pub fn set_channel(&mut self, name: &str, width: usize, values: &[f32]) -> Result<()> {
        if values.len() != width * self.len() || !values.iter().all(|value| value.is_finite()) {
            let (given, count) = (values.len(), self.len());
            return Err(Error::invalid(format!(
                "{given} numbers are given for {count} particles, or one is not finite"
            ))
            .at(name));
        }
        self.particles.channel(name, width)?.values.copy_from_slice(values);
        Ok(())
    }

    /// Adds particles at places in metres, with a velocity in m/s.
    ///
    /// # Errors
    /// Fails if a number is not finite, there would be more than 2³⁰ particles, or the fluid is split into domains.
    pub fn add(&mut self, places: &[Vec3], velocity: Vec3) -> Result<()> {
        self.add_batch(&Batch { places, velocities: &[velocity], lifetime: f32::INFINITY, channels: &[] })
    }

    /// Adds particles with what they carry.
    ///
    /// # Errors
    /// Fails if a number is out of range, lists do not fit each other, a channel has another width, there would be more
    /// than 2³⁰ particles, or the fluid is split into domains; nothing is added then.
    pub fn add_batch(&mut self, batch: &Batch) -> Result<()> {
        self.domain.expect_whole("particles cannot be added")?;
        self.particles.add(batch, self.seconds)
    }

    /// Adds particles that all ranks are given alike, without channels of different numbers. Fails as [`Self::add_batch`] does.
    pub(crate) fn emit(&mut self, batch: &Batch) -> Result<()> {
        // In an undivided fluid they are the last of all.
        match self.domain.is_last() {
            true => self.particles.add(batch, self.seconds),
            false => self.particles.add_elsewhere(batch, self.seconds),
        }
    }

    /// Returns how many particles all ranks have.
    pub(crate) fn count(&mut self) -> Result<usize> {
        match self.domain.is_whole() {
            true => Ok(self.len()),
            false => self.domain.count(self.len()),
        }
    }

    /// Replaces flags by whether they are set on all ranks.
    pub(crate) fn agree(&mut self, flags: &mut [bool]) -> Result<()> {
        self.domain.all(flags)
    }

    /// Finds the fastest particle of all ranks anew, after some were added or removed.
    pub(crate) fn find_fastest(&mut self) -> Result<()> {
        if !self.domain.is_whole() {
            let [speed] = self.domain.most([fastest(&self.particles)])?;
            self.domain.set_fastest(speed);
        }
        Ok(())
    }

    /// Removes the particles of which `is_gone` says so by their place in the lists, and returns how many there were.
    pub fn remove(&mut self, is_gone: impl Fn(usize) -> bool) -> usize {
        self.particles.remove(is_gone)
    }

    /// All that the fluid goes on from, but its options and walls.
    pub fn state(&self) -> State {
        State { seconds: self.seconds, pulled: self.pace.pulled, share: self.pace.share, ..self.particles.save() }
    }

    /// Goes on from a state, with other particles than before.
    ///
    /// # Errors
    /// Fails as [`State::check`]; nothing has changed then.
    pub fn set_state(&mut self, state: State) -> Result<()> {
        state.check()?;
        self.seconds = state.seconds;
        self.pace = Pace { pulled: state.pulled, share: state.share };
        self.particles = Particles::restore(state);
        self.take_share();
        Ok(())
    }

    /// Goes on with a part of the particles, while other ranks, which have the same fluid and call this too, have the rest.
    /// From now on all ranks call [`Self::step`], [`Self::advance`], [`Self::set_state`] and [`Self::gather`] alike; what is
    /// said of particles is said of those of this rank, and what is said of the fluid, of all.
    /// Sources add particles on all ranks alike; hosts can add none.
    ///
    /// # Errors
    /// Fails if the fluid is split already.
    pub fn distribute(&mut self, transport: Box<dyn Transport>) -> Result<()> {
        self.domain.expect_whole("a fluid cannot be split again")?;
        self.domain = Domain::new(transport, 0.0);
        self.take_share();
        Ok(())
    }

    /// Returns all that the fluid goes on from, as [`Self::state`], of all ranks: on rank 0, and on others `None`.
    ///
    /// # Errors
    /// Fails if another rank has ended, or sent a message that does not fit.
    pub fn gather(&mut self) -> Result<Option<State>> {
        if self.domain.is_whole() {
            return Ok(Some(self.state()));
        }
        let state =
            State { seconds: self.seconds, pulled: self.pace.pulled, share: self.pace.share, ..State::default() };
        let whole = self.domain.collect(&self.particles)?;
        Ok(whole.map(|particles| State {
            seconds: state.seconds,
            pulled: state.pulled,
            share: state.share,
            ..particles.save()
        }))
    }

    /// Returns what this rank sent to others.
    pub fn traffic(&self) -> Traffic {
        self.domain.traffic()
    }

    /// Drops the particles of the whole fluid that other ranks have.
    fn take_share(&mut self) {
        if !self.domain.is_whole() {
            self.domain.set_fastest(fastest(&self.particles));
            let own = self.domain.share(self.particles.len());
            self.particles.remove(|row| !own.contains(&row));
        }
    }

    /// Has each particle accelerated by so much, in m/s² and the order of [`Self::numbers`], beside all else, from now
    /// on.
    ///
    /// # Errors
    /// Fails if there are not as many accelerations as particles, or a number is not finite.
    pub fn accelerate(&mut self, accelerations: &[Vec3]) -> Result<()> {
        if accelerations.len() != self.len() {
            let (given, count) = (accelerations.len(), self.len());
            return Err(Error::invalid(format!("{given} accelerations are given for {count} particles")));
        }
        if accelerations.iter().any(|acceleration| !acceleration.is_finite()) {
            return Err(Error::invalid("an acceleration is not finite"));
        }
        self.particles.is_pushed = true;
        self.particles.pushes.iter_mut().zip(accelerations).for_each(|(push, given)| *push = given.extend(0.0));
        Ok(())
    }

    /// Has these forces act, instead of those before.
    ///
    /// # Errors
    /// Fails if a number of a force is out of range ([`Force::check`]).
    pub fn set_forces(&mut self, forces: &[Force]) -> Result<()> {
        for (number, force) in forces.iter().enumerate() {
            force.check().map_err(|error| error.at(format!("force {number}")))?;
        }
        self.forces = forces.to_vec();
        Ok(())
    }

    /// The forces that act.
    pub(crate) fn forces(&self) -> &[Force] {
        &self.forces
    }

    /// The density of each particle where it is now, in kg/m³, walls seen too. Particles may be in another order
    /// afterwards.
    ///
    /// # Errors
    /// Fails if a position is not finite, particles are too far from each other or from the origin, more than 4,096
    /// particles are within the support radius of one, or the fluid is split into domains.
    pub fn densities(&mut self, context: &Context) -> Result<impl ExactSizeIterator<Item = f32>> {
        self.domain.expect_whole("densities are not found")?;
        if !self.is_empty() {
            self.look_around(context)?;
        }
        Ok(self.found[..self.len()].iter().map(|found| found.density))
    }

    /// The sum of mass times velocity, in kg m/s.
    pub fn momentum(&self) -> Vec3 {
        let sum: glam::DVec3 = self.velocities().iter().map(|velocity| velocity.xyz().as_dvec3()).sum();
        (sum * f64::from(self.constants.mass)).as_vec3()
    }

    /// The energy of all motion, in J.
    pub fn kinetic_energy(&self) -> f32 {
        let sum: f64 = self.velocities().iter().map(|velocity| f64::from(velocity.with_w(0.0).length_squared())).sum();
        (0.5 * sum * f64::from(self.constants.mass)) as f32
    }

    /// Simulates so many seconds in as many steps as it takes, and calls `watch` after each.
    ///
    /// # Errors
    /// Fails as [`Self::step`], and with the error that `watch` returns.
    pub fn advance(
        &mut self,
        context: &Context,
        seconds: f32,
        mut watch: impl FnMut(&mut Self, &StepStatistics) -> Result<()>,
    ) -> Result<()> {
        let mut left = seconds;
        while left > 1e-6 * seconds {
            let done = self.step(context, within(self.time_step(), left))?;
            left -= done.seconds;
            watch(self, &done)?;
        }
        Ok(())
    }

    /// How long the next step should be, in seconds.
    pub fn time_step(&self) -> f32 {
        self.pace.step(&self.options, &self.constants, self.speed().max(self.wall.speed))
    }

    /// The speed of the fastest particle, in m/s.
    pub(crate) fn speed(&self) -> f32 {
        self.domain.fastest().unwrap_or_else(|| fastest(&self.particles))
    }

    /// Makes a step of so many seconds, or a shorter one where pressures do not converge.
    ///
    /// # Errors
    /// Fails if pressures do not converge at all, a position is not finite, particles are too far from each other or
    /// from the origin, or more than 4,096 particles are within the support radius of one; nothing has moved then.
    /// Fails too if another rank has ended.
    pub fn step(&mut self, context: &Context, seconds: f32) -> Result<StepStatistics> {
        let seconds = seconds.max(0.0).min(self.until_arrival());
        if seconds <= 0.0 || self.domain.count(self.len())? == 0 {
            self.impulses = vec![Impulse::default(); self.colliders.len() + 1];
            self.carry(seconds);
            self.seconds += f64::from(seconds);
            return Ok(StepStatistics { seconds, ..StepStatistics::default() });
        }
        self.look_around(context)?;
        let speed = self.colliders.iter().map(Collider::speed).fold(0.0, f32::max);
        let reach = self.options.spacing + seconds * speed;
        let places = &self.particles.places[..self.particles.len()];
        self.sweep.find(context, &self.colliders, places, reach, self.domain.ghosts());
        let (mut done, mut is_enough) = self.press(context, seconds, 0.0)?;
        let (mut corrections, mut divergence_corrections) = (done.corrections, done.divergence_corrections);
        while !is_enough {
            let Some((shorter, kept)) = self.pace.again(&self.options, done.seconds) else { break };
            // Pressures that did not converge are no better than none.
            self.particles.places.iter_mut().for_each(|place| place.w = 0.0);
            (done, is_enough) = self.press(context, shorter, kept)?;
            corrections += done.corrections;
            divergence_corrections += done.divergence_corrections;
        }
        let is_finite = self.predicted.iter().all(|place| place.is_finite());
        let is_finite = self.domain.most([f32::from(u8::from(!is_finite))])? == [0.0];
        if !is_finite || !(is_enough || self.options.time_step.is_fixed()) {
            self.particles.places.iter_mut().for_each(|place| place.w = 0.0);
            self.domain.drop_copies(&mut self.particles);
            return Err(Error::invalid("pressures do not converge")
                .at(format!("a step of {} s", done.seconds))
                .advise(
                    "take shorter steps, and see whether particles begin in each other, in walls or in colliders",
                ));
        }
        done.given = self.exchange(context, done.seconds)?;
        let pulled = self.arrive(done.seconds)?;
        self.pace.settle(&self.options, corrections, pulled);
        Ok(StepStatistics { corrections, divergence_corrections, ..done })
    }

    /// What a device goes on from beside the state.
    pub(crate) fn setting(&self) -> (&Constants, &Wall, Pace) {
        (&self.constants, &self.wall, self.pace)
    }

    /// Finds neighbours, densities and the accelerations that need no pressure.
    fn look_around(&mut self, context: &Context) -> Result<()> {
        let support = self.constants.kernels.support;
        let bounds = self.domain.bounds(bounds(context, &self.particles.places[..self.particles.len()])?)?;
        self.cells.cover(support, bounds)?;
        self.domain.divide(&self.cells, &mut self.particles)?;
        let count = self.len();
        self.cells.sort(context, &self.particles.places[..count]);
        let order: Vec<u32> = self.cells.order().collect();
        self.particles.sort(context, &order);
        self.domain.list(&self.cells, &self.particles);
        self.wall.sort(context, support)?;
        let all = &self.particles.places;
        let places = &all[..count];
        let copies = self.domain.ghosts();
        self.near.find(context, places, (all, &self.cells), support, true, copies)?;
        self.near_walls.find(context, places, (&self.wall.places, &self.wall.cells), support, false, copies)?;
        self.found.resize(count, Neighborhood::default());
        self.accelerations.resize(count, Vec4::ZERO);
        let begin = Begin {
            constants: self.constants,
            places: Rows { fluid: all, walls: &self.wall.places },
            velocities: Rows { fluid: &self.particles.velocities, walls: &self.wall.velocities },
        };
        prepare(context, &begin, [&mut self.near, &mut self.near_walls], &mut self.found, &mut self.accelerations);
        let now = [places, &self.particles.velocities[..count]];
        if self.options.tension > 0.0 {
            let tension = Tension { constants: self.constants, places: all, near: &self.near, found: &self.found };
            tension::pull(context, &tension, &mut self.domain, &mut self.normals, &mut self.accelerations)?;
        }
        let copies = self.domain.ghosts();
        self.forced = force::apply(context, &self.forces, now, self.seconds, copies, &mut self.accelerations);
        Ok(())
    }

    /// Takes the particles to where they were predicted to be, with the pressures that they have now, but none farther than
    /// they may go. Returns the greatest acceleration. Fails if another domain has ended.
    fn arrive(&mut self, seconds: f32) -> Result<f32> {
        let mut pulled = 0.0f32;
        let speed = self.speed().max(self.wall.speed);
        let farthest = self.pace.farthest(&self.options, &self.constants, speed, seconds);
        let Particles { places, velocities, numbers, .. } = &mut self.particles;
        let predicted = self.predicted.iter().take(numbers.len());
        let moves = predicted.zip(&self.advected);
        for ((place, velocity), (predicted, advected)) in places.iter_mut().zip(velocities).zip(moves) {
            let moved = (predicted.xyz() - place.xyz()).clamp_length_max(farthest);
            let new = (moved / seconds).extend(0.0);
            pulled = pulled.max((new - velocity.with_w(0.0)).length_squared());
            *velocity = new.with_w(advected.w);
            *place = (place.xyz() + moved).extend(place.w);
        }
        for met in self.sweep.met().filter(|met| met.is_last) {
            let place = &mut self.particles.places[met.particle as usize];
            *place = met.place.extend(place.w);
            let velocity = &mut self.particles.velocities[met.particle as usize];
            *velocity = met.velocity.extend(velocity.w);
        }
        let told = self.particles.pressures.iter_mut().zip(&self.predicted).zip(&self.found);
        told.for_each(|((pressure, predicted), found)| *pressure = predicted.w * found.virial);
        self.carry(seconds);
        self.seconds += f64::from(seconds);
        self.domain.drop_copies(&mut self.particles);
        self.particles.expire(self.seconds);
        let [pulled, speed] = self.domain.most([pulled.sqrt() / seconds, fastest(&self.particles)])?;
        self.domain.set_fastest(speed);
        Ok(pulled)
    }
}

/// The speed of the fastest of some particles, in m/s.
fn fastest(particles: &Particles) -> f32 {
    let velocities = &particles.velocities[..particles.len()];
    velocities.iter().map(|velocity| velocity.with_w(0.0).length_squared()).fold(0.0, f32::max).sqrt()
}

mod bodies;
pub mod press;

#[cfg(test)]
mod drops;
#[cfg(test)]
mod tests;
