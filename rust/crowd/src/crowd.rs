//! Agents, and what a view draws of them (Section 5.1).
//!
//! An agent that is far away against its size has nearly the same distance everywhere: its clusters are those of one step
//! of its model's [`Ladder`], for its nearest point. Only agents that are near are cut group by group. Both are free of
//! cracks and hold the error. An agent whose step of the last frame still fits is not searched for again.
//!
//! Decisions are in 32-bit floats, by sums, products and square roots in one order, so that a device makes the same
//! ([`crate::DeviceCrowd`]).

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, Vec3};
use relievo_core::{Context, Error, Result};

use crate::build::norm::norm;
use crate::clip::{BoneMatrix, Pose};
use crate::geomorph::{Geomorph, Limits};
use crate::hierarchy::{CrowdModel, Group, NONE};
use crate::impostor;
use crate::ladder::Ladder;
use crate::view::CrowdView;
use crate::weights::{Offsets, OwnWeights};

/// Agents of a crowd at most.
pub const MOST_AGENTS: usize = 1 << 24;
/// Depth of an agent against its distance up to which it is cut as a whole.
pub(crate) const DEEP: f32 = 0.25;
/// Rounding of the offset of a plane against its terms, by which clusters beyond it count as seen.
pub(crate) const SLACK: f32 = 1e-6;
/// Agents of one task.
const PART: usize = 256;
/// State of an agent that is not seen.
const OUTSIDE: u32 = u32::MAX;
/// State of an agent whose groups are looked at one by one.
const NEAR: u32 = u32::MAX - 1;
/// State of an agent that is an impostor.
const IMPOSTOR: u32 = u32::MAX - 3;
/// State of an agent that no frame has looked at.
const NEW: u32 = u32::MAX - 2;

/// A model placed in the world, with what it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agent {
    /// The model, as an index into the models of the crowd.
    pub model: u32,
    /// The clip, as an index into the clips of the model.
    pub clip: u32,
    /// Seconds that the agent is ahead in its clip.
    pub phase: f64,
    /// Where it is. Any map with an inverse, mirrors too.
    pub transform: DAffine3,
}

impl Agent {
    /// Returns the map from its model to the world in single precision, by rows.
    pub fn rows(&self) -> BoneMatrix {
        let map = self.transform;
        let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation];
        std::array::from_fn(|row| columns.map(|column| column[row] as f32))
    }
}

/// A sphere that an agent does not leave, its scale and its transform.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach {
    pub center: Vec3,
    pub radius: f32,
    /// One over the largest factor of lengths.
    pub shrink: f32,
    /// The largest factor of lengths.
    pub largest: f32,
    /// The smallest factor of lengths by the largest.
    pub evenness: f32,
    /// The inverse of the linear part of the transform, by rows.
    pub inverse: [[f32; 3]; 3],
    /// The transform, by rows.
    pub transform: BoneMatrix,
}

/// Models and agents.
#[derive(Debug)]
pub struct Crowd {
    models: Vec<Arc<CrowdModel>>,
    ladders: Vec<Ladder>,
    offsets: Vec<Offsets>,
    geomorphs: Vec<Geomorph>,
    agents: Vec<Agent>,
    /// Agents that show other weights of morph targets than their clips.
    weights: HashMap<u32, OwnWeights>,
    reaches: Vec<Reach>,
    /// What each agent was in the last frame: a step or one of the states.
    states: Vec<u32>,
    /// Counts changes of agents.
    changes: u64,
}

/// The pose of an agent. Agents with equal keys look alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PoseKey {
    /// The model.
    pub model: u32,
    /// The clip of the model.
    pub clip: u32,
    /// The pose of the clip.
    pub pose: u32,
    /// The agent, if it has weights of morph targets of its own, otherwise [`NONE`].
    pub own: u32,
}

/// What is drawn of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// A step of the ladder of its model.
    Step(u32),
    /// A part of [`Frame::mixed`].
    Mixed {
        /// The first cluster.
        first: u32,
        /// How many clusters there are.
        count: u32,
    },
    /// A quad: the picture that [`Impostors`](crate::Impostors) have.
    Impostor,
}

