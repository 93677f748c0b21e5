//! Displaced surfaces for renderers' own Embree scenes; see `include/relievo/procedural.h`.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_procedural::{BlockRay, MAX_CELLS, Procedural, procedural_rates};
use relievo_surface::{Place, TileTopology};

use crate::border::array::{Input, Output, Plain, present, put};
use crate::border::descriptor::{read_descriptor, read_optional, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle};
use crate::details::detail::{RLV_CHANNEL_COLOR, RlvDetail, missing};
use crate::details::view::{Looked, TileView, TriangleView, View, ViewKind, Wanted};
use crate::runtime::context::ContextObject;
use crate::surfaces::shape::SLACK;

handle!(RlvProcedural, 12, ProceduralObject);

descriptor! {
    pub struct RlvProceduralOptions {
        struct_size: u32,
        coarse: u32,
        fine: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvProceduralInfo {
        struct_size: u32,
        primitive_count: u32,
        time_step_count: u32,
        step: f32,
        cell_count: u64,
        bytes: u64,
        low: [f32; 3],
        high: [f32; 3],
    }
}

pub type RlvProceduralBounds = Option<unsafe extern "C" fn(*const c_void, u32, u32, *mut f32)>;
pub type RlvProceduralIntersect =
    Option<unsafe extern "C" fn(*const c_void, *const i32, u32, u32, u32, *mut c_void, u32)>;
pub type RlvProceduralOccluded = Option<unsafe extern "C" fn(*const c_void, *const i32, u32, *mut c_void, u32)>;

descriptor! {
    pub struct RlvProceduralTable {
        struct_size: u32,
        primitive_count: u32,
        time_step_count: u32,
        reserved: u32,
        data: *const c_void,
        tiles: *const u32,
        bounds: RlvProceduralBounds,
        intersect: RlvProceduralIntersect,
        occluded: RlvProceduralOccluded,
    }
}

descriptor! {
    pub struct RlvProceduralHits {
        struct_size: u32,
        reserved: u32,
        count: usize,
        primitives: *const u32,
        primitive_stride: usize,
        uvs: *const f32,
        uv_stride: usize,
        times: *const f32,
        time_stride: usize,
        tiles: *mut u32,
        tile_stride: usize,
        positions: *mut f32,
        position_stride: usize,
        normals: *mut f32,
        normal_stride: usize,
        colors: *mut f32,
        color_stride: usize,
    }
}

/// Primitives and what they were made of. It never changes.
pub struct ProceduralObject {
    context: Arc<ContextObject>,
    begin: Arc<View>,
    end: Option<Arc<View>>,
    cells: Cells,
    made: Procedural,
}

/// Cells along an edge of the cage.
#[derive(Clone, Copy)]
struct Cells {
    coarse: u32,
    fine: u32,
}

impl Cells {
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size.
    unsafe fn new(options: *const RlvProceduralOptions) -> Result<Self> {
        let default = RlvProceduralOptions { struct_size: 0, coarse: 0, fine: 0, reserved: 0 };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        for (name, value) in [("coarse", given.coarse), ("fine", given.fine)] {
            if value != 0 && !(value.is_power_of_two() && (4..=MAX_CELLS).contains(&value)) {
                return Err(Error::invalid(format!("an edge cannot have {value} cells"))
                    .at(name)
                    .advise(format!("use a power of two from 4 to {MAX_CELLS}, or 0 for the default")));
            }
        }
        let or = |value, default| if value == 0 { default } else { value };
        let coarse = or(given.coarse, 16);
        Ok(Self { coarse, fine: or(given.fine, 256).max(coarse) })
    }
}

/// The error about another cage at the end.
fn other_cage() -> Error {
    Error::invalid("the detail at the end is of another cage")
        .at("end")
        .advise("use a detail of the same faces, posed otherwise")
}

/// Whether tiles meet alike.
fn is_same(a: &TileTopology, b: &TileTopology) -> bool {
    a.tile_count() == b.tile_count() && (0..a.tile_count() as u32).all(|tile| a.links(tile) == b.links(tile))
}

/// The primitives of tiles.
fn of_tiles(context: &Context, begin: &TileView, end: Option<&TileView>, cells: Cells) -> Result<Procedural> {
    if end.is_some_and(|end| !is_same(begin.surface.topology(), end.surface.topology())) {
        return Err(other_cage());
    }
    // Colours and traces need no cells of their own: they are looked up.
    let density = |view: &TileView, tile: u32| {
        let vectors = view.vectors.as_ref().map_or(0, |vectors| vectors.field().density(tile));
        view.snapshot.field().density(tile).max(vectors)
    };
    let rates = procedural_rates(begin.surface.topology(), |tile| {
        let there = density(begin, tile).max(end.map_or(0, |end| density(end, tile)));
        there.clamp(cells.coarse, cells.fine)
    });
    let moved = end.map(TileView::displaced).transpose()?;
    Procedural::new(context, &begin.displaced()?, moved.as_ref(), &rates)
}

/// The primitives of triangles.
fn of_triangles(
    context: &Context,
    begin: &TriangleView,
    end: Option<&TriangleView>,
    cells: Cells,
) -> Result<Procedural> {
    if end.is_some_and(|end| begin.surface.topology().faces() != end.surface.topology().faces()) {
        return Err(other_cage());
    }
    let moved = end.map(TriangleView::displaced).transpose()?;
    Procedural::of_triangles(context, &begin.displaced()?, moved.as_ref(), cells.fine)
}

impl ProceduralObject {
    fn new(context: Arc<ContextObject>, begin: Arc<View>, end: Option<Arc<View>>, cells: Cells) -> Result<Self> {
        let executor = &context.context;
        let made =
            executor.stats().time("procedural", || match (&begin.layers, end.as_ref().map(|end| &end.layers)) {
                (ViewKind::Tiles(begin), None) => of_tiles(executor, begin, None, cells),
                (ViewKind::Tiles(begin), Some(ViewKind::Tiles(end))) => of_tiles(executor, begin, Some(end), cells),
                (ViewKind::Triangles(begin), None) => of_triangles(executor, begin, None, cells),
                (ViewKind::Triangles(begin), Some(ViewKind::Triangles(end))) => {
                    of_triangles(executor, begin, Some(end), cells)
                }
                _ => Err(other_cage()),
            })?;
        Ok(Self { context, begin, end, cells, made })
    }
}

/// What is being done while primitives are made.
const STAGE: &str = "procedural";

/// Reads the last commit of a detail, of which primitives are made.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or an option is out of range. What the work refuses, it returns:
/// primitives over the memory limit, or `Cancelled`.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn create(detail: RlvDetail, options: *const RlvProceduralOptions) -> Result<Making<RlvProcedural>> {
    let detail = registry::get(detail)?;
    // SAFETY: promised by the caller.
    let cells = unsafe { Cells::new(options) }?;
    Ok(making(detail.context.clone(), detail.view(), None, cells))
}

