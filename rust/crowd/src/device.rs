//! The cut of a crowd on a graphics device, and its indexed draws there (Section 5.2, `shaders/crowd/crowd_cut.wgsl`).
//!
//! A device makes the decisions of [`Crowd::cut`] and the draws of [`DrawList`](crate::DrawList) in the same order, and leaves
//! them in its memory as arguments of indirect draws: the host sends transforms of agents that changed, and eight bytes an agent
//! for its pose. Poses of all clips stay on the device. Where square roots are rounded as the processor does, draws are equal;
//! elsewhere an agent at the limit of two steps, or a group of it, may take the other one. Neither opens cracks.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Scan, Sort, groups};

use crate::crowd::{Crowd, Drawn, Frame as Shown, Reach};
use crate::draws::{Draw, Instance, starts, too_large};
use crate::view::CrowdView;

/// Planes of a view at most.
const MOST_PLANES: usize = 63;
/// Words of a draw.
const WORDS: usize = 5;

/// As in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Call {
    agents: u32,
    planes: u32,
    buckets: u32,
    capacity: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ModelRow {
    first_step: u32,
    steps: u32,
    first_bucket: u32,
    first_cluster: u32,
    clusters: u32,
    first_group: u32,
    base_vertex: u32,
    first_start: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct AgentRow {
    center: [f32; 3],
    radius: f32,
    inverse: [[f32; 4]; 3],
    transform: [[f32; 4]; 3],
}

/// An agent in view, on a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct DeviceInstance {
    /// The agent.
    pub agent: u32,
    /// The first of the matrices of its pose in those of all poses.
    pub first_matrix: u32,
    /// The first of the weights of its morph targets in those of all poses.
    pub first_weight: u32,
    /// The model.
    pub model: u32,
    /// From the model to the world, by rows.
    pub transform: [[f32; 4]; 3],
}

const _: () = assert!(size_of::<AgentRow>() == 112 && size_of::<DeviceInstance>() == 64 && size_of::<ModelRow>() == 32);

/// What a device drew up, read back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviceDraws {
    /// Draws, as [`DrawList::draws`](crate::DrawList::draws).
    pub draws: Vec<Draw>,
    /// Model and cluster of every draw.
    pub clusters: Vec<[u32; 2]>,
    /// Agents in view. Their matrices count in those of all poses of all clips of all models.
    pub instances: Vec<Instance>,
    /// The first weight of the pose of each, in those of the same poses.
    pub first_weights: Vec<u32>,
}

impl DeviceDraws {
    /// Returns what is drawn as [`Crowd::cut`] says it, with a list of clusters for every agent.
    pub fn frame(&self) -> Shown {
        let mut shown =
            Shown { mixed: self.clusters.iter().map(|[_, cluster]| *cluster).collect(), ..Shown::default() };
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
        shown.drawn.sort_unstable_by_key(|(agent, _)| *agent);
        shown
    }
}

/// A crowd on a device.
#[derive(Debug)]
pub struct DeviceCrowd {
    device: Device,
    shared: Shared,
    work: Work,
    capacity: u32,
}

/// What models have, sent once.
#[derive(Debug)]
struct Shared {
    models: Buffer<ModelRow>,
    clusters: Buffer<[u32; 4]>,
    groups: Buffer<[f32; 8]>,
    ladders: Buffer<u32>,
    view: Buffer<[f32; 4]>,
    matrices: Buffer<[[f32; 4]; 3]>,
    weights: Buffer<f32>,
    weight_count: usize,
    /// The first matrix and the first weight of every clip of every model.
    clips: Vec<Vec<[u32; 2]>>,
    buckets: u32,
    kernels: [Arc<Kernel>; 5],
}

/// What agents have, for so many.
#[derive(Debug)]
struct Work {
    agents: Buffer<AgentRow>,
    poses: Buffer<[u32; 2]>,
    starts: Buffer<u32>,
    counts: Buffer<u32>,
    draws: Buffer<u32>,
    drawn: Buffer<[u32; 2]>,
    instances: Buffer<DeviceInstance>,
    /// What is sorted, which its kernels are bound to.
    _keys: [Buffer<u32>; 2],
    sort: Sort,
    scan: Scan,
    bindings: [Bindings; 2],
    /// The agents that were sent, by the number of the crowd's changes.
    sent: Option<u64>,
}

