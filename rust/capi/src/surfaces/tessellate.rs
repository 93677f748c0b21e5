//! Triangles of surfaces and details; see `include/relievo/tessellate.h`.

use std::ops::Range;
use std::sync::{Arc, RwLock};

use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Error, Marks, Mesh, Progress, Result, Values};
use relievo_surface::{Surface, SurfaceOptions, TileTopology};
use relievo_tiles::triangle::{
    FaceRates, Pattern, TriangleChannel, TriangleDisplaced, TriangleNormals, TriangleOptions, TriangleTessellation,
};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Tessellation, Tessellator, by_format};

use crate::border::array::{Output, present, put};
use crate::border::descriptor::{check_descriptor, read_optional, write_descriptor};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::details::detail::{DetailObject, RlvDetail};
use crate::details::view::{TileView, TriangleView, View, ViewKind};
use crate::runtime::context::ContextObject;
use crate::surfaces::mesh::{self, RlvMesh};
use crate::surfaces::shape::Shape;
use crate::surfaces::surface::{Pose, RlvSurface, SurfaceObject};

handle!(RlvTessellation, 7, TessellationObject);

descriptor! {
    pub struct RlvTessellateOptions {
        struct_size: u32,
        coarse: u32,
        fine: u32,
        places: u32,
        smooth_uvs: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvTessellationInfo {
        struct_size: u32,
        reserved: u32,
        point_count: usize,
        triangle_count: usize,
        revision: u64,
    }
}

descriptor! {
    pub struct RlvTessellationChanges {
        struct_size: u32,
        rebuilt: u32,
        range_count: usize,
        point_count: usize,
        low: [f32; 3],
        high: [f32; 3],
    }
}

/// Cells along an edge of the cage.
#[derive(Clone, Copy)]
pub struct Cells {
    /// Beside tiles without displacement.
    coarse: u32,
    /// Beside tiles with displacement at most.
    fine: u32,
    /// Whether texture coordinates are subdivided as the surface is.
    smooth_uvs: bool,
}

const MAX_CELLS: u32 = 512;

impl Cells {
    /// The cells, and whether places are wanted.
    ///
    /// # Errors
    /// Fails with `Invalid` if `struct_size` is none of the type or a number of cells is no power of two up to the
    /// most, and with `Unsupported` if a field that this library lacks is not zero.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size.
    pub unsafe fn new(options: *const RlvTessellateOptions) -> Result<(Self, bool)> {
        let default =
            RlvTessellateOptions { struct_size: 0, coarse: 0, fine: 0, places: 0, smooth_uvs: 0, reserved: 0 };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        for (name, value) in [("coarse", given.coarse), ("fine", given.fine)] {
            if value != 0 && !(value.is_power_of_two() && value <= MAX_CELLS) {
                return Err(Error::invalid(format!("a tile cannot have {value} cells a side"))
                    .at(name)
                    .advise(format!("use a power of two from 1 to {MAX_CELLS}, or 0 for the default")));
            }
        }
        for (name, value) in [("places", given.places), ("smooth_uvs", given.smooth_uvs)] {
            if value > 1 {
                return Err(Error::invalid(format!("{name} is {value}")).at(name).advise("use 0 or 1"));
            }
        }
        let or = |value, default| if value == 0 { default } else { value };
        let coarse = or(given.coarse, 8);
        let smooth_uvs = given.smooth_uvs != 0;
        Ok((Self { coarse, fine: or(given.fine, 256).max(coarse), smooth_uvs }, given.places != 0))
    }

    /// Cells a side of a tile: one per texel if there are any.
    fn rate(self, topology: &TileTopology, tile: u32, density: u32) -> u32 {
        let cells = density.clamp(self.coarse, self.fine);
        if topology.is_sub(tile) { (cells / 2).max(1) } else { cells }
    }

    /// Returns the cells of every tile of a detail: as many as the finest of its channels has texels there.
    fn of_view(self, view: &TileView) -> Vec<u32> {
        self.rates(view.surface.topology(), |tile| view.density(tile))
    }

    /// Those of every tile.
    fn rates(self, topology: &TileTopology, density: impl Fn(u32) -> u32) -> Vec<u32> {
        (0..topology.tile_count() as u32).map(|tile| self.rate(topology, tile, density(tile))).collect()
    }
}

/// The name of the texture coordinates of meshes.
const UV: &str = "uv";

/// Subdivides the texture coordinates, if they are wanted so and there are any.
fn smooth(
    context: &Context,
    cage: &Mesh,
    options: &SurfaceOptions,
    cells: Cells,
    made: &mut Tessellation,
) -> Result<()> {
    if !cells.smooth_uvs || cage.attribute(UV).is_none_or(|uv| uv.domain != Domain::Corner) {
        return Ok(());
    }
    made.smooth_attribute(context, UV, &Surface::face_varying(context, cage, UV, options)?)
}

/// Fails unless the triangles of these rates fit the memory limit.
fn check_memory(context: &Context, rates: &[u32]) -> Result<()> {
    check_triangles(context, 2 * rates.iter().map(|rate| u64::from(*rate).pow(2)).sum::<u64>())
}

fn check_triangles(context: &Context, count: u64) -> Result<()> {
    // Half a point with its normal, and corners, indices of attributes, parameters and the tile.
    let bytes = count.saturating_mul(12 + (12 + 12 + 24 + 4));
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("{count} triangles do not fit the memory limit"))
            .advise("use fewer cells or raise the memory limit of the context"));
    }
    Ok(())
}

