//! Foam in a build without the feature `fluid`: no fluid has any.

use relievo_core::{Context, Parameter, Result};
use relievo_render::{Frame, Image, ObjectId, View};

use crate::world::World;

/// The parameters of particles of foam, of which there are no.
pub(crate) const PARAMETERS: &[Parameter] = &[];

/// The foam of all fluids of a scene that have some.
#[derive(Debug)]
pub(crate) struct Overlay;

impl Overlay {
    /// Makes no foam.
    pub fn new(_: &World) -> Result<Self> {
        Ok(Self)
    }

    /// Returns that no fluid has foam.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// Draws nothing.
    pub fn draw(
        &mut self,
        _: &Context,
        _: (&View, usize),
        _: &[Option<ObjectId>],
        _: &Image,
        _: &mut Frame,
    ) -> Result<()> {
        Ok(())
    }
}
