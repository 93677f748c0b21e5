//! Weights that agents have of their own, and the limits of their groups, after those of all models in the same buffers.

use std::collections::BTreeMap;

use relievo_core::Result;
use relievo_gpu::{Buffer, Device};

use crate::crowd::Crowd;
use crate::draws::too_large;

/// Where an agent has its own limits and weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own {
    pub first_limit: u32,
    pub first_weight: u32,
    pub moved: f32,
}

/// Limits of groups and weights of morph targets: those of the models and their poses, then those of agents.
#[derive(Debug)]
pub(super) struct OwnRows {
    /// Those of the models.
    shared_limits: Vec<[f32; 4]>,
    shared_weights: Vec<f32>,
    pub limits: Buffer<[f32; 4]>,
    pub weights: Buffer<f32>,
    /// How many weights all poses have, and how many there are with those of agents.
    pose_weights: usize,
    pub weight_count: usize,
    pub agents: BTreeMap<u32, Own>,
}

impl OwnRows {
    pub fn new(device: &Device, mut limits: Vec<[f32; 4]>, mut weights: Vec<f32>) -> Result<Self> {
        let pose_weights = weights.len();
        // Nothing empty can be bound.
        limits.resize(limits.len().max(1), [0.0; 4]);
        weights.resize(weights.len().max(1), 0.0);
        Ok(Self {
            limits: Buffer::of(device, "crowd limits", &limits)?,
            weights: Buffer::of(device, "crowd weights", &weights)?,
            pose_weights,
            weight_count: pose_weights,
            agents: BTreeMap::new(),
            shared_limits: limits,
            shared_weights: weights,
        })
    }

    /// Writes the weights that the agents of a crowd have of their own. Returns whether there are other buffers now.
    ///
    /// # Errors
    /// The device has no memory, or there are too many for 32 bits.
    pub fn update(&mut self, device: &Device, crowd: &Crowd) -> Result<bool> {
        let (mut limits, mut weights) = (Vec::new(), Vec::new());
        let [first_limit, first_weight] = [self.shared_limits.len(), self.pose_weights];
        self.agents.clear();
        for (index, own) in crowd.own_weights() {
            let number = crowd.agents()[index as usize].model;
            let groups = &crowd.models()[number as usize].groups;
            let error = |group: usize| groups[group].error + own.added[group];
            let first = |at: usize, what| u32::try_from(at).map_err(|_| too_large(what));
            let place = Own {
                first_limit: first(first_limit + limits.len(), "limits")?,
                first_weight: first(first_weight + weights.len(), "weights")?,
                moved: own.moved,
            };
            self.agents.insert(index, place);
            let widened = crowd.geomorph(number).widened(error);
            limits.extend(widened.iter().enumerate().map(|(at, it)| [error(at), it.start, it.end, 0.0]));
            weights.extend(&own.weights);
        }
        let is_larger =
            first_limit + limits.len() > self.limits.len() || first_weight + weights.len() > self.weights.len();
        if is_larger {
            // As many again, so that the next agents need no new room.
            let room = |shared: usize, own: usize| shared + own.next_power_of_two();
            self.limits = Buffer::new(device, "crowd limits", room(first_limit, limits.len()))?;
            self.weights = Buffer::new(device, "crowd weights", room(self.shared_weights.len(), weights.len()))?;
            self.limits.write(device, 0, &self.shared_limits)?;
            self.weights.write(device, 0, &self.shared_weights)?;
        }
        self.weight_count = first_weight + weights.len();
        self.limits.write(device, first_limit, &limits)?;
        self.weights.write(device, first_weight, &weights)?;
        Ok(is_larger)
    }
}
