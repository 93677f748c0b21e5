//! A deformable object: a limit surface, its displacement, and an affine transform to the world. Displacement is in
//! object units.

use glam::DAffine3;
use relievo_core::{Context, Error, Result};
use relievo_surface::Surface;
use relievo_tiles::Displacement;

use crate::hierarchy::{Bounds, Hierarchy};
use crate::knots::Knots;
use crate::obb::Obb;

/// A displaced surface in the world.
#[derive(Debug)]
pub struct DisplacedObject {
    pub(crate) surface: Surface,
    pub(crate) displacement: Displacement,
    pub(crate) transform: DAffine3,
    pub(crate) hierarchy: Hierarchy,
    pub(crate) knots: Knots,
    obb: Obb,
    reach: Option<[f32; 2]>,
}

impl DisplacedObject {
    /// Puts `surface`, made from a cage with the points `cage`, and its `displacement` into the world.
    ///
    /// Fails if the displacement is that of another surface, the cage is empty, or the transform cannot be undone.
    pub fn new(
        context: &Context,
        surface: Surface,
        cage: &[[f32; 3]],
        displacement: Displacement,
        transform: DAffine3,
    ) -> Result<Self> {
        if surface.tile_count() != displacement.field().tile_count() {
            return Err(Error::invalid(format!(
                "the surface has {} tiles and the displacement {}",
                surface.tile_count(),
                displacement.field().tile_count()
            ))
            .advise("make the displacement from the topology of this surface"));
        }
        check_transform(&transform)?;
        let obb = Obb::of_points(cage)?;
        let hierarchy = context.stats().time("object.hierarchy", || {
            Hierarchy::build(context, surface.tile_count(), |tile| tile_bounds(&surface, tile))
        })?;
        Ok(Self { surface, displacement, transform, hierarchy, knots: Knots::default(), obb, reach: None })
    }

    /// Moves the cage: poses the surface anew and refits the hierarchy. Displacements stay.
    pub fn pose(&mut self, context: &Context, cage: &[[f32; 3]]) -> Result<()> {
        let surface = self.surface.posed(context, cage)?;
        self.obb = Obb::of_points(cage)?;
        let hierarchy = &mut self.hierarchy;
        context.stats().time("object.refit", || hierarchy.refit(context, |tile| tile_bounds(&surface, tile)));
        self.surface = surface;
        self.knots.forget();
        Ok(())
    }

    /// The limit surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The displacement.
    pub fn displacement(&self) -> &Displacement {
        &self.displacement
    }

    /// The displacement, to be written.
    pub fn displacement_mut(&mut self) -> &mut Displacement {
        self.reach = None;
        &mut self.displacement
    }

    /// From object space to the world.
    pub fn transform(&self) -> &DAffine3 {
        &self.transform
    }

    /// Moves the object. Fails if the transform cannot be undone.
    pub fn set_transform(&mut self, transform: DAffine3) -> Result<()> {
        check_transform(&transform)?;
        self.transform = transform;
        Ok(())
    }

    /// The box of the undisplaced surface in the world, enlarged by `margin` object units.
    pub fn obb(&self, margin: f64) -> Obb {
        self.obb.enlarged(margin).transformed(&self.transform)
    }

    /// The least and the largest coefficient of the displacement, 0 between them.
    pub fn reach(&mut self) -> [f32; 2] {
        let field = self.displacement.field();
        *self.reach.get_or_insert_with(|| {
            let blocks = field.allocated().filter_map(|tile| field.block(tile));
            blocks.flatten().fold([0.0, 0.0], |[least, most], value| {
                let value = value.to_f32();
                [least.min(value), most.max(value)]
            })
        })
    }

    /// Notes that an imprint reached down to `least`, so that the blocks need not be read for it.
    pub(crate) fn deepen(&mut self, least: f32) {
        if let Some(reach) = &mut self.reach {
            reach[0] = reach[0].min(least);
        }
    }
}

/// Fails unless all numbers are finite and the transform can be undone.
pub(crate) fn check_transform(transform: &DAffine3) -> Result<()> {
    let inverse = transform.inverse();
    if transform.is_finite() && inverse.is_finite() && transform.matrix3.determinant() != 0.0 {
        return Ok(());
    }
    Err(Error::invalid("the transform cannot be undone").advise("give finite numbers and no scale of 0"))
}

fn tile_bounds(surface: &Surface, tile: u32) -> Bounds {
    if surface.topology().is_hole(tile) {
        return Bounds::EMPTY;
    }
    let (low, high) = surface.tile_bounds(tile);
    Bounds { low, high }
}
