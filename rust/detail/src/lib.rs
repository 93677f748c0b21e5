//! Imprints from colliding objects: Catmull-Clark surfaces with displacement tiles are pushed out of whatever touches
//! them, after Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object Collisions.

pub mod collider;
pub mod contact;
pub mod cull;
pub mod dda;
pub mod grid;
pub mod hierarchy;
pub mod imprint;
pub mod knots;
pub mod motion;
pub mod obb;
pub mod object;
pub mod overlap;
pub mod pair;
pub mod raycast;
mod rays;
mod scanline;
#[cfg(test)]
mod shapes;
mod smoothing;
pub mod tool;
pub mod voxel;

pub use collider::Collider;
pub use contact::Contact;
pub use dda::Exit;
pub use grid::Grid;
pub use hierarchy::{Bounds, Hierarchy, Region};
pub use imprint::{ImprintSettings, Imprinter, Moment, Report};
pub use motion::{Motion, Pose};
pub use obb::Obb;
pub use object::DisplacedObject;
pub use pair::Deformable;
pub use voxel::{Side, Solid, Voxels};
