//! Geomorphs (Hoppe 1996): vertices of a group move to where its simplification leaves them while the error that may be
//! seen grows to that of the group, so that nothing jumps where a cut changes.
//!
//! A group moves only once all groups below it are coarse. Then all clusters that it simplifies are drawn, and they have all
//! triangles at the places that move: places of its border stay. So surfaces stay closed. Each place is removed by one group
//! at most, because all levels use places of the input.

use crate::hierarchy::{CrowdModel, NONE};

/// Ratio of the limits of a group and of those below it at least, so that each has a range to move in.
const RATIO: f32 = 1.05;

/// Where a vertex goes when its place is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collapse {
    /// The group whose simplification removes its place, [`NONE`] if no group does.
    pub group: u32,
    /// A vertex of the place that it goes to, which a later group may remove; the vertex itself if no group removes it.
    pub target: u32,
}

/// The groups below each group, for limits.
#[derive(Clone, Debug, Default)]
pub(crate) struct Geomorph {
    below: Vec<Vec<u32>>,
    limits: Vec<Limits>,
}

/// The error that may be seen from which the vertices of a group move, and from which it is coarse, in units of the model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Limits {
    pub start: f32,
    pub end: f32,
}

impl Limits {
    /// Returns how far the vertices of a group are on their way where an error of `allowed` may be seen, 0 to 1.
    pub fn blend(self, allowed: f32) -> f32 {
        if allowed > self.start { ((allowed - self.start) / (self.end - self.start)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl Geomorph {
    pub fn of(model: &CrowdModel) -> Self {
        let mut below: Vec<Vec<u32>> = vec![Vec::new(); model.groups.len()];
        for cluster in model.clusters.iter().filter(|cluster| cluster.made_by != NONE) {
            if let Some(list) = below.get_mut(cluster.used_by as usize)
                && !list.contains(&cluster.made_by)
            {
                list.push(cluster.made_by);
            }
        }
        let mut made = Self { below, limits: Vec::new() };
        made.limits = made.widened(|group| model.groups[group].error);
        made
    }

    /// Returns the limits of every group by the errors of the model.
    pub fn limits(&self) -> &[Limits] {
        &self.limits
    }

    /// Returns the limits of every group by some errors, which grow upwards.
    pub fn widened(&self, error: impl Fn(usize) -> f32) -> Vec<Limits> {
        let mut limits: Vec<Limits> = Vec::with_capacity(self.below.len());
        // Groups come after those below them.
        for (group, below) in self.below.iter().enumerate() {
            let start = below.iter().map(|it| limits[*it as usize].end).fold(0.0, f32::max);
            limits.push(Limits { start, end: error(group).max(RATIO * start) });
        }
        limits
    }
}

impl CrowdModel {
    /// Whether the model says where vertices go, as geomorphs need; files of versions 1 and 2 do not.
    pub fn has_collapses(&self) -> bool {
        self.collapses.len() == self.character.points.len()
    }

    /// Returns the vertex that one of a cluster moves to while its group is simplified, if it moves.
    pub fn target(&self, cluster: u32, vertex: u32) -> Option<u32> {
        let group = self.clusters[cluster as usize].used_by;
        let found = self.collapses.get(vertex as usize).filter(|found| group != NONE && found.group == group)?;
        Some(found.target)
    }

    /// Returns the value of a vertex of a cluster that is `blend` of the way to its target, 0 to 1, among the values of all
    /// vertices.
    pub fn blended(&self, (cluster, blend): (u32, f32), vertex: u32, values: &[[f32; 3]]) -> [f32; 3] {
        let from = values[vertex as usize];
        match self.target(cluster, vertex) {
            Some(target) if blend > 0.0 => {
                let to = values[target as usize];
                std::array::from_fn(|axis| from[axis] + blend * (to[axis] - from[axis]))
            }
            _ => from,
        }
    }
}
