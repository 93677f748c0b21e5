//! Structs that host and shaders share, one module for each WGSL module that declares some.
//!
//! `build/` writes them from the text in `shaders/`: every struct that a variable in storage, in uniforms or in immediate
//! data holds, and every struct in one, with its names and comments. A vector is an array, a matrix an array of columns, an
//! atomic its number. What WGSL leaves free between fields and at the end are the fields `padding`, `padding_2` and so on.

#![allow(missing_docs, rustdoc::all)]

include!(concat!(env!("OUT_DIR"), "/wgsl.rs"));
