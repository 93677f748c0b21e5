//! Smoothing of what imprints changed on a graphics device (`shaders/imprint/smooth/imprint_touch.wgsl`, `imprint_smooth.wgsl`), where
//! others of the same submission start from it, as [`crate::imprint::smoothing`] does.
//!
//! Tiles that an imprint changes, and those around them, have blocks of their own for the rest of the submission, with
//! rings that the ring update makes there. Tiles that a budget refuses are not known.

use std::sync::Arc;

use half::f16;
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, groups};
use relievo_tiles::{BoundRing, DeviceRing, DeviceTiles, Field, WorkedBlocks};

use super::blocks::DeviceBlocks;
use super::job::MAX_JOBS;
use super::shared::{Shared, step};
use super::work::Work;

/// Slots of a tile, as in `imprint_link.wgsl`.
pub(super) const SLOTS: u32 = 6;

/// Blocks that there are at first, and at most: a dispatch has as many workgroups along a dimension.
const FIRST_ROOM: usize = 64;
const MAX: usize = 65_535;

/// Words of an imprint's arguments, as in `imprint_touch.wgsl`, and where those are of parts of blocks, of rings, of
/// tiles, and of records.
const STAGE: usize = 12;
const PARTS: usize = 0;
const RINGS: usize = 3;
const TILES: usize = 6;
const RECORDS: usize = 9;

/// Kernels in the order in which they run: the first two before the rings, two in each pass, and one at the end.
const ENTRIES: [&str; 5] = ["bring", "take_over", "average", "apply", "measure"];

/// Blocks of tiles, of all objects of a submission.
#[derive(Debug)]
pub(super) struct DeviceSmoothing {
    /// Made when something is smoothed.
    kernels: Option<Kernels>,
    blocks: Buffer<u32>,
    marks: Buffer<u32>,
    listed: Buffer<u32>,
    changed: Buffer<u32>,
    stages: Buffer<u32>,
    /// More than are ever listed: how many there are the arguments say.
    counts: Buffer<u32>,
    /// How many blocks there are, and words of one in the submission.
    capacity: usize,
    words: usize,
}

#[derive(Debug)]
struct Kernels {
    touch: Arc<Kernel>,
    /// Those of [`ENTRIES`].
    smooth: Vec<Arc<Kernel>>,
}

impl Kernels {
    fn new(device: &Device) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |module, entry, group: &[Access]| {
            let immediates = size_of::<Step>() as u32;
            device.kernel(&KernelSpec { module, entry, groups: &[group], immediates, constants: &[] })
        };
        let touching = [Read, Write, Write, Read, Write, Write, Write, Write, Read];
        let smoothing = [Read, Write, Read, Write, Write, Read, Read, Read, Read, Read, Write];
        let smooth = ENTRIES.into_iter().map(|entry| kernel("imprint_smooth", entry, &smoothing));
        Ok(Self { touch: kernel("imprint_touch", "touch", &touching)?, smooth: smooth.collect::<Result<_>>()? })
    }
}

/// What blocks of the tiles of an object need besides.
#[derive(Debug)]
pub(crate) struct WorkedTiles {
    /// Texels a side of all tiles.
    sizes: Vec<[u32; 2]>,
    on_device: Buffer<[u32; 2]>,
    /// The block of every tile, and that there is none.
    pointers: Buffer<u32>,
    none: Buffer<u32>,
}

/// An object that is bound to the blocks.
#[derive(Debug)]
pub(super) struct BoundTiles {
    touching: Bindings,
    smoothing: Bindings,
    ring: BoundRing,
}

impl WorkedTiles {
    /// For the tiles of `field`: `known`, if its tiles are of the same sizes. Fails where the device has no room.
    pub fn ready(known: Option<Self>, device: &Device, field: &Field) -> Result<Self> {
        let tiles = field.tile_count() as u32;
        let size = |tile| [0, field.size(tile)];
        if let Some(known) = known.filter(|it| it.sizes.iter().copied().eq((0..tiles).map(size))) {
            return Ok(known);
        }
        let sizes: Vec<[u32; 2]> = (0..tiles).map(size).collect();
        let on_device = Buffer::of(device, "sizes of tiles", &sizes)?;
        let pointers = Buffer::new(device, "blocks of tiles", sizes.len())?;
        let none = Buffer::of(device, "no blocks", &vec![u32::MAX; sizes.len()])?;
        Ok(Self { sizes, on_device, pointers, none })
    }

    /// Texels a side of the largest tile.
    pub fn largest(&self) -> u32 {
        self.sizes.iter().map(|[_, size]| *size).max().unwrap_or(0)
    }

    /// Their parameters for the kernels, where the largest of all objects has `largest` texels a side.
    pub fn work(&self, ring: &DeviceRing, largest: u32) -> Work {
        let words = words_of(largest);
        let (_, [rings, entries]) = ring.topology();
        let ring_parts = (4 * (self.largest() + 1)).div_ceil(GROUP);
        Work { words, parts: words_of(self.largest()).div_ceil(GROUP), ring_parts, rings, entries }
    }

    /// Records that no tile has a block.
    pub fn clear(&self, frame: &mut Frame) -> Result<()> {
        frame.copy(&self.none, 0..self.none.len(), &self.pointers, 0)
    }
}

/// Words of a block of so many texels a side.
fn words_of(size: u32) -> u32 {
    (size + 2) * (size + 2) / 2
}

