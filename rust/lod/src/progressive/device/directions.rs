//! Normals and tangents among attributes of a mesh on a device, as `directions` has them on the processor: where vertices have
//! moved they turn as those around have. The triangles that are shown say what is around a vertex: their corners, by
//! their leaves, are by vertices in every mesh.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::progressive_directions::DirectionsCall;
use relievo_gpu::wgsl::progressive_ring::RingCall;
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, Scan};

use super::calls::blocks;
use super::hierarchy::DeviceHierarchy;
use super::places::Places;
use super::wedges::LevelWedges;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::build::wedges::WedgeTrees;

/// In place of a number: none, as in `progressive_directions.wgsl`.
const NOTHING: u32 = u32::MAX;
/// Triangles of a vertex at most: a kernel goes round them some five times.
const MAX: u32 = 4096;

/// What a device has of a progressive mesh for directions: 12 bytes a triangle and 4 a wedge.
#[derive(Debug)]
pub struct DeviceDirections {
    call: DirectionsCall,
    /// Corners of the triangles in the order of the input, by their leaves.
    order: Buffer<u32>,
    /// Of every wedge a leaf of its vertex.
    homes: Buffer<u32>,
    /// Triangles at a vertex of the finest mesh at most.
    most: u32,
}

impl DeviceDirections {
    /// Nothing if there are no directions. Fails where the device has no memory.
    pub fn new(device: &Device, mesh: &Progressive, trees: &WedgeTrees) -> Result<Option<Self>> {
        if trees.directions.is_empty() {
            return Ok(None);
        }
        let [normal, tangent] = trees.directions.places().map(|at| at.map_or(NOTHING, |at| at as u32));
        let mut corners = vec![NONE; 3 * mesh.triangle_count()];
        let mut starts = vec![0u32; mesh.vertex_count() + 1];
        for (place, leaves) in mesh.faces.iter().enumerate().filter(|(_, leaves)| leaves[0] != NONE) {
            let first = 3 * mesh.face_id(place as u32) as usize;
            corners[first..first + 3].copy_from_slice(leaves);
            leaves.iter().for_each(|leaf| starts[*leaf as usize + 1] += 1);
        }
        let most = starts.iter().copied().max().unwrap_or_default();
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut order = vec![0; corners.len()];
        for (corner, leaf) in corners.iter().enumerate().filter(|(_, leaf)| **leaf != NONE) {
            let next = &mut starts[*leaf as usize];
            order[*next as usize] = corner as u32;
            *next += 1;
        }
        let homes: Vec<u32> = (0..trees.count() as u32).map(|wedge| trees.home(mesh, wedge)).collect();
        let call =
            DirectionsCall { vertices: mesh.vertex_count() as u32, width: trees.widths[0] as u32, normal, tangent };
        let order = Buffer::of(device, "corners by leaves", &order)?;
        Ok(Some(Self { call, order, homes: Buffer::of(device, "homes of wedges", &homes)?, most }))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        4 * (self.order.len() + self.homes.len())
    }
}

/// What a mesh on a device has for directions: 31 bytes a triangle of the finest.
#[derive(Debug)]
pub struct LevelDirections {
    call: DirectionsCall,
    triangles: usize,
    wedges: usize,
    scan: Scan,
    /// The kernels that find what is around vertices, then the kernels that turn.
    around: [Arc<Kernel>; 3],
    turn: [Arc<Kernel>; 2],
    bindings: [[Bindings; 2]; 2],
    places: Bindings,
}

