//! From where a crowd is seen, and how finely.

use glam::{DMat3, DVec3};
use relievo_core::{Error, Result};

/// A view of a crowd in perspective.
#[derive(Clone, Debug, PartialEq)]
pub struct CrowdView {
    /// Where it is seen from.
    pub eye: [f32; 3],
    /// Pixels of what has the length of its distance: half the height of the picture by the tangent of half the angle.
    pub pixels: f32,
    /// Error that may be seen, in pixels, above 0. The paper uses 0.5.
    pub tolerance: f32,
    /// What is seen: all that has n · p + d ≥ 0 for each n and d, with n of length 1. None for everything.
    pub planes: Vec<[f32; 4]>,
    /// Whether vertices move from cut to cut as the view does, so that nothing jumps. Of use above a pixel of error; every
    /// agent in view is then cut group by group.
    pub geomorph: bool,
    /// Whether agents are drawn as [`Impostor`](crate::Impostor)s where these hold the error.
    pub impostors: bool,
}

impl Default for CrowdView {
    fn default() -> Self {
        Self { eye: [0.0; 3], pixels: 1000.0, tolerance: 0.5, planes: Vec::new(), geomorph: false, impostors: false }
    }
}

impl CrowdView {
    /// Makes the view of a camera at `eye` whose axes point right, up and against the direction of view. `fov` is the
    /// vertical angle in radians.
    ///
    /// # Errors
    /// A number is not finite or out of range.
    pub fn perspective(eye: DVec3, axes: DMat3, fov: f64, [width, height]: [u32; 2], tolerance: f32) -> Result<Self> {
        let half = (0.5 * fov).tan();
        let wide = half * f64::from(width) / f64::from(height);
        let [right, up, back] = [axes.x_axis, axes.y_axis, axes.z_axis];
        let plane = |normal: DVec3| {
            let normal = normal.normalize();
            [normal.x as f32, normal.y as f32, normal.z as f32, -normal.dot(eye) as f32]
        };
        let planes = vec![
            plane(-back),
            plane(right - back * wide),
            plane(-right - back * wide),
            plane(up - back * half),
            plane(-up - back * half),
        ];
        let pixels = (0.5 * f64::from(height) / half) as f32;
        let view = Self { eye: eye.as_vec3().to_array(), pixels, tolerance, planes, ..Self::default() };
        view.check()?;
        Ok(view)
    }

    /// Checks that places are finite and sizes above 0.
    ///
    /// # Errors
    /// Says what is out of range.
    pub fn check(&self) -> Result<()> {
        let finite = self.eye.iter().chain(self.planes.as_flattened()).all(|value| value.is_finite());
        if !finite || !(self.pixels > 0.0 && self.pixels.is_finite()) {
            return Err(Error::invalid("the view is not finite or has no size").at("view"));
        }
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return Err(Error::invalid(format!("the error is {} pixels", self.tolerance))
                .at("view")
                .advise("use a number above 0, 0.5 for errors that are not seen"));
        }
        Ok(())
    }
}
