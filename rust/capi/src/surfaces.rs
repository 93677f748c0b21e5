//! Nouns of meshes, surfaces and grids, and of queries of them.

pub mod bezier;
pub mod caster;
pub mod evaluate;
pub mod grid;
pub mod mesh;
pub mod procedural;
pub mod ptex;
pub mod repair;
pub mod shape;
pub mod subdivision;
pub mod surface;
pub mod tessellate;
