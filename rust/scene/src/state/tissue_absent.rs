//! Soft tissue in a build without the feature `tissue`: a mesh of it is an error.

use std::path::Path;

use glam::DAffine3;
use relievo_core::{Context, Error, Mesh, Result};

use crate::format::description::{Scene, TissueEntry};
use crate::out::output::Folder;
use crate::state::paths::Paths;
use crate::state::physics::Physics;

/// A bound surface of a model, of which there is none.
#[derive(Debug)]
pub(crate) enum TissueSurface {}

impl TissueSurface {
    /// Fails.
    pub fn read(_: &Context, path: &Path, _: Option<&str>, _: DAffine3) -> Result<Self> {
        Err(absent().at(path.display().to_string()))
    }

    /// Returns nothing, since there is no surface.
    pub fn mesh(&self, _: &Context, _: &Path) -> Result<Mesh> {
        match *self {}
    }
}

/// Tissue that a scene simulates, of which there is none.
#[derive(Debug)]
pub(crate) enum Tissue {}

/// An object that tissue meets, and its mesh at time 0.
pub(crate) type Solid = (usize, Mesh);

impl Tissue {
    /// Fails.
    pub fn read(_: &Context, _: &Scene, _: &Paths, _: &TissueEntry, _: DAffine3) -> Result<Self> {
        Err(absent())
    }

    /// Meets nothing, since there is no tissue.
    pub fn meet(&mut self, _: &Context, _: (&Scene, &TissueEntry), _: Physics, _: DAffine3, _: &[Solid]) -> Result<()> {
        match *self {}
    }

    /// Keeps nothing, since there is no tissue.
    pub fn keep(&mut self, _: &Folder) -> Result<()> {
        match *self {}
    }

    /// Finds nothing, since there is no tissue.
    pub fn bound(&self, _: Option<&str>) -> Result<usize> {
        match *self {}
    }

    /// Returns nothing, since there is no tissue.
    pub fn mesh(&self, _: &Context, _: usize) -> Mesh {
        match *self {}
    }

    /// Returns nothing, since there is no tissue.
    pub fn last(&self) -> u32 {
        match *self {}
    }

    /// Returns nothing, since there is no tissue.
    pub fn checksums(&self) -> &[u32] {
        match *self {}
    }

    /// Returns nothing, since there is no tissue.
    pub fn take_notes(&mut self) -> Vec<String> {
        match *self {}
    }

    /// Returns nothing, since there is no tissue.
    pub fn points(&mut self, _: &Context, _: usize, _: u32) -> Result<Vec<[f32; 3]>> {
        match *self {}
    }
}

fn absent() -> Error {
    Error::unsupported("this build has no soft tissue").advise("build with the feature `tissue`")
}

/// Removes nothing: a build without soft tissue has no frames of it.
pub(crate) fn truncate(_: &Folder, _: u32) -> Result<()> {
    Ok(())
}
