//! Levels of progressive meshes; see `include/relievo/level.h`.

mod buffers;
pub mod edit;

use std::ffi::{c_char, c_void};
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, RwLock};

use relievo_core::{Attribute, Context, Domain, Error, ErrorKind, Result, Values};
use relievo_lod::progressive::{ActiveMesh, Cut, EditJournal, Front, KeyedEdit, View};

pub use self::buffers::{HostBuffers, RlvLevelBuffers, RlvLevelUpdate};
pub use self::edit::{RlvLevelEdit, RlvLevelHandle, RlvLevelKey, RlvLevelMotion, RlvLevelRegion, RlvLevelTrack};
use crate::border::array::{Input, Output, Plain, narrow, present, put, put_optional, text};
use crate::border::descriptor::{check_optional, read_descriptor, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::border::work::broken;
use crate::details::brush::RlvBrush;
use crate::details::stroke::{RlvStrokePoint, points_of};
use crate::levels::progressive::{self, ProgressiveObject, RlvProgressive, RlvProgressiveOptions};
use crate::runtime::context::{ContextObject, HostProgress, RLV_LOG_WARNING, RlvProgress};
use crate::surfaces::mesh::{self, RLV_DOMAIN_CORNER, RLV_DOMAIN_FACE, RLV_DOMAIN_POINT, RlvMesh};

handle!(RlvLevel, 17, LevelObject);

descriptor! {
    pub struct RlvLevelInfo {
        struct_size: u32,
        undo_count: u32,
        redo_count: u32,
        reserved: u32,
        vertex_count: usize,
        triangle_count: usize,
    }
}

descriptor! {
    pub struct RlvLevelView {
        struct_size: u32,
        reserved: u32,
        eye: [f64; 3],
        pixels: f64,
        tolerance: f64,
        outline: f64,
        planes: *const f32,
        plane_count: usize,
        plane_stride: usize,
    }
}

descriptor! {
    pub struct RlvLevelSculpted {
        struct_size: u32,
        reserved: u32,
        dabs: u64,
        missed_dabs: u64,
        vertices: u64,
    }
}

descriptor! {
    pub struct RlvLevelMisplaced {
        point: [f32; 3],
        told: f32,
        now: f32,
    }
}

impl Default for RlvLevelMisplaced {
    fn default() -> Self {
        Self { point: [0.0; 3], told: 0.0, now: 0.0 }
    }
}

// SAFETY: words without padding, floats.
unsafe impl Plain for RlvLevelMisplaced {}

pub struct LevelObject {
    context: Arc<ContextObject>,
    /// Taken after the mesh.
    whole: Mutex<Arc<ProgressiveObject>>,
    mesh: RwLock<ActiveMesh>,
    /// Where edits are written down, if they are. Taken after the mesh.
    journal: Mutex<Option<EditJournal>>,
    /// Edits over time, each of a mesh. Taken after the mesh.
    motions: Mutex<Vec<(Front, KeyedEdit)>>,
    /// What the last update wrote: ranges of vertices, triangles and wedges. Taken after the mesh.
    changed: Mutex<[Vec<Range<u32>>; 3]>,
}

impl LevelObject {
    fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Has the mesh for itself while it changes.
    fn change<T>(&self, work: impl FnOnce(&mut ActiveMesh) -> Result<T>) -> Result<T> {
        work(&mut *try_write(&self.mesh, "level")?)
    }

    fn whole(&self) -> Result<MutexGuard<'_, Arc<ProgressiveObject>>> {
        self.whole.lock().map_err(|_| broken("level"))
    }

    fn journal(&self) -> Result<MutexGuard<'_, Option<EditJournal>>> {
        self.journal.lock().map_err(|_| broken("level"))
    }

    fn motions(&self) -> Result<MutexGuard<'_, Vec<(Front, KeyedEdit)>>> {
        self.motions.lock().map_err(|_| broken("level"))
    }

    fn changed(&self) -> Result<MutexGuard<'_, [Vec<Range<u32>>; 3]>> {
        self.changed.lock().map_err(|_| broken("level"))
    }

    /// Has mesh and journal for itself while they change.
    fn edit<T>(
        &self,
        work: impl FnOnce(&Context, &mut ActiveMesh, Option<&mut EditJournal>) -> Result<T>,
    ) -> Result<T> {
        self.change(|mesh| work(&self.context().context, mesh, self.journal()?.as_mut()))
    }
}

