//! Imprints from colliding objects: Catmull-Clark surfaces with displacement tiles are pushed out of whatever touches
//! them, after Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object Collisions.

pub mod dda;
pub mod grid;
pub mod hierarchy;
pub mod obb;
pub mod overlap;
mod scanline;
#[cfg(test)]
mod shapes;
pub mod voxel;

pub use dda::Exit;
pub use grid::Grid;
pub use hierarchy::{Bounds, Hierarchy, Region};
pub use obb::Obb;
pub use voxel::{Side, Solid, Voxels};
