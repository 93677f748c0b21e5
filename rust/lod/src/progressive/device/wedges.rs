//! Attributes of progressive meshes on a device, as `wedges` has them on the processor: which wedges there are tells a bit
//! each, the wedge at a corner is a rank in those, and what it has is copied from the last split that made it.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::progressive_wedges::WedgesCall;
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, Scan};

use super::calls::blocks;
use super::hierarchy::DeviceHierarchy;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::build::wedges::WedgeTrees;
use crate::progressive::mesh::active::Extract;

/// In place of the owner of a wedge whose split is not there.
const NO_SPLIT: u32 = u32::MAX - 1;

/// What a device has of the attributes of a progressive mesh.
#[derive(Debug)]
pub struct DeviceWedges {
    call: WedgesCall,
    owners: Buffer<u32>,
    rows: Buffer<u32>,
    values: Buffer<u32>,
}

impl DeviceWedges {
    /// Fails where the device has no memory, and if numbers of wedges are too many to be counted.
    pub fn new(device: &Device, mesh: &Progressive, trees: &WedgeTrees) -> Result<Self> {
        let [width, face_width] = trees.widths;
        let (wedges, triangles) = (trees.count(), mesh.triangle_count());
        let row = 3 + face_width;
        if u32::try_from(2 * wedges * width).is_err() || u32::try_from(triangles * row).is_err() {
            return Err(Error::unsupported("attributes have more numbers than a graphics device counts"));
        }
        let mut owners: Vec<u32> =
            trees.owners.iter().map(|owner| if *owner == NONE { NO_SPLIT } else { *owner }).collect();
        trees.base.iter().for_each(|wedge| owners[*wedge as usize] = u32::MAX);
        let mut rows = vec![0; triangles * row];
        for (place, leaves) in trees.corners.iter().enumerate().filter(|(_, leaves)| leaves[0] != NONE) {
            let number = mesh.face_id(place as u32) as usize;
            let (corners, values) = rows[number * row..(number + 1) * row].split_at_mut(3);
            corners.copy_from_slice(leaves);
            values.copy_from_slice(&trees.faces[place * face_width..(place + 1) * face_width]);
        }
        let values = Buffer::new(device, "values of wedges", 2 * wedges * width)?;
        for (side, given) in trees.values.iter().enumerate() {
            values.write(device, side * wedges * width, bytemuck::cast_slice(given))?;
        }
        let call = WedgesCall {
            vertices: mesh.vertex_count() as u32,
            triangles: triangles as u32,
            wedges: wedges as u32,
            width: width as u32,
            face_width: face_width as u32,
        };
        let owners = Buffer::of(device, "owners of wedges", &owners)?;
        Ok(Self { call, owners, rows: Buffer::of(device, "wedges of triangles", &rows)?, values })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        4 * (self.owners.len() + self.rows.len() + self.values.len())
    }
}

/// What a mesh on a device has of attributes.
#[derive(Debug)]
pub struct LevelWedges {
    call: WedgesCall,
    scan: Scan,
    kernels: [Arc<Kernel>; 4],
    bindings: [Bindings; 2],
    /// Wedges that there are.
    pub list: Buffer<u32>,
    /// Wedges of triangles, three each.
    pub corners: Buffer<u32>,
    /// Numbers of wedges.
    pub values: Buffer<f32>,
    /// Numbers of triangles.
    pub faces: Buffer<u32>,
}

