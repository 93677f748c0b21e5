//! Values on triangle meshes, kept at the vertices that tessellation makes: colour and displacement on edges and faces
//! where something happened.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.

pub mod block;
pub mod channel;
pub mod displaced;
pub mod field;
pub mod normals;
pub mod pattern;
pub mod piece;
#[cfg(test)]
mod shapes;
pub mod tessellate;
pub mod vectors;

pub use block::TriangleBlock;
pub use channel::{TriangleChange, TriangleChannel, TriangleOptions, TriangleSets, TriangleSnapshot, TriangleValues};
pub use displaced::{Foot, TriangleDisplaced};
pub use field::{TriangleClass, TriangleField};
pub use normals::TriangleNormals;
pub use pattern::{Node, Pattern, Slot};
pub use piece::{FaceRates, TrianglePiece};
pub use tessellate::TriangleTessellation;
pub use vectors::Offset;
