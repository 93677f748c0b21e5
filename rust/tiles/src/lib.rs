//! Tiles of displacement and colour: where they live, how they meet, and the surface they displace and paint.
//!
//! - Where: [`heap`], [`sets`], [`field`], and [`channel`] with the protocol of an edit; [`paging`] where memory is
//!   short; [`levels`] for edits at half or a quarter of the texels.
//! - What they hold: [`texel`]. How they meet: [`ring`]. What they mean: [`spline`], [`color`], looked up
//!   by [`filter`], and [`trace`].
//! - How they are kept in documents: [`stored`]; how histories see them: [`blocks`].
//! - Layers put on each other: [`composite`].
//! - Vectors: [`vector`], in the frames of [`frame`].
//! - The displaced surface: [`displaced`] evaluates it, [`tessellate`] makes triangles of it, [`fold`] counts its folds.

mod device;
mod layers;
pub mod planes;
mod quads;
mod store;
pub mod texel;
pub mod triangle;

pub use device::mips::DeviceMips;
pub use device::ring::{BoundRing, DeviceRing, WorkedBlocks};
pub use device::{DeviceTiles, DisplacedEvaluation, TILES_GROUP};
pub use layers::composite::{Layered, Sheet};
pub use layers::decay::{Decay, DecayOptions, FadeReport, StampBlocks};
pub use layers::trace::{Mark, Trace, Traces};
pub use layers::{composite, decay, trace};
pub use planes::{ColorPlanes, Planes};
pub use quads::channel::{Applied, Channel, ChannelOptions, Snapshot, Texels};
pub use quads::color::{AnyField, ByFormat, Paint};
pub use quads::displaced::{Displaced, Points};
pub use quads::displacement::{Displacement, DisplacementOptions};
pub use quads::field::Field;
pub use quads::fold::Folds;
pub use quads::ring::Change;
pub use quads::seam::SEAM_REACH;
pub use quads::tessellate::{Tessellation, Tessellator, uniform_rates};
pub use quads::vector::VectorDisplacement;
pub use quads::{
    channel, color, displaced, displacement, face_varying, field, filter, fold, frame, levels, ring, spline,
    tessellate, vector,
};
pub use store::blocks::Blocks;
pub use store::sets::{Candidate, Sets};
pub use store::stored::StoredTexel;
pub use store::{blocks, heap, paging, sets, stored};
pub use texel::{ColorTexel, Rgba8, Rgba16, Texel, Vector};
