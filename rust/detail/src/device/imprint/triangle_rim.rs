//! Rims on triangle meshes on a graphics device (`shaders/imprint/rim`), as `triangle::rim` makes them: by the
//! stages of [`super::rim`], of pieces that are 256 values of a triangle's block.

use std::sync::Arc;

use relievo_core::Result;
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups, wgpu};
use relievo_surface::{DeviceMesh, MESH_GROUP};
use relievo_tiles::triangle::{DeviceTriangles, TRIANGLES_GROUP};

use super::blocks::Record;
use super::rim::{RIM_GROUP, RIM_OWN, RimKernels, RimStages};
use super::shared::{Shared, step};
use super::voxel::DeviceVoxels;

/// Imprints, triangles and their arguments, pieces and theirs, and the counters.
const LISTING: [Access; 6] = [Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write];

/// The kernels of rims on a mesh.
#[derive(Debug)]
pub(super) struct RimMesh {
    list: Arc<Kernel>,
    gather: Arc<Kernel>,
    raise: RimKernels,
    note: Arc<Kernel>,
}

/// What is bound of a mesh.
#[derive(Debug)]
pub(super) struct BoundRim {
    listing: Bindings,
    own: Bindings,
}

/// What kernels have as their group 0: those of all rims, places inside triangles, and vectors.
fn own() -> [Access; 11] {
    let mut own = [Access::Read; 11];
    own[..RIM_OWN.len()].copy_from_slice(&RIM_OWN);
    own
}

impl RimMesh {
    /// For a mesh whose kernels have these constants: segments, parts of a block, and whether there are vectors. Fails where
    /// the device does.
    pub fn new(device: &Device, [segments, parts, vectors]: [(&'static str, f64); 3]) -> Result<Self> {
        let immediates = size_of::<Step>() as u32;
        let own = own();
        let groups: &[&[Access]] = &[&own, &MESH_GROUP, &TRIANGLES_GROUP, &RIM_GROUP];
        let kernel = |module, entry, groups: &[&[Access]], constants: &[(&str, f64)]| {
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants })
        };
        Ok(Self {
            list: kernel("triangle_imprint_rim_pieces", "list_pieces", &[&LISTING], &[parts])?,
            gather: kernel("triangle_imprint_rim_gather", "gather", groups, &[segments, vectors])?,
            raise: RimKernels::new(device, groups, ("triangle_imprint_rim_cells", &[segments]), true)?,
            note: kernel("triangle_imprint_rim_note", "note_risen", groups, &[segments, parts])?,
        })
    }
}

impl BoundRim {
    /// Of a mesh whose listed triangles are these, and `beside` them places inside triangles, and vectors. Fails where the
    /// device does.
    pub fn new(
        device: &Device,
        stages: &RimStages,
        (shared, voxels): (&Shared, &DeviceVoxels),
        (slots, records): (&Buffer<u32>, &Buffer<Record>),
        (faces, beside): (&wgpu::Buffer, [&wgpu::Buffer; 3]),
    ) -> Result<Self> {
        let Shared { jobs, arguments, counters, .. } = &stages.around;
        let from = [jobs.wgpu(), faces, shared.arguments.wgpu()];
        let to = [stages.listed.wgpu(), arguments.wgpu(), counters.wgpu()];
        let bound = [&stages.own(shared, voxels, slots, records)[..], &beside].concat();
        Ok(Self { listing: device.bind_as(&LISTING, &[from, to].concat())?, own: device.bind_as(&own(), &bound)? })
    }

    /// Records that the pieces of the listed triangles are gathered, before imprint `job` is made.
    pub fn gather(
        &self,
        pass: &mut Pass<'_>,
        (stages, kernels): (&RimStages, &RimMesh),
        (mesh, values): (&DeviceMesh, &DeviceTriangles),
        job: usize,
    ) -> Result<()> {
        let jobs = step(job..job + 1);
        let faces = groups((mesh.face_count() as u32).div_ceil(GROUP));
        pass.run(&kernels.list, &[&self.listing], bytemuck::bytes_of(&jobs), faces)?;
        stages.run(pass, &kernels.gather, &[&self.own, mesh.group(), values.group(), &stages.state], job)
    }

    /// Records that a rim rises, after the imprint was made.
    pub fn raise(
        &self,
        pass: &mut Pass<'_>,
        (stages, kernels): (&RimStages, &RimMesh),
        (mesh, values): (&DeviceMesh, &DeviceTriangles),
        job: usize,
    ) -> Result<()> {
        let groups = [&self.own, mesh.group(), values.group(), &stages.state];
        stages.raise(pass, &kernels.raise, &groups, job)?;
        stages.run(pass, &kernels.note, &groups, job)
    }
}
