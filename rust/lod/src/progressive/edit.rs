//! Edits of a mesh of a progressive mesh at any level, and how finer and coarser levels follow them.

mod beneath;
mod coarser;
pub(crate) mod directions;
pub mod handle;
pub(crate) mod history;
pub mod keyed;
pub(crate) mod moves;
pub(crate) mod place;
pub mod sculpt;
pub(crate) mod stars;
pub(crate) mod turning;
