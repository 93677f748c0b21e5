//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod blind;
mod block;
mod cells;
mod chords;
mod constants;
mod function;
mod hierarchy;
mod isosurface;
mod kernel;
mod marching;
mod neighbours;
mod options;
mod pairs;
mod pcisph;
mod prepare;
mod probe;
mod profile;
mod raytrace;
mod rows;
mod smoothing;
mod solver;
mod surface;
mod wall;

pub use blind::{Classes, Visibility, classify};
pub use function::SurfaceFunction;
pub use isosurface::{Channel, mesh};
pub use kernel::{KernelSet, Kernels};
pub use options::{FluidOptions, TimeStep};
pub use pcisph::Excess;
pub use probe::{Probe, Sample};
pub use raytrace::{Hit, March, Motion, Ray, RayCaster, Tracer};
pub use smoothing::{Smoothing, smooth};
pub use solver::{Fluid, StepStatistics};
pub use surface::Surface;
pub use wall::{basin, block};
