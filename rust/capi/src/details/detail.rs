//! Details: surfaces with displacement that can be edited; see `include/relievo/detail.h`.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{ArcPool, Context, Error, ErrorKind, Result};
use relievo_detail::{
    AnyObject, Canvas, DecayingObject, DisplacedObject, Imprinter, LayeredObject, TriangleObject, refusal, with_object,
};
use relievo_document::{PageFile, PageStore};
use relievo_tiles::trace::Trace;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{
    Blocks, Change, Channel, ChannelOptions, DecayOptions, Displacement, Paint, Texel, Traces, VectorDisplacement,
};

use crate::border::array::{Input, Output, present, put, text};
use crate::border::descriptor::{check_descriptor, read_optional, write_descriptor};
use crate::border::registry::{self, handle, try_lock};
use crate::border::work::Held;
use crate::details::view::{CHANNELS, ChannelState, View, ViewKind};
use crate::runtime::context::{ContextObject, RLV_LOG_WARNING};
use crate::surfaces::shape::{Shape, only_cages};
use crate::surfaces::surface::{Pose, RlvSurface};

handle!(RlvDetail, 4, DetailObject);

descriptor! {
    pub struct RlvDetailOptions {
        struct_size: u32,
        tile_size: u32,
        budget: u64,
        face_sizes: *const u32,
        face_size_count: usize,
        face_size_stride: usize,
    }
}

descriptor! {
    pub struct RlvPaintOptions {
        struct_size: u32,
        tile_size: u32,
        budget: u64,
        color: [f32; 4],
        format: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvVectorOptions {
        struct_size: u32,
        tile_size: u32,
        budget: u64,
    }
}

descriptor! {
    pub struct RlvDecayOptions {
        struct_size: u32,
        delay: f32,
        duration: f32,
        reserved: u32,
        budget: u64,
    }
}

constants! {
    u32:
    RLV_COLOR_RGBA8 = 0,
    RLV_COLOR_RGBA16F = 1,
    RLV_CHANNEL_DISPLACEMENT = 0,
    RLV_CHANNEL_COLOR = 1,
    RLV_CHANNEL_VECTORS = 2,
    RLV_CHANNEL_TRACES = 3,
}

descriptor! {
    pub struct RlvChannelInfo {
        struct_size: u32,
        is_there: u32,
        allocated_count: usize,
        bytes: u64,
        full_bytes: u64,
        budget: u64,
        texel_size: u32,
        paged_count: u32,
    }
}

descriptor! {
    pub struct RlvDetailFolds {
        struct_size: u32,
        tile: u32,
        triangle_count: u64,
        folded_count: u64,
    }
}

descriptor! {
    pub struct RlvDetailInfo {
        struct_size: u32,
        is_painted: u32,
        tile_count: usize,
        allocated_count: usize,
        revision: u64,
        bytes: u64,
        full_bytes: u64,
        budget: u64,
        painted_count: usize,
        paint_bytes: u64,
        paint_budget: u64,
        time: f64,
        stamp_bytes: u64,
    }
}

descriptor! {
    pub struct RlvDetailChanges {
        struct_size: u32,
        moved: u32,
        revision: u64,
        tile_count: usize,
        low: [f32; 3],
        high: [f32; 3],
    }
}

descriptor! {
    pub struct RlvDetailTileInfo {
        struct_size: u32,
        is_allocated: u32,
        size: u32,
        reserved: u32,
        version: u64,
        block_size: usize,
        low: [f32; 3],
        high: [f32; 3],
    }
}

/// What is asked for is not there.
pub fn missing(channel: u32) -> Error {
    let remedy = match channel {
        RLV_CHANNEL_COLOR => "give it some with rlv_detail_add_paint, and commit",
        RLV_CHANNEL_VECTORS => "give it some with rlv_detail_add_vectors, and commit",
        RLV_CHANNEL_TRACES => "let imprints leave some with rlv_detail_add_traces, and commit",
        _ => "use an RLV_CHANNEL_ value",
    };
    let what = match channel {
        RLV_CHANNEL_COLOR => "the detail has no colours".to_string(),
        RLV_CHANNEL_VECTORS => "the detail has no vector displacement".into(),
        RLV_CHANNEL_TRACES => "the detail has no traces".into(),
        other => format!("there is no channel {other}"),
    };
    Error::invalid(what).at("channel").advise(remedy)
}

/// What a call that edits has to itself.
pub struct Editor {
    pub object: AnyObject,
    pub imprinter: Imprinter,
    /// Tiles whose blocks were put back since the last commit, by channel.
    written: [Vec<Change>; CHANNELS],
    /// How often the cage was posed.
    pose: u64,
    /// Whether the pose or transform changed since the last commit.
    moved: bool,
    /// What was committed lately, for the next commit where nobody looks at one any more.
    views: ArcPool<View>,
}

/// A detail: what is being edited, and what readers see.
pub struct DetailObject {
    pub context: Arc<ContextObject>,
    editor: Mutex<Editor>,
    view: RwLock<Arc<View>>,
    /// Faces of which the last edit that tells was refused tiles.
    refused: Mutex<Vec<u32>>,
    /// Why the processor took over from the graphics device.
    fault: Mutex<Option<Error>>,
}

impl DetailObject {
    /// The detail for a call that edits it. Poses and commits that nobody looks at any more are free for it to write
    /// to.
    ///
    /// # Errors
    /// Fails with `Busy` while another call edits it, and with `Internal` if an earlier panic left it broken.
    pub fn edit(&self) -> Result<Held<MutexGuard<'_, Editor>>> {
        let mut editor = try_lock(&self.editor, "detail")?;
        self.context.gather();
        let live = self.view();
        editor.views.for_each_free(|view| view.release(&live));
        Ok(editor)
    }

    /// Ends an edit. The host hears, once the detail is free, if the processor had to take over from the graphics device.
    pub fn leave(&self, mut editor: Held<MutexGuard<'_, Editor>>) {
        let fault = editor.object.take_device_fault();
        drop(editor);
        if let Some(fault) = fault {
            let text = format!("the processor took over: {fault}");
            *self.fault.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
            self.context.log(RLV_LOG_WARNING, &text);
        }
    }

    /// What was committed last.
    pub fn view(&self) -> Arc<View> {
        // Held only for as long as a clone or an assignment takes.
        self.view.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Returns the object over a Catmull-Clark surface.
///
/// # Errors
/// Fails with `Unsupported`, naming `what` needs such a surface, if it is over a triangle mesh.
pub fn tiles<'a>(object: &'a mut AnyObject, what: &str) -> Result<&'a mut DisplacedObject> {
    match object {
        AnyObject::Tiles(object) => Ok(object),
        AnyObject::Triangles(_) => Err(only_cages(what)),
    }
}

