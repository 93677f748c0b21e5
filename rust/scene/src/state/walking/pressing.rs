//! Crowds that press: each agent is a collider in its pose, of the triangles of one level of the model.
//!
//! The level is the same at all times, so that an agent only moves its points. Poses are those of the clip; between two of
//! them points go on straight lines.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_crowd::{Agent, CrowdModel, Ladder, skin_some};
use relievo_detail::{Collider, Motion, Obb, Pose};

use crate::format::description::{CrowdColliderEntry, CrowdEntry};
use crate::state::checksum::checksum;
use crate::state::paths::Paths;
use crate::state::walking::Loaded;

/// Parts of a frame's way at most: colliders number their steps in 16 bits.
const MAX_PARTS: f64 = 4096.0;

/// A crowd whose agents press.
#[derive(Debug)]
pub(crate) struct Pressing {
    /// Vertices of the character that the level has.
    vertices: Vec<u32>,
    /// The collider that those of agents are copies of.
    collider: Collider,
    checksums: [u32; 2],
}

impl Pressing {
    /// Chooses the level and makes its collider in the first pose of the first clip.
    ///
    /// # Errors
    /// The files of the crowd cannot be read, or its triangles cannot be a collider.
    pub fn new(
        context: &Context,
        paths: &Paths,
        (loaded, crowd): (&Loaded, &CrowdEntry),
        entry: &CrowdColliderEntry,
    ) -> Result<Self> {
        let checksums = [checksum(&paths.resolve(&crowd.file.text)?)?, checksum(&paths.resolve(&crowd.agents.text)?)?];
        let model = &loaded.model;
        model.check_triangles()?;
        let ladder = Ladder::new(model);
        let fits = |step: &u32| ladder.triangles(*step) <= entry.triangles;
        let steps = ladder.len() as u32;
        let step = (0..steps).find(fits).unwrap_or(steps.saturating_sub(1));
        let (mut numbers, mut vertices, mut triangles) = (HashMap::new(), Vec::new(), Vec::new());
        for cluster in ladder.clusters(step) {
            triangles.extend(model.triangles(*cluster).iter().map(|corners| {
                corners.map(|vertex| {
                    *numbers.entry(vertex).or_insert_with(|| {
                        vertices.push(vertex);
                        vertices.len() as u32 - 1
                    })
                })
            }));
        }
        let points = posed(context, model, &vertices, [0, 0])?;
        let collider = Collider::new(context, points, triangles, DAffine3::IDENTITY)?;
        Ok(Self { vertices, collider, checksums })
    }

    /// Returns the collider that those of agents are copies of.
    pub fn collider(&self) -> &Collider {
        &self.collider
    }

    /// Returns checksums of the model and of the list of agents.
    pub fn checksums(&self) -> [u32; 2] {
        self.checksums
    }

    /// Returns in how many parts a way of some seconds is cut, so that each takes an agent from one pose to the next.
    pub fn parts(&self, loaded: &Loaded, seconds: f64) -> u32 {
        let moving = loaded.model.clips.iter().filter(|clip| clip.poses.len() > 1);
        let rate = moving.map(|clip| f64::from(clip.rate)).fold(0.0, f64::max);
        // Times of frames are rounded: what is a whole number of poses must not become one more.
        (seconds * rate - 1e-6).ceil().clamp(1.0, MAX_PARTS) as u32
    }

    /// Returns a box in the world that an agent does not leave between two times, where its start is `carried` along with
    /// the surface.
    pub fn reach(&self, loaded: &Loaded, agent: usize, times: [f64; 2], carried: &DAffine3) -> Option<Obb> {
        let [from, to] = agents(loaded, agent, times)?;
        let (low, high) = (DVec3::from(loaded.model.low.map(f64::from)), DVec3::from(loaded.model.high.map(f64::from)));
        let whole = Obb::from_interval(DMat3::IDENTITY, low, high);
        let start = *carried * from.transform;
        let ways = whole
            .corners()
            .map(|corner| (start.transform_point3(corner) - to.transform.transform_point3(corner)).length());
        // A turn of up to half a circle is at most so much longer than the line between its ends.
        let farthest = FRAC_PI_2 * ways.into_iter().fold(0.0, f64::max);
        Some(whole.transformed(&to.transform).enlarged(farthest))
    }

    /// Returns the collider of an agent and its motion between two times, where its start is `carried` along with the
    /// surface.
    ///
    /// # Errors
    /// The agent does not exist, or a transform or pose cannot be used.
    pub fn motion(
        &self,
        context: &Context,
        (loaded, agent): (&Loaded, usize),
        times: [f64; 2],
        carried: &DAffine3,
    ) -> Result<(Collider, Motion)> {
        let missing = || Error::internal(format!("agent {agent} does not exist"));
        let [from, to] = agents(loaded, agent, times).ok_or_else(missing)?;
        let model = &loaded.model;
        let pose = |time: f64| model.clips.get(from.clip as usize).map_or(0, |clip| clip.pose_at(time + from.phase));
        let [first, last] = times.map(pose);
        let points = |pose: usize| posed(context, model, &self.vertices, [from.clip as usize, pose]);
        let mut collider = self.collider.clone();
        let ends = if first == last {
            collider.set_points(context, &points(first)?)?;
            [None, None]
        } else {
            [Some(points(first)?.into()), Some(points(last)?.into())]
        };
        let pose = |transform: DAffine3, points: Option<Arc<[[f32; 3]]>>| Pose { transform, points };
        let [start, end] = ends;
        let (start, end) = (pose(*carried * from.transform, start), pose(to.transform, end));
        let motion = Motion::new(&collider, start, end)?;
        Ok((collider, motion))
    }
}

/// Returns an agent at two times.
fn agents(loaded: &Loaded, agent: usize, times: [f64; 2]) -> Option<[Agent; 2]> {
    let walker = loaded.walkers.get(agent)?;
    Some(times.map(|time| loaded.placed(walker.at(time))))
}

/// Returns the places of some vertices in a pose of a clip.
fn posed(context: &Context, model: &CrowdModel, vertices: &[u32], [clip, pose]: [usize; 2]) -> Result<Vec<[f32; 3]>> {
    let found = model.clips.get(clip).and_then(|clip| clip.poses.get(pose));
    let pose = found.ok_or_else(|| Error::internal(format!("clip {clip} has no pose {pose}")))?;
    skin_some(context, &model.character, pose, model.blend, vertices)
}
