//! Tests of fluids through what the crate shows.

mod blind;
#[cfg(feature = "rapier3d")]
mod body;
mod device;
mod device_blind;
mod device_collider;
mod fill;
mod flow;
mod isosurface;
mod level_set;
mod raytrace;
mod shapes;
mod smoothing;
