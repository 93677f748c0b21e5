//! What dabs do to the channels of an object on a graphics device: heights, vectors and colours, each with a brush of its
//! own.

use glam::{DAffine3, Vec4};
use half::f16;
use relievo_core::{Context, Result};
use relievo_gpu::wgsl::brush_edit::Edit;
use relievo_tiles::{Channel, ColorPlanes, DeviceTiles, Field, Rgba8, Rgba16, Vector};

use super::brush::{DeviceBrush, DeviceGround, Event, Stage};
use super::colors::DeviceColors;
use super::events::{DeviceTile, edit_by, leave};
use super::smear::PICTURES;
use crate::device::state::{DeviceObject, bring};
use crate::object::DisplacedObject;
use crate::paint::dab::{Action, Dab, no_vectors};
use crate::paint::ground::Ground;
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::smudge::Smudge;
use crate::paint::vector::BrushMaps;
use crate::paint::weights::BrushParameters;

/// A colour that a device has room for.
pub(crate) trait DeviceColor: ColorPlanes + DeviceTile {
    fn slot(object: &mut DeviceObject) -> &mut Option<DeviceColors<Self>>;
}

impl DeviceColor for Rgba8 {
    fn slot(object: &mut DeviceObject) -> &mut Option<DeviceColors<Self>> {
        &mut object.painting
    }
}

impl DeviceColor for Rgba16 {
    fn slot(object: &mut DeviceObject) -> &mut Option<DeviceColors<Self>> {
        &mut object.half_painting
    }
}

impl DeviceObject {
    /// Sculpts with the first of `dabs`, or the first few at once. `None` if they reach more tiles than the device can
    /// have blocks for.
    pub(super) fn sculpt(
        &mut self,
        object: &DisplacedObject,
        dabs: &[Dab],
        start: Option<Ground<'_>>,
        mode: SculptMode,
    ) -> Result<Option<Event<f16>>> {
        self.follow_ground(object, start)?;
        let (known, channel) = (self.sculpting.take(), object.displacement());
        let Self { device, surface, tiles, ring, .. } = &*self;
        let ground = self.ground(object, start);
        let mut brush = DeviceBrush::ready(known, device, (surface, ground.0), channel.field())?;
        let edits = edits_of(&object.transform, dabs, Vec4::ZERO);
        // A dab that is by itself goes by its own displacement.
        let (together, looks_beside) = (start.is_some(), mode.needs_mean());
        let stamp = dabs.first().and_then(|dab| dab.brush.stamp());
        let field = channel.field();
        let stage =
            Stage { device, surface, ground, tiles, field, channel, ring, looks_beside, smudges: &[], maps: &[] };
        let made = brush.event(stage, (&edits, stamp), together)?;
        self.sculpting = Some(brush);
        Ok(made)
    }

    /// Changes vectors with the first of `dabs`, or the first few at once, or with one at a level, whose vectors are
    /// `coarse`, and were `before` when a stroke began. `None` as [`Self::sculpt`].
    pub(crate) fn bend(
        &mut self,
        context: &Context,
        object: &DisplacedObject,
        dabs: &[Dab],
        start: Option<Ground<'_>>,
        (coarse, before): (Option<&Field<Vector>>, Option<&Field<Vector>>),
        mode: SculptMode,
    ) -> Result<Option<Event<Vector>>> {
        self.follow_ground(object, start)?;
        let known = self.bending.take();
        let [mut now, mut then] = std::mem::take(&mut self.coarse_vectors);
        let channel = object.vectors.as_ref().ok_or_else(no_vectors)?;
        let (together, looks_beside) = (start.is_some() && coarse.is_none(), mode.needs_mean());
        if together && looks_beside {
            self.follow_frames(context, channel.field(), 0..channel.field().tile_count() as u32)?;
        }
        let Self { device, surface, ring, turning, .. } = &*self;
        let ring = turning.as_ref().unwrap_or(ring);
        let mut ground = self.ground(object, start);
        let (tiles, field) = match coarse {
            Some(coarse) => (bring(&mut now, device, coarse)?, coarse),
            None => (self.vectors.as_ref().ok_or_else(no_vectors)?, channel.field()),
        };
        if let Some(before) = before {
            ground = (
                DeviceGround { vectors: Some(bring(&mut then, device, before)?), ..ground.0 },
                Ground { vectors: Some(before), ..ground.1 },
            );
        } else if coarse.is_some() || ground.0.vectors.is_none() {
            ground = (DeviceGround { vectors: Some(tiles), ..ground.0 }, Ground { vectors: Some(field), ..ground.1 });
        }
        let mut brush = DeviceBrush::ready(known, device, (surface, ground.0), field)?;
        let edits = edits_of(&object.transform, dabs, Vec4::ZERO);
        let maps: Vec<_> = dabs.iter().map(|dab| BrushMaps::new(&dab.brush, &object.transform)).collect();
        let stamp = dabs.first().and_then(|dab| dab.brush.stamp());
        let stage =
            Stage { device, surface, ground, tiles, field, channel, ring, looks_beside, smudges: &[], maps: &maps };
        let made = brush.event(stage, (&edits, stamp), together)?;
        self.bending = Some(brush);
        self.coarse_vectors = [now, then];
        Ok(made)
    }