fn tessellate(
    context: &Context,
    displaced: &Displaced<'_>,
    cage: &Mesh,
    rates: &[u32],
    progress: &mut dyn Progress,
) -> Result<Tessellation> {
    check_memory(context, rates)?;
    context.stats().time("tessellate", || {
        let tessellator = Tessellator::new(displaced.field().topology(), cage, rates.to_vec())?;
        tessellator.tessellate_watched(context, displaced, cage, progress)
    })
}

/// The triangles of a mesh that they are of, where something is on it, as fine as that.
fn triangles_of(
    context: &Context,
    view: &TriangleView,
    cage: &Mesh,
    progress: &mut dyn Progress,
) -> Result<(Vec<FaceRates>, TriangleTessellation)> {
    let faces = view.surface.topology().face_count();
    let rates = context.map(faces, |face| view.rates(face as u32));
    let triangles: u64 = rates.iter().map(triangle_count).sum();
    check_triangles(context, triangles)?;
    let made = context.stats().time("tessellate", || {
        let (displaced, rate) = (view.displaced()?, |face| rates[face as usize]);
        TriangleTessellation::new_watched(context, &displaced, &view.normals, cage, rate, progress)
    })?;
    Ok((rates, made))
}

/// About how many triangles a face becomes, at most.
fn triangle_count(rates: &FaceRates) -> u64 {
    let inside = rates.inside.map_or(0, |pattern| u64::from(pattern.segments()));
    3 * inside * inside / 2 + rates.sides.iter().map(|side| u64::from(*side)).sum::<u64>()
}

/// Returns the triangles that [`tessellate_view`] makes, without colours, traces and attributes of the cage.
///
/// # Errors
/// Fails with `Memory` if the triangles exceed the context's memory limit, and with `Cancelled` if `progress` asks to
/// stop.
pub fn tessellate_bare_view(
    context: &Context,
    view: &View,
    cells: Cells,
    progress: &mut dyn Progress,
) -> Result<Tessellation> {
    let cage = Mesh { attributes: Vec::new(), ..(*view.cage).clone() };
    match &view.layers {
        ViewKind::Tiles(it) => tessellate(context, &it.displaced()?, &cage, &cells.of_view(it), progress),
        ViewKind::Triangles(it) => Ok(plain(triangles_of(context, it, &cage, progress)?.1)),
    }
}

/// What was committed, with its colours and traces.
fn tessellate_view(context: &Context, view: &View, cells: Cells, progress: &mut dyn Progress) -> Result<Tessellation> {
    Ok(Follower::new(context, view, cells, progress)?.into_tessellation())
}

fn plain(made: TriangleTessellation) -> Tessellation {
    let TriangleTessellation { mesh, tiles, parameters, .. } = made;
    Tessellation { mesh, tiles, parameters }
}

