//! What a fluid is, and how it is simulated.

use relievo_core::{Error, Result};
use relievo_fluid::{Excess, FluidOptions, KernelSet, PressureSolver, TimeStep};

use super::{RLV_FLUID_COURANT, RLV_FLUID_FIXED, RLV_FLUID_PCISPH, RLV_FLUID_WENDLAND};
use crate::border::descriptor::{numbered, read_optional};

/// Kernels by their numbers.
const KERNELS: [(KernelSet, &str); 2] = [(KernelSet::Wendland, "wendland"), (KernelSet::Mueller, "mueller")];

/// Solvers of pressures by their numbers.
const SOLVERS: [(PressureSolver, &str); 2] = [(PressureSolver::Pcisph, "pcisph"), (PressureSolver::Dfsph, "dfsph")];

descriptor! {
    pub struct RlvFluidOptions {
        struct_size: u32,
        kernels: u32,
        spacing: f32,
        density: f32,
        viscosity: f32,
        friction: f32,
        cohesion: f32,
        gravity: [f32; 3],
        max_excess: f32,
        mean_excess: f32,
        min_corrections: u32,
        max_corrections: u32,
        steps: u32,
        courant: f32,
        step: f32,
        solver: u32,
        tension: f32,
    }
}

/// What is asked for.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn read_options(options: *const RlvFluidOptions) -> Result<FluidOptions> {
    let usual = FluidOptions::default();
    let (courant, step) = match usual.time_step {
        TimeStep::Courant { number, most } => (number, most),
        TimeStep::Fixed(step) => (1.0, step),
    };
    let default = RlvFluidOptions {
        struct_size: 0,
        kernels: RLV_FLUID_WENDLAND,
        spacing: usual.spacing,
        density: usual.density,
        viscosity: usual.viscosity,
        friction: usual.friction,
        cohesion: usual.cohesion,
        gravity: usual.gravity.to_array(),
        max_excess: usual.excess.most,
        mean_excess: usual.excess.mean,
        min_corrections: usual.corrections[0],
        max_corrections: usual.corrections[1],
        steps: RLV_FLUID_COURANT,
        courant,
        step,
        solver: RLV_FLUID_PCISPH,
        tension: usual.tension,
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    let time_step = match given.steps {
        RLV_FLUID_COURANT => TimeStep::Courant { number: given.courant, most: given.step },
        RLV_FLUID_FIXED => TimeStep::Fixed(given.step),
        other => {
            return Err(Error::invalid(format!("there are no steps {other}")).at("steps").advise("use 0 or 1"));
        }
    };
    Ok(FluidOptions {
        spacing: given.spacing,
        density: given.density,
        viscosity: given.viscosity,
        friction: given.friction,
        cohesion: given.cohesion,
        tension: given.tension,
        gravity: given.gravity.into(),
        kernels: numbered("kernels", &KERNELS, given.kernels)?,
        excess: Excess { most: given.max_excess, mean: given.mean_excess },
        corrections: [given.min_corrections, given.max_corrections],
        time_step,
        solver: numbered("solver", &SOLVERS, given.solver)?,
    })
}
