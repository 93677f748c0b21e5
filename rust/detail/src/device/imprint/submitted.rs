//! What comes back of a submission of imprints: counters, the records of blocks that changed, and the volumes that moved there.

use relievo_core::stats::Stage;
use relievo_core::{Context, Result};
use relievo_gpu::wgsl::imprint_link::JobCounters;
use relievo_gpu::{Buffer, Device, Frame};

use super::blocks::Record;
use super::rim::{RimRoom, RimStages};
use super::shared::{Shared, parse};

/// Records that there is room for at first, and that are read back.
pub(super) const FIRST_ROOM: usize = 512;

/// What came back of a submission.
pub(super) struct Submitted {
    /// Records, whether or not there was room for them.
    pub kept: usize,
    /// Tiles or triangles that were worked on.
    pub taken: usize,
    /// The counters of every imprint.
    pub counters: Vec<JobCounters>,
    /// The records that there was room for, and their volumes where something rises.
    pub records: Vec<Record>,
    pub moved: Vec<[f32; 2]>,
    /// The room that rims need.
    pub rim_room: Option<RimRoom>,
}

impl Submitted {
    /// Returns the records to be expected of the next submission.
    pub fn likely(&self) -> usize {
        (self.kept + self.kept / 4).max(FIRST_ROOM)
    }
}

/// Where a submission leaves what is read back.
#[derive(Clone, Copy)]
pub(super) struct Results<'a> {
    pub shared: &'a Shared,
    pub records: &'a Buffer<Record>,
    /// Rims, where something rises.
    pub rims: Option<&'a RimStages>,
    /// Imprints that are made.
    pub jobs: usize,
}

impl Results<'_> {
    /// Submits `frame` and reads back what it leaves: at first `likely` records, and then the rest. `time` ends when
    /// everything is submitted.
    ///
    /// Fails if the device does, or as [`RimStages::needed`].
    pub fn submit(
        self,
        context: &Context,
        device: &Device,
        mut frame: Frame,
        likely: usize,
        time: Stage<'_>,
    ) -> Result<Submitted> {
        let Self { shared, records: room, rims, jobs } = self;
        let counters = shared.read_counters(&mut frame, jobs)?;
        let first = likely.min(room.len());
        let volumes = |frame: &mut _, range| rims.map(|rims| rims.read_volumes(frame, range)).transpose();
        let (first_records, first_moved) = (frame.read(room, 0..first)?, volumes(&mut frame, 0..first)?);
        let read_rims = rims.map(|rims| rims.read(&mut frame, jobs)).transpose()?;
        let submission = frame.submit()?;
        time.end();
        let ([kept, taken], counters) = parse(&counters.get(device)?);
        let mut records = first_records.get(device)?;
        for time in submission.wait()? {
            context.stats().add(time.name, time.length);
        }
        let there = kept.min(room.len());
        records.truncate(there);
        let mut moved = first_moved.map_or(Ok(Vec::new()), |it| it.get(device))?;
        moved.truncate(there);
        if there > first {
            let mut frame = device.frame()?;
            let rest = frame.read(room, first..there)?;
            let rest_moved = volumes(&mut frame, first..there)?;
            let _ = frame.submit()?;
            records.extend(rest.get(device)?);
            moved.extend(rest_moved.map_or(Ok(Vec::new()), |it| it.get(device))?);
        }
        let rim_room = read_rims.zip(rims).map(|(read, rims)| rims.needed(context, device, read)).transpose()?;
        Ok(Submitted { kept, taken, counters, records, moved, rim_room })
    }
}