/// What a view draws.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Agents in view, in order, with their clusters.
    pub drawn: Vec<(u32, Drawn)>,
    /// Clusters of agents with errors that differ from place to place.
    pub mixed: Vec<u32>,
    /// For each of these how far its vertices are on the way to their targets, 0 to 1; empty unless vertices move.
    pub blends: Vec<f32>,
    /// Agents that are drawn by other clusters than in the last frame, or may be.
    pub changed: u32,
    /// Clusters that are drawn.
    pub clusters: u64,
    /// Triangles that are drawn.
    pub triangles: u64,
}

impl Frame {
    /// Returns the agents that are drawn as impostors, in order.
    pub fn impostors(&self) -> Vec<u32> {
        self.drawn.iter().filter(|(_, drawn)| *drawn == Drawn::Impostor).map(|(agent, _)| *agent).collect()
    }
}

impl Crowd {
    /// Makes a crowd without agents.
    pub fn new(models: Vec<Arc<CrowdModel>>) -> Self {
        Self {
            ladders: models.iter().map(|model| Ladder::new(model)).collect(),
            offsets: models.iter().map(|model| Offsets::of(model)).collect(),
            geomorphs: models.iter().map(|model| Geomorph::of(model)).collect(),
            models,
            agents: Vec::new(),
            weights: HashMap::new(),
            reaches: Vec::new(),
            states: Vec::new(),
            changes: 0,
        }
    }

    /// Returns the models.
    pub fn models(&self) -> &[Arc<CrowdModel>] {
        &self.models
    }

    /// Returns the ladder of a model.
    pub fn ladder(&self, model: u32) -> Option<&Ladder> {
        self.ladders.get(model as usize)
    }

    /// Returns the agents.
    pub fn agents(&self) -> &[Agent] {
        &self.agents
    }

    /// Returns where the agents reach, and a number that is another after every change of an agent.
    pub(crate) fn reaches(&self) -> (&[Reach], u64) {
        (&self.reaches, self.changes)
    }

    /// Checks an agent that may be added.
    ///
    /// # Errors
    /// Its model or clip does not exist, or its transform has no inverse.
    pub fn check(&self, agent: &Agent) -> Result<()> {
        self.reach(agent).map(drop)
    }

    /// Adds an agent and returns its index.
    ///
    /// # Errors
    /// Its model or clip does not exist, its transform has no inverse, or there are too many agents.
    pub fn add(&mut self, agent: Agent) -> Result<u32> {
        if self.agents.len() >= MOST_AGENTS {
            return Err(Error::unsupported(format!("a crowd has at most {MOST_AGENTS} agents")));
        }
        let reach = self.reach(&agent)?;
        self.agents.push(agent);
        self.reaches.push(reach);
        self.states.push(NEW);
        self.changes += 1;
        Ok(self.agents.len() as u32 - 1)
    }

    /// Moves an agent, or gives it another clip. Weights of its own stay, unless it gets another model.
    ///
    /// # Errors
    /// As [`Self::add`], or the agent does not exist.
    pub fn set(&mut self, index: u32, agent: Agent) -> Result<()> {
        let at = index as usize;
        if at >= self.agents.len() {
            return Err(absent(index));
        }
        let mut reach = self.reach(&agent)?;
        let before = self.agents[at];
        if before.model != agent.model {
            self.states[at] = NEW;
            self.weights.remove(&index);
        }
        if let Some(own) = self.weights.get(&index) {
            let clip = &self.models[agent.model as usize].clips[agent.clip as usize];
            if before.clip != agent.clip {
                let own = self.offsets[agent.model as usize].own((agent.clip, clip), &own.weights)?;
                self.weights.insert(index, own);
            }
            reach.widen(self.weights[&index].moved);
        }
        (self.agents[at], self.reaches[at]) = (agent, reach);
        self.changes += 1;
        Ok(())
    }

    /// Gives an agent weights of its own for all morph targets of its model, in place of those of its clip; `None` gives it
    /// those of the clip again. Its errors and boxes grow by what the difference may move its vertices. Such an agent is cut
    /// group by group at any distance.
    ///
    /// # Errors
    /// The agent does not exist, there is another number of weights than of morph targets, or one is not finite or too large.
    pub fn set_weights(&mut self, index: u32, weights: Option<&[f32]>) -> Result<()> {
        let agent = *self.agents.get(index as usize).ok_or_else(|| absent(index))?;
        let mut reach = self.reach(&agent)?;
        match weights {
            Some(weights) => {
                let clip = &self.models[agent.model as usize].clips[agent.clip as usize];
                let own = self.offsets[agent.model as usize].own((agent.clip, clip), weights)?;
                reach.widen(own.moved);
                self.weights.insert(index, own);
            }
            None => {
                self.weights.remove(&index);
            }
        }
        self.reaches[index as usize] = reach;
        self.changes += 1;
        Ok(())
    }

