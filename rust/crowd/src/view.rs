//! From where a crowd is seen, and how finely.

use glam::{DMat3, DVec3, DVec4};
use relievo_core::{Error, Result};

use crate::crowd::Crowd;

/// Planes of a view with shadows at most.
const MAX_PLANES: usize = 48;
/// Angular radius of a sun, in radians, from which its light comes from everywhere.
const WIDE: f64 = 1.4;
/// Relative rounding of planes.
const ROUNDING: f64 = 1e-6;
/// Halvings of an interval in which a plane is searched for.
const HALVINGS: usize = 40;

/// A sun that throws shadows into a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSun {
    /// The direction towards it, of any length.
    pub towards: [f32; 3],
    /// Half its angular diameter, radians.
    pub angular_radius: f32,
}

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

    /// Returns a view that sees in addition whatever throws shadows into this one: all that lies from there towards suns, and
    /// all that is at most `around` away, which may hide a part of the sky. Some of what it sees throws none.
    pub fn with_shadows(&self, suns: &[ShadowSun], around: f32) -> Self {
        let mut planes: Vec<DVec4> =
            self.planes.iter().map(|plane| DVec4::from(plane.map(f64::from)) + DVec4::W * f64::from(around)).collect();
        for sun in suns {
            let away = -DVec3::from(sun.towards.map(f64::from)).normalize_or_zero();
            planes = swept(&planes, away, f64::from(sun.angular_radius));
        }
        let plane = |plane: DVec4| {
            let rounding = if suns.is_empty() { 0.0 } else { ROUNDING * plane.w.abs() };
            (plane + DVec4::W * rounding).as_vec4().to_array()
        };
        Self { planes: planes.into_iter().map(plane).collect(), ..self.clone() }
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

impl Crowd {
    /// Returns the largest radius of a sphere that an agent does not leave.
    pub fn largest_radius(&self) -> f32 {
        self.reaches().0.iter().map(|reach| reach.radius).fold(0.0, f32::max)
    }
}

/// Returns planes around what planes enclose and all from which light in a direction, or in one that is at most `radius` from it,
/// goes there: planes that such light does not enter by, and through the common line of one of these and one of the others a plane
/// that it runs along.
fn swept(planes: &[DVec4], away: DVec3, radius: f64) -> Vec<DVec4> {
    if away == DVec3::ZERO {
        return planes.to_vec();
    }
    if radius > WIDE {
        return Vec::new();
    }
    // Light enters by no plane whose normal is so far against it.
    let limit = -radius.max(0.0).sin();
    let is_left = |plane: &DVec4| plane.truncate().dot(away) <= limit * plane.truncate().length();
    let (mut made, entered): (Vec<DVec4>, Vec<DVec4>) = planes.iter().partition(|plane| is_left(plane));
    let left = made.clone();
    for (left, entered) in left.iter().flat_map(|left| entered.iter().map(move |entered| (left, entered))) {
        if made.len() >= MAX_PLANES {
            break;
        }
        let between = |share: f64| *entered + share * (*left - *entered);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_left(&between(middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let plane = between(high);
        let length = plane.truncate().length();
        // Planes that face one another have no common line.
        if length > 1e-6 {
            made.push(plane / length);
        }
    }
    made
}
