//! USD in a build without the feature `openusd`: every function fails and names it.

use std::convert::Infallible;
use std::path::Path;

use relievo_core::{Error, Result};

use crate::gltf::glb_writer::Instance;
use crate::instancers::PointInstancer;
use crate::model::Model;
use crate::root::Root;
use crate::stage_options::StageOptions;

fn absent() -> Error {
    Error::unsupported("this build reads and writes no USD")
        .advise("build with the feature `openusd`, or use OBJ, PLY or glTF")
}

/// Fails.
pub fn read_usd(_: Vec<u8>, _: u64, _: &Path, _: &Root) -> Result<Model> {
    Err(absent())
}

/// Fails.
pub fn read_usd_instancers(_: Vec<u8>, _: u64, _: &Path, _: &Root) -> Result<Vec<PointInstancer>> {
    Err(absent())
}

/// Fails.
pub fn write_usd(_: &Path, _: &[Instance], _: &StageOptions) -> Result<()> {
    Err(absent())
}

/// Collects the frames of a stage. It has no value in this build.
#[derive(Debug)]
pub struct StageWriter(Infallible);

impl StageWriter {
    /// Fails.
    pub fn new(_: &StageOptions, _: u64) -> Result<Self> {
        Err(absent())
    }

    /// Returns the number of frames.
    pub fn frames(&self) -> usize {
        match self.0 {}
    }

    /// Adds a frame.
    pub fn frame(&mut self, _: f64, _: &[Instance]) -> Result<()> {
        match self.0 {}
    }

    /// Writes the stage.
    pub fn finish(self, _: &Path) -> Result<()> {
        match self.0 {}
    }
}