/// The mesh of a surface without displacement.
fn tessellate_bare(
    context: &Context,
    surface: &SurfaceObject,
    cells: Cells,
    progress: &mut dyn Progress,
) -> Result<Tessellation> {
    let Pose { shape, points } = surface.snapshot();
    match shape {
        Shape::Tiles(limit) => {
            let nothing = Displacement::new(limit.topology().clone(), &DisplacementOptions::default())?;
            let rates = cells.rates(limit.topology(), |_| 0);
            let displaced = Displaced::new(&limit, nothing.field())?;
            let mut made = tessellate(context, &displaced, &surface.cage, &rates, progress)?;
            smooth(context, &surface.cage, &surface.options, cells, &mut made)?;
            Ok(made)
        }
        Shape::Triangles(triangles) => {
            let cage = Mesh { points: points.to_vec(), ..(*surface.cage).clone() };
            let options = TriangleOptions { segments: Pattern::SIZES[0], budget: u64::MAX };
            let nothing = TriangleChannel::displacement(triangles.topology().clone(), &options)?;
            let displaced = TriangleDisplaced::new(&triangles, nothing.field())?;
            let normals = TriangleNormals::new(triangles.topology(), nothing.field().pattern());
            check_triangles(context, triangles.topology().face_count() as u64)?;
            let single = |_| FaceRates::SINGLE;
            TriangleTessellation::new_watched(context, &displaced, &normals, &cage, single, progress).map(plain)
        }
    }
}

/// As [`tessellate_bare`], for colliders.
///
/// # Errors
/// Fails with `Memory` if the triangles exceed the context's memory limit, and with `Cancelled` if `progress` asks to
/// stop.
pub fn bare_mesh(
    context: &Context,
    surface: &SurfaceObject,
    cells: Cells,
    progress: &mut dyn Progress,
) -> Result<Mesh> {
    tessellate_bare(context, surface, cells, progress).map(|made| made.mesh)
}

/// Gives the points the colours and traces of what was committed.
fn coat(view: &View, tiles: &TileView, made: &mut Tessellation) {
    if let Some(paint) = &tiles.paint {
        by_format!(paint, it => made.paint(it.field()));
    }
    if let Some(traces) = &tiles.traces {
        made.trace(traces.field(), view.time);
    }
}

fn coat_triangles(view: &View, triangles: &TriangleView, made: &mut TriangleTessellation) -> Result<()> {
    if let Some(traces) = &triangles.traces {
        made.trace(traces.field(), view.time);
    }
    triangles.paint.as_ref().map_or(Ok(()), |paint| by_format!(paint, it => made.paint(it.field())))
}

/// The mesh, with the tile of every face and the parameters of every corner as attributes if they are wanted.
fn with_places(made: Tessellation, wanted: bool) -> Mesh {
    let Tessellation { mut mesh, tiles, parameters } = made;
    if wanted {
        let attribute =
            |name: &str, domain, width, values| Attribute { name: name.into(), domain, width, values, indices: None };
        mesh.attributes.retain(|attribute| attribute.name != "tile" && attribute.name != "tile_uv");
        mesh.attributes.push(attribute("tile", Domain::Face, 1, Values::U32(tiles)));
        let parameters = Values::F32(parameters.into_flattened());
        mesh.attributes.push(attribute("tile_uv", Domain::Corner, 2, parameters));
    }
    mesh
}

/// Triangles of a detail that follow its commits.
pub struct TessellationObject {
    detail: Arc<DetailObject>,
    cells: Cells,
    /// Whether places are wanted.
    places: bool,
    kept: RwLock<Kept>,
}

/// What an update changes.
struct Kept {
    /// The commit the triangles are of.
    view: Arc<View>,
    follower: Follower,
    /// Points that changed since the ranges were made.
    marks: Marks,
    /// First and number of the points that the last update changed.
    ranges: Vec<[u32; 2]>,
    /// Number of the last update, and of the last one that made other triangles.
    serial: u64,
    rebuilt: u64,
}

/// What a tessellation has, for copies that follow it.
pub struct Vertices<'a> {
    pub points: &'a [[f32; 3]],
    pub normals: &'a [[f32; 3]],
    pub corners: &'a [u32],
    /// The tile of every triangle, and the parameters of its corners there.
    pub tiles: &'a [u32],
    pub parameters: &'a [[f32; 2]],
    /// The commit that they are of.
    pub view: &'a Arc<View>,
    /// First and number of the points that the last update changed.
    pub ranges: &'a [[u32; 2]],
    /// Number of the last update.
    pub serial: u64,
    rebuilt: u64,
}