    /// Returns the weights that an agent has of its own.
    pub fn weights(&self, index: u32) -> Option<&[f32]> {
        self.weights.get(&index).map(|own| own.weights.as_slice())
    }

    /// Returns the agents with weights of their own, in order.
    pub(crate) fn own_weights(&self) -> Vec<(u32, &OwnWeights)> {
        let mut own: Vec<_> = self.weights.iter().map(|(index, own)| (*index, own)).collect();
        own.sort_unstable_by_key(|(index, _)| *index);
        own
    }

    /// Returns the limits of the groups of a model, which has a number.
    pub(crate) fn geomorph(&self, model: u32) -> &Geomorph {
        &self.geomorphs[model as usize]
    }

    /// Checks that all models say where vertices move.
    ///
    /// # Errors
    /// A model was read from a file of an older version.
    pub(crate) fn check_collapses(&self) -> Result<()> {
        if self.models.iter().all(|model| model.has_collapses()) {
            return Ok(());
        }
        Err(Error::unsupported("a model does not say where vertices move")
            .advise("build it again by `relievo crowd build`"))
    }

    /// Returns how far an agent may be outside the box of its model by weights of its own, in units of the model.
    pub(crate) fn moved(&self, index: u32) -> f32 {
        self.weights.get(&index).map_or(0.0, |own| own.moved)
    }

    /// Returns the pose that an agent has at `time` seconds, as an index into the poses of its clip.
    pub fn pose(&self, agent: &Agent, time: f64) -> usize {
        self.models[agent.model as usize].clips[agent.clip as usize].pose_at(time + agent.phase)
    }

    /// Returns what an agent looks like at `time` seconds.
    pub fn pose_key(&self, index: u32, time: f64) -> PoseKey {
        let agent = &self.agents[index as usize];
        let own = if self.weights.contains_key(&index) { index } else { NONE };
        PoseKey { model: agent.model, clip: agent.clip, pose: self.pose(agent, time) as u32, own }
    }

