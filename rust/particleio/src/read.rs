//! What readers of all formats return.

use crate::particles::Particles;

/// What was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read {
    /// The particles.
    pub particles: Particles,
    /// What was left out, for the user to know.
    pub notes: Vec<String>,
}
