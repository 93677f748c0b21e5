//! Crowds in a build without the feature `crowd`: one in a scene is an error.

use relievo_core::{Context, Error, Result};
use relievo_render as render;

use crate::format::description::{CrowdEntry, Scene};
use crate::state::paths::Paths;

/// A crowd of a scene, of which there is none.
#[derive(Debug)]
pub(crate) enum Loaded {}

impl Loaded {
    /// Fails.
    pub fn new(_: &Context, _: &Paths, _: &Scene, _: &CrowdEntry) -> Result<Self> {
        Err(Error::unsupported("this build has no crowds").advise("build with the feature `crowd`"))
    }
}

/// A crowd in pictures, of which there is none.
#[derive(Debug)]
pub(crate) enum Shown {}

impl Shown {
    /// Returns nothing, since there is no crowd.
    pub fn new(loaded: &Loaded) -> Result<Self> {
        match *loaded {}
    }

    /// Draws nothing, since there is no crowd.
    pub fn draw(
        &mut self,
        _: &Context,
        _: (&Loaded, &CrowdEntry),
        _: (&render::View, f64),
        _: u32,
        _: &mut render::Scene,
    ) -> Result<u64> {
        match *self {}
    }
}
