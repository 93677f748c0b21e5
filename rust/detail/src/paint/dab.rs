//! One touch of a brush: the passes that paint or sculpt what is in its box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 3 to 5:
//! intersect the box with the displaced surface, decide by a scan which tiles to allocate and to modify, evaluate the
//! brush at every texel, bring rings up to date. Here the brush is evaluated before the scan, so that a tile that the
//! box only grazes takes no memory. Tiles that hold nothing any more after an eraser are given back. Stages report
//! their time under `dab.intersect` and as [`crate::paint::edit`] says. Displacement is in object units.

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_tiles::{Channel, ColorPlanes, Displacement, by_format};

use crate::channels::frame::Vectors;
use crate::channels::knots::PerKnot;
use crate::channels::layered::LayeredObject;
use crate::channels::window::Window;
use crate::imprint::cull;
use crate::imprint::culled::{self, CulledTile};
use crate::object::DisplacedObject;
use crate::paint::brush::Brush;
use crate::paint::edit::{self, TileEdit};
use crate::paint::ground::Ground;
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::report::DabReport;
use crate::paint::spot::{Painting, Sculpting, everywhere};
use crate::paint::weights::BrushParameters;

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

impl Dab {
    /// Checks the numbers of the dab.
    ///
    /// # Errors
    /// Fails with `Invalid` if the strength is not within 0 to 1, a number of the colour not within 0 to 10000, or the
    /// height not within −60000 to 60000 object units.
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
    /// # Errors
    /// Fails, and changes nothing, as [`Self::check`], and with `Invalid` if the object does not have the colours or
    /// vectors to change, or the active layer cannot be seen. Fails with the error of the page store if a tile cannot
    /// be read from its page or written to one; part of the dab may be made then.
    pub fn apply(&self, context: &Context, object: &mut DisplacedObject) -> Result<DabReport> {
        let mut report = self.make(context, object, None)?;
        report.refuse(object.settle(context)?);
        Ok(report)
    }

    /// As [`Self::apply`], as one of the dabs of a stroke: what is in the box, and how much of the edit it gets, goes
    /// by the displacement `start` from when the stroke began. So dabs that overlap add up to an even ridge, rather
    /// than each finding what the one before raised. Only dabs were made since, and the reach was known then.
    pub(crate) fn make(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<Ground<'_>>,
    ) -> Result<DabReport> {
        self.check()?;
        match self.action {
            Action::Paint { mode, color } => self.paint(context, object, start, mode, Vec4::from(color)),
            Action::Sculpt { mode, height } => self.sculpt(context, object, (start, 0), mode, height),
        }
    }

