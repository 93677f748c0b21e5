//! Tests of fluids through what the crate shows.

mod isosurface;
