//! What rigid bodies of a fluid do not pass and do not move: meshes that are turned and moved, or change their shapes.
//!
//! To rapier3d a mesh is rigid, so what bodies meet would have no velocity where it bends. One that changes its shape is
//! therefore given triangle by triangle, near bodies alone, and each is moved as the rigid triangle that goes with it
//! best: that has the triangle's velocities across it, and along it all but the stretch.

use glam::{Quat, Vec3};
use rapier3d::prelude::{
    ColliderBuilder, PhysicsWorld, Pose, RigidBodyBuilder, RigidBodyHandle, Rotation, SharedShape, Vector,
};
use relievo_core::{Error, Result};

pub fn vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub fn placed((turn, moved): (Quat, Vec3)) -> Pose {
    Pose::from_parts(vector(moved), Rotation::from_array(turn.normalize().to_array()))
}

/// What bodies do not move, and its way through a time.
pub struct Obstacle {
    shape: SharedShape,
    triangles: Vec<[u32; 3]>,
    /// How many points it has.
    points: usize,
    way: Way,
}

enum Way {
    /// From a pose to another.
    Rigid([(Quat, Vec3); 2]),
    /// From points to others.
    Bent([Vec<Vec3>; 2]),
}

impl Obstacle {
    /// Of points in metres, where they are, and triangles. Fails if rapier3d cannot use it.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self> {
        let places = points.iter().map(|point| vector(*point)).collect();
        let shape = ColliderBuilder::trimesh(places, triangles.to_vec())
            .map_err(|error| Error::invalid(format!("bodies cannot meet it: {error}")))?;
        let way = Way::Rigid([(Quat::IDENTITY, Vec3::ZERO); 2]);
        Ok(Self { shape: shape.shape, triangles: triangles.to_vec(), points: points.len(), way })
    }

    /// Has it go from a pose to another. Fails if a number is not finite.
    pub fn go(&mut self, path: [(Quat, Vec3); 2]) -> Result<()> {
        if !path.iter().all(|(turn, moved)| turn.is_normalized() && moved.is_finite()) {
            return Err(Error::invalid("it cannot be there"));
        }
        self.way = Way::Rigid(path);
        Ok(())
    }

    /// Has it go from points to others, in straight lines. Fails if there are not as many as it has, or one is not finite.
    pub fn bend(&mut self, path: [&[Vec3]; 2]) -> Result<()> {
        if let Some(given) = path.iter().map(|points| points.len()).find(|given| *given != self.points) {
            return Err(Error::invalid(format!("{given} points are given for an obstacle of {}", self.points)));
        }
        if let Some(point) = path.iter().find_map(|points| points.iter().position(|point| !point.is_finite())) {
            return Err(Error::invalid("a place is not finite").at(format!("point {point}")));
        }
        self.way = Way::Bent(path.map(<[Vec3]>::to_vec));
        Ok(())
    }

    /// Puts it where its way begins; one that changes its shape comes in each step.
    pub fn insert(&self, physics: &mut PhysicsWorld) -> Option<RigidBodyHandle> {
        let Way::Rigid([from, _]) = self.way else { return None };
        let rigid = RigidBodyBuilder::kinematic_position_based().pose(placed(from));
        Some(physics.insert(rigid, ColliderBuilder::new(self.shape.clone())).0)
    }

    /// Where it is after a share of its way, unless it changes its shape.
    pub fn pose(&self, share: f32) -> Option<Pose> {
        let Way::Rigid([(from, start), (to, end)]) = self.way else { return None };
        Some(placed((from.slerp(to, share), start.lerp(end, share))))
    }

    /// Its triangles that meet one of some boxes, by low and high corners, on the way from a share to another within so many
    /// seconds, if it changes its shape.
    pub fn pieces(
        &self,
        [from, to]: [f32; 2],
        seconds: f32,
        boxes: &[[Vec3; 2]],
    ) -> Vec<(RigidBodyBuilder, ColliderBuilder)> {
        let Way::Bent([start, end]) = &self.way else { return Vec::new() };
        let at = |point: u32, share: f32| start[point as usize].lerp(end[point as usize], share);
        let ways = self.triangles.iter().map(|triangle| [from, to].map(|share| triangle.map(|point| at(point, share))));
        let is_near = |way: &[[Vec3; 3]; 2]| {
            let points = || way.iter().flatten();
            let low = points().fold(Vec3::INFINITY, |low, point| low.min(*point));
            let high = points().fold(Vec3::NEG_INFINITY, |high, point| high.max(*point));
            boxes.iter().any(|[least, most]| low.cmple(*most).all() && high.cmpge(*least).all())
        };
        ways.filter(is_near).filter_map(|way| piece(way, seconds)).collect()
    }
}

/// A triangle as rapier3d has it, with the velocity and spin of its way within so many seconds; `None` where it has no area.
fn piece([from, to]: [[Vec3; 3]; 2], seconds: f32) -> Option<(RigidBodyBuilder, ColliderBuilder)> {
    let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).try_normalize();
    let (first, last) = (normal(from)?, normal(to)?);
    let [middle, end] = [from, to].map(|[a, b, c]| (a + b + c) / 3.0);
    let offsets = from.map(|point| point - middle);
    let tilt = Quat::from_rotation_arc(first, last);
    // In its plane, it turns so that corners are as near to theirs as can be.
    let (mut across, mut along) = (0.0, 0.0);
    for (offset, point) in offsets.iter().zip(to) {
        let tilted = tilt * *offset;
        across += last.dot(tilted.cross(point - end));
        along += tilted.dot(point - end);
    }
    let turn = Quat::from_axis_angle(last, across.atan2(along)) * tilt;
    let (speed, spin) = ((end - middle) / seconds, turn.to_scaled_axis() / seconds);
    let rigid = RigidBodyBuilder::kinematic_velocity_based().translation(vector(middle));
    let [a, b, c] = offsets.map(vector);
    Some((rigid.linvel(vector(speed)).angvel(vector(spin)), ColliderBuilder::triangle(a, b, c)))
}
