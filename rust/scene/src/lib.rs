//! Scene files, physics, frame stepping and caches.

mod bodies;
pub mod description;
pub mod diagnostic;
pub mod file;
mod reader;
pub mod schema;
pub mod shapes;
