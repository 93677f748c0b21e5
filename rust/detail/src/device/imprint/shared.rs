//! What the stages of the imprints of a submission share on a device, and what they tell of each.

use std::ops::Range;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::{Step, Told};
use relievo_gpu::{Buffer, Device, Frame, Readback};

use super::link::{MAX_LINKS, Words};

/// Fails if the voxels are not those of the collider.
pub(super) fn check(told: &Told) -> Result<()> {
    if told.faults & 1 != 0 {
        return Err(Error::unsupported(
            "the collider reaches too far beyond the overlap to be voxelised on a graphics device",
        )
        .advise("cut the collider down, make the objects that collide closer in size, or use the device `cpu`"));
    }
    if told.faults & 2 != 0 {
        return Err(Error::unsupported("the collider covers the voxel grid too many times for a graphics device")
            .advise("use fewer voxels or a coarser collider, or the device `cpu`"));
    }
    Ok(())
}

/// Words of the counters before those of the first imprint.
const FIRST: usize = 4;
const TOLD: usize = size_of::<Told>() / 4;

/// Words of an imprint's arguments: those of chunks of columns, and those of its blocks.
const ARGUMENTS: usize = 8;
const CANDIDATES: usize = 4;

/// What the stages of a submission share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub links: Buffer<Words>,
    pub told: Buffer<u32>,
    pub arguments: Buffer<u32>,
    /// Of every imprint the box of the collider's points along the axes of the overlap, as `imprint_box.wgsl` has it.
    pub boxes: Buffer<[u32; 6]>,
    /// Of every imprint how many tiles were listed for it and those of its row, and the arguments of what takes them.
    pub candidates: Buffer<u32>,
}

impl Shared {
    /// Room for as many imprints as there may be. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            links: Buffer::new(device, "imprints", MAX_LINKS)?,
            told: Buffer::new(device, "what is told of imprints", FIRST + TOLD * MAX_LINKS)?,
            arguments: Buffer::new(device, "arguments of imprints", ARGUMENTS * MAX_LINKS)?,
            boxes: Buffer::new(device, "boxes of colliders", MAX_LINKS)?,
            candidates: Buffer::new(device, "tiles of imprints", CANDIDATES * MAX_LINKS)?,
        })
    }

    /// Tells of the imprints of a submission, and records that nothing was told of them so far. What is listed for them is
    /// nothing once they are voxelised.
    pub fn begin(&self, device: &Device, frame: &mut Frame, words: &[Words]) -> Result<()> {
        frame.clear(&self.told);
        frame.clear(&self.boxes);
        self.links.write(device, 0, words)
    }

    /// Records that nothing is listed for any imprint, where nothing is voxelised.
    pub fn begin_lists(&self, frame: &mut Frame) {
        frame.clear(&self.arguments);
        frame.clear(&self.candidates);
    }

    /// Where the arguments of the dispatch over chunks of columns are, of the imprints that are voxelised with `link`,
    /// the first of them, and of those over the blocks and over the tiles of the row that begins with `link`.
    pub fn chunks(link: usize) -> usize {
        ARGUMENTS * link + 1
    }

    pub fn blocks(link: usize) -> usize {
        ARGUMENTS * link + 5
    }

    pub fn tiles(link: usize) -> usize {
        CANDIDATES * link + 1
    }

    /// Records the way back of the counters of so many imprints.
    pub fn read_told(&self, frame: &mut Frame, links: usize) -> Result<Readback<u32>> {
        frame.read(&self.told, 0..FIRST + TOLD * links)
    }
}

/// The immediate data of a dispatch over `links`.
pub(super) fn step(links: Range<usize>) -> Step {
    Step { link: links.start as u32, count: links.len() as u32 }
}

/// How many blocks changed in all imprints and how many tiles were worked on, and the counters of each imprint, from
/// the words of [`Shared::read_told`].
pub(super) fn parse(words: &[u32]) -> ([usize; 2], Vec<Told>) {
    let (first, each) = words.split_at(FIRST.min(words.len()));
    let count = |at: usize| first.get(at).map_or(0, |count| *count as usize);
    ([count(0), count(1)], bytemuck::cast_slice(each).to_vec())
}
