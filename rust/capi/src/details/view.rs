//! A detail as it was committed last, for any number of readers: of a Catmull-Clark surface or of a triangle mesh.

use std::sync::Arc;

use glam::{DAffine3, DVec4, Vec3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{DecayingObject, DisplacedObject, LayeredObject, TriangleObject};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::displaced::Points;
use relievo_tiles::trace::{Mark, Trace};
use relievo_tiles::triangle::{
    FaceRates, Offset, TriangleBlock, TriangleChannel, TriangleDisplaced, TriangleField, TriangleNormals,
    TriangleSnapshot, foot_at,
};
use relievo_tiles::{
    ByFormat, Channel, ColorTexel, Displaced, Field, Folds, Rgba8, Rgba16, Snapshot, Texel, Vector, by_format,
};

use crate::details::detail::{
    RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT, RLV_CHANNEL_TRACES, RLV_CHANNEL_VECTORS, missing,
};
use crate::surfaces::shape::{Shape, barycentric, only_cages, union};

/// How many channels a detail may have.
pub const CHANNELS: usize = 4;

/// A detail as it was committed last. It never changes while somebody looks at it.
pub struct View {
    pub layers: ViewKind,
    /// The mesh the surface was made from, with its attributes.
    pub cage: Arc<Mesh>,
    /// When edits were made, in seconds.
    pub time: f64,
    /// Tiles that changed with the commit, ascending.
    pub changed: Vec<u32>,
    pub transform: DAffine3,
    /// How often the cage was posed before.
    pub pose: u64,
    /// Bytes of every channel with all its tiles, and its budget.
    pub limits: [[u64; 2]; CHANNELS],
    /// Bytes of the time stamps of edits that fade.
    pub stamp_bytes: u64,
}

/// What was committed of every channel.
pub enum ViewKind {
    Tiles(TileView),
    Triangles(TriangleView),
}

/// Of a Catmull-Clark surface.
#[derive(Clone)]
pub struct TileView {
    pub surface: Surface,
    /// How the surface was made.
    pub options: SurfaceOptions,
    pub snapshot: Arc<Snapshot>,
    /// Colours, if the detail has any.
    pub paint: Option<ByFormat<Arc<Snapshot<Rgba8>>, Arc<Snapshot<Rgba16>>>>,
    pub vectors: Option<Arc<Snapshot<Vector>>>,
    pub traces: Option<Arc<Snapshot<Trace>>>,
}

/// Of a triangle mesh.
pub struct TriangleView {
    pub surface: Arc<TriangleSurface>,
    pub snapshot: Arc<TriangleSnapshot>,
    pub paint: Option<ByFormat<Arc<TriangleSnapshot<Rgba8>>, Arc<TriangleSnapshot<Rgba16>>>>,
    pub vectors: Option<Arc<TriangleSnapshot<Vector>>>,
    pub traces: Option<Arc<TriangleSnapshot<Trace>>>,
    /// The vectors in object space, and the longest.
    pub offsets: Option<(TriangleField<Offset>, f32)>,
    pub normals: TriangleNormals,
}

/// A tile of any channel.
pub struct TileState {
    pub is_allocated: bool,
    pub size: u32,
    pub version: u64,
    pub block_bytes: u64,
    pub block: Option<Vec<u8>>,
}

/// A channel.
#[derive(Default)]
pub struct ChannelState {
    pub allocated: usize,
    pub paged: usize,
    pub bytes: u64,
    pub texel_size: usize,
}

/// What is at places.
#[derive(Default)]
pub struct Looked {
    pub points: Points,
    pub displacements: Vec<f32>,
    pub vectors: Vec<[f32; 3]>,
    pub marks: Vec<Mark>,
    pub colors: Vec<Vec4>,
    /// Where points are evaluated, and without vectors.
    canonical: Vec<Place>,
    without: Points,
}

/// What is wanted there besides points.
#[derive(Clone, Copy, Default)]
pub struct Wanted {
    pub displacements: bool,
    pub vectors: bool,
    pub marks: bool,
    pub colors: bool,
}

impl TileState {
    /// With its bytes if they are `wanted`.
    fn of<T: Texel>(field: &Field<T>, tile: u32, wanted: bool) -> Result<Self> {
        let block = if wanted { field.try_block(tile)? } else { None };
        Ok(Self {
            is_allocated: field.is_allocated(tile),
            size: field.size(tile),
            version: field.version(tile),
            block_bytes: field.block_bytes(tile),
            block: block.map(|block| bytemuck::cast_slice(block).to_vec()),
        })
    }

    /// Of a face, which is kept with its edges.
    fn of_face<T: Texel>(field: &TriangleField<T>, face: u32) -> Self {
        let pattern = field.face_pattern(face).unwrap_or(field.pattern());
        Self {
            is_allocated: field.is_allocated(face),
            size: pattern.segments(),
            version: field.version(face),
            block_bytes: (pattern.face_values() * size_of::<T>()) as u64,
            block: None,
        }
    }
}

impl TileView {
    /// The surface with its displacement.
    ///
    /// # Errors
    /// Fails only as [`Displaced::new`] does, if a layer were of another cage than the surface.
    pub fn displaced(&self) -> Result<Displaced<'_>> {
        let displaced = Displaced::new(&self.surface, self.snapshot.field())?;
        match &self.vectors {
            Some(vectors) => displaced.with_vectors(vectors.field()),
            None => Ok(displaced),
        }
    }

    /// Texels along an edge of the cage at `tile`, the most of what is allocated there.
    pub fn density(&self, tile: u32) -> u32 {
        let paint = self.paint.as_ref().map_or(0, |paint| by_format!(paint, it => it.field().density(tile)));
        let vectors = self.vectors.as_ref().map_or(0, |vectors| vectors.field().density(tile));
        let traces = self.traces.as_ref().map_or(0, |traces| traces.field().density(tile));
        self.snapshot.field().density(tile).max(paint).max(vectors).max(traces)
    }

    /// The numbers of the edits that changed `tile` last, by channel.
    pub fn versions(&self, tile: u32) -> [u64; CHANNELS] {
        [
            self.snapshot.field().version(tile),
            self.paint.as_ref().map_or(0, |paint| by_format!(paint, it => it.field().version(tile))),
            self.vectors.as_ref().map_or(0, |vectors| vectors.field().version(tile)),
            self.traces.as_ref().map_or(0, |traces| traces.field().version(tile)),
        ]
    }

    /// Makes `tiles` the tiles that may be others than in `before`, of the same surface, ascending: all that are not
    /// listed are the same memory in every channel.
    pub fn touched(&self, before: &TileView, tiles: &mut Vec<u32>) {
        fn touched<T: Texel>(new: Option<&Arc<Snapshot<T>>>, old: Option<&Arc<Snapshot<T>>>, tiles: &mut Vec<u32>) {
            match (new, old) {
                (Some(new), Some(old)) => tiles.extend(new.field().touched(old.field())),
                (Some(one), None) | (None, Some(one)) => tiles.extend(one.field().allocated()),
                (None, None) => {}
            }
        }
        tiles.clear();
        touched(Some(&self.snapshot), Some(&before.snapshot), tiles);
        match (&self.paint, &before.paint) {
            (Some(ByFormat::Rgba8(new)), Some(ByFormat::Rgba8(old))) => touched(Some(new), Some(old), tiles),
            (Some(ByFormat::Rgba16(new)), Some(ByFormat::Rgba16(old))) => touched(Some(new), Some(old), tiles),
            (new, old) => {
                for paint in [new, old].into_iter().flatten() {
                    by_format!(paint, it => touched(Some(it), None, tiles));
                }
            }
        }
        touched(self.vectors.as_ref(), before.vectors.as_ref(), tiles);
        touched(self.traces.as_ref(), before.traces.as_ref(), tiles);
        tiles.sort_unstable();
        tiles.dedup();
    }

    /// Makes `seen` the tiles in which other colours may be seen than in `before`, of which `changed` are others; false
    /// if it had none, or of another format, so that all are.
    pub fn seen(&self, before: &TileView, changed: &[u32], seen: &mut Vec<u32>) -> bool {
        match (&self.paint, &before.paint) {
            (Some(ByFormat::Rgba8(new)), Some(ByFormat::Rgba8(old))) => new.seen_from(old, changed, seen),
            (Some(ByFormat::Rgba16(new)), Some(ByFormat::Rgba16(old))) => new.seen_from(old, changed, seen),
            (None, None) => refill(seen, changed.iter().copied()),
            _ => return false,
        }
        true
    }

    fn look(
        &self,
        context: &Context,
        places: &[Place],
        footprints: Option<&[[[f32; 2]; 2]]>,
        wanted: Wanted,
        out: &mut Looked,
    ) -> Result<()> {
        let (displaced, field) = (self.displaced()?, self.snapshot.field());
        displaced.evaluate(context, places, &mut out.points)?;
        if wanted.displacements {
            let height = |place: &Place| field.point(context.level(), field.canonical(*place)).d;
            refill(&mut out.displacements, places.iter().map(height));
        }
        if wanted.vectors {
            // What the vectors add, where the whole is evaluated.
            refill(&mut out.canonical, places.iter().map(|place| displaced.canonical(*place)));
            let without = &mut out.without;
            Displaced::new(&self.surface, field)?.evaluate_in_place(context, &out.canonical, without)?;
            let pairs = without.p.iter().zip(&out.points.p);
            refill(&mut out.vectors, pairs.map(|(from, to)| [0, 1, 2].map(|axis| to[axis] - from[axis])));
        }
        if let (true, Some(traces)) = (wanted.marks, self.traces.as_ref().map(|traces| traces.field())) {
            refill(&mut out.marks, places.iter().map(|place| traces.mark(traces.canonical(*place))));
        }
        if let (true, Some(paint)) = (wanted.colors, &self.paint) {
            by_format!(paint, it => colors(context, it.field(), places, footprints, &mut out.colors))?;
        }
        Ok(())
    }
}

