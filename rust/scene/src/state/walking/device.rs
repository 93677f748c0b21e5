//! Crowds that a graphics device cuts, poses and draws (Section 5.2, `shaders/crowd/crowd_pose.wgsl`).
//!
//! The device makes the draws, poses each vertex of a cluster once for all agents of a step in the same pose, and writes two
//! numbers for each corner of each agent, which one indirect draw shows. The host reads nothing back but four counts, by
//! which it makes room. Places of agents are 32-bit floats in the world.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_crowd::{Crowd, CrowdModel, CrowdView, DeviceCrowd, MorphOffset};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Scan, groups};
use relievo_render::Material;
use relievo_render::virtual_vertex::{INSTANCE_TAG, Placed, PosedMesh, PosedVertex, Shape};

/// Draws, posed vertices and corners that there is room for at first.
const ROOM: [u32; 3] = [1 << 8, 1 << 12, 3 << 12];
/// What has no line at any corner.
const NO_CORNER: u32 = 3;

/// As in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Call {
    agents: u32,
    draws: u32,
    posed: u32,
    corners: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct VertexRow {
    p: [f32; 3],
    bones: u32,
    normal: [f32; 3],
    more_bones: u32,
    weights: [f32; 4],
    first_offset: u32,
    end_offset: u32,
    padding: [u32; 2],
}

/// A vertex of a cluster: which of all vertices, and its tag and corner as [`PosedVertex`] has them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
struct ClusterVertex {
    vertex: u32,
    tag: u32,
    corner: u32,
}

const _: () = assert!(size_of::<VertexRow>() == 64 && size_of::<ClusterVertex>() == 12);

/// How clusters look.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    /// The false colour of a triangle of the model, the cluster and the material. Left out, agents have that of their number.
    pub tag: Option<&'a dyn Fn(&CrowdModel, u32, u32) -> u32>,
    /// Whether wireframes have lines, for which corners share fewer vertices.
    pub lines: bool,
}

/// What a device drew up for a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceCounts {
    /// Agents in view.
    pub agents: u32,
    /// Clusters, each once for all agents that show it by one draw.
    pub draws: u32,
    /// Vertices that were posed.
    pub posed: u32,
    /// Triangles of all agents.
    pub triangles: u32,
}

/// The triangles of a crowd on a device.
#[derive(Debug)]
pub struct DeviceStandIns {
    device: Device,
    crowd: DeviceCrowd,
    models: Models,
    kernels: [Arc<Kernel>; 4],
    room: Room,
    bounds: [[f32; 3]; 2],
}

/// What models have, sent once.
#[derive(Debug)]
struct Models {
    clusters: Buffer<[u32; 2]>,
    vertices: Buffer<VertexRow>,
    cluster_vertices: Buffer<ClusterVertex>,
    indices: Buffer<u32>,
    offsets: Buffer<[f32; 4]>,
}

