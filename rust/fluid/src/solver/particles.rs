//! The particles of a fluid, and what each carries through its life.

use glam::{Vec3, Vec4};
use relievo_core::{Context, Error, Result};

use crate::solver::neighbours::NOWHERE;
use crate::state::State;
use crate::surface::isosurface::Channel;

/// Particles at most: numbers of what is beside them must fit too.
pub const MAX: usize = 1 << 30;
/// Channels at most, as files have no more beside velocities.
pub const MAX_CHANNELS: usize = 255;

/// Numbers that particles carry with them, such as a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleChannel {
    /// Its name: `color` is three numbers of scene-linear Rec.709, others are the user's own.
    pub name: String,
    /// Numbers per particle, 1 to 4.
    pub width: usize,
    /// The numbers, particle after particle.
    pub values: Vec<f32>,
}

impl ParticleChannel {
    /// What is in it.
    pub fn view(&self) -> Channel<'_> {
        Channel { name: &self.name, width: self.width, values: &self.values }
    }
}

/// Particles that are added to a fluid.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Places in metres.
    pub places: &'a [Vec3],
    /// Velocities in m/s: one for each, or one for all.
    pub velocities: &'a [Vec3],
    /// Seconds until they are removed; infinite for particles that stay.
    pub lifetime: f32,
    /// What they have in channels: the numbers of one for all, or those of each. Where a particle has nothing, it has zeros.
    pub channels: &'a [Channel<'a>],
}

/// Whether no channel may be called so: velocities are beside channels.
pub fn is_reserved(name: &str) -> bool {
    name.is_empty() || name == "velocity"
}

pub fn too_many() -> Error {
    Error::memory("a fluid has at most 2³⁰ particles").advise("take a larger spacing")
}

/// The particles of a fluid.
pub struct Particles {
    /// Places with what a step begins with, and velocities, each with a row after the last particle.
    pub places: Vec<Vec4>,
    pub velocities: Vec<Vec4>,
    /// What hosts add, and whether they do.
    pub pushes: Vec<Vec4>,
    pub is_pushed: bool,
    /// What the last step reports, in Pa.
    pub pressures: Vec<f32>,
    pub numbers: Vec<u32>,
    pub channels: Vec<ParticleChannel>,
    pub births: Vec<f64>,
    pub lifetimes: Vec<f32>,
    /// The number of the next one, and whether one does not stay for ever.
    next: u32,
    is_mortal: bool,
}

impl Default for Particles {
    fn default() -> Self {
        Self {
            places: vec![NOWHERE],
            velocities: vec![Vec4::ZERO],
            pushes: Vec::new(),
            is_pushed: false,
            pressures: Vec::new(),
            numbers: Vec::new(),
            channels: Vec::new(),
            births: Vec::new(),
            lifetimes: Vec::new(),
            next: 0,
            is_mortal: false,
        }
    }
}

impl Particles {
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// When each was added, in seconds since the beginning.
    pub fn births(&self) -> &[f64] {
        &self.births
    }