/// Colours at places, as means over as many footprints, if there are any.
fn colors<T: ColorTexel>(
    context: &Context,
    paint: &Field<T>,
    places: &[Place],
    footprints: Option<&[[[f32; 2]; 2]]>,
    colors: &mut Vec<Vec4>,
) -> Result<()> {
    let Some(footprints) = footprints else {
        refill(colors, places.iter().map(|place| paint.color(paint.canonical(*place))));
        return Ok(());
    };
    refill(colors, places.iter().map(|_| Vec4::ZERO));
    context.for_each_part((places, footprints, colors.as_mut_slice()), CHUNK, |_, (places, footprints, colors)| {
        paint.filtered_many(places, footprints, colors);
        Ok(())
    })
}

/// Puts `values` in the place of those in `list`, whose room is used again.
fn refill<T>(list: &mut Vec<T>, values: impl Iterator<Item = T>) {
    list.clear();
    list.extend(values);
}

impl TriangleView {
    /// The mesh with its displacement.
    ///
    /// # Errors
    /// Fails only as [`TriangleDisplaced::new`] does, if a layer were of another mesh than the surface.
    pub fn displaced(&self) -> Result<TriangleDisplaced<'_>> {
        let displaced = TriangleDisplaced::new(&self.surface, self.snapshot.field())?;
        self.offsets.as_ref().map_or(Ok(displaced), |(offsets, _)| displaced.with_vectors(offsets))
    }

    /// How finely a face has to be divided to show all that is on it.
    pub fn rates(&self, face: u32) -> FaceRates {
        let mut rates = FaceRates::of(self.snapshot.field(), face);
        let others = [
            self.paint.as_ref().map(|paint| by_format!(paint, it => FaceRates::of(it.field(), face))),
            self.vectors.as_ref().map(|vectors| FaceRates::of(vectors.field(), face)),
            self.traces.as_ref().map(|traces| FaceRates::of(traces.field(), face)),
        ];
        for other in others.into_iter().flatten() {
            rates = rates.with(other);
        }
        rates
    }

    /// The faces that look different than in `before`, ascending.
    pub fn shown(&self, before: &TriangleView) -> Vec<u32> {
        fn shown<T: Texel>(new: &TriangleSnapshot<T>, old: Option<&Arc<TriangleSnapshot<T>>>) -> Vec<u32> {
            let topology = new.topology();
            match old {
                Some(old) => new.changes(old).faces_shown(topology),
                None => TriangleBlock::change(topology, new.blocks()).faces_shown(topology),
            }
        }
        let mut faces = shown(&self.snapshot, Some(&before.snapshot));
        faces.extend(match (&self.paint, &before.paint) {
            (Some(ByFormat::Rgba8(new)), Some(ByFormat::Rgba8(old))) => shown(new, Some(old)),
            (Some(ByFormat::Rgba16(new)), Some(ByFormat::Rgba16(old))) => shown(new, Some(old)),
            (Some(new), _) => by_format!(new, it => shown(it, None)),
            _ => Vec::new(),
        });
        faces.extend(self.vectors.iter().flat_map(|new| shown(new, before.vectors.as_ref())));
        faces.extend(self.traces.iter().flat_map(|new| shown(new, before.traces.as_ref())));
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// Conservative bounds of a displaced face.
    fn bounds(&self, displaced: &TriangleDisplaced<'_>, face: u32) -> ([f32; 3], [f32; 3]) {
        let [least, most] = displaced.range(face);
        let far = most.max(-least) + self.offsets.as_ref().map_or(0.0, |(_, longest)| *longest);
        let corners = self.surface.corner_points(face);
        let (low, high) = corners.iter().map(|point| (*point, *point)).reduce(union).unwrap_or_default();
        (low.map(|value| value - far), high.map(|value| value + far))
    }

    fn look(&self, context: &Context, places: &[Place], wanted: Wanted, out: &mut Looked) -> Result<()> {
        let mut points = context.scratch().lend::<Vec<(Vec3, Vec3, f32, Vec3)>>();
        points.clear();
        points.resize(places.len(), Default::default());
        context.for_each_part((places, points.as_mut_slice()), CHUNK, |_, (places, points)| {
            points.iter_mut().zip(places).for_each(|(point, place)| *point = self.point(place));
            Ok(())
        })?;
        refill(&mut out.points.p, points.iter().map(|(point, ..)| point.to_array()));
        refill(&mut out.points.normal, points.iter().map(|(_, normal, ..)| normal.to_array()));
        refill(&mut out.displacements, points.iter().map(|(.., height, _)| *height));
        refill(&mut out.vectors, points.iter().map(|(.., vector)| vector.to_array()));
        let at = |place: &Place| (place.tile, barycentric(place.u, place.v));
        if let (true, Some(traces)) = (wanted.marks, self.traces.as_ref().map(|traces| traces.field())) {
            refill(&mut out.marks, places.iter().map(at).map(|(face, at)| mark(traces.value(face, at))));
        }
        if let (true, Some(paint)) = (wanted.colors, &self.paint) {
            let color = |(face, at)| by_format!(paint, it => it.field().value(face, at)).as_vec4();
            refill(&mut out.colors, places.iter().map(at).map(color));
        }
        Ok(())
    }

    /// Position, normal, height and vector at a place.
    fn point(&self, place: &Place) -> (Vec3, Vec3, f32, Vec3) {
        let at = barycentric(place.u, place.v);
        let foot = foot_at(&self.surface, place.tile, at);
        let height = self.snapshot.field().value(place.tile, at) as f32;
        let vectors = self.offsets.as_ref();
        let vector = vectors.map_or(Vec3::ZERO, |(offsets, _)| offsets.value(place.tile, at).as_vec3());
        let normal = self.normals.value(foot.normal, place.tile, at);
        (foot.point + foot.normal * height + vector, normal, height, vector)
    }
}

