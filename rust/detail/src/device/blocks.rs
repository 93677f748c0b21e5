//! Blocks of coefficients between culling and the host on a graphics device: which there are (`shaders/imprint_list.wgsl`),
//! what their rays start from (`shaders/imprint_sample.wgsl`), and those that changed (`shaders/imprint_keep.wgsl`).
//!
//! There is room for so many blocks; the numbers that come back say whether it was enough.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, Kernel, KernelSpec, Pass};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{DeviceTiles, TILES_GROUP};

use super::cull::DeviceCull;
use super::rays::DeviceRays;
use super::voxel::DeviceVoxels;
use crate::cull::VoxelFrame;
use crate::knots::BLOCK_KNOTS;
use crate::raycast::Limits;

/// As in `imprint_list.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Listing {
    room: u32,
    link: u32,
}

/// As in `imprint_sample.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sampling {
    flags: u32,
    base: u32,
    stride: u32,
    zero: u32,
}

/// As in `imprint_keep.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Keeping {
    flags: u32,
    base: u32,
    stride: u32,
    room: u32,
    link: u32,
}

const STARTED: u32 = 1;
const CHAINED: u32 = 2;

/// A block that an imprint changed. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Record {
    pub tile: u32,
    /// The block, and in the upper half which of the imprints it was that were submitted together.
    block: u32,
    /// Coefficients that change.
    pub changed: u32,
    /// The least coefficient, 0 at most, as the key of `imprint_cast.wgsl`.
    pub least: i32,
    /// The coefficients, two a word.
    pub values: [u32; BLOCK_KNOTS / 2],
}

impl Record {
    pub fn link(&self) -> u32 {
        self.block >> 16
    }

    pub fn block(&self) -> u32 {
        self.block & 0xffff
    }
}

/// What is told of an imprint. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct Told {
    /// Blocks that were found, whether or not there was room for them.
    pub found: u32,
    /// Rays that were held at the border of the grid.
    pub clamped: u32,
    pub tiles: u32,
    /// Faults in voxelising.
    pub faults: u32,
    /// Coefficients that were looked at.
    pub tested: u32,
    unused: [u32; 3],
}

/// Words before those of the first imprint.
const FIRST: usize = 4;
const TOLD: usize = size_of::<Told>() / 4;

/// Imprints that are submitted together at most.
pub(crate) const MOST_LINKS: usize = 64;

/// Where the slots of an object's blocks are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slots {
    pub base: u32,
    /// Slots of a tile.
    pub stride: u32,
}

/// Room for blocks on a device.
#[derive(Debug)]
pub(super) struct DeviceBlocks {
    list: [Arc<Kernel>; 2],
    sample: Arc<Kernel>,
    keep: Arc<Kernel>,
    rays: DeviceRays,
    arguments: Buffer<u32>,
    told: Buffer<u32>,
    records: Buffer<Record>,
    slots: Buffer<u32>,
    listing: Bindings,
    sampling: Bindings,
    keeping: Bindings,
    /// Blocks that an imprint may look at.
    pub room: usize,
    _kept: (Buffer<[u32; 2]>, Buffer<f32>, [Buffer<u32>; 2]),
}

use Access::{Read, Write};

/// The kernels that list blocks.
pub(super) fn list_kernel(device: &Device, entry: &str) -> Result<Arc<Kernel>> {
    device.kernel(&KernelSpec {
        module: "imprint_list",
        entry,
        groups: &[&[Read, Read, Read, Read], &[Write, Write, Write]],
        immediates: size_of::<Listing>() as u32,
        constants: &[],
    })
}

/// The kernel that keeps blocks.
pub(super) fn keep_kernel(device: &Device) -> Result<Arc<Kernel>> {
    device.kernel(&KernelSpec {
        module: "imprint_keep",
        entry: "keep",
        groups: &[&[Read, Read, Read, Read, Write, Write, Write], &[Write]],
        immediates: size_of::<Keeping>() as u32,
        constants: &[],
    })
}

impl DeviceBlocks {
    /// Room for `room` blocks of an imprint, `records` changed ones of all and as many `slots` as there are blocks in
    /// tiles. Fails where the device has none.
    pub fn new(device: &Device, room: usize, records: usize, slots: usize) -> Result<Self> {
        let sample = device.kernel(&KernelSpec {
            module: "imprint_sample",
            entry: "sample",
            groups: &[&[Read, Read, Read, Read, Write, Write, Write], &SURFACE_GROUP, &TILES_GROUP, &TILES_GROUP],
            immediates: size_of::<Sampling>() as u32,
            constants: &[],
        })?;
        let list = [list_kernel(device, "list")?, list_kernel(device, "arrange")?];
        let keep = keep_kernel(device)?;
        let listed = Buffer::new(device, "listed blocks", room)?;
        let arguments = Buffer::new(device, "blocks' arguments", 4)?;
        let samples = Buffer::new(device, "samples", 9 * BLOCK_KNOTS * room)?;
        let [heights, starts] = ["coefficients", "coefficients at the start"]
            .map(|label| Buffer::new(device, label, BLOCK_KNOTS / 2 * room));
        let (heights, starts) = (heights?, starts?);
        let told = Buffer::new(device, "what is told of imprints", FIRST + TOLD * MOST_LINKS)?;
        let records = Buffer::new(device, "changed blocks", records)?;
        let slots = Buffer::new(device, "blocks' slots", slots)?;
        let rays = DeviceRays::new(device, &samples, &heights, Some(&starts), Some(&arguments))?;
        let listing = device.bind(&list[0], 1, &[listed.wgpu(), told.wgpu(), arguments.wgpu()])?;
        let from = [listed.wgpu(), arguments.wgpu(), records.wgpu(), slots.wgpu()];
        let to = [samples.wgpu(), heights.wgpu(), starts.wgpu()];
        let sampling = device.bind(&sample, 0, &[&from[..], &to[..]].concat())?;
        let from = [listed.wgpu(), arguments.wgpu(), rays.reports().wgpu(), rays.changed().wgpu()];
        let to = [told.wgpu(), records.wgpu(), slots.wgpu()];
        let keeping = device.bind(&keep, 0, &[&from[..], &to[..]].concat())?;
        let _kept = (listed, samples, [heights, starts]);
        Ok(Self { list, sample, keep, rays, arguments, told, records, slots, listing, sampling, keeping, room, _kept })
    }

