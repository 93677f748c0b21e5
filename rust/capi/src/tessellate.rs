//! Triangles of surfaces and details; see `include/relievo/tessellate.h`.

use std::sync::{Arc, RwLock};

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Result, Values};
use relievo_surface::{Surface, SurfaceOptions, TileTopology};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Tessellation, Tessellator};

use crate::array::{Output, present, put};
use crate::descriptor::{check_descriptor, read_optional, write_descriptor};
use crate::detail::{DetailObject, RlvDetail, View};
use crate::mesh::{self, RlvMesh};
use crate::registry::{self, handle, try_read, try_write};
use crate::surface::RlvSurface;

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
        let or = |value, default| if value == 0 { default } else { value };
        let coarse = or(given.coarse, 8);
        let smooth_uvs = given.smooth_uvs != 0;
        Ok((Self { coarse, fine: or(given.fine, 256).max(coarse), smooth_uvs }, given.places != 0))
    }

    /// Cells a side of every tile: one per texel where there are any.
    fn rates(self, topology: &TileTopology, density: impl Fn(u32) -> u32) -> Vec<u32> {
        let rate = |tile: u32| {
            let cells = density(tile).clamp(self.coarse, self.fine);
            if topology.is_sub(tile) { (cells / 2).max(1) } else { cells }
        };
        (0..topology.tile_count() as u32).map(rate).collect()
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
    let quads: u64 = rates.iter().map(|rate| u64::from(*rate).pow(2)).sum();
    // A point with its normal, and for both triangles corners, indices of attributes, parameters and the tile.
    let bytes = quads.saturating_mul(24 + 2 * (12 + 12 + 24 + 4));
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("{} triangles do not fit the memory limit", 2 * quads))
            .advise("use fewer cells or raise the memory limit of the context"));
    }
    Ok(())
}

/// The triangles of a displaced surface, if they fit the memory limit.
pub fn tessellate(context: &Context, displaced: &Displaced<'_>, cage: &Mesh, cells: Cells) -> Result<Tessellation> {
    let rates = cells.rates(displaced.field().topology(), |tile| displaced.field().density(tile));
    check_memory(context, &rates)?;
    context.stats().time("tessellate", || displaced.tessellate(context, cage, &rates))
}

/// As [`tessellate`] for what was committed, with its colours.
fn tessellate_view(context: &Context, view: &View, cells: Cells) -> Result<Tessellation> {
    let rates = cells.rates(view.surface.topology(), |tile| view.density(tile));
    check_memory(context, &rates)?;
    let displaced = view.displaced()?;
    let mut made = context.stats().time("tessellate", || displaced.tessellate(context, &view.cage, &rates))?;
    smooth(context, &view.cage, &view.options, cells, &mut made)?;
    coat(view, &mut made);
    Ok(made)
}

/// Gives the points the colours and traces of what was committed.
fn coat(view: &View, made: &mut Tessellation) {
    if let Some(paint) = &view.paint {
        made.paint(paint.field());
    }
    if let Some(traces) = &view.traces {
        made.trace(traces.field(), view.time);
    }
}

/// As [`tessellate`] for a surface without displacement.
pub fn tessellate_bare(context: &Context, surface: &Surface, cage: &Mesh, cells: Cells) -> Result<Tessellation> {
    let nothing = Displacement::new(surface.topology().clone(), &DisplacementOptions::default())?;
    tessellate(context, &Displaced::new(surface, nothing.field())?, cage, cells)
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
    rates: Vec<u32>,
    tessellator: Tessellator,
    made: Tessellation,
    /// First and number of the points that the last update wrote.
    ranges: Vec<[u32; 2]>,
}

impl Kept {
    /// All triangles anew.
    fn new(context: &Context, view: Arc<View>, rates: Vec<u32>, cells: Cells) -> Result<Self> {
        check_memory(context, &rates)?;
        let (tessellator, made) = context.stats().time("tessellate", || {
            let tessellator = Tessellator::new(view.surface.topology(), &view.cage, rates.clone())?;
            let mut made = tessellator.tessellate(context, &view.displaced()?, &view.cage)?;
            smooth(context, &view.cage, &view.options, cells, &mut made)?;
            coat(&view, &mut made);
            Ok((tessellator, made))
        })?;
        let ranges = vec![[0, made.mesh.points.len() as u32]];
        Ok(Self { view, rates, tessellator, made, ranges })
    }

