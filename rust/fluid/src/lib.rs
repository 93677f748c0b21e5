//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod kernel;

pub use kernel::Kernels;
