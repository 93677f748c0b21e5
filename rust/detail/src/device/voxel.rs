//! Solid voxels on a graphics device (`shaders/imprint_*.wgsl`), bit by bit those of [`crate::voxel`]: every triangle
//! changes the winding number of the columns it meets at the first voxel whose centre is not below it, and a voxel is
//! solid where the number is not zero. A word is held for every voxel meanwhile, 64 MiB for 2²⁴.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups};

use super::collider::DeviceCollider;
use crate::grid::Grid;
use crate::voxel::Side;

/// As `Voxelise` in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Shape {
    nx: u32,
    ny: u32,
    nz: u32,
    flags: u32,
    pub(super) triangles: u32,
}

const BACKWARD: u32 = 1;
const OPEN: u32 = 2;
const MIRRORED: u32 = 4;

/// Bits of a word on the device.
const WORD: u32 = 32;

/// The solid voxels of a grid on a device.
#[derive(Debug)]
pub struct DeviceVoxels {
    dims: [u32; 3],
    turns: Buffer<i32>,
    spans: Buffer<u32>,
    words: Buffer<u32>,
    cross: Arc<Kernel>,
    resolve: Arc<Kernel>,
    crossed: Bindings,
    resolved: Bindings,
    /// The columns, as kernels read them.
    pub(super) columns: Bindings,
}

/// The kernel that looks at chunks of columns.
pub(super) fn facets(device: &Device) -> Result<Arc<Kernel>> {
    use Access::{Read, Write};
    device.kernel(&KernelSpec {
        module: "imprint_cross",
        entry: "cross_columns",
        groups: &[&[Read, Read], &[Read, Read], &[Write]],
        immediates: size_of::<Shape>() as u32,
        constants: &[],
    })
}

/// Columns that a ray may pass at most: a loop over them stays below the 65,535 iterations at which some devices stop,
/// with room for the words of one column.
const MOST_PASSED: u32 = 60_000;

/// What a grid of the given size needs: words of changes, of columns and of bits. Fails for one that is too wide.
fn needs([nx, ny, nz]: [u32; 3]) -> Result<[usize; 3]> {
    if nx + ny > MOST_PASSED {
        return Err(Error::unsupported(format!("{nx} × {ny} columns of voxels are too many for a graphics device"))
            .advise("use fewer voxels, or the device `cpu`"));
    }
    let columns = nx as usize * ny as usize;
    Ok([columns.saturating_mul(nz as usize + 1), columns, columns.saturating_mul(nz.div_ceil(WORD) as usize)])
}

impl DeviceVoxels {
    /// Room for the voxels of `grid`. Fails where the device has none.
    pub fn new(device: &Device, grid: &Grid) -> Result<Self> {
        let [changes, columns, words] = needs(grid.dims)?;
        let turns = Buffer::new(device, "winding numbers", changes)?;
        let spans = Buffer::new(device, "columns", columns)?;
        let words = Buffer::new(device, "voxels", words)?;
        let cross = facets(device)?;
        let resolve = device.kernel(&KernelSpec {
            module: "imprint_resolve",
            entry: "resolve",
            groups: &[&[Access::Write; 3]],
            immediates: size_of::<Shape>() as u32,
            constants: &[],
        })?;
        let crossed = device.bind(&cross, 2, &[turns.wgpu()])?;
        let resolved = device.bind(&resolve, 0, &[turns.wgpu(), spans.wgpu(), words.wgpu()])?;
        let read = device.bind(&cross, 0, &[spans.wgpu(), words.wgpu()])?;
        Ok(Self { dims: grid.dims, turns, spans, words, cross, resolve, crossed, resolved, columns: read })
    }

