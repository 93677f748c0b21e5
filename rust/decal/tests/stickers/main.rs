//! Decals as a user of the crate sees them.

mod disks;
mod geodesics;
mod holes;
mod hostile;
mod lay;
mod models;
mod placement;
mod recipes;
mod ring;
mod sheets;
mod strip;
mod triangle_recipes;
mod wound;
mod written;