/// What the interpolated value of traces says.
fn mark(value: DVec4) -> Mark {
    let time = (value.x > 0.0).then(|| (value.z / value.x) as f32);
    Mark { contact: value.x as f32, depth: value.y as f32, time }
}

/// What is committed of a channel, which adds its changed tiles and says how large it may be.
fn commit<T: Texel>(channel: &mut Channel<T>, changed: &mut Vec<u32>) -> (Arc<Snapshot<T>>, [u64; 2]) {
    let snapshot = channel.commit();
    changed.extend(snapshot.changed());
    (snapshot, [channel.full_bytes(), channel.budget()])
}

/// As [`commit`], of a channel that may not be there.
fn commit_some<T: Texel>(
    channel: Option<&mut Channel<T>>,
    changed: &mut Vec<u32>,
) -> (Option<Arc<Snapshot<T>>>, [u64; 2]) {
    let done = channel.map(|channel| commit(channel, changed));
    done.map_or((None, [0; 2]), |(snapshot, limits)| (Some(snapshot), limits))
}

/// The bytes of a channel with all its blocks, and its budget.
fn limits<T: Texel>(channel: Option<&TriangleChannel<T>>) -> [u64; 2] {
    channel.map_or([0; 2], |channel| [channel.full_bytes(), channel.budget()])
}

