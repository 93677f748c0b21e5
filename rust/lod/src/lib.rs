//! Levels of detail of triangle meshes: simplification by parallel edge collapses.

mod connectivity;
mod decimation;
mod placement;
mod selection;
mod simplify;

pub use simplify::{Simplified, SimplifyOptions, simplify};
