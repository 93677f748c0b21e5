//! Foam in a build without the feature `fluid`: no fluid has any.

use relievo_core::{Context, Parameter, Result};
use relievo_gpu::Device;
use relievo_render::{Frame, Image, ObjectId, View};

use crate::out::output::Folder;
use crate::state::world::World;

/// The parameters of particles of foam, of which there are no.
pub(crate) const PARAMETERS: &[Parameter] = &[];

/// Removes no frames from the cache of a scene, which has none of foam.
pub(crate) fn truncate(_: &Folder, _: u32) -> Result<()> {
    Ok(())
}

/// The foam of all fluids of a scene that have some.
#[derive(Debug)]
pub(crate) struct Overlay;

impl Overlay {
    /// Makes no foam.
    pub fn new(_: &Context, _: &World, _: Option<&Device>, _: &Folder) -> Result<Self> {
        Ok(Self)
    }

    /// Returns that no fluid has foam.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// Returns nothing that the user should know.
    pub fn take_notes(&mut self) -> Vec<String> {
        Vec::new()
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
