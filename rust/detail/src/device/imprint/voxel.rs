//! Solid voxels on a graphics device (`shaders/imprint/voxel`), bit by bit those of [`crate::geometry::voxel`]: points of colliders
//! are put on the lattices of grids, every triangle changes the winding number of the columns it meets at the first voxel
//! whose centre is not below it, and a voxel is solid where the number is not zero. Meanwhile
//! 16 bits are held for every voxel, 32 MiB for 2²⁴, or 32 where a collider has more than [`MAX_NARROW`] triangles.

use std::ops::Range;
use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups};

use super::batches::Batch;
use super::job::MAX_NARROW;
use super::meshes::DeviceMeshes;
use super::shared::{Shared, step};

/// Bits of a word on the device.
const WORD: u32 = 32;

/// Triangles whose work a workgroup finds, as in `imprint_link.wgsl`.
const COUNTED: u32 = 1024;

/// Columns that a ray may pass at most: a loop over them stays below the 65,535 iterations at which some devices stop,
/// with room for the words of one column.
const MAX_PASSED: u32 = 60_000;

/// Heights of a column: of its lower end and of its upper end.
const HEIGHTS: usize = 2;

/// How much voxels need: points on lattices and items of work, words of changes, of columns and of bits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VoxelRoom(pub [usize; 5]);

impl VoxelRoom {
    /// What a grid needs, and a collider of so many points and triangles in it. Fails for a grid that is too wide.
    pub fn of([points, triangles]: [u32; 2], [nx, ny, nz]: [u32; 3]) -> Result<Self> {
        if nx + ny > MAX_PASSED {
            return Err(Error::unsupported(format!(
                "{nx} × {ny} columns of voxels are too many for a graphics device"
            ))
            .advise("use fewer voxels, or the device `cpu`"));
        }
        let columns = nx as usize * ny as usize;
        let layers = if triangles <= MAX_NARROW { nz / 2 } else { nz };
        let turns = columns.saturating_mul(layers as usize + 1 + HEIGHTS);
        let words = columns.saturating_mul(nz.div_ceil(WORD) as usize);
        let ends = columns.saturating_mul(1 + HEIGHTS);
        Ok(Self([points as usize, triangles.next_multiple_of(COUNTED) as usize, turns, ends, words]))
    }

    /// What both need together.
    pub fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].saturating_add(other.0[k])))
    }

    /// What either needs.
    pub fn or(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].max(other.0[k])))
    }

    fn fits(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).all(|(own, other)| *own <= other)
    }
}

/// A kernel and the group of buffers it has to itself.
#[derive(Debug)]
struct Work {
    kernel: Arc<Kernel>,
    buffers: Bindings,
}

impl Work {
    fn new(
        device: &Device,
        [module, entry]: [&str; 2],
        bound: &[(Access, &relievo_gpu::wgpu::Buffer)],
    ) -> Result<Self> {
        let (accesses, buffers): (Vec<_>, Vec<_>) = bound.iter().copied().unzip();
        let groups: &[&[Access]] = &[&accesses];
        let immediates = size_of::<Step>() as u32;
        let kernel = device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })?;
        let buffers = device.bind(&kernel, 0, &buffers)?;
        Ok(Self { kernel, buffers })
    }

    fn run(&self, pass: &mut Pass<'_>, jobs: &Range<usize>, size: [u32; 3]) -> Result<()> {
        pass.run(&self.kernel, &[&self.buffers], bytemuck::bytes_of(&step(jobs.clone())), size)
    }
}

/// The solid voxels of grids on a device.
#[derive(Debug)]
pub(super) struct DeviceVoxels {
    room: VoxelRoom,
    /// Which buffers of meshes it is bound to.
    generation: u64,
    spans: Buffer<u32>,
    words: Buffer<u32>,
    snap: Work,
    count: Work,
    arrange: Work,
    cross: Work,
    resolve: Work,
    /// Points on the lattice of 1/256 voxel, whose fourth numbers are unused; the work of triangles and of workgroups of
    /// them; winding numbers.
    _kept: (Buffer<[i32; 4]>, [Buffer<u32>; 2], Buffer<i32>),
}

