//! A triangle mesh on a graphics device that is voxelised there: its points, those on the lattice of a grid, its triangles
//! and the work that each is (`shaders/imprint_snap.wgsl`, `imprint_count.wgsl`, `imprint_arrange.wgsl`).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, Readback, Scan, groups};

use super::voxel::{Shape, facets};
use crate::grid::Grid;
use crate::lattice::{FAR, Lattice};

/// Triangles up to which the kernels' sum of the work cannot wrap round.
const MOST_TRIANGLES: usize = 1 << 21;

/// As in `imprint_snap.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Snap {
    x: [i32; 3],
    count: u32,
    y: [i32; 3],
    shift: u32,
    z: [i32; 3],
    scale: f32,
    origin: [i32; 3],
    padding: u32,
    low: [u32; 3],
    padding_low: u32,
    high: [u32; 3],
    padding_high: u32,
}

impl Snap {
    fn new(lattice: &Lattice, count: u32) -> Self {
        let Lattice { rows: [x, y, z], shift, scale, origin, offset } = *lattice;
        let (low, high) = (offset.map(|it| it as u32), offset.map(|it| (it >> 32) as u32));
        let (padding, padding_low, padding_high) = (0, 0, 0);
        Self { x, count, y, shift, z, scale, origin, padding, low, padding_low, high, padding_high }
    }
}

/// A collider's mesh on a device.
#[derive(Debug)]
pub struct DeviceCollider {
    points: Buffer<f32>,
    corners: Buffer<[i32; 4]>,
    pub(super) arguments: Buffer<u32>,
    state: Buffer<u32>,
    pub(super) triangle_count: u32,
    last: u32,
    closed: bool,
    snapping: Work,
    counting: Work,
    arranging: Work,
    scan: Scan,
    /// The corners and triangles, and what says which are whose work.
    pub(super) mesh: Bindings,
    pub(super) items: Bindings,
    _kept: [Buffer<u32>; 2],
}

/// A kernel and the group of buffers it has to itself.
#[derive(Debug)]
struct Work {
    kernel: Arc<Kernel>,
    bindings: Bindings,
}

/// A device's faults in voxelising a collider, on their way back.
#[derive(Debug)]
pub struct Faults(Readback<u32>);

impl DeviceCollider {
    /// Brings a mesh to a device. `closed` says whether it has no open edge. Fails where an index does not exist, where
    /// the mesh is too large for kernels, and where the device has no room for it.
    pub fn new(device: &Device, points: &[[f32; 3]], triangles: &[[u32; 3]], closed: bool) -> Result<Self> {
        if let Some(index) = triangles.iter().position(|it| it.iter().any(|point| *point as usize >= points.len())) {
            return Err(Error::invalid("a point of the triangle does not exist").at(format!("triangle {index}")));
        }
        if triangles.len() > MOST_TRIANGLES || points.len() > 3 * MOST_TRIANGLES {
            return Err(Error::unsupported(format!(
                "a collider of {} triangles and {} points is too large for a graphics device",
                triangles.len(),
                points.len()
            ))
            .advise("use a coarser collider, or the device `cpu`"));
        }
        use Access::{Read, Write};
        let flat = Buffer::of(device, "collider points", bytemuck::cast_slice(points))?;
        let corners = Buffer::new(device, "collider corners", points.len())?;
        let indices = Buffer::of(device, "collider triangles", bytemuck::cast_slice(triangles))?;
        let starts = Buffer::new(device, "triangles' work", triangles.len())?;
        let state = Buffer::new(device, "voxelisation state", 2)?;
        let arguments = Buffer::new(device, "voxelisation arguments", 4)?;
        let scan = Scan::new(device, &starts, &arguments)?;
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize| {
            let immediates = immediates as u32;
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
        };
        let work = |kernel: Arc<Kernel>, group, buffers: &[&relievo_gpu::wgpu::Buffer]| {
            let bindings = device.bind(&kernel, group, buffers)?;
            Ok::<_, Error>(Work { kernel, bindings })
        };
        let snap = kernel("imprint_snap", "snap", &[&[Read, Write, Write]], size_of::<Snap>())?;
        let snapping = work(snap, 0, &[flat.wgpu(), corners.wgpu(), state.wgpu()])?;
        let count = kernel("imprint_count", "count", &[&[Read, Read], &[Write, Write]], size_of::<Shape>())?;
        let mesh = device.bind(&count, 0, &[corners.wgpu(), indices.wgpu()])?;
        let counting = work(count, 1, &[starts.wgpu(), state.wgpu()])?;
        let arrange = kernel("imprint_arrange", "arrange", &[&[Read, Write, Write]], size_of::<u32>())?;
        let arranging = work(arrange, 0, &[scan.sums().wgpu(), arguments.wgpu(), state.wgpu()])?;
        let items = device.bind(&*facets(device)?, 1, &[starts.wgpu(), arguments.wgpu()])?;
        Ok(Self {
            points: flat,
            corners,
            arguments,
            state,
            triangle_count: triangles.len() as u32,
            last: scan.sums().len() as u32 - 1,
            closed,
            snapping,
            counting,
            arranging,
            scan,
            mesh,
            items,
            _kept: [indices, starts],
        })
    }

