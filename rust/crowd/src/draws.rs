//! Draw lists: what a frame shows as indexed, instanced draws, for graphics devices and hosts (Section 5.2).
//!
//! The vertices and the indices of all models lie one model after the other in one buffer each. Agents that show the same
//! clusters of a model are instances of the same draws, and agents in the same pose share its skin matrices.

use std::collections::HashMap;

use relievo_core::{Error, Result};

use crate::clip::BoneMatrix;
use crate::crowd::{Crowd, Drawn, Frame, PoseKey};

/// Arguments of an indexed draw, as graphics devices read them (`VkDrawIndexedIndirectCommand`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Draw {
    /// Three for each triangle of the cluster.
    pub index_count: u32,
    /// Agents that show the cluster.
    pub instance_count: u32,
    /// The first index in the indices of all models, or in those of the slots of a [`Stream`](crate::Stream).
    pub first_index: u32,
    /// The first vertex of the model in the vertices of all models.
    pub base_vertex: i32,
    /// The first of its instances.
    pub first_instance: u32,
}

/// An agent that is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instance {
    /// The agent.
    pub agent: u32,
    /// The first of the skin matrices of its pose.
    pub first_matrix: u32,
    /// The map from its model to the world: three rows of four numbers.
    pub transform: BoneMatrix,
}

/// The draws of a frame.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    /// Draws, those of the same instances one after the other.
    pub draws: Vec<Draw>,
    /// Model and cluster of every draw.
    pub clusters: Vec<[u32; 2]>,
    /// For each draw how far its vertices are on the way to their targets, 0 to 1.
    pub blends: Vec<f32>,
    /// Agents that are shown by clusters.
    pub instances: Vec<Instance>,
    /// Skin matrices of the poses that are shown, one pose after the other: one for each bone of the model.
    pub matrices: Vec<BoneMatrix>,
    /// Weights of the morph targets of these poses, one pose after the other.
    pub weights: Vec<f32>,
    /// The first of the weights of the pose of every instance.
    pub first_weights: Vec<u32>,
}

impl DrawList {
    /// Finds the draws of a frame of a crowd at `time` seconds, and writes them over this list.
    ///
    /// # Errors
    /// The indices of all models exceed 32 bits, or their vertices 31, or matrices 32.
    pub fn update(&mut self, crowd: &Crowd, frame: &Frame, time: f64) -> Result<()> {
        self.draws.clear();
        self.clusters.clear();
        self.blends.clear();
        self.instances.clear();
        self.matrices.clear();
        self.weights.clear();
        self.first_weights.clear();
        let starts = starts(crowd)?;
        let model = |agent: u32| crowd.agents()[agent as usize].model;
        let mut order: Vec<usize> = (0..frame.drawn.len()).filter(|at| frame.drawn[*at].1 != Drawn::Impostor).collect();
        // Agents of one step are drawn together, those in one pose one after the other; each of the others is drawn alone, unless
        // a stream draws the same coarser clusters for several.
        let is_streamed = crowd.stream().is_some();
        order.sort_by_cached_key(|at| {
            let (agent, drawn) = frame.drawn[*at];
            let [step, first] = match drawn {
                Drawn::Step(step) => [step, 0],
                Drawn::Mixed { first, .. } if is_streamed => [u32::MAX, first],
                Drawn::Mixed { .. } | Drawn::Impostor => [u32::MAX, 0],
            };
            (model(agent), step, first, crowd.pose_key(agent, time), agent)
        });
        let mut poses: HashMap<PoseKey, [u32; 2]> = HashMap::new();
        let is_alike = |a: &usize, b: &usize| match (frame.drawn[*a], frame.drawn[*b]) {
            ((one, Drawn::Step(a)), (other, Drawn::Step(b))) => a == b && model(one) == model(other),
            ((_, a @ Drawn::Mixed { .. }), (_, b)) => is_streamed && a == b,
            _ => false,
        };
        for alike in order.chunk_by(is_alike) {
            let first_instance = self.instances.len() as u32;
            for at in alike {
                let agent = frame.drawn[*at].0;
                let found = &crowd.agents()[agent as usize];
                let key = crowd.pose_key(agent, time);
                let [first_matrix, first_weight] = match poses.get(&key) {
                    Some(first) => *first,
                    None => {
                        let matrix = u32::try_from(self.matrices.len()).map_err(|_| too_large("matrices"))?;
                        let weight = u32::try_from(self.weights.len()).map_err(|_| too_large("weights"))?;
                        let pose = crowd.posed(&key);
                        self.matrices.extend(&pose.bones);
                        self.weights.extend(&pose.weights);
                        *poses.entry(key).or_insert([matrix, weight])
                    }
                };
                self.first_weights.push(first_weight);
                self.instances.push(Instance { agent, first_matrix, transform: found.rows() });
            }
            let drawn = frame.drawn[alike[0]];
            let number = model(drawn.0);
            let [first_index, base_vertex] = starts[number as usize];
            let blends = crowd.blends(frame, drawn);
            for (at, cluster) in crowd.clusters(frame, drawn).iter().enumerate() {
                let found = &crowd.models()[number as usize].clusters[*cluster as usize];
                self.draws.push(Draw {
                    index_count: 3 * found.count,
                    instance_count: alike.len() as u32,
                    first_index: match crowd.stream() {
                        Some(stream) => 3 * stream.first_triangle(number, *cluster),
                        None => first_index + 3 * found.first,
                    },
                    base_vertex: base_vertex as i32,
                    first_instance,
                });
                self.clusters.push([number, *cluster]);
                self.blends.push(blends.get(at).copied().unwrap_or_default());
            }
        }
        Ok(())
    }
}

/// Returns the first index and the first vertex of every model.
pub(crate) fn starts(crowd: &Crowd) -> Result<Vec<[u32; 2]>> {
    let mut next = [0u64; 2];
    let models = crowd.models().iter();
    models
        .map(|model| {
            let [index, vertex] = next;
            // Indices of a stream are those of its slots.
            let triangles = if crowd.stream().is_some() { 0 } else { model.character.triangles.len() as u64 };
            next = [index + 3 * triangles, vertex + model.character.points.len() as u64];
            if next[0] > u64::from(u32::MAX) || next[1] > i32::MAX as u64 {
                return Err(too_large("indices or vertices"));
            }
            Ok([index as u32, vertex as u32])
        })
        .collect()
}

pub(crate) fn too_large(what: &str) -> Error {
    Error::unsupported(format!("the {what} of all models do not fit 32 bits")).advise("use fewer or smaller models")
}
