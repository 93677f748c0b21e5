//! What an interrupted simulation goes on from: a frame of a cache with the state of the solver.
//!
//! The state, version 2, little-endian: the version (u32), which description it is of (u32 bytes of text), the number of
//! the step from frame to frame (u64), steps and corrections so far (u64 each) and the most that was too dense (f32);
//! seconds (f64), the largest acceleration and the share of the Courant step (f32 each), the number of the next particle
//! and how many there are (u32 each); and of all particles what steps and corrections of velocities begin with (f32
//! each), accelerations by the host (three f32), pressures (f32), births (f64) and lifetimes (f32), list after list; and then
//! what its owner adds.

use glam::{Vec3, Vec4};
use relievo_core::{Error, Result};
use relievo_particleio::{Channel, Frame, Particles, VELOCITY};

use crate::solver::particles::ParticleChannel;
use crate::state::State;

const VERSION: u32 = 2;

/// What was done so far, for statistics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Steps.
    pub steps: u64,
    /// Corrections of pressures.
    pub corrections: u64,
    /// How much denser than at rest a particle was at most, as a share.
    pub most: f32,
}

/// Where a simulation is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// The description it is of; empty where there is none.
    pub identity: String,
    /// Frames and sub-frames after the first.
    pub step: u64,
    /// What was done so far.
    pub totals: Totals,
    /// All that the fluid goes on from.
    pub state: State,
    /// What its owner goes on from beside that, such as bodies.
    pub rest: Vec<u8>,
}

impl State {
    /// The particles of a state in its order, which are so far apart at rest, in metres.
    pub fn particles(&self, spacing: f32) -> Particles {
        let vectors = |rows: &[Vec4]| rows.iter().map(|row| row.truncate().to_array()).collect::<Vec<_>>();
        let velocities = vectors(&self.velocities).into_flattened();
        let velocities = Channel { name: VELOCITY.into(), width: 3, values: velocities };
        let channels = self.channels.iter().map(|ParticleChannel { name, width, values }| Channel {
            name: name.clone(),
            width: *width as u32,
            values: values.clone(),
        });
        Particles {
            points: vectors(&self.places),
            time: Some(self.seconds),
            spacing: Some(spacing),
            numbers: Some(self.numbers.clone()),
            channels: std::iter::once(velocities).chain(channels).collect(),
        }
    }
}

impl Checkpoint {
    /// What of it is not among the particles.
    pub fn encode(&self) -> Vec<u8> {
        let Self { identity, step, totals, state, rest } = self;
        let mut out = VERSION.to_le_bytes().to_vec();
        out.extend((identity.len() as u32).to_le_bytes());
        out.extend(identity.as_bytes());
        out.extend([*step, totals.steps, totals.corrections].iter().flat_map(|number| number.to_le_bytes()));
        out.extend(totals.most.to_le_bytes());
        out.extend(state.seconds.to_le_bytes());
        out.extend([state.pulled, state.share].iter().flat_map(|number| number.to_le_bytes()));
        out.extend([state.next, state.numbers.len() as u32].iter().flat_map(|number| number.to_le_bytes()));
        out.extend(state.places.iter().flat_map(|place| place.w.to_le_bytes()));
        out.extend(state.velocities.iter().flat_map(|velocity| velocity.w.to_le_bytes()));
        let pushes = state.pushes.iter().flat_map(|push| push.truncate().to_array());
        out.extend(pushes.flat_map(f32::to_le_bytes));
        out.extend(state.pressures.iter().flat_map(|pressure| pressure.to_le_bytes()));
        out.extend(state.births.iter().flat_map(|birth| birth.to_le_bytes()));
        out.extend(state.lifetimes.iter().flat_map(|lifetime| lifetime.to_le_bytes()));
        out.extend(rest);
        out
    }

