//! Nouns of levels of detail: simplification and progressive meshes.

pub mod arrival;
pub mod device_level;
pub mod level;
pub mod progressive;
pub mod simplify;
