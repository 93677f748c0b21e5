//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod boundary;
mod device;
mod diffuse;
mod solver;
mod source;
mod state;
mod surface;

#[cfg(feature = "rapier3d")]
pub use boundary::body::Bodies;
#[cfg(not(feature = "rapier3d"))]
pub use boundary::body_absent::Bodies;
pub use boundary::body_state::{BodyOptions, BodyState};
pub use boundary::collider::{ColliderOptions, Contact};
pub use boundary::exchange::{Given, Impulse};
pub use boundary::wall::{basin, block};
pub use device::{DeviceFluid, classify_on};
pub use diffuse::{
    Diffuse, DiffuseEntry, DiffuseKind, DiffuseOptions, DiffuseParticles, DiffuseReport, DiffuseSettings, FluidFrame,
    Potentials, differences, positions_and_velocities,
};
pub use solver::domain::Traffic;
pub use solver::force::Force;
pub use solver::kernel::{KernelSet, Kernels};
pub use solver::options::{FluidOptions, PressureSolver, TimeStep};
pub use solver::particles::{Batch, ParticleChannel};
pub use solver::pcisph::Excess;
pub use solver::transport::{InProcess, Transport};
pub use solver::{Fluid, StepStatistics};
pub use source::field::fill_where;
pub use source::shape::{cuboid, sphere};
pub use source::solid::Solid;
pub use source::{Emitter, Overflow, Sink, Sources};
pub use state::State;
pub use state::checkpoint::{Checkpoint, Totals};
pub use surface::Surface;
pub use surface::blind::{Classes, Visibility, classify};
pub use surface::function::SurfaceFunction;
pub use surface::isosurface::{Channel, mesh};
pub use surface::level_set::{BLOCK, Block, LevelSet, level_set};
pub use surface::probe::{Probe, Sample};
pub use surface::raytrace::{Hit, March, Motion, Ray, RayCaster, Tracer, Trail};
pub use surface::smoothing::{Smoothing, smooth};
