//! Bodies that nodes do not enter, with Coulomb friction.
//!
//! A node that is found inside is put on the surface along the normal. Its velocity loses what goes into the body, and of
//! what goes along it at most the friction times that loss, so contact takes energy and gives none beside what the body's
//! own motion does.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use relievo_core::{Context, Error, Result};

use crate::block::Row;
use crate::curve::Curve;
use crate::distance::DistanceField;
use crate::simulation::State;

/// A rigid body that nodes do not enter.
#[derive(Clone, Debug)]
pub struct Collider {
    body: Body,
    friction: f32,
    motion: Motion,
}

/// Where a body is over time.
#[derive(Clone, Debug)]
enum Motion {
    /// Translation in metres and rotation vector in radians, about the body's origin, over seconds.
    Curves { translation: Curve<3>, rotation: Curve<3> },
    /// Seconds, rising, and poses.
    Poses(Vec<(f64, Pose)>),
}

/// A place and a rotation about the body's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres.
    pub translation: DVec3,
    /// A unit quaternion.
    pub rotation: DQuat,
}

/// The shape of a collider in its own space.
#[derive(Clone, Debug)]
pub enum Body {
    /// All that is below z = 0.
    Floor,
    /// A ball about the origin, by its radius in metres.
    Ball(f32),
    /// A closed mesh, counter-clockwise seen from outside.
    Mesh(DistanceField),
}

impl Collider {
    /// Makes a collider with a coefficient of friction, a translation and a rotation vector over time.
    ///
    /// # Errors
    /// Fails if the friction is negative or the radius not positive.
    pub fn new(body: Body, friction: f32, translation: Curve<3>, rotation: Curve<3>) -> Result<Self> {
        Self::moving(body, friction, Motion::Curves { translation, rotation })
    }

    /// Makes a collider that stays in a pose until [`Self::add_pose`] gives it others, such as those of a rigid body.
    ///
    /// # Errors
    /// Fails as [`Self::new`] does.
    pub fn posed(body: Body, friction: f32, pose: Pose) -> Result<Self> {
        Self::moving(body, friction, Motion::Poses(vec![(0.0, pose)]))
    }

    fn moving(body: Body, friction: f32, motion: Motion) -> Result<Self> {
        if !(friction >= 0.0 && friction.is_finite()) {
            return Err(Error::invalid(format!("a friction of {friction} cannot be")).advise("use 0 or more"));
        }
        if let Body::Ball(radius) = body
            && !(radius > 0.0 && radius.is_finite())
        {
            return Err(Error::invalid(format!("a ball of radius {radius} m cannot be")).advise("use more than 0"));
        }
        Ok(Self { body, friction, motion })
    }

    /// Returns the shape and the coefficient of friction.
    pub(crate) fn shape(&self) -> (&Body, f32) {
        (&self.body, self.friction)
    }

    /// Adds the pose at a time in seconds after all so far. Between two it moves and turns evenly.
    ///
    /// # Errors
    /// Fails if the time is not later, or the collider moves along curves.
    pub fn add_pose(&mut self, time: f64, pose: Pose) -> Result<()> {
        match &mut self.motion {
            Motion::Poses(poses) if poses.last().is_none_or(|(last, _)| time > *last) => poses.push((time, pose)),
            Motion::Poses(_) => return Err(Error::invalid(format!("the pose at {time} s is not later than the last"))),
            Motion::Curves { .. } => return Err(Error::invalid("the collider moves along curves and takes no poses")),
        }
        Ok(())
    }

    /// Returns where the body is at `time`.
    pub fn pose(&self, time: f64) -> DAffine3 {
        let Pose { translation, rotation } = match &self.motion {
            Motion::Curves { translation, rotation } => Pose {
                translation: Vec3::from(translation.at(time)).as_dvec3(),
                rotation: DQuat::from_scaled_axis(Vec3::from(rotation.at(time)).as_dvec3()),
            },
            Motion::Poses(poses) => between(poses, time),
        };
        DAffine3::from_rotation_translation(rotation, translation)
    }

    /// Returns the signed distance of a place in the body's space and the normal there, if it is inside.
    fn inside(&self, place: Vec3) -> Option<(f32, Vec3)> {
        let (distance, normal) = self.within(place, 0.0)?;
        (distance < 0.0).then_some((distance, normal))
    }

    /// Returns the signed distance of a place in the body's space and the normal there, if it is at most `margin`.
    fn within(&self, place: Vec3, margin: f32) -> Option<(f32, Vec3)> {
        let (distance, normal) = match &self.body {
            Body::Floor => (place.z, Vec3::Z),
            Body::Ball(radius) => {
                let length = place.length();
                (length - radius, place.try_normalize().unwrap_or(Vec3::Z))
            }
            Body::Mesh(field) => {
                let [low, high] = field.bounds();
                if place.cmplt(low - margin).any() || place.cmpgt(high + margin).any() {
                    return None;
                }
                let closest = field.closest(place, None);
                let away = if closest.distance < 0.0 { closest.point - place } else { place - closest.point };
                // On the surface the way to it is nothing but rounding.
                let away = away.try_normalize().filter(|_| closest.distance.abs() > margin);
                (closest.distance, away.unwrap_or(closest.normal))
            }
        };
        (distance <= margin).then_some((distance, normal))
    }

