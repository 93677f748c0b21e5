//! What a device has of the agents of a crowd: room for so many, and for so many draws.

use relievo_core::Result;
use relievo_gpu::wgsl::crowd_agents::Agent;
use relievo_gpu::wgsl::crowd_cut::Instance;
use relievo_gpu::{Bindings, Buffer, Device, Scan, Sort, wgpu};

use super::rows::SEEN;
use super::shared::Shared;

/// Words of a draw.
pub(super) const WORDS: usize = 5;

/// Rows of agents, and what cuts leave.
#[derive(Debug)]
pub(super) struct Work {
    pub agents: Buffer<Agent>,
    pub poses: Buffer<[u32; 2]>,
    /// Whether agents were seen in the last frame, and whether others hide them.
    pub states: Buffer<u32>,
    /// Whether the cluster of each draw is hidden, and how many are.
    pub draw_states: Buffer<u32>,
    pub starts: Buffer<u32>,
    pub counts: Buffer<u32>,
    pub draws: Buffer<u32>,
    pub drawn: Buffer<[u32; 2]>,
    pub blends: Buffer<f32>,
    pub instances: Buffer<Instance>,
    keys: [Buffer<u32>; 2],
    pub sort: Sort,
    pub scan: Scan,
    /// Of the kernels' three groups, of which the first has the agents.
    pub bindings: [Bindings; 3],
    /// The agents that were sent, by the number of the crowd's changes.
    pub sent: Option<u64>,
}

impl Work {
    pub fn new(device: &Device, shared: &Shared, count: usize, draws: u32) -> Result<Self> {
        let keys = [Buffer::new(device, "crowd buckets", count)?, Buffer::new(device, "crowd order", count)?];
        let starts = Buffer::new(device, "crowd starts", count + 1)?;
        let counts = Buffer::new(device, "crowd counts", 4)?;
        let [buckets, order] = &keys;
        let (sort, scan) = (Sort::new(device, buckets, order)?, Scan::new(device, &starts, &counts)?);
        let agents = Buffer::new(device, "crowd agents", count)?;
        let poses = Buffer::<[u32; 2]>::new(device, "crowd poses", count)?;
        let states = Buffer::<u32>::new(device, "crowd states", count)?;
        let draw_states = Buffer::<u32>::new(device, "crowd states of draws", draws as usize + 1)?;
        let arguments = Buffer::new(device, "crowd draws", WORDS * draws as usize)?;
        let drawn = Buffer::new(device, "crowd drawn", draws as usize)?;
        let blends = Buffer::new(device, "crowd blends", draws as usize)?;
        let instances = Buffer::new(device, "crowd instances", count)?;
        let written = [
            buckets.wgpu(),
            order.wgpu(),
            starts.wgpu(),
            counts.wgpu(),
            arguments.wgpu(),
            drawn.wgpu(),
            instances.wgpu(),
            blends.wgpu(),
        ];
        let kernel = &shared.kernels[0];
        let bindings = [
            device.bind(kernel, 0, &[shared.models.wgpu(), agents.wgpu(), shared.view.wgpu()])?,
            bind_models(device, shared, poses.wgpu(), states.wgpu())?,
            device.bind(kernel, 2, &written)?,
        ];
        // All count as seen before the first frame.
        states.write(device, 0, &vec![SEEN; count])?;
        Ok(Self {
            agents,
            poses,
            states,
            draw_states,
            starts,
            counts,
            draws: arguments,
            drawn,
            blends,
            instances,
            keys,
            sort,
            scan,
            bindings,
            sent: None,
        })
    }

    /// Binds the buffers of the models again, of which some are new.
    ///
    /// # Errors
    /// The device was lost.
    pub fn rebind(&mut self, device: &Device, shared: &Shared) -> Result<()> {
        self.bindings[1] = bind_models(device, shared, self.poses.wgpu(), self.states.wgpu())?;
        Ok(())
    }

    /// Returns the agents in the order of the last cut: those with clusters, then impostors.
    pub fn order(&self) -> &Buffer<u32> {
        &self.keys[1]
    }
}

/// Binds what models have, with the poses and the states of agents.
fn bind_models(device: &Device, shared: &Shared, poses: &wgpu::Buffer, states: &wgpu::Buffer) -> Result<Bindings> {
    let read =
        [shared.clusters.wgpu(), shared.groups.wgpu(), shared.ladders.wgpu(), poses, shared.own.limits.wgpu(), states];
    device.bind(&shared.kernels[0], 1, &read)
}
