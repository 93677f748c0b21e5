//! A perspective camera. Its position is in f64, and rays start at the origin of a space that moves with it, so that
//! scenes far from the origin keep their precision.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::{Error, Result};

/// A perspective camera that looks along −z of its own space, with x to the right and y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: DVec3,
    /// Columns: right, up, and against the direction of view, of unit length.
    pub axes: DMat3,
    /// Vertical field of view, radians, above 0 and at most 175 degrees.
    pub fov: f64,
}

/// The widest field of view: a plane that is wider shows nothing but its border.
const MAX_FOV: f64 = 175.0 / 180.0 * std::f64::consts::PI;

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` as near to upwards as that allows.
    ///
    /// # Errors
    /// A number is not finite, the view has no direction or is along `up`, or `fov` is out of range.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov: f64) -> Result<Self> {
        let back = (eye - target).try_normalize();
        let right = back.and_then(|back| up.cross(back).try_normalize());
        let (Some(back), Some(right)) = (back, right) else {
            return Err(Error::invalid("the camera has no direction of view")
                .advise("place its target away from it, and not straight along the up direction"));
        };
        Self::new(eye, DMat3::from_cols(right, back.cross(right), back), fov)
    }

    /// A camera placed by a matrix from its space to the world. Scale in the matrix is ignored.
    ///
    /// # Errors
    /// The matrix is singular or not finite, or `fov` is out of range.
    pub fn from_matrix(to_world: DAffine3, fov: f64) -> Result<Self> {
        let [x, y, z] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
        let back = z.try_normalize();
        let right = back.and_then(|back| y.cross(back).try_normalize());
        match (back, right) {
            (Some(back), Some(right)) if right.dot(x) > 0.0 => {
                Self::new(to_world.translation, DMat3::from_cols(right, back.cross(right), back), fov)
            }
            _ => Err(Error::invalid("the camera's matrix is singular or mirrors")),
        }
    }

    fn new(eye: DVec3, axes: DMat3, fov: f64) -> Result<Self> {
        if !(eye.is_finite() && axes.is_finite()) {
            return Err(Error::invalid("the camera's position is not finite"));
        }
        if !(fov > 0.0 && fov <= MAX_FOV) {
            return Err(Error::invalid(format!("the camera's field of view is {} degrees", fov.to_degrees()))
                .advise("use more than 0 and at most 175 degrees"));
        }
        Ok(Self { eye, axes, fov })
    }

    /// The rays of a picture of `width` × `height` pixels.
    pub(crate) fn rays(&self, width: u32, height: u32) -> Rays {
        let half = (0.5 * self.fov).tan();
        let pixel = 2.0 * half / f64::from(height);
        let [right, up, back] = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis];
        let corner = up * half - right * (0.5 * pixel * f64::from(width)) - back;
        Rays { corner: corner.as_vec3(), dx: (right * pixel).as_vec3(), dy: (up * -pixel).as_vec3() }
    }
}

/// Directions through the places of a picture, whose part along the view has length 1: distances along them are depths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays {
    corner: Vec3,
    /// How the direction changes per pixel to the right.
    pub dx: Vec3,
    /// How it changes per pixel down.
    pub dy: Vec3,
}

impl Rays {
    /// The direction through (x, y), in pixels from the top left corner of the picture.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.corner + self.dx * x + self.dy * y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_the_picture_is_the_direction_of_view() {
        let camera = Camera::look_at(DVec3::new(1e7, 2.0, 3.0), DVec3::new(1e7, 7.0, 3.0), DVec3::Z, 1.0).unwrap();
        let rays = camera.rays(64, 32);
        assert!((rays.direction(32.0, 16.0) - Vec3::Y).length() < 1e-6);
        let top = rays.direction(32.0, 0.0);
        assert!((top.angle_between(Vec3::Y) - 0.5).abs() < 1e-6 && top.z > 0.0);
        assert!(rays.direction(64.0, 16.0).x > 0.0, "x runs to the right");
    }

    #[test]
    fn a_matrix_and_look_at_agree_and_bad_ones_are_refused() {
        let camera = Camera::look_at(DVec3::new(4.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 0.7).unwrap();
        let matrix = DAffine3::from_mat3_translation(camera.axes * 3.0, camera.eye);
        let again = Camera::from_matrix(matrix, 0.7).unwrap();
        assert!(again.axes.abs_diff_eq(camera.axes, 1e-12));
        assert!(Camera::from_matrix(DAffine3::ZERO, 0.7).is_err());
        assert!(Camera::look_at(DVec3::Y, DVec3::ZERO, DVec3::Y, 0.7).is_err());
        assert!(Camera::look_at(DVec3::X, DVec3::ZERO, DVec3::Y, 4.0).is_err());
        assert!(Camera::look_at(DVec3::NAN, DVec3::ZERO, DVec3::Y, 0.7).is_err());
    }
}
