//! Tests of models of soft tissue and their simulation through what the crate shows.

mod bends;
mod bodies;
mod contact;
mod creation;
mod device;
mod dynamics;
mod files;
mod grids;
mod loads;
mod peer;
mod statics;