    /// Returns the normal of the body in a pose at a place of the world that is inside of it or at most `margin` away.
    pub(crate) fn touched(&self, pose: DAffine3, place: DVec3, margin: f32) -> Option<Vec3> {
        let own = pose.inverse().transform_point3(place).as_vec3();
        let (_, normal) = self.within(own, margin)?;
        Some(pose.transform_vector3(normal.as_dvec3()).as_vec3())
    }

    /// Puts nodes that are inside on the surface. The body moved for `dt` seconds before the present time, or stands still
    /// if that is `None`. Fails, and moves nothing, if all nodes are inside: they would lie on the surface, without a volume
    /// between them. `witness` is a node that was outside, with which the search for one begins.
    pub(crate) fn push(
        &self,
        context: &Context,
        nodes: &[[f32; 3]],
        masses: &[Row],
        state: &mut State,
        dt: Option<f32>,
        witness: &mut usize,
    ) -> Result<()> {
        let time = state.seconds;
        let pose = self.pose(time);
        let moved = dt.map(|dt| (self.pose(time - f64::from(dt)), f64::from(dt)));
        let back = pose.inverse();
        let is_outside = |node: &usize| {
            let own = back.transform_point3(place(nodes, state, *node));
            self.inside(own.as_vec3()).is_none()
        };
        if !is_outside(witness) {
            *witness = (0..nodes.len()).find(is_outside).ok_or_else(|| {
                let what = format!("all {} nodes are inside of the collider at {time:.6} s", nodes.len());
                Error::invalid(what).advise("let it begin outside of the model, or move it more slowly")
            })?;
        }
        let parts = (state.displacements.as_mut_slice(), state.velocities.as_mut_slice());
        context.for_each_part(parts, 4096, |first, (displacements, velocities)| {
            for (at, (u, v)) in displacements.iter_mut().zip(velocities).enumerate() {
                let node = first + at;
                let mass = &masses[node];
                if mass[0] == 0.0 && mass[1] == 0.0 && mass[2] == 0.0 {
                    continue;
                }
                let place = (Vec3::from(nodes[node]) + Vec3::from_slice(u)).as_dvec3();
                let own = back.transform_point3(place);
                let Some((distance, normal)) = self.inside(own.as_vec3()) else { continue };
                let normal: DVec3 = pose.transform_vector3(normal.as_dvec3());
                let surface = own - back.transform_vector3(normal) * f64::from(distance);
                let to = pose.transform_point3(surface);
                let pace = moved.map_or(DVec3::ZERO, |(before, dt)| (to - before.transform_point3(surface)) / dt);
                let relative = Vec3::from_slice(v).as_dvec3() - pace;
                let into = relative.dot(normal).min(0.0);
                let along = relative - normal * relative.dot(normal);
                let rubbed = f64::from(self.friction) * -into;
                let left = along * (1.0 - (rubbed / along.length().max(1e-30)).min(1.0));
                let after = pace + left + normal * relative.dot(normal).max(0.0);
                for axis in (0..3).filter(|axis| mass[*axis] > 0.0) {
                    u[axis] += (to - place)[axis] as f32;
                    v[axis] = after[axis] as f32;
                }
            }
            Ok(())
        })
    }
}

/// Returns where a node is, in metres.
pub(crate) fn place(nodes: &[[f32; 3]], state: &State, node: usize) -> DVec3 {
    (Vec3::from(nodes[node]) + Vec3::from_slice(&state.displacements[node])).as_dvec3()
}

/// Returns the pose at a time: even motion between two, and the first or the last outside of them.
fn between(poses: &[(f64, Pose)], time: f64) -> Pose {
    let after = poses.partition_point(|(at, _)| *at <= time);
    let (start, a) = poses[after.saturating_sub(1)];
    let Some((end, b)) = poses.get(after).filter(|_| after > 0) else { return a };
    let share = (time - start) / (end - start);
    Pose { translation: a.translation.lerp(b.translation, share), rotation: a.rotation.slerp(b.rotation, share) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn a_posed_body_moves_and_turns_evenly_between_its_poses_and_rests_outside_of_them() {
        let pose =
            |x: f64, angle: f64| Pose { translation: DVec3::new(x, 0.0, 0.0), rotation: DQuat::from_rotation_z(angle) };
        let mut body = Collider::posed(Body::Ball(1.0), 0.0, pose(0.0, 0.0)).unwrap();
        body.add_pose(1.0, pose(2.0, FRAC_PI_2)).unwrap();
        body.add_pose(2.0, pose(2.0, 2.0 * FRAC_PI_2)).unwrap();
        for (time, x, angle) in [(-1.0, 0.0, 0.0), (0.25, 0.5, 0.25), (1.0, 2.0, 1.0), (1.5, 2.0, 1.5), (9.0, 2.0, 2.0)]
        {
            let found = body.pose(time);
            let turned = DQuat::from_rotation_z(angle * FRAC_PI_2) * DVec3::X;
            assert!((found.translation.x - x).abs() < 1e-12, "{time}");
            assert!((found.transform_vector3(DVec3::X) - turned).length() < 1e-12, "{time}");
        }
        assert!(body.add_pose(2.0, pose(0.0, 0.0)).unwrap_err().to_string().contains("not later"));
    }
}
