//! Levels of detail of triangle meshes: simplification by parallel edge collapses, and progressive meshes.

mod attributes;
mod beside;
mod connectivity;
mod decimation;
mod distance;
mod doubles;
mod error_bound;
mod exchange;
mod mates;
mod mesh;
mod numbers;
mod offset;
mod open_fans;
mod order;
mod outliers;
mod patch;
mod patches;
mod placement;
mod posed_distance;
pub mod progressive;
mod queue;
mod selection;
mod sheets;
mod simplify;
mod watched;
mod wedges;
mod weld;

pub use attributes::{Attributes, SimplifiedWith, simplify_with};
pub use distance::{Distance, distance};
pub use mesh::{AttributeOptions, SimplifiedMesh, default_weight, simplify_mesh};
pub use posed_distance::PosedDistance;
pub use progressive::Progressive;
pub use simplify::{Simplified, SimplifyOptions, simplify};
pub use weld::{Welded, weld};
