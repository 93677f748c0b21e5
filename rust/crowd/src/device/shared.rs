//! What a device has of the models of a crowd, sent once.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::crowd_agents::Model;
use relievo_gpu::wgsl::crowd_cut::{Call, Cluster, Group};
use relievo_gpu::{Access, Buffer, Device, Kernel, KernelSpec};

use super::MAX_PLANES;
use super::own::OwnRows;
use crate::crowd::Crowd;
use crate::draws::{starts, too_large};

/// Hierarchies, poses of all clips, the view, and the kernels.
#[derive(Debug)]
pub(super) struct Shared {
    pub models: Buffer<Model>,
    pub clusters: Buffer<Cluster>,
    pub groups: Buffer<Group>,
    pub ladders: Buffer<u32>,
    pub view: Buffer<[f32; 4]>,
    pub matrices: Buffer<[[f32; 4]; 3]>,
    pub own: OwnRows,
    /// The first matrix and the first weight of every clip of every model.
    pub clips: Vec<Vec<[u32; 2]>>,
    pub buckets: u32,
    pub kernels: [Arc<Kernel>; 5],
}

impl Shared {
    pub fn new(device: &Device, crowd: &Crowd) -> Result<Self> {
        let (mut models, mut clusters, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut errors, mut ends, mut steps) = (Vec::new(), Vec::new(), Vec::<u32>::new());
        let (mut matrices, mut weights, mut clips) = (Vec::new(), Vec::new(), Vec::new());
        let mut limits = Vec::new();
        let mut buckets = 0;
        for ((number, model), [first_index, base_vertex]) in (0u32..).zip(crowd.models()).zip(starts(crowd)?) {
            let ladder = crowd.ladder(number).ok_or_else(|| Error::internal("a model without a ladder"))?;
            models.push(Model {
                first_step: errors.len() as u32,
                steps: ladder.len() as u32,
                first_bucket: buckets,
                first_cluster: clusters.len() as u32,
                clusters: model.clusters.len() as u32,
                first_group: boxes.len() as u32,
                base_vertex,
                first_start: ends.len() as u32,
                low: model.low,
                radius: 0.5 * model.size(),
                high: model.high,
                padding: 0,
            });
            buckets += ladder.len() as u32 + 1;
            ends.push(steps.len());
            for step in 0..ladder.len() as u32 {
                errors.push(ladder.error(step).to_bits());
                steps.extend(ladder.clusters(step));
                ends.push(steps.len());
            }
            clusters.extend(model.clusters.iter().map(|it| Cluster {
                indices: 3 * it.count,
                first_index: first_index + 3 * it.first,
                made_by: it.made_by,
                used_by: it.used_by,
            }));
            boxes.extend(model.groups.iter().map(|it| Group { low: it.low, high: it.high, ..Group::default() }));
            let moving = crowd.geomorph(number).limits();
            limits.extend(model.groups.iter().zip(moving).map(|(group, it)| [group.error, it.start, it.end, 0.0]));
            let mut firsts = Vec::new();
            for clip in &model.clips {
                let first = |at: usize, what| u32::try_from(at).map_err(|_| too_large(what));
                firsts.push([first(matrices.len(), "matrices")?, first(weights.len(), "weights")?]);
                for pose in &clip.poses {
                    matrices.extend(&pose.bones);
                    weights.extend(&pose.weights);
                }
            }
            clips.push(firsts);
        }
        // Errors, where the clusters of steps begin, and these, in one list.
        let (first_start, first_step) = (errors.len(), errors.len() + ends.len());
        models.iter_mut().for_each(|model| model.first_start += first_start as u32);
        let all = first_step + steps.len();
        // Agents are sorted by twice the number of a matrix.
        u32::try_from(all.max(2 * matrices.len() + 1)).map_err(|_| too_large("steps or matrices"))?;
        let mut ladders = errors;
        ladders.extend(ends.iter().map(|end| (first_step + end) as u32));
        ladders.extend(steps);
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_cut",
                entry,
                groups: &[&[Read; 3], &[Read; 6], &[Write; 8]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        Ok(Self {
            models: Buffer::of(device, "crowd models", &models)?,
            clusters: Buffer::of(device, "crowd clusters", &clusters)?,
            groups: Buffer::of(device, "crowd groups", &boxes)?,
            ladders: Buffer::of(device, "crowd ladders", &ladders)?,
            view: Buffer::new(device, "crowd view", MAX_PLANES + 1)?,
            matrices: Buffer::of(device, "crowd matrices", &matrices)?,
            own: OwnRows::new(device, limits, weights)?,
            clips,
            buckets,
            kernels: [
                kernel("enlist")?,
                kernel("choose")?,
                kernel("count_seen")?,
                kernel("count_draws")?,
                kernel("write_draws")?,
            ],
        })
    }
}
