//! Point instancers of USD stages: many copies of a few prototypes, each with its place.

use glam::{DAffine3, DVec3};

/// Copies of prototypes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointInstancer {
    /// Its path on the stage.
    pub path: String,
    /// Paths of the prototypes.
    pub prototypes: Vec<String>,
    /// Copies, in order, without inactive or invisible ones.
    pub copies: Vec<Copied>,
}

/// A copy of a prototype.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Copied {
    /// The prototype, as an index into [`PointInstancer::prototypes`].
    pub prototype: u32,
    /// The map from the prototype, in metres with y up, to the stage in metres with y up.
    pub transform: DAffine3,
    /// Metres a second.
    pub velocity: DVec3,
    /// The primvar `clip`: name or number of a clip; empty without.
    pub clip: String,
    /// The primvar `phase`: seconds; 0 without.
    pub phase: f64,
}
