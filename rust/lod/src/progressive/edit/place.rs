//! Where vertices are, and how those around one have turned.

use glam::{Mat3A, Quat, Vec2, Vec3, Vec3A};

/// Where a vertex is, and its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    pub point: Vec3,
    pub normal: Vec3,
}

/// The middle of the vertices around one, as they were built and as they are now, and the linear map between.
///
/// The paper (Derzapf, Grund, Guthe 2014, Section 4.1) spans a frame by averages of normals and tangents, stores offsets
/// in it, and turns them with the frame. Only the map from one frame to the other matters for that. Here it is the one
/// that takes the vertices themselves where they are, in least squares, and the average normal to the other. So no mesh
/// needs tangents, nothing is lost where everything moves rigidly, and where the surface is stretched or sheared its
/// vertices go with it: offsets that only turn overtake each other there, which is seen as noise.
pub struct Surroundings {
    built: Vec3A,
    now: Vec3A,
    map: Mat3A,
}

/// How much the map wants normals to go to normals, and to be a turn in all directions, beside the sum of squares of how
/// far the vertices are. With less of the latter, what vertices round off grows from level to level; directions, which no
/// other level is made from, need it only where vertices are in a line.
const UPRIGHT: f32 = 0.5;
const RIGID: f32 = 5e-2;
const NEARLY_FREE: f32 = 1e-3;
/// The least volume, of the map, that can be undone.
const FLAT: f32 = 1e-2;

impl Surroundings {
    /// Of the vertex that is split or was merged, which counts twice, and its neighbours, each as built and as it is now.
    pub fn new(vertex: [Place; 2], neighbours: &[[Place; 2]]) -> Self {
        Self::fit(vertex, neighbours, RIGID)
    }

    /// As [`Self::new`], for directions alone.
    pub fn for_directions(vertex: [Place; 2], neighbours: &[[Place; 2]]) -> Self {
        Self::fit(vertex, neighbours, NEARLY_FREE)
    }

    fn fit(vertex: [Place; 2], neighbours: &[[Place; 2]], rigid: f32) -> Self {
        let share = 1.0 / (neighbours.len() as f32 + 2.0);
        let origin = vertex.map(|place| Vec3A::from(place.point));
        let offsets = |places: &[Place; 2]| [0, 1].map(|time| Vec3A::from(places[time].point) - origin[time]);
        let (mut sum, mut normals) = ([Vec3A::ZERO; 2], vertex.map(|place| 2.0 * Vec3A::from(place.normal)));
        for places in neighbours {
            let offsets = offsets(places);
            for time in 0..2 {
                sum[time] += offsets[time];
                normals[time] += Vec3A::from(places[time].normal);
            }
        }
        let middle = sum.map(|sum| sum * share);
        let [built, now] = [0, 1].map(|time| origin[time] + middle[time]);
        // Σ before beforeᵀ and Σ after beforeᵀ, from the middles.
        let own = middle.map(|middle| -middle);
        let (mut spread, mut across) = (2.0 * outer(own[0], own[0]), 2.0 * outer(own[1], own[0]));
        for places in neighbours {
            let offsets = offsets(places);
            let [before, after] = [0, 1].map(|time| offsets[time] - middle[time]);
            spread += outer(before, before);
            across += outer(after, before);
        }
        let normals = normals.map(|sum| sum.try_normalize().unwrap_or(Vec3A::Z));
        let arc = arc(normals[0].into(), normals[1].into());
        let squares = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        if squares == 0.0 {
            return Self { built, now, map: Mat3A::from_quat(arc) };
        }
        // What follows is of numbers about 1.
        let scale = squares.recip();
        (spread, across) = (spread * scale, across * scale);
        let normal = normals[1];
        let turned = across * Mat3A::from_quat(arc).transpose();
        let [x, y, z] = [turned.x_axis, turned.y_axis, turned.z_axis];
        let sine = normal.dot(Vec3A::new(y.z - z.y, z.x - x.z, x.y - y.x));
        let cosine = x.x + y.y + z.z - normal.dot(turned * normal);
        let turn = Mat3A::from_quat((about(normal.into(), sine, cosine) * arc).normalize());
        // What the turn leaves is fitted, not the whole: it is nothing where everything only turned.
        let left = turn.transpose() * across - spread;
        let spread = spread + outer(normals[0], normals[0]) * UPRIGHT + Mat3A::IDENTITY * rigid;
        let map = turn + turn * left * spread.inverse();
        let is_fit = map.determinant() > FLAT && map.is_finite();
        Self { built, now, map: if is_fit { map } else { turn } }
    }

    /// Where a vertex is now that was built at `place`.
    pub fn forward(&self, place: Place) -> Place {
        let normal = self.map.inverse().transpose() * Vec3A::from(place.normal);
        let point = self.now + self.map * (Vec3A::from(place.point) - self.built);
        Place { point: point.into(), normal: normal.normalize_or_zero().into() }
    }

    /// What a normal is now that was built, of the same length.
    pub fn normal(&self, built: Vec3) -> Vec3 {
        let normal = self.map.inverse().transpose() * Vec3A::from(built);
        Vec3::from(normal.normalize_or_zero()) * built.length()
    }

    /// What a tangent is now, of the same length and as far from the tangent plane, where a surface had one normal and has
    /// another; of length 1, or 0 for none.
    pub fn tangent(&self, built: Vec3, normals: [Vec3; 2]) -> Vec3 {
        let above = built.dot(normals[0]);
        let within = built - normals[0] * above;
        let turned = Vec3::from(self.map * Vec3A::from(within));
        let turned = turned - normals[1] * turned.dot(normals[1]);
        turned.normalize_or_zero() * within.length() + normals[1] * above
    }

    /// Where a vertex would have been built that is at `place` now.
    pub fn back(&self, place: Place) -> Place {
        let normal = self.map.transpose() * Vec3A::from(place.normal);
        let point = self.built + self.map.inverse() * (Vec3A::from(place.point) - self.now);
        Place { point: point.into(), normal: normal.normalize_or_zero().into() }
    }
}

/// a bᵀ
#[inline(always)]
fn outer(a: Vec3A, b: Vec3A) -> Mat3A {
    Mat3A::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The turn about an axis by the angle that has this sine and cosine, both times the same number above 0.
fn about(axis: Vec3, sine: f32, cosine: f32) -> Quat {
    let length = (sine * sine + cosine * cosine).sqrt();
    // Of tan(φ/2) = sin φ / (1 + cos φ) = (1 − cos φ) / sin φ the one that is exact.
    let half = if cosine >= 0.0 {
        Vec2::new(length + cosine, sine)
    } else {
        Vec2::new(sine.abs(), (length - cosine).copysign(sine))
    };
    let half = half.try_normalize().unwrap_or(Vec2::X);
    let [x, y, z] = (axis * half.y).to_array();
    Quat::from_xyzw(x, y, z, half.x)
}

/// The shortest turn from one unit vector to another, exact for small ones too.
pub fn arc(from: Vec3, to: Vec3) -> Quat {
    let cosine = 1.0 + from.dot(to);
    if cosine < 1e-6 {
        return Quat::from_axis_angle(from.any_orthonormal_vector(), std::f32::consts::PI);
    }
    let axis = from.cross(to);
    Quat::from_xyzw(axis.x, axis.y, axis.z, cosine).normalize()
}
