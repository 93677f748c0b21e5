//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod blind;
mod block;
mod function;
mod isosurface;
mod kernel;
mod marching;
mod profile;
mod rows;
mod surface;

pub use blind::{Classes, Visibility, classify};
pub use function::SurfaceFunction;
pub use isosurface::{Channel, mesh};
pub use kernel::Kernels;
pub use surface::{Probe, Sample, Surface};
