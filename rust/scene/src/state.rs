//! The world of a scene: what its file names, loaded and made, at a time.

pub mod assets;
pub(crate) mod blocks;
pub(crate) mod checksum;
pub(crate) mod coat;
pub(crate) mod documents;
#[cfg_attr(not(feature = "fluid"), path = "state/isosurface_absent.rs")]
pub mod isosurface;
pub mod keyframe;
pub(crate) mod load;
pub mod paths;
#[cfg_attr(not(feature = "rapier3d"), path = "state/physics_absent.rs")]
pub mod physics;
pub mod shapes;
pub(crate) mod stamps;
#[cfg_attr(not(feature = "decal"), path = "state/stickers_absent.rs")]
pub(crate) mod stickers;
#[cfg_attr(not(feature = "tissue"), path = "state/tissue_absent.rs")]
pub mod tissue;
pub mod triangles;
#[cfg_attr(not(feature = "crowd"), path = "state/walking_absent.rs")]
pub mod walking;
pub mod world;
