//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.
//! Tests that begin processes have their own: for a moment such a process holds the locks of the one that begins it.

#[macro_use]
mod texts;

mod bending;
mod brushes;
#[cfg(feature = "crowd")]
mod crowd_devices;
#[cfg(feature = "crowd")]
mod crowd_impostors;
#[cfg(feature = "crowd")]
mod crowds;
#[cfg(feature = "decal")]
mod decals;
mod decay;
mod device;
mod half_colors;
mod levels;
mod run;
mod support;
#[cfg(feature = "tissue")]
mod tissue;
mod traces;
#[cfg(feature = "crowd")]
mod treading;
mod triangles;
mod usd;