    /// Blocks that imprints which are submitted together may change.
    pub fn record_room(&self) -> usize {
        self.records.len()
    }

    /// Slots of blocks.
    pub fn slot_room(&self) -> usize {
        self.slots.len()
    }

    /// Records that nothing was told so far.
    pub fn begin(&self, frame: &mut Frame) {
        frame.clear(&self.told);
    }

    /// Records that no block has a slot.
    pub fn clear_slots(&self, frame: &mut Frame) {
        frame.clear(&self.slots);
    }

    /// Records the list of the blocks that culling left.
    pub fn list(&self, pass: &mut Pass<'_>, culling: &DeviceCull, link: u32) -> Result<()> {
        let work = Listing { room: self.room as u32, link };
        let (groups, immediates) = ([&culling.culled, &self.listing], bytemuck::bytes_of(&work));
        let [list, arrange] = &self.list;
        pass.run_indirect(list, &groups, immediates, culling.counts(), culling.arguments()[0])?;
        pass.run(arrange, &groups, immediates, [1, 1, 1])
    }

    /// Records what the rays of the listed blocks start from. `slots` are where earlier imprints of the submission left
    /// blocks, and `start` is the displacement from which the depth limit counts, that of `tiles` where it is `None`.
    pub fn sample(
        &self,
        pass: &mut Pass<'_>,
        surface: &DeviceSurface,
        tiles: &DeviceTiles,
        start: Option<&DeviceTiles>,
        slots: Option<Slots>,
    ) -> Result<()> {
        let flags = if start.is_some() { STARTED } else { 0 } | chained(slots);
        let Slots { base, stride } = slots.unwrap_or(Slots { base: 0, stride: 0 });
        let work = Sampling { flags, base, stride, zero: 0 };
        let groups = [&self.sampling, surface.group(), tiles.group(), start.unwrap_or(tiles).group()];
        pass.run_indirect(&self.sample, &groups, bytemuck::bytes_of(&work), &self.arguments, 1)
    }

    /// Records the rays of the listed blocks.
    pub fn cast(&self, pass: &mut Pass<'_>, voxels: &DeviceVoxels, frame: &VoxelFrame, limits: &Limits) -> Result<()> {
        self.rays.cast_indirect(pass, voxels, frame, limits, (&self.arguments, 0))
    }

    /// Records that the blocks which changed are kept.
    pub fn keep(&self, pass: &mut Pass<'_>, culling: &DeviceCull, slots: Option<Slots>, link: u32) -> Result<()> {
        let Slots { base, stride } = slots.unwrap_or(Slots { base: 0, stride: 0 });
        let work = Keeping { flags: chained(slots), base, stride, room: self.records.len() as u32, link };
        let groups = [&self.keeping, &culling.lowering];
        pass.run_indirect(&self.keep, &groups, bytemuck::bytes_of(&work), &self.arguments, 1)
    }

    /// What is told, and the word of it that takes the faults of imprint `link`.
    pub fn told(&self, link: usize) -> (&Buffer<u32>, usize) {
        (&self.told, FIRST + TOLD * link + 3)
    }

    /// Records the way back of what is told of `links` imprints.
    pub fn read_told(&self, frame: &mut Frame, links: usize) -> Result<relievo_gpu::Readback<u32>> {
        frame.read(&self.told, 0..FIRST + TOLD * links)
    }

    /// Records the way back of the records `range`.
    pub fn read(&self, frame: &mut Frame, range: std::ops::Range<usize>) -> Result<relievo_gpu::Readback<Record>> {
        frame.read(&self.records, range)
    }
}

fn chained(slots: Option<Slots>) -> u32 {
    if slots.is_some() { CHAINED } else { 0 }
}

/// How many blocks changed in all imprints, and what is told of each, from the words of [`DeviceBlocks::read_told`].
pub(super) fn parse(words: &[u32]) -> (usize, Vec<Told>) {
    let (first, each) = words.split_at(FIRST.min(words.len()));
    (first.first().map_or(0, |kept| *kept as usize), bytemuck::cast_slice(each).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn the_layouts_are_those_of_the_kernels() {
        let listing = [("room", offset_of!(Listing, room)), ("link", offset_of!(Listing, link))];
        assert_layout("imprint_list", "Listing", size_of::<Listing>(), &listing);
        let sampling = [
            ("flags", offset_of!(Sampling, flags)),
            ("base", offset_of!(Sampling, base)),
            ("stride", offset_of!(Sampling, stride)),
            ("zero", offset_of!(Sampling, zero)),
        ];
        assert_layout("imprint_sample", "Sampling", size_of::<Sampling>(), &sampling);
        let keeping = [
            ("flags", offset_of!(Keeping, flags)),
            ("base", offset_of!(Keeping, base)),
            ("stride", offset_of!(Keeping, stride)),
            ("room", offset_of!(Keeping, room)),
            ("link", offset_of!(Keeping, link)),
        ];
        assert_layout("imprint_keep", "Keeping", size_of::<Keeping>(), &keeping);
    }
}
