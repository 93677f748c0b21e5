//! Dabs at half or a quarter of the texels: a rough shape over fine detail, which stays.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.1. The
//! brush is evaluated at the texels of the level, and [`Channel::put_at`] carries what it changed to the tiles. Units:
//! object units for displacement.

use relievo_core::{Context, Result};
use relievo_tiles::{Channel, by_format};

use crate::channels::frame::Vectors;
use crate::channels::knots::PerKnot;
use crate::channels::layered::LayeredObject;
use crate::channels::window::Window;
use crate::device::DeviceColor;
use crate::imprint::culled::{self, CulledTile};
use crate::object::DisplacedObject;
use crate::paint::dab::{Action, Dab};
use crate::paint::edit;
use crate::paint::ground::Ground;
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::report::DabReport;
use crate::paint::spot::{Painting, Sculpting, everywhere};
use crate::paint::weights::BrushParameters;

impl DisplacedObject {
    /// Refits boxes after a dab that looked at `culled`; after one at a coarser level, whose `finer` coefficients may
    /// reach further than what it made of them, notes how far they do.
    pub(crate) fn refit_after(
        &mut self,
        context: &Context,
        start: Option<Ground<'_>>,
        culled: &[CulledTile],
        report: &DabReport,
        finer: bool,
    ) {
        let field = self.displacement().field();
        let tiles = edit::stale(context, field, culled, report);
        if finer {
            let mut ranges = context.scratch().list();
            context.map_into(tiles.len(), &mut ranges, |index| field.range(tiles[index]));
            let range =
                ranges.iter().copied().fold([0.0f32; 2], |all, [low, high]| [all[0].min(low), all[1].max(high)]);
            self.widen(range);
        }
        self.refit(context, start, &tiles);
    }
}

impl Dab {
    /// As [`Self::apply`], at `level`: 0 for the texels that faces were given, 1 for half of them along an edge, 2 for
    /// a quarter. Faces without a tile get tiles of that size. An eraser takes away what the level sees, and leaves
    /// detail.
    ///
    /// # Errors
    /// Fails as [`Self::apply`]; with `Invalid` if there is no such level; and with `Memory` if tiles that are coarser
    /// than the level do not fit the budget at its size.
    pub fn apply_at(&self, context: &Context, object: &mut DisplacedObject, level: u32) -> Result<DabReport> {
        let mut report = self.make_at(context, object, None, level)?;
        report.refuse(object.settle(context)?);
        Ok(report)
    }

    /// As [`Self::make`], at a level.
    pub(crate) fn make_at(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<Ground<'_>>,
        level: u32,
    ) -> Result<DabReport> {
        if level == 0 {
            return self.make(context, object, start);
        }
        self.check()?;
        match self.action {
            Action::Paint { mode, color } => {
                let mut paint = object.take_paint()?;
                let done = by_format!(&mut paint, stack => {
                    self.paint_at(context, object, stack.active_mut(), (start, level), mode, color)
                });
                object.put_paint(paint);
                done
            }
            Action::Sculpt { mode, height } => self.sculpt(context, object, (start, level), mode, height),
        }
    }

    fn paint_at<T: DeviceColor>(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        paint: &mut Channel<T>,
        (start, level): (Option<Ground<'_>>, u32),
        mode: PaintMode,
        color: [f32; 4],
    ) -> Result<DabReport> {
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |_, tile| paint.field().size_at(tile, level));
        let mut tiles = context.scratch().list();
        tiles.extend(culled.iter().map(|culled| culled.tile));
        let coarse = paint.field().at_level(context, level, &tiles)?;
        let made = object.painted_on_device(context, self, (paint, &coarse), start);
        let edits = made.unwrap_or_else(|| {
            let blank = coarse.blank().color().to_array();
            let ground = start.unwrap_or(object.ground());
            let simd = context.level();
            let places = |window: &Window, heights: &mut PerKnot, vectors: &mut Vectors| {
                ground.at_texels(simd, window, heights, vectors)
            };
            let (stamp, smudge) = (self.brush.stamp(), self.brush.smudge());
            let painting = Painting { level: simd, mode, color: everywhere(color), blank, stamp, smudge };
            edit::evaluate(context, &object.surface, &coarse, &culled, &brush, places, |site, texels| {
                painting.edit(site, texels);
            })
        });
        let report = edit::write_at(context, paint, Some(&coarse), &culled, edits, mode == PaintMode::Erase)?;
        culled::give_back(context, culled);
        Ok(report)
    }

    /// Changes the displacement along the normals, at a level.
    pub(crate) fn raise_at(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        (start, level): (Option<Ground<'_>>, u32),
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        object.layers.displacement.check_editable()?;
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let size = |object: &DisplacedObject, tile: u32| object.displacement().field().size_at(tile, level);
        let culled = self.intersect(context, object, start, size);
        let mut tiles = context.scratch().list();
        tiles.extend(culled.iter().map(|culled| culled.tile));
        let coarse = object.displacement().field().at_level(context, level, &tiles)?;
        let before = start.map(|start| start.heights.at_level(context, level, &tiles)).transpose()?;
        let edits = match object.raised_on_device(context, self, start, (&coarse, before.as_ref())) {
            Some(edits) => edits,
            None => {
                let simd = context.level();
                let vectors = start.unwrap_or(object.ground()).vectors;
                let ground = Ground { heights: before.as_ref().unwrap_or(&coarse), vectors };
                let places = |window: &Window, heights: &mut PerKnot, vectors: &mut Vectors| {
                    ground.at_coefficients(simd, window, heights, vectors)
                };
                let (stamp, since) = (self.brush.stamp(), start.is_some());
                let sculpting = Sculpting { level: simd, mode, height, stamp, since };
                let displaced = ground.displaced(&object.surface)?;
                edit::evaluate(context, &object.surface, &coarse, &culled, &brush, places, |site, texels| {
                    sculpting.edit(site, |site, cosines| site.facing(context, &displaced, cosines), texels);
                })
            }
        };
        let erase = mode == SculptMode::Erase;
        let report =
            edit::write_at(context, object.layers.displacement.composite_mut(), Some(&coarse), &culled, edits, erase)?;
        object.refit_after(context, start, &culled, &report, true);
        culled::give_back(context, culled);
        Ok(report)
    }
}
