//! Muscles as NURBS volumes: a surface that is closed around, shrunk to its central curve (Section 4.3, Figure 7).
//!
//! Around, the basis is cubic, uniform and periodic; along, clamped and of degree 3 or less. The third parameter runs
//! linearly from the surface at 0 to the central curve at 1. Fibres follow the derivative along the muscle (Equations 4
//! and 5).

use glam::{DMat3, DVec3, DVec4};
use relievo_core::{Error, Result};

/// A NURBS volume within a surface that is closed around.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsMuscle {
    /// Control points as (wx, wy, wz, w), ring after ring.
    points: Vec<DVec4>,
    /// Control points of the central curve, one a ring.
    centres: Vec<DVec4>,
    around: usize,
    degree: usize,
    knots: Vec<f64>,
    /// Places of a coarse grid of parameters, from which Newton's method may start.
    starts: Vec<(DVec3, DVec3)>,
}

/// Intervals of the grid of starts around, along and inwards.
const STARTS: [usize; 3] = [12, 16, 3];

/// A place of the volume with its derivatives around, along and inwards.
struct Jet {
    place: DVec3,
    by: DMat3,
}

impl NurbsMuscle {
    /// Makes the volume of rings of control points with their weights, in metres.
    ///
    /// # Errors
    /// Fails unless there are at least two rings, all of the same number of at least four points, with finite numbers
    /// and positive weights.
    pub fn new(rings: &[Vec<[f64; 4]>]) -> Result<Self> {
        let around = rings.first().map_or(0, Vec::len);
        let along = rings.len();
        if along < 2 || around < 4 || rings.iter().any(|ring| ring.len() != around) {
            return Err(Error::invalid(format!(
                "{along} rings of control points, the first of {around}, make no muscle"
            ))
            .advise("give at least two rings of the same number of points, four or more"));
        }
        let is_sound = |point: &[f64; 4]| point.iter().all(|part| part.is_finite()) && point[3] > 0.0;
        if let Some(ring) = rings.iter().position(|ring| !ring.iter().all(is_sound)) {
            return Err(Error::invalid("a control point is not finite or its weight is not positive")
                .at(format!("ring {ring}")));
        }
        let points: Vec<DVec4> =
            rings.iter().flatten().map(|[x, y, z, w]| DVec4::new(x * w, y * w, z * w, *w)).collect();
        let centres = points.chunks(around).map(|ring| ring.iter().sum::<DVec4>() / around as f64).collect();
        let degree = 3.min(along - 1);
        let inner = along - degree;
        let knot = |at: usize| (at.saturating_sub(degree)).min(inner) as f64 / inner as f64;
        let knots = (0..along + degree + 1).map(knot).collect();
        let mut muscle = Self { points, centres, around, degree, knots, starts: Vec::new() };
        for u in 0..STARTS[0] {
            for v in 0..=STARTS[1] {
                for w in 0..STARTS[2] {
                    let at = [u as f64, v as f64, w as f64 + 0.5];
                    let at = DVec3::from_array(std::array::from_fn(|axis| at[axis] / STARTS[axis] as f64));
                    muscle.starts.push((at, muscle.jet(at).place));
                }
            }
        }
        Ok(muscle)
    }

    /// Returns a point of the volume for parameters around, along and inwards, each 0 to 1.
    pub fn point(&self, at: DVec3) -> DVec3 {
        self.jet(at).place
    }

    /// Returns the parameters of a place by Newton's method, from those of a place that is near if there are any. Places
    /// outside get the parameters of the border near them.
    pub fn parameters(&self, place: DVec3, near: Option<DVec3>) -> DVec3 {
        let tolerance = 1e-10 * self.starts.iter().map(|start| start.1.distance_squared(place)).fold(0.0, f64::max);
        if let Some((at, square)) = near.map(|near| self.newton(place, near))
            && square < tolerance
        {
            return at;
        }
        let start =
            self.starts.iter().min_by(|a, b| a.1.distance_squared(place).total_cmp(&b.1.distance_squared(place)));
        start.map_or(DVec3::ZERO, |start| self.newton(place, start.0).0)
    }

    /// Returns the unit direction of the fibres at a place, and its parameters.
    pub fn direction(&self, place: DVec3, near: Option<DVec3>) -> (DVec3, DVec3) {
        let at = self.parameters(place, near);
        (self.jet(at).by.y_axis.normalize_or(DVec3::X), at)
    }

    /// Returns parameters whose place is close to `place`, and the squared distance that is left.
    fn newton(&self, place: DVec3, start: DVec3) -> (DVec3, f64) {
        let mut at = start;
        let mut best = (start, f64::INFINITY);
        for _ in 0..12 {
            let jet = self.jet(at);
            let off = place - jet.place;
            let square = off.length_squared();
            if square < best.1 {
                best = (at, square);
            }
            // At the central curve the derivative around vanishes.
            let scale = jet.by.determinant();
            let size = jet.by.x_axis.length() * jet.by.y_axis.length() * jet.by.z_axis.length();
            let step = if scale.abs() > 1e-9 * size.max(f64::MIN_POSITIVE) {
                jet.by.inverse() * off
            } else {
                let along = jet.by.y_axis;
                DVec3::new(0.0, off.dot(along) / along.length_squared().max(f64::MIN_POSITIVE), -0.05)
            };
            let next = at + step.clamp(DVec3::splat(-0.25), DVec3::splat(0.25));
            let next = DVec3::new(next.x.rem_euclid(1.0), next.y.clamp(0.0, 1.0), next.z.clamp(0.0, 1.0));
            if (next - at).length_squared() < 1e-20 {
                break;
            }
            at = next;
        }
        best
    }

