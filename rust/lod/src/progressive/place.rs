//! Where vertices are, and how those around one have turned.

use glam::{Mat3, Quat, Vec3};

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
    built: Vec3,
    now: Vec3,
    map: Mat3,
}

/// How much the map wants normals to go to normals, and to be a turn in all directions, beside the sum of squares of how
/// far the vertices are. With less of the latter, what vertices round off grows from level to level.
const UPRIGHT: f32 = 0.5;
const RIGID: f32 = 5e-2;
/// The least volume, of the map, that can be undone.
const FLAT: f32 = 1e-2;

impl Surroundings {
    /// Of the vertex that is split or was merged, which counts twice, and its neighbours, each as built and as it is now.
    pub fn new(vertex: [Place; 2], neighbours: &[[Place; 2]]) -> Self {
        let share = 1.0 / (neighbours.len() as f32 + 2.0);
        let middle = [0, 1].map(|time| {
            let sum = neighbours.iter().map(|places| places[time].point - vertex[time].point).sum::<Vec3>();
            vertex[time].point + sum * share
        });
        let normal = [0, 1].map(|time| {
            let sum = neighbours.iter().fold(2.0 * vertex[time].normal, |sum, places| sum + places[time].normal);
            sum.try_normalize().unwrap_or(Vec3::Z)
        });
        let arc = arc(normal[0], normal[1]);
        let offsets = |places: &[Place; 2]| [0, 1].map(|time| places[time].point - middle[time]);
        let all = || neighbours.iter().chain([&vertex, &vertex]).map(offsets);
        let (mut sine, mut cosine) = (0.0, 0.0);
        for [before, after] in all() {
            let turned = arc * before;
            let turned = turned - normal[1] * turned.dot(normal[1]);
            sine += normal[1].dot(turned.cross(after));
            cosine += turned.dot(after);
        }
        let turn = Mat3::from_quat((Quat::from_axis_angle(normal[1], f32::atan2(sine, cosine)) * arc).normalize());
        // What the turn leaves is fitted, not the whole: it is exactly nothing where everything only turned.
        let (mut squares, mut spread, mut left) = (0.0, Mat3::ZERO, Mat3::ZERO);
        for [before, after] in all() {
            squares += before.length_squared();
            spread += outer(before, before);
            left += outer(turn.transpose() * after - before, before);
        }
        if squares == 0.0 {
            return Self { built: middle[0], now: middle[1], map: turn };
        }
        // The inverse is of numbers about 1.
        let scale = squares.recip();
        let spread = spread * scale + outer(normal[0], normal[0]) * UPRIGHT + Mat3::IDENTITY * RIGID;
        let map = turn + turn * (left * scale) * spread.inverse();
        let is_fit = map.determinant() > FLAT && map.is_finite();
        Self { built: middle[0], now: middle[1], map: if is_fit { map } else { turn } }
    }

    /// Where a vertex is now that was built at `place`.
    pub fn forward(&self, place: Place) -> Place {
        let normal = self.map.inverse().transpose() * place.normal;
        Place { point: self.now + self.map * (place.point - self.built), normal: normal.normalize_or_zero() }
    }

    /// Where a vertex would have been built that is at `place` now.
    pub fn back(&self, place: Place) -> Place {
        let normal = self.map.transpose() * place.normal;
        Place { point: self.built + self.map.inverse() * (place.point - self.now), normal: normal.normalize_or_zero() }
    }
}

/// a bᵀ
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The shortest turn from one unit vector to another, exact for small ones too.
fn arc(from: Vec3, to: Vec3) -> Quat {
    let cosine = 1.0 + from.dot(to);
    if cosine < 1e-6 {
        return Quat::from_axis_angle(from.any_orthonormal_vector(), std::f32::consts::PI);
    }
    let axis = from.cross(to);
    Quat::from_xyzw(axis.x, axis.y, axis.z, cosine).normalize()
}
