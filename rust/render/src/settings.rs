//! What a picture is made with, apart from the scene, the camera and the light.

use glam::{DAffine3, DVec3};
use relievo_core::parameter::Switch;
use relievo_core::{Error, Result};
use relievo_surface::bezier::Viewpoint;

use crate::camera::Camera;
use crate::color::Color;
use crate::light::Lights;

relievo_core::parameters! {
    /// Size and quality of a picture.
    pub struct Settings {
        /// Pixels in a row.
        width: u32 = 640, 1..=16384, "px";
        /// Rows.
        height: u32 = 360, 1..=16384, "px";
        /// Rays from the camera per pixel.
        samples: u32 = 4, 1..=1024, "";
        /// Rays to the sky per ray from the camera; 0 lights without looking for what is in the way.
        sky_rays: u32 = 1, 0..=256, "";
        /// Radius in which neighbouring pixels share what they know of the sky; 0 for none.
        sky_filter: u32 = 3, 0..=16, "px";
        /// Whether suns throw shadows.
        shadows: Switch = Switch::ON, 0..=1, "";
        /// Whether the edges of triangles are drawn.
        wireframe: Switch = Switch::OFF, 0..=1, "";
        /// Width of those lines.
        line_width: f32 = 1.0, 0.1..=16, "px";
        /// How much of a false colour covers the material, where there is one.
        false_color: f32 = 0.75, 0..=1, "";
    }
}

/// Colours that stand for the tags of triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct FalseColor {
    /// Colour of tag 0, 1, …; larger tags start again from the first.
    pub palette: Vec<Color>,
}

/// All a picture of a scene depends on.
#[derive(Clone, Debug)]
pub struct View {
    /// From where.
    pub camera: Camera,
    /// The light.
    pub lights: Lights,
    /// Size and quality.
    pub settings: Settings,
    /// Opening and close of the shutter in seconds, by which implicit surfaces that move are blurred.
    pub shutter: [f32; 2],
    /// Colours for the tags of triangles, in place of the materials' colours.
    pub false_color: Option<FalseColor>,
    /// Colour of the wireframe.
    pub line_color: Color,
}

impl View {
    /// A view with the default light and settings.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            lights: Lights::default(),
            settings: Settings::default(),
            shutter: [0.0; 2],
            false_color: None,
            line_color: [0.01, 0.012, 0.02],
        }
    }

    /// Returns the view with no more than depths need: one ray a pixel, and no light of the sky or shadows.
    pub fn for_depths(&self) -> Self {
        let settings = Settings { samples: 1, sky_rays: 0, sky_filter: 0, shadows: Switch::OFF, ..self.settings };
        Self { settings, false_color: None, ..self.clone() }
    }

    /// From where levels and rates of what `transform` places are chosen.
    pub fn viewpoint(&self, transform: &DAffine3) -> Viewpoint {
        let half = (0.5 * self.camera.fov).tan();
        let [width, height] = [self.settings.width, self.settings.height].map(f64::from);
        // Distances in the object's space are shorter by the scale of its longest axis.
        let linear = transform.matrix3;
        let scale =
            [linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| axis.length()).into_iter().fold(0.0, f64::max);
        let back = transform.inverse();
        let forward = back.transform_vector3(-self.camera.axes.z_axis);
        Viewpoint {
            eye: back.transform_point3(self.camera.eye).to_array(),
            forward: forward.normalize_or(DVec3::NEG_Z).to_array(),
            pixels: 0.5 * height / half * (scale * forward.length()).max(1.0),
            corner: half * (1.0 + (width / height).powi(2)).sqrt(),
        }
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.settings.check()?;
        self.lights.check()?;
        let [open, close] = self.shutter;
        if !(open.is_finite() && close.is_finite() && open <= close) {
            return Err(Error::invalid(format!("the shutter is open from {open} to {close}"))
                .advise("use finite times, the first not after the second"));
        }
        let finite = |color: &Color| color.iter().all(|value| value.is_finite());
        let palette = self
            .false_color
            .as_ref()
            .is_none_or(|colors| !colors.palette.is_empty() && colors.palette.iter().all(finite));
        if palette && finite(&self.line_color) {
            return Ok(());
        }
        Err(Error::invalid("a palette is empty or has colours that are not finite"))
    }
}