    /// Makes room for the voxels of `grid` if there is not enough. Fails where the device has none.
    pub fn prepare(&mut self, device: &Device, grid: &Grid) -> Result<()> {
        let [changes, columns, words] = needs(grid.dims)?;
        if changes > self.turns.len() || columns > self.spans.len() || words > self.words.len() {
            *self = Self::new(device, grid)?;
        }
        self.dims = grid.dims;
        Ok(())
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// Of column (x, y), at `y · dims[0] + x`: the lowest solid voxel, and the one after the highest in the upper half;
    /// 0xffff for a column that is solid in more than one piece.
    pub fn spans(&self) -> &Buffer<u32> {
        &self.spans
    }

    /// The bits of all columns: voxel z of column c is bit `z % 32` of word `z / 32 · dims[0] · dims[1] + c`.
    pub fn words(&self) -> &Buffer<u32> {
        &self.words
    }

    /// Records the voxelisation of a collider whose points are on the lattice of the grid. `mirrored` says whether the
    /// map from its object space to the voxels turns it inside out.
    pub fn fill(&self, pass: &mut Pass<'_>, collider: &DeviceCollider, side: Side, mirrored: bool) -> Result<()> {
        let [nx, ny, nz] = self.dims;
        let flag = |condition: bool, flag: u32| if condition { flag } else { 0 };
        let flags =
            flag(side == Side::Backward, BACKWARD) | flag(!collider.is_closed(), OPEN) | flag(mirrored, MIRRORED);
        let shape = Shape { nx, ny, nz, flags, triangles: collider.triangle_count };
        collider.count(pass, &shape)?;
        let immediates = bytemuck::bytes_of(&shape);
        let bindings = [&collider.mesh, &collider.items, &self.crossed];
        pass.run_indirect(&self.cross, &bindings, immediates, &collider.arguments, 1)?;
        pass.run(&self.resolve, &[&self.resolved], immediates, groups((nx * ny).div_ceil(GROUP)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;
    use crate::obb::Obb;
    use crate::shapes::{self, Soup};
    use crate::voxel::{Solid, Voxels};
    use glam::{DAffine3, DMat3, DVec3, EulerRot};
    use relievo_core::Context;
    use relievo_testing::{device, wgsl::assert_layout};
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernels() {
        let fields = [
            ("nx", offset_of!(Shape, nx)),
            ("ny", offset_of!(Shape, ny)),
            ("nz", offset_of!(Shape, nz)),
            ("flags", offset_of!(Shape, flags)),
            ("triangles", offset_of!(Shape, triangles)),
        ];
        for module in ["imprint_facet", "imprint_resolve"] {
            assert_layout(module, "Voxelise", size_of::<Shape>(), &fields);
        }
    }

    fn around(center: [f64; 3], half: [f64; 3], angle: f64) -> Obb {
        let axes = DMat3::from_euler(EulerRot::XYZ, angle, 0.6 * angle, -angle);
        Obb { center: DVec3::from(center), axes, half: DVec3::from(half) }
    }

    /// Voxelises on both and compares every voxel and every column's ends. Returns the solid voxels.
    fn compare(device: &Device, soup: &Soup, grid: &Grid, transform: DAffine3, side: Side, closed: bool) -> u64 {
        let solid = Solid { points: &soup.0, triangles: &soup.1, transform, closed, lattice: None };
        let mut voxels = Voxels::default();
        voxels.fill(&Context::serial(), grid, &solid, None, side).unwrap();
        let collider = DeviceCollider::new(device, &soup.0, &soup.1, closed).unwrap();
        collider.set_corners(device, grid, &transform, &soup.0).unwrap();
        let there = DeviceVoxels::new(device, grid).unwrap();
        let mirrored = (grid.map * transform).matrix3.determinant() < 0.0;
        // Twice: the first leaves nothing behind that the second would count.
        let mut frame = device.frame().unwrap();
        for _ in 0..2 {
            there.fill(&mut frame.pass("voxelisation"), &collider, side, mirrored).unwrap();
        }
        let spans = frame.read(there.spans(), 0..there.spans().len()).unwrap();
        let words = frame.read(there.words(), 0..there.words().len()).unwrap();
        let faults = collider.faults(&mut frame).unwrap();
        let _ = frame.submit().unwrap();
        faults.check(device).unwrap();
        let (spans, words) = (spans.get(device).unwrap(), words.get(device).unwrap());
        assert!(voxels.columns().spans == &spans[..], "{:?} {side:?}", grid.dims);
        let [nx, ny, nz] = grid.dims;
        for column in 0..nx * ny {
            for z in 0..nz {
                let bit = words[(z / WORD * nx * ny + column) as usize] >> (z % WORD) & 1 != 0;
                assert_eq!(bit, voxels.get([column % nx, column / nx, z]), "{column} {z} of {:?}", grid.dims);
            }
        }
        voxels.count()
    }

    #[test]
    fn voxels_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let torus = || shapes::torus(1.0, 0.4, 40, 30);
        let soup = shapes::joined(torus(), shapes::sphere(0.8, 20, 12, 0.1));
        let turned = DAffine3::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 0.7);
        let mirror = turned * DAffine3::from_scale(DVec3::new(1.0, -1.2, 0.9));
        let mut solid = 0;
        for (index, (transform, angle)) in [(turned, 0.0), (mirror, 0.3), (turned, -1.1)].into_iter().enumerate() {
            let half = [0.9, 0.5 + 0.2 * index as f64, 0.7];
            let grid = Grid::new(&around([0.2, -0.1, 0.3], half, angle), 1 << 15, None);
            for (side, closed) in [(Side::Forward, true), (Side::Backward, true), (Side::Backward, false)] {
                solid += compare(&device, &soup, &grid, transform, side, closed);
            }
        }
        assert!(solid > 30_000, "{solid}");
    }

    #[test]
    fn shells_inside_out_open_sheets_and_planes_of_the_lattice_too() {
        let Some(device) = device() else { return };
        let still = DAffine3::IDENTITY;
        let ball = |radius: f32, x: f32| shapes::moved(shapes::sphere(radius, 24, 12, 0.0), [x, 0.0, 0.0]);
        let grid = Grid::new(&around([0.0; 3], [1.2, 0.8, 0.9], 0.2), 1 << 14, None);
        let shells =
            [ball(0.8, 0.0), shapes::inverted(ball(0.5, 0.0)), ball(0.3, 0.4), ball(0.3, 0.4), ball(0.2, -0.9)];
        let shells = shells.into_iter().reduce(shapes::joined).unwrap();
        assert!(compare(&device, &shells, &grid, still, Side::Forward, true) > 0);
        assert!(compare(&device, &shells, &grid, still, Side::Backward, true) > 0);
        // Corners, sides and faces on centres of voxels, and planes at 45° through them.
        let map = DAffine3::from_translation(DVec3::splat(16.0));
        let grid = Grid { dims: [32; 3], size: DVec3::ONE, map, ..grid };
        let roof = (
            vec![[-9.5, -9.5, -9.5], [9.5, -9.5, 9.5], [9.5, 9.5, 9.5], [-9.5, 9.5, -9.5]],
            vec![[0, 1, 2], [0, 2, 3]],
        );
        for soup in [shapes::cube(7.5), shapes::cube(20.0), roof] {
            for side in [Side::Forward, Side::Backward] {
                for closed in [true, false] {
                    assert!(compare(&device, &soup, &grid, still, side, closed) > 0);
                }
            }
        }
    }

    #[test]
    fn no_loop_ends_early_in_the_longest_columns_and_the_widest_rows() {
        let Some(device) = device() else { return };
        let most = crate::grid::MAX_VOXELS_PER_AXIS;
        let obb = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let soup = shapes::moved(shapes::cube(0.9), [0.05, 0.02, -0.03]);
        // Triangles that cover the whole grid, and the winding number of all crossings summed up twice.
        for dims in [[most, 3, 1], [3, most, 1], [2, 2, most]] {
            let size = DVec3::splat(2.0) / DVec3::from(dims.map(f64::from));
            let matrix3 = DMat3::from_diagonal(size.recip());
            let map = DAffine3 { matrix3, translation: matrix3 * DVec3::ONE };
            let grid = Grid { dims, size, map, ..Grid::new(&obb, 1 << 12, Some(2)) };
            for closed in [true, false] {
                assert!(compare(&device, &soup, &grid, DAffine3::IDENTITY, Side::Backward, closed) > 1000);
            }
        }
    }

    #[test]
    fn points_are_snapped_as_on_the_processor_and_far_ones_are_reported() {
        let Some(device) = device() else { return };
        let (mut points, triangles) = shapes::sphere(0.8, 40, 20, 0.1);
        let grid = Grid::new(&around([0.1; 3], [0.5, 0.6, 0.7], 0.4), 1 << 18, None);
        let transform = DAffine3::from_rotation_x(0.3);
        let mut collider = DeviceCollider::new(&device, &points, &triangles, true).unwrap();
        let count = points.len();
        let lattice = Lattice::new(&grid, &transform, &Obb::of_points(&points).unwrap()).unwrap();
        let snapped = |collider: &DeviceCollider| {
            let mut frame = device.frame().unwrap();
            collider.snap(&mut frame.pass("snap"), &lattice).unwrap();
            let corners = frame.read(collider.corners(), 0..count).unwrap();
            let faults = collider.faults(&mut frame).unwrap();
            let _ = frame.submit().unwrap();
            (corners.get(&device).unwrap(), faults.check(&device))
        };
        let (corners, told) = snapped(&collider);
        told.unwrap();
        for (corner, point) in corners.iter().zip(&points) {
            let place = lattice.place(*point).unwrap();
            assert_eq!(corner[..3].iter().map(|it| i64::from(*it)).collect::<Vec<_>>(), place);
        }
        points[7][1] = 1e9;
        assert!(collider.set_points(&device, &points[1..]).is_err());
        collider.set_points(&device, &points).unwrap();
        assert!(snapped(&collider).1.unwrap_err().to_string().contains("too far"));
        assert!(collider.set_corners(&device, &grid, &transform, &points).is_err());
        points[7][1] = f32::NAN;
        collider.set_points(&device, &points).unwrap();
        assert!(snapped(&collider).1.is_err());
        assert!(DeviceCollider::new(&device, &points, &[[0, 1, 9999]], true).is_err());
    }
}
