//! A deformable triangle mesh: its points, its displacement, the colours painted on it, and an affine transform to the
//! world. Displacement is in object units.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_document::{self as document, Document, Kind};
use relievo_gpu::Device;
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::triangle::{
    FaceRates, Offset, TriangleBlock, TriangleChange, TriangleChannel, TriangleDisplaced, TriangleField,
    TriangleNormals, TrianglePiece, TriangleSnapshot,
};
use relievo_tiles::{ByFormat, Mark, Rgba8, Rgba16, StoredTexel, Texel, Trace, Vector, by_format};

use super::device::TriangleDevice;
use crate::channels::fading::DecayingObject;
use crate::channels::layered::{LayeredObject, Layers, LayersOf, Stored};
use crate::channels::layers::Stack;
use crate::geometry::hierarchy::{Bounds, Hierarchy, Region};
use crate::geometry::obb::Obb;
use crate::object::ranges::{Ranges, widest};
use crate::object::transform::check_transform;

/// Displacements that dabs go by: along the normals, and in object space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleGround<'a> {
    pub heights: &'a TriangleField,
    pub vectors: Option<&'a TriangleField<Offset>>,
}

/// A displaced triangle mesh in the world.
#[derive(Debug)]
pub struct TriangleObject {
    pub(super) surface: TriangleSurface,
    /// Its displacement and its colours.
    pub(super) layers: LayersOf<Self>,
    pub(super) traces: Option<TriangleChannel<Trace>>,
    pub(super) vectors: Option<TriangleChannel<Vector>>,
    /// The vectors in object space, as they were renewed or edited last, and no less than the longest.
    pub(super) offsets: Option<(TriangleField<Offset>, f32)>,
    pub(super) normals: TriangleNormals,
    pub(super) transform: DAffine3,
    pub(super) hierarchy: Hierarchy,
    obb: Obb,
    /// The least and the largest displacement, 0 between them; `None` where it has to be measured.
    reach: Option<[f32; 2]>,
    ranges: Ranges,
    /// Whether the vectors in object space are to be made anew.
    bent: bool,
    /// Faces whose normals are to be renewed; `None` for all.
    stale: Option<Vec<u32>>,
    level: u32,
    /// What makes dabs in place of the processor, and why it stopped to.
    pub(super) device: Option<TriangleDevice>,
    pub(super) device_fault: Option<Error>,
}

impl TriangleObject {
    /// Puts `surface` and its `displacement` into the world.
    ///
    /// # Errors
    /// Fails with `Invalid` if the displacement has another number of faces or vertices than the mesh, or the transform
    /// is not finite or cannot be undone.
    pub fn new(
        context: &Context,
        surface: TriangleSurface,
        displacement: TriangleChannel,
        transform: DAffine3,
    ) -> Result<Self> {
        TriangleDisplaced::new(&surface, displacement.field())?;
        check_transform(&transform)?;
        let obb = Obb::of_points(surface.points())?;
        let hierarchy = context.stats().time("object.hierarchy", || {
            Hierarchy::build(context, surface.topology().face_count(), |face| bounds(&surface, face))
        })?;
        let normals = TriangleNormals::new(surface.topology(), displacement.field().pattern());
        Ok(Self {
            layers: Layers::new(displacement),
            traces: None,
            vectors: None,
            offsets: None,
            surface,
            normals,
            transform,
            hierarchy,
            obb,
            reach: None,
            ranges: Ranges::default(),
            bent: false,
            stale: None,
            level: 0,
            device: None,
            device_fault: None,
        })
    }

    /// Moves the points of the mesh. Displacements stay.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there are not as many points as the mesh has or one is not finite.
    /// Where a device fails, the processor takes over instead, see [`Self::take_device_fault`].
    pub fn pose(&mut self, context: &Context, points: &[[f32; 3]]) -> Result<()> {
        let surface = self.surface.posed(context, points)?;
        self.obb = Obb::of_points(points)?;
        let hierarchy = &mut self.hierarchy;
        context.stats().time("object.refit", || hierarchy.refit(context, |face| bounds(&surface, face)));
        self.surface = surface;
        self.pose_on_device();
        self.bent = true;
        self.stale = None;
        Ok(())
    }