    /// Sculpts with a dab at a level, whose displacement is `coarse`, and was `before` when a stroke began. `None` as
    /// [`Self::sculpt`].
    pub(super) fn sculpt_at(
        &mut self,
        object: &DisplacedObject,
        dab: &Dab,
        start: Option<Ground<'_>>,
        (coarse, before): (&Field, Option<&Field>),
        mode: SculptMode,
    ) -> Result<Option<Event<f16>>> {
        self.follow_vectors(object, start)?;
        let known = self.sculpting.take();
        let [mut now, mut then] = std::mem::take(&mut self.coarse);
        let Self { device, surface, ring, .. } = &*self;
        let tiles = bring(&mut now, device, coarse)?;
        let (heights, field) = match before {
            Some(before) => (bring(&mut then, device, before)?, before),
            None => (tiles, coarse),
        };
        let (there, here) = self.ground(object, start);
        let ground = (DeviceGround { heights, ..there }, Ground { heights: field, ..here });
        let mut brush = DeviceBrush::ready(known, device, (surface, ground.0), coarse)?;
        let edits = edits_of(&object.transform, std::slice::from_ref(dab), Vec4::ZERO);
        let (channel, looks_beside) = (object.displacement(), mode.needs_mean());
        let stage = Stage {
            device,
            surface,
            ground,
            tiles,
            field: coarse,
            channel,
            ring,
            looks_beside,
            smudges: &[],
            maps: &[],
        };
        let made = brush.event(stage, (&edits, dab.brush.stamp()), false)?;
        self.sculpting = Some(brush);
        self.coarse = [now, then];
        Ok(made)
    }

    /// Paints with the first of `dabs`, or the first few at once, on a channel or on what it is at a coarser level. `None`
    /// as [`Self::sculpt`].
    pub(crate) fn paint<T: DeviceColor>(
        &mut self,
        object: &DisplacedObject,
        (channel, coarse): (&Channel<T>, Option<&Field<T>>),
        dabs: &[Dab],
        start: Option<Ground<'_>>,
        mode: PaintMode,
    ) -> Result<Option<Event<T>>> {
        self.follow_ground(object, start)?;
        let mut colors = match T::slot(self).take() {
            Some(colors) => colors,
            None => DeviceColors { tiles: DeviceTiles::new(&self.device, channel.field())?, coarse: None, brush: None },
        };
        let (tiles, field) = match coarse {
            Some(coarse) => (bring(&mut colors.coarse, &self.device, coarse)?, coarse),
            None => {
                colors.tiles.update(&self.device, channel.field())?;
                (&colors.tiles, channel.field())
            }
        };
        let mut edits = edits_of(&object.transform, dabs, channel.field().blank().color());
        let Self { device, surface, ring, .. } = &*self;
        let ground = self.ground(object, start);
        let known = colors.brush.take();
        let maker = colors.brush.insert(DeviceBrush::ready(known, device, (surface, ground.0), channel.field())?);
        let stamp = dabs.first().and_then(|dab| dab.brush.stamp());
        let (smudges, together) = smudges_of(dabs, &mut edits);
        let (looks_beside, smudges) = (mode.needs_mean(), &smudges[..]);
        let stage = Stage { device, surface, ground, tiles, field, channel, ring, looks_beside, smudges, maps: &[] };
        let made = maker.event(stage, (&edits, stamp), together)?;
        *T::slot(self) = Some(colors);
        Ok(made)
    }
}

/// What brushes of `dabs` carry, if they smear, and which of the device's pictures that is: dabs that leave what an
/// earlier one picks up have its own. Also whether they may be made at once. `edits` get their pictures.
pub(crate) fn smudges_of<'a>(
    dabs: &'a [Dab],
    edits: &mut [(BrushParameters, Edit)],
) -> (Vec<(&'a Smudge, usize)>, bool) {
    let mut smudges: Vec<(&Smudge, usize)> = Vec::new();
    // The last of each picture.
    let mut last: Vec<&Smudge> = Vec::new();
    for (smudge, (_, edit)) in dabs.iter().filter_map(|dab| dab.brush.smudge()).zip(edits) {
        let picture = last.iter().position(|before| smudge.follows(before)).unwrap_or(last.len());
        if picture == PICTURES {
            return (smudges, false);
        }
        match last.get_mut(picture) {
            Some(before) => *before = smudge,
            None => last.push(smudge),
        }
        leave(edit, picture);
        smudges.push((smudge, picture));
    }
    let together = smudges.is_empty() || smudges.len() == dabs.len();
    (smudges, together)
}

/// What dabs do to texels of an object with this transform to the world, of which those without a block read as `blank`.
pub(crate) fn edits_of(transform: &DAffine3, dabs: &[Dab], blank: Vec4) -> Vec<(BrushParameters, Edit)> {
    let edit = |dab: &Dab| {
        let brush = BrushParameters::new(&dab.brush, dab.strength, transform);
        let mut edit = edit_by(&brush, dab.brush.stamp());
        edit.blank = blank.to_array();
        match dab.action {
            Action::Sculpt { mode, height } => (edit.mode, edit.height) = (mode as u32, height),
            Action::Paint { mode, color } => (edit.mode, edit.color) = (mode as u32, color),
        }
        (brush, edit)
    };
    dabs.iter().map(edit).collect()
}
