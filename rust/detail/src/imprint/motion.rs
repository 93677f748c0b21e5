//! The motion of a collider between two frames, cut into sub-steps so small that imprints overlap: no point of the
//! collider travels further than a quarter of the smallest edge of its box between two of them. A fast wheel then
//! leaves a track and not dots.
//!
//! A transform moves as the middle of the collider's box on a line, the rotation at constant speed by the shorter way,
//! and scale and shear linearly. Points that deform move on lines.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use relievo_core::{Context, Error, Result};

use crate::geometry::obb::Obb;
use crate::imprint::collider::Collider;
use crate::object::transform::check_transform;

/// Where a collider is at a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// From object space to the world.
    pub transform: DAffine3,
    /// The points of a deforming collider, `None` for a rigid one.
    pub points: Option<Arc<[[f32; 3]]>>,
}

impl Pose {
    /// A pose of a rigid collider.
    pub fn rigid(transform: DAffine3) -> Self {
        Self { transform, points: None }
    }
}

/// The way of a collider from one pose to another.
#[derive(Clone, Debug)]
pub struct Motion {
    from: Pose,
    to: Pose,
    parts: [Parts; 2],
    pivot: DVec3,
    /// The longest way of a point, and how far it may go between two imprints.
    travel: f64,
    step: f64,
}

/// A transform as what moves independently: place of the pivot, rotation, and scale with shear before it.
#[derive(Clone, Copy, Debug)]
struct Parts {
    place: DVec3,
    rotation: DQuat,
    stretch: DMat3,
}

impl Parts {
    /// Fails where the transform cannot be undone.
    fn new(transform: &DAffine3, pivot: DVec3) -> Result<Self> {
        check_transform(transform)?;
        let place = transform.transform_point3(pivot);
        // Polar decomposition by Newton's iteration (Higham 1986); a mirroring stays in the stretch.
        let mut turn = transform.matrix3 * transform.matrix3.determinant().signum();
        for _ in 0..64 {
            let inverse = turn.inverse().transpose();
            // Scaling by the norms makes it converge for any scale.
            let norm = |matrix: &DMat3| matrix.to_cols_array().iter().map(|value| value * value).sum::<f64>().sqrt();
            let weight = (norm(&inverse) / norm(&turn)).sqrt();
            let next = (turn * weight + inverse * (1.0 / weight)) * 0.5;
            let change = norm(&(next - turn));
            turn = next;
            if change < 1e-14 {
                break;
            }
        }
        let rotation = DQuat::from_mat3(&turn).normalize();
        Ok(Self { place, rotation, stretch: DMat3::from_quat(rotation.inverse()) * transform.matrix3 })
    }
}

impl Motion {
    /// The motion of `collider` from one pose to another.
    ///
    /// # Errors
    /// Fails with `Invalid` if a transform is not finite or cannot be undone, or a pose has another number of points
    /// than the collider or a point that is not finite.
    pub fn new(collider: &Collider, from: Pose, to: Pose) -> Result<Self> {
        for pose in [&from, &to] {
            if pose.points.as_ref().is_some_and(|points| points.len() != collider.points().len()) {
                return Err(Error::invalid("a pose of the collider has another number of points than the collider"));
            }
        }
        let rest = collider.points();
        let points = |pose: &'_ Pose| pose.points.clone().unwrap_or_else(|| rest.into());
        let boxes = match (&from.points, &to.points) {
            (None, None) => [*collider.object_obb(); 2],
            _ => [Obb::of_points(&points(&from))?, Obb::of_points(&points(&to))?],
        };
        let pivot = boxes[0].center;
        let parts = [Parts::new(&from.transform, pivot)?, Parts::new(&to.transform, pivot)?];
        let mut travel = rigid_travel(&parts, &boxes, pivot);
        if from.points.is_some() || to.points.is_some() {
            let (a, b) = (points(&from), points(&to));
            // The stretch between the two is a mean of both, so no line is longer than under one of them.
            let farthest = a.iter().zip(b.iter()).map(|(a, b)| {
                let line = DVec3::from(b.map(f64::from)) - DVec3::from(a.map(f64::from));
                parts.map(|parts| (parts.stretch * line).length_squared()).into_iter().fold(0.0, f64::max)
            });
            travel += farthest.fold(0.0, f64::max).sqrt();
        }
        let edge = [(&boxes[0], &from), (&boxes[1], &to)].map(|(obb, pose)| {
            let half = obb.transformed(&pose.transform).half;
            // A flat collider has no smallest edge to go by.
            2.0 * half.min_element().max(0.05 * half.max_element())
        });
        let step = 0.25 * edge[0].min(edge[1]);
        Ok(Self { from, to, parts, pivot, travel, step })
    }

