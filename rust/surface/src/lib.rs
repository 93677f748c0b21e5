//! Catmull-Clark limit surfaces: tiles, patches, evaluation, bounds.

pub mod topology;

pub use topology::{Incidence, Link, Place, RingClass, Side, TileTopology};
