//! Soft tissue in a build without the feature `tissue`: a mesh of it is an error.

use std::path::Path;

use glam::DAffine3;
use relievo_core::{Context, Error, Mesh, Result};

/// A bound surface of a model, of which there is none.
#[derive(Debug)]
pub enum TissueSurface {}

impl TissueSurface {
    /// Fails.
    pub fn read(_: &Context, path: &Path, _: Option<&str>, _: DAffine3) -> Result<Self> {
        Err(Error::unsupported("this build has no soft tissue")
            .at(path.display().to_string())
            .advise("build with the feature `tissue`"))
    }

    /// Returns nothing, since there is no surface.
    pub fn mesh(&self, _: &Context, _: &Path) -> Result<Mesh> {
        match *self {}
    }
}
