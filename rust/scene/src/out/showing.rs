//! How a surface by itself is shown: a camera that has all of it in view, and two suns without a sky, which every
//! renderer has alike.

use glam::DVec3;
use relievo_core::Result;
use relievo_render::{Camera, Lights, Material, Sky, Sun};

use crate::format::placement::Up;
use crate::out::picture::whole_view;

/// The vertical field of view, radians.
const FOV: f64 = 0.5;

/// How much of the picture's width or height the box around it takes.
const FILLED: f64 = 0.96;

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
        let eye = target + (eye - target).normalize_or(DVec3::Y) * distance(bounds, eye, target, aspect, up)?;
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

/// How far from `target`, on the side of `eye`, a camera has all corners of a box within [`FILLED`] of its picture.
fn distance([low, high]: [DVec3; 2], eye: DVec3, target: DVec3, aspect: f64, up: Up) -> Result<f64> {
    let axes = Camera::look_at(eye, target, up.direction(), FOV)?.axes;
    let half = FILLED * (0.5 * FOV).tan();
    let needed = |at: u32| {
        let pick = |axis: usize| if at >> axis & 1 == 1 { high[axis] } else { low[axis] };
        let corner = axes.transpose() * (DVec3::new(pick(0), pick(1), pick(2)) - target);
        corner.z + (corner.x.abs() / (half * aspect)).max(corner.y.abs() / half)
    };
    Ok((0..8).map(needed).fold(1e-6, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_of_any_shape_are_in_view_with_a_margin() {
        for high in [[1.0, 1.0, 1.0], [9.0, 1.0, 0.1], [0.1, 0.2, 7.0]] {
            for size in [[640, 480], [100, 400]] {
                let showing = Showing::new(([0.0; 3], high), Up::Z, size).unwrap();
                let camera = showing.camera;
                let half = (0.5 * camera.fov).tan();
                let aspect = f64::from(size[0]) / f64::from(size[1]);
                let mut most = 0.0f64;
                for at in 0..8 {
                    let pick = |axis: usize| if at >> axis & 1 == 1 { f64::from(high[axis]) } else { 0.0 };
                    let p = camera.axes.transpose() * (DVec3::new(pick(0), pick(1), pick(2)) - camera.eye);
                    most = most.max((p.x / (p.z * half * aspect)).abs()).max((p.y / (p.z * half)).abs());
                }
                assert!((most - FILLED).abs() < 1e-9, "{high:?} {size:?}: {most}");
            }
        }
    }
}
