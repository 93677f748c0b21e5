//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod files;
mod gltf;
mod hostile;
mod round_trip;
mod usd;
