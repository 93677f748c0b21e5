//! Particles: where they are, which is which, and named values of each.

use std::collections::BTreeSet;

use relievo_core::{Error, Result};

/// The name of the channel of velocities, in m/s.
pub const VELOCITY: &str = "velocity";
/// Particles at most: formats count them in signed numbers of 32 bits.
pub(crate) const MAX: u64 = i32::MAX as u64;
/// Channels at most.
pub(crate) const MAX_CHANNELS: usize = 256;
/// Bytes of a name at most.
const LONGEST: usize = 255;

/// Values of all particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name: `velocity`, `color`, `normal`, or the user's own.
    pub name: String,
    /// Numbers per particle, 1 to 4.
    pub width: u32,
    /// The numbers, particle after particle.
    pub values: Vec<f32>,
}

/// Particles at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Places in metres.
    pub points: Vec<[f32; 3]>,
    /// Seconds since the beginning, where it is known.
    pub time: Option<f64>,
    /// Distance between particles at rest in metres, where it is known.
    pub spacing: Option<f32>,
    /// The number of each, by which it is found again at other times.
    pub numbers: Option<Vec<u32>>,
    /// Their values.
    pub channels: Vec<Channel>,
}

impl Particles {
    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Velocities in m/s, if there are some.
    pub fn velocities(&self) -> Option<&[[f32; 3]]> {
        self.channel(VELOCITY).filter(|channel| channel.width == 3).map(|channel| channel.values.as_chunks().0)
    }

    /// Checks that every number is finite, that there are as many as particles, and that names and widths can be.
    ///
    /// # Errors
    /// Fails with `Invalid` if one of these does not hold, two channels share a name or the spacing is not above 0, and
    /// with `Unsupported` for more than 2³¹ - 1 particles or too many channels.
    pub fn check(&self) -> Result<()> {
        let count = self.points.len();
        if count as u64 > MAX {
            return Err(Error::unsupported(format!("there are {count} particles")).advise("use at most 2³¹ - 1"));
        }
        if let Some(particle) = self.points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(not_finite("its place", particle));
        }
        if self.time.is_some_and(|time| !time.is_finite()) {
            return Err(Error::invalid("the time is not finite"));
        }
        if let Some(spacing) = self.spacing.filter(|spacing| !(*spacing > 0.0 && spacing.is_finite())) {
            return Err(Error::invalid(format!("particles cannot be {spacing} m apart")));
        }
        if let Some(numbers) = self.numbers.as_ref().filter(|numbers| numbers.len() != count) {
            return Err(Error::invalid(format!("{} numbers are given for {count} particles", numbers.len())));
        }
        if self.channels.len() > MAX_CHANNELS {
            return Err(Error::unsupported(format!("there are {} channels", self.channels.len()))
                .advise(format!("use at most {MAX_CHANNELS}")));
        }
        let mut names = BTreeSet::new();
        for channel in &self.channels {
            channel.check(count).map_err(|error| error.at(format!("channel {:?}", channel.name)))?;
            if !names.insert(channel.name.as_str()) {
                return Err(Error::invalid(format!("there are two channels {:?}", channel.name)));
            }
        }
        Ok(())
    }

    /// Puts particles in the order of their numbers, if they have some.
    pub fn sort(&mut self) {
        let Some(numbers) = &self.numbers else { return };
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_by_key(|particle| numbers[*particle]);
        *self = self.subset(&order);
    }

    /// The particles at these places of the lists, in this order. Panics where one is not there.
    pub fn subset(&self, places: &[usize]) -> Self {
        let channel = |Channel { name, width, values }: &Channel| {
            let size = *width as usize;
            let values = places.iter().flat_map(|at| &values[at * size..][..size]).copied().collect();
            Channel { name: name.clone(), width: *width, values }
        };
        Self {
            points: places.iter().map(|at| self.points[*at]).collect(),
            numbers: self.numbers.as_ref().map(|numbers| places.iter().map(|at| numbers[*at]).collect()),
            channels: self.channels.iter().map(channel).collect(),
            ..*self
        }
    }
}

impl Channel {
    fn check(&self, count: usize) -> Result<()> {
        if self.name.is_empty() || self.name.len() > LONGEST {
            return Err(Error::invalid("the name is empty or too long").advise("use 1 to 255 bytes"));
        }
        if !(1..=4).contains(&self.width) {
            return Err(Error::invalid(format!("a value has {} numbers", self.width)).advise("use 1 to 4"));
        }
        if self.values.len() as u64 != u64::from(self.width) * count as u64 {
            return Err(Error::invalid(format!("there is not a value for each of {count} particles")));
        }
        match self.values.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(not_finite("its value", at / self.width as usize)),
            None => Ok(()),
        }
    }
}

fn not_finite(what: &str, particle: usize) -> Error {
    let error = Error::invalid(format!("{what} is not finite")).at(format!("particle {particle}"));
    error.advise("remove the particle or repair its numbers")
}
