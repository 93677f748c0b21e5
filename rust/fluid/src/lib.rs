//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod function;
mod kernel;
mod profile;
mod rows;
mod surface;

pub use function::SurfaceFunction;
pub use kernel::Kernels;
pub use surface::{Probe, Sample, Surface};
