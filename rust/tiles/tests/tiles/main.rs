//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod color;
mod decay;
mod device;
mod device_rings;
mod displaced;
mod filter;
mod levels;
mod paging;
mod rings;
mod stored;
mod support;
mod tessellate;
mod topology;
mod triangle_paging;
mod vector;
