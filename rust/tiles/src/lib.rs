//! Displacement tiles: where they live, how they meet, and the surface they displace.
//!
//! - Where: [`heap`], [`sets`], [`field`], and [`displacement`] with the protocol of an edit.
//! - How they meet: [`ring`]. What they mean: [`spline`].
//! - The displaced surface: [`displaced`] evaluates it, [`tessellate`] makes triangles of it.

mod carried;
pub mod displaced;
pub mod displacement;
pub mod face_varying;
pub mod field;
pub mod heap;
mod numbering;
pub mod ring;
pub mod sets;
pub mod spline;
pub mod tessellate;

pub use displaced::{Displaced, Points};
pub use displacement::{Applied, Displacement, DisplacementOptions, Snapshot, Texels};
pub use field::Field;
pub use ring::Change;
pub use sets::{Candidate, Sets};
pub use tessellate::{Tessellation, Tessellator, uniform_rates};