/// What a view asks for.
///
/// # Errors
/// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type or the array of planes cannot
/// be used, with `Unsupported` if a field that this library lacks is not zero, and with `Memory` if the planes exceed
/// the memory limit.
///
/// # Safety
/// `view` is NULL or a descriptor whose array is as the header demands.
pub unsafe fn read_view(context: &ContextObject, view: *const RlvLevelView) -> Result<View> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvLevelView = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(view, default) }?;
    // SAFETY: promised by the caller.
    let planes =
        unsafe { Input::new("planes", given.planes.cast::<[f32; 4]>(), given.plane_count, given.plane_stride) }?;
    let RlvLevelView { eye, pixels, tolerance, outline, .. } = given;
    let planes = planes.to_vec("planes", context.context.memory_limit())?;
    let [pixels, tolerance, outline] = [pixels, tolerance, outline].map(|value| value as f32);
    Ok(View { eye: narrow(eye), pixels, tolerance, outline, planes })
}

/// The mesh of a deviation.
///
/// # Errors
/// Fails with `Invalid` if it is negative or not a number.
pub fn cut_of_error(error: f32) -> Result<Cut> {
    if error.is_nan() || error < 0.0 {
        return Err(Error::invalid(format!("{error} is no length")).at("error").advise("use 0 or more"));
    }
    Ok(Cut::of_error(error))
}

pub fn nothing(what: &str) -> Error {
    Error::new(ErrorKind::NotFound, format!("there is no edit to {what}")).at("level")
}

fn no_journal() -> Error {
    Error::new(ErrorKind::NotFound, "it has no journal").at("level").advise("open one first")
}

