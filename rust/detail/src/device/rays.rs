//! The displacement update on a graphics device (`shaders/imprint_cast.wgsl`), as [`crate::raycast`] makes it: blocks of
//! coefficients, of which every invocation takes two.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};

use super::voxel::DeviceVoxels;
use crate::cull::VoxelFrame;
use crate::knots::BLOCK_KNOTS;
use crate::raycast::{Limits, deepest};

/// As in `imprint_cast.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Cast {
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    origin: [f32; 3],
    blocks: u32,
    dims: [u32; 3],
    share: f32,
    max_displacement: f32,
    depth: f32,
    deepest: i32,
    length: u32,
    zero: u32,
    padding: [u32; 3],
}

/// What became of a block of coefficients. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BlockReport {
    /// Coefficients that change.
    pub changed: i32,
    /// Rays that left the grid inside the collider and were held at its border.
    pub clamped: i32,
    /// The least coefficient, 0 at most: halves as whole numbers of the same order, −1 for −0.
    pub least: i32,
    /// Unused.
    pub padding: i32,
}

/// Coefficients whose rays are cast on a device.
#[derive(Debug)]
pub struct DeviceRays {
    kernel: Arc<Kernel>,
    buffers: Bindings,
    changed: Buffer<u32>,
    reports: Buffer<BlockReport>,
}

/// Numbers of a sample: P, du and dv.
const SAMPLE: usize = 9;

/// Halves are in pairs.
const WORDS: usize = BLOCK_KNOTS / 2;

impl DeviceRays {
    /// Rays for blocks of 256 coefficients each. `samples` are P, du and dv at the places of the coefficients, nine
    /// numbers each, as the surface's evaluation of first order leaves them; places without a normal stay as they are.
    /// `heights` are the coefficients as halves, two a word, `starts` what they were when the depth limit began to
    /// count; without it they are the same. `counts` may say how many blocks there are.
    ///
    /// Fails where there are fewer samples or starts than coefficients, or no room on the device.
    pub fn new(
        device: &Device,
        samples: &Buffer<f32>,
        heights: &Buffer<u32>,
        starts: Option<&Buffer<u32>>,
        counts: Option<&Buffer<u32>>,
    ) -> Result<Self> {
        let blocks = heights.len() / WORDS;
        let starts = starts.unwrap_or(heights);
        if samples.len() < blocks * BLOCK_KNOTS * SAMPLE || starts.len() < blocks * WORDS {
            return Err(Error::internal(format!(
                "{} numbers of samples and {} words of starts for {blocks} blocks",
                samples.len(),
                starts.len()
            )));
        }
        use Access::{Read, Write};
        let kernel = device.kernel(&KernelSpec {
            module: "imprint_cast",
            entry: "cast_rays",
            groups: &[&[Read, Read, Read, Read, Write, Write], &[Read, Read]],
            immediates: size_of::<Cast>() as u32,
            constants: &[],
        })?;
        let changed = Buffer::new(device, "changed coefficients", heights.len())?;
        let reports = Buffer::new(device, "blocks' reports", blocks)?;
        let counts = counts.unwrap_or(heights);
        let buffers = [samples.wgpu(), heights.wgpu(), starts.wgpu(), counts.wgpu(), changed.wgpu(), reports.wgpu()];
        let buffers = device.bind(&kernel, 0, &buffers)?;
        Ok(Self { kernel, buffers, changed, reports })
    }

    /// The coefficients as they are to be, two a word.
    pub fn changed(&self) -> &Buffer<u32> {
        &self.changed
    }

    /// What became of every block.
    pub fn reports(&self) -> &Buffer<BlockReport> {
        &self.reports
    }

    fn work(&self, voxels: &DeviceVoxels, frame: &VoxelFrame, limits: &Limits) -> Cast {
        let row = |axis: usize| {
            let [x, y, z] = frame.rows[axis];
            [x, y, z, frame.shift[axis]]
        };
        Cast {
            x: row(0),
            y: row(1),
            z: row(2),
            origin: frame.origin,
            blocks: self.reports.len() as u32,
            dims: voxels.dims(),
            share: limits.share,
            max_displacement: limits.max_displacement,
            depth: limits.depth,
            deepest: deepest(limits).into(),
            length: 0,
            zero: 0,
            padding: [0; 3],
        }
    }

