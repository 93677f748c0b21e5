//! Where vertices are, and how those around one have turned.

use glam::{Quat, Vec3};

/// Where a vertex is, and its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    pub point: Vec3,
    pub normal: Vec3,
}

/// The middle of the vertices around one, as they were built and as they are now, and the turn between.
///
/// The paper (Derzapf, Grund, Guthe 2014, Section 4.1) spans a frame by averages of normals and tangents, stores offsets
/// in it, and turns them with the frame. Only the turn from one frame to the other matters for that. It takes the average
/// normal to the other, and about it fits the vertices themselves best, in the plane; so it needs no tangents, and none
/// that a mesh without them would have to make up, and is exact where everything moved rigidly.
pub struct Surroundings {
    built: Vec3,
    now: Vec3,
    turn: Quat,
}

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
        let (mut sine, mut cosine) = (0.0, 0.0);
        for places in neighbours.iter().chain([&vertex]) {
            let before = arc * (places[0].point - middle[0]);
            let after = places[1].point - middle[1];
            let before = before - normal[1] * before.dot(normal[1]);
            sine += normal[1].dot(before.cross(after));
            cosine += before.dot(after);
        }
        let turn = Quat::from_axis_angle(normal[1], f32::atan2(sine, cosine)) * arc;
        Self { built: middle[0], now: middle[1], turn: turn.normalize() }
    }

    /// Where a vertex is now that was built at `place`.
    pub fn forward(&self, place: Place) -> Place {
        Place { point: self.now + self.turn * (place.point - self.built), normal: self.turn * place.normal }
    }

    /// Where a vertex would have been built that is at `place` now.
    pub fn back(&self, place: Place) -> Place {
        let turn = self.turn.inverse();
        Place { point: self.built + turn * (place.point - self.now), normal: turn * place.normal }
    }
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
