//! Agents that are near, cut group by group (Section 5.1).
//!
//! The errors that may be seen of all groups of a model are found many at a time. Groups seldom become fine or coarse from one
//! frame to the next; while none of an agent does, its clusters are those of the last frame, and only what is in view is found
//! anew.

use glam::Vec3;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, dispatch_simd};

use crate::crowd::Reach;
use crate::geomorph::{Geomorph, Limits};
use crate::hierarchy::{CrowdModel, NONE};
use crate::view::CrowdView;
use crate::weights::OwnWeights;

/// The groups of a model, number by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroupBoxes {
    low: [Vec<f32>; 3],
    high: [Vec<f32>; 3],
    errors: Vec<f32>,
}

impl GroupBoxes {
    pub fn of(model: &CrowdModel) -> Self {
        let groups = &model.groups;
        Self {
            low: std::array::from_fn(|axis| groups.iter().map(|group| group.low[axis]).collect()),
            high: std::array::from_fn(|axis| groups.iter().map(|group| group.high[axis]).collect()),
            errors: groups.iter().map(|group| group.error).collect(),
        }
    }
}

/// What an agent that is near draws.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearCut {
    pub agent: u32,
    pub model: u32,
    /// The groups that are coarse.
    is_coarse: Vec<bool>,
    /// The clusters of these groups, in view or not.
    clusters: Vec<u32>,
    /// The clusters in view.
    pub drawn: Vec<u32>,
    /// For each of these how far its vertices are on the way to their targets, 0 to 1; empty unless vertices move.
    pub blends: Vec<f32>,
}

/// A model as cuts need it.
#[derive(Clone, Copy)]
pub(crate) struct NearModel<'a> {
    pub model: &'a CrowdModel,
    pub boxes: &'a GroupBoxes,
    pub geomorph: &'a Geomorph,
}

impl NearCut {
    /// Makes the list of cuts of some agents, given by agent and model in order, from that of the last frame.
    pub fn carry_over(before: Vec<Self>, near: impl Iterator<Item = (u32, u32)>) -> Vec<Self> {
        let mut before = before.into_iter().peekable();
        near.map(|(agent, model)| {
            while before.next_if(|cut| cut.agent < agent).is_some() {}
            let same = before.next_if(|cut| (cut.agent, cut.model) == (agent, model));
            same.unwrap_or_else(|| Self { agent, model, ..Self::default() })
        })
        .collect()
    }

    /// Finds the clusters by the distance of each group, those in view, and how far the vertices of each are on their way if
    /// they move.
    pub fn update(
        &mut self,
        context: &Context,
        of: NearModel<'_>,
        (reach, own): (&Reach, Option<&OwnWeights>),
        view: &CrowdView,
    ) {
        let NearModel { model, boxes, geomorph } = of;
        let count = model.groups.len();
        let moved = own.map_or(0.0, |own| own.moved);
        let mut allowed = context.scratch().list::<f32>();
        allowed.resize(count, 0.0);
        // Distances in the model are longer in the world at least by the smallest scale, errors at most by the largest.
        let factor = view.tolerance / view.pixels * reach.evenness;
        let eye = reach.local(view.eye).to_array();
        let [low, high] = [&boxes.low, &boxes.high].map(|side| side.each_ref().map(Vec::as_slice));
        errors_allowed(context.level(), &mut allowed, (low, high), eye, (factor, moved));
        let own_limits = own
            .filter(|_| view.geomorph)
            .map(|own| geomorph.widened(|group| model.groups[group].error + own.added[group]));
        let limits: &[Limits] = own_limits.as_deref().unwrap_or(geomorph.limits());
        let is_coarse = |group: usize| {
            if view.geomorph {
                return limits[group].end <= allowed[group];
            }
            boxes.errors[group] + own.map_or(0.0, |own| own.added[group]) <= allowed[group]
        };
        let is_new = self.clusters.is_empty() || self.is_coarse.len() != count;
        self.is_coarse.resize(count, false);
        let mut has_changed = is_new;
        for (group, known) in self.is_coarse.iter_mut().enumerate() {
            let now = is_coarse(group);
            has_changed |= *known != now;
            *known = now;
        }
        if has_changed {
            self.clusters = model.drawn(&self.is_coarse);
        }
        self.drawn.clear();
        self.blends.clear();
        if view.planes.is_empty() {
            self.drawn.extend(&self.clusters);
        } else {
            // 1 for groups in view.
            let mut inside = context.scratch().list::<f32>();
            inside.resize(count, 1.0);
            for plane in &view.planes {
                let [x, y, z, mut d] = reach.plane(plane);
                d += moved * Vec3::new(x, y, z).length();
                let far = |axis: usize, normal: f32| if normal > 0.0 { high[axis] } else { low[axis] };
                clip(context.level(), &mut inside, [far(0, x), far(1, y), far(2, z)], [x, y, z, d]);
            }
            let is_seen = |cluster: &&u32| {
                inside.get(model.clusters[**cluster as usize].used_by as usize).is_none_or(|inside| *inside > 0.0)
            };
            self.drawn.extend(self.clusters.iter().filter(is_seen));
        }
        if view.geomorph {
            let blend = |cluster: &u32| match model.clusters[*cluster as usize].used_by {
                NONE => 0.0,
                group => limits[group as usize].blend(allowed[group as usize]),
            };
            self.blends.extend(self.drawn.iter().map(blend));
        }
    }
}