entry! {
    fn rlv_level_create(progressive: RlvProgressive, out: *mut RlvLevel) {
        present("out", out)?;
        let whole = registry::get(progressive)?;
        let bytes = ActiveMesh::bytes(&whole.mesh);
        if bytes > whole.context.context.memory_limit() {
            return Err(Error::memory(format!("a level of it takes {bytes} bytes, more than the memory limit"))
                .at("progressive")
                .advise("raise the memory limit of the context"));
        }
        let mesh = RwLock::new(ActiveMesh::new(&whole.mesh));
        let (context, whole) = (whole.context.clone(), Mutex::new(whole));
        let (journal, motions, changed) = (Mutex::default(), Mutex::default(), Mutex::default());
        let made = registry::insert(LevelObject { context, whole, mesh, journal, motions, changed })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_level_take_up(level: RlvLevel, progressive: RlvProgressive) {
        let object = registry::get(level)?;
        let whole = registry::get(progressive)?;
        object.change(|mesh| {
            mesh.take_up(&whole.mesh).map_err(|error| error.at("progressive"))?;
            *object.whole()? = whole.clone();
            Ok(())
        })
    }

    fn rlv_level_retain(level: RlvLevel) {
        registry::retain(level)
    }

    fn rlv_level_release(level: RlvLevel) {
        registry::release(level)
    }

    fn rlv_level_info(level: RlvLevel, out: *mut RlvLevelInfo) {
        let object = registry::get(level)?;
        let mesh = try_read(&object.mesh, "level")?;
        let [undo, redo] = mesh.edits();
        let info = RlvLevelInfo {
            struct_size: 0,
            undo_count: undo as u32,
            redo_count: redo as u32,
            reserved: 0,
            vertex_count: mesh.vertex_count(),
            triangle_count: mesh.triangle_count(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_level_set_error(level: RlvLevel, error: f32) {
        let object = registry::get(level)?;
        let cut = cut_of_error(error)?;
        object.change(|mesh| {
            mesh.adapt(&object.context().context, cut);
            Ok(())
        })
    }

    fn rlv_level_set_bound(
        level: RlvLevel,
        bound: f32,
        progress: RlvProgress,
        user: *mut c_void,
        distance: *mut f32,
    ) {
        let object = registry::get(level)?;
        if bound.is_nan() || bound < 0.0 {
            return Err(Error::invalid(format!("{bound} is no length")).at("bound").advise("use 0 or more"));
        }
        let mut progress = HostProgress { callback: progress, user };
        let found =
            object.change(|mesh| mesh.adapt_within(&object.context().context, bound, &mut progress))?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(distance, found) };
        Ok(())
    }

    fn rlv_level_set_triangles(level: RlvLevel, triangles: usize) {
        let object = registry::get(level)?;
        object.change(|mesh| {
            let cut = Cut::of_faces(mesh.progressive(), triangles);
            mesh.adapt(&object.context().context, cut);
            Ok(())
        })
    }

    fn rlv_level_set_view(level: RlvLevel, view: *const RlvLevelView) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with an array of its count.
        let view = unsafe { read_view(object.context(), view) }?;
        object.change(|mesh| {
            let whole = object.whole()?.clone();
            mesh.adapt_to(&object.context().context, &view, whole.extents()).map(drop)
        })
    }

    fn rlv_level_edit(level: RlvLevel, edit: *const RlvLevelEdit, reached: *mut usize) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let edit = unsafe { edit::read_edit(edit) }?;
        let count = object.edit(|context, mesh, journal| match journal {
            Some(journal) => journal.edit(context, mesh, &edit),
            None => mesh.edit(context, &edit),
        })?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(reached, count) };
        Ok(())
    }

    fn rlv_level_sculpt(
        level: RlvLevel,
        brush: RlvBrush,
        points: *const RlvStrokePoint,
        count: usize,
        stride: usize,
        out: *mut RlvLevelSculpted,
    ) {
        let (object, brush) = (registry::get(level)?, registry::get(brush)?);
        let context = &object.context().context;
        // SAFETY: the caller promises `count` points, and NULL or a descriptor that starts with its size.
        let points = unsafe {
            check_optional(out)?;
            points_of(context, points, count, stride)?
        };
        let mut stroke = try_read(&brush.stroke, "brush")?.clone();
        stroke.points = points.detach();
        let done = object.edit(|context, mesh, journal| match journal {
            Some(journal) => journal.sculpt(context, mesh, &stroke),
            None => mesh.sculpt(context, &stroke),
        })?;
        let told = RlvLevelSculpted {
            struct_size: 0,
            reserved: 0,
            dabs: done.dabs as u64,
            missed_dabs: done.missed as u64,
            vertices: done.vertices as u64,
        };
        // SAFETY: as above.
        unsafe { write_optional(out, told) }
    }

    fn rlv_level_undo(level: RlvLevel) {
        let object = registry::get(level)?;
        let is_done = object.edit(|context, mesh, journal| match journal {
            Some(journal) => journal.undo(context, mesh),
            None => Ok(mesh.undo(context)),
        })?;
        if is_done { Ok(()) } else { Err(nothing("take back")) }
    }

    fn rlv_level_redo(level: RlvLevel) {
        let object = registry::get(level)?;
        let is_done = object.edit(|context, mesh, journal| match journal {
            Some(journal) => journal.redo(context, mesh),
            None => Ok(mesh.redo(context)),
        })?;
        if is_done { Ok(()) } else { Err(nothing("make again")) }
    }

    fn rlv_level_add_motion(level: RlvLevel, motion: *const RlvLevelMotion) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let motion = unsafe { edit::read_motion(motion) }?;
        object.change(|mesh| {
            object.motions()?.push((mesh.front(), motion));
            Ok(())
        })
    }

    fn rlv_level_set_time(level: RlvLevel, time: f64, reached: *mut usize) {
        let object = registry::get(level)?;
        let count = object.change(|mesh| mesh.pose(&object.context().context, &object.motions()?, time))?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(reached, count) };
        Ok(())
    }

    fn rlv_level_clear_motions(level: RlvLevel) {
        let object = registry::get(level)?;
        object.change(|mesh| {
            object.motions()?.clear();
            mesh.rest(&object.context().context);
            Ok(())
        })
    }

    fn rlv_level_open_journal(level: RlvLevel, path: *const c_char) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let note = object.change(|mesh| {
            let mut journal = object.journal()?;
            if journal.is_some() {
                return Err(Error::invalid("it has a journal already").at("level").advise("close that one first"));
            }
            let opened = EditJournal::open(&object.context().context, Path::new(path), mesh);
            let (opened, found) = opened.map_err(|error| if error.place.is_empty() { error.at("level") } else { error })?;
            *journal = Some(opened);
            Ok(found.note)
        })?;
        // The log may call back.
        if let Some(note) = note {
            object.context().log(RLV_LOG_WARNING, &format!("{path}: {note}"));
        }
        Ok(())
    }

    fn rlv_level_sync_journal(level: RlvLevel) {
        let object = registry::get(level)?;
        let _mesh = try_read(&object.mesh, "level")?;
        object.journal()?.as_ref().ok_or_else(no_journal)?.sync()
    }

    fn rlv_level_close_journal(level: RlvLevel) {
        let object = registry::get(level)?;
        object.change(|_| object.journal()?.take().map(drop).ok_or_else(no_journal))
    }

    fn rlv_level_update(level: RlvLevel, buffers: *const RlvLevelBuffers, out: *mut RlvLevelUpdate) {
        let object = registry::get(level)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvLevelBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let given = unsafe {
            check_optional(out)?;
            read_descriptor(buffers, default)?
        };
        object.change(|mesh| {
            let (vertices, triangles) = (mesh.vertex_count(), mesh.triangle_count());
            // SAFETY: the caller promises room for the capacities.
            let mut buffers = unsafe { HostBuffers::new(&given, mesh.progressive()) }?;
            buffers.points.holds("points", vertices)?;
            buffers.triangles.holds("triangles", triangles)?;
            let update = mesh.update(&mut buffers, given.is_whole != 0);
            let told = RlvLevelUpdate::of(&update);
            *object.changed()? = [update.changed_vertices, update.changed_triangles, update.changed_wedges];
            // SAFETY: checked above.
            unsafe { write_optional(out, told) }
        })
    }

    fn rlv_level_changed_ranges(level: RlvLevel, domain: u32, ranges: *mut u32, capacity: usize, count: *mut usize) {
        present("count", count)?;
        let object = registry::get(level)?;
        let _mesh = try_read(&object.mesh, "level")?;
        let changed = object.changed()?;
        let list = match domain {
            RLV_DOMAIN_POINT => &changed[0],
            RLV_DOMAIN_FACE => &changed[1],
            RLV_DOMAIN_CORNER => &changed[2],
            _ => {
                return Err(Error::invalid(format!("there is no domain {domain}"))
                    .at("domain")
                    .advise("use RLV_DOMAIN_POINT, RLV_DOMAIN_FACE or RLV_DOMAIN_CORNER"));
            }
        };
        // SAFETY: checked above.
        unsafe { put(count, list.len()) };
        // SAFETY: the caller promises room for `capacity` pairs, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::<[u32; 2]>::optional("ranges", ranges.cast(), capacity, 0) }? {
            let pairs = list.iter().map(|range| [range.start, range.end - range.start]);
            out.holds("ranges", list.len())?.fill(pairs);
        }
        Ok(())
    }

    fn rlv_level_mesh(level: RlvLevel, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(level)?;
        let active = try_read(&object.mesh, "level")?;
        if active.triangle_count() == 0 {
            return Err(Error::invalid("no triangle is left of it").at("level").advise("make it finer"));
        }
        let (mut mesh, vertices) = active.to_mesh();
        // What the mesh was built with rules.
        if mesh.attribute("normal").is_none() {
            let normals = active.extract().normals;
            let values = vertices.iter().flat_map(|vertex| normals[*vertex as usize]).collect();
            let (name, values) = ("normal".into(), Values::F32(values));
            mesh.attributes.push(Attribute { name, domain: Domain::Point, width: 3, values, indices: None });
        }
        let made = mesh::register(object.context().clone(), mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_level_settle(level: RlvLevel, out: *mut RlvProgressive) {
        present("out", out)?;
        let object = registry::get(level)?;
        let settled = object.change(|mesh| Ok(mesh.settled(&object.context().context)))?;
        let made = progressive::register(object.context().clone(), settled)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
    fn rlv_level_misplaced(level: RlvLevel, out: *mut RlvLevelMisplaced, capacity: usize, count: *mut usize) {
        present("count", count)?;
        let object = registry::get(level)?;
        // SAFETY: the caller promises room for `capacity`.
        let room = unsafe { Output::new("out", out, capacity, 0) }?;
        let found = object.change(|mesh| Ok(mesh.misplaced(&object.context().context)))?;
        room.fill(found.iter().map(|split| RlvLevelMisplaced { point: split.point, told: split.told, now: split.now }));
        // SAFETY: checked above.
        unsafe { put(count, found.len()) };
        Ok(())
    }

    fn rlv_level_rebuild(
        level: RlvLevel,
        options: *const RlvProgressiveOptions,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvProgressive,
    ) {
        present("out", out)?;
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (options, _) = unsafe { progressive::read_options(options, Ok) }?;
        let (context, mut progress) = (&object.context().context, HostProgress { callback: progress, user });
        let made = object.change(|mesh| mesh.rebuilt(context, &options, &mut progress))?;
        let made = progressive::register(object.context().clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
