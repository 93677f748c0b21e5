//! Two deformable objects in contact (Schäfer et al. 2014, Section 1): two passes, in each of which one object is the
//! rigid collider for the other.
//!
//! In the first pass the first object gives way to the second by its share of the penetration. In the second pass the
//! second object gives way to the first, as the first pass left it, by everything that remains. So both are dented,
//! each by its share, and nothing overlaps afterwards.

use relievo_core::{Context, Mesh, Result};

use crate::geometry::grid::Grid;
use crate::geometry::overlap::overlap;
use crate::imprint::Imprinter;
use crate::imprint::collider::Collider;
use crate::imprint::settings::{ImprintSettings, Moment, Report};
use crate::object::DisplacedObject;

/// One side of a pair of deformable objects.
#[derive(Debug)]
pub struct Deformable<'a> {
    /// The object.
    pub object: &'a mut DisplacedObject,
    /// The faces of its surface's cage.
    pub cage: &'a Mesh,
    /// How it takes imprints. The share of the first side is what it takes of the penetration; that of the second is
    /// what it takes of the rest, 1 as a rule.
    pub settings: ImprintSettings,
}

impl Imprinter {
    /// Presses two deformable objects into each other where they stand. Returns what happened to either.
    ///
    /// Both surfaces are tessellated finer than a voxel where they meet.
    ///
    /// # Errors
    /// Fails as [`Imprinter::imprint`] and [`Collider::of_object`]; the first object may be dented then.
    pub fn collide(
        &mut self,
        context: &Context,
        first: &mut Deformable<'_>,
        second: &mut Deformable<'_>,
        moment: Moment,
    ) -> Result<[Report; 2]> {
        let pair = 2 * moment.pair;
        let one = self.give_way(context, first, second, Moment { pair, ..moment })?;
        let other = self.give_way(context, second, first, Moment { pair: pair + 1, ..moment })?;
        Ok([one, other])
    }

    /// One pass: `dented` gives way to `other` as it is.
    fn give_way(
        &mut self,
        context: &Context,
        dented: &mut Deformable<'_>,
        other: &mut Deformable<'_>,
        moment: Moment,
    ) -> Result<Report> {
        dented.settings.check()?;
        let [least, most] = dented.object.measure().map(f64::from);
        let least = least.min(f64::from(-dented.settings.max_displacement));
        let [inward, outward] = other.object.measure().map(f64::from);
        let boxes = (dented.object.obb(most.max(-least)), other.object.obb(outward.max(-inward)));
        let nothing = Report { bytes: dented.object.displacement().bytes(), ..Report::default() };
        let Some(both) = overlap(&boxes.0, &boxes.1) else { return Ok(nothing) };
        let Some(both) = dented.object.occupied(context, &both, least, most) else { return Ok(nothing) };
        // Cells as small as the voxels would be if the overlap were no smaller than this box.
        let edge = Grid::new(&both, u64::from(dented.settings.voxels), None).size.min_element();
        let stage = context.stats().begin("imprint.tessellate");
        let collider = Collider::of_object(context, other.object, other.cage, &both, edge)?;
        stage.end();
        self.imprint(context, dented.object, &collider, &dented.settings, moment)
    }
}