/// Places of one item of parallel work.
const CHUNK: usize = 1024;

impl View {
    /// The surface in the committed pose.
    pub fn shape(&self) -> Shape {
        match &self.layers {
            ViewKind::Tiles(view) => Shape::Tiles(view.surface.clone()),
            ViewKind::Triangles(view) => Shape::Triangles(view.surface.clone()),
        }
    }

    /// The tiles of a Catmull-Clark surface.
    ///
    /// # Errors
    /// Fails with `Unsupported`, naming `what` they are wanted for, on a triangle mesh.
    pub fn tiles(&self, what: &str) -> Result<&TileView> {
        match &self.layers {
            ViewKind::Tiles(view) => Ok(view),
            ViewKind::Triangles(_) => Err(only_cages(what)),
        }
    }

    pub fn has_paint(&self) -> bool {
        match &self.layers {
            ViewKind::Tiles(view) => view.paint.is_some(),
            ViewKind::Triangles(view) => view.paint.is_some(),
        }
    }

    pub fn has_traces(&self) -> bool {
        match &self.layers {
            ViewKind::Tiles(view) => view.traces.is_some(),
            ViewKind::Triangles(view) => view.traces.is_some(),
        }
    }

    /// A number that grows with every edit.
    pub fn revision(&self) -> u64 {
        fn tiles<T>(channel: &Option<Arc<Snapshot<T>>>) -> u64 {
            channel.as_ref().map_or(0, |channel| channel.revision())
        }
        fn faces<T>(channel: &Option<Arc<TriangleSnapshot<T>>>) -> u64 {
            channel.as_ref().map_or(0, |channel| channel.revision())
        }
        match &self.layers {
            ViewKind::Tiles(it) => {
                let paint = it.paint.as_ref().map_or(0, |paint| by_format!(paint, it => it.revision()));
                it.snapshot.revision() + paint + tiles(&it.vectors) + tiles(&it.traces)
            }
            ViewKind::Triangles(it) => {
                let paint = it.paint.as_ref().map_or(0, |paint| by_format!(paint, it => it.revision()));
                it.snapshot.revision() + paint + faces(&it.vectors) + faces(&it.traces)
            }
        }
    }