dispatch_simd! {
    /// Writes the error that may be seen of each group, in units of the model: the distance of its box from the eye, less what
    /// vertices may be outside, by a factor.
    fn errors_allowed = errors_allowed_body(
        allowed: &mut [f32],
        boxes: ([&[f32]; 3], [&[f32]; 3]),
        eye: [f32; 3],
        factors: (f32, f32),
    )
}

#[inline(always)]
fn errors_allowed_body<A: Arithmetic>(
    _: A,
    allowed: &mut [f32],
    (low, high): ([&[f32]; 3], [&[f32]; 3]),
    eye: [f32; 3],
    (factor, moved): (f32, f32),
) {
    let count = allowed.len();
    let [low, high] = [low, high].map(|side| side.map(|values| &values[..count]));
    for (at, allowed) in allowed.iter_mut().enumerate() {
        let beyond = |axis: usize| (low[axis][at] - eye[axis]).max(eye[axis] - high[axis][at]).max(0.0);
        let [x, y, z] = [beyond(0), beyond(1), beyond(2)];
        let distance = (x * x + y * y + z * z).sqrt();
        *allowed = factor * (distance - moved).max(0.0);
    }
}

dispatch_simd! {
    /// Writes 0 where a corner of a box is beyond a plane.
    fn clip = clip_body(inside: &mut [f32], corner: [&[f32]; 3], plane: [f32; 4])
}

#[inline(always)]
fn clip_body<A: Arithmetic>(_: A, inside: &mut [f32], corner: [&[f32]; 3], [x, y, z, d]: [f32; 4]) {
    let corner = corner.map(|values| &values[..inside.len()]);
    for (at, inside) in inside.iter_mut().enumerate() {
        let sum = x * corner[0][at] + y * corner[1][at] + z * corner[2][at];
        *inside = if sum + d >= 0.0 { *inside } else { 0.0 };
    }
}

/// Spheres of agents, number by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spheres {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    radius: Vec<f32>,
}

impl Spheres {
    pub fn push(&mut self, reach: &Reach) {
        let [x, y, z] = reach.center.to_array();
        for (list, value) in [(&mut self.x, x), (&mut self.y, y), (&mut self.z, z), (&mut self.radius, reach.radius)] {
            list.push(value);
        }
    }

    pub fn set(&mut self, index: usize, reach: &Reach) {
        [self.x[index], self.y[index], self.z[index]] = reach.center.to_array();
        self.radius[index] = reach.radius;
    }

    /// Writes how far the spheres from `first` on are from the eye, and 0 in place of 1 where one is beyond a plane.
    pub fn measure(&self, level: Level, first: usize, view: &CrowdView, near: &mut [f32], inside: &mut [f32]) {
        let range = first..first + near.len();
        let parts = [&self.x[range.clone()], &self.y[range.clone()], &self.z[range.clone()], &self.radius[range]];
        measure(level, near, inside, parts, view.eye, &view.planes);
    }
}

dispatch_simd! {
    /// Writes how far spheres are from the eye, and 0 in `inside` where one is beyond a plane.
    fn measure = measure_body(
        near: &mut [f32],
        inside: &mut [f32],
        spheres: [&[f32]; 4],
        eye: [f32; 3],
        planes: &[[f32; 4]],
    )
}

#[inline(always)]
fn measure_body<A: Arithmetic>(
    _: A,
    near: &mut [f32],
    inside: &mut [f32],
    spheres: [&[f32]; 4],
    eye: [f32; 3],
    planes: &[[f32; 4]],
) {
    let count = near.len();
    let [x, y, z, radius] = spheres.map(|values| &values[..count]);
    for (at, near) in near.iter_mut().enumerate() {
        let [x, y, z] = [x[at] - eye[0], y[at] - eye[1], z[at] - eye[2]];
        *near = (x * x + y * y + z * z).sqrt() - radius[at];
    }
    let inside = &mut inside[..count];
    for [a, b, c, d] in planes {
        for (at, inside) in inside.iter_mut().enumerate() {
            let is_out = a * x[at] + b * y[at] + c * z[at] + d < -radius[at];
            *inside = if is_out { 0.0 } else { *inside };
        }
    }
}
