//! Nouns of fluids, their foam and surfaces, particles, soft tissue, and servers that simulate.

pub mod channel;
pub mod client;
pub mod diffuse;
pub mod fluid;
pub mod foam;
pub mod isosurface;
pub mod particles;
pub mod tissue;
