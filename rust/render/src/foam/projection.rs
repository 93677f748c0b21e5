//! From the world to the picture and back, for perspective and orthographic cameras.

use glam::{DVec3, Mat3, Vec2, Vec3};
use relievo_core::{Error, Result};

use crate::camera::Camera;

/// How a camera projects.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lens {
    /// By the field of view of the camera.
    #[default]
    Perspective,
    /// In parallel; the picture is so many metres high.
    Orthographic(f64),
}

/// From where foam is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamView {
    /// Position and direction, and the field of view of a perspective lens.
    pub camera: Camera,
    /// How it projects.
    pub lens: Lens,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Pixels along a side at most.
const MAX_SIDE: u32 = 1 << 14;

impl FoamView {
    /// Checks the size and the lens.
    ///
    /// # Errors
    /// Fails with `Invalid` if the picture has no pixels or too many, or an orthographic one no height.
    pub fn check(&self) -> Result<()> {
        let Self { width, height, .. } = *self;
        if width == 0 || height == 0 || width.max(height) > MAX_SIDE {
            return Err(Error::invalid(format!("a picture of foam cannot have {width} × {height} pixels"))
                .advise(format!("use 1 to {MAX_SIDE} along each side")));
        }
        match self.lens {
            Lens::Orthographic(height) if !(height > 0.0 && height.is_finite()) => {
                Err(Error::invalid(format!("an orthographic picture cannot be {height} m high"))
                    .advise("use a height above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Places in eye space: metres to the right of the camera, above it, and along its direction of view.
#[derive(Clone, Debug)]
pub struct Projection {
    eye: DVec3,
    /// Columns: right, up, and against the direction of view.
    pub(super) axes: Mat3,
    pub(super) middle: Vec2,
    /// Pixels of a metre at a depth of 1 m, or at any depth.
    pub(super) scale: f32,
    pub(super) is_parallel: bool,
}

impl Projection {
    /// Makes the projection of a view.
    pub fn new(view: &FoamView) -> Self {
        let height = f64::from(view.height);
        let (scale, is_parallel) = match view.lens {
            Lens::Perspective => (0.5 * height / (0.5 * view.camera.fov).tan(), false),
            Lens::Orthographic(metres) => (height / metres, true),
        };
        Self {
            eye: view.camera.eye,
            axes: view.camera.axes.as_mat3(),
            middle: 0.5 * Vec2::new(view.width as f32, view.height as f32),
            scale: scale as f32,
            is_parallel,
        }
    }

    /// Returns a place of the world in eye space.
    #[inline]
    pub fn to_eye(&self, position: [f32; 3]) -> Vec3 {
        // The difference is taken in f64, so that scenes far from the origin keep their precision.
        let from = (Vec3::from(position).as_dvec3() - self.eye).as_vec3();
        Vec3::new(self.axes.x_axis.dot(from), self.axes.y_axis.dot(from), -self.axes.z_axis.dot(from))
    }

    /// Returns the pixels of a metre at a depth.
    #[inline]
    pub fn scale(&self, depth: f32) -> f32 {
        if self.is_parallel { self.scale } else { self.scale / depth }
    }

    /// Returns where a place in eye space is in the picture, in pixels from its top left corner.
    #[inline]
    pub fn to_picture(&self, place: Vec3) -> Vec2 {
        let scale = self.scale(place.z);
        Vec2::new(self.middle.x + scale * place.x, self.middle.y - scale * place.y)
    }

    /// Returns the place in eye space at a depth behind (x, y) of the picture.
    #[inline]
    pub fn from_picture(&self, x: f32, y: f32, depth: f32) -> Vec3 {
        let metres = self.scale(depth).recip();
        Vec3::new((x - self.middle.x) * metres, (self.middle.y - y) * metres, depth)
    }

    /// Returns a direction of the world of one whose parts are to the right, up and towards the camera.
    #[inline]
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.axes * direction
    }
}