    /// The mesh without its displacement.
    pub fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    /// The displacement.
    pub fn displacement(&self) -> &TriangleChannel {
        self.layers.displacement.composite()
    }

    /// The displacement, to be written.
    pub fn displacement_mut(&mut self) -> &mut TriangleChannel {
        self.reach = None;
        self.ranges.forget();
        self.stale = None;
        self.layers.displacement.composite_mut()
    }

    /// The colours painted on it, of either format, if it can be painted.
    pub fn colors(&self) -> Option<ByFormat<&TriangleField<Rgba8>, &TriangleField<Rgba16>>> {
        self.layers.color_fields()
    }

    /// The colours painted on it, if it can be painted with those of 8 bits.
    pub fn paint(&self) -> Option<&TriangleChannel<Rgba8>> {
        self.layers.paints().0
    }

    /// The colours of 8 bits, to be written.
    pub fn paint_mut(&mut self) -> Option<&mut TriangleChannel<Rgba8>> {
        self.layers.paints_mut().0
    }

    /// As [`Self::paint`], of half floats.
    pub fn half_paint(&self) -> Option<&TriangleChannel<Rgba16>> {
        self.layers.paints().1
    }

    /// As [`Self::paint_mut`], of half floats.
    pub fn half_paint_mut(&mut self) -> Option<&mut TriangleChannel<Rgba16>> {
        self.layers.paints_mut().1
    }

    /// Makes the object one that can be painted with colours of 8 bits, in place of those it may have.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if the colours have another number of faces or vertices than the
    /// mesh, and with the error of the page store if a block cannot be read from its page or written to one. Fails with
    /// `Memory` if edits fade and the budget of stamps does not hold the vertices; the object has the colours then,
    /// which do not fade.
    pub fn set_paint(&mut self, mut paint: TriangleChannel<Rgba8>) -> Result<()> {
        self.check_mesh(paint.field().topology(), "colours")?;
        self.page(&mut paint)?;
        self.layers.set_colors(ByFormat::Rgba8(paint));
        self.fade_own()
    }

    /// As [`Self::set_paint`] with colours of half floats, which may be brighter than 1.
    ///
    /// # Errors
    /// Fails as [`Self::set_paint`].
    pub fn set_half_paint(&mut self, mut paint: TriangleChannel<Rgba16>) -> Result<()> {
        self.check_mesh(paint.field().topology(), "colours")?;
        self.page(&mut paint)?;
        self.layers.set_colors(ByFormat::Rgba16(paint));
        self.fade_own()
    }

    /// The traces that imprints leave, if they are to leave any.
    pub fn traces(&self) -> Option<&TriangleChannel<Trace>> {
        self.traces.as_ref()
    }

    /// The traces, to be written.
    pub fn traces_mut(&mut self) -> Option<&mut TriangleChannel<Trace>> {
        self.traces.as_mut()
    }

    /// Makes imprints leave traces.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if the traces have another number of faces or vertices than the mesh,
    /// and with the error of the page store if a block cannot be read from its page or written to one.
    pub fn set_traces(&mut self, mut traces: TriangleChannel<Trace>) -> Result<()> {
        self.check_mesh(traces.field().topology(), "traces")?;
        self.page(&mut traces)?;
        self.traces = Some(traces);
        Ok(())
    }

    /// The layer of a document that is called `name`.
    fn channel<T: StoredTexel>(
        &self,
        context: &Context,
        document: &Document,
        name: &str,
        budget: u64,
    ) -> Result<Option<TriangleChannel<T>>> {
        let topology = self.surface.topology().clone();
        TriangleChannel::stored_with(context, topology, document, name, budget, self.page_store())
    }

    /// A channel of an object that pages does as well.
    fn page<T: Texel>(&self, channel: &mut TriangleChannel<T>) -> Result<()> {
        match (self.page_store(), channel.page_store()) {
            (Some(own), Some(other)) if Arc::ptr_eq(own, other) => Ok(()),
            (Some(own), _) => channel.page_to(Some(own.clone())),
            (None, _) => Ok(()),
        }
    }