impl Editor {
    /// Returns the object over a Catmull-Clark surface.
    ///
    /// # Errors
    /// Fails as [`tiles`] does.
    pub fn tiles(&mut self, what: &str) -> Result<&mut DisplacedObject> {
        tiles(&mut self.object, what)
    }

    /// What strokes are made on.
    pub fn canvas(&mut self) -> &mut dyn Canvas {
        self.object.canvas()
    }

    /// Bytes that the displacement may occupy.
    pub fn budget(&self) -> u64 {
        with_object!(&self.object, object => object.displacement().budget())
    }

    /// Makes everything up to now a view that follows `before`.
    fn commit(&mut self, context: &Context, before: &View) -> Result<Arc<View>> {
        let cage = before.cage.clone();
        match (&mut self.object, &before.layers) {
            (AnyObject::Tiles(object), ViewKind::Tiles(tiles)) => {
                let view = View::of_tiles(object, cage, tiles.options, self.pose, self.views.take());
                self.views.watch(&view);
                Ok(view)
            }
            (AnyObject::Triangles(object), _) => View::of_triangles(context, object, Some(before), cage, self.pose),
            _ => Err(Error::internal("a detail is of another surface than what was committed")),
        }
    }
}

/// The affine transform of twelve doubles, the identity for NULL.
///
/// # Errors
/// Fails only as [`Input::new`] does, which takes twelve packed doubles.
///
/// # Safety
/// `matrix` is NULL or points to twelve readable doubles.
pub unsafe fn transform(matrix: *const f64) -> Result<DAffine3> {
    if matrix.is_null() {
        return Ok(DAffine3::IDENTITY);
    }
    // SAFETY: promised by the caller.
    let columns = unsafe { Input::new("matrix", matrix, 12, 0) }?;
    let column = |first: usize| DVec3::new(columns.get(first), columns.get(first + 1), columns.get(first + 2));
    let linear = DMat3::from_cols(column(0), column(3), column(6));
    Ok(DAffine3::from_mat3_translation(linear, column(9)))
}

