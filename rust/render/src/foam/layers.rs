//! The layers of foam, each of which compositors can grade by itself.

use std::sync::Arc;

use relievo_gpu::PassTime;

use super::depth::normal;
use super::device::DeviceLayers;
use super::occlusion::shadow;
use super::projection::{FoamView, Projection};
use super::scenery::Depths;
use super::settings::FoamSettings;
use crate::files::exr_file::{Channel, Layer, Samples};

/// The nearest fragments of all pixels, row after row.
#[derive(Clone, Debug)]
pub struct Surfaces {
    /// Depth in metres, infinite where nothing is.
    pub depth: Vec<f32>,
    /// Search radius in pixels.
    pub search: Vec<f32>,
    /// Where on the disc of its sprite it is, which gives the normal.
    pub disc: Vec<[f32; 2]>,
}

/// What foam is shaded from.
pub struct Shading<'a> {
    pub settings: &'a FoamSettings,
    pub view: &'a FoamView,
    pub projection: &'a Projection,
    pub depths: &'a Depths,
    pub surfaces: &'a Surfaces,
    /// Intensities of all pixels.
    pub intensity: &'a [f32],
}

/// The layers of a picture of foam, row after row from the top.
#[derive(Clone, Debug)]
pub struct FoamLayers {
    pub(super) settings: FoamSettings,
    pub(super) view: FoamView,
    pub(super) projection: Projection,
    pub(super) surfaces: Surfaces,
    pub(super) thickness: Vec<f32>,
    pub(super) intensity: Vec<f32>,
    pub(super) occlusion: Vec<f32>,
    pub(super) irradiance: Vec<[f32; 3]>,
    /// What a graphics device has of them, if it made them.
    pub(super) device: Option<Arc<DeviceLayers>>,
}

impl FoamLayers {
    /// Returns pixels in a row and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.view.width, self.view.height]
    }

    /// Returns the depth of the nearest particle of each pixel in metres, infinite where there is none.
    pub fn depth(&self) -> &[f32] {
        &self.surfaces.depth
    }

    /// Returns the search radius of each pixel, in pixels.
    pub fn search_radius(&self) -> &[f32] {
        &self.surfaces.search
    }

    /// Returns the unit normal of the nearest particle of a pixel in the world, by the number of the pixel; zero where there
    /// is none or no such pixel.
    pub fn normal(&self, pixel: usize) -> [f32; 3] {
        match self.surfaces.disc.get(pixel) {
            Some([u, v]) if self.surfaces.depth[pixel].is_finite() => self.projection.to_world(normal(*u, *v)).into(),
            _ => [0.0; 3],
        }
    }

    /// Returns the thickness ρ of each pixel.
    pub fn thickness(&self) -> &[f32] {
        &self.thickness
    }

    /// Returns the intensity ι of each pixel, 0 to 1.
    pub fn intensity(&self) -> &[f32] {
        &self.intensity
    }

    /// Returns the occlusion ω of each pixel, 0 to 1.
    pub fn occlusion(&self) -> &[f32] {
        &self.occlusion
    }

    /// Returns the shadow ζ of a pixel before it is filtered, 0 to 1.
    pub(super) fn shadow(&self, pixel: usize) -> f32 {
        shadow(&self.settings, self.occlusion[pixel])
    }

    /// Returns the irradiance of each pixel.
    pub fn irradiance(&self) -> &[[f32; 3]] {
        &self.irradiance
    }

    /// Returns how long the passes took on the graphics device that made the layers, by its own clock: those of all chunks
    /// together. The list is empty if the processor made the layers, or the device does not time passes.
    pub fn times(&self) -> Vec<PassTime> {
        self.device.as_ref().map_or_else(Vec::new, |device| device.times())
    }

    /// Returns the layers as one of an EXR file: `foam.intensity`, `foam.thickness`, `foam.depth`, `foam.normal.X`, `Y` and
    /// `Z`, `foam.occlusion`, `foam.irradiance.R`, `G` and `B`.
    pub fn exr_layer(&self) -> Layer {
        let channel =
            |name: &str, values: Vec<f32>| Channel { name: format!("foam.{name}"), samples: Samples::F32(values) };
        let mut channels = vec![
            channel("intensity", self.intensity.clone()),
            channel("thickness", self.thickness.clone()),
            channel("depth", self.surfaces.depth.clone()),
            channel("occlusion", self.occlusion.clone()),
        ];
        for (axis, name) in ["normal.X", "normal.Y", "normal.Z"].into_iter().enumerate() {
            channels.push(channel(name, (0..self.view.pixels()).map(|pixel| self.normal(pixel)[axis]).collect()));
        }
        for (part, name) in ["irradiance.R", "irradiance.G", "irradiance.B"].into_iter().enumerate() {
            channels.push(channel(name, self.irradiance.iter().map(|value| value[part]).collect()));
        }
        Layer { name: None, width: self.view.width, height: self.view.height, channels, attributes: Vec::new() }
    }
}
