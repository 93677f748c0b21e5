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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::imprint::cull::tests::object;
    use crate::{Action, Falloff, SculptMode, Stroke, StrokePoint, StrokeSettings};
    use glam::DVec3;
    use relievo_testing::device;
    use relievo_tiles::{ChannelOptions, DeviceTiles, Texel, VectorDisplacement};

    /// Compares what the device has with the field, numbers up to one step of a half float.
    fn compare<T: Texel>(tiles: &DeviceTiles<T>, field: &Field<T>, device: &relievo_gpu::Device) -> usize {
        assert!(field.differing(tiles.field()).is_empty());
        let mut apart = 0;
        for (tile, there) in tiles.read_back(device).unwrap() {
            let halves = |texels: &[T]| bytemuck::cast_slice::<T, half::f16>(texels).to_vec();
            for (a, b) in halves(field.block(tile).unwrap()).into_iter().zip(halves(&there)) {
                apart += usize::from(a != b);
                assert!((a.to_f32() - b.to_f32()).abs() <= 2e-3 * a.to_f32().abs() + 1e-6, "tile {tile}: {a} {b}");
            }
        }
        apart
    }

    #[test]
    fn vectors_on_the_device_are_what_dabs_made_of_them() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let mut object = object(&context);
        let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
        object.set_vectors(VectorDisplacement::on(object.surface(), &options).unwrap()).unwrap();
        object.use_device(Some(&device)).unwrap();
        let points = [[3.2, 3.4], [4.1, 3.9], [4.6, 4.9]]
            .map(|[x, y]| StrokePoint::new(object.transform().transform_point3(DVec3::new(x, y, 0.0)), 1.0));
        let settings = StrokeSettings { radius: 0.9, spacing: 0.4, ..StrokeSettings::default() };
        for (mode, height) in [(SculptMode::Pinch, 0.6), (SculptMode::Smooth, 0.0)] {
            let action = Action::Sculpt { mode, height };
            Stroke::new(points.to_vec(), settings, Falloff::Smooth, action).apply(&context, &mut object).unwrap();
            assert!(object.take_device_fault().is_none());
            let (state, field) = (object.device.as_ref().unwrap(), object.vectors().unwrap().field());
            let made = field.allocated().count();
            let apart = compare(state.vectors.as_ref().unwrap(), field, &device);
            assert!(made > 8 && apart * 1000 < made * 34 * 34, "{mode:?}: {apart} numbers of {made} tiles");
            compare(&state.tiles, object.displacement().field(), &device);
        }
    }
}
