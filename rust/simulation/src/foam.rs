//! A fluid and its foam, simulated together frame by frame (Ihmsen, Akinci, Akinci, Teschner 2012).
//!
//! A description of foam is that of a fluid with a table `foam`. A frame has the diffuse particles; its state has the frame
//! of the fluid and what the foam goes on from:
//!
//! - `RLVWATER` (8 bytes), bytes of the fluid's frame (u64, little-endian), that frame, and the state of [`Diffuse`].

use glam::Vec3;
use relievo_core::{Context, Error, Progress, Result};
use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseSettings, FluidFrame};
use relievo_particleio::{encode_frame, read_frame};

use crate::description::Description;
use crate::files::Source;
use crate::simulation::{Making, Simulation};

const MAGIC: [u8; 8] = *b"RLVWATER";
/// The name of the table of foam in a description.
const TABLE: &str = "foam";
/// The identity of the foam in its state. What decides the frames is in [`Foam::identity`].
const RUN: &str = "foam";
/// The part of a frame's time that the fluid is taken to need.
const FLUID_SHARE: f32 = 0.9;

/// Reads a table of foam: the entries of [`DiffuseSettings::entries`], and `bounds`, two corners.
fn read_settings(table: toml::Table) -> Result<(DiffuseSettings, Option<[Vec3; 2]>)> {
    let mut settings = DiffuseSettings::default();
    let mut bounds = None;
    for (name, value) in table {
        if name == "bounds" {
            let corners: [[f32; 3]; 2] = value
                .try_into()
                .map_err(|_| Error::invalid("`bounds` is not two corners").advise("write [[0, 0, 0], [1, 1, 1]]"))?;
            bounds = Some(corners.map(Vec3::from));
            continue;
        }
        let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        let values: Option<Vec<f64>> = match &value {
            toml::Value::Array(list) => list.iter().map(number).collect(),
            single => number(single).map(|number| vec![number]),
        };
        let values = values.ok_or_else(|| {
            Error::invalid(format!("`{name}` is not a number or a list of numbers")).advise("write a number, or [1, 2]")
        })?;
        settings.set_entry(&name, &values)?;
    }
    Ok((settings, bounds))
}

/// A description of a fluid and of the foam that it makes.
#[derive(Debug)]
pub struct FoamDescription {
    /// The fluid.
    pub fluid: Description,
    /// The settings of the foam.
    pub options: DiffuseOptions,
}

impl FoamDescription {
    /// Returns whether a text has a table `foam`, and so describes foam. A text that is not TOML has none.
    pub fn is_meant(text: &str) -> bool {
        toml::from_str::<toml::Table>(text).is_ok_and(|table| table.contains_key(TABLE))
    }

    /// Parses the text of a description.
    ///
    /// # Errors
    /// Fails as [`Description::parse`] does, and with `Invalid` if a setting of the foam is unknown or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let invalid = |error: &dyn std::fmt::Display| Error::invalid(error.to_string());
        let mut table: toml::Table = toml::from_str(text).map_err(|error| invalid(&error))?;
        let (settings, bounds) = match table.remove(TABLE) {
            None => (DiffuseSettings::default(), None),
            Some(toml::Value::Table(foam)) => read_settings(foam).map_err(|error| error.at(TABLE))?,
            Some(_) => {
                return Err(Error::invalid("foam is not a table").at(TABLE).advise("write [foam] before its settings"));
            }
        };
        let rest = toml::to_string(&table).map_err(|error| invalid(&error))?;
        let fluid = Description::parse(&rest)?;
        let options = DiffuseOptions { spacing: fluid.spacing(), gravity: fluid.gravity(), bounds, settings };
        Diffuse::new(options).map_err(|error| error.at(TABLE))?;
        Ok(Self { fluid, options })
    }
}

/// A fluid and its foam at one of their frames.
pub struct Foam {
    fluid: Simulation,
    options: DiffuseOptions,
    diffuse: Diffuse,
    identity: String,
}

impl Foam {
    /// Begins at the first frame, which has no foam. `making` is that of the fluid, with one step a frame.
    ///
    /// # Errors
    /// Fails as [`Simulation::begin`] does, and with `Invalid` if an option of the foam is out of range.
    pub fn begin(context: &Context, description: FoamDescription, files: &Source, making: Making) -> Result<Self> {
        let FoamDescription { fluid, options } = description;
        let fluid = Simulation::begin(context, fluid, files, making)?;
        let identity = format!("{options:?} of {}", fluid.identity());
        Ok(Self { fluid, options, diffuse: Diffuse::new(options)?, identity })
    }

