//! The copies that a device has of an object's displacement, vectors and colours, after an event of dabs that was made on
//! it: blocks that the processor kept are taken from the event, and rings are made there, so that nothing is sent.

use relievo_core::{Context, Result};
use relievo_tiles::{Field, Vector};

use super::channels::DeviceColor;
use crate::device::state::DeviceObject;
use crate::paint::report::DabReport;

/// Those of the tiles whose blocks are on the device that the budget did not refuse.
pub(crate) fn kept(firsts: &[(u32, u32)], report: &DabReport) -> Vec<(u32, u32)> {
    firsts.iter().copied().filter(|(tile, _)| report.changed.binary_search(tile).is_ok()).collect()
}

impl DeviceObject {
    /// Makes the device have `field`, the displacement after the last event, whose blocks are where `written` says.
    pub(super) fn follow_sculpted(&mut self, field: &Field, written: &[(u32, u32)]) -> Result<Option<()>> {
        let Self { device, tiles, ring, sculpting, .. } = self;
        let Some(brush) = sculpting else { return Ok(None) };
        tiles.follow(device, ring, field, (written, brush.blocks()))?;
        Ok(Some(()))
    }

    /// As [`Self::follow_sculpted`], of vectors.
    pub(super) fn follow_bent(
        &mut self,
        context: &Context,
        field: &Field<Vector>,
        written: &[(u32, u32)],
    ) -> Result<Option<()>> {
        let Some(tiles) = &self.vectors else { return Ok(None) };
        self.follow_frames(context, field, field.differing(tiles.field()))?;
        let Self { device, vectors: Some(tiles), turning: Some(ring), bending: Some(brush), .. } = self else {
            return Ok(None);
        };
        tiles.follow(device, ring, field, (written, brush.blocks()))?;
        Ok(Some(()))
    }

    /// As [`Self::follow_sculpted`], of colours.
    pub(super) fn follow_painted<T: DeviceColor>(
        &mut self,
        field: &Field<T>,
        written: &[(u32, u32)],
    ) -> Result<Option<()>> {
        let Some(mut colors) = T::slot(self).take() else { return Ok(None) };
        let Some(brush) = &colors.brush else { return Ok(None) };
        colors.tiles.follow(&self.device, &self.ring, field, (written, brush.blocks()))?;
        *T::slot(self) = Some(colors);
        Ok(Some(()))
    }
}