    /// Sub-steps that keep the travel of every point below a quarter of the box's smallest edge.
    pub fn sub_steps(&self) -> u32 {
        self.sub_steps_against(0.0)
    }

    /// Whether the collider's own points stay as they are.
    pub fn is_rigid(&self) -> bool {
        self.from.points.is_none() && self.to.points.is_none()
    }

    /// A bound of the way that any point goes, in world units.
    pub fn travel(&self) -> f64 {
        self.travel
    }

    /// Sub-steps that keep the travel of every point against a surface below a quarter of the box's smallest edge,
    /// where points of the surface move by up to `travel` world units meanwhile.
    pub fn sub_steps_against(&self, travel: f64) -> u32 {
        let steps = ((self.travel + travel) / self.step).ceil();
        // A collider that is a point has no size at all.
        if self.step > 0.0 { steps.clamp(1.0, f64::from(u32::MAX)) as u32 } else { 1 }
    }

    /// The pose at `t`, from 0 to 1.
    pub fn at(&self, t: f64) -> Pose {
        if t >= 1.0 {
            return self.to.clone();
        }
        let [a, b] = &self.parts;
        let stretch = a.stretch * (1.0 - t) + b.stretch * t;
        let matrix3 = DMat3::from_quat(a.rotation.slerp(b.rotation, t)) * stretch;
        let translation = a.place.lerp(b.place, t) - matrix3 * self.pivot;
        let points = match (&self.from.points, &self.to.points) {
            (Some(a), Some(b)) => {
                let mix = |a: f32, b: f32| (f64::from(a) * (1.0 - t) + f64::from(b) * t) as f32;
                Some(a.iter().zip(b.iter()).map(|(a, b)| [0, 1, 2].map(|axis| mix(a[axis], b[axis]))).collect())
            }
            (_, end) => end.clone(),
        };
        let transform = DAffine3 { matrix3, translation };
        // A motion through a mirror image passes a transform that cannot be undone; the end is taken for it.
        if check_transform(&transform).is_ok() { Pose { transform, points } } else { self.to.clone() }
    }
}

impl Collider {
    /// Puts the collider into a pose.
    ///
    /// # Errors
    /// Fails as [`Self::set_points`], and with `Invalid` if the transform is not finite or cannot be undone; the points
    /// are those of the pose then.
    pub fn set_pose(&mut self, context: &Context, pose: &Pose) -> Result<()> {
        if let Some(points) = &pose.points {
            self.set_points(context, points)?;
        }
        self.set_transform(pose.transform)
    }
}