    /// Returns all that decides the bits of the frames, as [`Simulation::identity`] does.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Returns the fluid.
    pub fn fluid(&self) -> &Simulation {
        &self.fluid
    }

    /// Returns the number of diffuse particles.
    pub fn len(&self) -> usize {
        self.diffuse.particles().len()
    }

    /// Returns whether there is no diffuse particle.
    pub fn is_empty(&self) -> bool {
        self.diffuse.particles().is_empty()
    }

    /// Simulates to the next frame.
    ///
    /// # Errors
    /// Fails with `Cancelled` if `progress` asks to stop, with `Invalid` if pressures do not converge or a number is
    /// not finite, and with `Memory` if new particles exceed the memory limit. The simulation is then between two
    /// frames: restore it before it goes on.
    pub fn advance(&mut self, context: &Context, progress: &mut dyn Progress) -> Result<()> {
        let (mut done, seconds) = (0.0, self.fluid.seconds());
        self.fluid.advance(context, |step| {
            done += step.seconds;
            progress.step(FLUID_SHARE * (done / seconds).min(1.0), "fluid")
        })?;
        let fluid = self.fluid.fluid();
        let positions: Vec<Vec3> = fluid.places().iter().map(|place| place.truncate()).collect();
        let velocities: Vec<Vec3> = fluid.velocities().iter().map(|velocity| velocity.truncate()).collect();
        let frame = FluidFrame { positions: &positions, velocities: &velocities };
        let mut rest =
            |fraction: f32, stage: &str| progress.report(FLUID_SHARE + (1.0 - FLUID_SHARE) * fraction, stage);
        self.diffuse.advance(context, frame, seconds, &mut rest)?;
        Ok(())
    }

    /// Returns this frame as a file of the cache format: the diffuse particles, and all that the simulation goes on from.
    ///
    /// # Errors
    /// Fails with `Internal` if the frame cannot be compressed, and with `Invalid` if a particle is not finite.
    pub fn encode(&self, context: &Context) -> Result<Vec<u8>> {
        let water = self.fluid.encode(context)?;
        let mut state = MAGIC.to_vec();
        state.extend((water.len() as u64).to_le_bytes());
        state.extend(&water);
        state.extend(self.diffuse.state(RUN));
        let time = self.fluid.step() as f64 * f64::from(self.fluid.seconds());
        encode_frame(context, &self.diffuse.particles().to_file(time, self.options.spacing)?, Some(&state))
    }

    /// Goes on from a frame of [`Self::encode`].
    ///
    /// # Errors
    /// Fails with `Invalid` if the frame is damaged or not one of foam, with `Unsupported` if it is of a newer version,
    /// and with `Memory` if it does not fit the context's memory limit.
    pub fn restore(&mut self, context: &Context, frame: &[u8]) -> Result<()> {
        let mut frame = read_frame(context, frame)?;
        let whole = frame.state.take().ok_or_else(unfit)?;
        let (water, state) = split(&whole)?;
        let checkpoint = Simulation::decode(context, water)?;
        frame.state = Some(state.to_vec());
        let (_, diffuse) = Diffuse::resume(self.options, &frame)?.ok_or_else(unfit)?;
        self.fluid.restore(checkpoint)?;
        self.diffuse = diffuse;
        Ok(())
    }

    /// Returns the frame of the fluid that is in a frame of foam.
    ///
    /// # Errors
    /// Fails with `Invalid` if the frame is damaged or not one of foam, with `Unsupported` if it is of a newer version,
    /// and with `Memory` if it does not fit the context's memory limit.
    pub fn water(context: &Context, frame: &[u8]) -> Result<Vec<u8>> {
        let state = read_frame(context, frame)?.state.ok_or_else(unfit)?;
        Ok(split(&state)?.0.to_vec())
    }
}

fn unfit() -> Error {
    Error::invalid("the frame has no state of a fluid with foam").advise("take a frame of a simulation of foam")
}

/// Splits the state of a frame into the frame of the fluid and the state of the foam.
fn split(state: &[u8]) -> Result<(&[u8], &[u8])> {
    let rest = state.strip_prefix(&MAGIC).ok_or_else(unfit)?;
    let (length, rest) = rest.split_first_chunk().ok_or_else(unfit)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| unfit())?;
    rest.split_at_checked(length).ok_or_else(unfit)
}
