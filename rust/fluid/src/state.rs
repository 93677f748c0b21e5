//! What a fluid goes on from.

pub(crate) mod checkpoint;

use glam::Vec4;
use relievo_core::{Error, Result};

use crate::solver::particles::{MAX, MAX_CHANNELS, ParticleChannel, is_reserved, too_many};

/// All that a fluid goes on from: one with the same options and walls does the same from it, to the bit. The rows of all
/// lists are in the same order, which counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Seconds since the beginning.
    pub seconds: f64,
    /// The largest acceleration in the last step, in m/s².
    pub pulled: f32,
    /// The share of the Courant step that is taken, above 0 and at most 1.
    pub share: f32,
    /// The number that the next particle gets.
    pub next: u32,
    /// Places in metres; the fourth numbers are what a step begins with.
    pub places: Vec<Vec4>,
    /// Velocities in m/s; the fourth numbers are what corrections of velocities begin with.
    pub velocities: Vec<Vec4>,
    /// Accelerations by the host in m/s²; the fourth numbers are 0.
    pub pushes: Vec<Vec4>,
    /// Pressures in Pa.
    pub pressures: Vec<f32>,
    /// Numbers, different ones.
    pub numbers: Vec<u32>,
    /// When particles were added, in seconds since the beginning.
    pub births: Vec<f64>,
    /// How many seconds after that they are removed; infinite for particles that stay.
    pub lifetimes: Vec<f32>,
    /// What they carry beside that.
    pub channels: Vec<ParticleChannel>,
}

impl State {
    /// Checks that the lists fit each other and their numbers are in range.
    ///
    /// # Errors
    /// Fails if lists are not of the same length, a number is out of range, two particles have the same number, two
    /// channels have the same name, or there are more particles or channels than a fluid can have.
    pub fn check(&self) -> Result<()> {
        let count = self.numbers.len();
        let lists = [
            ("places", self.places.len()),
            ("velocities", self.velocities.len()),
            ("pushes", self.pushes.len()),
            ("pressures", self.pressures.len()),
            ("births", self.births.len()),
            ("lifetimes", self.lifetimes.len()),
        ];
        if let Some((name, length)) = lists.into_iter().find(|(_, length)| *length != count) {
            return Err(Error::invalid(format!("there are {length} rows for {count} particles")).at(name));
        }
        if count > MAX || self.channels.len() > MAX_CHANNELS {
            return Err(too_many());
        }
        let refuse = |name: &str, what: &str| Err(Error::invalid(what).at(name));
        let is_sound = |row: &Vec4| row.is_finite();
        if !self.places.iter().all(|place| is_sound(place) && place.w >= 0.0) {
            return refuse("places", "a number is not finite, or a pressure negative");
        }
        if !self.velocities.iter().all(|velocity| is_sound(velocity) && velocity.w >= 0.0) {
            return refuse("velocities", "a number is not finite, or a pressure negative");
        }
        if !self.pushes.iter().all(|push| is_sound(push) && push.w == 0.0) {
            return refuse("pushes", "a number is not finite, or a fourth one is not 0");
        }
        if !self.pressures.iter().all(|pressure| pressure.is_finite()) {
            return refuse("pressures", "a number is not finite");
        }
        if !self.births.iter().all(|birth| birth.is_finite()) || !self.lifetimes.iter().all(|seconds| *seconds > 0.0) {
            return refuse("lifetimes", "a particle is removed before it is added");
        }
        let mut numbers = self.numbers.clone();
        numbers.sort_unstable();
        if numbers.windows(2).any(|pair| pair[0] == pair[1]) || numbers.last().is_some_and(|last| *last >= self.next) {
            return refuse("numbers", "two particles have the same number, or one that is yet to be given");
        }
        let steps = (0.0..=1.0).contains(&self.share) && self.share > 0.0 && self.pulled >= 0.0;
        if !(steps && self.pulled.is_finite() && self.seconds.is_finite()) {
            return refuse("steps", "the time or what steps follow from is out of range");
        }
        for (at, channel) in self.channels.iter().enumerate() {
            let is_named =
                is_reserved(&channel.name) || self.channels[..at].iter().any(|other| other.name == channel.name);
            let is_whole = channel.values.len() == count * channel.width && (1..=4).contains(&channel.width);
            if is_named || !is_whole || !channel.values.iter().all(|value| value.is_finite()) {
                return refuse(
                    &channel.name,
                    "a channel has not 1 to 4 finite numbers a particle, or no name of its own",
                );
            }
        }
        Ok(())
    }
}
