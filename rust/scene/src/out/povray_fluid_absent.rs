//! Fluids in scenes for POV-Ray in a build without the feature `fluid`, which has no fluids.

use std::io::Write;

use relievo_core::{Context, Result};

use crate::out::output::Folder;
use crate::state::isosurface::FluidEntry;

/// A fluid as it is written, of which there is none.
pub(crate) enum PovrayFluid {}

impl PovrayFluid {
    /// Returns nothing, since there is no fluid.
    pub fn new(_: &Context, _: &FluidEntry, _: &[[f32; 3]]) -> Result<Option<Self>> {
        Ok(None)
    }

    /// Stores nothing.
    pub fn store(&mut self, _: &Folder, _: &str, _: u32) -> Result<()> {
        match *self {}
    }

    /// Writes nothing.
    pub fn declare(&self, _: &mut impl Write) -> std::io::Result<()> {
        match *self {}
    }

    /// Writes nothing.
    pub fn write(&self, _: &mut impl Write) -> std::io::Result<()> {
        match *self {}
    }
}
