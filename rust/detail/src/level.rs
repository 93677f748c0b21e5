//! Dabs at half or a quarter of the texels: a rough shape over fine detail, which stays.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.1. The
//! brush is evaluated at the texels of the level, and [`Channel::put_at`] carries what it changed to the tiles. Units:
//! object units for displacement.

use relievo_core::{Context, Result};
use relievo_tiles::{Channel, ColorPlanes, Displaced};

use crate::dab::{Action, Dab, DabReport};
use crate::edit::{self, Window};
use crate::knots::PerKnot;
use crate::layered::LayeredObject;
use crate::mode::{PaintMode, SculptMode};
use crate::object::DisplacedObject;
use crate::spot::{Painting, Sculpting, everywhere};
use crate::weights::BrushParameters;

impl Dab {
    /// As [`Self::apply`], at `level`: 0 for the texels that faces were given, 1 for half of them along an edge, 2 for a
    /// quarter. Faces without a tile get tiles of that size. An eraser takes away what the level sees, and leaves detail.
    ///
    /// Fails, and changes nothing, as [`Self::apply`] does, or if there is no such level.
    pub fn apply_at(&self, context: &Context, object: &mut DisplacedObject, level: u32) -> Result<DabReport> {
        if level == 0 {
            return self.apply(context, object);
        }
        self.check()?;
        let mut report = match self.action {
            Action::Paint { mode, color } => {
                let mut paint = object.take_paint()?;
                let done = self.paint_at(context, object, &mut paint, level, mode, color);
                object.put_paint(paint);
                done?
            }
            Action::Sculpt { mode, height } => self.sculpt_at(context, object, level, mode, height)?,
        };
        report.refuse(object.settle(context)?);
        Ok(report)
    }

    fn paint_at<T: ColorPlanes>(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        paint: &mut Channel<T>,
        level: u32,
        mode: PaintMode,
        color: [f32; 4],
    ) -> Result<DabReport> {
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, None, |_, tile| paint.field().size_at(tile, level));
        let tiles: Vec<u32> = culled.iter().map(|culled| culled.tile).collect();
        let coarse = paint.field().at_level(context, level, &tiles)?;
        let blank = coarse.blank().color().to_array();
        let displacement = object.displacement.field();
        let simd = context.level();
        let heights = |window: &Window, out: &mut PerKnot| edit::surface_heights(simd, displacement, window, out);
        let (stamp, smudge) = (self.brush.stamp(), self.brush.smudge());
        let painting = Painting { level: simd, mode, color: everywhere(color), blank, stamp, smudge };
        let edits = edit::evaluate(context, &object.surface, &coarse, &culled, &brush, heights, |site, texels| {
            painting.edit(site, texels);
        });
        edit::write_at(context, paint, Some(&coarse), &culled, edits, mode == PaintMode::Erase)
    }

    fn sculpt_at(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        level: u32,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        object.layers.displacement.check_editable()?;
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let size = |object: &DisplacedObject, tile: u32| object.displacement.field().size_at(tile, level);
        let culled = self.intersect(context, object, None, size);
        let tiles: Vec<u32> = culled.iter().map(|culled| culled.tile).collect();
        let coarse = object.displacement.field().at_level(context, level, &tiles)?;
        let heights = |window: &Window, out: &mut PerKnot| edit::coefficients(&coarse, window, out);
        let sculpting = Sculpting { level: context.level(), mode, height, stamp: self.brush.stamp(), since: false };
        let displaced = Displaced::new(&object.surface, &coarse)?;
        let edits = edit::evaluate(context, &object.surface, &coarse, &culled, &brush, heights, |site, texels| {
            sculpting.edit(site, |site, cosines| site.facing(context, &displaced, cosines), texels);
        });
        // Finer coefficients may reach further than those of the level.
        let displacement = object.displacement_mut();
        edit::write_at(context, displacement, Some(&coarse), &culled, edits, mode == SculptMode::Erase)
    }
}
