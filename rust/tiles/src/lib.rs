//! Tile heaps, rings and displaced evaluation.

pub mod heap;
pub mod sets;
pub mod spline;

pub use sets::{Candidate, Sets};