impl DeviceVoxels {
    /// Room for voxels of colliders of `meshes`. Fails where the device has none.
    fn new(device: &Device, shared: &Shared, meshes: &DeviceMeshes, room: VoxelRoom) -> Result<Self> {
        use Access::{Read, Write};
        let VoxelRoom([corners, items, changes, columns, words]) = room;
        let corners = Buffer::new(device, "colliders' corners", corners)?;
        let starts = Buffer::new(device, "triangles' work", items)?;
        let sums = Buffer::new(device, "work of workgroups", items / COUNTED as usize + 1)?;
        let turns = Buffer::new(device, "winding numbers", changes)?;
        let spans = Buffer::new(device, "columns", columns)?;
        let words = Buffer::new(device, "voxels", words)?;
        let jobs = (Read, shared.jobs.wgpu());
        let counters = (Write, shared.counters.wgpu());
        let (mesh, indices) = ((Read, corners.wgpu()), (Read, meshes.triangles().wgpu()));
        let bound =
            [jobs, (Read, meshes.points().wgpu()), (Write, corners.wgpu()), counters, (Write, shared.boxes.wgpu())];
        let snap = Work::new(device, ["imprint_snap", "snap"], &bound)?;
        let bound = [jobs, mesh, indices, (Write, starts.wgpu()), counters, (Write, sums.wgpu())];
        let count = Work::new(device, ["imprint_count", "count"], &bound)?;
        let [arguments, candidates] = [&shared.arguments, &shared.candidates].map(|it| (Write, it.wgpu()));
        let bound = [jobs, (Write, sums.wgpu()), arguments, counters, candidates];
        let arrange = Work::new(device, ["imprint_arrange", "arrange"], &bound)?;
        let reads = [jobs, mesh, indices, (Read, starts.wgpu()), (Read, shared.arguments.wgpu())];
        let bound = [&reads[..], &[(Write, turns.wgpu()), (Read, sums.wgpu())]].concat();
        let cross = Work::new(device, ["imprint_cross", "cross_columns"], &bound)?;
        let to = [(Write, words.wgpu()), (Write, spans.wgpu())];
        let bound = [&[jobs, (Write, turns.wgpu()), (Read, shared.boxes.wgpu())], &to[..]].concat();
        let resolve = Work::new(device, ["imprint_resolve", "resolve"], &bound)?;
        let _kept = (corners, [starts, sums], turns);
        let generation = meshes.generation();
        Ok(Self { room, generation, spans, words, snap, count, arrange, cross, resolve, _kept })
    }

    /// Makes room where there is not enough, and anew where the buffers of the meshes are. Returns whether there are other
    /// buffers than before. Fails where the device has no room; there is none at all then.
    pub fn prepare(
        there: &mut Option<Self>,
        device: &Device,
        shared: &Shared,
        meshes: &DeviceMeshes,
        room: VoxelRoom,
    ) -> Result<bool> {
        let old = match there.take() {
            Some(voxels) if voxels.generation == meshes.generation() && room.fits(&voxels.room) => {
                *there = Some(voxels);
                return Ok(false);
            }
            // What it took is free before more is asked for.
            Some(voxels) => voxels.room,
            None => VoxelRoom::default(),
        };
        *there = Some(Self::new(device, shared, meshes, room.or(old))?);
        Ok(true)
    }

    /// Of column (x, y), at `y · dims[0] + x`: the lowest solid voxel, and the one after the highest in the upper half;
    /// 0xffff for a column that is solid in more than one piece. Then of every column the heights of both ends, as
    /// [`Columns`](crate::geometry::voxel::Columns) has them.
    pub fn spans(&self) -> &Buffer<u32> {
        &self.spans
    }

    /// The bits of all columns: voxel z of column c is bit `z % 32` of word `z / 32 · dims[0] · dims[1] + c`.
    pub fn words(&self) -> &Buffer<u32> {
        &self.words
    }