    /// Brings the triangles to `view`; whether they are others than before.
    fn update(&mut self, context: &Context, view: Arc<View>, cells: Cells) -> Result<bool> {
        let rates = cells.rates(view.surface.topology(), |tile| view.density(tile));
        if rates != self.rates {
            *self = Self::new(context, view, rates, cells)?;
            return Ok(true);
        }
        let posed = view.pose != self.view.pose;
        let tiles = 0..view.surface.tile_count() as u32;
        let changed: Vec<u32> =
            tiles.filter(|tile| posed || self.view.versions(*tile) != view.versions(*tile)).collect();
        let ranges = context.stats().time("tessellate.update", || {
            self.tessellator.update(context, &view.displaced()?, &changed, &mut self.made)
        })?;
        self.ranges = ranges.into_iter().map(|range| [range.start, range.end - range.start]).collect();
        if !changed.is_empty() || view.time != self.view.time {
            coat(&view, &mut self.made);
        }
        self.view = view;
        Ok(false)
    }

    /// The points that the last update wrote.
    fn written(&self) -> impl Iterator<Item = &[f32; 3]> {
        let points = &self.made.mesh.points;
        self.ranges.iter().flat_map(|[first, count]| points.iter().skip(*first as usize).take(*count as usize))
    }

    fn normals(&self) -> Result<&[[f32; 3]]> {
        match self.made.mesh.attribute("normal").map(|attribute| &attribute.values) {
            Some(Values::F32(normals)) => Ok(normals.as_chunks().0),
            _ => Err(Error::internal("a tessellation has no normals")),
        }
    }
}

entry! {
    fn rlv_tessellate_surface(surface: RlvSurface, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(surface)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let pose = object.snapshot();
        let context = &object.context.context;
        let mut made = tessellate_bare(context, &pose.surface, &object.cage, cells)?;
        smooth(context, &object.cage, &object.options, cells, &mut made)?;
        let handle = mesh::register(object.context.clone(), with_places(made, places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_tessellate_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let view = object.view();
        let made = tessellate_view(&object.context.context, &view, cells)?;
        let handle = mesh::register(object.context.clone(), with_places(made, places))?;
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
        let rates = cells.rates(view.surface.topology(), |tile| view.density(tile));
        let kept = RwLock::new(Kept::new(&detail.context.context, view, rates, cells)?);
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
            point_count: kept.tessellator.point_count(),
            triangle_count: kept.tessellator.triangle_count(),
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
        // SAFETY: the caller promises room for `capacity` pairs, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::<[u32; 2]>::optional("ranges", ranges.cast(), capacity, 0) }? {
            out.holds("ranges", kept.ranges.len())?.fill(kept.ranges.iter().copied());
        }
        // SAFETY: checked above.
        unsafe { put(count, kept.ranges.len()) };
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
        let points = &kept.made.mesh.points;
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
        let values = match kept.made.mesh.attribute("color").map(|attribute| &attribute.values) {
            Some(Values::F32(values)) if kept.view.paint.is_some() => values.as_chunks().0,
            _ => return Err(Error::invalid("the detail has no colours").advise("give it some with rlv_detail_add_paint")),
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
        if kept.view.traces.is_none() {
            return Err(Error::invalid("the detail has no traces").advise("let imprints leave some with rlv_detail_add_traces"));
        }
        let points = kept.made.mesh.points.len();
        let end = first.checked_add(count).filter(|end| *end <= points);
        let end = end.ok_or_else(|| {
            Error::invalid(format!("{count} points from {first} on are more than there are: {points}"))
        })?;
        let lists = ["contact", "depth", "age"].map(|name| match kept.made.mesh.attribute(name).map(|it| &it.values) {
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
        let made = try_read(&object.kept, "tessellation")?.made.clone();
        let handle = mesh::register(object.detail.context.clone(), with_places(made, object.places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }
}
