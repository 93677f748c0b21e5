//! Boxes, hierarchies, voxels and rays: where things meet.

pub(crate) mod closure;
pub mod dda;
pub(crate) mod exits;
pub mod grid;
pub mod hierarchy;
pub(crate) mod lattice;
pub mod obb;
pub mod overlap;
pub(crate) mod rays;
pub(crate) mod scanline;
pub mod voxel;
pub mod voxel_frame;