/// The bytes that a channel may occupy.
fn or_default(budget: u64) -> u64 {
    if budget == 0 { ChannelOptions::default().budget } else { budget }
}

fn channel_options(size: u32, budget: u64) -> ChannelOptions {
    let default = ChannelOptions::default();
    let size = if size == 0 { default.size } else { size };
    ChannelOptions { size, budget: or_default(budget), ..default }
}

/// Segments along an edge of a triangle mesh.
fn segments_of(size: u32) -> u32 {
    if size == 0 { 16 } else { size }
}

fn triangle_options(size: u32, budget: u64) -> TriangleOptions {
    TriangleOptions { segments: segments_of(size), budget: or_default(budget) }
}

/// Fails if a detail has `what` already.
fn check_none(there: bool, what: &str) -> Result<()> {
    if there { Err(Error::invalid(format!("it has {what} already")).at("detail")) } else { Ok(()) }
}

entry! {
    fn rlv_detail_create(surface: RlvSurface, options: *const RlvDetailOptions, matrix: *const f64, out: *mut RlvDetail) {
        present("out", out)?;
        let surface = registry::get(surface)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvDetailOptions = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        // SAFETY: the caller promises NULL or twelve doubles.
        let matrix = unsafe { transform(matrix) }?;
        // SAFETY: the caller promises `face_size_count` pairs.
        let sizes = unsafe {
            Input::new("face_sizes", given.face_sizes.cast::<[u32; 2]>(), given.face_size_count, given.face_size_stride)
        }?;
        let budget = or_default(given.budget);
        let context = surface.context.clone();
        let executor = &context.context;
        let Pose { shape, points } = surface.snapshot();
        let fault;
        let (object, view) = match shape {
            Shape::Tiles(limit) => {
                let mut options = channel_options(given.tile_size, given.budget);
                options.face_sizes = sizes.iter().map(|[face, size]| (face, size)).collect();
                let displacement = Displacement::new(limit.topology().clone(), &options)?;
                let mut object = DisplacedObject::new(executor, limit, &points, displacement, matrix)?;
                fault = context.device().and_then(|device| object.use_device(Some(device)).err());
                let view = View::of_tiles(&mut object, surface.cage.clone(), surface.options, 0, None);
                (AnyObject::Tiles(Box::new(object)), view)
            }
            Shape::Triangles(mesh) => {
                if !sizes.is_empty() {
                    return Err(only_cages("sizes of single faces").at("face_sizes"));
                }
                let options = TriangleOptions { segments: segments_of(given.tile_size), budget };
                let displacement = TriangleChannel::displacement(mesh.topology().clone(), &options)?;
                let mut object = TriangleObject::new(executor, (*mesh).clone(), displacement, matrix)?;
                fault = context.device().and_then(|device| object.use_device(Some(device)).err());
                let view = View::of_triangles(executor, &mut object, None, surface.cage.clone(), 0)?;
                (AnyObject::Triangles(Box::new(object)), view)
            }
        };
        let mut views = ArcPool::default();
        views.watch(&view);
        let (imprinter, written) = (Imprinter::new(), Default::default());
        let editor = Editor { object, imprinter, written, pose: 0, moved: false, views };
        let note = fault.as_ref().map(|fault| format!("the processor edits it: {fault}"));
        let handle = registry::insert(DetailObject {
            context: context.clone(),
            editor: Mutex::new(editor),
            view: RwLock::new(view),
            refused: Mutex::default(),
            fault: Mutex::new(fault),
        })?;
        if let Some(note) = note {
            context.log(RLV_LOG_WARNING, &note);
        }
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_detail_retain(detail: RlvDetail) {
        registry::retain(detail)
    }

    fn rlv_detail_release(detail: RlvDetail) {
        registry::release(detail)
    }

    fn rlv_detail_info(detail: RlvDetail, out: *mut RlvDetailInfo) {
        let view = registry::get(detail)?.view();
        let heights = view.channel(RLV_CHANNEL_DISPLACEMENT)?.unwrap_or_default();
        let colors = view.channel(RLV_CHANNEL_COLOR)?.unwrap_or_default();
        let info = RlvDetailInfo {
            struct_size: 0,
            is_painted: u32::from(view.has_paint()),
            tile_count: view.shape().tile_count(),
            allocated_count: heights.allocated,
            revision: view.revision(),
            bytes: heights.bytes,
            full_bytes: view.limits[0][0],
            budget: view.limits[0][1],
            painted_count: colors.allocated,
            paint_bytes: colors.bytes,
            paint_budget: view.limits[1][1],
            time: view.time,
            stamp_bytes: view.stamp_bytes,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_device_fault(detail: RlvDetail) {
        let object = registry::get(detail)?;
        match &*object.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(fault) => Err(fault.clone()),
            None => Ok(()),
        }
    }

    fn rlv_detail_set_budget(detail: RlvDetail, budget: u64) {
        let object = registry::get(detail)?;
        with_object!(&mut object.edit()?.object, object => object.displacement_mut().set_budget(budget));
        Ok(())
    }

    fn rlv_detail_set_paging(detail: RlvDetail, page: u32, folder: *const c_char) {
        let object = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let folder = if folder.is_null() { None } else { Some(unsafe { text("folder", folder) }?) };
        let folder = folder.map(Path::new);
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(Error::new(ErrorKind::NotFound, "there is no such folder").at(folder.display().to_string()));
        }
        let mut editor = object.edit()?;
        let pages: Option<Arc<dyn PageStore>> = (page != 0).then(|| Arc::new(PageFile::new(folder)) as _);
        with_object!(&mut editor.object, displaced => {
            displaced.settle(&object.context.context)?;
            displaced.page_to(pages)
        })
    }

    fn rlv_detail_add_paint(detail: RlvDetail, options: *const RlvPaintOptions) {
        let object = registry::get(detail)?;
        let color = [1.0; 4];
        let white = RlvPaintOptions { struct_size: 0, tile_size: 0, budget: 0, color, format: 0, reserved: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, white) }?;
        let brightest = match given.format {
            RLV_COLOR_RGBA8 => 1.0,
            RLV_COLOR_RGBA16F => 65504.0,
            other => {
                return Err(Error::invalid(format!("there is no format {other} of colours"))
                    .at("format")
                    .advise("use RLV_COLOR_RGBA8 or RLV_COLOR_RGBA16F"));
            }
        };
        if given.color.iter().any(|value| !(0.0..=brightest).contains(value)) {
            return Err(Error::invalid(format!("its numbers are not from 0 to {brightest}")).at("color"));
        }
        let (color, halves) = (Vec4::from(given.color), given.format == RLV_COLOR_RGBA16F);
        match &mut object.edit()?.object {
            AnyObject::Tiles(object) => {
                check_none(object.colors().is_some(), "colours")?;
                let topology = object.surface().topology().clone();
                let options = channel_options(given.tile_size, given.budget);
                if halves {
                    return object.set_half_paint(Paint::of_color(topology, color, &options)?);
                }
                object.set_paint(Paint::of_color(topology, color, &options)?)
            }
            AnyObject::Triangles(object) => {
                check_none(object.colors().is_some(), "colours")?;
                let topology = object.surface().topology().clone();
                let options = triangle_options(given.tile_size, given.budget);
                if halves {
                    return object.set_half_paint(TriangleChannel::of_color(topology, color, &options)?);
                }
                object.set_paint(TriangleChannel::of_color(topology, color, &options)?)
            }
        }
    }

    fn rlv_detail_add_vectors(detail: RlvDetail, options: *const RlvVectorOptions) {
        let object = registry::get(detail)?;
        let default = RlvVectorOptions { struct_size: 0, tile_size: 0, budget: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        match &mut object.edit()?.object {
            AnyObject::Tiles(object) => {
                check_none(object.vectors().is_some(), "vector displacement")?;
                let options = channel_options(given.tile_size, given.budget);
                let vectors = VectorDisplacement::on(object.surface(), &options)?;
                object.set_vectors(vectors)
            }
            AnyObject::Triangles(object) => {
                check_none(object.vectors().is_some(), "vector displacement")?;
                let topology = object.surface().topology().clone();
                object.set_vectors(TriangleChannel::vectors(topology, &triangle_options(given.tile_size, given.budget))?)
            }
        }
    }

    fn rlv_detail_add_traces(detail: RlvDetail, budget: u64) {
        let object = registry::get(detail)?;
        match &mut object.edit()?.object {
            AnyObject::Tiles(object) => {
                check_none(object.traces().is_some(), "traces")?;
                let traces = Traces::of(object.displacement().field(), or_default(budget))?;
                object.set_traces(traces)
            }
            AnyObject::Triangles(object) => {
                check_none(object.traces().is_some(), "traces")?;
                let traces = TriangleChannel::<Trace>::of(object.displacement().field(), or_default(budget))?;
                object.set_traces(traces)
            }
        }
    }

    fn rlv_detail_set_decay(detail: RlvDetail, options: *const RlvDecayOptions) {
        let object = registry::get(detail)?;
        let default = RlvDecayOptions { struct_size: 0, delay: 0.0, duration: 10.0, reserved: 0, budget: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        let mut editor = object.edit()?;
        if with_object!(&editor.object, object => object.is_fading()) {
            return Err(Error::invalid("its edits fade already").at("detail"));
        }
        let options = DecayOptions { delay: given.delay, duration: given.duration };
        with_object!(&mut editor.object, object => object.set_decay(options, or_default(given.budget)))
    }

    fn rlv_detail_advance(detail: RlvDetail, time: f64) {
        let object = registry::get(detail)?;
        let mut editor = object.edit()?;
        let (before, is_fading) = with_object!(&editor.object, object => (object.time(), object.is_fading()));
        if is_fading && time < before {
            return Err(Error::invalid(format!("edits that fade are at {before} s, and {time} s is before that"))
                .at("time")
                .advise("put back blocks of an earlier time in a new detail"));
        }
        let context = &object.context.context;
        let refused = with_object!(&mut editor.object, displaced => {
            displaced.settle(context)?;
            let refused = displaced.stamp(context)?.len();
            displaced.advance(context, time)?;
            refused
        });
        // The log may call back.
        drop(editor);
        if refused > 0 {
            let text = format!("edits of {refused} tiles will not fade: their time stamps exceed the budget");
            object.context.log(RLV_LOG_WARNING, &text);
        }
        Ok(())
    }

    fn rlv_detail_channel_info(detail: RlvDetail, channel: u32, out: *mut RlvChannelInfo) {
        let view = registry::get(detail)?.view();
        let [full_bytes, budget] = *view.limits.get(channel as usize).ok_or_else(|| missing(channel))?;
        let found = view.channel(channel)?;
        let is_there = u32::from(found.is_some());
        let ChannelState { allocated: allocated_count, paged, bytes, texel_size } = found.unwrap_or_default();
        let info = RlvChannelInfo {
            struct_size: 0,
            is_there,
            allocated_count,
            bytes,
            full_bytes,
            budget,
            texel_size: texel_size as u32,
            paged_count: paged as u32,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_folds(detail: RlvDetail, out: *mut RlvDetailFolds) {
        let object = registry::get(detail)?;
        let folds = object.view().folds(&object.context.context)?;
        let folds = RlvDetailFolds {
            struct_size: 0,
            tile: folds.worst.unwrap_or(u32::MAX),
            triangle_count: folds.triangles,
            folded_count: folds.folded,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, folds) }
    }

    fn rlv_detail_set_face_sizes(detail: RlvDetail, face_sizes: *const u32, count: usize, stride: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `count` pairs.
        let sizes = unsafe { Input::new("face_sizes", face_sizes.cast::<[u32; 2]>(), count, stride) }?;
        let sizes = sizes.to_vec("face_sizes", object.context.context.memory_limit())?;
        let sizes: Vec<(u32, u32)> = sizes.into_iter().map(|[face, size]| (face, size)).collect();
        let mut editor = object.edit()?;
        let context = &object.context.context;
        let displaced = editor.tiles("sizes of single faces")?;
        let displacement = displaced.displacement_mut();
        let before = displacement.clone();
        let mut refused = displacement.resize(context, &sizes)?;
        let budget = displacement.budget();
        // Traces have the sizes of the displacement.
        match displaced.traces_mut().map(|traces| traces.resize(context, &sizes)) {
            None => {}
            Some(Ok(more)) => refused.extend(more),
            Some(Err(error)) => {
                *displaced.displacement_mut() = before;
                return Err(error.at("traces"));
            }
        }
        // The log may call back.
        drop(editor);
        log_refusal(&object, &refused, budget);
        Ok(())
    }

    fn rlv_detail_set_transform(detail: RlvDetail, matrix: *const f64) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises NULL or twelve doubles.
        let matrix = unsafe { transform(matrix) }?;
        let mut editor = object.edit()?;
        with_object!(&mut editor.object, object => object.set_transform(matrix))?;
        editor.moved = true;
        Ok(())
    }

    fn rlv_detail_set_points(detail: RlvDetail, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Vec<[f32; 3]>>();
        points.copy_to("points", context.memory_limit(), &mut room)?;
        let mut editor = object.edit()?;
        with_object!(&mut editor.object, it => it.pose(context, &room))?;
        editor.pose += 1;
        editor.moved = true;
        object.leave(editor);
        Ok(())
    }

    fn rlv_detail_commit(detail: RlvDetail, out: *mut RlvDetailChanges) {
        let object = registry::get(detail)?;
        if !out.is_null() {
            // SAFETY: the caller gives a descriptor that starts with its size.
            unsafe { check_descriptor(out) }?;
        }
        let mut editor = object.edit()?;
        let context = &object.context.context;
        with_object!(&editor.object, object => object.report_fault())?;
        let [heights, colors, directions, contacts] = std::mem::take(&mut editor.written);
        if let AnyObject::Tiles(displaced) = &mut editor.object {
            if !heights.is_empty() {
                displaced.displacement_mut().update_rings(context, &heights)?;
            }
            bring_rings(context, displaced.paint_mut(), &colors)?;
            bring_rings(context, displaced.half_paint_mut(), &colors)?;
            // Reached for writing, what was measured of the object is forgotten.
            if !directions.is_empty() {
                bring_rings(context, displaced.vectors_mut(), &directions)?;
            }
            bring_rings(context, displaced.traces_mut(), &contacts)?;
        }
        // A stroke that is being drawn is seen as far as it got.
        with_object!(&mut editor.object, object => object.settle_colors(context))?;
        let view = editor.commit(context, &object.view())?;
        let moved = std::mem::take(&mut editor.moved);
        *object.view.write().unwrap_or_else(PoisonError::into_inner) = view.clone();
        drop(editor);
        if out.is_null() {
            return Ok(());
        }
        let tiles = &view.changed;
        let (low, high) = view.bounds(tiles)?.unwrap_or_default();
        let changes = RlvDetailChanges {
            struct_size: 0,
            moved: u32::from(moved),
            revision: view.revision(),
            tile_count: tiles.len(),
            low,
            high,
        };
        // SAFETY: the caller gives a descriptor that starts with its size.
        unsafe { write_descriptor(out, changes) }
    }

    fn rlv_detail_changed_tiles(detail: RlvDetail, tiles: *mut u32, capacity: usize, count: *mut usize) {
        present("count", count)?;
        let view = registry::get(detail)?.view();
        let changed = &view.changed;
        // SAFETY: checked above.
        unsafe { put(count, changed.len()) };
        // SAFETY: the caller promises room for `capacity` tiles, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::optional("tiles", tiles, capacity, 0) }? {
            out.holds("tiles", changed.len())?.fill(changed.iter().copied());
        }
        Ok(())
    }

    fn rlv_detail_refused_faces(detail: RlvDetail, faces: *mut u32, capacity: usize, count: *mut usize) {
        present("count", count)?;
        let object = registry::get(detail)?;
        let refused = object.refused.lock().unwrap_or_else(PoisonError::into_inner).clone();
        // SAFETY: checked above.
        unsafe { put(count, refused.len()) };
        // SAFETY: the caller promises room for `capacity` faces, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::optional("faces", faces, capacity, 0) }? {
            out.holds("faces", refused.len())?.fill(refused.iter().copied());
        }
        Ok(())
    }

    fn rlv_detail_tile_info(detail: RlvDetail, channel: u32, tile: u32, out: *mut RlvDetailTileInfo) {
        let view = registry::get(detail)?.view();
        let state = view.tile(channel, tile, false)?;
        let (low, high) = view.bounds(&[tile])?.unwrap_or_default();
        let info = RlvDetailTileInfo {
            struct_size: 0,
            is_allocated: u32::from(state.is_allocated),
            size: state.size,
            reserved: 0,
            version: state.version,
            block_size: usize::try_from(state.block_bytes).unwrap_or(usize::MAX),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_read_block(
        detail: RlvDetail,
        channel: u32,
        tile: u32,
        bytes: *mut c_void,
        capacity: usize,
        size: *mut usize,
    ) {
        present("size", size)?;
        let view = registry::get(detail)?.view();
        let block = view.tile(channel, tile, true)?.block.unwrap_or_default();
        // SAFETY: checked above.
        unsafe { put(size, block.len()) };
        // SAFETY: the caller promises `capacity` bytes, or NULL to ask for the size alone.
        if let Some(out) = unsafe { Output::<u8>::optional("bytes", bytes.cast(), capacity, 0) }? {
            out.holds("bytes", block.len())?.fill(block.iter().copied());
        }
        Ok(())
    }

    fn rlv_detail_write_block(detail: RlvDetail, channel: u32, tile: u32, bytes: *const c_void, size: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { Input::<u8>::new("bytes", bytes.cast(), size, 0) }?;
        let bytes = bytes.to_vec("bytes", object.context.context.memory_limit())?;
        let mut editor = object.edit()?;
        let block = if size == 0 { None } else { Some(bytes.as_slice()) };
        let displaced = editor.tiles("blocks of single faces")?;
        let colors = displaced.layers().iter().filter(|layer| layer.kind.is_color()).count();
        if channel == RLV_CHANNEL_COLOR && colors > 1 {
            return Err(Error::unsupported("blocks of colours cannot be put back where they have several layers")
                .at("channel")
                .advise("keep the edits in a document"));
        }
        match channel {
            RLV_CHANNEL_DISPLACEMENT => Some(displaced.displacement_mut().write(tile, block)),
            RLV_CHANNEL_COLOR => match displaced.half_paint_mut() {
                Some(halves) => Some(halves.write(tile, block)),
                None => displaced.paint_mut().map(|it| it.write(tile, block)),
            },
            RLV_CHANNEL_VECTORS => displaced.vectors_mut().map(|it| it.write(tile, block)),
            RLV_CHANNEL_TRACES => displaced.traces_mut().map(|it| it.write(tile, block)),
            _ => None,
        }
        .ok_or_else(|| missing(channel))??;
        editor.written[channel as usize].push(Change::all(tile));
        Ok(())
    }
}

/// Gives traces the sizes of the displacement, after that was replaced.
///
/// # Errors
/// Fails with `Memory` if the budget of the traces does not allow the sizes.
pub fn fit_traces(context: &Context, object: &mut DisplacedObject) -> Result<()> {
    let sizes: Vec<(u32, u32)> = (0..).zip(object.displacement().field().face_sizes()).collect();
    match object.traces_mut() {
        Some(traces) => traces.resize(context, &sizes).map(drop).map_err(|error| error.at("traces")),
        None => Ok(()),
    }
}

/// Brings the rings of blocks that were put back up to date.
fn bring_rings<T: Texel>(context: &Context, channel: Option<&mut Channel<T>>, changes: &[Change]) -> Result<()> {
    match channel {
        Some(channel) if !changes.is_empty() => channel.update_rings(context, changes).map(drop),
        _ => Ok(()),
    }
}

/// Tells the host that tiles could not be had.
pub fn log_refusal(detail: &DetailObject, refused: &[u32], budget: u64) {
    let mut faces = match &detail.view().layers {
        ViewKind::Tiles(it) => refusal::faces(it.surface.topology(), refused),
        // What triangle meshes keep is counted by faces.
        ViewKind::Triangles(_) => refused.to_vec(),
    };
    faces.sort_unstable();
    faces.dedup();
    let named = if refused.is_empty() { String::new() } else { refusal::named(&faces) };
    *detail.refused.lock().unwrap_or_else(PoisonError::into_inner) = faces;
    if !refused.is_empty() {
        let text = format!("{} tiles were refused by the budget of {budget} bytes: {named}", refused.len());
        detail.context.log(RLV_LOG_WARNING, &text);
    }
}