    /// Records the voxelisation of a batch's colliders.
    pub fn fill(&self, pass: &mut Pass<'_>, shared: &Shared, batch: &Batch) -> Result<()> {
        let Batch { jobs, most: [points, triangles], .. } = batch;
        let count = jobs.len() as u32;
        self.snap.run(pass, jobs, [points.div_ceil(GROUP), count, 1])?;
        self.count.run(pass, jobs, [triangles.div_ceil(COUNTED), count, 1])?;
        self.arrange.run(pass, jobs, [1, 1, 1])?;
        for wave in &batch.waves {
            let Work { kernel, buffers } = &self.cross;
            let jobs = step(wave.jobs.clone());
            let chunks = Shared::chunks(wave.jobs.start);
            pass.run_indirect(kernel, &[buffers], bytemuck::bytes_of(&jobs), &shared.arguments, chunks)?;
            let [x, y, _] = groups(wave.columns.div_ceil(GROUP));
            self.resolve.run(pass, &wave.jobs, [x, y, wave.jobs.len() as u32])?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::imprint::batches::batches;
    use crate::device::imprint::job::{Ground, ImprintJob, JobParams};
    use crate::device::imprint::meshes::Place;
    use crate::device::imprint::shared::{check, parse};
    use crate::geometry::grid::Grid;
    use crate::geometry::obb::Obb;
    use crate::geometry::scanline::{FINE, NO_HEIGHT, height_stride};
    use crate::geometry::voxel::{Side, Solid, Voxels};
    use crate::imprint::collider::Collider;
    use crate::imprint::settings::ImprintSettings;
    use crate::object::shapes::{self, Soup};
    use glam::{DAffine3, DMat3, DVec3, EulerRot};
    use relievo_core::Context;
    use relievo_gpu::wgsl::imprint_link::JobCounters;
    use relievo_testing::device;

    /// Voxels of a collider, its box, and what was told.
    struct Made {
        corners: Vec<[i32; 4]>,
        extrema: [u32; 6],
        spans: Vec<u32>,
        words: Vec<u32>,
        counters: JobCounters,
    }

    /// Voxelises on a device, twice: the first time leaves nothing behind that the second would count. `closed` is what
    /// the collider is taken for, and `moved` is a point that is somewhere else than the collider knows.
    fn voxelise(
        device: &Device,
        collider: &Collider,
        grid: &Grid,
        (side, closed): (Side, bool),
        moved: Option<[f32; 3]>,
    ) -> Made {
        let shared = Shared::new(device).unwrap();
        let mut meshes = DeviceMeshes::new(device).unwrap();
        meshes.bring(device, &[collider]).unwrap();
        if let Some(point) = moved {
            meshes.points().write(device, 7, &[point]).unwrap();
        }
        let limits = ImprintSettings::default().limits();
        let job = ImprintJob::of(0, collider, grid, &limits, side, collider.lattice(grid).unwrap());
        let place = Place { closed, ..meshes.place(job.mesh).unwrap().clone() };
        let ground = Ground { transform: &DAffine3::IDENTITY, tiles: 0, started: false, slots: None };
        let mut words = [JobParams::new(&job, &place, &ground)];
        let batches = batches(&mut words, &[0], 1 << 26).unwrap();
        let mut voxels = None;
        assert!(DeviceVoxels::prepare(&mut voxels, device, &shared, &meshes, batches[0].room).unwrap());
        let voxels = voxels.unwrap();
        let mut frame = device.frame().unwrap();
        shared.begin(device, &mut frame, &words).unwrap();
        for _ in 0..2 {
            voxels.fill(&mut frame.pass("voxelisation"), &shared, &batches[0]).unwrap();
        }
        let (corners, ..) = &voxels._kept;
        let corners = frame.read(corners, 0..corners.len()).unwrap();
        let spans = frame.read(voxels.spans(), 0..voxels.spans().len()).unwrap();
        let words = frame.read(voxels.words(), 0..voxels.words().len()).unwrap();
        let boxes = frame.read(&shared.boxes, 0..1).unwrap();
        let counters = shared.read_counters(&mut frame, 1).unwrap();
        let _ = frame.submit().unwrap();
        Made {
            corners: corners.get(device).unwrap(),
            extrema: boxes.get(device).unwrap()[0],
            spans: spans.get(device).unwrap(),
            words: words.get(device).unwrap(),
            counters: parse(&counters.get(device).unwrap()).1[0],
        }
    }

    fn around(center: [f64; 3], half: [f64; 3], angle: f64) -> Obb {
        let axes = DMat3::from_euler(EulerRot::XYZ, angle, 0.6 * angle, -angle);
        Obb { center: DVec3::from(center), axes, half: DVec3::from(half) }
    }

    /// Compares the heights of the ends of columns: floats on the one, 96 bits on the other.
    fn compare_heights(voxels: &Voxels, ends: &[u32]) {
        let columns = voxels.columns();
        let [nx, ny, _] = columns.dims.map(|count| count as usize);
        let stride = height_stride(nx);
        let (mut apart, mut known) = (0, 0);
        for (column, ends) in ends.chunks(2).enumerate() {
            for (upper, end) in ends.iter().enumerate() {
                let expected = columns.heights[(2 * (column / nx) + upper) * stride + column % nx];
                assert_eq!(expected == NO_HEIGHT, *end == NO_HEIGHT, "column {column}: {expected} {end}");
                let off = (expected as i32 - *end as i32).abs();
                assert!(off <= FINE / 256, "column {column}: {expected} {end}");
                apart += usize::from(off > 1);
                known += usize::from(expected != NO_HEIGHT);
            }
        }
        assert_eq!(ends.len(), 2 * nx * ny);
        assert!(apart * 100 <= known, "{apart} of {known}");
    }

    /// Voxelises on both and compares every voxel and every column's ends. Returns the solid voxels.
    fn compare(device: &Device, soup: &Soup, grid: &Grid, transform: DAffine3, side: Side, closed: bool) -> u64 {
        let context = Context::serial();
        let collider = Collider::new(&context, soup.0.clone(), soup.1.clone(), transform).unwrap();
        let lattice = collider.lattice(grid);
        let solid = Solid { points: &soup.0, triangles: &soup.1, transform, closed, lattice };
        let mut voxels = Voxels::default();
        voxels.fill(&context, grid, &solid, None, side).unwrap();
        let Made { spans, words, counters, .. } = voxelise(device, &collider, grid, (side, closed), None);
        check(&counters).unwrap();
        let [nx, ny, nz] = grid.dims;
        let (spans, ends) = spans.split_at((nx * ny) as usize);
        assert!(voxels.columns().spans == spans, "{:?} {side:?}", grid.dims);
        compare_heights(&voxels, ends);
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
        // Of so many triangles no word holds two numbers.
        let fine = shapes::sphere(0.9, 200, 100, 0.0);
        assert!(fine.1.len() > MAX_NARROW as usize);
        let grid = Grid::new(&around([0.2, -0.1, 0.3], [0.9, 0.5, 0.7], 0.2), 1 << 15, None);
        assert!(compare(&device, &fine, &grid, turned, Side::Backward, true) > 5_000);
    }

    #[test]
    fn colliders_are_voxelised_together_whatever_is_there_at_once() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let (points, triangles) = shapes::sphere(0.8, 30, 20, 0.1);
        let colliders: Vec<Collider> = (0..5)
            .map(|k| {
                let transform = DAffine3::from_scale(DVec3::new(1.0, 0.8 + 0.1 * f64::from(k), 1.0));
                Collider::new(&context, points.clone(), triangles.clone(), transform).unwrap()
            })
            .collect();
        let colliders: Vec<&Collider> = colliders.iter().collect();
        let grid = |k: usize| {
            let angle = 0.4 * k as f64;
            Grid::new(&around([0.1, 0.2, 0.3 - 0.1 * angle], [0.5 + 0.2 * angle, 0.6, 0.7], angle), 1 << 14, None)
        };
        let shared = Shared::new(&device).unwrap();
        let mut meshes = DeviceMeshes::new(&device).unwrap();
        meshes.bring(&device, &colliders).unwrap();
        let limits = ImprintSettings::default().limits();
        let ground = Ground { transform: &DAffine3::IDENTITY, tiles: 0, started: false, slots: None };
        // The winding numbers of two grids at once, those of one, and no two grids in a batch.
        for (most, wanted) in [(20_000, [1, 3]), (8_500, [1, 5]), (1, [5, 1])] {
            let mut words: Vec<JobParams> = (0..5)
                .map(|k| {
                    let grid = grid(k);
                    let lattice = colliders[k].lattice(&grid).unwrap();
                    let job = ImprintJob::of(0, colliders[k], &grid, &limits, Side::Forward, lattice);
                    JobParams::new(&job, meshes.place(job.mesh).unwrap(), &ground)
                })
                .collect();
            let batches = batches(&mut words, &[0, 1, 0, 1, 1], most).unwrap();
            assert_eq!([batches.len(), batches[0].waves.len()], wanted, "{batches:?}");
            let room = batches.iter().fold(VoxelRoom::default(), |room, batch| room.or(batch.room));
            let mut voxels = None;
            DeviceVoxels::prepare(&mut voxels, &device, &shared, &meshes, room).unwrap();
            let voxels = voxels.unwrap();
            let mut frame = device.frame().unwrap();
            shared.begin(&device, &mut frame, &words).unwrap();
            let mut spans = Vec::new();
            for batch in &batches {
                voxels.fill(&mut frame.pass("voxelisation"), &shared, batch).unwrap();
                spans.push(frame.read(voxels.spans(), 0..batch.room.0[3]).unwrap());
            }
            let _ = frame.submit().unwrap();
            let spans: Vec<Vec<u32>> = spans.into_iter().map(|it| it.get(&device).unwrap()).collect();
            let mut found = spans.concat().into_iter();
            for (k, collider) in colliders.iter().enumerate() {
                let solid = Solid {
                    points: &points,
                    triangles: &triangles,
                    transform: *collider.transform(),
                    closed: true,
                    lattice: collider.lattice(&grid(k)),
                };
                let mut expected = Voxels::default();
                expected.fill(&context, &grid(k), &solid, None, Side::Forward).unwrap();
                let count = expected.columns().spans.len();
                let spans: Vec<u32> = found.by_ref().take(3 * count).collect();
                assert!(expected.count() > 1000 && expected.columns().spans == &spans[..count], "collider {k}, {most}");
                compare_heights(&expected, &spans[count..]);
            }
        }
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
        let soups = [(shapes::cube(7.5), true), (shapes::cube(20.0), true), (roof, false)];
        for (soup, may_be_closed) in soups {
            for side in [Side::Forward, Side::Backward] {
                for closed in [false, may_be_closed] {
                    assert!(compare(&device, &soup, &grid, still, side, closed) > 0);
                }
            }
        }
    }

    #[test]
    fn no_loop_ends_early_in_the_longest_columns_and_the_widest_rows() {
        let Some(device) = device() else { return };
        let most = crate::geometry::grid::MAX_VOXELS_PER_AXIS;
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
        let context = Context::serial();
        let (points, triangles) = shapes::sphere(0.8, 40, 20, 0.1);
        let grid = Grid::new(&around([0.1; 3], [0.5, 0.6, 0.7], 0.4), 1 << 18, None);
        let collider = Collider::new(&context, points.clone(), triangles, DAffine3::from_rotation_x(0.3)).unwrap();
        let lattice = collider.lattice(&grid).unwrap();
        let made = |moved| voxelise(&device, &collider, &grid, (Side::Forward, true), moved);
        let Made { corners, extrema, counters, .. } = made(None);
        check(&counters).unwrap();
        // The box along the axes of the grid, of all points and of no others.
        for axis in 0..3 {
            let along = || corners.iter().map(|corner| corner[axis]);
            let ends = [extrema[axis], extrema[axis + 3]].map(|word| (word ^ 1 << 31) as i32);
            assert_eq!(ends, [along().max().unwrap(), -along().min().unwrap()], "axis {axis}");
        }
        for (corner, point) in corners.iter().zip(&points) {
            let place = lattice.place(*point).unwrap();
            assert_eq!(corner[..3].iter().map(|it| i64::from(*it)).collect::<Vec<_>>(), place);
        }
        for lost in [1e9, f32::NAN] {
            let counters = check(&made(Some([0.1, lost, 0.2])).counters);
            assert!(counters.unwrap_err().to_string().contains("too far"));
        }
    }
}
