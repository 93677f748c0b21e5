//! A fluid on a graphics device: its steps are those of the processor, pass by pass.
//!
//! Particles are sorted by cells and have lists of neighbours, as on the processor, and sums are in the order of these lists,
//! so that a device gives the same bits in every run. A step is one submission, with as many corrections as it mostly takes;
//! corrections that are not needed have no workgroups, which the device decides itself.

mod blind;
mod forces;
mod obstacles;
mod passes;

pub use blind::classify_on;
use glam::{DVec3, Vec4, Vec4Swizzles};
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::fluid::FluidCall;
use relievo_gpu::wgsl::fluid_press::Report;
use relievo_gpu::{Device, PassTime};

use self::obstacles::Obstacles;
use self::passes::Passes;
use crate::boundary::wall::Wall;
use crate::solver::constants::Constants;
use crate::solver::pace::{Pace, within};
use crate::solver::pcisph::Excess;
use crate::solver::press::CARRIED;
use crate::{
    Classes, Fluid, FluidOptions, Force, Given, PressureSolver, State, StepStatistics, SurfaceFunction, Visibility,
};

/// Neighbours that there is room for at first, and at most.
const ROOM: [u32; 2] = [64, 4096];
/// Corrections of a submission: of the first of a step, and of later ones.
const BATCHES: [u32; 2] = [12, 24];
/// More than any excess of particles that are somewhere.
const LOST: f32 = 1e30;

/// A fluid whose steps a graphics device makes. It has the particles and walls of a [`Fluid`] and gives them back.
#[derive(Debug)]
pub struct DeviceFluid {
    device: Device,
    options: FluidOptions,
    constants: Constants,
    /// What it was sent as.
    state: State,
    wall: Wall,
    pace: Pace,
    forces: Vec<Force>,
    obstacles: Obstacles,
    /// The sum of what hosts accelerate particles by, in m/s².
    pushed: DVec3,
    /// The greatest speed, in m/s.
    speed: f32,
    passes: Passes,
    times: Vec<PassTime>,
}

