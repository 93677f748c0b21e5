//! Scene files, physics, frame stepping and caches.

mod bodies;
pub mod description;
pub mod diagnostic;
pub mod file;
pub mod keyframe;
pub mod paths;
pub mod physics;
mod reader;
pub mod schema;
pub mod shapes;
