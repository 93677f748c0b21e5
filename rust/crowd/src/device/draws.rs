//! What a device drew up for a view, read back.

use crate::crowd::{Drawn, Frame as Shown};
use crate::draws::{Draw, Instance};

/// What a device drew up, read back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviceDraws {
    /// Draws, as [`DrawList::draws`](crate::DrawList::draws).
    pub draws: Vec<Draw>,
    /// Model and cluster of every draw.
    pub clusters: Vec<[u32; 2]>,
    /// How far the vertices of every draw are on the way to their targets, 0 to 1.
    pub blends: Vec<f32>,
    /// Agents in view. Their matrices count in those of all poses of all clips of all models.
    pub instances: Vec<Instance>,
    /// The first weight of each, in those of the same poses and of agents with weights of their own.
    pub first_weights: Vec<u32>,
    /// Agents that are drawn as impostors, in order.
    pub impostors: Vec<u32>,
}

impl DeviceDraws {
    /// Returns what is drawn as [`Crowd::cut`] says it, with a list of clusters for every agent.
    pub fn frame(&self) -> Shown {
        let mixed = self.clusters.iter().map(|[_, cluster]| *cluster).collect();
        let mut shown = Shown { mixed, blends: self.blends.clone(), ..Shown::default() };
        // An agent whose clusters are all out of view has no draws.
        shown.drawn = self.instances.iter().map(|it| (it.agent, Drawn::Mixed { first: 0, count: 0 })).collect();
        let mut first = 0;
        // All draws of an instance are one after the other.
        for alike in self.draws.chunk_by(|a, b| a.first_instance == b.first_instance) {
            let Draw { first_instance, instance_count, .. } = alike[0];
            let part = Drawn::Mixed { first, count: alike.len() as u32 };
            first += alike.len() as u32;
            let instances = shown.drawn.iter_mut().skip(first_instance as usize).take(instance_count as usize);
            instances.for_each(|drawn| drawn.1 = part);
            shown.clusters += u64::from(instance_count) * alike.len() as u64;
            let triangles: u64 = alike.iter().map(|draw| u64::from(draw.index_count / 3)).sum();
            shown.triangles += u64::from(instance_count) * triangles;
        }
        shown.drawn.extend(self.impostors.iter().map(|agent| (*agent, Drawn::Impostor)));
        shown.triangles += 2 * self.impostors.len() as u64;
        shown.drawn.sort_unstable_by_key(|(agent, _)| *agent);
        shown
    }
}
