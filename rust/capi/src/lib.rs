//! The C ABI of Relievo: the only crate whose functions C and C++ call.
//!
//! One noun is one header in `include/relievo`, one file here and one test in `tests/c`. The headers are the
//! documentation of every function; `tests/header` compares their types, values and layouts with this crate's. Every
//! function goes through [`entry!`](border), which keeps panics inside and remembers the last error; every handle goes
//! through the [`registry`], every array through [`array`] and every descriptor through [`descriptor`].

// The headers document every item; repeating them here would let the two drift apart.
#![allow(missing_docs, clippy::missing_safety_doc)]

#[macro_use]
pub mod border;
mod arithmetic;
pub mod array;
#[macro_use]
pub mod descriptor;
pub mod adapter;
pub mod allocator;
pub mod arrival;
pub mod bake;
pub mod bezier;
pub mod brush;
pub mod buffer;
pub mod bytes;
pub mod capability;
pub mod caster;
pub mod channel;
pub mod client;
pub mod collider;
pub mod color_buffer;
pub mod context;
pub mod crowd;
pub mod decal;
pub mod detail;
pub mod device_crowd;
pub mod device_level;
pub mod diffuse;
pub mod document;
pub mod element;
pub mod error;
pub mod evaluate;
pub mod fluid;
pub mod foam;
pub mod fork;
mod glibc;
pub mod grid;
pub mod host;
pub mod imprint;
pub mod isosurface;
pub mod job;
pub mod layer;
pub mod level;
pub mod log;
pub mod making;
pub mod memory;
pub mod mesh;
pub mod object;
pub mod parameter;
pub mod particles;
pub mod picture;
pub mod procedural;
pub mod progressive;
pub mod ptex;
pub mod registry;
pub mod repair;
#[cfg_attr(not(feature = "shader"), path = "shader_absent.rs")]
pub mod shader;
pub mod shape;
pub mod simplify;
pub mod stream;
pub mod stroke;
pub mod subdivision;
pub mod surface;
pub mod tessellate;
pub mod tissue;
pub mod version;
pub mod view;
pub mod vulkan;
pub mod work;