    /// Returns the pose of a key.
    pub fn posed(&self, key: &PoseKey) -> Cow<'_, Pose> {
        let pose = &self.models[key.model as usize].clips[key.clip as usize].poses[key.pose as usize];
        match self.weights.get(&key.own) {
            Some(own) => Cow::Owned(Pose { bones: pose.bones.clone(), weights: own.weights.clone() }),
            None => Cow::Borrowed(pose),
        }
    }

    /// Returns the clusters of an agent in a frame.
    pub fn clusters<'a>(&'a self, frame: &'a Frame, (agent, drawn): (u32, Drawn)) -> &'a [u32] {
        match drawn {
            Drawn::Step(step) => self.ladders[self.agents[agent as usize].model as usize].clusters(step),
            Drawn::Mixed { first, count } => &frame.mixed[first as usize..(first + count) as usize],
            Drawn::Impostor => &[],
        }
    }

    /// Returns how far the vertices of each of these clusters are on their way, 0 to 1; nothing where none moves.
    pub fn blends<'a>(&self, frame: &'a Frame, (_, drawn): (u32, Drawn)) -> &'a [f32] {
        match drawn {
            Drawn::Mixed { first, count } => {
                frame.blends.get(first as usize..(first + count) as usize).unwrap_or_default()
            }
            Drawn::Step(_) | Drawn::Impostor => &[],
        }
    }

    /// Finds what a view draws of every agent, and writes it over `frame`.
    ///
    /// # Errors
    /// The view is not finite, or vertices are to move and a model does not say where.
    pub fn cut(&mut self, context: &Context, view: &CrowdView, frame: &mut Frame) -> Result<()> {
        view.check()?;
        if view.geomorph {
            self.check_collapses()?;
        }
        let (agents, reaches, ladders, weights) = (&self.agents, &self.reaches, &self.ladders, &self.weights);
        let eye = Vec3::from(view.eye);
        let factor = view.tolerance / view.pixels;
        let radii: Vec<f32> = self.models.iter().map(|model| 0.5 * model.size()).collect();
        let mut before = context.scratch().list::<u32>();
        before.extend_from_slice(&self.states);
        context.for_each_part(self.states.as_mut_slice(), PART, |first, states| {
            for (state, index) in states.iter_mut().zip(first..) {
                let Reach { center, radius, shrink, .. } = reaches[index];
                let is_out = |plane: &[f32; 4]| {
                    let [x, y, z, d] = *plane;
                    x * center.x + y * center.y + z * center.z + d < -radius
                };
                if view.planes.iter().any(is_out) {
                    *state = OUTSIDE;
                    continue;
                }
                let near = center.distance(eye) - radius;
                let is_own = !weights.is_empty() && weights.contains_key(&(index as u32));
                let model = agents[index].model as usize;
                let away = near * shrink;
                let is_quad = view.impostors && !is_own && away > 0.0;
                *state = if is_quad && impostor::error(radii[model], away) <= factor * away {
                    IMPOSTOR
                } else if view.geomorph || is_own || 2.0 * radius > DEEP * near {
                    NEAR
                } else {
                    ladders[model].step(factor * away, *state)
                };
            }
            Ok(())
        })?;
        frame.drawn.clear();
        frame.mixed.clear();
        frame.blends.clear();
        (frame.changed, frame.clusters, frame.triangles) = (0, 0, 0);
        let near: Vec<u32> = self.states.iter().zip(0..).filter(|(state, _)| **state == NEAR).map(|it| it.1).collect();
        let cuts = context.map(near.len(), |index| self.near_cut(near[index], view));
        let mut cuts = cuts.into_iter();
        for (index, (state, before)) in self.states.iter().zip(before.iter()).enumerate() {
            frame.changed += u32::from(state != before || *state == NEAR);
            let model = self.agents[index].model as usize;
            match *state {
                OUTSIDE => {}
                NEAR => {
                    let (cut, blends) = cuts.next().unwrap_or_default();
                    frame.blends.extend(blends);
                    let first = frame.mixed.len() as u32;
                    frame.clusters += cut.len() as u64;
                    frame.triangles += self.models[model].triangle_count(&cut);
                    frame.mixed.extend(&cut);
                    frame.drawn.push((index as u32, Drawn::Mixed { first, count: cut.len() as u32 }));
                }
                IMPOSTOR => {
                    frame.triangles += 2;
                    frame.drawn.push((index as u32, Drawn::Impostor));
                }
                step => {
                    frame.clusters += self.ladders[model].clusters(step).len() as u64;
                    frame.triangles += self.ladders[model].triangles(step);
                    frame.drawn.push((index as u32, Drawn::Step(step)));
                }
            }
        }
        Ok(())
    }

    /// Returns the clusters of an agent by the distance of each group, without those out of view, and how far the vertices of
    /// each are on their way if they move.
    fn near_cut(&self, index: u32, view: &CrowdView) -> (Vec<u32>, Vec<f32>) {
        let number = self.agents[index as usize].model as usize;
        let model = &self.models[number];
        let reach = &self.reaches[index as usize];
        let own = self.weights.get(&index);
        let moved = own.map_or(0.0, |own| own.moved);
        let eye = reach.local(view.eye);
        // Distances in the model are longer in the world at least by the smallest scale, errors at most by the largest.
        let factor = view.tolerance / view.pixels * reach.evenness;
        let allowed = |group: &Group| factor * (distance(eye, group) - moved).max(0.0);
        let error = |group: usize| model.groups[group].error + own.map_or(0.0, |own| own.added[group]);
        let mut blends = Vec::new();
        let is_coarse: Vec<bool> = if view.geomorph {
            let geomorph = &self.geomorphs[number];
            let widened = own.map(|_| geomorph.widened(error));
            let limits = widened.as_deref().unwrap_or(geomorph.limits());
            let groups = model.groups.iter().zip(limits);
            let found = groups.map(|(group, limits): (&Group, &Limits)| {
                let allowed = allowed(group);
                (limits.end <= allowed, limits.blend(allowed))
            });
            let (is_coarse, moving): (Vec<bool>, Vec<f32>) = found.unzip();
            blends = moving;
            is_coarse
        } else {
            model.groups.iter().enumerate().map(|(at, group)| error(at) <= allowed(group)).collect()
        };
        let mut planes: Vec<[f32; 4]> = view.planes.iter().map(|plane| reach.plane(plane)).collect();
        for [x, y, z, d] in &mut planes {
            *d += moved * Vec3::new(*x, *y, *z).length();
        }
        let mut drawn = model.drawn(&is_coarse);
        if !planes.is_empty() {
            drawn.retain(|cluster| {
                let group = model.clusters[*cluster as usize].used_by as usize;
                model.groups.get(group).is_none_or(|group| planes.iter().all(|plane| reaches(plane, group)))
            });
        }
        if view.geomorph {
            let blend = |cluster: &u32| blends.get(model.clusters[*cluster as usize].used_by as usize).copied();
            let blends = drawn.iter().map(|cluster| blend(cluster).unwrap_or_default()).collect();
            return (drawn, blends);
        }
        (drawn, Vec::new())
    }

    fn reach(&self, agent: &Agent) -> Result<Reach> {
        let model = self.models.get(agent.model as usize).ok_or_else(|| {
            Error::invalid(format!("model {} does not exist", agent.model))
                .advise(format!("the crowd has {} models counted from 0", self.models.len()))
        })?;
        if agent.clip as usize >= model.clips.len() {
            return Err(Error::invalid(format!("clip {} does not exist", agent.clip))
                .advise(format!("the model has {} clips counted from 0", model.clips.len())));
        }
        let linear = agent.transform.matrix3;
        // Singular values lie between these bounds, which are equal for turns, mirrors and scales alike on all axes.
        let inverse = linear.inverse();
        let (largest, smallest) = (norm(&linear), 1.0 / norm(&inverse));
        let is_regular = agent.transform.is_finite() && linear.determinant() != 0.0 && inverse.is_finite();
        if !(is_regular && agent.phase.is_finite() && smallest > 0.0 && largest.is_finite()) {
            return Err(Error::invalid("the transform of an agent is not finite or has no inverse")
                .advise("give it a scale that is not zero on every axis"));
        }
        let (low, high) = (Vec3::from(model.low).as_dvec3(), Vec3::from(model.high).as_dvec3());
        let center = agent.transform.transform_point3(0.5 * (low + high)).as_vec3();
        let radius = (0.5 * (high - low).length() * largest) as f32 * (1.0 + 1e-6);
        let columns = [linear.x_axis, linear.y_axis, linear.z_axis, agent.transform.translation];
        Ok(Reach {
            center,
            radius,
            shrink: (1.0 / largest) as f32,
            largest: (largest * (1.0 + 1e-6)) as f32,
            evenness: (smallest / largest) as f32,
            inverse: std::array::from_fn(|row| inverse.row(row).as_vec3().to_array()),
            transform: std::array::from_fn(|row| columns.map(|column| column[row] as f32)),
        })
    }
}