    /// Adds particles at a time. Nothing is added where it fails.
    pub fn add(&mut self, batch: &Batch, now: f64) -> Result<()> {
        let (added, given) = (batch.places.len(), batch.velocities.len());
        if given != 1 && given != added {
            return Err(Error::invalid(format!("{given} velocities are given for {added} particles")));
        }
        if !batch.places.iter().chain(batch.velocities).all(|vector| vector.is_finite()) {
            return Err(Error::invalid("a place or velocity of a particle is not finite"));
        }
        if batch.lifetime.is_nan() || batch.lifetime <= 0.0 {
            return Err(Error::invalid(format!("particles cannot live for {} s", batch.lifetime)));
        }
        let count = self.len() + added;
        let (Some(next), true) = (self.next.checked_add(added as u32), count <= MAX) else {
            return Err(too_many());
        };
        for Channel { name, width, values } in batch.channels {
            if values.len() != *width && values.len() != added * width {
                let given = values.len();
                return Err(Error::invalid(format!("{given} numbers are given for {added} particles")).at(*name));
            }
            if !values.iter().all(|value| value.is_finite()) {
                return Err(Error::invalid("a number of a channel is not finite").at(*name));
            }
            self.find(name, *width)?;
        }
        for Channel { name, width, .. } in batch.channels {
            self.channel(name, *width)?;
        }
        self.places.truncate(self.numbers.len());
        self.velocities.truncate(self.numbers.len());
        self.numbers.extend(self.next..next);
        self.next = next;
        self.places.extend(batch.places.iter().map(|place| place.extend(0.0)).chain([NOWHERE]));
        let velocities = batch.velocities.iter().cycle().take(added);
        self.velocities.extend(velocities.map(|velocity| velocity.extend(0.0)).chain([Vec4::ZERO]));
        self.pushes.resize(count, Vec4::ZERO);
        self.pressures.resize(count, 0.0);
        self.births.resize(count, now);
        self.lifetimes.resize(count, batch.lifetime);
        self.is_mortal |= batch.lifetime.is_finite();
        for channel in &mut self.channels {
            match batch.channels.iter().find(|given| given.name == channel.name) {
                Some(given) => channel.values.extend(given.values.iter().cycle().take(added * channel.width)),
                None => channel.values.resize(count * channel.width, 0.0),
            }
        }
        Ok(())
    }

    /// Counts particles that are added to another domain of the fluid, and makes their channels. Fails as [`Self::add`] does.
    pub fn add_elsewhere(&mut self, batch: &Batch, now: f64) -> Result<()> {
        let next = self.next.checked_add(batch.places.len() as u32).ok_or_else(too_many)?;
        self.add(&Batch { places: &[], velocities: &[], ..*batch }, now)?;
        self.next = next;
        Ok(())
    }

    /// The channel of a name and so many numbers a particle, of zeros if it is new. Fails if it has another width.
    pub fn channel(&mut self, name: &str, width: usize) -> Result<&mut ParticleChannel> {
        let at = self.find(name, width)?.unwrap_or(self.channels.len());
        if at == self.channels.len() {
            let values = vec![0.0; width * self.len()];
            self.channels.push(ParticleChannel { name: name.into(), width, values });
        }
        Ok(&mut self.channels[at])
    }

    /// Which one it is, if there is one. Fails if there is none and cannot be, or it has another width.
    fn find(&self, name: &str, width: usize) -> Result<Option<usize>> {
        match self.channels.iter().position(|channel| channel.name == name) {
            Some(at) if self.channels[at].width == width => Ok(Some(at)),
            None if (1..=4).contains(&width) && !is_reserved(name) && self.channels.len() < MAX_CHANNELS => Ok(None),
            _ => Err(Error::invalid(format!("{width} numbers a particle cannot be in this channel")).at(name).advise(
                format!(
                    "use another name than `velocity`, 1 to 4 numbers, as many as the channel has if it is there, and at most \
                     {MAX_CHANNELS} channels"
                ),
            )),
        }
    }

    /// Removes the particles of which `is_gone` says so by their place in the lists, and returns how many.
    pub fn remove(&mut self, is_gone: impl Fn(usize) -> bool) -> usize {
        let count = self.len();
        let gone: Vec<bool> = (0..count).map(is_gone).collect();
        let removed = gone.iter().filter(|gone| **gone).count();
        if removed > 0 {
            retain(&mut self.places, &gone, 1);
            retain(&mut self.velocities, &gone, 1);
            retain(&mut self.pushes, &gone, 1);
            retain(&mut self.pressures, &gone, 1);
            retain(&mut self.numbers, &gone, 1);
            retain(&mut self.births, &gone, 1);
            retain(&mut self.lifetimes, &gone, 1);
            self.channels.iter_mut().for_each(|channel| retain(&mut channel.values, &gone, channel.width));
        }
        removed
    }