/// Reads what the primitives of a surface that moves are made of.
///
/// # Errors
/// Fails with `Invalid` if a handle is not alive. What the work refuses, it returns: a detail with another cage,
/// primitives over the memory limit, or `Cancelled`.
pub fn create_moving(begin: RlvProcedural, end: RlvDetail) -> Result<Making<RlvProcedural>> {
    let (begin, end) = (registry::get(begin)?, registry::get(end)?);
    Ok(making(begin.context.clone(), begin.begin.clone(), Some(end.view()), begin.cells))
}

fn making(
    context: Arc<ContextObject>,
    begin: Arc<View>,
    end: Option<Arc<View>>,
    cells: Cells,
) -> Making<RlvProcedural> {
    Making::new(context.clone(), move |progress| {
        progress.step(0.0, STAGE)?;
        let made = ProceduralObject::new(context, begin, end, cells)?;
        progress.step(1.0, STAGE)?;
        registry::insert(made)
    })
}

/// Kinds of numbers of a ray, and of a ray and its hit.
const RAY: usize = 12;
const RAY_HIT: usize = 20;

/// Rays of a packet, kind after kind.
struct Packet {
    numbers: *mut f32,
    count: usize,
}

impl Packet {
    /// # Safety
    /// The packet has this many kinds of numbers, and `ray` is one of it.
    unsafe fn get(&self, kind: usize, ray: usize) -> f32 {
        // SAFETY: promised by the caller.
        unsafe { self.numbers.add(kind * self.count + ray).read() }
    }