impl LevelWedges {
    /// Room for the attributes of any mesh of `whole`; given which vertices and triangles there are, with the ranks of those,
    /// and where counts are written.
    pub fn new(
        whole: &DeviceHierarchy,
        trees: &DeviceWedges,
        [there, shown, shown_ranks]: [&Buffer<u32>; 3],
        arguments: &Buffer<u32>,
    ) -> Result<Self> {
        let (device, call) = (&whole.device, trees.call);
        let (triangles, wedges) = (call.triangles as usize, call.wedges as usize);
        let buffer = |label, count| Buffer::<u32>::new(device, label, count);
        let there_of = buffer("wedges there", wedges.div_ceil(32))?;
        let ranks = buffer("ranks of wedges", wedges.div_ceil(32))?;
        let list = buffer("list of wedges", wedges)?;
        let corners = buffer("level wedges", 3 * triangles)?;
        let values = Buffer::new(device, "level values", wedges * call.width as usize)?;
        let faces = buffer("level values of triangles", triangles * call.face_width as usize)?;
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "progressive_wedges",
                entry,
                groups: &[&[Access::Read; 4], &[Access::Write; 10]],
                immediates: size_of::<WedgesCall>() as u32,
                constants: &[],
            })
        };
        let kernels =
            [kernel("mark_wedges")?, kernel("list_wedges")?, kernel("write_wedges")?, kernel("write_corners")?];
        let read = [whole.splits.wgpu(), trees.owners.wgpu(), trees.rows.wgpu(), trees.values.wgpu()];
        let written = [
            there.wgpu(),
            shown.wgpu(),
            shown_ranks.wgpu(),
            there_of.wgpu(),
            ranks.wgpu(),
            list.wgpu(),
            corners.wgpu(),
            values.wgpu(),
            faces.wgpu(),
            arguments.wgpu(),
        ];
        let bindings = [device.bind(&kernels[0], 0, &read)?, device.bind(&kernels[0], 1, &written)?];
        let scan = Scan::new(device, &ranks, arguments)?;
        Ok(Self { call, scan, kernels, bindings, list, corners, values, faces })
    }

    /// Wedges of the finest mesh.
    pub fn count(&self) -> usize {
        self.call.wedges as usize
    }

    /// Records that the attributes of what is marked and shown are written, as they were built.
    pub fn write(&self, pass: &mut Pass<'_>) -> Result<()> {
        let [mark, list, values, corners] = &self.kernels;
        let (wedges, triangles) = (self.call.wedges as usize, self.call.triangles as usize);
        self.run(pass, mark, wedges)?;
        self.scan.run(pass, wedges.div_ceil(32) as u32)?;
        self.run(pass, list, wedges)?;
        self.run(pass, values, wedges)?;
        self.run(pass, corners, triangles)
    }

    fn run(&self, pass: &mut Pass<'_>, kernel: &Kernel, items: usize) -> Result<()> {
        let [read, written] = &self.bindings;
        pass.run(kernel, &[read, written], bytemuck::bytes_of(&self.call), blocks(items))
    }

    /// Puts wedges and what triangles have into an extract, given how many wedges and triangles there are.
    pub fn extract(&self, device: &Device, [wedges, triangles]: [usize; 2], made: &mut Extract) -> Result<()> {
        let [width, face_width] = [self.call.width as usize, self.call.face_width as usize];
        let mut frame = device.frame()?;
        let corners = frame.read(&self.corners, 0..3 * triangles)?;
        let values = frame.read(&self.values, 0..wedges * width)?;
        let faces = frame.read(&self.faces, 0..triangles * face_width)?;
        let _ = frame.submit()?;
        let (mut corners, values) = (corners.get(device)?, values.get(device)?);
        made.face_values = faces.get(device)?;
        // Wedges that no triangle has are left out.
        let mut numbers = vec![NONE; wedges];
        corners.iter().for_each(|wedge| numbers[*wedge as usize] = 0);
        for (count, (wedge, number)) in
            numbers.iter_mut().enumerate().filter(|(_, number)| **number != NONE).enumerate()
        {
            *number = count as u32;
            made.values.extend_from_slice(&values[wedge * width..(wedge + 1) * width]);
        }
        corners.iter_mut().for_each(|wedge| *wedge = numbers[*wedge as usize]);
        made.wedges = corners.as_chunks::<3>().0.to_vec();
        Ok(())
    }
}
