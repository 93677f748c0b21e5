//! Bézier patches drawn from virtual vertices: a vertex stage evaluates points and normals at the places of parametric
//! maps, after Concheiro, Amor, Padrón, Gil, Martorell 2013 (*Rendering of Bézier Surfaces on Handheld Devices*).
//!
//! [`VirtualVertices`] are the patches, their maps and their draws on a device, [`Rasterizer`] draws them.

mod patches;
mod rasterizer;
mod tuner;

pub use patches::{DrawCall, Storage, UNIFORM_PATCHES, VirtualVertices};
pub use rasterizer::{PassedVertex, PassedVertices, Rasterizer};
pub use tuner::{Measured, Tuned, Tuning};
