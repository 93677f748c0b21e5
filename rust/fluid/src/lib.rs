//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod block;
mod function;
mod isosurface;
mod kernel;
mod marching;
mod profile;
mod rows;
mod surface;

pub use function::SurfaceFunction;
pub use isosurface::{Channel, mesh};
pub use kernel::Kernels;
pub use surface::{Probe, Sample, Surface};
