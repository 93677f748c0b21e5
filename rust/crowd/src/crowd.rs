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
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, Vec3};
use relievo_core::{Context, Error, Result};

use crate::build::norm::norm;
use crate::clip::{BoneMatrix, Pose};
use crate::geomorph::Geomorph;
use crate::hierarchy::{CrowdModel, NONE};
use crate::impostor;
use crate::ladder::Ladder;
use crate::near::{GroupBoxes, NearCut, NearModel, Spheres};
use crate::sharing::{BoneBoxes, Sharing};
use crate::skinning::Blend;
use crate::stream::Stream;
use crate::view::CrowdView;
use crate::weights::{Offsets, OwnWeights};

/// Agents of a crowd at most.
pub const MAX_AGENTS: usize = 1 << 24;
/// Depth of an agent against its distance up to which it is cut as a whole.
pub(crate) const DEEP: f32 = 0.25;
/// Rounding of the offset of a plane against its terms, by which clusters beyond it count as seen.
pub(crate) const SLACK: f32 = 1e-6;
/// Agents of one task.
const CHUNK_LEN: usize = 256;
/// Agents that are near of one task.
const NEAR_PART: usize = 4;
/// How much further than by its number an error may be taken to be seen, where a device rounds otherwise.
const MARGIN: f32 = 1.0 + 1e-5;
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

/// What an agent was in the last frame.
#[derive(Clone, Copy, Debug)]
struct State {
    /// A step, or one of the states.
    cut: u32,
    /// The level of [`Sharing`] of its pose.
    level: u8,
}

impl State {
    const FRESH: Self = Self { cut: NEW, level: 0 };
}

/// What is derived from a model.
#[derive(Debug)]
struct Derived {
    ladder: Ladder,
    offsets: Offsets,
    geomorph: Geomorph,
    boxes: GroupBoxes,
    bones: BoneBoxes,
    /// For every clip the poses that stand for others; made when first needed.
    sharing: Vec<OnceLock<Sharing>>,
}

impl Derived {
    fn of(model: &CrowdModel) -> Self {
        Self {
            ladder: Ladder::new(model),
            offsets: Offsets::of(model),
            geomorph: Geomorph::of(model),
            boxes: GroupBoxes::of(model),
            bones: BoneBoxes::of(&model.character),
            sharing: vec![OnceLock::new(); model.clips.len()],
        }
    }
}

