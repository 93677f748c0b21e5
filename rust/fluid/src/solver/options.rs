//! What a fluid is, and how it is simulated.

use glam::Vec3;
use relievo_core::{Error, Result};

use crate::{Excess, KernelSet};

/// What a fluid is, and how it is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidOptions {
    /// Distance between particles at rest, in metres; positive. Kernels reach twice as far.
    pub spacing: f32,
    /// Density at rest, in kg/m³; positive.
    pub density: f32,
    /// Kinematic viscosity, in m²/s; 0 or more.
    pub viscosity: f32,
    /// The same between the fluid and walls; 0 lets it slip.
    pub friction: f32,
    /// What pulls particles to each other (Becker, Teschner 2007, Section 3.4), in m⁵/(kg s²); 0 or more.
    pub cohesion: f32,
    /// Surface tension (Akinci, Akinci, Teschner 2013), in N/m, 0.072 of water; 0 or more. Walls neither attract nor repel.
    pub tension: f32,
    /// Acceleration of all particles, in m/s².
    pub gravity: Vec3,
    /// The kernels of density and pressure.
    pub kernels: KernelSet,
    /// How pressures are found.
    pub solver: PressureSolver,
    /// How much denser than at rest the fluid may be when a step ends.
    pub excess: Excess,
    /// Corrections of pressures in a step, at least and at most. One that is not enough is made anew with half the time,
    /// unless steps are fixed.
    pub corrections: [u32; 2],
    /// How long steps are.
    pub time_step: TimeStep,
}

/// How pressures are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PressureSolver {
    /// By prediction and correction of densities (Solenthaler, Pajarola 2009).
    #[default]
    Pcisph,
    /// Velocities are also kept from compressing the fluid (Bender, Koschier 2017). It takes fewer steps, and in most fluids
    /// less time.
    Dfsph,
}

/// How long a step is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// Always so many seconds.
    Fixed(f32),
    /// As long as nothing goes farther than a part of the spacing (Courant, Friedrichs, Lewy 1928), and less where more
    /// than a few corrections were needed.
    Courant {
        /// The part of the spacing; positive.
        number: f32,
        /// Seconds at most.
        most: f32,
    },
}

impl TimeStep {
    /// Whether all steps are as long.
    pub fn is_fixed(self) -> bool {
        matches!(self, Self::Fixed(_))
    }
}

impl Default for FluidOptions {
    fn default() -> Self {
        Self {
            spacing: 0.02,
            density: 1000.0,
            viscosity: 1e-3,
            friction: 1e-3,
            cohesion: 0.0,
            tension: 0.0,
            gravity: Vec3::new(0.0, 0.0, -9.81),
            kernels: KernelSet::Wendland,
            solver: PressureSolver::default(),
            excess: Excess { most: 0.01, mean: 0.001 },
            corrections: [3, 100],
            time_step: TimeStep::Courant { number: 0.4, most: 0.005 },
        }
    }
}

impl FluidOptions {
    /// Checks the options.
    ///
    /// # Errors
    /// Fails if an option is out of range, and names it.
    pub fn check(&self) -> Result<()> {
        let steps = match self.time_step {
            TimeStep::Fixed(step) => [step, 1.0],
            TimeStep::Courant { number, most } => [number, most],
        };
        let positive = [
            ("spacing", self.spacing),
            ("density", self.density),
            ("time_step", steps[0]),
            ("time_step", steps[1]),
            ("excess", self.excess.most),
            ("excess", self.excess.mean),
        ];
        let positive = positive.into_iter().find(|(_, value)| !(*value > 1e-9 && *value < 1e9));
        let more = [
            ("viscosity", self.viscosity),
            ("friction", self.friction),
            ("cohesion", self.cohesion),
            ("tension", self.tension),
        ];
        let more = more.into_iter().find(|(_, value)| !(*value >= 0.0 && *value < 1e9));
        let refuse = |(name, value): (&str, f32), range: &str| {
            Err(Error::invalid(format!("{value} is no {name} of a fluid")).at(name).advise(format!("use {range}")))
        };
        match (positive, more) {
            (Some(option), _) => refuse(option, "1e-9 to 1e9"),
            (_, Some(option)) => refuse(option, "0 to 1e9"),
            _ if !self.gravity.is_finite() => refuse(("gravity", self.gravity.length()), "finite numbers"),
            _ if self.corrections[0] == 0 || self.corrections[1] < self.corrections[0] => {
                refuse(("corrections", self.corrections[0] as f32), "at least 1, and no more than at most")
            }
            _ => Ok(()),
        }
    }
}
