//! Scalar displacement: a [`Channel`] of the B-spline coefficients of [`crate::quads::spline`]. Units: object units.

use std::sync::Arc;

use half::f16;
use relievo_core::Result;
use relievo_surface::TileTopology;

use crate::quads::channel::{Channel, ChannelOptions};

/// Displacements that may be edited.
pub type Displacement = Channel<f16>;

/// How a displacement is made.
pub type DisplacementOptions = ChannelOptions;

impl Displacement {
    /// A displacement of zero everywhere.
    ///
    /// # Errors
    /// Fails if a size or face does not exist.
    pub fn new(topology: Arc<TileTopology>, options: &DisplacementOptions) -> Result<Self> {
        Self::blank(topology, f16::ZERO, options)
    }
}