impl DeviceFluid {
    /// Sends a fluid with its walls, forces and colliders to a device, where colliders go where they are going now.
    ///
    /// # Errors
    /// Fails if the fluid has particles that do not stay for ever, surface tension, another solver than PCISPH, or
    /// colliders with more than 2,000 triangles within a few spacings, and where the device is lost or has no memory.
    pub fn new(device: &Device, fluid: &Fluid) -> Result<Self> {
        let is_tense = fluid.options().tension > 0.0;
        if fluid.is_mortal() || is_tense || fluid.options().solver != PressureSolver::Pcisph {
            return Err(Error::unsupported(
                "fluids on devices have walls, forces, colliders and PCISPH, but no lifetimes and surface tension",
            )
            .advise("use `--device cpu`, or PCISPH without them"));
        }
        let (state, options, (constants, wall, pace)) = (fluid.state(), fluid.options().clone(), fluid.setting());
        let (constants, wall) = (*constants, wall.clone());
        let count = state.numbers.len();
        let (colliders, firsts) = fluid.obstacles();
        let obstacles = Obstacles::new(device, colliders, firsts, &options)?;
        let passes = Passes::new(device, [count, wall.set().len(), fluid.forces().len()], ROOM[0], &obstacles)?;
        passes.rows.places.write(device, 0, &state.places)?;
        let velocities = state.velocities.iter().zip(&state.pressures).map(|(row, pressure)| row.with_w(*pressure));
        passes.rows.velocities.write(device, 0, &velocities.collect::<Vec<_>>())?;
        let tags = state.pushes.iter().zip(0..).map(|(push, at)| {
            let [x, y, z, _] = push.to_array().map(f32::to_bits);
            [x, y, z, at]
        });
        passes.rows.tags.write(device, 0, &tags.collect::<Vec<_>>())?;
        let made = Self {
            device: device.clone(),
            options,
            constants,
            pushed: state.pushes.iter().map(|push| push.xyz().as_dvec3()).sum(),
            state,
            wall,
            pace,
            forces: fluid.forces().to_vec(),
            obstacles,
            speed: fluid.speed(),
            passes,
            times: Vec::new(),
        };
        made.send_walls()?;
        Ok(made)
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.state.numbers.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How long the next step should be, in seconds.
    pub fn time_step(&self) -> f32 {
        self.pace.step(&self.options, &self.constants, self.speed.max(self.wall.speed))
    }

    /// How long the passes of the last step took on the device; nothing where it does not time.
    pub fn times(&self) -> &[PassTime] {
        &self.times
    }

    /// Simulates so many seconds in as many steps as it takes, and calls `watch` after each.
    ///
    /// # Errors
    /// Fails as [`Self::step`], and with the error that `watch` returns.
    pub fn advance(
        &mut self,
        seconds: f32,
        mut watch: impl FnMut(&mut Self, &StepStatistics) -> Result<()>,
    ) -> Result<()> {
        let mut left = seconds;
        while left > 1e-6 * seconds {
            let done = self.step(within(self.time_step(), left))?;
            left -= done.seconds;
            watch(self, &done)?;
        }
        Ok(())
    }

    /// Makes a step of so many seconds, or a shorter one where pressures do not converge, a collider comes to rest, or
    /// one would go farther than the options' part of the spacing.
    ///
    /// # Errors
    /// Fails as [`Fluid::step`], and where the device has no memory or is lost; nothing has moved then.
    pub fn step(&mut self, seconds: f32) -> Result<StepStatistics> {
        let seconds = seconds.max(0.0).min(self.obstacles.longest());
        if self.is_empty() || seconds == 0.0 {
            self.arrive(seconds)?;
            return Ok(StepStatistics { seconds, ..StepStatistics::default() });
        }
        self.times.clear();
        let forces = self.forces.iter().map(|force| forces::row(force, self.state.seconds));
        self.passes.work.forces.write(&self.device, 0, &forces.collect::<Vec<_>>())?;
        let mut call = self.call(seconds);
        let mut report = self.begin(&mut call)?;
        let mut corrections = report.corrections;
        while report.is_enough == 0 {
            let Some((shorter, kept)) = self.pace.again(&self.options, call.step) else { break };
            // Pressures that did not converge are no better than none.
            call = FluidCall {
                step: shorter,
                farthest: self.farthest(shorter),
                allowed_share: kept,
                carried: 0.0,
                ..call
            };
            report = self.press(&call, false)?;
            corrections += report.corrections;
        }
        let is_lost = report.most > LOST;
        let is_enough = report.is_enough != 0 || self.options.time_step.is_fixed();
        if is_lost || !is_enough {
            return Err(Error::invalid("pressures do not converge")
                .at(format!("a step of {} s", call.step))
                .advise("take shorter steps, and see whether particles begin in each other or in walls"));
        }
        let mut frame = self.device.frame()?;
        if report.is_enough == 0 {
            self.passes.end(&mut frame, &call)?;
        }
        let greatest = frame.read(&self.passes.work.greatest, 0..1)?;
        let given = frame.read(&self.passes.work.given, 0..1)?;
        self.times.extend(frame.submit()?.wait()?);
        let [speed, change] = greatest.get(&self.device)?[0].map(f32::sqrt);
        self.speed = speed;
        self.pace.settle(&self.options, corrections, change / call.step);
        let given = self.given(given.get(&self.device)?[0], call.step);
        self.arrive(call.step)?;
        let excess = Excess { most: report.most, mean: report.mean };
        Ok(StepStatistics { seconds: call.step, corrections, excess, given, ..StepStatistics::default() })
    }

    /// What a step gave, by the sums of what forces and walls accelerated particles by.
    fn given(&self, [forces, walls]: [Vec4; 2], seconds: f32) -> Given {
        let each = f64::from(self.constants.mass) * f64::from(seconds);
        Given {
            gravity: each * self.len() as f64 * self.options.gravity.as_dvec3(),
            host: each * self.pushed,
            forces: each * forces.xyz().as_dvec3(),
            walls: each * walls.xyz().as_dvec3(),
        }
    }

    /// All that the fluid goes on from, on the processor too. Particles are in the order in which they were sent.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn state(&self) -> Result<State> {
        let count = self.len();
        let mut frame = self.device.frame()?;
        let rows = &self.passes.rows;
        let places = frame.read(&rows.places, 0..count)?;
        let velocities = frame.read(&rows.velocities, 0..count)?;
        let tags = frame.read(&rows.tags, 0..count)?;
        let _ = frame.submit()?;
        let (places, velocities) = (places.get(&self.device)?, velocities.get(&self.device)?);
        let mut state = self.state.clone();
        (state.pulled, state.share) = (self.pace.pulled, self.pace.share);
        for (at, [_, _, _, from]) in tags.get(&self.device)?.into_iter().enumerate() {
            state.places[from as usize] = places[at];
            state.velocities[from as usize] = velocities[at].with_w(0.0);
            state.pressures[from as usize] = velocities[at].w;
        }
        Ok(state)
    }