impl Vertices<'_> {
    /// Whether there are other triangles than after the update with this number.
    pub fn rebuilt_since(&self, serial: u64) -> bool {
        self.rebuilt > serial
    }
}

impl TessellationObject {
    pub fn context(&self) -> &ContextObject {
        &self.detail.context
    }

    pub fn shared_context(&self) -> Arc<ContextObject> {
        self.detail.context.clone()
    }

    /// Calls `look` with what the last update left.
    ///
    /// # Errors
    /// Fails with `Busy` while an update is at work, with `Internal` if an earlier panic left it broken, and as `look`
    /// does.
    pub fn with_vertices<R>(&self, look: impl FnOnce(&Vertices<'_>) -> Result<R>) -> Result<R> {
        let kept = try_read(&self.kept, "tessellation")?;
        let Kept { serial, rebuilt, ranges, follower, view, .. } = &*kept;
        let mesh = follower.mesh();
        let (tiles, parameters) = follower.places();
        look(&Vertices {
            points: &mesh.points,
            normals: kept.normals()?,
            corners: &mesh.corners,
            tiles,
            parameters,
            view,
            ranges,
            serial: *serial,
            rebuilt: *rebuilt,
        })
    }
}

/// Triangles, and how finely what they are of was divided.
enum Follower {
    Tiles { rates: Vec<u32>, tessellator: Tessellator, made: Tessellation },
    Triangles { rates: Vec<FaceRates>, made: TriangleTessellation },
}

impl Follower {
    /// All triangles anew.
    fn new(context: &Context, view: &View, cells: Cells, progress: &mut dyn Progress) -> Result<Self> {
        let cage = &view.cage;
        match &view.layers {
            ViewKind::Tiles(it) => {
                let rates = cells.of_view(it);
                check_memory(context, &rates)?;
                context.stats().time("tessellate", || {
                    let tessellator = Tessellator::new(it.surface.topology(), cage, rates.clone())?;
                    let mut made = tessellator.tessellate_watched(context, &it.displaced()?, cage, progress)?;
                    smooth(context, cage, &it.options, cells, &mut made)?;
                    coat(view, it, &mut made);
                    Ok(Self::Tiles { rates, tessellator, made })
                })
            }
            ViewKind::Triangles(it) => {
                let (rates, mut made) = triangles_of(context, it, cage, progress)?;
                coat_triangles(view, it, &mut made)?;
                Ok(Self::Triangles { rates, made })
            }
        }
    }

    fn mesh(&self) -> &Mesh {
        match self {
            Self::Tiles { made, .. } => &made.mesh,
            Self::Triangles { made, .. } => &made.mesh,
        }
    }

    /// The tile of every triangle, and the parameters of its corners there.
    fn places(&self) -> (&[u32], &[[f32; 2]]) {
        match self {
            Self::Tiles { made, .. } => (&made.tiles, &made.parameters),
            Self::Triangles { made, .. } => (&made.tiles, &made.parameters),
        }
    }

    fn into_tessellation(self) -> Tessellation {
        match self {
            Self::Tiles { made, .. } => made,
            Self::Triangles { made, .. } => plain(made),
        }
    }

    fn tessellation(&self) -> Tessellation {
        match self {
            Self::Tiles { made, .. } => made.clone(),
            Self::Triangles { made, .. } => plain(made.clone()),
        }
    }

