//! Tests of this crate, one program for all: linking one each took most of the time that they took to build.

mod bending;
mod budgets;
mod device;
mod fading;
mod half_colors;
mod history;
mod imprint;
mod layers;
mod levels;
mod open_colliders;
mod openvdb;
mod paging;
mod paint;
mod refit;
mod shapes;
mod strokes;
mod terraces;
mod traces;
mod triangle_bending;
mod triangle_documents;
mod triangle_paging;
mod triangle_ridges;
mod triangle_rims;
mod triangles;
mod vectors;