    /// # Safety
    /// As for [`Self::get`].
    unsafe fn set(&self, kind: usize, ray: usize, value: f32) {
        // SAFETY: promised by the caller.
        unsafe { self.numbers.add(kind * self.count + ray).write(value) }
    }

    /// # Safety
    /// As for [`Self::get`].
    unsafe fn ray(&self, ray: usize) -> BlockRay {
        // SAFETY: promised by the caller.
        unsafe {
            BlockRay {
                origin: [self.get(0, ray), self.get(1, ray), self.get(2, ray)],
                near: self.get(3, ray),
                direction: [self.get(4, ray), self.get(5, ray), self.get(6, ray)],
                time: self.get(7, ray),
                far: self.get(8, ray),
            }
        }
    }
}

/// Runs the body of a function of the table, from which no panic gets out.
fn inside(body: impl FnOnce()) {
    // There is nobody to tell: a primitive that fails is not hit.
    let _ = catch_unwind(AssertUnwindSafe(body));
}

/// # Safety
/// As `procedural.h` demands: `data` is that of a table whose procedural lives, `bounds` has room for eight floats.
unsafe extern "C" fn bounds(data: *const c_void, primitive: u32, time_step: u32, bounds: *mut f32) {
    if data.is_null() || bounds.is_null() {
        return;
    }
    inside(|| {
        // SAFETY: promised by the caller.
        let procedural = unsafe { &*data.cast::<Procedural>() };
        let empty = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let (low, high) = procedural.bounds(primitive, time_step > 0).unwrap_or(empty);
        for (index, value) in [low[0], low[1], low[2], 0.0, high[0], high[1], high[2], 0.0].into_iter().enumerate() {
            // SAFETY: promised by the caller.
            unsafe { bounds.add(index).write(value) };
        }
    });
}

/// Has `meet` called with every ray of a packet that is valid, by its index; nothing is done where a pointer is NULL.
///
/// # Safety
/// As for [`intersect`], with as many kinds of numbers as `meet` uses.
unsafe fn each_ray(
    data: *const c_void,
    valid: *const i32,
    rays: *mut c_void,
    count: u32,
    meet: impl Fn(&Procedural, &Packet, usize),
) {
    if data.is_null() || valid.is_null() || rays.is_null() {
        return;
    }
    inside(|| {
        // SAFETY: promised by the caller.
        let procedural = unsafe { &*data.cast::<Procedural>() };
        let packet = Packet { numbers: rays.cast(), count: count as usize };
        for index in 0..packet.count {
            // SAFETY: promised by the caller; the index is below the count.
            if unsafe { valid.add(index).read() } != 0 {
                meet(procedural, &packet, index);
            }
        }
    });
}