impl LevelDirections {
    /// Room for the directions of any mesh of `whole`; given which vertices and triangles there are, each with their ranks,
    /// the corners of triangles, where counts are written, and where vertices are that have moved. Fails if a vertex of
    /// the finest mesh has too many triangles, and where the device has no memory.
    pub fn new(
        whole: &DeviceHierarchy,
        directions: &DeviceDirections,
        wedges: &LevelWedges,
        [there, ranks, shown, shown_ranks]: &[Buffer<u32>; 4],
        [indices, arguments]: [&Buffer<u32>; 2],
        places: &Places,
    ) -> Result<Self> {
        if directions.most > MAX {
            let error = format!(
                "a vertex has {} triangles; where normals or tangents turn on a graphics device it has at most {MAX}",
                directions.most
            );
            return Err(Error::unsupported(error).advise("use the processor"));
        }
        let (device, triangles) = (&whole.device, whole.triangles);
        let buffer = |label, count| Buffer::<u32>::new(device, label, count);
        let nodes = buffer("nodes of vertices", whole.vertices)?;
        let ends = Buffer::<[u32; 2]>::new(device, "ends of rings", whole.vertices)?;
        let corners = buffer("corners shown", (3 * triangles).div_ceil(32))?;
        let corner_ranks = buffer("ranks of corners", (3 * triangles).div_ceil(32))?;
        let list = buffer("list of corners", 3 * triangles)?;
        let ring = buffer("rings", 3 * triangles)?;
        let constants = &places.constants();
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize| {
            device.kernel(&KernelSpec { module, entry, groups, immediates: immediates as u32, constants })
        };
        let rings: &[&[Access]] = &[&[Access::Read], &[Access::Write; 10], &[Access::Write; 2]];
        let find = |entry| kernel("progressive_ring", entry, rings, size_of::<RingCall>());
        let around = [find("mark_corners")?, find("list_corners")?, find("find_ring")?];
        let turns: &[&[Access]] = &[&[Access::Read; 4], &[Access::Write; 9], &[Access::Write; 2]];
        let turn = |entry| kernel("progressive_directions", entry, turns, size_of::<DirectionsCall>());
        let turn = [turn("name_vertices")?, turn("turn")?];
        let finding = [
            shown.wgpu(),
            shown_ranks.wgpu(),
            indices.wgpu(),
            arguments.wgpu(),
            corners.wgpu(),
            corner_ranks.wgpu(),
            list.wgpu(),
            nodes.wgpu(),
            ends.wgpu(),
            ring.wgpu(),
        ];
        let built = [whole.splits.wgpu(), whole.inner.wgpu(), whole.leaves.wgpu(), directions.homes.wgpu()];
        let turning = [
            there.wgpu(),
            ranks.wgpu(),
            arguments.wgpu(),
            indices.wgpu(),
            wedges.list.wgpu(),
            wedges.values.wgpu(),
            nodes.wgpu(),
            ends.wgpu(),
            ring.wgpu(),
        ];
        let bindings = [
            [device.bind(&around[0], 0, &[directions.order.wgpu()])?, device.bind(&around[0], 1, &finding)?],
            [device.bind(&turn[0], 0, &built)?, device.bind(&turn[0], 1, &turning)?],
        ];
        let scan = Scan::new(device, &corner_ranks, arguments)?;
        Ok(Self {
            call: directions.call,
            triangles,
            wedges: wedges.count(),
            scan,
            around,
            turn,
            bindings,
            places: places.bindings.clone(),
        })
    }

    /// Records that directions turn of what is written as it was built.
    pub fn turn(&self, pass: &mut Pass<'_>) -> Result<()> {
        let [mark, list, find] = &self.around;
        let [name, turn] = &self.turn;
        let corners = 3 * self.triangles;
        let call = RingCall { triangles: self.triangles as u32 };
        let [order, found] = &self.bindings[0];
        let around = |pass: &mut Pass<'_>, kernel: &Kernel, items: usize| {
            pass.run(kernel, &[order, found, &self.places], bytemuck::bytes_of(&call), blocks(items))
        };
        let [built, state] = &self.bindings[1];
        let own = bytemuck::bytes_of(&self.call);
        let state = [built, state, &self.places];
        around(pass, mark, corners)?;
        self.scan.run(pass, corners.div_ceil(32) as u32)?;
        around(pass, list, corners)?;
        pass.run(name, &state, own, blocks(2 * self.call.vertices as usize))?;
        around(pass, find, corners)?;
        pass.run(turn, &state, own, blocks(self.wedges))
    }
}
