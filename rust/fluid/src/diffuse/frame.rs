//! Diffuse particles in files: frames of particles with the channels `velocity`, `type`, `age` and `lifetime`, and what a
//! run goes on from.
//!
//! The state, little-endian: `RLVFOAM1`, what the run is of (u32 bytes of text), and the frames and
//! births so far (u64 each). Particles are in the frame itself.

use glam::Vec3;
use relievo_core::{Error, Result};
use relievo_particleio::{Channel, Frame, Particles, VELOCITY};

use super::{Diffuse, DiffuseKind, DiffuseOptions, DiffuseParticles};

/// The channel of kinds: 0 spray, 1 foam, 2 bubble.
const TYPE: &str = "type";
/// The channel of seconds since birth.
const AGE: &str = "age";
/// The channel of seconds of foam that are left.
const LIFETIME: &str = "lifetime";
const MAGIC: [u8; 8] = *b"RLVFOAM1";

impl DiffuseParticles {
    /// Returns the ids as numbers of 32 bits, as files have them.
    ///
    /// # Errors
    /// Fails if an id has more than 32 bits.
    pub fn numbers(&self) -> Result<Vec<u32>> {
        let number = |id: &u64| u32::try_from(*id);
        self.ids.iter().map(number).collect::<std::result::Result<_, _>>().map_err(|_| {
            Error::unsupported("more than 2³² diffuse particles were born")
                .advise("make fewer particles a second, or begin a second run")
        })
    }

    /// Returns the particles as those of a file, at a time in seconds, of a fluid whose particles are so many metres
    /// apart.
    ///
    /// # Errors
    /// Fails if an id has more than 32 bits.
    pub fn to_file(&self, time: f64, spacing: f32) -> Result<Particles> {
        let channel = |name: &str, width: u32, values: Vec<f32>| Channel { name: name.into(), width, values };
        let arrays = |vectors: &[Vec3]| vectors.iter().map(|vector| vector.to_array()).collect::<Vec<_>>();
        Ok(Particles {
            points: arrays(&self.positions),
            time: Some(time),
            spacing: Some(spacing),
            numbers: Some(self.numbers()?),
            channels: vec![
                channel(VELOCITY, 3, arrays(&self.velocities).into_flattened()),
                channel(TYPE, 1, self.kinds.iter().map(|kind| f32::from(*kind as u8)).collect()),
                channel(AGE, 1, self.ages.clone()),
                channel(LIFETIME, 1, self.lifetimes.clone()),
            ],
        })
    }

    /// Returns the diffuse particles of a file.
    ///
    /// # Errors
    /// Fails if the particles have no numbers, a channel is missing, or a type is unknown.
    pub fn of_file(particles: &Particles) -> Result<Self> {
        let column = |name: &str, width: u32| {
            let found = particles.channel(name).filter(|channel| channel.width == width);
            found.map(|channel| channel.values.as_slice()).ok_or_else(|| {
                Error::invalid(format!("the frame has no channel `{name}`"))
                    .advise("use a frame of `relievo foam generate`")
            })
        };
        let kind = |value: &f32| match *value {
            0.0 => Ok(DiffuseKind::Spray),
            1.0 => Ok(DiffuseKind::Foam),
            2.0 => Ok(DiffuseKind::Bubble),
            other => Err(Error::invalid(format!("a diffuse particle has the type {other}"))
                .advise("use 0 for spray, 1 for foam and 2 for bubbles")),
        };
        let numbers = particles.numbers.as_ref().ok_or_else(|| {
            Error::invalid("the diffuse particles have no numbers").advise("use a frame of `relievo foam generate`")
        })?;
        Ok(Self {
            positions: particles.points.iter().map(|point| Vec3::from(*point)).collect(),
            velocities: column(VELOCITY, 3)?.as_chunks().0.iter().map(|velocity| Vec3::from_array(*velocity)).collect(),
            kinds: column(TYPE, 1)?.iter().map(kind).collect::<Result<_>>()?,
            ages: column(AGE, 1)?.to_vec(),
            lifetimes: column(LIFETIME, 1)?.to_vec(),
            ids: numbers.iter().map(|number| u64::from(*number)).collect(),
        })
    }
}

impl Diffuse {
    /// Returns the state with which [`Self::resume`] continues the run; `identity` says what it is of.
    pub fn state(&self, identity: &str) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend((identity.len() as u32).to_le_bytes());
        out.extend(identity.as_bytes());
        out.extend([self.frames, self.births].iter().flat_map(|number| number.to_le_bytes()));
        out
    }

    /// Returns whether the state of a frame is one of diffuse particles.
    pub fn has_state(frame: &Frame) -> bool {
        frame.state.as_ref().is_some_and(|state| state.starts_with(&MAGIC))
    }

    /// Returns the identity and the run of a frame of a cache; `None` if the frame has no state.
    ///
    /// # Errors
    /// Fails if the state is of another version or does not fit, or a setting is out of range.
    pub fn resume(options: DiffuseOptions, frame: &Frame) -> Result<Option<(String, Self)>> {
        let Some(state) = &frame.state else { return Ok(None) };
        let unfit = || Error::invalid("the state of the frame is not one of diffuse particles").advise("begin anew");
        let rest = state.strip_prefix(&MAGIC).ok_or_else(unfit)?;
        let (length, rest) = rest.split_first_chunk().ok_or_else(unfit)?;
        let (text, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(unfit)?;
        let identity = String::from_utf8(text.to_vec()).map_err(|_| unfit())?;
        let [frames, births] = match rest.as_chunks::<8>() {
            ([frames, births], []) => [*frames, *births].map(u64::from_le_bytes),
            _ => return Err(unfit()),
        };
        let run = Self::restore(options, DiffuseParticles::of_file(&frame.particles)?, frames, births)?;
        Ok(Some((identity, run)))
    }
}
