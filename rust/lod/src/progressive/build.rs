//! Progressive meshes as they are built: the collapses of a simplification become splits, their numbers and their wedges.

pub(crate) mod attributed;
pub mod cut;
pub mod hierarchy;
mod numbers;
pub mod order;
pub(crate) mod recording;
mod settle;
pub(crate) mod wedges;
mod within;
