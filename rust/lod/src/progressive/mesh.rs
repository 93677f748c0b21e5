//! Meshes of a progressive mesh: refined and coarsened in place, for a view, and in the buffers of their users.

pub mod active;
mod active_wedges;
pub(crate) mod bitset;
mod blocks;
mod buffer_places;
pub mod buffers;
pub(crate) mod jump;
pub(crate) mod sparse;
mod splits;
pub mod view;
