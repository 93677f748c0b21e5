//! Taking channels along: as Ptex and back, as pictures of tiles, as maps on the mesh's own texture coordinates, as
//! meshes.
//!
//! - Files with a texture for every face: [`ptex`], with [`prefilter`] for what a displacement's numbers mean there.
//! - Pictures of tiles: [`atlas`], and back: [`gather`]; [`mosaic`] for textures that are looked up as they are.
//! - Bakes to texture coordinates: [`map`], of what [`quantity`] says, in files as [`texture`] has them; [`triangles`]
//!   of triangle meshes.
//! - Documents: [`opened`] makes surface and channels of one, [`transfer`](mod@transfer) takes one to another mesh.

pub mod atlas;
pub mod gather;
pub mod gutter;
mod layout;
pub mod map;
pub mod mosaic;
mod nearby;
mod nearby_faces;
pub mod opened;
pub mod prefilter;
pub mod ptex;
pub mod quantity;
mod raster;
mod resample;
mod restored;
mod solve;
pub mod texture;
pub mod transfer;
pub mod triangles;

pub use gutter::Gutter;
pub use map::{BakeOptions, BakeReport, Map, bake, bake_watched};
pub use opened::Opened;
pub use quantity::{Axes, Colors, Handedness, Meaning, Quantity, Space};
pub use texture::{MapFormat, Scaling, numbered, write_map};
