//! Crowds in a build without the feature `crowd`: one in a scene is an error.

use glam::DAffine3;
use relievo_core::{Context, Error, Result};
use relievo_detail::{Collider, Motion, Obb};
use relievo_render as render;

use crate::format::description::{CrowdColliderEntry, CrowdEntry, Scene};
use crate::state::paths::Paths;

/// A crowd of a scene, of which there is none.
#[derive(Debug)]
pub(crate) enum Loaded {}

impl Loaded {
    /// Fails.
    pub fn new(_: &Context, _: &Paths, _: &Scene, _: &CrowdEntry) -> Result<Self> {
        Err(Error::unsupported("this build has no crowds").advise("build with the feature `crowd`"))
    }

    /// Returns nothing, since there is no crowd.
    pub fn len(&self) -> usize {
        match *self {}
    }
}

/// A crowd whose agents press, of which there is none.
#[derive(Debug)]
pub(crate) enum Pressing {}

impl Pressing {
    /// Returns nothing, since there is no crowd.
    pub fn new(_: &Context, _: &Paths, (loaded, _): (&Loaded, &CrowdEntry), _: &CrowdColliderEntry) -> Result<Self> {
        match *loaded {}
    }

    /// Returns nothing, since there is no crowd.
    pub fn collider(&self) -> &Collider {
        match *self {}
    }

    /// Returns nothing, since there is no crowd.
    pub fn checksums(&self) -> [u32; 2] {
        match *self {}
    }

    /// Returns nothing, since there is no crowd.
    pub fn parts(&self, _: &Loaded, _: f64) -> u32 {
        match *self {}
    }

    /// Returns nothing, since there is no crowd.
    pub fn reach(&self, _: &Loaded, _: usize, _: [f64; 2], _: &DAffine3) -> Option<Obb> {
        match *self {}
    }

    /// Returns nothing, since there is no crowd.
    pub fn motion(&self, _: &Context, _: (&Loaded, usize), _: [f64; 2], _: &DAffine3) -> Result<(Collider, Motion)> {
        match *self {}
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
