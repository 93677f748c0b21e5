//! Values on triangle meshes, kept at the vertices that tessellation makes: colour and displacement on edges and faces
//! where something happened.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.

pub mod channel;
pub mod field;
pub mod pattern;
#[cfg(test)]
mod shapes;

pub use channel::{TriangleChange, TriangleChannel, TriangleOptions, TriangleSets, TriangleSnapshot, TriangleValues};
pub use field::{TriangleClass, TriangleField};
pub use pattern::{Node, Pattern, Slot};
