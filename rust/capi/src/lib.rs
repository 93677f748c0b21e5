//! The C ABI of Relievo: the only crate whose functions C and C++ call.
//!
//! One noun is one header in `include/relievo`, one file of the same name here, in the folder of its subject, and one
//! test in `tests/c`. The headers are the documentation of every function; `tests/header` compares their types, values and
//! layouts with this crate's. Every function goes through [`entry!`](border), which keeps panics inside and remembers the
//! last error; every handle goes through the [`registry`](border::registry), every array through
//! [`array`](border::array) and every descriptor through [`descriptor`](border::descriptor).

// The headers document every item; repeating them here would let the two drift apart.
#![allow(missing_docs, clippy::missing_safety_doc)]

#[macro_use]
pub mod border;
mod details;
mod levels;
mod runtime;
mod scenery;
mod simulation;
mod surfaces;

pub use details::{bake, brush, collider, color_buffer, decal, detail, document, imprint, layer, object, stroke, view};
pub use levels::{arrival, device_level, level, progressive, simplify};
pub use runtime::{
    adapter, allocator, buffer, bytes, capability, context, error, job, parameter, stream, version, vulkan,
};
pub use scenery::{crowd, crowd_stream, device_crowd, picture, shader};
pub use simulation::{channel, client, diffuse, fluid, foam, isosurface, particles, tissue};
pub use surfaces::{
    bezier, caster, evaluate, grid, mesh, procedural, ptex, repair, shape, subdivision, surface, tessellate,
};
