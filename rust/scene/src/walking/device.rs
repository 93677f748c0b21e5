//! Crowds that a graphics device cuts, poses and draws (`shaders/crowd/crowd_pose.wgsl`).
//!
//! The device makes the draws, skins the corners of what they show, and the rasteriser draws these by an indirect draw: what is
//! drawn is never read back. Places are 32-bit floats in the world.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_crowd::{Crowd, CrowdView, DeviceCrowd, MorphOffset};
use relievo_gpu::{Access, Buffer, Device, GROUP, Kernel, KernelSpec, Scan, groups};
use relievo_render::Material;
use relievo_render::virtual_vertex::{MeshVertex, Placed, Shape, WrittenMesh};

/// Draws and triangles that there is room for at first.
const ROOM: [u32; 2] = [1 << 16, 1 << 16];

/// As in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Call {
    draws: u32,
    corners: u32,
    by_agent: u32,
    padding: u32,
    color: [f32; 3],
    more_padding: u32,
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

const _: () = assert!(size_of::<VertexRow>() == 64 && size_of::<Call>() == 32 && size_of::<MeshVertex>() == 52);

/// What false colours show of a crowd.
#[derive(Clone, Copy, Debug)]
pub enum Tags<'a> {
    /// A number for each triangle of all clusters of all models, one model after the other.
    Triangles(&'a [u32]),
    /// The number of the agent.
    Agents,
}

/// What a device drew up for a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceCounts {
    /// Agents in view.
    pub agents: u32,
    /// Indexed draws.
    pub draws: u32,
    /// Triangles.
    pub triangles: u32,
}

/// The triangles of a crowd on a device.
#[derive(Debug)]
pub struct DeviceStandIns {
    device: Device,
    crowd: DeviceCrowd,
    vertices: Buffer<VertexRow>,
    indices: Buffer<u32>,
    tags: Buffer<u32>,
    offsets: Buffer<[f32; 4]>,
    by_agent: bool,
    base_color: [f32; 3],
    kernels: [Arc<Kernel>; 2],
    room: Room,
    bounds: [[f32; 3]; 2],
}

/// What is written for a view.
#[derive(Debug)]
struct Room {
    starts: Buffer<u32>,
    scan: Scan,
    corners: Buffer<MeshVertex>,
    arguments: Buffer<u32>,
}

impl Room {
    fn new(device: &Device, crowd: &DeviceCrowd, corners: u32) -> Result<Self> {
        let starts = Buffer::new(device, "crowd corner starts", crowd.room() as usize + 1)?;
        Ok(Self {
            scan: Scan::new(device, &starts, crowd.counts())?,
            starts,
            corners: Buffer::new(device, "crowd corners", corners as usize)?,
            arguments: Buffer::new(device, "crowd arguments", 4)?,
        })
    }
}