impl Reach {
    /// Makes room for vertices that are up to `moved` units of the model outside its box.
    fn widen(&mut self, moved: f32) {
        self.radius += moved * self.largest;
    }

    /// Returns a place of the world in the space of the model.
    fn local(&self, place: [f32; 3]) -> Vec3 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| place[axis] - self.transform[axis][3]);
        Vec3::from_array(self.inverse.map(|row| row[0] * x + row[1] * y + row[2] * z))
    }

    /// Returns a plane of the world in the space of the model, moved outwards by what its offset may be rounded.
    fn plane(&self, [x, y, z, d]: &[f32; 4]) -> [f32; 4] {
        let rows = &self.transform;
        let turned = |axis: usize| x * rows[0][axis] + y * rows[1][axis] + z * rows[2][axis];
        let terms = [x * rows[0][3], y * rows[1][3], z * rows[2][3]];
        let rounded = SLACK * (terms[0].abs() + terms[1].abs() + terms[2].abs() + d.abs());
        [turned(0), turned(1), turned(2), terms[0] + terms[1] + terms[2] + d + rounded]
    }
}

fn absent(index: u32) -> Error {
    Error::invalid(format!("agent {index} does not exist"))
}

/// Returns the distance of a point from the box of a group.
fn distance(point: Vec3, group: &Group) -> f32 {
    let beyond = (Vec3::from(group.low) - point).max(point - Vec3::from(group.high)).max(Vec3::ZERO);
    beyond.length()
}

/// Whether the box of a group reaches to the inner side of a plane.
fn reaches([x, y, z, d]: &[f32; 4], group: &Group) -> bool {
    let far = |normal: f32, low: f32, high: f32| normal * if normal > 0.0 { high } else { low };
    let sum = far(*x, group.low[0], group.high[0])
        + far(*y, group.low[1], group.high[1])
        + far(*z, group.low[2], group.high[2]);
    sum + d >= 0.0
}