    /// Whether one does not stay for ever.
    pub fn is_mortal(&self) -> bool {
        self.is_mortal
    }

    /// Removes those whose life has ended at a time.
    pub fn expire(&mut self, now: f64) {
        if self.is_mortal {
            let (births, lifetimes) = (std::mem::take(&mut self.births), std::mem::take(&mut self.lifetimes));
            let is_over: Vec<bool> =
                births.iter().zip(&lifetimes).map(|(birth, life)| now - birth >= f64::from(*life)).collect();
            (self.births, self.lifetimes) = (births, lifetimes);
            self.remove(|particle| is_over[particle]);
        }
    }

    /// Puts all into an order, the number that each row had.
    pub fn sort(&mut self, context: &Context, order: &[u32]) {
        self.places = moved(context, order, &self.places, 1);
        self.velocities = moved(context, order, &self.velocities, 1);
        self.places.push(NOWHERE);
        self.velocities.push(Vec4::ZERO);
        if self.is_pushed {
            self.pushes = moved(context, order, &self.pushes, 1);
        }
        self.pressures = moved(context, order, &self.pressures, 1);
        self.numbers = moved(context, order, &self.numbers, 1);
        self.births = moved(context, order, &self.births, 1);
        self.lifetimes = moved(context, order, &self.lifetimes, 1);
        for channel in &mut self.channels {
            channel.values = moved(context, order, &channel.values, channel.width);
        }
    }

    /// Returns no particles, with the channels of these and the number that the next one gets.
    pub fn emptied(&self) -> Self {
        let channels = self.channels.iter();
        let channels = channels.map(|channel| ParticleChannel { values: Vec::new(), ..channel.clone() }).collect();
        let Self { next, is_mortal, is_pushed, .. } = *self;
        Self { channels, next, is_mortal, is_pushed, ..Self::default() }
    }

    /// All of them, for a state of a fluid.
    pub fn save(&self) -> State {
        let count = self.len();
        State {
            next: self.next,
            places: self.places[..count].to_vec(),
            velocities: self.velocities[..count].to_vec(),
            pushes: self.pushes.clone(),
            pressures: self.pressures.clone(),
            numbers: self.numbers.clone(),
            births: self.births.clone(),
            lifetimes: self.lifetimes.clone(),
            channels: self.channels.clone(),
            ..State::default()
        }
    }

    /// Those of a state that was checked.
    pub fn restore(state: State) -> Self {
        let State { mut places, mut velocities, lifetimes, .. } = state;
        places.push(NOWHERE);
        velocities.push(Vec4::ZERO);
        Self {
            places,
            velocities,
            is_pushed: state.pushes.iter().any(|push| *push != Vec4::ZERO),
            pushes: state.pushes,
            pressures: state.pressures,
            numbers: state.numbers,
            channels: state.channels,
            births: state.births,
            is_mortal: lifetimes.iter().any(|seconds| seconds.is_finite()),
            lifetimes,
            next: state.next,
        }
    }
}

/// Keeps the rows that are not gone, and what is after the last one.
fn retain<T: Copy>(rows: &mut Vec<T>, gone: &[bool], width: usize) {
    let mut kept = 0;
    for at in 0..rows.len() {
        if !gone.get(at / width).is_some_and(|gone| *gone) {
            rows[kept] = rows[at];
            kept += 1;
        }
    }
    rows.truncate(kept);
}

