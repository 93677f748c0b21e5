//! One touch of a brush: the passes that paint or sculpt what is in its box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 3 to 5:
//! intersect the box with the displaced surface, decide by a scan which tiles to allocate and to modify, evaluate the
//! brush at every texel, bring rings up to date. Here the brush is evaluated before the scan, so that a tile that the
//! box only grazes takes no memory. Tiles that hold nothing any more after an eraser are given back. Stages report
//! their time under `dab.intersect` and as [`crate::edit`] says. Displacement is in object units.

use glam::Vec4;
use relievo_core::{Context, Error, Result};
use relievo_tiles::{Channel, ColorPlanes, Displaced, Displacement, Field};

use crate::brush::Brush;
use crate::cull::{self, CulledTile};
use crate::edit::{self, Window};
use crate::knots::PerKnot;
use crate::layered::LayeredObject;
use crate::mode::{PaintMode, SculptMode};
use crate::object::DisplacedObject;
use crate::spot::{Painting, Sculpting, everywhere};
use crate::weights::BrushParameters;

/// What a brush does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Changes colours.
    Paint {
        /// How.
        mode: PaintMode,
        /// Linear Rec.709 and alpha.
        color: [f32; 4],
    },
    /// Changes displacement.
    Sculpt {
        /// How.
        mode: SculptMode,
        /// What is drawn where the share is 1, object units.
        height: f32,
    },
}

/// One touch of a brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Dab {
    /// Where.
    pub brush: Brush,
    /// What.
    pub action: Action,
    /// How much of it, 0 to 1.
    pub strength: f32,
}

/// What dabs did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DabReport {
    /// Tiles of which texels were looked at.
    pub tested_tiles: u64,
    /// Texels that were looked at.
    pub tested_texels: u64,
    /// Tiles of which texels changed, ascending.
    pub changed: Vec<u32>,
    /// Texels that changed.
    pub changed_texels: u64,
    /// Tiles that were newly allocated, neighbours included.
    pub allocated: u64,
    /// Tiles that were given back.
    pub freed: u64,
    /// Tiles that the budget refused, ascending.
    pub refused: Vec<u32>,
    /// Bytes of the allocated tiles of the channel afterwards.
    pub bytes: u64,
}

impl DabReport {
    /// Counts tiles as refused.
    pub(crate) fn refuse(&mut self, tiles: Vec<u32>) {
        self.refused.extend(tiles);
        self.refused.sort_unstable();
        self.refused.dedup();
    }

    /// Adds what another dab did afterwards.
    pub fn merge(&mut self, other: DabReport) {
        let union = |a: &mut Vec<u32>, b: Vec<u32>| {
            a.extend(b);
            a.sort_unstable();
            a.dedup();
        };
        self.tested_tiles += other.tested_tiles;
        self.tested_texels += other.tested_texels;
        union(&mut self.changed, other.changed);
        self.changed_texels += other.changed_texels;
        self.allocated += other.allocated;
        self.freed += other.freed;
        union(&mut self.refused, other.refused);
        self.bytes = other.bytes;
    }
}

impl Dab {
    /// Fails if a number is not finite or out of its range.
    pub fn check(&self) -> Result<()> {
        let fault = |what: &str, remedy: &str| Err(Error::invalid(what).at("dab").advise(remedy));
        if !(0.0..=1.0).contains(&self.strength) {
            return fault("its strength is out of range", "use 0 to 1");
        }
        match self.action {
            Action::Paint { color, .. } if color.iter().any(|value| !(0.0..=1e4).contains(value)) => {
                fault("its colour is out of range", "use numbers from 0 to 10000")
            }
            Action::Sculpt { height, .. } if !(-60000.0..=60000.0).contains(&height) => {
                fault("its height is out of range", "use object units from -60000 to 60000")
            }
            _ => Ok(()),
        }
    }

    /// Paints or sculpts `object`, all passes in a row.
    ///
    /// Fails, and changes nothing, if a number is out of range, or the object has no colours and is to be painted.
    pub fn apply(&self, context: &Context, object: &mut DisplacedObject) -> Result<DabReport> {
        let mut report = self.make(context, object, None)?;
        report.refuse(object.settle(context)?);
        Ok(report)
    }

