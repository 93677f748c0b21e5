//! How a surface by itself is shown: a camera that has all of it in view, and two suns without a sky, which every
//! renderer has alike.

use glam::DVec3;
use relievo_core::Result;
use relievo_render::{Camera, Lights, Material, Sky, Sun};

use crate::description::Up;
use crate::picture::whole_view;

/// The vertical field of view, radians.
const FOV: f64 = 0.5;

/// By how much the camera is nearer than what shows all of the sphere around it.
const NEARER: f64 = 0.74;

/// The camera, the light and the material of a surface that is shown by itself.
#[derive(Clone, Debug)]
pub struct Showing {
    /// The camera.
    pub camera: Camera,
    /// Light from the front and, weaker, from the side.
    pub lights: Lights,
    /// What it is made of.
    pub material: Material,
    /// Smallest and largest coordinates.
    pub bounds: (DVec3, DVec3),
    /// Pixels along x and y.
    pub size: [u32; 2],
}

impl Showing {
    /// Of what is within `bounds`, on a picture of `size` pixels.
    ///
    /// # Errors
    /// The bounds are not finite.
    pub fn new((low, high): ([f32; 3], [f32; 3]), up: Up, size: [u32; 2]) -> Result<Self> {
        let bounds = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
        let (eye, target) = whole_view(Some(bounds.into()), FOV, aspect, up);
        // Little of the sphere around it is filled.
        let eye = target + (eye - target) * NEARER;
        let sun = |direction: [f32; 3], irradiance: f32| Sun {
            direction: up.from_z_up(direction),
            irradiance: [irradiance; 3],
            angular_radius: 0.0,
        };
        Ok(Self {
            camera: Camera::look_at(eye, target, up.direction(), FOV)?,
            lights: Lights {
                suns: vec![sun([0.1, -0.7, 0.7], 2.6), sun([0.9, 0.1, 0.35], 0.8)],
                sky: Sky { up: up.direction().as_vec3().to_array(), ..Sky::uniform([0.0; 3]) },
            },
            material: Material { base_color: [0.62, 0.24, 0.12], specular: 0.0, roughness: 0.4 },
            bounds: bounds.into(),
            size,
        })
    }
}
