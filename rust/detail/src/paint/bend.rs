//! Dabs that change the vector displacement of a Catmull-Clark surface, at the texels it has or at a coarser level.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 5 and
//! 7.1: the passes of any dab, over texels whose vectors are in frames of their own. Units: object units.

use relievo_core::{Context, Result};

use crate::channels::frame::Vectors;
use crate::channels::knots::PerKnot;
use crate::channels::window::{PlaceShift, Window};
use crate::imprint::culled;
use crate::object::DisplacedObject;
use crate::paint::dab::Kind;
use crate::paint::dab::{Dab, no_vectors};
use crate::paint::edit;
use crate::paint::ground::Ground;
use crate::paint::mode::SculptMode;
use crate::paint::report::DabReport;
use crate::paint::vector::Bending;
use crate::paint::weights::BrushParameters;

impl Dab {
    /// Changes the vectors, at `level` if that is not 0.
    pub(crate) fn bend(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        (start, level): (Option<Ground<'_>>, u32),
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        if object.vectors.is_none() {
            return Err(no_vectors());
        }
        if level == 0 {
            let (kind, dabs) = (Kind::Bend(mode), std::slice::from_ref(self));
            if let Some(reports) = object.made_on_device(context, kind, dabs, start)? {
                return Ok(reports.into_iter().next().unwrap_or_default());
            }
        }
        let brush = BrushParameters::new(&self.brush, self.strength, &object.transform);
        let culled = self.intersect(context, object, start, |object, tile| match &object.vectors {
            Some(vectors) if level > 0 => vectors.field().size_at(tile, level),
            Some(vectors) => vectors.field().size(tile),
            None => object.displacement().field().size(tile),
        });
        let Some(vectors) = &object.vectors else { return Err(no_vectors()) };
        let mut tiles = context.scratch().list();
        tiles.extend(culled.iter().map(|culled| culled.tile));
        let coarse = (level > 0).then(|| vectors.field().at_level(context, level, &tiles)).transpose()?;
        let before = start.and_then(|start| start.vectors);
        let coarse_before =
            before.filter(|_| level > 0).map(|before| before.at_level(context, level, &tiles)).transpose()?;
        let made = coarse
            .as_ref()
            .and_then(|coarse| object.bent_on_device(context, self, start, (coarse, coarse_before.as_ref()), mode));
        let Some(vectors) = &object.vectors else { return Err(no_vectors()) };
        let field = coarse.as_ref().unwrap_or(vectors.field());
        let ground = Ground {
            heights: start.unwrap_or(object.ground()).heights,
            vectors: coarse_before.as_ref().or(before).or(Some(field)),
        };
        let simd = context.level();
        let places = |window: &Window, heights: &mut PerKnot, vectors: &mut Vectors| {
            ground.heights(simd, window, heights);
            ground.vector_coefficients(window, vectors);
            PlaceShift::Vectors
        };
        let bending = Bending::new(simd, mode, height, &self.brush, &object.transform);
        let surface = &object.surface;
        let edits = made.unwrap_or_else(|| {
            edit::evaluate(context, surface, field, &culled, &brush, places, |site, texels| {
                bending.edit(site, texels);
            })
        });
        let Some(vectors) = &mut object.vectors else { return Err(no_vectors()) };
        let erase = mode == SculptMode::Erase;
        let report = edit::write_at(context, vectors, coarse.as_ref(), &culled, edits, erase)?;
        let tiles = edit::stale(context, vectors.field(), &culled, &report);
        object.refit(context, start, &tiles);
        culled::give_back(context, culled);
        Ok(report)
    }
}