impl DeviceCrowd {
    /// Sends the models of a crowd to a device, and makes room for its agents and for `draws` draws.
    ///
    /// # Errors
    /// The device has no memory, or indices, vertices or matrices of all models do not fit 32 bits.
    pub fn new(device: &Device, crowd: &Crowd, draws: u32) -> Result<Self> {
        let shared = Shared::new(device, crowd)?;
        let work = Work::new(device, &shared, crowd.agents().len(), draws)?;
        Ok(Self { device: device.clone(), shared, work, capacity: draws })
    }

    /// Records the cut of a view at `time` seconds, after which the buffers of this crowd have its draws. Draws beyond the room
    /// that was made are left out, and counted: see [`Self::counts`].
    ///
    /// # Errors
    /// The view is not finite or has more than 63 planes, the crowd has other models, it asks for geomorphs or impostors, an
    /// agent has weights of its own, or the device has no memory or is lost.
    pub fn record(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&CrowdView, f64),
        frame: &mut Frame,
    ) -> Result<()> {
        view.check()?;
        if view.planes.len() > MOST_PLANES {
            return Err(Error::unsupported(format!("a view on a device has at most {MOST_PLANES} planes")).at("view"));
        }
        if crowd.models().len() != self.shared.clips.len() {
            return Err(Error::invalid("the crowd has other models than were sent").advise("make it for this crowd"));
        }
        if view.geomorph || view.impostors {
            return Err(Error::unsupported("geomorphs and impostors are of cuts on the processor")
                .advise("turn them off, or cut on the processor"));
        }
        if crowd.has_weights() {
            return Err(Error::unsupported("agents with weights of their own are cut on the processor")
                .advise("give them the weights of their clips, or cut on the processor"));
        }
        let count = crowd.agents().len();
        if count != self.work.poses.len() {
            self.work = Work::new(&self.device, &self.shared, count, self.capacity)?;
        }
        let (shared, work, device) = (&self.shared, &mut self.work, &self.device);
        let (reaches, changes) = crowd.reaches();
        if work.sent != Some(changes) {
            let rows = context.map(count, |at| row(&reaches[at], crowd.agents()[at].model));
            work.agents.write(device, 0, &rows)?;
            work.sent = Some(changes);
        }
        let poses = context.map(count, |at| {
            let agent = &crowd.agents()[at];
            let model = &crowd.models()[agent.model as usize].character;
            let first = shared.clips[agent.model as usize][agent.clip as usize];
            let pose = crowd.pose(agent, time) as u32;
            [first[0] + pose * model.bones.len() as u32, first[1] + pose * model.morphs.count]
        });
        work.poses.write(device, 0, &poses)?;
        let [x, y, z] = view.eye;
        let mut rows = vec![[x, y, z, view.tolerance / view.pixels]];
        rows.extend(&view.planes);
        shared.view.write(device, 0, &rows)?;

        frame.clear(&work.starts);
        frame.clear(&work.counts);
        frame.clear(&work.draws);
        let agents = count as u32;
        let planes = view.planes.len() as u32;
        let call = Call { agents, planes, buckets: shared.buckets, capacity: self.capacity };
        let call = bytemuck::bytes_of(&call);
        let bound = [&work.bindings[0], &work.bindings[1]];
        let [enlist, choose, count_seen, count_draws, write_draws] = &shared.kernels;
        let by_agent = groups(agents.div_ceil(GROUP));
        let bits = |largest: u32| u32::BITS - largest.leading_zeros();
        let mut pass = frame.pass("crowd cut");
        // By poses first: the second sort keeps their order among agents of one step.
        pass.run(enlist, &bound, call, by_agent)?;
        work.sort.run(&mut pass, agents, bits(shared.matrices.len() as u32))?;
        pass.run(choose, &bound, call, by_agent)?;
        work.sort.run(&mut pass, agents, bits(shared.buckets))?;
        pass.run(count_seen, &bound, call, by_agent)?;
        pass.run(count_draws, &bound, call, groups(agents))?;
        work.scan.run(&mut pass, agents + 1)?;
        pass.run(write_draws, &bound, call, groups(agents))
    }

    /// Cuts a view at `time` seconds, and reads the draws back. Makes room for more draws where there are more.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn cut(&mut self, context: &Context, crowd: &Crowd, view: &CrowdView, time: f64) -> Result<DeviceDraws> {
        let counted = self.update(context, crowd, view, time)?;
        self.read(counted)
    }

    /// Cuts a view at `time` seconds and leaves the draws on the device. Makes room for more draws where there are more. Returns
    /// the numbers of agents in view and of draws.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn update(&mut self, context: &Context, crowd: &Crowd, view: &CrowdView, time: f64) -> Result<[u32; 2]> {
        let counted = self.counted(context, crowd, view, time)?;
        if counted[1] <= self.capacity {
            return Ok(counted);
        }
        self.make_room(counted[1])?;
        self.counted(context, crowd, view, time)
    }

    /// Reads back so many agents in view and draws.
    ///
    /// # Errors
    /// There is no room for as many, or the device is lost.
    pub fn read(&self, counted: [u32; 2]) -> Result<DeviceDraws> {
        let [seen, found] = counted.map(|count| count as usize);
        let mut frame = self.device.frame()?;
        let draws = frame.read(&self.work.draws, 0..WORDS * found)?;
        let clusters = frame.read(&self.work.drawn, 0..found)?;
        let instances = frame.read(&self.work.instances, 0..seen)?;
        let _ = frame.submit()?;
        let draw = |words: &[u32; WORDS]| Draw {
            index_count: words[0],
            instance_count: words[1],
            first_index: words[2],
            base_vertex: words[3] as i32,
            first_instance: words[4],
        };
        let instance = |row: DeviceInstance| Instance {
            agent: row.agent,
            first_matrix: row.first_matrix,
            transform: row.transform,
        };
        let instances = instances.get(&self.device)?;
        Ok(DeviceDraws {
            draws: draws.get(&self.device)?.as_chunks().0.iter().map(draw).collect(),
            clusters: clusters.get(&self.device)?,
            first_weights: instances.iter().map(|row| row.first_weight).collect(),
            instances: instances.into_iter().map(instance).collect(),
        })
    }

    /// Makes room for so many draws. Those there are have to be recorded again.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn make_room(&mut self, draws: u32) -> Result<()> {
        self.work = Work::new(&self.device, &self.shared, self.work.poses.len(), draws)?;
        self.capacity = draws;
        Ok(())
    }

    /// Cuts a view, and returns the numbers of agents in view and of draws.
    fn counted(&mut self, context: &Context, crowd: &Crowd, view: &CrowdView, time: f64) -> Result<[u32; 2]> {
        let mut frame = self.device.frame()?;
        self.record(context, crowd, (view, time), &mut frame)?;
        let counts = frame.read(&self.work.counts, 0..2)?;
        let _ = frame.submit()?;
        counts.get(&self.device)?.try_into().map_err(|_| Error::internal("counts that cannot be read"))
    }

    /// Returns the arguments of draws: five words each, as of VkDrawIndexedIndirectCommand; those after the last are 0.
    pub fn draws(&self) -> &Buffer<u32> {
        &self.work.draws
    }

    /// Returns model and cluster of every draw; what is after the last is of frames before.
    pub fn clusters(&self) -> &Buffer<[u32; 2]> {
        &self.work.drawn
    }

    /// Returns the number of agents in view, and that of draws, as the first two words.
    pub fn counts(&self) -> &Buffer<u32> {
        &self.work.counts
    }

    /// Returns how many draws there is room for.
    pub fn room(&self) -> u32 {
        self.capacity
    }

    /// Returns the agents in view, in the order of their draws, those of a step in the order of their poses; what is after the
    /// last is of frames before.
    pub fn instances(&self) -> &Buffer<DeviceInstance> {
        &self.work.instances
    }

    /// Returns the skin matrices of all poses of all clips of all models, one model after the other.
    pub fn matrices(&self) -> &Buffer<[[f32; 4]; 3]> {
        &self.shared.matrices
    }

    /// Returns the weights of the morph targets of the same poses; without weights, a buffer that nothing reads.
    pub fn weights(&self) -> &Buffer<f32> {
        &self.shared.weights
    }

    /// Returns how many weights there are.
    pub fn weight_count(&self) -> usize {
        self.shared.weight_count
    }
}

