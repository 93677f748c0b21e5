//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.
//! `killed.rs` is another, since a process that is begun holds for a moment the locks of the one that begins it.

mod format;
mod journal;
mod model;
mod storage;
mod triangles;