/// Models and agents.
#[derive(Debug)]
pub struct Crowd {
    models: Vec<Arc<CrowdModel>>,
    derived: Vec<Derived>,
    agents: Vec<Agent>,
    /// Agents that show other weights of morph targets than their clips.
    weights: HashMap<u32, OwnWeights>,
    reaches: Vec<Reach>,
    spheres: Spheres,
    states: Vec<State>,
    /// Agents that were near in the last frame, in order.
    near: Vec<NearCut>,
    /// Counts changes of agents.
    changes: u64,
    /// Clusters in memory, where cuts read them from files.
    pub(crate) stream: Option<Stream>,
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

/// How an agent in view is cut.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// As a whole, where so large an error may be seen, in units of its model.
    Whole(f32),
    /// Group by group.
    Near,
    Impostor,
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
            derived: models.iter().map(|model| Derived::of(model)).collect(),
            models,
            agents: Vec::new(),
            weights: HashMap::new(),
            reaches: Vec::new(),
            spheres: Spheres::default(),
            states: Vec::new(),
            near: Vec::new(),
            changes: 0,
            stream: None,
        }
    }

    /// Returns the models.
    pub fn models(&self) -> &[Arc<CrowdModel>] {
        &self.models
    }

    /// Returns the ladder of a model.
    pub fn ladder(&self, model: u32) -> Option<&Ladder> {
        self.derived.get(model as usize).map(|derived| &derived.ladder)
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
        if self.agents.len() >= MAX_AGENTS {
            return Err(Error::unsupported(format!("a crowd has at most {MAX_AGENTS} agents")));
        }
        let reach = self.reach(&agent)?;
        self.agents.push(agent);
        self.spheres.push(&reach);
        self.reaches.push(reach);
        self.states.push(State::FRESH);
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
            self.states[at] = State::FRESH;
            self.weights.remove(&index);
        }
        if before.clip != agent.clip {
            self.states[at].level = 0;
        }
        if let Some(own) = self.weights.get(&index) {
            let clip = &self.models[agent.model as usize].clips[agent.clip as usize];
            if before.clip != agent.clip {
                let own = self.derived[agent.model as usize].offsets.own((agent.clip, clip), &own.weights)?;
                self.weights.insert(index, own);
            }
            reach.widen(self.weights[&index].moved);
        }
        self.spheres.set(at, &reach);
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
                let own = self.derived[agent.model as usize].offsets.own((agent.clip, clip), weights)?;
                reach.widen(own.moved);
                self.weights.insert(index, own);
            }
            None => {
                self.weights.remove(&index);
            }
        }
        self.spheres.set(index as usize, &reach);
        self.reaches[index as usize] = reach;
        self.states[index as usize].level = 0;
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
        &self.derived[model as usize].geomorph
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

    /// Returns the pose that the clip of an agent has at `time` seconds.
    pub fn clip_key(&self, index: u32, time: f64) -> PoseKey {
        let agent = &self.agents[index as usize];
        let own = if self.weights.contains_key(&index) { index } else { NONE };
        PoseKey { model: agent.model, clip: agent.clip, pose: self.pose(agent, time) as u32, own }
    }

    /// Returns the pose that an agent is shown in at `time` seconds, for the view of the last cut: that of its clip, or one that
    /// stands for it where the difference and the error of its clusters together hold the budget of pixels.
    pub fn pose_key(&self, index: u32, time: f64) -> PoseKey {
        let key = self.clip_key(index, time);
        match self.states[index as usize].level {
            0 => key,
            level => PoseKey { pose: self.sharing(key.model, key.clip).shown(level, key.pose), ..key },
        }
    }

    /// Returns the pose that a view shows an agent in at `time` seconds, without a cut of the crowd.
    pub(crate) fn key_in(&self, index: u32, (view, time): (&CrowdView, f64)) -> PoseKey {
        let key = self.clip_key(index, time);
        let reach = &self.reaches[index as usize];
        let near = reach.center.distance(Vec3::from(view.eye)) - reach.radius;
        match self.kind(index as usize, near, view) {
            Kind::Whole(allowed) => {
                let step = self.derived[key.model as usize].ladder.step(allowed, NONE);
                let level = self.level(&self.agents[index as usize], step, allowed);
                PoseKey { pose: self.sharing(key.model, key.clip).shown(level, key.pose), ..key }
            }
            Kind::Near | Kind::Impostor => key,
        }
    }

    fn sharing(&self, model: u32, clip: u32) -> &Sharing {
        let (found, derived) = (&self.models[model as usize], &self.derived[model as usize]);
        derived.sharing[clip as usize].get_or_init(|| match found.blend {
            Blend::Linear => Sharing::of(&found.clips[clip as usize], &derived.bones, found.size()),
            // Differences of poses are bounded for matrices alone.
            Blend::DualQuaternion => Sharing::default(),
        })
    }

    /// Returns the level of shared poses of an agent that shows a step where an error of `allowed` may be seen.
    fn level(&self, agent: &Agent, step: u32, allowed: f32) -> u8 {
        let ladder = &self.derived[agent.model as usize].ladder;
        // A device that rounds otherwise may take the next step.
        let room = allowed - ladder.error(ladder.step(allowed * MARGIN, step));
        if room > 0.0 { self.sharing(agent.model, agent.clip).level(room) } else { 0 }
    }

    /// Returns how an agent in view is cut whose sphere is so far from the eye.
    fn kind(&self, index: usize, near: f32, view: &CrowdView) -> Kind {
        let Reach { radius, shrink, .. } = self.reaches[index];
        let is_own = !self.weights.is_empty() && self.weights.contains_key(&(index as u32));
        let model = &self.models[self.agents[index].model as usize];
        let away = near * shrink;
        let allowed = view.tolerance / view.pixels * away;
        // The error of a quad is below that of the coarsest clusters, which may be all that a stream has.
        let is_quad = view.impostors && self.stream.is_none() && !is_own && away > 0.0;
        if is_quad && impostor::error(0.5 * model.size(), away) <= allowed {
            Kind::Impostor
        } else if view.geomorph || is_own || 2.0 * radius > DEEP * near {
            Kind::Near
        } else {
            Kind::Whole(allowed)
        }
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
            Drawn::Step(step) => self.derived[self.agents[agent as usize].model as usize].ladder.clusters(step),
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
    /// The view is not finite, vertices are to move and a model does not say where, or a cluster that is read from a file is
    /// damaged.
    pub fn cut(&mut self, context: &Context, view: &CrowdView, frame: &mut Frame) -> Result<()> {
        view.check()?;
        if view.geomorph {
            self.check_collapses()?;
        }
        let mut states = std::mem::take(&mut self.states);
        let mut before = context.scratch().list::<u32>();
        before.extend(states.iter().map(|state| state.cut));
        let done = context.for_each_part(states.as_mut_slice(), CHUNK_LEN, |first, states| {
            self.choose(context, view, first, states);
            Ok(())
        });
        self.states = states;
        done?;
        let is_near = |(state, _): &(&State, u32)| state.cut == NEAR;
        let near =
            self.states.iter().zip(0..).filter(is_near).map(|(_, index)| (index, self.agents[index as usize].model));
        let mut cuts = NearCut::carry_over(std::mem::take(&mut self.near), near);
        let done = context.for_each_part(cuts.as_mut_slice(), NEAR_PART, |_, cuts| {
            for cut in cuts {
                let derived = &self.derived[cut.model as usize];
                let model = &self.models[cut.model as usize];
                let of = NearModel { model, boxes: &derived.boxes, geomorph: &derived.geomorph };
                cut.update(context, of, (&self.reaches[cut.agent as usize], self.weights.get(&cut.agent)), view);
            }
            Ok(())
        });
        self.near = cuts;
        done?;
        frame.drawn.clear();
        frame.mixed.clear();
        frame.blends.clear();
        (frame.changed, frame.clusters, frame.triangles) = (0, 0, 0);
        let mut cuts = self.near.iter();
        for (index, (State { cut, .. }, before)) in self.states.iter().zip(before.iter()).enumerate() {
            frame.changed += u32::from(cut != before || *cut == NEAR);
            let model = self.agents[index].model as usize;
            match *cut {
                OUTSIDE => {}
                NEAR => {
                    let Some(NearCut { drawn, blends, .. }) = cuts.next() else { continue };
                    frame.blends.extend(blends);
                    let first = frame.mixed.len() as u32;
                    frame.clusters += drawn.len() as u64;
                    frame.triangles += self.models[model].triangle_count(drawn);
                    frame.mixed.extend(drawn);
                    frame.drawn.push((index as u32, Drawn::Mixed { first, count: drawn.len() as u32 }));
                }
                IMPOSTOR => {
                    frame.triangles += 2;
                    frame.drawn.push((index as u32, Drawn::Impostor));
                }
                step => {
                    let ladder = &self.derived[model].ladder;
                    frame.clusters += ladder.clusters(step).len() as u64;
                    frame.triangles += ladder.triangles(step);
                    frame.drawn.push((index as u32, Drawn::Step(step)));
                }
            }
        }
        if let Some(mut stream) = self.stream.take() {
            let done = stream.update(self, frame);
            self.stream = Some(stream);
            done?;
        }
        Ok(())
    }

    /// Sets what the agents from `first` on are in a view.
    fn choose(&self, context: &Context, view: &CrowdView, first: usize, states: &mut [State]) {
        let (mut near, mut inside) = ([0.0; CHUNK_LEN], [1.0; CHUNK_LEN]);
        let (near, inside) = (&mut near[..states.len()], &mut inside[..states.len()]);
        self.spheres.measure(context.level(), first, view, near, inside);
        for (at, state) in states.iter_mut().enumerate() {
            let index = first + at;
            *state = if inside[at] == 0.0 {
                State { cut: OUTSIDE, level: 0 }
            } else {
                match self.kind(index, near[at], view) {
                    Kind::Near => State { cut: NEAR, level: 0 },
                    Kind::Impostor => State { cut: IMPOSTOR, level: 0 },
                    Kind::Whole(allowed) => {
                        let agent = &self.agents[index];
                        let step = self.derived[agent.model as usize].ladder.step(allowed, state.cut);
                        State { cut: step, level: self.level(agent, step, allowed) }
                    }
                }
            };
        }
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
    pub(crate) fn local(&self, place: [f32; 3]) -> Vec3 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|axis| place[axis] - self.transform[axis][3]);
        Vec3::from_array(self.inverse.map(|row| row[0] * x + row[1] * y + row[2] * z))
    }

    /// Returns a plane of the world in the space of the model, moved outwards by what its offset may be rounded.
    pub(crate) fn plane(&self, [x, y, z, d]: &[f32; 4]) -> [f32; 4] {
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
