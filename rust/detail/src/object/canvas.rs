//! What strokes are made on: displaced Catmull-Clark surfaces and triangle meshes alike.

use std::fmt::Debug;

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Result};
use relievo_tiles::triangle::{Offset, TriangleField};
use relievo_tiles::{Field, Vector, by_format};

use crate::channels::layered::LayeredObject;
use crate::imprint::culled;
use crate::object::DisplacedObject;
use crate::object::nearest::SurfacePoint;
use crate::paint::dab::Dab;
use crate::paint::ground::Ground;
use crate::paint::report::DabReport;
use crate::triangle::{TriangleGround, TriangleObject};

/// The displacement of an object when a stroke began.
#[derive(Clone, Debug)]
pub enum Start {
    /// That of a Catmull-Clark surface, and the vector displacement that comes after it.
    Tiles(Field, Option<Field<Vector>>),
    /// That of a triangle mesh, and the vectors that come after it, in object space.
    Triangles(TriangleField, Option<TriangleField<Offset>>),
}

impl Start {
    /// That of a Catmull-Clark surface, if it is one's.
    pub(crate) fn ground(&self) -> Option<Ground<'_>> {
        match self {
            Start::Tiles(heights, vectors) => Some(Ground { heights, vectors: vectors.as_ref() }),
            Start::Triangles(..) => None,
        }
    }

    /// That of a triangle mesh, if it is one's.
    fn triangles(&self) -> Option<TriangleGround<'_>> {
        match self {
            Start::Tiles(..) => None,
            Start::Triangles(heights, vectors) => Some(TriangleGround { heights, vectors: vectors.as_ref() }),
        }
    }
}

/// An object that can be painted and sculpted.
pub trait Canvas: Debug + Send + Sync {
    /// From object space to the world.
    fn transform(&self) -> &DAffine3;

    /// Whether it has colours to paint on.
    fn is_paintable(&self) -> bool;

    /// Whether it has vector displacement to change.
    fn is_bendable(&self) -> bool;

    /// Makes it ready for a stroke, so that nothing has to be measured anew for each dab, and returns what dabs go by.
    ///
    /// # Errors
    /// Fails as [`LayeredObject::settle`], which brings the edits before the stroke to their layers, and on a triangle
    /// mesh as [`TriangleObject::renew`].
    fn begin(&mut self, context: &Context) -> Result<Start>;

    /// The place of its surface nearest to a point of the world, no further than `within`, as it was at `start`.
    ///
    /// # Errors
    /// Fails with `Invalid` if the displacement at `start` is that of another surface.
    fn nearest(&self, context: &Context, start: &Start, point: DVec3, within: f64) -> Result<Option<SurfacePoint>>;

    /// Whether the brush of a dab may reach its surface, as it is or was at `start`.
    fn meets(&mut self, context: &Context, dab: &Dab, start: &Start) -> bool;

    /// Bytes of the colours that are painted on.
    ///
    /// # Errors
    /// Fails with `Invalid` if the object has no colours, or their active layer cannot be seen.
    fn painted_bytes(&mut self) -> Result<u64>;

    /// Makes a dab at `level`, see [`StrokeSettings::level`](crate::StrokeSettings::level), as one of a stroke that
    /// began with `start`.
    ///
    /// # Errors
    /// Fails as [`Dab::check`]; with `Invalid` if there is no such level, the object does not have the colours or
    /// vectors to change, or the active layer cannot be seen; with `Memory` if tiles that are coarser than the level do
    /// not fit the budget at its size; and with the error of the page store if a tile or block cannot be read from its
    /// page or written to one.
    fn dab(&mut self, context: &Context, dab: &Dab, start: &Start, level: u32) -> Result<DabReport>;

    /// Makes `dabs` one after the other, see [`Self::dab`]. Returns what each did; the report of the last has what is
    /// known of several together.
    ///
    /// # Errors
    /// Fails as [`Self::dab`]; dabs before stay made.
    fn dabs(&mut self, context: &Context, dabs: &[Dab], start: &Start, level: u32) -> Result<Vec<DabReport>> {
        dabs.iter().map(|dab| self.dab(context, dab, start, level)).collect()
    }

    /// Makes what dabs painted visible where colours have layers; what later dabs find stays the same. Returns tiles
    /// that a budget refused.
    ///
    /// # Errors
    /// Fails as [`LayeredObject::settle_colors`].
    fn show(&mut self, _: &Context) -> Result<Vec<u32>> {
        Ok(Vec::new())
    }

    /// Ends a stroke. Returns tiles that a budget refused after the last dab.
    ///
    /// # Errors
    /// Fails as [`LayeredObject::settle`].
    fn end(&mut self, _: &Context) -> Result<Vec<u32>> {
        Ok(Vec::new())
    }
}

impl Canvas for DisplacedObject {
    fn transform(&self) -> &DAffine3 {
        DisplacedObject::transform(self)
    }

