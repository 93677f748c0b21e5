//! What the stages of the imprints of a submission share on a device, and what they tell of each.

use std::ops::Range;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::{JobCounters, Step};
use relievo_gpu::{Buffer, Device, Frame, Readback};

use super::job::{JobParams, MAX_JOBS};

/// Fails if the voxels are not those of the collider.
pub(super) fn check(counters: &JobCounters) -> Result<()> {
    if counters.faults & 1 != 0 {
        return Err(Error::unsupported(
            "the collider reaches too far beyond the overlap to be voxelised on a graphics device",
        )
        .advise("cut the collider down, make the objects that collide closer in size, or use the device `cpu`"));
    }
    if counters.faults & 2 != 0 {
        return Err(Error::unsupported("the collider covers the voxel grid too many times for a graphics device")
            .advise("use fewer voxels or a coarser collider, or the device `cpu`"));
    }
    Ok(())
}

/// Words of the counters before those of the first imprint.
const FIRST: usize = 4;
const TOLD: usize = size_of::<JobCounters>() / 4;

/// Words of an imprint's arguments: those of chunks of columns, and those of its blocks.
const ARGUMENTS: usize = 8;
const CANDIDATES: usize = 4;

/// What the stages of a submission share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub jobs: Buffer<JobParams>,
    pub counters: Buffer<u32>,
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
            jobs: Buffer::new(device, "imprints", MAX_JOBS)?,
            counters: Buffer::new(device, "what is counters of imprints", FIRST + TOLD * MAX_JOBS)?,
            arguments: Buffer::new(device, "arguments of imprints", ARGUMENTS * MAX_JOBS)?,
            boxes: Buffer::new(device, "boxes of colliders", MAX_JOBS)?,
            candidates: Buffer::new(device, "tiles of imprints", CANDIDATES * MAX_JOBS)?,
        })
    }

    /// Tells of the imprints of a submission, and records that nothing was told of them so far. What is listed for them is
    /// nothing once they are voxelised.
    pub fn begin(&self, device: &Device, frame: &mut Frame, words: &[JobParams]) -> Result<()> {
        frame.clear(&self.counters);
        frame.clear(&self.boxes);
        self.jobs.write(device, 0, words)
    }

    /// Records that nothing is listed for any imprint, where nothing is voxelised.
    pub fn begin_lists(&self, frame: &mut Frame) {
        frame.clear(&self.arguments);
        frame.clear(&self.candidates);
    }

    /// Where the arguments of the dispatch over chunks of columns are, of the imprints that are voxelised with `job`,
    /// the first of them, and of those over the blocks and over the tiles of the row that begins with `job`.
    pub fn chunks(job: usize) -> usize {
        ARGUMENTS * job + 1
    }

    pub fn blocks(job: usize) -> usize {
        ARGUMENTS * job + 5
    }

    pub fn tiles(job: usize) -> usize {
        CANDIDATES * job + 1
    }

    /// Records the way back of the counters of so many imprints.
    pub fn read_counters(&self, frame: &mut Frame, jobs: usize) -> Result<Readback<u32>> {
        frame.read(&self.counters, 0..FIRST + TOLD * jobs)
    }
}

/// The immediate data of a dispatch over `jobs`.
pub(super) fn step(jobs: Range<usize>) -> Step {
    Step { link: jobs.start as u32, count: jobs.len() as u32 }
}

/// How many blocks changed in all imprints and how many tiles were worked on, and the counters of each imprint, from
/// the words of [`Shared::read_told`].
pub(super) fn parse(words: &[u32]) -> ([usize; 2], Vec<JobCounters>) {
    let (first, each) = words.split_at(FIRST.min(words.len()));
    let count = |at: usize| first.get(at).map_or(0, |count| *count as usize);
    ([count(0), count(1)], bytemuck::cast_slice(each).to_vec())
}