    /// Brings points from `before` to `view`. `marks` get the points that changed in any array, but for ages of traces
    /// where the time alone is another. Returns false if there are to be other triangles.
    fn update(&mut self, context: &Context, before: &View, view: &View, cells: Cells, marks: &Marks) -> Result<bool> {
        let posed = view.pose != before.pose;
        let (was, aged) = (before.time, view.time != before.time);
        match (self, &view.layers, &before.layers) {
            (Self::Tiles { rates, tessellator, made }, ViewKind::Tiles(it), ViewKind::Tiles(before)) => {
                let topology = it.surface.topology();
                let mut room = context.scratch().lend::<Changes>();
                let Changes { tiles: changed, seen } = &mut *room;
                it.touched(before, changed);
                if changed.iter().any(|tile| cells.rate(topology, *tile, it.density(*tile)) != rates[*tile as usize]) {
                    return Ok(false);
                }
                if posed {
                    changed.clear();
                    changed.extend(0..topology.tile_count() as u32);
                } else {
                    changed.retain(|tile| before.versions(*tile) != it.versions(*tile));
                }
                let known = it.seen(before, changed, seen);
                let renewed = if known { &*seen } else { &*changed };
                tessellator.update(context, &it.displaced()?, renewed, made, marks)?;
                match &it.paint {
                    Some(paint) if known => by_format!(paint, it => tessellator.paint(it.field(), seen, made, marks))?,
                    Some(paint) => {
                        by_format!(paint, it => made.paint(it.field()));
                        marks.mark_all();
                    }
                    None => {}
                }
                if let Some(traces) = &it.traces {
                    let is_new = before.traces.is_none();
                    if is_new {
                        marks.mark_all();
                    } else {
                        // Compared at the earlier time, so that ages alone mark no point.
                        tessellator.trace(traces.field(), was, changed, made, marks)?;
                    }
                    if is_new || aged {
                        made.trace(traces.field(), view.time);
                    }
                }
                Ok(true)
            }
            (Self::Triangles { rates, made }, ViewKind::Triangles(it), ViewKind::Triangles(before)) => {
                let faces = it.surface.topology().face_count();
                if context.map(faces, |face| it.rates(face as u32)) != *rates {
                    return Ok(false);
                }
                let changed = if posed { (0..faces as u32).collect() } else { it.shown(before) };
                let points = made.points_near(it.surface.topology(), &changed)?;
                made.update(context, &it.displaced()?, &it.normals, &points, marks)?;
                let formats = [&it.paint, &before.paint].map(|paint| paint.as_ref().map(std::mem::discriminant));
                match &it.paint {
                    Some(paint) if formats[0] == formats[1] => {
                        by_format!(paint, it => made.repaint(it.field(), &points, marks))?;
                    }
                    Some(paint) => {
                        by_format!(paint, it => made.paint(it.field()))?;
                        marks.mark_all();
                    }
                    None => {}
                }
                if let Some(traces) = &it.traces {
                    let is_new = before.traces.is_none();
                    if is_new {
                        marks.mark_all();
                    } else {
                        // Compared at the earlier time, so that ages alone mark no point.
                        made.retrace(traces.field(), was, &points, marks)?;
                    }
                    if is_new || aged {
                        made.trace(traces.field(), view.time);
                    }
                }
                Ok(true)
            }
            _ => Err(Error::internal("a tessellation is of another surface than its detail")),
        }
    }
}

/// Tiles that changed between two commits.
#[derive(Default)]
struct Changes {
    tiles: Vec<u32>,
    /// Those in which other colours may be seen.
    seen: Vec<u32>,
}

impl Kept {
    /// All triangles anew.
    fn new(context: &Context, view: Arc<View>, cells: Cells) -> Result<Self> {
        let follower = Follower::new(context, &view, cells, &mut Silent)?;
        let count = follower.mesh().points.len();
        let (marks, ranges) = (Marks::new(count), vec![[0, count as u32]]);
        Ok(Self { view, follower, marks, ranges, serial: 0, rebuilt: 0 })
    }

    /// Brings the triangles to `view`; whether they are others than before.
    fn update(&mut self, context: &Context, view: Arc<View>, cells: Cells) -> Result<bool> {
        let Self { follower, view: before, marks, serial, .. } = self;
        let serial = *serial + 1;
        let mut ranges = context.scratch().lend::<Vec<Range<u32>>>();
        let update = || follower.update(context, before, &view, cells, marks);
        if !context.stats().time("tessellate.update", update)? {
            *self = Self { serial, rebuilt: serial, ..Self::new(context, view, cells)? };
            return Ok(true);
        }
        self.marks.take(&mut ranges);
        self.ranges.clear();
        self.ranges.extend(ranges.iter().map(|range| [range.start, range.end - range.start]));
        (self.view, self.serial) = (view, serial);
        Ok(false)
    }

