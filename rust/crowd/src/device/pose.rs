//! The clusters that a cut draws, posed on a device (Section 5.2, `shaders/crowd/crowd_pose.wgsl`).
//!
//! The device poses each vertex of a cluster once for all agents of a step in the same pose, and writes two numbers for each
//! corner of each agent, which one indirect draw shows. Where it culls by occlusion, it poses what was seen in the last frame
//! first, and then only what is missing of what is seen now. The host reads nothing back but how much was written, by which it makes
//! room. Places of agents are 32-bit floats in the world.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::crowd_pose::{Call, ClusterVertex, Vertex};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, groups};
use relievo_render::virtual_vertex::{INSTANCE_TAG, PosedMesh};

use super::room::{Ended, Ends, Room};
use super::{DeviceCounted, DeviceCrowd, Part};
use crate::crowd::Crowd;
use crate::hierarchy::CrowdModel;
use crate::morph::MorphOffset;
use crate::skinning::{Blend, dual_rows};
use crate::view::CrowdView;

/// Posed vertices and corners that there is room for at first.
const ROOM: [u32; 2] = [1 << 12, 3 << 12];
/// What has no line at any corner.
const NO_CORNER: u32 = 3;

/// How clusters look on a device.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    /// The false colour of a triangle of the model, the cluster and the material. Left out, agents have that of their number.
    pub tag: Option<&'a dyn Fn(&CrowdModel, u32, u32) -> u32>,
    /// Whether wireframes have lines, for which corners share fewer vertices.
    pub lines: bool,
}

/// How many vertices were posed, and how many corners are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DevicePosed {
    /// Vertices that were posed.
    pub vertices: u32,
    /// Corners of triangles of all agents.
    pub corners: u32,
}

/// Poses what a [`DeviceCrowd`] draws.
#[derive(Debug)]
pub struct DevicePoser {
    device: Device,
    models: Models,
    kernels: [Arc<Kernel>; 7],
    room: Room,
    bounds: [[f32; 3]; 2],
}

/// What models have, sent once.
#[derive(Debug)]
struct Models {
    clusters: Buffer<[u32; 2]>,
    vertices: Buffer<Vertex>,
    cluster_vertices: Buffer<ClusterVertex>,
    indices: Buffer<u32>,
    offsets: Buffer<[f32; 4]>,
    /// The bones of all poses as dual quaternions, where they are blended as such.
    dual: Option<Buffer<[f32; 4]>>,
}

