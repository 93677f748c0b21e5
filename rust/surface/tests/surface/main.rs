//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod bezier;
mod device;
mod embree;
mod evaluators;
mod memory;
mod subdivision;
