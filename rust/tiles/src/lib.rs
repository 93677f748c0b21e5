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

pub mod blocks;
mod carried;
pub mod channel;
pub mod color;
pub mod composite;
pub mod decay;
mod device;
mod device_mips;
mod device_ring;
pub mod displaced;
pub mod displacement;
pub mod face_varying;
mod fade;
pub mod field;
pub mod filter;
pub mod fold;
pub mod frame;
pub mod heap;
pub mod levels;
mod mip;
mod numbering;
mod pages;
pub mod paging;
pub mod planes;
pub mod ring;
mod seam;
pub mod sets;
mod slot;
mod spare;
pub mod spline;
pub mod stored;
pub mod tessellate;
pub mod texel;
pub mod trace;
pub mod triangle;
pub mod vector;

pub use blocks::Blocks;
pub use channel::{Applied, Channel, ChannelOptions, Snapshot, Texels};
pub use color::{AnyField, ByFormat, Paint};
pub use composite::{Layered, Sheet};
pub use decay::{Decay, DecayOptions, Faded, StampBlocks};
pub use device::{DeviceTiles, DisplacedEvaluation, TILES_GROUP};
pub use device_mips::DeviceMips;
pub use device_ring::{BoundRing, DeviceRing, WorkedBlocks};
pub use displaced::{Displaced, Points};
pub use displacement::{Displacement, DisplacementOptions};
pub use field::Field;
pub use fold::Folds;
pub use planes::{ColorPlanes, Planes};
pub use ring::Change;
pub use seam::SEAM_REACH;
pub use sets::{Candidate, Sets};
pub use stored::StoredTexel;
pub use tessellate::{Tessellation, Tessellator, uniform_rates};
pub use texel::{ColorTexel, Rgba8, Rgba16, Texel, Vector};
pub use trace::{Mark, Trace, Traces};
pub use vector::VectorDisplacement;