    /// Whether it has no open edge.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Its points in object space, three numbers each, for kernels that move them; they stay within the box for which
    /// a lattice is made.
    pub fn points(&self) -> &Buffer<f32> {
        &self.points
    }

    /// Its points on the lattice of 1/256 voxel; the fourth number of each is unused. Whoever writes them instead of
    /// [`Self::snap`] keeps them within 2²⁴ units.
    pub fn corners(&self) -> &Buffer<[i32; 4]> {
        &self.corners
    }

    /// Writes its points in object space. Fails unless there are as many as before.
    pub fn set_points(&mut self, device: &Device, points: &[[f32; 3]]) -> Result<()> {
        if 3 * points.len() != self.points.len() {
            return Err(Error::invalid(format!("{} points for a mesh of {}", points.len(), self.points.len() / 3)));
        }
        self.points.write(device, 0, bytemuck::cast_slice(points))
    }

    /// Writes its points on the lattice as the processor computes them. Fails, before anything is written, where one is
    /// too far outside the grid.
    pub fn set_corners(&self, device: &Device, grid: &Grid, transform: &DAffine3, points: &[[f32; 3]]) -> Result<()> {
        let map = grid.map * *transform;
        let mut corners = Vec::with_capacity(points.len());
        for (index, point) in points.iter().enumerate() {
            let place = map.transform_point3(point.map(f64::from).into()).to_array().map(crate::scanline::snap);
            if place.iter().any(|value| value.abs() > FAR) {
                return Err(too_far().at(format!("point {index}")));
            }
            corners.push([place[0] as i32, place[1] as i32, place[2] as i32, 0]);
        }
        self.corners.write(device, 0, &corners)
    }

    /// Records its points on a lattice, to the bit as [`Lattice::place`] puts them there.
    pub fn snap(&self, pass: &mut Pass<'_>, lattice: &Lattice) -> Result<()> {
        let count = self.corners.len() as u32;
        let work = Snap::new(lattice, count);
        let Work { kernel, bindings } = &self.snapping;
        pass.run(kernel, &[bindings], bytemuck::bytes_of(&work), groups(count.div_ceil(GROUP)))
    }

    /// Records what work its triangles are in a grid of the given shape.
    pub(super) fn count(&self, pass: &mut Pass<'_>, shape: &Shape) -> Result<()> {
        let size = groups(shape.triangles.div_ceil(GROUP));
        let Work { kernel, bindings } = &self.counting;
        pass.run(kernel, &[&self.mesh, bindings], bytemuck::bytes_of(shape), size)?;
        self.scan.run(pass, shape.triangles)?;
        let Work { kernel, bindings } = &self.arranging;
        pass.run(kernel, &[bindings], bytemuck::bytes_of(&self.last), [1, 1, 1])
    }

    /// What went wrong since this was asked last, on its way back with the frame.
    pub fn faults(&self, frame: &mut Frame) -> Result<Faults> {
        let faults = frame.read(&self.state, 0..1)?;
        frame.clear(&self.state);
        Ok(Faults(faults))
    }

    /// As [`Self::faults`], to word `at` of a buffer, for [`check`].
    pub(super) fn tell(&self, frame: &mut Frame, told: &Buffer<u32>, at: usize) -> Result<()> {
        frame.copy(&self.state, 0..1, told, at)?;
        frame.clear(&self.state);
        Ok(())
    }
}

fn too_far() -> Error {
    Error::unsupported("the collider reaches too far beyond the overlap to be voxelised on a graphics device")
        .advise("cut the collider down, make the objects that collide closer in size, or use the device `cpu`")
}

impl Faults {
    /// Fails if the voxels of the frame are not those of the collider.
    pub fn check(self, device: &Device) -> Result<()> {
        check(self.0.get(device)?.first().copied().unwrap_or_default())
    }
}

/// Fails if something went wrong, by the word that the kernels leave.
pub(super) fn check(faults: u32) -> Result<()> {
    if faults & 1 != 0 {
        return Err(too_far());
    }
    if faults & 2 != 0 {
        return Err(Error::unsupported("the collider covers the voxel grid too many times for a graphics device")
            .advise("use fewer voxels or a coarser collider, or the device `cpu`"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernel() {
        let fields = [
            ("x", offset_of!(Snap, x)),
            ("count", offset_of!(Snap, count)),
            ("y", offset_of!(Snap, y)),
            ("shift", offset_of!(Snap, shift)),
            ("z", offset_of!(Snap, z)),
            ("scale", offset_of!(Snap, scale)),
            ("origin", offset_of!(Snap, origin)),
            ("low", offset_of!(Snap, low)),
            ("high", offset_of!(Snap, high)),
        ];
        assert_layout("imprint_snap", "Snap", size_of::<Snap>(), &fields);
    }
}
