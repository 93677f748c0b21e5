//! How a region of a mesh is moved and turned: handles with a region of influence, and anchors that hold it
//! (Derzapf, Grund, Guthe 2014, Section 4; the region is Euclidean).

use glam::{Quat, Vec3};
use relievo_core::{Error, Falloff, Result};

use super::place::Place;

/// A ball in which something has an influence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// The middle.
    pub center: [f32; 3],
    /// Where the influence ends, above 0.
    pub radius: f32,
    /// How it falls.
    pub falloff: Falloff,
}

impl Region {
    fn influence(&self, point: Vec3) -> f32 {
        self.falloff.at(point.distance(self.center.into()) / self.radius)
    }

    /// Whether there may be an influence within a box.
    fn reaches(&self, low: Vec3, high: Vec3) -> bool {
        let center = Vec3::from(self.center);
        // As far as `influence` says there is none, whatever is rounded.
        center.distance(center.clamp(low, high)) <= self.radius * 1.0001
    }

    fn is_usable(&self) -> bool {
        self.radius > 0.0 && self.radius.is_finite() && self.center.iter().all(|value| value.is_finite())
    }
}

/// What grabs a region, turns it about its middle and moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle {
    /// What is grabbed.
    pub region: Region,
    /// How far it moves.
    pub translation: [f32; 3],
    /// The axis it turns about, of length 1; of any where it does not turn.
    pub axis: [f32; 3],
    /// How far it turns, in radians.
    pub angle: f32,
}

/// Handles that act together, and regions that are held. Where influences of handles sum to more than 1, each has its
/// share; an anchor takes its influence away from all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edit {
    /// What moves.
    pub handles: Vec<Handle>,
    /// What stays.
    pub anchors: Vec<Region>,
}

impl Handle {
    /// Whether it moves or turns anything.
    pub(crate) fn is_moving(&self) -> bool {
        self.translation != [0.0; 3] || self.angle != 0.0
    }
}

impl Edit {
    /// Fails if a handle or anchor is not usable.
    pub(crate) fn check(&self) -> Result<()> {
        let Some(fault) = self.fault() else { return Ok(()) };
        Err(Error::invalid("it needs finite numbers, a radius above 0 and an axis of length 1").at(fault))
    }

    /// The first handle or anchor that is not usable.
    fn fault(&self) -> Option<String> {
        let is_usable = |handle: &Handle| {
            let axis = Vec3::from(handle.axis);
            handle.region.is_usable()
                && handle.translation.iter().all(|value| value.is_finite())
                && handle.angle.is_finite()
                && (handle.angle == 0.0 || (axis.is_finite() && (axis.length() - 1.0).abs() < 1e-3))
        };
        let handle = self.handles.iter().position(|handle| !is_usable(handle)).map(|index| format!("handle {index}"));
        let anchor = self.anchors.iter().position(|anchor| !anchor.is_usable()).map(|index| format!("anchor {index}"));
        handle.or(anchor)
    }

    /// Whether a handle may reach vertices within a box.
    pub(crate) fn reaches(&self, low: Vec3, high: Vec3) -> bool {
        low.x <= high.x && self.handles.iter().any(|handle| handle.region.reaches(low, high))
    }

    /// Where a vertex goes, if it is reached.
    pub(crate) fn moved(&self, place: Place) -> Option<Place> {
        let influences = self.handles.iter().map(|handle| handle.region.influence(place.point));
        let sum: f32 = influences.clone().sum();
        if sum <= 0.0 {
            return None;
        }
        let free: f32 = self.anchors.iter().map(|anchor| 1.0 - anchor.influence(place.point)).product();
        let share = free / sum.max(1.0);
        let (mut point, mut normal) = (place.point, place.normal);
        for (handle, influence) in self.handles.iter().zip(influences).filter(|(_, influence)| *influence > 0.0) {
            let turn = match handle.angle {
                0.0 => Quat::IDENTITY,
                angle => Quat::from_axis_angle(Vec3::from(handle.axis).normalize(), angle * influence * share),
            };
            let arm = place.point - Vec3::from(handle.region.center);
            point += turn * arm - arm + Vec3::from(handle.translation) * (influence * share);
            normal = turn * normal;
        }
        Some(Place { point, normal })
    }
}