impl Models {
    fn new(device: &Device, crowd: &Crowd, look: Look<'_>) -> Result<Self> {
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
                vertices.push(VertexRow {
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
                        let found = ClusterVertex { vertex: first_vertex + vertex, tag, corner };
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
        Ok(Self {
            clusters: Buffer::of(device, "crowd vertex ranges", &clusters)?,
            vertices: Buffer::of(device, "crowd vertices", &vertices)?,
            cluster_vertices: Buffer::of(device, "crowd vertices of clusters", &cluster_vertices)?,
            indices: Buffer::of(device, "crowd indices", &indices)?,
            offsets: Buffer::of(device, "crowd offsets", &offsets)?,
        })
    }
}

/// What is written for a view.
#[derive(Debug)]
struct Room {
    agents: usize,
    runs: Buffer<u32>,
    run_firsts: Buffer<u32>,
    starts: [Buffer<u32>; 2],
    posed: Buffer<PosedVertex>,
    corners: Buffer<[u32; 2]>,
    arguments: Buffer<u32>,
    /// Of runs, and of both starts.
    scans: [Scan; 3],
}

impl Room {
    fn new(device: &Device, agents: usize, [draws, posed, corners]: [u32; 3]) -> Result<Self> {
        let runs = Buffer::new(device, "crowd runs", agents + 1)?;
        let start = |label| Buffer::new(device, label, draws as usize + 1);
        let starts = [start("crowd posed starts")?, start("crowd corner starts")?];
        let arguments = Buffer::new(device, "crowd arguments", 4)?;
        let scan = |items| Scan::new(device, items, &arguments);
        Ok(Self {
            agents,
            scans: [scan(&runs)?, scan(&starts[0])?, scan(&starts[1])?],
            runs,
            run_firsts: Buffer::new(device, "crowd run firsts", agents)?,
            starts,
            posed: Buffer::new(device, "crowd posed vertices", posed as usize)?,
            corners: Buffer::new(device, "crowd corners", corners as usize)?,
            arguments,
        })
    }

    /// Draws, posed vertices and corners.
    fn sizes(&self) -> [u32; 3] {
        [self.starts[0].len() - 1, self.posed.len(), self.corners.len()].map(|size| size as u32)
    }
}

impl DeviceStandIns {
    /// Sends the models of a crowd to a device.
    ///
    /// # Errors
    /// The device has no memory, or the models are too large for 32 bits.
    pub fn new(device: &Device, crowd: &Crowd, look: Look<'_>) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_pose",
                entry,
                groups: &[&[Read; 5], &[Write; 7], &[Read; 6]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        Ok(Self {
            crowd: DeviceCrowd::new(device, crowd, ROOM[0])?,
            models: Models::new(device, crowd, look)?,
            kernels: [kernel("mark_runs")?, kernel("count_parts")?, kernel("pose_vertices")?, kernel("write_corners")?],
            room: Room::new(device, crowd.agents().len(), ROOM)?,
            bounds: [[0.0; 3]; 2],
            device: device.clone(),
        })
    }

    /// Cuts and poses the crowd for a view at `time` seconds. Makes room where there is too little.
    ///
    /// # Errors
    /// As [`DeviceCrowd::record`].
    pub fn update(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&CrowdView, f64),
    ) -> Result<DeviceCounts> {
        self.bounds = bounds(crowd);
        if crowd.agents().is_empty() {
            // Kernels cannot be bound to no agents.
            let mut frame = self.device.frame()?;
            frame.clear(&self.room.arguments);
            let _ = frame.submit()?;
            return Ok(DeviceCounts::default());
        }
        loop {
            let sizes = self.room.sizes();
            if self.room.agents != crowd.agents().len() {
                self.room = Room::new(&self.device, crowd.agents().len(), sizes)?;
            }
            let mut frame = self.device.frame()?;
            self.crowd.record(context, crowd, (view, time), &mut frame)?;
            self.record(&mut frame)?;
            let draws = sizes[0] as usize;
            let counts = frame.read(self.crowd.counts(), 0..2)?;
            let ends = self.room.starts.each_ref().map(|starts| frame.read(starts, draws..draws + 1));
            let _ = frame.submit()?;
            let [agents, draws] = counts.get(&self.device)?.try_into().map_err(|_| unread())?;
            let [posed, corners] = ends.map(|end| end?.get(&self.device)?.first().copied().ok_or_else(unread));
            let needed = [draws, posed?, corners?];
            if needed.iter().zip(sizes).all(|(needed, size)| *needed <= size) {
                return Ok(DeviceCounts { agents, draws, posed: needed[1], triangles: needed[2] / 3 });
            }
            // A fourth more, so that a view that comes nearer needs no new room in each frame.
            let larger = |needed: u32, size: u32| if needed > size { needed.saturating_add(needed / 4) } else { size };
            let sizes: [u32; 3] = std::array::from_fn(|at| larger(needed[at], sizes[at]));
            if sizes[0] > self.crowd.room() {
                self.crowd.make_room(sizes[0])?;
            }
            self.room = Room::new(&self.device, crowd.agents().len(), sizes)?;
        }
    }

    /// Records what follows the cut.
    fn record(&self, frame: &mut Frame) -> Result<()> {
        let room = &self.room;
        let [draws, posed, corners] = room.sizes();
        let agents = room.agents as u32;
        let call = Call { agents, draws, posed, corners };
        let call = bytemuck::bytes_of(&call);
        let bindings = self.bindings()?;
        let bound = bindings.each_ref();
        let [mark_runs, count_parts, pose_vertices, write_corners] = &self.kernels;
        let by_item = |items: u32| groups(items.div_ceil(GROUP));
        frame.clear(&room.arguments);
        let mut pass = frame.pass("crowd pose");
        pass.run(mark_runs, &bound, call, by_item(agents + 1))?;
        room.scans[0].run(&mut pass, agents + 1)?;
        pass.run(count_parts, &bound, call, by_item(agents.max(draws + 1)))?;
        room.scans[1].run(&mut pass, draws + 1)?;
        room.scans[2].run(&mut pass, draws + 1)?;
        pass.run(pose_vertices, &bound, call, by_item(posed))?;
        pass.run(write_corners, &bound, call, by_item(corners))
    }

    fn bindings(&self) -> Result<[Bindings; 3]> {
        let (crowd, room, models) = (&self.crowd, &self.room, &self.models);
        let drawn = [
            crowd.draws().wgpu(),
            crowd.clusters().wgpu(),
            crowd.instances().wgpu(),
            crowd.counts().wgpu(),
            models.clusters.wgpu(),
        ];
        let written = [
            room.runs.wgpu(),
            room.run_firsts.wgpu(),
            room.starts[0].wgpu(),
            room.starts[1].wgpu(),
            room.posed.wgpu(),
            room.corners.wgpu(),
            room.arguments.wgpu(),
        ];
        let read = [
            models.vertices.wgpu(),
            models.cluster_vertices.wgpu(),
            models.indices.wgpu(),
            crowd.matrices().wgpu(),
            crowd.weights().wgpu(),
            models.offsets.wgpu(),
        ];
        let bind = |group, buffers: &[_]| self.device.bind(&self.kernels[0], group, buffers);
        Ok([bind(0, &drawn)?, bind(1, &written)?, bind(2, &read)?])
    }

    /// Returns what is drawn, made of `material`.
    pub fn placed(&self, material: Material) -> Placed<'_> {
        let mesh = PosedMesh {
            corners: &self.room.corners,
            vertices: &self.room.posed,
            instances: self.crowd.instances().wgpu(),
            arguments: &self.room.arguments,
            bounds: self.bounds,
        };
        Placed::new(Shape::Posed(mesh), material)
    }
}

fn unread() -> Error {
    Error::internal("counts that cannot be read")
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
