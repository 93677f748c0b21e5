//! Progressive meshes in files and as they arrive, and journals of their edits.

pub mod arrival;
pub mod file;
pub(crate) mod format;
mod inputs;
pub mod journal;
pub(crate) mod packing;
mod reading;
mod wedge_columns;
