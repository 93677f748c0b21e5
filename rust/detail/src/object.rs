//! A deformable object: a limit surface, its displacement, the colours painted on it, and an affine transform to the
//! world. Displacement is in object units.

pub(crate) mod any;
pub mod canvas;
pub(crate) mod fit;
pub(crate) mod instances;
pub mod nearest;
pub(crate) mod ranges;
pub mod refusal;
#[cfg(test)]
pub(crate) mod shapes;
mod tile_bounds;
pub(crate) mod transform;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_surface::{Cone, Surface};
use relievo_tiles::{
    AnyField, ByFormat, Channel, Displaced, Displacement, Field, Paint, Rgba16, Snapshot, StoredTexel, Texel, Traces,
    Vector, VectorDisplacement,
};

use crate::channels::fading::DecayingObject;
use crate::channels::layered::{LayeredObject, Layers};
use crate::device::DeviceObject;
use crate::geometry::hierarchy::{Hierarchy, Region};
use crate::geometry::obb::Obb;
use crate::object::fit::Fit;
use crate::object::ranges::Ranges;
use crate::object::tile_bounds::{tile_bounds, tile_cone};
use crate::object::transform::check_transform;
use crate::paint::ground::Ground;

/// A displaced surface in the world.
#[derive(Debug)]
pub struct DisplacedObject {
    pub(crate) surface: Surface,
    pub(crate) vectors: Option<VectorDisplacement>,
    /// The length of the longest vector, once it was asked for.
    longest: OnceLock<f32>,
    pub(crate) traces: Option<Traces>,
    /// Its displacement and its colours.
    pub(crate) layers: Layers,
    pub(crate) transform: DAffine3,
    pub(crate) hierarchy: Hierarchy,
    /// Boxes that follow the displacement, once brushes need them.
    fit: Option<Fit>,
    obb: Obb,
    /// Cones of the normals of the tiles that were looked at in this pose.
    cones: BTreeMap<u32, Cone>,
    reach: Option<[f32; 2]>,
    ranges: Ranges,
    /// What evaluates dabs and imprints in place of the processor, and why it did not.
    pub(crate) device: Option<DeviceObject>,
    pub(crate) device_fault: Option<Error>,
}

