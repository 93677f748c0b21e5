//! The rasteriser of a build without the feature `wgpu`, which has no device to draw on.

use std::convert::Infallible;
use std::time::Duration;

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Charge, Device, Frame as Commands};

use super::patches::{DrawCall, Storage};
use super::placed::{Placed, PosedMesh};
use crate::camera::Camera;
use crate::frame::Frame;
use crate::settings::View;

/// Draws virtual vertices. It has no value in this build.
#[derive(Debug)]
pub struct Rasterizer(Infallible);

impl Rasterizer {
    /// Fails.
    pub fn new(_: &Device) -> Result<Self> {
        Err(Error::unsupported("this build draws on no graphics device").advise("build with the feature `wgpu`"))
    }

    /// Draws a picture of objects and reads it back.
    pub fn render(&mut self, _: &[Placed<'_>], _: &View) -> Result<Frame> {
        match self.0 {}
    }

    /// Draws a picture into the device's memory and returns how long the device took.
    pub fn time(&mut self, _: &[Placed<'_>], _: &View, _: [u32; 2]) -> Result<Duration> {
        match self.0 {}
    }
}

/// Draws depths into a buffer. It has no value in this build.
#[derive(Debug)]
pub struct DepthMap(Infallible);

impl DepthMap {
    /// Fails.
    pub fn new(_: &Device) -> Result<Self> {
        Err(Error::unsupported("this build draws on no graphics device").advise("build with the feature `wgpu`"))
    }

    /// Makes room for a picture.
    pub fn resize(&mut self, _: [u32; 2]) -> Result<()> {
        match self.0 {}
    }

    /// Records the depths of a mesh.
    pub fn record(&self, _: &mut Commands, _: &PosedMesh<'_>, _: &Camera) -> Result<f32> {
        match self.0 {}
    }

    /// Returns the depths.
    pub fn depths(&self) -> Option<&Buffer<f32>> {
        match self.0 {}
    }

    /// Returns how many numbers a row of the depths has.
    pub fn stride(&self) -> u32 {
        match self.0 {}
    }
}

/// The records of Bézier patches.
#[derive(Debug)]
pub(super) enum Records {
    Buffer(Buffer<[f32; 4]>),
}

impl Records {
    /// Writes records to a storage buffer.
    pub fn new(
        device: &Device,
        _: Storage,
        records: Vec<[f32; 4]>,
        _: &[DrawCall],
        _: u32,
    ) -> Result<(Self, Option<Charge>)> {
        Ok((Self::Buffer(Buffer::of(device, "patches", &records)?), None))
    }
}
