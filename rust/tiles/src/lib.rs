//! Tile heaps, rings and displaced evaluation.

pub mod displaced;
pub mod displacement;
pub mod face_varying;
pub mod field;
pub mod heap;
pub mod ring;
pub mod sets;
pub mod spline;
pub mod tessellate;

pub use displaced::{Displaced, Points};
pub use displacement::{Applied, Displacement, DisplacementOptions, Snapshot, Texels};
pub use field::Field;
pub use ring::Change;
pub use sets::{Candidate, Sets};
pub use tessellate::{Tessellation, uniform_rates};