    fn jet(&self, at: DVec3) -> Jet {
        let along = self.along(at.y);
        let around = uniform(at.x, self.around);
        let [mut shell, mut shell_u, mut shell_v, mut core, mut core_v] = [DVec4::ZERO; 5];
        for (ring, value, slope) in along {
            core += self.centres[ring] * value;
            core_v += self.centres[ring] * slope;
            for (column, share, rise) in around {
                let point = self.points[ring * self.around + column];
                shell += point * (value * share);
                shell_u += point * (value * rise);
                shell_v += point * (slope * share);
            }
        }
        let sum = shell.lerp(core, at.z);
        let parts = [shell_u * (1.0 - at.z), shell_v.lerp(core_v, at.z), core - shell];
        let place = sum.truncate() / sum.w;
        let [u, v, w] = parts.map(|part| (part.truncate() - place * part.w) / sum.w);
        Jet { place, by: DMat3::from_cols(u, v, w) }
    }

    /// Returns the rings whose basis functions are not 0 at a parameter along, their values and slopes; the last entries
    /// are 0 for degrees below 3 (Piegl and Tiller 1997, Section 2.5).
    fn along(&self, t: f64) -> [(usize, f64, f64); 4] {
        let (degree, knots) = (self.degree, &self.knots);
        let last = self.centres.len() - 1;
        let span = knots.partition_point(|knot| *knot <= t).saturating_sub(1).clamp(degree, last);
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let mut lower = [0.0; 4];
        let mut values = [0.0; 4];
        values[0] = 1.0;
        for order in 1..=degree {
            lower = values;
            values = [0.0; 4];
            for at in 0..order {
                let (left, right) = (knots[span + 1 + at - order], knots[span + 1 + at]);
                let share = ratio(lower[at], right - left);
                values[at] += (right - t) * share;
                values[at + 1] += (t - left) * share;
            }
        }
        std::array::from_fn(|at| {
            if at > degree {
                return (0, 0.0, 0.0);
            }
            let ring = span - degree + at;
            let before = if at > 0 { ratio(lower[at - 1], knots[ring + degree] - knots[ring]) } else { 0.0 };
            let after = if at < degree { ratio(lower[at], knots[ring + degree + 1] - knots[ring + 1]) } else { 0.0 };
            (ring, values[at], degree as f64 * (before - after))
        })
    }

    /// Returns a closed mesh of the surface, counter-clockwise seen from outside, with so many points around and along.
    pub fn mesh(&self, around: u32, along: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let (around, along) = (around.max(3), along.max(1));
        let mut points = Vec::new();
        let mut add = |at: DVec3| points.push(self.jet(at).place.as_vec3().to_array());
        for v in 0..=along {
            for u in 0..around {
                add(DVec3::new(f64::from(u) / f64::from(around), f64::from(v) / f64::from(along), 0.0));
            }
        }
        add(DVec3::new(0.0, 0.0, 1.0));
        add(DVec3::new(0.0, 1.0, 1.0));
        let id = |u: u32, v: u32| v * around + u % around;
        let ends = [(along + 1) * around, (along + 1) * around + 1];
        let mut triangles = Vec::new();
        for u in 0..around {
            triangles.push([ends[0], id(u + 1, 0), id(u, 0)]);
            triangles.push([ends[1], id(u, along), id(u + 1, along)]);
            for v in 0..along {
                triangles.push([id(u, v), id(u + 1, v), id(u + 1, v + 1)]);
                triangles.push([id(u, v), id(u + 1, v + 1), id(u, v + 1)]);
            }
        }
        let corner =
            |triangle: &[u32; 3]| triangle.map(|point| DVec3::from_array(points[point as usize].map(f64::from)));
        let volume: f64 = triangles.iter().map(corner).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        if volume < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        (points, triangles)
    }
}

/// Returns the control points around whose uniform cubic basis functions are not 0, their values and slopes.
fn uniform(u: f64, count: usize) -> [(usize, f64, f64); 4] {
    let at = u.rem_euclid(1.0) * count as f64;
    let whole = at.floor();
    let (t, n) = (at - whole, count as f64 / 6.0);
    let first = whole as usize + count - 1;
    let values = [
        (1.0 - t).powi(3),
        3.0 * t.powi(3) - 6.0 * t * t + 4.0,
        -3.0 * t.powi(3) + 3.0 * t * t + 3.0 * t + 1.0,
        t.powi(3),
    ];
    let slopes = [-3.0 * (1.0 - t).powi(2), 9.0 * t * t - 12.0 * t, -9.0 * t * t + 6.0 * t + 3.0, 3.0 * t * t];
    std::array::from_fn(|k| ((first + k) % count, values[k] / 6.0, slopes[k] * n))
}