    /// Records the rays of the first `blocks` blocks through `voxels`, of whose grid `frame` is. The share of the limits
    /// is above 0.
    pub fn cast(
        &self,
        pass: &mut Pass<'_>,
        voxels: &DeviceVoxels,
        frame: &VoxelFrame,
        limits: &Limits,
        blocks: u32,
    ) -> Result<()> {
        let mut work = self.work(voxels, frame, limits);
        work.blocks = work.blocks.min(blocks);
        pass.run(&self.kernel, &[&self.buffers, &voxels.columns], bytemuck::bytes_of(&work), groups(work.blocks))
    }

    /// Records the rays of as many blocks as item `index` of the counts says, in as many workgroups as the three items
    /// after it say.
    pub fn cast_indirect(
        &self,
        pass: &mut Pass<'_>,
        voxels: &DeviceVoxels,
        frame: &VoxelFrame,
        limits: &Limits,
        (counts, index): (&Buffer<u32>, u32),
    ) -> Result<()> {
        let work = Cast { length: index + 1, ..self.work(voxels, frame, limits) };
        let buffers = [&self.buffers, &voxels.columns];
        pass.run_indirect(&self.kernel, &buffers, bytemuck::bytes_of(&work), counts, index as usize + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceCollider;
    use crate::grid::Grid;
    use crate::knots::KnotBlock;
    use crate::obb::Obb;
    use crate::raycast::{Scratch, TileDents, cast_block, key};
    use crate::shapes;
    use crate::voxel::{Side, Solid, Voxels};
    use glam::{DAffine3, DMat3, DVec3, Vec3};
    use half::f16;
    use relievo_core::Context;
    use relievo_testing::{Random, device, wgsl::assert_layout};
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernel() {
        let fields = [
            ("x", offset_of!(Cast, x)),
            ("y", offset_of!(Cast, y)),
            ("z", offset_of!(Cast, z)),
            ("origin", offset_of!(Cast, origin)),
            ("blocks", offset_of!(Cast, blocks)),
            ("dims", offset_of!(Cast, dims)),
            ("share", offset_of!(Cast, share)),
            ("max_displacement", offset_of!(Cast, max_displacement)),
            ("depth", offset_of!(Cast, depth)),
            ("deepest", offset_of!(Cast, deepest)),
            ("length", offset_of!(Cast, length)),
            ("zero", offset_of!(Cast, zero)),
        ];
        assert_layout("imprint_cast", "Cast", size_of::<Cast>(), &fields);
    }

    const BLOCKS: usize = 320;

    /// Blocks of coefficients at random places, some along the columns, with their samples as the device has them.
    fn coefficients(center: Vec3, seed: u64) -> (Vec<KnotBlock>, Vec<f32>, [Vec<f16>; 2]) {
        let mut random = Random(seed);
        let mut unit = move || random.below(1 << 20) as f32 / (1 << 19) as f32 - 1.0;
        let (mut blocks, mut samples, mut halves) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
        for index in 0..BLOCKS {
            let mut block = KnotBlock::ZERO;
            for knot in 0..BLOCK_KNOTS {
                let p = center + Vec3::new(unit(), unit(), unit()) * Vec3::new(1.4, 1.4, 0.6);
                let mut du = Vec3::new(unit(), unit(), unit());
                let dv = Vec3::new(unit(), unit(), unit());
                match (index + knot) % 16 {
                    // No normal.
                    0 => du = dv * 2.0,
                    1 => du = Vec3::ZERO,
                    _ => {}
                }
                let across = du.cross(dv);
                let n = if across.length_squared() > 0.0 { across / across.length() } else { Vec3::ZERO };
                for axis in 0..3 {
                    block.p[axis][knot] = p[axis];
                    block.n[axis][knot] = n[axis];
                }
                samples.extend(p.to_array().into_iter().chain(du.to_array()).chain(dv.to_array()));
                let height = unit().powi(3) * 0.2;
                halves[0].push(f16::from_f32(height));
                halves[1].push(f16::from_f32(height + 0.1 * unit()));
            }
            blocks.push(block);
        }
        (blocks, samples, halves)
    }

    #[test]
    fn coefficients_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        // Rings side by side, so that some columns are solid in pieces, at a place that floats know only roughly.
        let far = [100.0, -50.0, 20.0];
        let soup = shapes::joined(
            shapes::torus(1.0, 0.4, 48, 24),
            shapes::moved(shapes::torus(0.5, 0.15, 24, 12), [0.0, 0.0, 0.5]),
        );
        let soup = shapes::moved(soup, far);
        let center = DVec3::from(far.map(f64::from));
        let obb = Obb { center, axes: DMat3::from_rotation_x(0.4), half: DVec3::new(1.3, 1.2, 0.7) };
        let grid = Grid::new(&obb, 1 << 18, Some(1));
        let solid =
            Solid { points: &soup.0, triangles: &soup.1, transform: DAffine3::IDENTITY, closed: true, lattice: None };
        let mut voxels = Voxels::default();
        voxels.fill(&context, &grid, &solid, None, Side::Forward).unwrap();
        let collider = DeviceCollider::new(&device, &soup.0, &soup.1, true).unwrap();
        collider.set_corners(&device, &grid, &DAffine3::IDENTITY, &soup.0).unwrap();
        let there = DeviceVoxels::new(&device, &grid).unwrap();

        let (blocks, samples, halves) = coefficients(center.as_vec3(), 5);
        let words = |halves: &[f16]| -> Vec<u32> {
            halves.chunks(2).map(|pair| u32::from(pair[0].to_bits()) | u32::from(pair[1].to_bits()) << 16).collect()
        };
        let samples = Buffer::of(&device, "samples", &samples).unwrap();
        let [heights, starts] = [0, 1].map(|i| Buffer::of(&device, "heights", &words(&halves[i])).unwrap());
        let counts = Buffer::of(&device, "counts", &[BLOCKS as u32, BLOCKS as u32, 1, 1]).unwrap();
        let frame = VoxelFrame::new(&grid, &DAffine3::IDENTITY);
        let plain = Limits { share: 1.0, max_displacement: 60_000.0, depth: 60_000.0 };
        let tight = Limits { share: 0.4, max_displacement: 0.15, depth: 0.12 };
        let (mut looked, mut apart, mut rays, mut clamped) = (0_u32, 0_u32, 0, 0);
        for (limits, started) in [(plain, false), (tight, true)] {
            let from = started.then_some(&starts);
            let cast = DeviceRays::new(&device, &samples, &heights, from, Some(&counts)).unwrap();
            let mut commands = device.frame().unwrap();
            there.fill(&mut commands.pass("voxelisation"), &collider, Side::Forward, false).unwrap();
            if started {
                cast.cast_indirect(&mut commands.pass("ray casting"), &there, &frame, &limits, (&counts, 0)).unwrap();
            } else {
                cast.cast(&mut commands.pass("ray casting"), &there, &frame, &limits, BLOCKS as u32).unwrap();
            }
            let changed = commands.read(cast.changed(), 0..cast.changed().len()).unwrap();
            let reports = commands.read(cast.reports(), 0..BLOCKS).unwrap();
            let _ = commands.submit().unwrap();
            let (changed, reports) = (changed.get(&device).unwrap(), reports.get(&device).unwrap());
            let changed: Vec<_> = changed.iter().flat_map(|word| [*word as u16, (*word >> 16) as u16]).collect();
            let mut scratch = Scratch::default();
            for (index, block) in blocks.iter().enumerate() {
                let range = index * BLOCK_KNOTS..(index + 1) * BLOCK_KNOTS;
                let mut dents = TileDents::default();
                let start: [f16; BLOCK_KNOTS] = halves[1][range.clone()].try_into().unwrap();
                let old = &halves[0][range.clone()];
                let count = cast_block(
                    context.level(),
                    &frame,
                    block,
                    old,
                    started.then_some(&start),
                    &voxels.columns(),
                    &limits,
                    &mut scratch,
                    &mut dents,
                );
                let here = if count > 0 { &scratch.new()[..] } else { old };
                let mut differ = 0;
                for (here, there) in here.iter().zip(&changed[range]) {
                    let steps = i32::from(key(*here)) - i32::from(key(f16::from_bits(*there)));
                    looked += 1;
                    differ += u32::from(steps.abs() > 1);
                }
                apart += differ;
                rays += count;
                clamped += dents.clamped;
                let report = reports[index];
                if differ == 0 {
                    assert!(report.changed.abs_diff(count as i32) <= 1, "{report:?}, {count} on the processor");
                    assert!(report.clamped.abs_diff(dents.clamped as i32) <= 1, "{report:?} {dents:?}");
                }
            }
        }
        println!("{apart} of {looked} coefficients, {rays} moved, {clamped} held");
        assert!(rays > looked / 20 && clamped > 20, "{rays} {clamped}");
        assert!(apart * 10_000 < looked, "{apart} of {looked} coefficients are more than one half apart");
    }
}
