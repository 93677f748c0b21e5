//! A fluid on its way from frame to frame, which goes on from any frame that was stored.

use relievo_core::{Context, Error, Result};
use relievo_fluid::{Checkpoint, Fluid, State, StepStatistics, Totals, Transport};
use relievo_gpu::Device;
use relievo_particleio::encode_frame;

use crate::bodies;
use crate::description::Description;
use crate::files::Source;
use crate::play::Play;

/// How frames are made.
#[derive(Debug, Default)]
pub struct Making {
    /// The format that frames are stored in, by its extension. It is part of their identity.
    pub format: String,
    /// Steps from frame to frame: 1, or the number of sub-frames.
    pub parts: u32,
    /// The graphics device that makes the steps; `None` for the processor.
    pub device: Option<Device>,
}

/// A fluid and all that it meets, at one of its frames or sub-frames.
pub struct Simulation {
    description: Description,
    identity: String,
    making: Making,
    play: Play,
    fluid: Fluid,
    step: u64,
    totals: Totals,
}

impl Simulation {
    /// Begins a simulation at its first frame.
    ///
    /// # Errors
    /// Fails as [`Description::play`], [`Description::begin`] and [`Description::identity`] do: if the description, or
    /// a file that it names, cannot be used.
    pub fn begin(context: &Context, description: Description, files: &Source, making: Making) -> Result<Self> {
        let mut play = description.play(context, files)?;
        let fluid = description.begin(context, files, &mut play)?;
        // The bits of frames are a device's own.
        let device = making.device.as_ref().map_or_else(String::new, |it| format!(" by {}", it.summary().name));
        let Making { format, parts, .. } = &making;
        let identity = format!("{format}, {parts} sub-frames{device} of {}", description.identity(context, files)?);
        Ok(Self { description, identity, making, play, fluid, step: 0, totals: Totals::default() })
    }

    /// Returns all that decides the bits of the frames but the instruction level of the processor: the description without
    /// the number of its frames, checksums of the files that it names, the format, the sub-frames and the device.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Returns the description that is simulated.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Returns the fluid as it is now.
    pub fn fluid(&self) -> &Fluid {
        &self.fluid
    }

    /// Returns how many emitters there are.
    pub fn emitters(&self) -> usize {
        self.play.sources.emitters.len()
    }

    /// Returns the number of the last frame or sub-frame.
    pub fn last(&self) -> u64 {
        u64::from(self.description.frames) * u64::from(self.making.parts)
    }

    /// Returns the number of the frame or sub-frame that the fluid is at; 0 is the first.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Returns what was done since the first frame.
    pub fn totals(&self) -> Totals {
        self.totals
    }

    /// Returns the seconds from one frame or sub-frame to the next.
    pub fn seconds(&self) -> f32 {
        (1.0 / (self.description.fps * f64::from(self.making.parts))) as f32
    }

    /// Goes on from a frame that was stored. Whether it is of this simulation is for the caller to check.
    ///
    /// # Errors
    /// Fails with `Invalid` if its state does not fit the fluid or its bodies.
    pub fn restore(&mut self, checkpoint: Checkpoint) -> Result<()> {
        let bodies = bodies::decode(&checkpoint.rest)?;
        self.fluid.set_state(checkpoint.state)?;
        self.play.bodies.set_states(&bodies)?;
        (self.step, self.totals) = (checkpoint.step, checkpoint.totals);
        Ok(())
    }

    /// Simulates to the next frame or sub-frame and calls `watch` after each step of the solver
    ///
    /// # Errors
    /// Returns the error of `watch`, and fails as [`Play::advance`] or [`Play::advance_on`] does. The fluid is then
    /// between two frames: restore it before it goes on.
    pub fn advance(&mut self, context: &Context, mut watch: impl FnMut(&StepStatistics) -> Result<()>) -> Result<()> {
        let (time, seconds) =
            (self.step as f64 / (self.description.fps * f64::from(self.making.parts)), self.seconds());
        let mut totals = self.totals;
        let counted = |done: &StepStatistics| {
            totals.steps += 1;
            totals.corrections += u64::from(done.corrections);
            totals.most = totals.most.max(done.excess.most);
            watch(done)
        };
        let Self { play, fluid, making, .. } = self;
        match &making.device {
            None => {
                let mut counted = counted;
                play.advance(context, fluid, time, seconds, |_, done| counted(done))?;
            }
            Some(device) => play.advance_on((context, device), fluid, time, seconds, counted)?,
        }
        self.totals = totals;
        self.step += 1;
        Ok(())
    }

    /// Accelerates each particle by so many m/s² beside all else, in the order of a frame's particles, from now on.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many as particles, or a number is not finite.
    pub fn accelerate(&mut self, accelerations: &[[f32; 3]]) -> Result<()> {
        let accelerations: Vec<_> = accelerations.iter().copied().map(glam::Vec3::from).collect();
        self.fluid.accelerate(&accelerations)
    }

    /// Returns what the simulation goes on from at this frame.
    pub fn checkpoint(&self) -> Checkpoint {
        self.checkpoint_of(self.fluid.state())
    }

    /// Goes on with a part of the particles, while other ranks, which have begun or restored the same simulation and
    /// call this too, have the rest.
    ///
    /// # Errors
    /// Fails with `Unsupported` where there is a graphics device or the fluid has what domains cannot have, and with
    /// `Io` if another rank has ended.
    pub fn distribute(&mut self, transport: Box<dyn Transport>) -> Result<()> {
        if self.making.device.is_some() {
            return Err(Error::unsupported("graphics devices do not work in domains")
                .advise("simulate the fluid in one process, on its processor"));
        }
        self.fluid.distribute(transport)
    }

    /// Returns what the simulation goes on from at this frame, of all ranks: on rank 0, and on others `None`. All ranks
    /// call this.
    ///
    /// # Errors
    /// Fails with `Io` if another rank has ended.
    pub fn gather(&mut self) -> Result<Option<Checkpoint>> {
        Ok(self.fluid.gather()?.map(|state| self.checkpoint_of(state)))
    }

    fn checkpoint_of(&self, state: State) -> Checkpoint {
        Checkpoint {
            identity: self.identity.clone(),
            step: self.step,
            totals: self.totals,
            state,
            rest: bodies::encode(&self.play.bodies.states()),
        }
    }

    /// Returns this frame as a file of the cache format holds it, with what the simulation goes on from.
    ///
    /// # Errors
    /// Fails with `Invalid` if a particle is not finite, and with `Internal` if the frame cannot be compressed.
    pub fn encode(&self, context: &Context) -> Result<Vec<u8>> {
        let checkpoint = self.checkpoint();
        encode_frame(context, &checkpoint.state.particles(self.description.spacing()), Some(&checkpoint.encode()))
    }

    /// Reads a frame that [`Self::encode`] or a run of `relievo fluid sim` made.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is damaged or has no state, with `Unsupported` if it is of a newer version, and with
    /// `Memory` if it does not fit the context's memory limit.
    pub fn decode(context: &Context, bytes: &[u8]) -> Result<Checkpoint> {
        Checkpoint::of(relievo_particleio::read_frame(context, bytes)?)?
            .ok_or_else(|| Error::invalid("the frame has no state that a simulation could go on from"))
    }
}
