//! Vector displacement: a [`Channel`] of the B-spline coefficients of [`crate::quads::spline`], three a texel, in the frames
//! of [`crate::quads::frame`]. It comes after scalar displacement, see [`crate::quads::displaced`]. Units: object units.

use std::sync::Arc;

use relievo_core::{Context, Result};
use relievo_document::{Document, PageStore};
use relievo_surface::Surface;

use crate::quads::channel::{Channel, ChannelOptions};
use crate::quads::frame::Frames;
use crate::texel::Vector;

/// Vector displacements that may be edited.
pub type VectorDisplacement = Channel<Vector>;

impl VectorDisplacement {
    /// No displacement anywhere. Vectors turn with the tangents of `surface`, and what tiles know of each other is
    /// re-expressed by its tangents as they are now.
    ///
    /// # Errors
    /// Fails if a size or face does not exist.
    pub fn on(surface: &Surface, options: &ChannelOptions) -> Result<Self> {
        Ok(Self::blank(surface.topology().clone(), Vector::ZERO, options)?.framed(surface))
    }

    /// As [`Channel::stored_with`], for `surface` in the pose that the stored channel was made in.
    ///
    /// # Errors
    /// Fails as [`Channel::stored_with`].
    pub fn stored_on(
        context: &Context,
        surface: &Surface,
        document: &Document,
        name: &str,
        budget: u64,
        pages: Option<&Arc<dyn PageStore>>,
    ) -> Result<Option<Self>> {
        let stored = Self::stored_with(context, surface.topology().clone(), document, name, budget, pages)?;
        Ok(stored.map(|channel| channel.framed(surface)))
    }

    fn framed(mut self, surface: &Surface) -> Self {
        self.field.frames = Some(Arc::new(Frames::new(surface)));
        self
    }
}
