//! Scene files, physics, frame stepping and caches.

pub mod assets;
pub mod bake;
mod blender;
mod blocks;
mod bodies;
pub mod cache;
mod coat;
mod crowds;
mod decals;
pub mod description;
#[cfg(feature = "fluid")]
pub mod df3;
pub mod diagnostic;
mod dielectric;
mod documents;
pub mod export;
pub mod file;
#[cfg_attr(not(feature = "fluid"), path = "foam_absent.rs")]
pub mod foam;
#[cfg_attr(not(feature = "fluid"), path = "isosurface_absent.rs")]
pub mod isosurface;
pub mod keyframe;
mod layers;
#[cfg_attr(not(feature = "decal"), path = "laying_absent.rs")]
mod laying;
pub mod manual;
pub mod output;
#[cfg(feature = "decal")]
pub mod overlap;
pub mod paths;
#[cfg_attr(not(feature = "rapier3d"), path = "physics_absent.rs")]
pub mod physics;
pub mod picture;
pub mod povray;
#[cfg_attr(not(feature = "fluid"), path = "povray_fluid_absent.rs")]
mod povray_fluid;
mod reader;
pub mod refusals;
pub mod replay;
mod riders;
mod row;
pub mod schema;
pub mod sequence;
pub mod shapes;
pub mod showing;
pub mod stages;
mod stamps;
pub mod starter;
pub mod stepper;
mod strokes;
pub mod tessellation;
#[cfg_attr(not(feature = "tissue"), path = "tissue_absent.rs")]
pub mod tissue;
mod tissues;
pub mod trace;
pub mod triangles;
mod views;
#[cfg_attr(not(feature = "crowd"), path = "walking_absent.rs")]
pub mod walking;
pub mod world;