    fn check_mesh(&self, other: &TriangleTopology, what: &str) -> Result<()> {
        let own = self.surface.topology();
        if (own.face_count(), own.vertex_count()) == (other.face_count(), other.vertex_count()) {
            return Ok(());
        }
        Err(Error::invalid(format!("the {what} are those of another mesh"))
            .advise(format!("make the {what} from the topology of this surface")))
    }

    /// The vector displacement, which comes after the scalar one, if it has one.
    pub fn vectors(&self) -> Option<&TriangleChannel<Vector>> {
        self.vectors.as_ref()
    }

    /// The vector displacement, to be written. What is shown follows when the object is committed.
    pub fn vectors_mut(&mut self) -> Option<&mut TriangleChannel<Vector>> {
        self.bent = true;
        self.stale = None;
        self.vectors.as_mut()
    }

    /// The vectors in object space and the length of the longest, as they were renewed last, see [`Self::renew`].
    pub fn offsets(&self) -> Option<&(TriangleField<Offset>, f32)> {
        self.offsets.as_ref()
    }

    /// Makes the vectors visible to readers, as [`Self::commit`] does the displacement, and brings normals up to date.
    ///
    /// # Errors
    /// Fails as [`Self::renew`].
    pub fn commit_vectors(&mut self, context: &Context) -> Result<Option<Arc<TriangleSnapshot<Vector>>>> {
        self.renew(context)?;
        Ok(self.vectors.as_mut().map(TriangleChannel::commit))
    }

    /// Gives the object a vector displacement.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if it has another number of faces or vertices than the mesh, and with
    /// the error of the page store if a block cannot be read from its page or written to one.
    pub fn set_vectors(&mut self, mut vectors: TriangleChannel<Vector>) -> Result<()> {
        self.check_mesh(vectors.field().topology(), "vectors")?;
        self.page(&mut vectors)?;
        self.vectors = Some(vectors);
        self.bent = true;
        self.stale = None;
        Ok(())
    }

    /// Makes everything that was sculpted up to now visible to readers, and brings normals up to date.
    ///
    /// # Errors
    /// Fails as [`Self::renew`].
    pub fn commit(&mut self, context: &Context) -> Result<Arc<TriangleSnapshot>> {
        self.renew(context)?;
        Ok(self.layers.displacement.composite_mut().commit())
    }

    /// Which level dabs edit: 0 for T segments an edge, 1 for half and 2 for a quarter of them.
    pub fn level(&self) -> u32 {
        self.level
    }

    /// Makes dabs edit another level. What finer levels have more stays when a coarser one is edited.
    ///
    /// # Errors
    /// Fails with `Invalid` unless the level is 0 to 2.
    pub fn set_level(&mut self, level: u32) -> Result<()> {
        if level > 2 {
            return Err(Error::invalid(format!("there is no level {level}")).advise("use 0, 1 or 2"));
        }
        self.level = level;
        Ok(())
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

    /// The box of the mesh without its scalar displacement in the world, enlarged by `margin` object units.
    pub fn obb(&self, margin: f64) -> Obb {
        self.obb.enlarged(margin + f64::from(self.vector_reach())).transformed(&self.transform)
    }

    /// The displaced mesh.
    ///
    /// # Errors
    /// Fails with `Invalid` only if [`Self::displacement_mut`] or [`Self::vectors_mut`] was given a displacement of
    /// another mesh.
    pub fn displaced(&self) -> Result<TriangleDisplaced<'_>> {
        self.displaced_by(self.ground())
    }

    /// The mesh with other displacements.
    pub(super) fn displaced_by<'a>(&'a self, ground: TriangleGround<'a>) -> Result<TriangleDisplaced<'a>> {
        let displaced = TriangleDisplaced::new(&self.surface, ground.heights)?;
        ground.vectors.map_or(Ok(displaced), |vectors| displaced.with_vectors(vectors))
    }

