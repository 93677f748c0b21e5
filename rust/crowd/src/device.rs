//! The cut of a crowd on a graphics device, and its indexed draws there (Section 5.2, `shaders/crowd/crowd_cut.wgsl`).
//!
//! A device makes the decisions of [`Crowd::cut`] and the draws of [`DrawList`](crate::DrawList) in the same order, and leaves
//! them in its memory as arguments of indirect draws: the host sends transforms of agents that changed, weights of their own, and
//! eight bytes an agent for its pose. Poses of all clips stay on the device. Where square roots are rounded as the processor does,
//! draws are equal; elsewhere an agent at the limit of two steps, or a group of it, may take the other one. Neither opens cracks.

mod draws;
mod occlusion;
mod own;
mod pose;
mod quads;
mod room;
mod rows;
mod shared;
mod work;

use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::crowd_cut::Call;
pub use relievo_gpu::wgsl::crowd_cut::Instance as DeviceInstance;
use relievo_gpu::{Buffer, Device, Frame, GROUP, groups};

pub use self::draws::DeviceDraws;
pub use self::occlusion::{DeviceOcclusion, DeviceUnhidden};
pub use self::pose::{DevicePosed, DevicePoser, Look};
pub use self::quads::DeviceQuads;

use self::rows::{GEOMORPH, HIDDEN, IMPOSTORS, SEEN, agent_row};
use self::shared::Shared;
use self::work::{WORDS, Work};
use crate::crowd::Crowd;
use crate::draws::{Draw, Instance};
use crate::view::CrowdView;

/// Planes of a view at most.
const MAX_PLANES: usize = 63;

/// What a cut counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceCounted {
    /// Agents in view that are drawn by clusters.
    pub agents: u32,
    /// Draws.
    pub draws: u32,
    /// Triangles of all instances, without those of impostors.
    pub triangles: u32,
    /// Agents that are drawn as impostors.
    pub impostors: u32,
}

impl DeviceCounted {
    /// Returns what the words of [`DeviceCrowd::counts`] say.
    ///
    /// # Errors
    /// There are not four of them.
    pub fn read(words: Vec<u32>) -> Result<Self> {
        let [agents, draws, triangles, impostors] =
            words.try_into().map_err(|_| Error::internal("counts that cannot be read"))?;
        Ok(Self { agents, draws, triangles, impostors })
    }
}

/// Which agents a cut looks at, or is posed of it, as in the kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    All = 0,
    /// Agents that were seen in the last frame.
    Occluders = 1,
    /// Agents that no others hide.
    Visible = 2,
}

/// A crowd on a device.
#[derive(Debug)]
pub struct DeviceCrowd {
    device: Device,
    shared: Shared,
    work: Work,
    capacity: u32,
    /// Planes and options of the view.
    view: [u32; 2],
}

impl DeviceCrowd {
    /// Sends the models of a crowd to a device, and makes room for its agents and for `draws` draws.
    ///
    /// # Errors
    /// The device has no memory, indices, vertices or matrices of all models do not fit 32 bits, or clusters are read while they
    /// are drawn.
    pub fn new(device: &Device, crowd: &Crowd, draws: u32) -> Result<Self> {
        crowd.check_whole()?;
        let shared = Shared::new(device, crowd)?;
        let work = Work::new(device, &shared, crowd.agents().len(), draws)?;
        Ok(Self { device: device.clone(), shared, work, capacity: draws, view: [0; 2] })
    }