/// Returns what the kernels have of an agent.
fn row(reach: &Reach, model: u32) -> AgentRow {
    let last = [reach.shrink, reach.evenness, f32::from_bits(model)];
    let inverse = std::array::from_fn(|axis| {
        let [x, y, z] = reach.inverse[axis];
        [x, y, z, last[axis]]
    });
    AgentRow { center: reach.center.to_array(), radius: reach.radius, inverse, transform: reach.transform }
}

impl Shared {
    fn new(device: &Device, crowd: &Crowd) -> Result<Self> {
        let (mut models, mut clusters, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut errors, mut ends, mut steps) = (Vec::new(), Vec::new(), Vec::<u32>::new());
        let (mut matrices, mut weights, mut clips) = (Vec::new(), Vec::new(), Vec::new());
        let mut buckets = 0;
        for ((number, model), [first_index, base_vertex]) in (0u32..).zip(crowd.models()).zip(starts(crowd)?) {
            let ladder = crowd.ladder(number).ok_or_else(|| Error::internal("a model without a ladder"))?;
            models.push(ModelRow {
                first_step: errors.len() as u32,
                steps: ladder.len() as u32,
                first_bucket: buckets,
                first_cluster: clusters.len() as u32,
                clusters: model.clusters.len() as u32,
                first_group: boxes.len() as u32,
                base_vertex,
                first_start: ends.len() as u32,
            });
            buckets += ladder.len() as u32 + 1;
            ends.push(steps.len());
            for step in 0..ladder.len() as u32 {
                errors.push(ladder.error(step).to_bits());
                steps.extend(ladder.clusters(step));
                ends.push(steps.len());
            }
            clusters.extend(
                model.clusters.iter().map(|it| [3 * it.count, first_index + 3 * it.first, it.made_by, it.used_by]),
            );
            boxes.extend(model.groups.iter().map(|it| {
                let ([a, b, c], [d, e, f]) = (it.low, it.high);
                [a, b, c, it.error, d, e, f, 0.0]
            }));
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
        u32::try_from(all.max(matrices.len())).map_err(|_| too_large("steps or matrices"))?;
        let mut ladders = errors;
        ladders.extend(ends.iter().map(|end| (first_step + end) as u32));
        ladders.extend(steps);
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_cut",
                entry,
                groups: &[&[Read; 7], &[Write; 7]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        Ok(Self {
            models: Buffer::of(device, "crowd models", &models)?,
            clusters: Buffer::of(device, "crowd clusters", &clusters)?,
            groups: Buffer::of(device, "crowd groups", &boxes)?,
            ladders: Buffer::of(device, "crowd ladders", &ladders)?,
            view: Buffer::new(device, "crowd view", MOST_PLANES + 1)?,
            matrices: Buffer::of(device, "crowd matrices", &matrices)?,
            weight_count: weights.len(),
            // Nothing empty can be bound.
            weights: Buffer::of(device, "crowd weights", if weights.is_empty() { &[0.0] } else { &weights })?,
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

impl Work {
    fn new(device: &Device, shared: &Shared, count: usize, draws: u32) -> Result<Self> {
        let agents = Buffer::new(device, "crowd agents", count)?;
        let poses = Buffer::new(device, "crowd poses", count)?;
        let keys = [Buffer::new(device, "crowd buckets", count)?, Buffer::new(device, "crowd order", count)?];
        let starts = Buffer::new(device, "crowd starts", count + 1)?;
        let counts = Buffer::new(device, "crowd counts", 2)?;
        let arguments = Buffer::new(device, "crowd draws", WORDS * draws as usize)?;
        let drawn = Buffer::new(device, "crowd drawn", draws as usize)?;
        let instances = Buffer::new(device, "crowd instances", count)?;
        let [buckets, order] = &keys;
        let (sort, scan) = (Sort::new(device, buckets, order)?, Scan::new(device, &starts, &counts)?);
        let read = [
            shared.models.wgpu(),
            shared.clusters.wgpu(),
            shared.groups.wgpu(),
            shared.ladders.wgpu(),
            agents.wgpu(),
            poses.wgpu(),
            shared.view.wgpu(),
        ];
        let written = [
            buckets.wgpu(),
            order.wgpu(),
            starts.wgpu(),
            counts.wgpu(),
            arguments.wgpu(),
            drawn.wgpu(),
            instances.wgpu(),
        ];
        let kernel = &shared.kernels[0];
        let bindings = [device.bind(kernel, 0, &read)?, device.bind(kernel, 1, &written)?];
        Ok(Self {
            agents,
            poses,
            starts,
            counts,
            draws: arguments,
            drawn,
            instances,
            _keys: keys,
            sort,
            scan,
            bindings,
            sent: None,
        })
    }
}