    /// The displacements as they are.
    pub(crate) fn ground(&self) -> TriangleGround<'_> {
        let vectors = self.offsets.as_ref().map(|(offsets, _)| offsets);
        TriangleGround { heights: self.displacement().field(), vectors }
    }

    /// The length of the longest vector.
    pub(super) fn vector_reach(&self) -> f32 {
        self.offsets.as_ref().map_or(0.0, |(_, longest)| *longest)
    }

    /// The normals as they were renewed last, see [`Self::renew`].
    pub fn normals(&self) -> &TriangleNormals {
        &self.normals
    }

    /// Whether a face has a block of displacement or of colours.
    pub fn is_allocated(&self, face: u32) -> bool {
        self.displacement().field().is_allocated(face)
            || self.colors().is_some_and(|colors| by_format!(colors, field => field.is_allocated(face)))
            || self.traces.as_ref().is_some_and(|traces| traces.field().is_allocated(face))
    }

    /// How finely a face has to be divided to show all that is on it.
    pub fn rates(&self, face: u32) -> FaceRates {
        let rates = FaceRates::of(self.displacement().field(), face);
        let vectors = self.vectors.as_ref();
        let rates = vectors.map_or(rates, |vectors| rates.with(FaceRates::of(vectors.field(), face)));
        let traces = self.traces.as_ref();
        let rates = traces.map_or(rates, |traces| rates.with(FaceRates::of(traces.field(), face)));
        self.colors().map_or(rates, |colors| by_format!(colors, field => rates.with(FaceRates::of(field, face))))
    }

    /// The triangles of a face and the colours at their corners, linear Rec.709 with alpha; none if it has no paint.
    ///
    /// # Errors
    /// Fails as [`Self::displaced`].
    pub fn piece(&self, face: u32) -> Result<(TrianglePiece, Vec<[f32; 4]>)> {
        let rates = self.rates(face);
        let piece = TrianglePiece::new(&self.displaced()?, &self.normals, face, &rates);
        let colors = self.colors().map(|colors| {
            let values = by_format!(colors, field => TrianglePiece::values(field, face, &rates));
            values.into_iter().map(|value| value.as_vec4().to_array()).collect()
        });
        Ok((piece, colors.unwrap_or_default()))
    }

    /// Brings the vectors in object space up to date.
    pub(super) fn renew_vectors(&mut self, context: &Context) {
        if let (Some(vectors), true) = (&self.vectors, std::mem::take(&mut self.bent)) {
            let offsets = vectors.field().in_object_space(context, &self.surface);
            let faces = offsets.allocated().filter_map(|face| offsets.face(face));
            let edges = offsets.allocated_edges().filter_map(|edge| offsets.edge(edge));
            let reach = faces.chain(edges).chain(offsets.vertices()).map(longest).fold(0.0, f32::max);
            self.offsets = Some((offsets, reach));
        }
    }

    /// What traces say at the corners of the triangles of a face, see [`Self::piece`]; nothing if it keeps none.
    pub fn marks(&self, face: u32) -> Vec<Mark> {
        let Some(traces) = &self.traces else { return Vec::new() };
        let places = self.rates(face).places().into_iter();
        places.map(|(pattern, node)| traces.field().mark(face, pattern, node)).collect()
    }

    /// Brings the normals up to date.
    ///
    /// # Errors
    /// Fails as [`Self::displaced`].
    pub fn renew(&mut self, context: &Context) -> Result<()> {
        self.renew_vectors(context);
        let lost = self.displacement().lost().to_vec();
        self.note_shown(&lost);
        let displaced = TriangleDisplaced::new(&self.surface, self.layers.displacement.composite().field())?;
        let displaced = match &self.offsets {
            Some((offsets, _)) => displaced.with_vectors(offsets)?,
            None => displaced,
        };
        match self.stale.replace(Vec::new()) {
            Some(faces) if faces.is_empty() => {}
            Some(mut faces) => {
                faces.sort_unstable();
                faces.dedup();
                context.stats().time("object.normals", || self.normals.update(context, &displaced, &faces));
            }
            None => {
                self.normals = context.stats().time("object.normals", || TriangleNormals::of(context, &displaced))?
            }
        }
        Ok(())
    }

    /// Notes that faces look different now.
    pub(super) fn touch(&mut self, faces: &[u32]) {
        if let Some(stale) = &mut self.stale {
            stale.extend_from_slice(faces);
        }
    }

    /// Bounds of the displacement, 0 between them: the least and the largest there is, and those there were since the last
    /// imprint or motion began.
    pub fn reach(&mut self) -> [f32; 2] {
        self.reach.unwrap_or_else(|| self.measure())
    }

    /// Finds the least and the largest displacement there is, as [`crate::DisplacedObject`] does.
    pub(crate) fn measure(&mut self) -> [f32; 2] {
        let field = self.layers.displacement.composite().field();
        let faces = field.allocated().map(|face| (face, field.version(face)));
        let faces = self.ranges.of(faces, |face| field.range(TriangleBlock::Face(face)).unwrap_or_default());
        *self.reach.insert(widest(faces, range_between(field)))
    }

    /// Notes that displacements now reach from `least` to `most`.
    pub(super) fn widen(&mut self, [least, most]: [f32; 2]) {
        if let Some(reach) = &mut self.reach {
            *reach = [reach[0].min(least), reach[1].max(most)];
        }
    }

    /// Faces that may be in `obb`, displaced as they are or as they were with `start`, ascending.
    pub(super) fn faces_near(&self, context: &Context, obb: &Obb, start: Option<TriangleGround<'_>>) -> Vec<u32> {
        let map = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let field = self.displacement().field();
        let [least, most] = self.reach.unwrap_or_else(|| range(field));
        let rows = [0, 1, 2].map(|axis| map.matrix3.row(axis));
        let stretch = DVec3::from(rows.map(|row| row.length()));
        let margin = stretch * f64::from(most.max(-least) + self.vector_reach());
        let mut faces = Vec::new();
        self.hierarchy.query(context, &Region::new(map, -obb.half - margin, obb.half + margin), &mut faces);
        if margin != DVec3::ZERO {
            // Most faces are displaced by less than some face is.
            faces.retain(|face| {
                let corners =
                    self.surface.corner_points(*face).map(|p| map.transform_point3(DVec3::from(p.map(f64::from))));
                let low = corners[0].min(corners[1]).min(corners[2]);
                let high = corners[0].max(corners[1]).max(corners[2]);
                let is_near = |reach: f32| {
                    let far = stretch * f64::from(reach) + obb.half * (1.0 + 1e-9);
                    low.cmple(far).all() && high.cmpge(-far).all()
                };
                // Few faces are near only by what displaces them.
                let reach = || self.ground().reach(*face).max(start.map_or(0.0, |start| start.reach(*face)));
                is_near(0.0) || is_near(reach())
            });
        }
        faces.sort_unstable();
        faces
    }
}

