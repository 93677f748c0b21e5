//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod blind;
mod block;
#[cfg(feature = "rapier3d")]
mod body;
#[cfg(not(feature = "rapier3d"))]
mod body_absent;
mod body_state;
mod cells;
mod checkpoint;
mod chords;
mod collider;
mod constants;
mod device;
mod dfsph;
mod diffuse;
mod domain;
mod exchange;
mod field;
mod force;
mod function;
mod hierarchy;
mod interior;
mod isosurface;
mod kernel;
mod lattice;
mod level_set;
mod marching;
mod migration;
mod neighbours;
mod noise;
#[cfg(feature = "rapier3d")]
mod obstacle;
mod options;
mod pace;
mod pairs;
mod particles;
mod pcisph;
mod prepare;
mod probe;
mod profile;
mod radix;
mod raytrace;
mod rows;
mod sampling;
mod shape;
mod smoothing;
mod solid;
mod solver;
mod source;
mod state;
mod surface;
mod sweep;
mod tension;
mod transport;
mod wall;

pub use blind::{Classes, Visibility, classify};
#[cfg(feature = "rapier3d")]
pub use body::Bodies;
#[cfg(not(feature = "rapier3d"))]
pub use body_absent::Bodies;
pub use body_state::{BodyOptions, BodyState};
pub use checkpoint::{Checkpoint, Totals};
pub use collider::{ColliderOptions, Contact};
pub use device::{DeviceFluid, classify_on};
pub use diffuse::{
    Diffuse, DiffuseEntry, DiffuseKind, DiffuseOptions, DiffuseParticles, DiffuseReport, DiffuseSettings, FluidFrame,
    Potentials, differences, positions_and_velocities,
};
pub use domain::Traffic;
pub use exchange::{Given, Impulse};
pub use field::fill_where;
pub use force::Force;
pub use function::SurfaceFunction;
pub use isosurface::{Channel, mesh};
pub use kernel::{KernelSet, Kernels};
pub use level_set::{BLOCK, Block, LevelSet, level_set};
pub use options::{FluidOptions, PressureSolver, TimeStep};
pub use particles::{Batch, ParticleChannel};
pub use pcisph::Excess;
pub use probe::{Probe, Sample};
pub use raytrace::{Hit, March, Motion, Ray, RayCaster, Tracer, Trail};
pub use shape::{cuboid, sphere};
pub use smoothing::{Smoothing, smooth};
pub use solid::Solid;
pub use solver::{Fluid, StepStatistics};
pub use source::{Emitter, Overflow, Sink, Sources};
pub use state::State;
pub use surface::Surface;
pub use transport::{InProcess, Transport};
pub use wall::{basin, block};