    /// Where the simulation was that wrote a frame; `None` if the frame has no state.
    ///
    /// # Errors
    /// Fails if the state is of another version, does not fit the particles, or is not sound ([`State::check`]).
    pub fn of(frame: Frame) -> Result<Option<Self>> {
        let Some(bytes) = frame.state else { return Ok(None) };
        let Particles { points, numbers, mut channels, .. } = frame.particles;
        let mut reader = Reader(&bytes);
        let version = reader.u32()?;
        if version != VERSION {
            return Err(Error::unsupported(format!("its state is of version {version}"))
                .advise("take the Relievo that wrote it, or begin anew"));
        }
        let length = reader.u32()? as usize;
        let identity = String::from_utf8(reader.bytes(length)?.to_vec()).map_err(|_| unfit())?;
        let step = reader.u64()?;
        let totals = Totals { steps: reader.u64()?, corrections: reader.u64()?, most: reader.f32()? };
        let (seconds, pulled, share, next) = (reader.f64()?, reader.f32()?, reader.f32()?, reader.u32()?);
        let count = reader.u32()? as usize;
        let velocities = channels.iter().position(|channel| channel.name == VELOCITY && channel.width == 3);
        let (Some(velocities), Some(numbers)) = (velocities, numbers.filter(|_| count == points.len())) else {
            return Err(unfit());
        };
        let velocities = channels.remove(velocities).values;
        let row = |vector: &[f32; 3], last: f32| Vec3::from(*vector).extend(last);
        let begun = reader.list(count, f32::from_le_bytes)?;
        let corrected = reader.list(count, f32::from_le_bytes)?;
        let pushes = reader.list(3 * count, f32::from_le_bytes)?;
        let state = State {
            seconds,
            pulled,
            share,
            next,
            places: points.iter().zip(&begun).map(|(place, last)| row(place, *last)).collect(),
            velocities: velocities
                .as_chunks()
                .0
                .iter()
                .zip(&corrected)
                .map(|(velocity, last)| row(velocity, *last))
                .collect(),
            pushes: pushes.as_chunks().0.iter().map(|push| row(push, 0.0)).collect(),
            pressures: reader.list(count, f32::from_le_bytes)?,
            numbers,
            births: reader.list(count, f64::from_le_bytes)?,
            lifetimes: reader.list(count, f32::from_le_bytes)?,
            channels: channels
                .into_iter()
                .map(|Channel { name, width, values }| ParticleChannel { name, width: width as usize, values })
                .collect(),
        };
        state.check()?;
        Ok(Some(Self { identity, step, totals, state, rest: reader.0.to_vec() }))
    }
}

/// Takes from the front of bytes that may be anything.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(unfit)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk().ok_or_else(unfit)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn f32(&mut self) -> Result<f32> {
        self.array().map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A list of `count` numbers.
    fn list<const N: usize, T>(&mut self, count: usize, number: fn([u8; N]) -> T) -> Result<Vec<T>> {
        let bytes = self.bytes(count.checked_mul(N).ok_or_else(unfit)?)?;
        Ok(bytes.as_chunks().0.iter().map(|bytes| number(*bytes)).collect())
    }
}

fn unfit() -> Error {
    Error::invalid("its state does not fit its particles").advise("begin anew")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let rows = |last: f32| vec![Vec4::new(0.5, 1.0, -2.0, last), Vec4::new(3.0, 0.25, 1e-3, last)];
        let state = State {
            seconds: 0.3,
            pulled: 9.81,
            share: 0.7,
            next: 9,
            places: rows(2.5),
            velocities: rows(1.25),
            pushes: rows(0.0),
            pressures: vec![4.0, -1.5],
            numbers: vec![8, 3],
            births: vec![0.0, 0.1],
            lifetimes: vec![f32::INFINITY, 2.0],
            channels: vec![ParticleChannel { name: "heat".into(), width: 2, values: vec![1.0, 2.0, 3.0, 4.0] }],
        };
        let totals = Totals { steps: 12, corrections: 40, most: 0.01 };
        Checkpoint { identity: "a dam".into(), step: 5, totals, state, rest: vec![7, 8] }
    }

    fn frame(state: Vec<u8>) -> Frame {
        let particles = checkpoint().state.particles(0.02);
        Frame { particles, level: String::new(), state: Some(state) }
    }

    #[test]
    fn what_is_written_is_read_and_what_is_cut_is_not() {
        let bytes = checkpoint().encode();
        assert_eq!(Checkpoint::of(frame(bytes.clone())).unwrap(), Some(checkpoint()));
        assert!((0..bytes.len() - 2).all(|length| Checkpoint::of(frame(bytes[..length].to_vec())).is_err()));
        assert_eq!(Checkpoint::of(Frame { state: None, ..frame(Vec::new()) }).unwrap(), None);
    }

    #[test]
    fn a_state_that_does_not_fit_or_is_newer_is_refused() {
        let refused = |frame: Frame, why: &str| {
            let error = Checkpoint::of(frame).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        };
        let bytes = checkpoint().encode();
        let newer = [&3u32.to_le_bytes(), &bytes[4..]].concat();
        refused(frame(newer), "version 3");
        let mut fewer = frame(bytes.clone());
        fewer.particles.points.pop();
        refused(fewer, "does not fit");
        let mut still = frame(bytes.clone());
        still.particles.channels.remove(0);
        refused(still, "does not fit");
        let mut twice = frame(bytes);
        twice.particles.numbers = Some(vec![3, 3]);
        refused(twice, "same number");
    }
}