impl LayeredObject for TriangleObject {
    type Displacement = TriangleChannel;
    type Paint = TriangleChannel<Rgba8>;
    type HalfPaint = TriangleChannel<Rgba16>;
    type Traces = TriangleChannel<Trace>;
    type Vectors = TriangleChannel<Vector>;

    fn device_in_use(&self) -> Option<&Device> {
        self.device.as_ref().map(TriangleDevice::device)
    }

    fn lose_device(&mut self, fault: Error) {
        (self.device, self.device_fault) = (None, Some(fault));
    }

    fn note_shown(&mut self, faces: &[u32]) {
        let topology = self.surface.topology();
        let vertices = faces.iter().flat_map(|face| topology.face(*face)).collect();
        let shown = TriangleChange { vertices, ..Default::default() }.faces_shown(topology);
        self.touch(&shown);
    }

    fn stacks(&self) -> &LayersOf<Self> {
        &self.layers
    }

    fn stacks_mut(&mut self) -> &mut LayersOf<Self> {
        &mut self.layers
    }

    fn heights_mut(&mut self) -> &mut Stack<TriangleChannel> {
        self.displacement_mut();
        &mut self.layers.displacement
    }

    fn others(&self) -> (Option<&Self::Traces>, Option<&Self::Vectors>) {
        (self.traces.as_ref(), self.vectors.as_ref())
    }

