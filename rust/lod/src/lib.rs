//! Levels of detail of triangle meshes: simplification by parallel edge collapses, and progressive meshes.

mod connectivity;
mod distance;
mod mates;
mod numbers;
mod order;
pub mod progressive;
mod simplify;
mod watched;
mod weld;

pub use distance::posed_distance::PosedDistance;
pub use distance::{Distance, MeasuredMesh, distance};
pub use progressive::Progressive;
pub use simplify::attributes::{Attributes, SimplifiedWith, simplify_with};
pub use simplify::mesh::{AttributeOptions, SimplifiedMesh, default_weight, simplify_mesh};
pub use simplify::{Simplified, SimplifyOptions, simplify};
pub use weld::{Welded, weld};