    /// What particles are for their surface, in the order in which they were sent, as [`classify_on`]; they stay on the
    /// device.
    ///
    /// # Errors
    /// Fails as [`classify_on`].
    pub fn classify(&self, function: SurfaceFunction, threshold: Option<f32>) -> Result<Classes> {
        if self.is_empty() {
            return Ok(Classes::new(Vec::new()));
        }
        let found = blind::find(&self.device, &self.passes.rows.places, function, threshold)?;
        let mut frame = self.device.frame()?;
        let tags = frame.read(&self.passes.rows.tags, 0..self.len())?;
        let _ = frame.submit()?;
        let mut classes = vec![Visibility::Hidden; self.len()];
        let from = tags.get(&self.device)?.into_iter().map(|[_, _, _, from]| from as usize);
        from.zip(found).for_each(|(from, class)| classes[from] = class);
        Ok(Classes::new(classes))
    }

    /// Sorts particles, finds neighbours, makes room for them where there is none, and presses.
    fn begin(&mut self, call: &mut FluidCall) -> Result<Report> {
        loop {
            call.room = self.passes.room();
            let report = self.press(call, true)?;
            if report.crowd == 0 {
                return Ok(report);
            }
            if report.crowd > ROOM[1] {
                return Err(Error::invalid(format!(
                    "{} particles are within the support radius of another",
                    report.crowd
                ))
                .advise("let fewer particles begin at one place, or make their spacing less"));
            }
            self.passes.widen(&self.device, report.crowd.next_multiple_of(32))?;
        }
    }

    /// Corrects pressures until they are enough or there were as many corrections as there may be.
    fn press(&mut self, call: &FluidCall, is_new: bool) -> Result<Report> {
        let mut made = 0;
        loop {
            let mut frame = self.device.frame()?;
            if is_new && made == 0 {
                self.passes.look_around(&mut frame, call)?;
            }
            let batch = BATCHES[usize::from(made > 0)];
            self.passes.press(&mut frame, call, batch, made == 0)?;
            let report = frame.read(&self.passes.work.report, 0..1)?;
            self.times.extend(frame.submit()?.wait()?);
            let report = report.get(&self.device)?[0];
            made += batch;
            let is_over = report.corrections >= call.corrections || report.corrections < made;
            if report.crowd > 0 || report.is_enough != 0 && report.corrections >= call.least || is_over {
                return Ok(report);
            }
        }
    }

    /// Goes on by a step in time.
    fn arrive(&mut self, seconds: f32) -> Result<()> {
        self.state.seconds += f64::from(seconds);
        let is_moving = self.wall.speed > 0.0;
        self.wall.arrive(seconds);
        self.obstacles.arrive(&self.device, &mut self.wall, seconds)?;
        if is_moving { self.send_walls() } else { Ok(()) }
    }

    fn send_walls(&self) -> Result<()> {
        if !self.wall.set().is_empty() {
            self.passes.walls.places.write(&self.device, 0, self.wall.set())?;
            self.passes.walls.velocities.write(&self.device, 0, self.wall.paces())?;
            let mut frame = self.device.frame()?;
            self.passes.sort_walls(&mut frame, &self.call(0.0))?;
            let _ = frame.submit()?;
        }
        Ok(())
    }

    /// How far a particle may go in a step of so many seconds, in metres.
    fn farthest(&self, step: f32) -> f32 {
        self.pace.farthest(&self.options, &self.constants, self.speed.max(self.wall.speed), step)
    }

    /// The beginning of a step.
    fn call(&self, step: f32) -> FluidCall {
        let Constants { kernels, mass, density, wall, diagonal, viscosity, friction, cohesion, .. } = self.constants;
        let FluidOptions { gravity, excess, corrections, .. } = self.options;
        FluidCall {
            gravity: gravity.to_array(),
            support: kernels.support,
            kernel: kernels.density,
            spiky: kernels.spiky,
            wall,
            kernels: kernels.set as u32,
            mass,
            density,
            diagonal,
            viscosity,
            friction,
            cohesion,
            farthest: self.farthest(step),
            step,
            begun_limit: (1.0 + excess.most) * density,
            allowed_share: 0.0,
            most: excess.most,
            mean: excess.mean,
            count: self.len() as u32,
            walls: self.wall.set().len() as u32,
            room: self.passes.room(),
            least: corrections[0],
            corrections: corrections[1],
            carried: CARRIED,
            forces: self.forces.len() as u32,
            spacing: if self.obstacles.is_empty() { 0.0 } else { self.options.spacing },
        }
    }
}