    fn others_mut(&mut self) -> (Option<&mut Self::Traces>, Option<&mut Self::Vectors>) {
        self.bent = true;
        self.stale = None;
        (self.traces.as_mut(), self.vectors.as_mut())
    }

    fn stored(
        &self,
        context: &Context,
        document: &Document,
        layer: &document::Layer,
        budget: u64,
    ) -> Result<Option<Stored<Self>>> {
        let (own, name) = (self, layer.name());
        Ok(match layer.kind() {
            Kind::Scalar => own.channel(context, document, name, budget)?.map(Stored::Displacement),
            Kind::Rgba8 => own.channel(context, document, name, budget)?.map(Stored::Paint),
            Kind::Trace => own.channel(context, document, name, budget)?.map(Stored::Traces),
            Kind::Vector => own.channel(context, document, name, budget)?.map(Stored::Vectors),
            Kind::Rgba16 => own.channel(context, document, name, budget)?.map(Stored::HalfPaint),
            Kind::Stamps => None,
        })
    }

    fn set_channel(&mut self, channel: Stored<Self>) -> Result<()> {
        match channel {
            Stored::Displacement(displacement) => {
                self.check_mesh(displacement.field().topology(), "values")?;
                *self.displacement_mut() = displacement;
            }
            Stored::Paint(paint) => self.set_paint(paint)?,
            Stored::HalfPaint(paint) => self.set_half_paint(paint)?,
            Stored::Traces(traces) => self.set_traces(traces)?,
            Stored::Vectors(vectors) => self.set_vectors(vectors)?,
        }
        Ok(())
    }
}

impl TriangleGround<'_> {
    /// How far a face is displaced at most.
    pub fn reach(&self, face: u32) -> f32 {
        let [least, most] = field_range(self.heights, face);
        most.max(-least) + self.vectors.map_or(0.0, |vectors| field_length(vectors, face))
    }
}

/// The length of the longest of some vectors.
pub(super) fn longest(values: &[Offset]) -> f32 {
    values.iter().map(|value| Vec3::from(value.0).length()).fold(0.0, f32::max)
}

/// The length of the longest vector in and around a face.
pub(crate) fn field_length(field: &TriangleField<Offset>, face: u32) -> f32 {
    let topology = field.topology();
    let corners = topology.face(face).map(|vertex| field.vertex(vertex));
    let blocks = topology.edges_of(face).map(|edge| field.edge(edge)).into_iter().chain([field.face(face)]);
    blocks.flatten().map(longest).fold(longest(&corners), f32::max)
}

/// The least and the largest value in and around a face, 0 between them.
pub(crate) fn field_range(field: &TriangleField, face: u32) -> [f32; 2] {
    let topology = field.topology();
    let with = |sum: [f32; 2], range: [f32; 2]| [sum[0].min(range[0]), sum[1].max(range[1])];
    let corners = topology.face(face).map(|vertex| field.vertex(vertex));
    let sum = with([0.0; 2], crate::object::ranges::range(&corners));
    let blocks = topology.edges_of(face).map(TriangleBlock::Edge).into_iter().chain([TriangleBlock::Face(face)]);
    blocks.filter_map(|block| field.range(block)).fold(sum, with)
}

/// The least and the largest value of all, 0 between them.
fn range(field: &TriangleField) -> [f32; 2] {
    let faces = field.allocated().filter_map(|face| field.range(TriangleBlock::Face(face)));
    faces.fold(range_between(field), widest)
}

/// The same of what lies on edges and at vertices.
fn range_between(field: &TriangleField) -> [f32; 2] {
    let edges = field.allocated_edges().filter_map(|edge| field.range(TriangleBlock::Edge(edge)));
    edges.chain(field.vertices().map(crate::object::ranges::range)).fold([0.0; 2], widest)
}

fn bounds(surface: &TriangleSurface, face: u32) -> Bounds {
    Bounds::of_points(&surface.corner_points(face))
}
