//! Values on triangle meshes, kept at the vertices that tessellation makes: colour and displacement on edges and faces
//! where something happened.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.

mod allocation;
mod around;
pub mod block;
pub mod change;
pub mod channel;
pub mod composite;
pub mod decay;
mod device;
pub mod displaced;
mod expendable;
pub mod field;
mod mending;
pub mod normals;
pub mod paging;
pub mod pattern;
pub mod piece;
#[cfg(test)]
mod shapes;
mod stored;
pub mod tessellate;
pub mod trace;
pub mod vectors;

pub use block::TriangleBlock;
pub use change::{TriangleChange, TriangleSets, TriangleSnapshot, TriangleValues};
pub use channel::{TriangleChannel, TriangleOptions};
pub use composite::TriangleSheet;
pub use decay::{TriangleDecay, TriangleStamps};
pub use device::{DeviceTriangles, TRIANGLES_GROUP};
pub use displaced::{Foot, TriangleDisplaced, edge_foot, foot, foot_at};
pub use field::{TriangleClass, TriangleField};
pub use normals::TriangleNormals;
pub use pattern::{Node, Pattern, Slot};
pub use piece::{FaceRates, TrianglePiece, border_strip};
pub use tessellate::TriangleTessellation;
pub use vectors::Offset;
