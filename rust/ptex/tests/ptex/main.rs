//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod hostile;
mod layout;
mod round_trip;