    /// Records the cut of a view at `time` seconds, after which the buffers of this crowd have its draws. Draws beyond the room
    /// that was made are left out, and counted: see [`Self::counts`].
    ///
    /// # Errors
    /// The view is not finite or has more than 63 planes, the crowd has other models, vertices are to move and a model does not
    /// say where, or the device has no memory or is lost.
    pub fn record(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&CrowdView, f64),
        frame: &mut Frame,
    ) -> Result<()> {
        self.send(context, crowd, (view, time))?;
        self.record_part(Part::All, frame)
    }

    /// Sends the view, the poses, and agents that changed.
    fn send(&mut self, context: &Context, crowd: &Crowd, (view, time): (&CrowdView, f64)) -> Result<()> {
        view.check()?;
        if view.planes.len() > MAX_PLANES {
            return Err(Error::unsupported(format!("a view on a device has at most {MAX_PLANES} planes")).at("view"));
        }
        if crowd.models().len() != self.shared.clips.len() {
            return Err(Error::invalid("the crowd has other models than were sent").advise("make it for this crowd"));
        }
        if view.geomorph {
            crowd.check_collapses()?;
        }
        let count = crowd.agents().len();
        if count != self.work.poses.len() {
            self.work = Work::new(&self.device, &self.shared, count, self.capacity)?;
        }
        let device = &self.device;
        let (reaches, changes) = crowd.reaches();
        if self.work.sent != Some(changes) {
            if self.shared.own.update(device, crowd)? {
                self.work.rebind(device, &self.shared)?;
            }
            let own = &self.shared.own.agents;
            let rows = context.map(count, |at| {
                let own = own.get(&(at as u32)).map(|own| (own.first_limit, own.moved));
                agent_row(&reaches[at], crowd.agents()[at].model, own)
            });
            self.work.agents.write(device, 0, &rows)?;
            self.work.sent = Some(changes);
        }
        let shared = &self.shared;
        let poses = context.map(count, |at| {
            let agent = &crowd.agents()[at];
            let model = &crowd.models()[agent.model as usize].character;
            let first = shared.clips[agent.model as usize][agent.clip as usize];
            let pose = crowd.key_in(at as u32, (view, time)).pose;
            let weight = first[1] + pose * model.morphs.count;
            let own = shared.own.agents.get(&(at as u32)).map_or(weight, |own| own.first_weight);
            [first[0] + pose * model.bones.len() as u32, own]
        });
        self.work.poses.write(device, 0, &poses)?;
        let [x, y, z] = view.eye;
        let mut rows = vec![[x, y, z, view.tolerance / view.pixels]];
        rows.extend(&view.planes);
        shared.view.write(device, 0, &rows)?;
        let option = |is_on: bool, option: u32| if is_on { option } else { 0 };
        let options = option(view.geomorph, GEOMORPH) | option(view.impostors, IMPOSTORS);
        self.view = [view.planes.len() as u32, options];
        Ok(())
    }

    /// Records the cut of some of the agents for the view that was sent.
    fn record_part(&self, part: Part, frame: &mut Frame) -> Result<()> {
        let (shared, work) = (&self.shared, &self.work);
        frame.clear(&work.starts);
        frame.clear(&work.counts);
        frame.clear(&work.draws);
        let agents = work.poses.len() as u32;
        let [planes, options] = self.view;
        let (buckets, capacity) = (shared.buckets, self.capacity);
        let call = Call { agents, planes, buckets, capacity, options, which: part as u32 };
        let call = bytemuck::bytes_of(&call);
        let bound = work.bindings.each_ref();
        let [enlist, choose, count_seen, count_draws, write_draws] = &shared.kernels;
        let by_agent = groups(agents.div_ceil(GROUP));
        let bits = |largest: u32| u32::BITS - largest.leading_zeros();
        let mut pass = frame.pass("crowd cut");
        // By poses first: the second sort keeps their order among agents of one step.
        pass.run(enlist, &bound, call, by_agent)?;
        work.sort.run(&mut pass, agents, bits(2 * shared.matrices.len() as u32 + 1))?;
        pass.run(choose, &bound, call, by_agent)?;
        work.sort.run(&mut pass, agents, bits(shared.buckets + 1))?;
        pass.run(count_seen, &bound, call, [1, 1, 1])?;
        pass.run(count_draws, &bound, call, groups(agents))?;
        work.scan.run(&mut pass, agents + 1)?;
        pass.run(write_draws, &bound, call, groups(agents))
    }

    /// Lets all agents count as seen in the last frame.
    fn forget_seen(&self) -> Result<()> {
        self.work.states.write(&self.device, 0, &vec![SEEN; self.work.states.len()])
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
    /// how many there are of what.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn update(&mut self, context: &Context, crowd: &Crowd, view: &CrowdView, time: f64) -> Result<DeviceCounted> {
        let counted = self.counted(context, crowd, view, time)?;
        if counted.draws <= self.capacity {
            return Ok(counted);
        }
        self.make_room(counted.draws)?;
        self.counted(context, crowd, view, time)
    }

    /// Reads back the draws that were counted.
    ///
    /// # Errors
    /// There is no room for as many, or the device is lost.
    pub fn read(&self, counted: DeviceCounted) -> Result<DeviceDraws> {
        let [seen, found] = [counted.agents, counted.draws].map(|count| count as usize);
        let mut frame = self.device.frame()?;
        let draws = frame.read(&self.work.draws, 0..WORDS * found)?;
        let clusters = frame.read(&self.work.drawn, 0..found)?;
        let blends = frame.read(&self.work.blends, 0..found)?;
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
        let mut impostors = self.impostors(counted)?;
        impostors.sort_unstable();
        Ok(DeviceDraws {
            draws: draws.get(&self.device)?.as_chunks().0.iter().map(draw).collect(),
            clusters: clusters.get(&self.device)?,
            blends: blends.get(&self.device)?,
            first_weights: instances.iter().map(|row| row.first_weight).collect(),
            instances: instances.into_iter().map(instance).collect(),
            impostors,
        })
    }

    /// Reads back the agents that are drawn as impostors, in the order of [`Self::instances`].
    ///
    /// # Errors
    /// They are not those of the last cut, or the device is lost.
    pub fn impostors(&self, counted: DeviceCounted) -> Result<Vec<u32>> {
        if counted.impostors == 0 {
            return Ok(Vec::new());
        }
        let [seen, quads] = [counted.agents, counted.impostors].map(|count| count as usize);
        let mut frame = self.device.frame()?;
        let agents = frame.read(self.work.order(), seen..seen + quads)?;
        let _ = frame.submit()?;
        agents.get(&self.device)
    }

    /// Reads back the agents in view that others hide, ascending, after [`DeviceOcclusion::update`]; none where it rested.
    ///
    /// # Errors
    /// The device is lost.
    pub fn hidden(&self) -> Result<Vec<u32>> {
        let states = &self.work.states;
        if states.is_empty() {
            return Ok(Vec::new());
        }
        let mut frame = self.device.frame()?;
        let states = frame.read(states, 0..states.len())?;
        let _ = frame.submit()?;
        let states = states.get(&self.device)?;
        let numbered = (0..).zip(states);
        Ok(numbered.filter(|(_, state)| *state == HIDDEN).map(|(agent, _)| agent).collect())
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

    /// Cuts a view, and returns how many there are of what.
    fn counted(&mut self, context: &Context, crowd: &Crowd, view: &CrowdView, time: f64) -> Result<DeviceCounted> {
        let mut frame = self.device.frame()?;
        self.record(context, crowd, (view, time), &mut frame)?;
        let counts = frame.read(&self.work.counts, 0..4)?;
        let _ = frame.submit()?;
        DeviceCounted::read(counts.get(&self.device)?)
    }

    /// Returns the arguments of draws: five words each, as of VkDrawIndexedIndirectCommand; those after the last are 0.
    pub fn draws(&self) -> &Buffer<u32> {
        &self.work.draws
    }

    /// Returns model and cluster of every draw; what is after the last is of frames before.
    pub fn clusters(&self) -> &Buffer<[u32; 2]> {
        &self.work.drawn
    }

    /// Returns how far the vertices of every draw are on the way to their targets, 0 to 1; what is after the last is of frames
    /// before.
    pub fn blends(&self) -> &Buffer<f32> {
        &self.work.blends
    }

    /// Returns four words, as [`DeviceCounted::read`] takes them.
    pub fn counts(&self) -> &Buffer<u32> {
        &self.work.counts
    }

    /// Returns how many draws there is room for.
    pub fn room(&self) -> u32 {
        self.capacity
    }

    /// Returns the agents in view, in the order of their draws, those of a step in the order of their poses, then impostors; what
    /// is after the last is of frames before.
    pub fn instances(&self) -> &Buffer<DeviceInstance> {
        &self.work.instances
    }

    /// Returns the skin matrices of all poses of all clips of all models, one model after the other.
    pub fn matrices(&self) -> &Buffer<[[f32; 4]; 3]> {
        &self.shared.matrices
    }

    /// Returns the weights of the morph targets of the same poses, then the own weights of agents; without weights, a buffer
    /// that nothing reads. Another one where there are more agents with weights of their own.
    pub fn weights(&self) -> &Buffer<f32> {
        &self.shared.own.weights
    }

    /// Returns how many weights there are.
    pub fn weight_count(&self) -> usize {
        self.shared.own.weight_count
    }
}
