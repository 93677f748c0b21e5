//! Tests of fluids through what the crate shows.

mod blind;
mod isosurface;
mod raytrace;
mod shapes;
mod smoothing;
