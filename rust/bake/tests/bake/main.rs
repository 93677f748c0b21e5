//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod atlas;
mod maps;
mod opened;
mod ptex;
mod support;
mod transfer;
mod triangles;