/// # Safety
/// As `procedural.h` demands: `data` is that of a table whose procedural lives, `valid` has `count` numbers, `rays` as
/// many of twenty kinds.
unsafe extern "C" fn intersect(
    data: *const c_void,
    valid: *const i32,
    primitive: u32,
    geometry: u32,
    instance: u32,
    rays: *mut c_void,
    count: u32,
) {
    const { assert!(RAY_HIT == 20) };
    let meet = |procedural: &Procedural, packet: &Packet, index| {
        // SAFETY: the index is below the count of the packet.
        unsafe {
            let ray = packet.ray(index);
            let Some(hit) = procedural.intersect(primitive, &ray) else { return };
            // Of hits at the same distance that of the first primitive counts, in whatever order they are met.
            let there = [packet.get(17, index).to_bits(), packet.get(18, index).to_bits()];
            if hit.distance == ray.far && there[1] == geometry && there[0] < primitive {
                return;
            }
            packet.set(8, index, hit.distance);
            for (kind, value) in (RAY..).zip(hit.normal.into_iter().chain(hit.uv)) {
                packet.set(kind, index, value);
            }
            for (kind, value) in (RAY + 5..).zip([primitive, geometry, instance]) {
                packet.set(kind, index, f32::from_bits(value));
            }
        }
    };
    // SAFETY: promised by the caller.
    unsafe { each_ray(data, valid, rays, count, meet) };
}

/// # Safety
/// As for [`intersect`], with twelve kinds of numbers.
unsafe extern "C" fn occluded(data: *const c_void, valid: *const i32, primitive: u32, rays: *mut c_void, count: u32) {
    let meet = |procedural: &Procedural, packet: &Packet, index| {
        // SAFETY: the index is below the count of the packet.
        unsafe {
            if procedural.occluded(primitive, &packet.ray(index)) {
                packet.set(8, index, f32::NEG_INFINITY);
            }
        }
    };
    // SAFETY: promised by the caller.
    unsafe { each_ray(data, valid, rays, count, meet) };
}

/// Hits that are evaluated between two writes to the caller's arrays, which bounds the memory of a call.
const CHUNK: usize = 1 << 16;

/// What is at places, of a detail that moves blended at `times`.
fn look(object: &ProceduralObject, places: &[Place], times: &[f32], wanted: Wanted) -> Result<Looked> {
    let mut found = Looked::default();
    let context = &object.context.context;
    object.begin.look(context, places, None, wanted, &mut found)?;
    let Some(end) = &object.end else { return Ok(found) };
    let mut last = Looked::default();
    end.look(context, places, None, wanted, &mut last)?;
    let blend = |a: [f32; 3], b: [f32; 3], time: f32| Vec3::from(a) * (1.0 - time) + Vec3::from(b) * time;
    for (index, time) in times.iter().enumerate() {
        let (p, normal) = (&mut found.points.p[index], &mut found.points.normal[index]);
        *p = blend(*p, last.points.p[index], *time).to_array();
        *normal = blend(*normal, last.points.normal[index], *time).normalize_or(Vec3::from(*normal)).to_array();
        if let (Some(color), Some(last)) = (found.colors.get_mut(index), last.colors.get(index)) {
            *color = color.lerp(*last, *time);
        }
    }
    Ok(found)
}

fn write<T: Plain>(out: Option<Output<T>>, first: usize, values: impl IntoIterator<Item = T>) {
    if let Some(out) = out {
        values.into_iter().enumerate().for_each(|(index, value)| out.set(first + index, value));
    }
}

