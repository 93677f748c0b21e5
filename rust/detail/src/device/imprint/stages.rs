//! The stages of the imprints of a submission, in the order in which they are recorded.

use relievo_core::{Error, Result};
use relievo_gpu::{Device, Frame, Pass};
use relievo_tiles::{DeviceTiles, Field};

use super::batches::Batch;
use super::blocks::DeviceBlocks;
use super::ground::BoundGround;
use super::job::ImprintJob;
use super::rim::DeviceRims;
use super::shared::Shared;
use super::smoothing::{BoundTiles, DeviceSmoothing};
use super::voxel::DeviceVoxels;
use crate::device::state::DeviceObject;
use crate::object::DisplacedObject;

/// An object that is imprinted on.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub state: &'a mut DeviceObject,
    pub object: &'a DisplacedObject,
    /// The displacement from which the depth limits count, if it is not what it is now.
    pub start: Option<&'a Field>,
}

impl Target<'_> {
    /// The displacement on the device from which the depth limits count, if it is not what it is now.
    pub(crate) fn begun(&self) -> Option<&DeviceTiles> {
        self.start.and_then(|_| self.state.begun())
    }
}

/// A stage of an imprint or, where it does not depend on others, of several.
#[derive(Clone, Copy, Debug)]
enum Stage<'a> {
    /// What is found of a target first.
    Measure(usize),
    Voxelise(&'a Batch),
    /// Of the row of imprints of one object that begins with this one.
    Cull(usize),
    Raycast(usize),
    /// What an imprint changed, for later imprints.
    Smooth(usize),
    /// What is around an imprint before it is made, and what rises there afterwards.
    Gather(usize),
    Raise(usize),
}

impl Stage<'_> {
    /// The name of its pass, where passes are timed.
    fn name(self) -> &'static str {
        match self {
            Self::Measure(_) | Self::Cull(_) => "imprint.device.cull",
            Self::Voxelise(_) => "imprint.device.voxelise",
            Self::Raycast(_) => "imprint.device.raycast",
            Self::Smooth(_) => "imprint.device.smooth",
            Self::Gather(_) | Self::Raise(_) => "imprint.device.rim",
        }
    }
}

/// What the stages of a submission are recorded from.
#[derive(Debug)]
pub(super) struct Stages<'a> {
    pub shared: &'a Shared,
    pub voxels: &'a DeviceVoxels,
    pub blocks: &'a DeviceBlocks,
    /// If something rises.
    pub rims: Option<&'a DeviceRims>,
    pub smoothing: &'a DeviceSmoothing,
    pub targets: &'a [Target<'a>],
    pub jobs: &'a [ImprintJob],
    /// Of every target what it is displaced by, and its tiles if they are worked on.
    pub grounds: &'a [BoundGround],
    pub bound: &'a [Option<BoundTiles>],
}

impl<'a> Stages<'a> {
    /// Records those of imprints that are taken together as `batches` say.
    pub fn record(&self, device: &Device, frame: &mut Frame, batches: &'a [Batch]) -> Result<()> {
        let mut in_order = self.in_order(batches);
        if device.is_timed() {
            return in_order.try_for_each(|stage| self.record_one(&mut frame.pass(stage.name()), stage));
        }
        // Every pass is a command buffer: passes that nobody times are one.
        let mut pass = frame.pass("imprint.device");
        in_order.try_for_each(|stage| self.record_one(&mut pass, stage))
    }

    /// Those of imprints that are taken together as `batches` say.
    fn in_order(&self, batches: &'a [Batch]) -> impl Iterator<Item = Stage<'a>> {
        let Self { targets, jobs, bound, .. } = *self;
        let each = move |job: usize| {
            let ImprintJob { target, rising, .. } = jobs[job];
            let goes_on = bound[target].is_some() && jobs[job + 1..].iter().any(|job| job.target == target);
            let before = rising.map(|_| Stage::Gather(job)).into_iter();
            let after = rising.map(|_| Stage::Raise(job));
            let smoothed = goes_on.then_some(Stage::Smooth(job));
            before.chain([Stage::Cull(job), Stage::Raycast(job)]).chain(after).chain(smoothed)
        };
        let of_batch = move |batch: &'a Batch| {
            std::iter::once(Stage::Voxelise(batch)).chain(batch.rows.iter().copied().flat_map(each))
        };
        (0..targets.len()).map(Stage::Measure).chain(batches.iter().flat_map(of_batch))
    }

    /// Records a stage.
    fn record_one(&self, pass: &mut Pass<'_>, stage: Stage<'_>) -> Result<()> {
        let Self { shared, voxels, blocks, rims, smoothing, targets, jobs, grounds, bound } = *self;
        let no_rims = || Error::internal("no room for rims");
        match stage {
            Stage::Measure(target) => {
                let state = &*targets[target].state;
                state.culling()?.measure(pass, &state.surface, &state.tiles)
            }
            Stage::Voxelise(batch) => voxels.fill(pass, shared, batch),
            Stage::Cull(job) => {
                let state = &*targets[jobs[job].target].state;
                state.culling()?.cull(pass, shared, blocks.listing(), &state.surface, job)
            }
            Stage::Raycast(job) => {
                let ImprintJob { target: index, .. } = jobs[job];
                let target = &targets[index];
                let fields = (&grounds[index], target.begun().unwrap_or(&target.state.tiles));
                blocks.cast(pass, shared, &target.state.surface, fields, job)
            }
            Stage::Smooth(job) => {
                let ImprintJob { target, smoothing: (_, passes), .. } = jobs[job];
                let bound = bound[target].as_ref().ok_or_else(|| Error::internal("tiles without room for blocks"))?;
                smoothing.smooth(pass, (bound, &targets[target].state.ring), job, passes)
            }
            Stage::Gather(job) => {
                let ImprintJob { target, .. } = jobs[job];
                let state = &*targets[target].state;
                rims.ok_or_else(no_rims)?.gather(pass, state.culling()?, (&state.surface, &grounds[target]), job)
            }
            Stage::Raise(job) => {
                let state = &*targets[jobs[job].target].state;
                rims.ok_or_else(no_rims)?.raise(pass, (&state.surface, &state.tiles), job)
            }
        }
    }
}
