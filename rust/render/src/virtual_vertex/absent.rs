//! The rasteriser of a build without the feature `wgpu`, which has no device to draw on.

use std::convert::Infallible;
use std::time::Duration;

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Charge, Device};

use super::patches::{DrawCall, Storage};
use super::placed::Placed;
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