    /// A tile of a channel, with its bytes if they are `wanted`, which faces of triangle meshes do not have by
    /// themselves.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such tile or channel, with `Unsupported` if the bytes of a face of a
    /// triangle mesh are `wanted`, and with the error of the store if a page of the channel cannot be read.
    pub fn tile(&self, channel: u32, tile: u32, wanted: bool) -> Result<TileState> {
        self.shape().check_tile(tile)?;
        let state = match &self.layers {
            ViewKind::Tiles(it) => match channel {
                RLV_CHANNEL_DISPLACEMENT => Some(TileState::of(it.snapshot.field(), tile, wanted)?),
                RLV_CHANNEL_COLOR => match &it.paint {
                    Some(paint) => Some(by_format!(paint, it => TileState::of(it.field(), tile, wanted))?),
                    None => None,
                },
                RLV_CHANNEL_VECTORS => {
                    it.vectors.as_ref().map(|it| TileState::of(it.field(), tile, wanted)).transpose()?
                }
                RLV_CHANNEL_TRACES => {
                    it.traces.as_ref().map(|it| TileState::of(it.field(), tile, wanted)).transpose()?
                }
                _ => None,
            },
            ViewKind::Triangles(it) => match channel {
                RLV_CHANNEL_DISPLACEMENT => Some(TileState::of_face(it.snapshot.field(), tile)),
                RLV_CHANNEL_COLOR => {
                    it.paint.as_ref().map(|paint| by_format!(paint, it => TileState::of_face(it.field(), tile)))
                }
                RLV_CHANNEL_VECTORS => it.vectors.as_ref().map(|it| TileState::of_face(it.field(), tile)),
                RLV_CHANNEL_TRACES => it.traces.as_ref().map(|it| TileState::of_face(it.field(), tile)),
                _ => None,
            },
        };
        match (state, &self.layers) {
            (Some(_), ViewKind::Triangles(_)) if wanted => {
                Err(Error::unsupported("faces of triangle meshes have no blocks of their own")
                    .advise("keep the edits in a document"))
            }
            (state, _) => state.ok_or_else(|| missing(channel)),
        }
    }

