//! The map of a patch of surface into the plane of the image: seed, growth, and relaxation of its distortion.

mod embed;
pub(crate) mod energy;
mod extend;
pub(crate) mod factor;
mod front;
pub(crate) mod gradual;
pub(crate) mod graph;
pub(crate) mod grow;
pub(crate) mod patch;
pub(crate) mod quality;
pub(crate) mod region;
pub(crate) mod relax;
pub(crate) mod seed;
mod triangular;
mod turns;