impl DeviceStandIns {
    /// Sends the models of a crowd to a device. Surfaces have the colour of `material` where no false colour covers it.
    ///
    /// # Errors
    /// The device has no memory, there is another number of tags than of triangles, or the crowd is too large for 32 bits.
    pub fn new(device: &Device, crowd: &Crowd, tags: Tags<'_>, material: &Material) -> Result<Self> {
        let (mut vertices, mut indices, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
        for model in crowd.models() {
            let character = &model.character;
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
            indices.extend(character.triangles.iter().flatten());
        }
        // Nothing empty can be bound.
        offsets.push([0.0; 4]);
        let (tags, by_agent) = match tags {
            Tags::Triangles(tags) => (tags.to_vec(), false),
            Tags::Agents => (vec![0; indices.len() / 3], true),
        };
        if 3 * tags.len() != indices.len() {
            let counts = (tags.len(), indices.len() / 3);
            return Err(Error::invalid(format!("there are {} tags for {} triangles", counts.0, counts.1)));
        }
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_pose",
                entry,
                groups: &[&[Read; 9], &[Write; 3]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        let on_device = DeviceCrowd::new(device, crowd, ROOM[0])?;
        Ok(Self {
            vertices: Buffer::of(device, "crowd vertices", &vertices)?,
            indices: Buffer::of(device, "crowd indices", &indices)?,
            tags: Buffer::of(device, "crowd tags", &tags)?,
            offsets: Buffer::of(device, "crowd offsets", &offsets)?,
            by_agent,
            base_color: material.base_color,
            kernels: [kernel("count_corners")?, kernel("pose_corners")?],
            room: Room::new(device, &on_device, 3 * ROOM[1])?,
            bounds: [[0.0; 3]; 2],
            crowd: on_device,
            device: device.clone(),
        })
    }

    /// Cuts and poses the crowd for a view at `time` seconds. Room is made where there is too little.
    ///
    /// # Errors
    /// As [`DeviceCrowd::record`].
    pub fn update(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&CrowdView, f64),
    ) -> Result<DeviceCounts> {
        let [agents, draws] = self.crowd.update(context, crowd, view, time)?;
        if self.room.starts.len() != self.crowd.room() as usize + 1 {
            self.room = Room::new(&self.device, &self.crowd, self.room.corners.len() as u32)?;
        }
        let mut corners = self.count()?;
        if corners as usize > self.room.corners.len() {
            // A fourth more, so that a view that comes nearer needs no room in each frame.
            let more = corners.checked_add(corners / 4).unwrap_or(u32::MAX);
            self.room = Room::new(&self.device, &self.crowd, more)?;
            corners = self.count()?;
        }
        let mut frame = self.device.frame()?;
        frame.clear(&self.room.arguments);
        let bindings = self.bindings(1)?;
        let mut pass = frame.pass("crowd pose");
        let call = self.call();
        pass.run(&self.kernels[1], &[&bindings[0], &bindings[1]], bytemuck::bytes_of(&call), groups(draws.max(1)))?;
        drop(pass);
        let _ = frame.submit()?;
        self.bounds = bounds(crowd);
        Ok(DeviceCounts { agents, draws, triangles: corners / 3 })
    }

    /// Returns what is drawn. It has the glossy part of `material`.
    pub fn placed(&self, material: Material) -> Placed<'_> {
        let Room { corners, arguments, .. } = &self.room;
        Placed::new(Shape::Written(WrittenMesh { vertices: corners, arguments, bounds: self.bounds }), material)
    }

    fn call(&self) -> Call {
        Call {
            draws: self.crowd.room(),
            corners: self.room.corners.len() as u32,
            by_agent: u32::from(self.by_agent),
            padding: 0,
            color: self.base_color,
            more_padding: 0,
        }
    }

    fn bindings(&self, kernel: usize) -> Result<[relievo_gpu::Bindings; 2]> {
        let read = [
            self.vertices.wgpu(),
            self.indices.wgpu(),
            self.tags.wgpu(),
            self.crowd.matrices().wgpu(),
            self.crowd.weights().wgpu(),
            self.offsets.wgpu(),
            self.crowd.draws().wgpu(),
            self.crowd.instances().wgpu(),
            self.crowd.counts().wgpu(),
        ];
        let written = [self.room.starts.wgpu(), self.room.corners.wgpu(), self.room.arguments.wgpu()];
        let kernel = &self.kernels[kernel];
        Ok([self.device.bind(kernel, 0, &read)?, self.device.bind(kernel, 1, &written)?])
    }

    /// Finds where the corners of each draw begin, and returns how many there are.
    fn count(&mut self) -> Result<u32> {
        let draws = self.crowd.room();
        let mut frame = self.device.frame()?;
        frame.clear(&self.room.starts);
        let bindings = self.bindings(0)?;
        let call = self.call();
        let mut pass = frame.pass("crowd corners");
        let by_draw = groups(draws.div_ceil(GROUP));
        pass.run(&self.kernels[0], &[&bindings[0], &bindings[1]], bytemuck::bytes_of(&call), by_draw)?;
        self.room.scan.run(&mut pass, draws + 1)?;
        drop(pass);
        let end = frame.read(&self.room.starts, draws as usize..draws as usize + 1)?;
        let _ = frame.submit()?;
        end.get(&self.device)?.first().copied().ok_or_else(|| Error::internal("a sum that cannot be read"))
    }
}

/// Returns a box around all agents.
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