    /// As [`Self::apply`], as one of the dabs of a stroke: what is in the box, and how much of the edit it gets, goes by
    /// the displacement `start` from when the stroke began. So dabs that overlap add up to an even ridge, rather than
    /// each finding what the one before raised. Only dabs were made since, and the reach was known then.
    pub(crate) fn make(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
    ) -> Result<DabReport> {
        self.check()?;
        match self.action {
            Action::Paint { mode, color } => self.paint(context, object, start, mode, Vec4::from(color)),
            Action::Sculpt { mode, height } => self.sculpt(context, object, start, mode, height),
        }
    }

    fn paint(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let mut paint = object.take_paint()?;
        let done = self.paint_channel(context, object, start, &mut paint, mode, color);
        object.put_paint(paint);
        done
    }

    /// Paints `channel`, colours over the surface of `object` that are not its own: a layer, or colours of 16 bits.
    ///
    /// Fails, and changes nothing, if a number is out of range, the colours are those of another surface, or the dab
    /// does not paint.
    pub fn apply_to<T: ColorPlanes>(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        channel: &mut Channel<T>,
    ) -> Result<DabReport> {
        self.check()?;
        let (tiles, painted) = (object.surface.tile_count(), channel.field().tile_count());
        if tiles != painted {
            return Err(Error::invalid(format!("the surface has {tiles} tiles and its colours {painted}"))
                .advise("make the colours from the topology of this surface"));
        }
        let Action::Paint { mode, color } = self.action else {
            return Err(Error::invalid("the dab sculpts and does not paint").at("dab").advise("give it a colour"));
        };
        self.paint_channel(context, object, None, channel, mode, Vec4::from(color))
    }

    fn paint_channel<T: ColorPlanes>(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        paint: &mut Channel<T>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |_, tile| paint.field().size(tile));
        let field = paint.field();
        let blank = field.blank().color().to_array();
        let level = context.level();
        let displacement = start.unwrap_or(object.displacement.field());
        let heights = |window: &Window, out: &mut PerKnot| edit::surface_heights(level, displacement, window, out);
        let painting = Painting {
            level,
            mode,
            color: everywhere(color.to_array()),
            blank,
            stamp: self.brush.stamp(),
            smudge: self.brush.smudge(),
        };
        let edits = edit::evaluate(context, &object.surface, field, &culled, &brush, heights, |site, texels| {
            painting.edit(site, texels);
        });
        edit::write(context, paint, &culled, edits, mode == PaintMode::Erase)
    }

    fn sculpt(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        object.layers.displacement.check_editable()?;
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |object, tile| object.displacement.field().size(tile));
        let field = object.displacement.field();
        let level = context.level();
        let heights = |window: &Window, out: &mut PerKnot| edit::coefficients(start.unwrap_or(field), window, out);
        let sculpting = Sculpting { level, mode, height, stamp: self.brush.stamp(), since: start.is_some() };
        let displaced = Displaced::new(&object.surface, start.unwrap_or(field))?;
        let edits = edit::evaluate(context, &object.surface, field, &culled, &brush, heights, |site, texels| {
            sculpting.edit(site, |site, cosines| site.facing(context, &displaced, cosines), texels);
        });
        object.widen(edit::range(context, &edits));
        let displacement: &mut Displacement = &mut object.displacement;
        let report = edit::write(context, displacement, &culled, edits, mode == SculptMode::Erase)?;
        object.refit_after(context, start, &culled, &report, false);
        Ok(report)
    }

    /// The first pass: tiles and blocks of texels that may be in the box.
    pub(crate) fn intersect(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        size: impl Fn(&DisplacedObject, u32) -> u32 + Sync,
    ) -> Vec<CulledTile> {
        let mut stage = context.stats().begin("dab.intersect");
        let mut culled = cull::cull_box(context, object, self.brush.obb(), size, start);
        culled.sort_unstable_by_key(|tile| tile.tile);
        stage.count("tiles", culled.len() as u64);
        stage.count("blocks", culled.iter().map(|tile| tile.blocks.len() as u64).sum());
        culled
    }
}