entry! {
    fn rlv_procedural_create(detail: RlvDetail, options: *const RlvProceduralOptions, out: *mut RlvProcedural) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let handle = unsafe { create(detail, options) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_procedural_create_moving(begin: RlvProcedural, end: RlvDetail, out: *mut RlvProcedural) {
        present("out", out)?;
        let handle = create_moving(begin, end)?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_procedural_retain(procedural: RlvProcedural) {
        registry::retain(procedural)
    }

    fn rlv_procedural_release(procedural: RlvProcedural) {
        registry::release(procedural)
    }

    fn rlv_procedural_info(procedural: RlvProcedural, out: *mut RlvProceduralInfo) {
        let object = registry::get(procedural)?;
        let (low, high) = object.made.all_bounds();
        let info = RlvProceduralInfo {
            struct_size: 0,
            primitive_count: object.made.tiles().len() as u32,
            time_step_count: 1 + u32::from(object.made.moves()),
            step: object.made.step(),
            cell_count: object.made.cell_count(),
            bytes: object.made.bytes(),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_procedural_table(procedural: RlvProcedural, out: *mut RlvProceduralTable) {
        // The object stays where it is as long as there are references.
        let object = registry::get(procedural)?;
        let table = RlvProceduralTable {
            struct_size: 0,
            primitive_count: object.made.tiles().len() as u32,
            time_step_count: 1 + u32::from(object.made.moves()),
            reserved: 0,
            data: (&raw const object.made).cast(),
            tiles: object.made.tiles().as_ptr(),
            bounds: Some(bounds),
            intersect: Some(intersect),
            occluded: Some(occluded),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, table) }
    }

    fn rlv_procedural_evaluate(procedural: RlvProcedural, hits: *const RlvProceduralHits) {
        let object = registry::get(procedural)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvProceduralHits = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(hits, default) }?;
        let count = given.count;
        // SAFETY: the caller promises `count` elements of each that is not NULL.
        let (primitives, uvs, times, tiles, positions, normals, colors) = unsafe {
            (
                Input::new("primitives", given.primitives, count, given.primitive_stride)?,
                Input::<[f32; 2]>::new("uvs", given.uvs.cast(), count, given.uv_stride)?,
                Input::optional("times", given.times, count, given.time_stride)?,
                Output::optional("tiles", given.tiles, count, given.tile_stride)?,
                Output::<[f32; 3]>::optional("positions", given.positions.cast(), count, given.position_stride)?,
                Output::<[f32; 3]>::optional("normals", given.normals.cast(), count, given.normal_stride)?,
                Output::<[f32; 4]>::optional("colors", given.colors.cast(), count, given.color_stride)?,
            )
        };
        if colors.is_some() && !(object.begin.has_paint() && object.end.as_ref().is_none_or(|end| end.has_paint())) {
            return Err(missing(RLV_CHANNEL_COLOR).at("colors"));
        }
        let most = if matches!(object.begin.layers, ViewKind::Triangles(_)) { 1.0 + SLACK } else { 2.0 };
        for (index, (primitive, uv)) in primitives.iter().zip(uvs.iter()).enumerate() {
            let known = object.made.tiles().len();
            if primitive as usize >= known {
                return Err(Error::invalid(format!("primitive {primitive} does not exist"))
                    .at(format!("hit {index}"))
                    .advise(format!("there are {known}")));
            }
            if !uv.iter().all(|value| (0.0..=1.0).contains(value)) || uv[0] + uv[1] > most {
                return Err(Error::invalid(format!("({}, {}) is outside the tile", uv[0], uv[1]))
                    .at(format!("hit {index}"))
                    .advise("use u and v as a hit has them"));
            }
        }
        let wanted = Wanted { colors: colors.is_some(), ..Wanted::default() };
        for first in (0..count).step_by(CHUNK) {
            let range = first..count.min(first + CHUNK);
            let place = |index| {
                let [u, v] = uvs.get(index);
                let tile = object.made.tiles().get(primitives.get(index) as usize).copied();
                Place { tile: tile.unwrap_or_default(), u, v }
            };
            let places: Vec<Place> = range.clone().map(place).collect();
            // What is no number counts as the beginning.
            let time = |index| times.map_or(0.0, |times| times.get(index).max(0.0).min(1.0));
            let moments: Vec<f32> = range.map(time).collect();
            write(tiles, first, places.iter().map(|place| place.tile));
            if positions.is_some() || normals.is_some() || colors.is_some() {
                let found = look(&object, &places, &moments, wanted)?;
                write(positions, first, found.points.p.iter().copied());
                write(normals, first, found.points.normal.iter().copied());
                write(colors, first, found.colors.iter().map(|color| color.to_array()));
            }
        }
        Ok(())
    }
}
