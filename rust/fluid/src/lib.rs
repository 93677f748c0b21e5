//! Fluids of particles (smoothed particle hydrodynamics) and their surfaces.

mod anisotropy;
mod blind;
mod block;
mod chords;
mod function;
mod hierarchy;
mod isosurface;
mod kernel;
mod marching;
mod probe;
mod profile;
mod raytrace;
mod rows;
mod smoothing;
mod surface;

pub use blind::{Classes, Visibility, classify};
pub use function::SurfaceFunction;
pub use isosurface::{Channel, mesh};
pub use kernel::Kernels;
pub use probe::{Probe, Sample};
pub use raytrace::{Hit, March, Motion, Ray, RayCaster, Tracer};
pub use smoothing::{Smoothing, smooth};
pub use surface::Surface;