impl DeviceSmoothing {
    /// Without any room. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            kernels: None,
            blocks: Buffer::new(device, "blocks of imprinted tiles", 1)?,
            marks: Buffer::new(device, "what is smoothed", 1)?,
            listed: Buffer::new(device, "imprinted tiles", 1)?,
            changed: Buffer::new(device, "blocks of an imprint", 1)?,
            stages: Buffer::new(device, "arguments of smoothing", STAGE * MAX_JOBS)?,
            counts: Buffer::of(device, "no limit", &[u32::MAX])?,
            capacity: 0,
            words: 0,
        })
    }

    /// The blocks.
    pub fn blocks(&self) -> &Buffer<u32> {
        &self.blocks
    }

    /// How many blocks there are.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Makes room for at least so many blocks, of so many words, of any of so many tiles. Returns whether the blocks are
    /// others than before. Fails where the device has no room.
    pub fn enlarge(&mut self, device: &Device, (wanted, words, tiles): (usize, usize, usize)) -> Result<bool> {
        if tiles > self.listed.len() {
            self.listed = Buffer::new(device, "imprinted tiles", tiles)?;
        }
        self.words = words;
        let wanted = wanted.max(FIRST_ROOM);
        if wanted <= self.capacity && self.capacity.saturating_mul(words) <= self.blocks.len() {
            return Ok(false);
        }
        let capacity = if wanted > self.capacity { (wanted + wanted / 4).min(MAX) } else { self.capacity };
        let all = capacity.checked_mul(words).filter(|all| wanted <= MAX && u32::try_from(2 * all).is_ok());
        let all = all.ok_or_else(|| Error::memory("imprints change too many tiles to be smoothed on a device"))?;
        self.blocks = Buffer::new(device, "blocks of imprinted tiles", all)?;
        self.marks = Buffer::new(device, "what is smoothed", 2 * all)?;
        self.capacity = capacity;
        Ok(true)
    }

    /// Records that nothing is listed.
    pub fn clear(&self, frame: &mut Frame) {
        frame.clear(&self.stages);
    }

    /// Binds an object to the blocks, as they and what imprints left are now. Fails where the device does.
    pub fn bind(
        &mut self,
        device: &Device,
        (shared, records): (&Shared, &DeviceBlocks),
        (worked, tiles, ring): (&WorkedTiles, &DeviceTiles, &DeviceRing),
    ) -> Result<BoundTiles> {
        if self.changed.len() < records.records().len() {
            self.changed = Buffer::new(device, "blocks of an imprint", records.records().len())?;
        }
        let kernels = match self.kernels.take() {
            Some(kernels) => self.kernels.insert(kernels),
            None => self.kernels.insert(Kernels::new(device)?),
        };
        let (jobs, counters, slots) = (shared.jobs.wgpu(), shared.counters.wgpu(), records.slots().wgpu());
        let (records, listed, changed) = (records.records().wgpu(), self.listed.wgpu(), self.changed.wgpu());
        let (topology, _) = ring.topology();
        let found = [listed, changed, self.stages.wgpu(), worked.pointers.wgpu(), topology.wgpu()];
        let touching = device.bind(&kernels.touch, 0, &[&[jobs, counters, slots, records][..], &found].concat())?;
        let [entries, texels] = tiles.buffers();
        let own = [jobs, slots, records, self.blocks.wgpu(), self.marks.wgpu(), listed, changed];
        let of_tiles = [worked.on_device.wgpu(), entries, texels, counters];
        let smoothing = device.bind(&kernels.smooth[0], 0, &[&own[..], &of_tiles].concat())?;
        let (pointers, blocks, sizes) = (&worked.pointers, &self.blocks, worked.on_device.wgpu());
        let blocks = WorkedBlocks { pointers, blocks, sizes, room: self.words as u32 };
        let ring = ring.bind(device, tiles, (listed, self.counts.wgpu()), Some(blocks))?;
        Ok(BoundTiles { touching, smoothing, ring })
    }

    /// Records that what imprint `job` changed is in blocks of `bound`, with rings, and is smoothed in so many passes.
    pub fn smooth(
        &self,
        pass: &mut Pass<'_>,
        (bound, ring): (&BoundTiles, &DeviceRing),
        job: usize,
        passes: u32,
    ) -> Result<()> {
        let kernels = self.kernels.as_ref().ok_or_else(|| Error::internal("nothing is bound to be smoothed"))?;
        let jobs = step(job..job + 1);
        let jobs = bytemuck::bytes_of(&jobs);
        let at = |what: usize| STAGE * job + what;
        let run = |pass: &mut Pass<'_>, kernel: usize, what: usize| {
            pass.run_indirect(&kernels.smooth[kernel], &[&bound.smoothing], jobs, &self.stages, at(what))
        };
        let update =
            |pass: &mut Pass<'_>| ring.update_indirect(pass, &bound.ring, f16::ZERO, (&self.stages, at(RINGS)));
        let count = groups((self.changed.len() as u32).div_ceil(GROUP));
        pass.run(&kernels.touch, &[&bound.touching], jobs, count)?;
        run(pass, 0, PARTS)?;
        run(pass, 1, RECORDS)?;
        update(pass)?;
        for _ in 0..passes {
            run(pass, 2, PARTS)?;
            run(pass, 3, PARTS)?;
            update(pass)?;
        }
        run(pass, 4, TILES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_made_anew_for_more_or_larger_ones() {
        let Some(device) = relievo_testing::device() else { return };
        let mut smoothing = DeviceSmoothing::new(&device).unwrap();
        assert!(smoothing.enlarge(&device, (10, 8, 4)).unwrap());
        assert!(!smoothing.enlarge(&device, (10, 8, 4)).unwrap());
        assert!(smoothing.enlarge(&device, (10, 64, 4)).unwrap());
        assert!(smoothing.blocks().len() >= 64 * smoothing.capacity());
        let more = smoothing.capacity() + 1;
        assert!(smoothing.enlarge(&device, (more, 1, 4)).unwrap());
        assert!(smoothing.capacity() >= more);
    }
}