/// Rows in an order, with room for one more.
fn moved<T: Copy + Send + Sync>(context: &Context, order: &[u32], from: &[T], width: usize) -> Vec<T> {
    let mut to = Vec::with_capacity(order.len() * width + 1);
    if width == 1 {
        context.map_into(order.len(), &mut to, |at| from[order[at] as usize]);
    } else {
        context.map_into(order.len() * width, &mut to, |at| from[order[at / width] as usize * width + at % width]);
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch<'a>(places: &'a [Vec3], channels: &'a [Channel<'a>]) -> Batch<'a> {
        Batch { places, velocities: &[Vec3::X], lifetime: 2.0, channels }
    }

    fn channel<'a>(name: &'a str, width: usize, values: &'a [f32]) -> [Channel<'a>; 1] {
        [Channel { name, width, values }]
    }

    #[test]
    fn what_particles_carry_goes_with_them() {
        let mut particles = Particles::default();
        let places: Vec<Vec3> = (0..6).map(|at| Vec3::splat(at as f32)).collect();
        particles.add(&batch(&places, &channel("color", 3, &[0.1, 0.2, 0.3])), 0.0).unwrap();
        particles
            .add(&Batch { lifetime: f32::INFINITY, ..batch(&places[..2], &channel("age", 1, &[7.0, 8.0])) }, 1.0)
            .unwrap();
        particles.sort(&Context::serial(), &[7, 1, 2, 3, 4, 5, 6, 0]);
        assert_eq!(particles.remove(|at| at == 1), 1);
        assert_eq!(particles.numbers, [7, 2, 3, 4, 5, 6, 0]);
        assert!(particles.places[0] == Vec4::new(1.0, 1.0, 1.0, 0.0) && particles.places[7] == NOWHERE);
        let state = particles.save();
        assert_eq!(state.channels[0].values[..6], [0.0, 0.0, 0.0, 0.1, 0.2, 0.3]);
        assert_eq!(state.channels[1].values, [8.0, 0.0, 0.0, 0.0, 0.0, 7.0, 0.0]);
        particles = Particles::restore(state.clone());
        assert_eq!(particles.save(), state);
        particles.expire(2.0);
        assert_eq!(particles.numbers, [7, 6]);
        particles.add(&batch(&places[..1], &[]), 2.0).unwrap();
        assert_eq!(particles.numbers, [7, 6, 8]);
    }

    #[test]
    fn what_cannot_be_particles_is_refused() {
        let mut particles = Particles::default();
        particles.add(&batch(&[Vec3::ZERO; 3], &channel("age", 1, &[1.0])), 0.0).unwrap();
        let mut refused = |batch: Batch| assert!(particles.add(&batch, 0.0).is_err() && particles.len() == 3);
        refused(batch(&[Vec3::NAN], &[]));
        refused(batch(&[Vec3::ZERO], &channel("age", 2, &[1.0, 2.0])));
        refused(batch(&[Vec3::ZERO; 3], &channel("age", 1, &[1.0, 2.0])));
        refused(batch(&[Vec3::ZERO], &channel("", 1, &[1.0])));
        refused(batch(&[Vec3::ZERO], &channel("velocity", 3, &[1.0; 3])));
        refused(batch(&[Vec3::ZERO], &channel("color", 5, &[0.0; 5])));
        refused(batch(&[Vec3::ZERO], &channel("color", 3, &[f32::NAN, 0.0, 0.0])));
        refused(Batch { velocities: &[Vec3::X; 2], ..batch(&[Vec3::ZERO; 3], &[]) });
        refused(Batch { lifetime: f32::NAN, ..batch(&[Vec3::ZERO], &[]) });
        let state = State { share: 1.0, ..particles.save() };
        assert!(state.check().is_ok());
        let refused = |change: &dyn Fn(&mut State)| {
            let mut state = state.clone();
            change(&mut state);
            assert!(state.check().is_err());
        };
        refused(&|state| state.places[1].x = f32::NAN);
        refused(&|state| state.velocities.truncate(2));
        refused(&|state| state.numbers[1] = 0);
        refused(&|state| state.numbers[2] = 3);
        refused(&|state| state.channels[0].width = 5);
        refused(&|state| state.channels[0].name = "velocity".into());
        refused(&|state| state.channels[0].values.truncate(1));
        refused(&|state| state.lifetimes[0] = 0.0);
        refused(&|state| state.share = 0.0);
        refused(&|state| state.seconds = f64::NAN);
    }
}