    fn paint(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<Ground<'_>>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        if let Some(reports) = object.dab_on_device(context, std::slice::from_ref(self), start)? {
            return Ok(reports.into_iter().next().unwrap_or_default());
        }
        let mut paint = object.take_paint()?;
        let done = by_format!(&mut paint, stack => {
            self.paint_channel(context, object, start, stack.active_mut(), mode, color)
        });
        object.put_paint(paint);
        done
    }

    /// Paints `channel`, colours over the surface of `object` that are not its own.
    ///
    /// # Errors
    /// Fails, and changes nothing, as [`Self::check`], and with `Invalid` if the colours have another number of tiles
    /// than the surface, or the dab does not paint. Fails with the error of the page store if a tile cannot be read
    /// from its page or written to one; part of the dab may be made then.
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
        start: Option<Ground<'_>>,
        paint: &mut Channel<T>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |_, tile| paint.field().size(tile));
        let field = paint.field();
        let blank = field.blank().color().to_array();
        let level = context.level();
        let ground = start.unwrap_or(object.ground());
        let places = |window: &Window, heights: &mut PerKnot, vectors: &mut Vectors| {
            ground.at_texels(level, window, heights, vectors)
        };
        let painting = Painting {
            level,
            mode,
            color: everywhere(color.to_array()),
            blank,
            stamp: self.brush.stamp(),
            smudge: self.brush.smudge(),
        };
        let edits = edit::evaluate(context, &object.surface, field, &culled, &brush, places, |site, texels| {
            painting.edit(site, texels);
        });
        let report = edit::write(context, paint, &culled, edits, mode == PaintMode::Erase)?;
        culled::give_back(context, culled);
        Ok(report)
    }

    /// Changes displacement, vectors or both at a level.
    pub(crate) fn sculpt(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        (start, level): (Option<Ground<'_>>, u32),
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        let raise = |object: &mut DisplacedObject, start: Option<Ground<'_>>| match level {
            0 => self.raise(context, object, start, mode, height),
            _ => self.raise_at(context, object, (start, level), mode, height),
        };
        if mode.needs_vectors() {
            return self.bend(context, object, (start, level), mode, height);
        }
        if !(mode.changes_vectors() && object.vectors.is_some()) {
            return raise(object, start);
        }
        // Both see the surface as it was before.
        let kept = match start {
            Some(_) => None,
            None => Some((object.displacement().field().clone(), object.vectors.as_ref().map(|v| v.field().clone()))),
        };
        let kept = kept.as_ref().map(|(heights, vectors)| Ground { heights, vectors: vectors.as_ref() });
        let mut report = raise(object, start.or(kept))?;
        let bytes = report.bytes;
        let bent = self.bend(context, object, (start.or(kept), level), mode, height)?;
        report.merge(&bent);
        bent.give_back(context);
        report.bytes += bytes;
        Ok(report)
    }

    /// Changes the displacement along the normals.
    fn raise(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<Ground<'_>>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        object.layers.displacement.check_editable()?;
        let (kind, dabs) = (Kind::Sculpt(mode), std::slice::from_ref(self));
        if let Some(reports) = object.made_on_device(context, kind, dabs, start)? {
            return Ok(reports.into_iter().next().unwrap_or_default());
        }
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |object, tile| object.displacement().field().size(tile));
        let edits = self.raised(context, object, start, (mode, height), &culled, &brush)?;
        object.widen(edit::range(context, &edits));
        let displacement: &mut Displacement = object.layers.displacement.composite_mut();
        let report = edit::write(context, displacement, &culled, edits, mode == SculptMode::Erase)?;
        object.refit_after(context, start, &culled, &report, false);
        culled::give_back(context, culled);
        Ok(report)
    }

    /// The second pass of a change of the displacement along the normals.
    fn raised(
        &self,
        context: &Context,
        object: &DisplacedObject,
        start: Option<Ground<'_>>,
        (mode, height): (SculptMode, f32),
        culled: &[CulledTile],
        brush: &BrushParameters,
    ) -> Result<Vec<TileEdit<f16>>> {
        let field = object.displacement().field();
        let level = context.level();
        let ground = start.unwrap_or(object.ground());
        let places = |window: &Window, heights: &mut PerKnot, vectors: &mut Vectors| {
            ground.at_coefficients(level, window, heights, vectors)
        };
        let sculpting = Sculpting { level, mode, height, stamp: self.brush.stamp(), since: start.is_some() };
        let displaced = ground.displaced(&object.surface)?;
        Ok(edit::evaluate(context, &object.surface, field, culled, brush, places, |site, texels| {
            sculpting.edit(site, |site, cosines| site.facing(context, &displaced, cosines), texels);
        }))
    }

    /// The first pass: tiles and blocks of texels that may be in the box.
    pub(crate) fn intersect(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<Ground<'_>>,
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

/// That vectors are to be changed which are not there.
pub(crate) fn no_vectors() -> Error {
    Error::invalid("the object has no vector displacement to change").advise("give it some first")
}

/// What dabs that can be made together have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Of displacement along the normals.
    Sculpt(SculptMode),
    /// Of vectors.
    Bend(SculptMode),
    Paint(PaintMode),
}

impl Kind {
    /// That of a dab, if kernels know it.
    pub fn of(dab: &Dab) -> Option<Self> {
        match dab.action {
            Action::Sculpt { mode, .. } => (!mode.needs_vectors()).then_some(Self::Sculpt(mode)),
            Action::Paint { mode, .. } => Some(Self::Paint(mode)),
        }
    }

    /// That of a dab of an object which has vectors or not, if kernels know it and it is no more than that.
    pub fn on(dab: &Dab, has_vectors: bool) -> Option<Self> {
        match dab.action {
            Action::Sculpt { mode, .. } if has_vectors && mode.changes_vectors() => {
                mode.needs_vectors().then_some(Self::Bend(mode))
            }
            _ => Self::of(dab),
        }
    }

    /// That of the first half of a dab which changes displacement and vectors of an object that has both.
    pub fn of_both(dab: &Dab, has_vectors: bool) -> Option<Self> {
        let Action::Sculpt { mode, .. } = dab.action else { return None };
        (has_vectors && mode.changes_vectors() && !mode.needs_vectors()).then_some(Self::Sculpt(mode))
    }

    /// The first of `dabs` that are of one kind, with the same image of the brush; `None` if the first has none. Fails as
    /// [`Dab::check`].
    pub fn first(dabs: &[Dab], kind: impl Fn(&Dab) -> Option<Self>) -> Result<Option<(Self, &[Dab])>> {
        let Some(first) = dabs.first().and_then(&kind) else { return Ok(None) };
        dabs.iter().try_for_each(|dab| dab.check())?;
        let stamp = dabs.first().and_then(|dab| dab.brush.stamp());
        let same_stamp = |dab: &Dab| match (dab.brush.stamp(), stamp) {
            (Some(one), Some(other)) => one.is_like(other),
            (one, other) => one.is_none() && other.is_none(),
        };
        let alike = |dab: &&Dab| kind(dab) == Some(first) && same_stamp(dab);
        Ok(Some((first, &dabs[..dabs.iter().take_while(alike).count()])))
    }
}
