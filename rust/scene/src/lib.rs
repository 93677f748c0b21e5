//! Scene files, physics, frame stepping and caches.

pub mod assets;
pub mod bake;
mod bodies;
pub mod cache;
mod coat;
pub mod description;
pub mod diagnostic;
mod documents;
pub mod export;
pub mod file;
pub mod keyframe;
pub mod manual;
pub mod output;
pub mod paths;
pub mod physics;
pub mod picture;
mod reader;
pub mod schema;
pub mod sequence;
pub mod shapes;
pub mod starter;
pub mod stepper;
mod strokes;
pub mod tessellation;
pub mod trace;
mod views;
pub mod world;