    /// A channel; `None` if the detail does not have it.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such channel.
    pub fn channel(&self, channel: u32) -> Result<Option<ChannelState>> {
        fn tiles<T: Texel>(snapshot: &Arc<Snapshot<T>>) -> ChannelState {
            let field = snapshot.field();
            let allocated = field.allocated().count();
            let paged = field.allocated().filter(|tile| field.is_paged(*tile)).count();
            ChannelState { allocated, paged, bytes: snapshot.bytes(), texel_size: size_of::<T>() }
        }
        fn faces<T: Texel>(snapshot: &Arc<TriangleSnapshot<T>>) -> ChannelState {
            let field = snapshot.field();
            let allocated = field.allocated().count();
            let paged = field.allocated().filter(|face| field.is_paged(*face)).count();
            ChannelState { allocated, paged, bytes: snapshot.bytes(), texel_size: size_of::<T>() }
        }
        if channel as usize >= CHANNELS {
            return Err(missing(channel));
        }
        Ok(match (&self.layers, channel) {
            (ViewKind::Tiles(it), RLV_CHANNEL_COLOR) => {
                it.paint.as_ref().map(|paint| by_format!(paint, it => tiles(it)))
            }
            (ViewKind::Tiles(it), RLV_CHANNEL_VECTORS) => it.vectors.as_ref().map(tiles),
            (ViewKind::Tiles(it), RLV_CHANNEL_TRACES) => it.traces.as_ref().map(tiles),
            (ViewKind::Tiles(it), _) => Some(tiles(&it.snapshot)),
            (ViewKind::Triangles(it), RLV_CHANNEL_COLOR) => {
                it.paint.as_ref().map(|paint| by_format!(paint, it => faces(it)))
            }
            (ViewKind::Triangles(it), RLV_CHANNEL_VECTORS) => it.vectors.as_ref().map(faces),
            (ViewKind::Triangles(it), RLV_CHANNEL_TRACES) => it.traces.as_ref().map(faces),
            (ViewKind::Triangles(it), _) => Some(faces(&it.snapshot)),
        })
    }

    /// Conservative bounds of the displaced surface of `tiles`, which exist; `None` for no tiles.
    ///
    /// # Errors
    /// Fails only as [`TileView::displaced`] or [`TriangleView::displaced`] does.
    pub fn bounds(&self, tiles: &[u32]) -> Result<Option<([f32; 3], [f32; 3])>> {
        Ok(match &self.layers {
            ViewKind::Tiles(view) => {
                let displaced = view.displaced()?;
                tiles.iter().map(|tile| displaced.tile_bounds(*tile)).reduce(union)
            }
            ViewKind::Triangles(view) => {
                let displaced = view.displaced()?;
                tiles.iter().map(|face| view.bounds(&displaced, *face)).reduce(union)
            }
        })
    }

    /// Where the displaced surface is folded.
    ///
    /// # Errors
    /// Fails only as [`Displaced::folds`] does; triangle meshes do not fail.
    pub fn folds(&self, context: &Context) -> Result<Folds> {
        match &self.layers {
            ViewKind::Tiles(view) => view.displaced()?.folds(context),
            ViewKind::Triangles(view) => Ok(view.displaced()?.folds(context)),
        }
    }

    /// What is at places, which exist; colours of tiles as means over as many footprints, if there are any.
    ///
    /// # Errors
    /// Fails with `Invalid` if a place or a footprint cannot be evaluated.
    pub fn look(
        &self,
        context: &Context,
        places: &[Place],
        footprints: Option<&[[[f32; 2]; 2]]>,
        wanted: Wanted,
        out: &mut Looked,
    ) -> Result<()> {
        match &self.layers {
            ViewKind::Tiles(view) => view.look(context, places, footprints, wanted, out),
            ViewKind::Triangles(view) => view.look(context, places, wanted, out),
        }
    }

    /// Seconds from when a place was touched to the detail's time; −1 where none ever was.
    pub fn age(&self, mark: &Mark) -> f32 {
        mark.age(self.time)
    }