impl Models {
    fn new(device: &Device, crowd: &Crowd, (look, blend): (Look<'_>, Blend)) -> Result<Self> {
        let (mut vertices, mut offsets) = (Vec::new(), Vec::new());
        let (mut cluster_vertices, mut indices) = (Vec::<ClusterVertex>::new(), Vec::new());
        let mut next = crowd.models().len() as u32;
        let firsts = crowd.models().iter().map(|model| {
            next += model.clusters.len() as u32;
            [next - model.clusters.len() as u32, 0]
        });
        let mut clusters: Vec<[u32; 2]> = firsts.collect();
        for model in crowd.models() {
            let character = &model.character;
            let first_vertex = vertices.len() as u32;
            let normals = character.values("normal").map(|values| values.as_chunks::<3>().0);
            for (index, (p, influence)) in character.points.iter().zip(&character.influences).enumerate() {
                let [a, b, c, d] = influence.bones.map(u32::from);
                let first_offset = offsets.len() as u32;
                let row = |MorphOffset { morph, offset: [x, y, z] }: &MorphOffset| [*x, *y, *z, f32::from_bits(*morph)];
                offsets.extend(character.morphs.of(index).iter().map(row));
                vertices.push(Vertex {
                    p: *p,
                    bones: a | b << 16,
                    normal: normals.and_then(|normals| normals.get(index)).copied().unwrap_or_default(),
                    more_bones: c | d << 16,
                    weights: influence.weights,
                    first_offset,
                    end_offset: offsets.len() as u32,
                    padding: [0; 2],
                });
            }
            for (cluster, number) in model.clusters.iter().zip(0..) {
                let first = cluster_vertices.len();
                let mut known = HashMap::new();
                let materials = &character.materials[cluster.first as usize..];
                for (triangle, material) in model.triangles(number).iter().zip(materials) {
                    let tag = look.tag.map_or(INSTANCE_TAG, |tag| tag(model, number, *material));
                    for (vertex, corner) in triangle.iter().zip(0..) {
                        let corner = if look.lines { corner } else { NO_CORNER };
                        let target_vertex = first_vertex + model.target(number, *vertex).unwrap_or(*vertex);
                        let found = ClusterVertex { vertex: first_vertex + vertex, tag, corner, target_vertex };
                        indices.push(*known.entry(found).or_insert_with(|| {
                            cluster_vertices.push(found);
                            (cluster_vertices.len() - first - 1) as u32
                        }));
                    }
                }
                clusters.push([first as u32, (cluster_vertices.len() - first) as u32]);
            }
        }
        // Nothing empty can be bound.
        offsets.push([0.0; 4]);
        let clips = crowd.models().iter().flat_map(|model| &model.clips);
        let bones = clips.flat_map(|clip| &clip.poses).flat_map(|pose| &pose.bones);
        let dual = (blend == Blend::DualQuaternion).then(|| bones.flat_map(dual_rows).collect::<Vec<_>>());
        Ok(Self {
            clusters: Buffer::of(device, "crowd vertex ranges", &clusters)?,
            vertices: Buffer::of(device, "crowd vertices", &vertices)?,
            cluster_vertices: Buffer::of(device, "crowd vertices of clusters", &cluster_vertices)?,
            indices: Buffer::of(device, "crowd indices", &indices)?,
            offsets: Buffer::of(device, "crowd offsets", &offsets)?,
            dual: dual.map(|rows| Buffer::of(device, "crowd dual quaternions", &rows)).transpose()?,
        })
    }
}

impl DevicePoser {
    /// Sends the vertices of the models of a crowd to a device.
    ///
    /// # Errors
    /// The device has no memory, the models are too large for 32 bits, or their bones are blended in different ways.
    pub fn new(device: &Device, crowd: &Crowd, look: Look<'_>) -> Result<Self> {
        crowd.check_whole()?;
        let blend = crowd.models().first().map_or(Blend::Linear, |model| model.blend);
        if crowd.models().iter().any(|model| model.blend != blend) {
            return Err(Error::unsupported("the bones of the models are blended in different ways")
                .advise("blend all alike (`CrowdModel::with_blend`, rlv_crowd_model_with_blend), or make two crowds"));
        }
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_pose",
                entry,
                groups: &[&[Read; 8], &[Write; 10], &[Read; 8]],
                immediates: size_of::<Call>() as u32,
                constants: if blend == Blend::DualQuaternion { &[("DUAL", 1.0)] } else { &[] },
            })
        };
        Ok(Self {
            models: Models::new(device, crowd, (look, blend))?,
            kernels: [
                kernel("mark_runs")?,
                kernel("split_runs")?,
                kernel("list_runs")?,
                kernel("mark_fresh")?,
                kernel("count_parts")?,
                kernel("pose_vertices")?,
                kernel("write_corners")?,
            ],
            room: Room::new(device, crowd.agents().len(), [1, ROOM[0], ROOM[1]])?,
            bounds: [[0.0; 3]; 2],
            device: device.clone(),
        })
    }

    /// Cuts a crowd for a view at `time` seconds and poses what is drawn. Makes room where there is too little.
    ///
    /// # Errors
    /// As [`DeviceCrowd::record`].
    pub fn update(
        &mut self,
        context: &Context,
        (crowd, on): (&Crowd, &mut DeviceCrowd),
        (view, time): (&CrowdView, f64),
    ) -> Result<(DeviceCounted, DevicePosed)> {
        if crowd.agents().is_empty() {
            self.clear()?;
            return Ok(Default::default());
        }
        loop {
            self.fit(crowd, on.room())?;
            let mut frame = self.device.frame()?;
            on.record(context, crowd, (view, time), &mut frame)?;
            let counts = frame.read(on.counts(), 0..4)?;
            self.record(on, (Part::All, 0), &mut frame)?;
            let ends = self.read_ends(0, &mut frame)?;
            let _ = frame.submit()?;
            let counted = DeviceCounted::read(counts.get(&self.device)?)?;
            let Ended { vertices, corners, .. } = ends.get(&self.device)?;
            let posed = DevicePosed { vertices, corners };
            if counted.draws > on.room() {
                on.make_room(larger(counted.draws))?;
            } else if !self.grow(posed)? {
                return Ok((counted, posed));
            }
        }
    }

    /// Draws nothing: kernels cannot be bound to no agents.
    pub(super) fn clear(&mut self) -> Result<()> {
        self.bounds = [[0.0; 3]; 2];
        let mut frame = self.device.frame()?;
        frame.clear(&self.room.arguments);
        let _ = frame.submit()?;
        Ok(())
    }

    /// Makes room for the agents of a crowd and for so many draws.
    pub(super) fn fit(&mut self, crowd: &Crowd, draws: u32) -> Result<()> {
        self.bounds = bounds(crowd);
        let [known, posed, corners] = self.room.sizes();
        if self.room.agents != crowd.agents().len() || known != draws {
            self.room = Room::new(&self.device, crowd.agents().len(), [draws, posed, corners])?;
        }
        Ok(())
    }

    /// Makes room for what did not fit. Returns whether something did not.
    pub(super) fn grow(&mut self, needed: DevicePosed) -> Result<bool> {
        let [draws, posed, corners] = self.room.sizes();
        let fits = needed.vertices <= posed && needed.corners <= corners;
        if !fits {
            let room = |needed: u32, size: u32| if needed > size { larger(needed) } else { size };
            let sizes = [draws, room(needed.vertices, posed), room(needed.corners, corners)];
            self.room = Room::new(&self.device, self.room.agents, sizes)?;
        }
        Ok(!fits)
    }

    /// Records that what a pass wrote is read back.
    pub(super) fn read_ends(&self, number: usize, frame: &mut Frame) -> Result<Ends> {
        self.room.read_ends(number, frame)
    }

    /// Records the posing of some of the agents that the cut before lists, as the first pass or the second. The second has the
    /// vertices of the first, and poses only what is missing.
    pub(super) fn record(&self, on: &DeviceCrowd, (part, number): (Part, usize), frame: &mut Frame) -> Result<()> {
        let room = &self.room;
        let [draws, posed, corners] = room.sizes();
        let agents = room.agents as u32;
        let call = Call { agents, draws, posed, corners, which: part as u32, pass_number: number as u32 };
        let call = bytemuck::bytes_of(&call);
        let bindings = self.bindings(on, number)?;
        let bound = bindings.each_ref();
        let [mark_runs, split_runs, list_runs, mark_fresh, count_parts, pose_vertices, write_corners] = &self.kernels;
        let by_item = |items: u32| groups(items.div_ceil(GROUP));
        let ([of_runs, of_marks, of_corners], [of_fresh, of_posed]) = (&room.scans, &room.pass_scans[number]);
        frame.clear(&room.arguments);
        if number == 0 {
            frame.clear(&room.total);
        }
        let mut pass = frame.pass("crowd pose");
        pass.run(mark_runs, &bound, call, by_item(agents + 1))?;
        if number == 0 {
            pass.run(split_runs, &bound, call, by_item(draws))?;
            of_runs.run(&mut pass, agents + 1)?;
        }
        of_marks.run(&mut pass, agents + 1)?;
        pass.run(list_runs, &bound, call, by_item(agents))?;
        pass.run(mark_fresh, &bound, call, by_item(agents + 1))?;
        of_fresh.run(&mut pass, agents + 1)?;
        pass.run(count_parts, &bound, call, by_item(agents.max(draws + 1)))?;
        of_posed.run(&mut pass, draws + 1)?;
        of_corners.run(&mut pass, draws + 1)?;
        pass.run(pose_vertices, &bound, call, by_item(posed))?;
        pass.run(write_corners, &bound, call, by_item(corners))
    }

    fn bindings(&self, crowd: &DeviceCrowd, number: usize) -> Result<[Bindings; 3]> {
        let (room, models) = (&self.room, &self.models);
        let drawn = [
            crowd.draws().wgpu(),
            crowd.clusters().wgpu(),
            crowd.instances().wgpu(),
            crowd.counts().wgpu(),
            models.clusters.wgpu(),
            crowd.blends().wgpu(),
            crowd.work.states.wgpu(),
            crowd.work.draw_states.wgpu(),
        ];
        let written = [
            room.runs.wgpu(),
            room.marks.wgpu(),
            room.lists.wgpu(),
            room.fresh[number].wgpu(),
            room.posed_starts[number].wgpu(),
            room.corner_starts.wgpu(),
            room.posed.wgpu(),
            room.corners.wgpu(),
            room.arguments.wgpu(),
            room.total.wgpu(),
        ];
        let read = [
            models.vertices.wgpu(),
            models.cluster_vertices.wgpu(),
            models.indices.wgpu(),
            models.dual.as_ref().map_or(crowd.matrices().wgpu(), Buffer::wgpu),
            crowd.weights().wgpu(),
            models.offsets.wgpu(),
            room.fresh[1 - number].wgpu(),
            room.posed_starts[1 - number].wgpu(),
        ];
        let bind = |group, buffers: &[_]| self.device.bind(&self.kernels[0], group, buffers);
        Ok([bind(0, &drawn)?, bind(1, &written)?, bind(2, &read)?])
    }

    /// Returns what is drawn of a crowd that was posed last.
    pub fn mesh<'a>(&'a self, on: &'a DeviceCrowd) -> PosedMesh<'a> {
        PosedMesh {
            corners: &self.room.corners,
            vertices: &self.room.posed,
            instances: on.instances().wgpu(),
            arguments: &self.room.arguments,
            bounds: self.bounds,
        }
    }
}

/// A fourth more, so that a view that comes nearer needs no new room in each frame.
pub(super) fn larger(needed: u32) -> u32 {
    needed.saturating_add(needed / 4)
}

/// Returns a box around all agents in the world.
fn bounds(crowd: &Crowd) -> [[f32; 3]; 2] {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for agent in crowd.agents() {
        let model = &crowd.models()[agent.model as usize];
        let ends = [model.low, model.high].map(|end| Vec3::from(end).as_dvec3());
        for corner in 0..8 {
            let at = DVec3::from_array(std::array::from_fn(|axis| ends[corner >> axis & 1][axis]));
            let place = agent.transform.transform_point3(at).as_vec3();
            (low, high) = (low.min(place), high.max(place));
        }
    }
    if crowd.agents().is_empty() { [[0.0; 3]; 2] } else { [low.to_array(), high.to_array()] }
}