    /// The points in the ranges of the last update.
    fn written(&self) -> impl Iterator<Item = &[f32; 3]> {
        let points = &self.follower.mesh().points;
        self.ranges.iter().flat_map(|[first, count]| points.iter().skip(*first as usize).take(*count as usize))
    }

    fn normals(&self) -> Result<&[[f32; 3]]> {
        match self.follower.mesh().attribute("normal").map(|attribute| &attribute.values) {
            Some(Values::F32(normals)) => Ok(normals.as_chunks().0),
            _ => Err(Error::internal("a tessellation has no normals")),
        }
    }
}

/// The triangles of what was committed, with their places if those are wanted.
///
/// # Errors
/// Fails with `Memory` if the triangles exceed the context's memory limit or the host refuses their bytes, and with
/// `Cancelled` if `progress` asks to stop.
pub fn tessellate_committed(
    context: &Arc<ContextObject>,
    view: &View,
    options: (Cells, bool),
    progress: &mut dyn Progress,
) -> Result<RlvMesh> {
    let (cells, places) = options;
    let made = tessellate_view(&context.context, view, cells, progress)?;
    mesh::register(context.clone(), with_places(made, places))
}

entry! {
    fn rlv_tessellate_surface(surface: RlvSurface, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(surface)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let made = tessellate_bare(&object.context.context, &object, cells, &mut Silent)?;
        let handle = mesh::register(object.context.clone(), with_places(made, places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_tessellate_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { Cells::new(options) }?;
        let handle = tessellate_committed(&object.context, &object.view(), options, &mut Silent)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_tessellation_create(
        detail: RlvDetail,
        options: *const RlvTessellateOptions,
        out: *mut RlvTessellation,
    ) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let view = detail.view();
        let kept = RwLock::new(Kept::new(&detail.context.context, view, cells)?);
        let handle = registry::insert(TessellationObject { detail, cells, places, kept })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_tessellation_retain(tessellation: RlvTessellation) {
        registry::retain(tessellation)
    }

    fn rlv_tessellation_release(tessellation: RlvTessellation) {
        registry::release(tessellation)
    }

    fn rlv_tessellation_info(tessellation: RlvTessellation, out: *mut RlvTessellationInfo) {
        let object = registry::get(tessellation)?;
        let kept = try_read(&object.kept, "tessellation")?;
        let info = RlvTessellationInfo {
            struct_size: 0,
            reserved: 0,
            point_count: kept.follower.mesh().points.len(),
            triangle_count: kept.follower.mesh().face_count(),
            revision: kept.view.revision(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_tessellation_update(tessellation: RlvTessellation, out: *mut RlvTessellationChanges) {
        let object = registry::get(tessellation)?;
        if !out.is_null() {
            // SAFETY: the caller gives a descriptor that starts with its size.
            unsafe { check_descriptor(out) }?;
        }
        let mut kept = try_write(&object.kept, "tessellation")?;
        object.detail.context.gather();
        let rebuilt = kept.update(&object.detail.context.context, object.detail.view(), object.cells)?;
        if out.is_null() {
            return Ok(());
        }
        let bounds = kept.written().map(|point| (*point, *point)).reduce(|a, b| {
            (std::array::from_fn(|axis| a.0[axis].min(b.0[axis])), std::array::from_fn(|axis| a.1[axis].max(b.1[axis])))
        });
        let (low, high) = bounds.unwrap_or_default();
        let changes = RlvTessellationChanges {
            struct_size: 0,
            rebuilt: u32::from(rebuilt),
            range_count: kept.ranges.len(),
            point_count: kept.ranges.iter().map(|[_, count]| *count as usize).sum(),
            low,
            high,
        };
        // SAFETY: the caller gives a descriptor that starts with its size.
        unsafe { write_descriptor(out, changes) }
    }

    fn rlv_tessellation_changed_ranges(
        tessellation: RlvTessellation,
        ranges: *mut u32,
        capacity: usize,
        count: *mut usize,
    ) {
        present("count", count)?;
        let object = registry::get(tessellation)?;
        let kept = try_read(&object.kept, "tessellation")?;
        // SAFETY: checked above.
        unsafe { put(count, kept.ranges.len()) };
        // SAFETY: the caller promises room for `capacity` pairs, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::<[u32; 2]>::optional("ranges", ranges.cast(), capacity, 0) }? {
            out.holds("ranges", kept.ranges.len())?.fill(kept.ranges.iter().copied());
        }
        Ok(())
    }

    fn rlv_tessellation_get_points(
        tessellation: RlvTessellation,
        first: usize,
        count: usize,
        positions: *mut f32,
        position_stride: usize,
        normals: *mut f32,
        normal_stride: usize,
    ) {
        let object = registry::get(tessellation)?;
        let kept = try_read(&object.kept, "tessellation")?;
        let points = &kept.follower.mesh().points;
        let range = first..first.saturating_add(count);
        let (Some(from), Some(facing)) = (points.get(range.clone()), kept.normals()?.get(range)) else {
            return Err(Error::invalid(format!("there are {} points, not {count} from {first} on", points.len()))
                .at("count")
                .advise("take ranges of the last update, and fetch the mesh anew if it said rebuilt"));
        };
        // SAFETY: the caller promises room for `count` vectors, or NULL.
        let (positions, normals) = unsafe {
            (
                Output::<[f32; 3]>::optional("positions", positions.cast(), count, position_stride)?,
                Output::<[f32; 3]>::optional("normals", normals.cast(), count, normal_stride)?,
            )
        };
        for (out, values) in [(positions, from), (normals, facing)] {
            if let Some(out) = out {
                out.fill(values.iter().copied());
            }
        }
        Ok(())
    }

    fn rlv_tessellation_get_colors(
        tessellation: RlvTessellation,
        first: usize,
        count: usize,
        colors: *mut f32,
        stride: usize,
    ) {
        let object = registry::get(tessellation)?;
        let kept = try_read(&object.kept, "tessellation")?;
        // SAFETY: the caller promises room for `count` colours.
        let out = unsafe { Output::<[f32; 3]>::optional("colors", colors.cast(), count, stride) }?;
        let values = match kept.follower.mesh().attribute("color").map(|attribute| &attribute.values) {
            Some(Values::F32(values)) if kept.view.has_paint() => values.as_chunks().0,
            _ => return Err(Error::invalid("the detail has no colours").advise("give it some with rlv_detail_add_paint, commit it and update the tessellation")),
        };
        let end = first.checked_add(count).filter(|end| *end <= values.len());
        let end = end.ok_or_else(|| {
            Error::invalid(format!("{count} points from {first} on are more than there are: {}", values.len()))
        })?;
        if let Some(out) = out {
            out.fill(values[first..end].iter().copied());
        }
        Ok(())
    }

    fn rlv_tessellation_get_traces(
        tessellation: RlvTessellation,
        first: usize,
        count: usize,
        traces: *mut f32,
        stride: usize,
    ) {
        let object = registry::get(tessellation)?;
        let kept = try_read(&object.kept, "tessellation")?;
        // SAFETY: the caller promises room for `count` traces.
        let out = unsafe { Output::<[f32; 3]>::optional("traces", traces.cast(), count, stride) }?;
        if !kept.view.has_traces() {
            return Err(Error::invalid("the detail has no traces").advise("let imprints leave some with rlv_detail_add_traces, commit it and update the tessellation"));
        }
        let points = kept.follower.mesh().points.len();
        let end = first.checked_add(count).filter(|end| *end <= points);
        let end = end.ok_or_else(|| {
            Error::invalid(format!("{count} points from {first} on are more than there are: {points}"))
        })?;
        let lists = ["contact", "depth", "age"].map(|name| match kept.follower.mesh().attribute(name).map(|it| &it.values) {
            Some(Values::F32(values)) => values.get(first..end).unwrap_or_default(),
            _ => &[],
        });
        if let Some(out) = out {
            let [contacts, depths, ages] = lists;
            out.fill(contacts.iter().zip(depths).zip(ages).map(|((contact, depth), age)| [*contact, *depth, *age]));
        }
        Ok(())
    }

    fn rlv_tessellation_mesh(tessellation: RlvTessellation, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(tessellation)?;
        let made = try_read(&object.kept, "tessellation")?.follower.tessellation();
        let handle = mesh::register(object.detail.context.clone(), with_places(made, object.places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }
}
