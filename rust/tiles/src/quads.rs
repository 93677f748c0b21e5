//! Tiles of quads: their rings, mips and levels, the surface that they displace, and its meshes.

mod carried;
pub mod channel;
pub mod color;
pub mod displaced;
pub mod displacement;
pub mod face_varying;
pub mod field;
pub mod filter;
pub mod fold;
pub mod frame;
pub mod levels;
pub(crate) mod mip;
mod numbering;
pub mod ring;
pub(crate) mod seam;
pub mod spline;
pub mod tessellate;
pub mod vector;