    fn is_paintable(&self) -> bool {
        self.colors().is_some()
    }

    fn is_bendable(&self) -> bool {
        self.vectors().is_some()
    }

    fn begin(&mut self, context: &Context) -> Result<Start> {
        self.settle(context)?;
        self.follow(context, None);
        self.reach();
        let vectors = self.vectors().map(|vectors| vectors.field().clone());
        Ok(Start::Tiles(self.displacement().field().clone(), vectors))
    }

    fn nearest(&self, context: &Context, start: &Start, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        let Some(ground) = start.ground() else { return DisplacedObject::nearest(self, context, point, within) };
        self.nearest_of(context, &ground.displaced(self.surface())?, point, within)
    }

    fn meets(&mut self, context: &Context, dab: &Dab, start: &Start) -> bool {
        let size = |object: &Self, tile| object.displacement().field().size(tile);
        let culled = dab.intersect(context, self, start.ground(), size);
        let meets = !culled.is_empty();
        culled::give_back(context, culled);
        meets
    }

    fn painted_bytes(&mut self) -> Result<u64> {
        let mut paint = self.take_paint()?;
        let bytes = by_format!(&mut paint, stack => stack.active_mut().bytes());
        self.put_paint(paint);
        Ok(bytes)
    }

    fn dab(&mut self, context: &Context, dab: &Dab, start: &Start, level: u32) -> Result<DabReport> {
        dab.make_at(context, self, start.ground(), level)
    }

    fn dabs(&mut self, context: &Context, dabs: &[Dab], start: &Start, level: u32) -> Result<Vec<DabReport>> {
        one_after_another(self, context, dabs, start, level, |object, dabs| {
            object.dab_on_device(context, dabs, start.ground())
        })
    }

    fn show(&mut self, context: &Context) -> Result<Vec<u32>> {
        self.settle_colors(context)
    }

    fn end(&mut self, context: &Context) -> Result<Vec<u32>> {
        self.settle(context)
    }
}

impl Canvas for TriangleObject {
    fn transform(&self) -> &DAffine3 {
        TriangleObject::transform(self)
    }

    fn is_paintable(&self) -> bool {
        self.colors().is_some()
    }

    fn is_bendable(&self) -> bool {
        self.vectors().is_some()
    }

    fn begin(&mut self, context: &Context) -> Result<Start> {
        self.settle(context)?;
        self.reach();
        self.renew(context)?;
        let TriangleGround { heights, vectors } = self.ground();
        Ok(Start::Triangles(heights.clone(), vectors.cloned()))
    }

    fn nearest(&self, context: &Context, start: &Start, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        match start.triangles() {
            None => TriangleObject::nearest(self, context, point, within),
            Some(ground) => self.nearest_of(context, ground, point, within),
        }
    }

    fn meets(&mut self, context: &Context, dab: &Dab, start: &Start) -> bool {
        !self.intersect(context, dab, start.triangles()).is_empty()
    }

    fn painted_bytes(&mut self) -> Result<u64> {
        let mut paint = self.take_paint()?;
        let bytes = by_format!(&mut paint, stack => stack.active_mut().bytes());
        self.put_paint(paint);
        Ok(bytes)
    }

    fn dab(&mut self, context: &Context, dab: &Dab, start: &Start, level: u32) -> Result<DabReport> {
        // What the stroke does not say, the object does.
        let own = self.level();
        self.set_level(if level > 0 { level } else { own })?;
        let done = self.make_dab(context, dab, start.triangles());
        self.set_level(own)?;
        done
    }

    fn dabs(&mut self, context: &Context, dabs: &[Dab], start: &Start, level: u32) -> Result<Vec<DabReport>> {
        one_after_another(self, context, dabs, start, level, |object, dabs| {
            object.dab_on_device(context, dabs, start.triangles())
        })
    }

    fn show(&mut self, context: &Context) -> Result<Vec<u32>> {
        self.settle_colors(context)
    }

    fn end(&mut self, context: &Context) -> Result<Vec<u32>> {
        self.settle(context)
    }
}

/// Makes `dabs` in their order: the first few `there` at once, on the object's device, where it makes any, and else the first
/// one here. Fails as [`Canvas::dabs`].
fn one_after_another<O: Canvas>(
    object: &mut O,
    context: &Context,
    dabs: &[Dab],
    start: &Start,
    level: u32,
    there: impl Fn(&mut O, &[Dab]) -> Result<Option<Vec<DabReport>>>,
) -> Result<Vec<DabReport>> {
    let mut done: Vec<DabReport> = context.scratch().take_list();
    while let Some((first, _)) = dabs[done.len()..].split_first() {
        let together = if level == 0 { there(object, &dabs[done.len()..])? } else { None };
        match together {
            Some(reports) => done.extend(reports),
            None => done.push(object.dab(context, first, start, level)?),
        }
    }
    Ok(done)
}