    /// What was committed of a Catmull-Clark surface, in place of `spare`, a view that nobody looks at, if there is one.
    pub fn of_tiles(
        object: &mut DisplacedObject,
        cage: Arc<Mesh>,
        options: SurfaceOptions,
        pose: u64,
        spare: Option<Arc<Self>>,
    ) -> Arc<Self> {
        let (mut spare, mut changed) = (spare, Vec::new());
        if let Some(spare) = spare.as_mut().and_then(Arc::get_mut) {
            std::mem::swap(&mut changed, &mut spare.changed);
            changed.clear();
        }
        // Not reached for writing, so that what was measured of it stays.
        let snapshot = object.commit();
        changed.extend(snapshot.changed());
        let heights = [object.displacement().full_bytes(), object.displacement().budget()];
        let (bytes, mut colors) = commit_some(object.paint_mut(), &mut changed);
        let (halves, half_colors) = commit_some(object.half_paint_mut(), &mut changed);
        if halves.is_some() {
            colors = half_colors;
        }
        let paint = bytes.map(ByFormat::Rgba8).or(halves.map(ByFormat::Rgba16));
        let vectors = object.commit_vectors();
        changed.extend(vectors.iter().flat_map(|vectors| vectors.changed()));
        let directions = object.vectors().map_or([0; 2], |vectors| [vectors.full_bytes(), vectors.budget()]);
        let (traces, contacts) = commit_some(object.traces_mut(), &mut changed);
        changed.sort_unstable();
        changed.dedup();
        let surface = object.surface().clone();
        let made = Self {
            layers: ViewKind::Tiles(TileView { surface, options, snapshot, paint, vectors, traces }),
            cage,
            time: object.time(),
            changed,
            transform: *object.transform(),
            pose,
            limits: [heights, colors, directions, contacts],
            stamp_bytes: object.stamp_bytes(),
        };
        let Some(mut view) = spare else { return Arc::new(made) };
        match Arc::get_mut(&mut view) {
            Some(room) => *room = made,
            None => view = Arc::new(made),
        }
        view
    }

    /// Shares what `live` has instead of what it had: of a view that nobody looks at.
    pub fn release(&mut self, live: &Self) {
        if let (ViewKind::Tiles(old), ViewKind::Tiles(new)) = (&mut self.layers, &live.layers) {
            old.clone_from(new);
        }
    }

    /// What was committed of a triangle mesh. `before` is the view before, whose surface is shared if the pose is the
    /// same.
    ///
    /// # Errors
    /// Fails only as [`TriangleDisplaced::new`] does, if a layer were of another mesh.
    pub fn of_triangles(
        context: &Context,
        object: &mut TriangleObject,
        before: Option<&View>,
        cage: Arc<Mesh>,
        pose: u64,
    ) -> Result<Arc<Self>> {
        let topology = object.surface().topology().clone();
        let vectors = object.commit_vectors(context)?;
        let snapshot = object.commit(context)?;
        let halves = object.half_paint_mut().map(|paint| ByFormat::Rgba16(paint.commit()));
        let paint = object.paint_mut().map(|paint| ByFormat::Rgba8(paint.commit())).or(halves);
        let traces = object.traces_mut().map(TriangleChannel::commit);
        let mut faces = snapshot.changed().faces_shown(&topology);
        faces.extend(vectors.iter().flat_map(|vectors| vectors.changed().faces_shown(&topology)));
        faces.extend(paint.iter().flat_map(|paint| by_format!(paint, it => it.changed().faces_shown(&topology))));
        faces.extend(traces.iter().flat_map(|traces| traces.changed().faces_shown(&topology)));
        faces.sort_unstable();
        faces.dedup();
        let same = before.filter(|before| before.pose == pose).map(|before| before.shape());
        let surface = match same {
            Some(Shape::Triangles(surface)) => surface,
            _ => Arc::new(object.surface().clone()),
        };
        let layers = ViewKind::Triangles(TriangleView {
            surface,
            snapshot,
            paint,
            vectors,
            traces,
            offsets: object.offsets().cloned(),
            normals: object.normals().clone(),
        });
        Ok(Arc::new(Self {
            layers,
            cage,
            time: object.time(),
            changed: faces,
            transform: *object.transform(),
            pose,
            limits: [
                limits(Some(object.displacement())),
                match object.half_paint() {
                    None => limits(object.paint()),
                    halves => limits(halves),
                },
                limits(object.vectors()),
                limits(object.traces()),
            ],
            stamp_bytes: object.stamp_bytes(),
        }))
    }
}
