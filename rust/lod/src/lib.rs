//! Levels of detail of triangle meshes: simplification by parallel edge collapses, and progressive meshes.

mod connectivity;
mod decimation;
mod placement;
pub mod progressive;
mod selection;
mod simplify;
mod watched;
mod weld;

pub use progressive::Progressive;
pub use simplify::{Simplified, SimplifyOptions, simplify};
pub use weld::{Welded, weld};