/// The longest way of a corner of the boxes: of the pivot, around it, and by stretching.
fn rigid_travel(parts: &[Parts; 2], boxes: &[Obb; 2], pivot: DVec3) -> f64 {
    let corners = boxes.iter().flat_map(Obb::corners);
    let (mut radius, mut stretched) = (0.0f64, 0.0f64);
    for corner in corners {
        let arm = corner - pivot;
        let ends = parts.map(|parts| parts.stretch * arm);
        radius = radius.max(ends[0].length()).max(ends[1].length());
        stretched = stretched.max((ends[1] - ends[0]).length());
    }
    let angle = parts[0].rotation.angle_between(parts[1].rotation);
    (parts[1].place - parts[0].place).length() + angle * radius + stretched
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shapes;
    use proptest::prelude::*;

    fn collider() -> Collider {
        let (points, triangles) = shapes::moved(shapes::torus(1.0, 0.3, 24, 12), [0.5, -0.2, 0.1]);
        Collider::new(&Context::serial(), points, triangles, DAffine3::IDENTITY).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn no_point_travels_more_than_a_quarter_of_the_smallest_edge(
            scale in prop::array::uniform3(0.5f64..2.0), turn in prop::array::uniform3(-3.0f64..3.0),
            shift in prop::array::uniform3(-4.0f64..4.0), shake in 0.0f32..0.5
        ) {
            let collider = collider();
            let rotation = DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let end = DAffine3::from_scale_rotation_translation(DVec3::from(scale), rotation, DVec3::from(shift));
            let mut to = Pose::rigid(end);
            let mut from = Pose::rigid(DAffine3::IDENTITY);
            if shake > 0.25 {
                from.points = Some(collider.points().into());
                to.points = Some(collider.points().iter().map(|p| [p[0] + shake * p[1], p[1], p[2] - shake]).collect());
            }
            let motion = Motion::new(&collider, from.clone(), to.clone()).unwrap();
            let steps = motion.sub_steps();
            let place = |pose: &Pose, index: usize| {
                let point = pose.points.as_ref().map_or(collider.points()[index], |points| points[index]);
                pose.transform.transform_point3(DVec3::from(point.map(f64::from)))
            };
            let edge = |pose: &Pose| {
                let points: Vec<[f32; 3]> = pose.points.as_ref().map_or(collider.points().to_vec(), |points| points.to_vec());
                2.0 * Obb::of_points(&points).unwrap().transformed(&pose.transform).half.min_element()
            };
            let limit = 0.25 * edge(&from).min(edge(&to)) * (1.0 + 1e-6);
            let mut before = motion.at(0.0);
            for step in 1..=steps {
                let pose = motion.at(f64::from(step) / f64::from(steps));
                for index in (0..collider.points().len()).step_by(17) {
                    prop_assert!((place(&pose, index) - place(&before, index)).length() <= limit);
                }
                before = pose;
            }
            for (found, pose) in [(motion.at(0.0), &from), (before, &to)] {
                for index in 0..5 {
                    prop_assert!((place(&found, index) - place(pose, index)).length() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn points_that_move_together_need_the_steps_of_a_move() {
        let collider = collider();
        let place = DAffine3::from_scale(DVec3::splat(3.0));
        let moved: Arc<[[f32; 3]]> = collider.points().iter().map(|[x, y, z]| [x + 4.1, *y, *z]).collect();
        let pose = |points| Pose { transform: place, points: Some(points) };
        let way = DAffine3::from_translation(DVec3::X * 3.0 * 4.1) * place;
        let deformed = Motion::new(&collider, pose(collider.points().into()), pose(moved)).unwrap();
        let pushed = Motion::new(&collider, Pose::rigid(place), Pose::rigid(way)).unwrap();
        assert!((pushed.travel() - 3.0 * 4.1).abs() < 1e-4);
        assert!((deformed.travel() - pushed.travel()).abs() < 1e-4);
        assert_eq!(deformed.sub_steps(), pushed.sub_steps());
    }

    #[test]
    fn a_spinning_wheel_needs_steps_and_a_resting_one_does_not() {
        let collider = collider();
        let rest = Pose::rigid(DAffine3::from_scale(DVec3::splat(3.0)));
        assert_eq!(Motion::new(&collider, rest.clone(), rest.clone()).unwrap().sub_steps(), 1);
        let middle = collider.object_obb().center;
        let spin =
            DAffine3::from_translation(middle) * DAffine3::from_rotation_z(2.0) * DAffine3::from_translation(-middle);
        let spun = Pose::rigid(rest.transform * spin);
        let motion = Motion::new(&collider, rest, spun).unwrap();
        assert!(motion.sub_steps() > 10);
        assert!((motion.at(0.37).transform.transform_point3(middle) - 3.0 * middle).length() < 1e-9);
        let mirrored = Pose::rigid(DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
        let flip = Motion::new(&collider, Pose::rigid(DAffine3::IDENTITY), mirrored).unwrap();
        assert!(flip.at(0.5).transform.is_finite());
        let short = Pose { points: Some(vec![[0.0; 3]; 3].into()), ..Pose::rigid(DAffine3::IDENTITY) };
        assert!(Motion::new(&collider, short.clone(), short).is_err());
    }
}
