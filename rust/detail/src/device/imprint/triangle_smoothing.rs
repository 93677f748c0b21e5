//! Smoothing of what imprints changed on triangle meshes on a graphics device (`shaders/imprint/smooth/triangle_imprint_touch.wgsl` and
//! `triangle_imprint_smooth.wgsl`), where others of the same submission start from it, as `triangle::smoothing` does.
//!
//! The values of the triangles around what changed are worked on, all together, and left as records like those of rays.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, groups, wgpu};
use relievo_surface::{DeviceMesh, MESH_GROUP};
use relievo_tiles::triangle::{DeviceTriangles, TRIANGLES_GROUP};

use super::job::MAX_JOBS;
use super::shared::step;
use crate::channels::knots::BLOCK_KNOTS;

/// Triangles that there is room for at first.
const FIRST_ROOM: usize = 64;

/// Words of an imprint's arguments, as in `triangle_imprint_touch.wgsl`, and of a value that is worked on.
const STAGE: usize = 4;
const WORKED: usize = 2;

/// Rounds of neighbours that are smoothed as well.
const REACH: usize = 2;

/// What is bound of a mesh to find triangles: imprints, which have blocks, marks, the list, arguments, slots and
/// counters.
const TOUCHING: [Access; 7] =
    [Access::Read, Access::Read, Access::Write, Access::Write, Access::Write, Access::Read, Access::Write];
/// And to smooth them: imprints, which have blocks, marks, the list, arguments, slots, counters, records, and values that
/// are worked on.
const SMOOTHING: [Access; 9] = [
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Read,
    Access::Write,
    Access::Write,
    Access::Write,
    Access::Write,
];

/// The kernels in the order in which they run: kernels that find triangles, and kernels that smooth them.
const FIND: [&str; 2] = ["mark", "list"];
const SMOOTH: [&str; 5] = ["bring", "spread", "average", "apply", "settle"];

/// The triangles of a mesh that are smoothed.
#[derive(Debug)]
pub(super) struct SmoothedMesh {
    find: Vec<Arc<Kernel>>,
    smooth: Vec<Arc<Kernel>>,
    marks: Buffer<[u32; 2]>,
    listed: Buffer<u32>,
    /// Values of a triangle that there is room for.
    values: usize,
}

/// What is bound of a mesh.
#[derive(Debug)]
pub(super) struct BoundMesh {
    touching: Bindings,
    smoothing: Bindings,
}

/// The buffers that smoothing shares with the rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside<'a> {
    pub jobs: &'a wgpu::Buffer,
    pub held: &'a wgpu::Buffer,
    pub slots: &'a wgpu::Buffer,
    pub counters: &'a wgpu::Buffer,
    pub records: &'a wgpu::Buffer,
}

/// The values that are worked on, of all meshes of a submission one after the other.
#[derive(Debug)]
pub(super) struct TriangleSmoothing {
    worked: Buffer<u32>,
    arguments: Buffer<u32>,
    /// Triangles that there is room for.
    capacity: usize,
}

impl SmoothedMesh {
    /// For a mesh of so many faces, whose kernels have these `constants` and take so many parts of 256 values. Fails where
    /// the device has no room.
    pub fn new(device: &Device, faces: usize, constants: &[(&str, f64)], parts: u32) -> Result<Self> {
        let immediates = size_of::<Step>() as u32;
        let find = FIND.map(|entry| {
            let groups: &[&[Access]] = &[&TOUCHING, &MESH_GROUP];
            let constants: Vec<_> = constants.iter().copied().filter(|(name, _)| *name == "PARTS").collect();
            let module = "triangle_imprint_touch";
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &constants })
        });
        let smooth = SMOOTH.map(|entry| {
            let groups: &[&[Access]] = &[&SMOOTHING, &MESH_GROUP, &TRIANGLES_GROUP];
            device.kernel(&KernelSpec { module: "triangle_imprint_smooth", entry, groups, immediates, constants })
        });
        Ok(Self {
            find: find.into_iter().collect::<Result<_>>()?,
            smooth: smooth.into_iter().collect::<Result<_>>()?,
            marks: Buffer::new(device, "marks of triangles", faces)?,
            listed: Buffer::new(device, "triangles to smooth", faces)?,
            values: BLOCK_KNOTS * parts as usize,
        })
    }
}

impl TriangleSmoothing {
    /// Without room for values. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        let worked = Buffer::new(device, "values to smooth", 1)?;
        let arguments = Buffer::new(device, "arguments of smoothing", STAGE * MAX_JOBS)?;
        Ok(Self { worked, arguments, capacity: 0 })
    }

    /// How many triangles of a mesh there is room for.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Makes room for at least so many triangles of `meshes`. Fails where the device has none.
    pub fn enlarge<'a>(
        &mut self,
        device: &Device,
        wanted: usize,
        meshes: impl Iterator<Item = &'a SmoothedMesh>,
    ) -> Result<()> {
        let values = meshes.map(|mesh| mesh.values).max().unwrap_or_default();
        let capacity =
            if wanted > self.capacity { (wanted + wanted / 4).max(FIRST_ROOM) } else { self.capacity.max(FIRST_ROOM) };
        let words = capacity.checked_mul(WORKED * values).filter(|words| u32::try_from(*words).is_ok());
        let words =
            words.ok_or_else(|| Error::memory("imprints change too many triangles to be smoothed on a device"))?;
        if words > self.worked.len() {
            self.worked = Buffer::new(device, "values to smooth", words)?;
        }
        self.capacity = capacity;
        Ok(())
    }

    /// Records that nothing is listed.
    pub fn clear(&self, frame: &mut Frame) {
        frame.clear(&self.arguments);
    }

    /// Binds a mesh. Fails where the device does.
    pub fn bind(&self, device: &Device, mesh: &SmoothedMesh, beside: Beside<'_>) -> Result<BoundMesh> {
        let Beside { jobs, held, slots, counters, records } = beside;
        let first = [jobs, held, mesh.marks.wgpu(), mesh.listed.wgpu(), self.arguments.wgpu(), slots, counters];
        let rest = [records, self.worked.wgpu()];
        Ok(BoundMesh {
            touching: device.bind_as(&TOUCHING, &first)?,
            smoothing: device.bind_as(&SMOOTHING, &[&first[..], &rest].concat())?,
        })
    }

    /// Records that what imprint `job` changed of a mesh, whose values are these, is smoothed in so many passes.
    pub fn smooth(
        &self,
        pass: &mut Pass<'_>,
        (it, bound): (&SmoothedMesh, &BoundMesh),
        (mesh, values): (&DeviceMesh, &DeviceTriangles),
        job: usize,
        passes: u32,
    ) -> Result<()> {
        let faces = groups((mesh.face_count() as u32).div_ceil(GROUP));
        for kernel in &it.find {
            let jobs = step(job..job + 1);
            pass.run(kernel, &[&bound.touching, mesh.group()], bytemuck::bytes_of(&jobs), faces)?;
        }
        let bound = [&bound.smoothing, mesh.group(), values.group()];
        let [bring, spread, average, apply, settle] = [0, 1, 2, 3, 4].map(|kernel| &it.smooth[kernel]);
        let mut run = |kernel: &Kernel, round: usize| {
            let jobs = step(job..job + round);
            pass.run_indirect(kernel, &bound, bytemuck::bytes_of(&jobs), &self.arguments, STAGE * job + 1)
        };
        run(bring, 0)?;
        (0..REACH).try_for_each(|round| run(spread, round))?;
        for _ in 0..passes {
            run(average, 0)?;
            run(apply, 0)?;
        }
        run(settle, 0)
    }
}
