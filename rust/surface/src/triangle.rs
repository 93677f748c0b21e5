//! Triangle meshes as surfaces: how triangles meet, and points and smooth normals on them.
//!
//! What Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6,
//! displaces and paints: flat triangles whose normals are interpolated from their vertices.

mod carried;
mod closest;
mod device;
mod split;
mod surface;
mod topology;

pub use carried::Pieces;
pub use closest::closest;
pub use device::{DeviceMesh, MESH_GROUP};
pub use split::{SplitReport, split};
pub use surface::TriangleSurface;
pub use topology::{TriangleSide, TriangleTopology};