impl DisplacedObject {
    /// Puts `surface`, made from a cage with the points `cage`, and its `displacement` into the world.
    ///
    /// # Errors
    /// Fails with `Invalid` if the displacement has another number of tiles or the cage another number of points than
    /// the surface, a point is not finite, or the transform is not finite or cannot be undone.
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
        let count = surface.table().cage_point_count();
        if cage.len() != count {
            return Err(Error::invalid(format!("{} points were given, the surface's cage has {count}", cage.len())));
        }
        check_transform(&transform)?;
        let obb = Obb::of_points(cage)?;
        let hierarchy = context.stats().time("object.hierarchy", || {
            Hierarchy::build(context, surface.tile_count(), |tile| tile_bounds(&surface, tile))
        })?;
        Ok(Self {
            surface,
            vectors: None,
            longest: OnceLock::new(),
            traces: None,
            layers: Layers::new(displacement),
            transform,
            hierarchy,
            fit: None,
            obb,
            cones: BTreeMap::new(),
            reach: None,
            ranges: Ranges::default(),
            device: None,
            device_fault: None,
        })
    }

    /// Moves the cage: poses the surface anew and refits the hierarchy. Displacements stay.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there are not as many points as the cage has or one is not finite.
    /// Where a device fails, the processor takes over instead, see [`Self::take_device_fault`].
    pub fn pose(&mut self, context: &Context, cage: &[[f32; 3]]) -> Result<()> {
        let surface = self.surface.posed(context, cage)?;
        self.obb = Obb::of_points(cage)?;
        let hierarchy = &mut self.hierarchy;
        context.stats().time("object.refit", || hierarchy.refit(context, |tile| tile_bounds(&surface, tile)));
        self.surface = surface;
        if let Some(fit) = &mut self.fit {
            fit.pose(context, &self.surface, &self.hierarchy);
        }
        self.cones.clear();
        if let Some(Err(fault)) = self.device.as_mut().map(|device| device.pose(cage)) {
            (self.device, self.device_fault) = (None, Some(fault));
        }
        Ok(())
    }

    /// The limit surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The displacement.
    pub fn displacement(&self) -> &Displacement {
        self.layers.displacement.composite()
    }

    /// The displacement, to be written.
    pub fn displacement_mut(&mut self) -> &mut Displacement {
        self.reach = None;
        self.ranges.forget();
        if let Some(fit) = &mut self.fit {
            fit.forget();
        }
        self.layers.displacement.composite_mut()
    }

    /// Makes what imprints changed visible to readers.
    pub fn commit(&mut self) -> Arc<Snapshot> {
        self.layers.displacement.composite_mut().commit()
    }

    /// As [`Self::commit`], of vectors, if there are any.
    pub fn commit_vectors(&mut self) -> Option<Arc<Snapshot<Vector>>> {
        self.vectors.as_mut().map(|vectors| vectors.commit())
    }

    /// The surface with all its displacements.
    ///
    /// # Errors
    /// Fails with `Invalid` only if [`Self::displacement_mut`] or [`Self::vectors_mut`] was given a displacement of
    /// another surface.
    pub fn displaced(&self) -> Result<Displaced<'_>> {
        self.ground().displaced(&self.surface)
    }

    /// The vector displacement that comes after the scalar one, if it has one.
    pub fn vectors(&self) -> Option<&VectorDisplacement> {
        self.vectors.as_ref()
    }

    /// The vector displacement, to be written.
    pub fn vectors_mut(&mut self) -> Option<&mut VectorDisplacement> {
        self.bent();
        self.vectors.as_mut()
    }

    /// Gives the object a vector displacement.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if it has another number of tiles than the surface, and with the
    /// error of the page store if a tile cannot be read from its page or written to one.
    pub fn set_vectors(&mut self, mut vectors: VectorDisplacement) -> Result<()> {
        Displaced::new(&self.surface, self.displacement().field())?.with_vectors(vectors.field())?;
        self.page(&mut vectors)?;
        self.bent();
        self.vectors = Some(vectors);
        Ok(())
    }

    /// Notes that vectors may be others.
    fn bent(&mut self) {
        self.longest = OnceLock::new();
        if let Some(fit) = &mut self.fit {
            fit.forget();
        }
    }

    /// The length of the longest vector.
    pub(crate) fn longest(&self) -> f32 {
        let Some(vectors) = &self.vectors else { return 0.0 };
        let field = vectors.field();
        *self.longest.get_or_init(|| field.allocated().map(|tile| field.length(tile)).fold(0.0, f32::max))
    }

    /// The displacements as they are.
    pub(crate) fn ground(&self) -> Ground<'_> {
        Ground { heights: self.displacement().field(), vectors: self.vectors.as_ref().map(|vectors| vectors.field()) }
    }

    /// The numbers of the last edits of displacement and of vectors.
    fn revision(&self) -> [u64; 2] {
        [self.displacement().revision(), self.vectors.as_ref().map_or(0, |vectors| vectors.revision())]
    }

    /// The colours painted on it, of either format, if it can be painted.
    pub fn colors(&self) -> Option<AnyField<'_>> {
        self.layers.color_fields()
    }

    /// The colours painted on it, if it can be painted with those of 8 bits.
    pub fn paint(&self) -> Option<&Paint> {
        self.layers.paints().0
    }

    /// The colours of 8 bits, to be written. With several layers of them, see [`Self::layers`], these are what the
    /// layers come to, and what is written is lost when they are settled.
    pub fn paint_mut(&mut self) -> Option<&mut Paint> {
        self.layers.paints_mut().0
    }

    /// As [`Self::paint`], of half floats.
    pub fn half_paint(&self) -> Option<&Paint<Rgba16>> {
        self.layers.paints().1
    }

    /// As [`Self::paint_mut`], of half floats.
    pub fn half_paint_mut(&mut self) -> Option<&mut Paint<Rgba16>> {
        self.layers.paints_mut().1
    }

    /// Makes the object one that can be painted with colours of 8 bits, in place of those it may have.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if the colours have another number of tiles than the surface, and
    /// with the error of the page store if a tile cannot be read from its page or written to one.
    pub fn set_paint(&mut self, mut paint: Paint) -> Result<()> {
        self.take_on(&mut paint)?;
        self.layers.set_colors(ByFormat::Rgba8(paint));
        self.fade_own()
    }

    /// As [`Self::set_paint`] with colours of half floats, which may be brighter than 1.
    ///
    /// # Errors
    /// Fails as [`Self::set_paint`].
    pub fn set_half_paint(&mut self, mut paint: Paint<Rgba16>) -> Result<()> {
        self.take_on(&mut paint)?;
        self.layers.set_colors(ByFormat::Rgba16(paint));
        self.fade_own()
    }

    /// Makes colours page as the object does. Fails if they are those of another surface.
    fn take_on<T: StoredTexel>(&self, paint: &mut Paint<T>) -> Result<()> {
        let (tiles, painted) = (self.surface.tile_count(), paint.field().tile_count());
        if tiles != painted {
            return Err(Error::invalid(format!("the surface has {tiles} tiles and its colours {painted}"))
                .advise("make the colours from the topology of this surface"));
        }
        self.page(paint)
    }

    /// The traces that imprints leave, if they are to leave any.
    pub fn traces(&self) -> Option<&Traces> {
        self.traces.as_ref()
    }

    /// The traces, to be written.
    pub fn traces_mut(&mut self) -> Option<&mut Traces> {
        self.traces.as_mut()
    }

    /// Makes imprints leave traces.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if the traces have another number of tiles than the surface, and with
    /// the error of the page store if a tile cannot be read from its page or written to one.
    pub fn set_traces(&mut self, mut traces: Traces) -> Result<()> {
        let (tiles, traced) = (self.surface.tile_count(), traces.field().tile_count());
        if tiles != traced {
            return Err(Error::invalid(format!("the surface has {tiles} tiles and its traces {traced}"))
                .advise("make the traces from the displacement of this object"));
        }
        self.page(&mut traces)?;
        self.traces = Some(traces);
        Ok(())
    }

    /// A channel of an object that pages does as well.
    fn page<T: Texel>(&self, channel: &mut Channel<T>) -> Result<()> {
        match (self.page_store(), channel.page_store()) {
            (Some(own), Some(other)) if Arc::ptr_eq(own, other) => Ok(()),
            (Some(own), _) => channel.page_to(Some(own.clone())),
            (None, _) => Ok(()),
        }
    }

    /// From object space to the world.
    pub fn transform(&self) -> &DAffine3 {
        &self.transform
    }

    /// Moves the object.
    ///
    /// # Errors
    /// Fails with `Invalid` if the transform is not finite or cannot be undone.
    pub fn set_transform(&mut self, transform: DAffine3) -> Result<()> {
        check_transform(&transform)?;
        self.transform = transform;
        Ok(())
    }

    /// The box of the surface without its scalar displacement in the world, enlarged by `margin` object units.
    pub fn obb(&self, margin: f64) -> Obb {
        self.obb.enlarged(margin + f64::from(self.longest())).transformed(&self.transform)
    }

    /// The part of `obb`, along its axes, that holds all tiles in it, displaced by `from` to `to` object units along
    /// their normals and by their vectors; `None` without such tiles.
    pub fn occupied(&mut self, context: &Context, obb: &Obb, from: f64, to: f64) -> Option<Obb> {
        let map = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let rows = [0, 1, 2].map(|axis| map.matrix3.row(axis));
        let stretch = DVec3::from(rows.map(|row| row.length()));
        let margin = stretch * (from.abs().max(to.abs()) + f64::from(self.longest()));
        let mut tiles = context.scratch().list();
        self.hierarchy.query(context, &Region::new(map, -obb.half - margin, obb.half + margin), &mut tiles);
        let spread = map.matrix3.abs();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for tile in tiles.iter().copied() {
            let (least, most) = self.surface.tile_bounds(tile);
            let (least, most) = (DVec3::from(least.map(f64::from)), DVec3::from(most.map(f64::from)));
            let center = map.transform_point3(0.5 * (least + most));
            let length = self.vectors.as_ref().map_or(0.0, |vectors| vectors.field().length(tile));
            let half = spread * (0.5 * (most - least)) + stretch * f64::from(length);
            let surface = &self.surface;
            let cone = self.cones.entry(tile).or_insert_with(|| tile_cone(surface, tile));
            let (mut down, mut up) = (center - half, center + half);
            for axis in 0..3 {
                let (along, against) = cone.span(rows[axis].as_vec3().to_array());
                let ends = [from, to].map(|d| [d * f64::from(along), d * f64::from(against)]);
                let ends = ends.as_flattened();
                down[axis] += ends.iter().copied().fold(f64::INFINITY, f64::min);
                up[axis] += ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            }
            // A tile beside the box does not widen it.
            if down.cmple(obb.half).all() && up.cmpge(-obb.half).all() {
                (low, high) = (low.min(down), high.max(up));
            }
        }
        let slack = 1e-5 * obb.half;
        let (low, high) = ((low - slack).max(-obb.half), (high + slack).min(obb.half));
        if low.cmpgt(high).any() {
            return None;
        }
        let local = Obb::from_interval(DMat3::IDENTITY, low, high);
        Some(Obb { center: obb.center + obb.axes * local.center, axes: obb.axes, half: local.half })
    }

    /// Boxes of the tiles, and how far the displaced surface may be beyond them: boxes that follow the displacement if
    /// they are up to date, else those of the surface itself. While a stroke is drawn they hold the surface it began on
    /// too.
    pub(crate) fn bounds(&self) -> (&Hierarchy, f32) {
        match self.fit.as_ref().filter(|fit| fit.has_seen(self.revision())) {
            Some(fit) => (fit.hierarchy(), 0.0),
            None => {
                let [least, most] = self.reach.unwrap_or_else(|| coefficient_range(self.displacement().field()));
                (&self.hierarchy, most.max(-least) + self.longest())
            }
        }
    }

    /// Tiles whose surface, displaced as far as coefficients reach, may be in `obb`.
    pub fn tiles_near(&self, context: &Context, obb: &Obb) -> Vec<u32> {
        let map = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let (hierarchy, reach) = self.bounds();
        let rows = [0, 1, 2].map(|axis| map.matrix3.row(axis));
        let margin = DVec3::from(rows.map(|row| row.length())) * f64::from(reach);
        let mut tiles = Vec::new();
        hierarchy.query(context, &Region::new(map, -obb.half - margin, obb.half + margin), &mut tiles);
        tiles
    }

    /// How much the normals of the tiles in `obb` run along each of its axes, 0 to 1.
    pub fn facing(&mut self, context: &Context, obb: &Obb) -> DVec3 {
        let map = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let mut tiles = context.scratch().list();
        self.hierarchy.query(context, &Region::new(map, -obb.half, obb.half), &mut tiles);
        let count = tiles.len().max(1) as f64;
        let sum: DVec3 = tiles
            .iter()
            .copied()
            .map(|tile| {
                let surface = &self.surface;
                let cone = self.cones.entry(tile).or_insert_with(|| tile_cone(surface, tile));
                (map.matrix3 * DVec3::from(cone.axis.map(f64::from))).normalize_or_zero().abs()
            })
            .sum();
        sum / count
    }

    /// Bounds of the coefficients of the displacement, 0 between them: the least and the largest there is, and those there
    /// were since the last imprint or motion began.
    pub fn reach(&mut self) -> [f32; 2] {
        self.reach.unwrap_or_else(|| self.measure())
    }

    /// Finds the least and the largest coefficient there is. What was before is forgotten: an edit that goes by the reach
    /// does the same to an object that was undone or opened as it is.
    pub(crate) fn measure(&mut self) -> [f32; 2] {
        let field = self.layers.displacement.composite().field();
        let tiles = field.allocated().map(|tile| (tile, field.version(tile)));
        *self.reach.insert(self.ranges.of(tiles, |tile| field.range(tile)))
    }

    /// Brings the boxes that brushes look at up to date with all edits. With `start`, they cover that displacement too.
    pub(crate) fn follow(&mut self, context: &Context, start: Option<Ground<'_>>) -> &Fit {
        let mut fit = self.fit.take().unwrap_or_else(|| Fit::new(&self.hierarchy));
        fit.follow(context, &self.surface, self.ground(), start, self.revision());
        self.fit.insert(fit)
    }

    /// As [`Self::follow`] after an edit that changed only `tiles`.
    pub(crate) fn refit(&mut self, context: &Context, start: Option<Ground<'_>>, tiles: &[u32]) {
        self.longest = OnceLock::new();
        if let Some(mut fit) = self.fit.take() {
            let _stage = context.stats().begin("dab.refit");
            fit.refit(context, &self.surface, self.ground(), start, tiles, self.revision());
            self.fit = Some(fit);
        }
    }

    /// Notes that coefficients now reach from `least` to `most`, so that the blocks need not be read for it.
    pub(crate) fn widen(&mut self, [least, most]: [f32; 2]) {
        if let Some(reach) = &mut self.reach {
            *reach = [reach[0].min(least), reach[1].max(most)];
        }
    }
}

/// The least and the largest coefficient of all blocks, and 0.
fn coefficient_range(field: &Field) -> [f32; 2] {
    field
        .allocated()
        .map(|tile| field.range(tile))
        .fold([0.0, 0.0], |[least, most], [low, high]| [least.min(low), most.max(high)])
}
