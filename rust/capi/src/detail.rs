//! Details: surfaces with displacement that can be edited; see `include/relievo/detail.h`.

use std::ffi::c_void;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError};

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{DisplacedObject, Imprinter, LayeredObject};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::trace::Trace;
use relievo_tiles::{
    Blocks, Change, Channel, ChannelOptions, DecayOptions, Displaced, Displacement, DisplacementOptions, Field, Paint,
    Rgba8, Snapshot, Texel, Traces, Vector, VectorDisplacement,
};

use crate::array::{Input, Output, present, put};
use crate::context::{ContextObject, RLV_LOG_WARNING};
use crate::descriptor::{check_descriptor, read_optional, write_descriptor};
use crate::registry::{self, broken, busy, handle};
use crate::surface::{RlvSurface, check_tile};

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
        reserved: u32,
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

/// A detail as it was committed last. It never changes.
pub struct View {
    pub surface: Surface,
    /// The cage the surface was made from, with its attributes.
    pub cage: Arc<Mesh>,
    /// How the surface was made.
    pub options: SurfaceOptions,
    pub snapshot: Arc<Snapshot>,
    /// Colours, if the detail has any.
    pub paint: Option<Arc<Snapshot<Rgba8>>>,
    pub vectors: Option<Arc<Snapshot<Vector>>>,
    pub traces: Option<Arc<Snapshot<Trace>>>,
    /// When edits were made, in seconds.
    pub time: f64,
    /// Tiles that changed with the commit, ascending.
    pub changed: Vec<u32>,
    pub transform: DAffine3,
    /// How often the cage was posed before.
    pub pose: u64,
    /// Bytes of every channel with all its tiles, and its budget.
    limits: [[u64; 2]; CHANNELS],
    /// Bytes of the time stamps of edits that fade.
    stamp_bytes: u64,
}

/// How many channels a detail may have.
const CHANNELS: usize = 4;

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

/// A tile of any channel.
struct TileState {
    is_allocated: bool,
    size: u32,
    version: u64,
    block_bytes: u64,
    block: Option<Vec<u8>>,
}

impl TileState {
    /// With its bytes if they are `wanted`.
    fn of<T: Texel>(field: &Field<T>, tile: u32, wanted: bool) -> Self {
        Self {
            is_allocated: field.is_allocated(tile),
            size: field.size(tile),
            version: field.version(tile),
            block_bytes: field.block_bytes(tile),
            block: field.block(tile).filter(|_| wanted).map(|block| bytemuck::cast_slice(block).to_vec()),
        }
    }
}

impl View {
    /// The surface with its displacement.
    pub fn displaced(&self) -> Result<Displaced<'_>> {
        let displaced = Displaced::new(&self.surface, self.snapshot.field())?;
        match &self.vectors {
            Some(vectors) => displaced.with_vectors(vectors.field()),
            None => Ok(displaced),
        }
    }

    /// A number that grows with every edit.
    pub fn revision(&self) -> u64 {
        let paint = self.paint.as_ref().map_or(0, |paint| paint.revision());
        let traces = self.traces.as_ref().map_or(0, |traces| traces.revision());
        self.snapshot.revision() + paint + traces + self.vectors.as_ref().map_or(0, |vectors| vectors.revision())
    }

    /// The numbers of the edits that changed `tile` last, by channel.
    pub fn versions(&self, tile: u32) -> [u64; CHANNELS] {
        let paint = self.paint.as_ref().map_or(0, |paint| paint.field().version(tile));
        let vectors = self.vectors.as_ref().map_or(0, |vectors| vectors.field().version(tile));
        let traces = self.traces.as_ref().map_or(0, |traces| traces.field().version(tile));
        [self.snapshot.field().version(tile), paint, vectors, traces]
    }

    /// A tile of a channel, with its bytes if they are `wanted`. Fails if there is no such channel.
    fn tile(&self, channel: u32, tile: u32, wanted: bool) -> Result<TileState> {
        check_tile(&self.surface, tile)?;
        match channel {
            RLV_CHANNEL_DISPLACEMENT => Some(TileState::of(self.snapshot.field(), tile, wanted)),
            RLV_CHANNEL_COLOR => self.paint.as_ref().map(|it| TileState::of(it.field(), tile, wanted)),
            RLV_CHANNEL_VECTORS => self.vectors.as_ref().map(|it| TileState::of(it.field(), tile, wanted)),
            RLV_CHANNEL_TRACES => self.traces.as_ref().map(|it| TileState::of(it.field(), tile, wanted)),
            _ => None,
        }
        .ok_or_else(|| missing(channel))
    }

    /// Texels along an edge of the cage at `tile`, the most of what is allocated there.
    pub fn density(&self, tile: u32) -> u32 {
        let paint = self.paint.as_ref().map_or(0, |paint| paint.field().density(tile));
        let vectors = self.vectors.as_ref().map_or(0, |vectors| vectors.field().density(tile));
        let traces = self.traces.as_ref().map_or(0, |traces| traces.field().density(tile));
        self.snapshot.field().density(tile).max(paint).max(vectors).max(traces)
    }
}

/// What a call that edits has to itself.
pub struct Editor {
    pub object: DisplacedObject,
    pub imprinter: Imprinter,
    /// Tiles whose blocks were put back since the last commit, by channel.
    written: [Vec<Change>; CHANNELS],
    /// How often the cage was posed.
    pose: u64,
    /// Whether the pose or transform changed since the last commit.
    moved: bool,
}

/// A detail: what is being edited, and what readers see.
pub struct DetailObject {
    pub context: Arc<ContextObject>,
    editor: Mutex<Editor>,
    view: RwLock<Arc<View>>,
}

impl DetailObject {
    /// The detail for a call that edits it; fails as busy while another one does.
    pub fn edit(&self) -> Result<MutexGuard<'_, Editor>> {
        match self.editor.try_lock() {
            Ok(editor) => Ok(editor),
            Err(TryLockError::WouldBlock) => Err(busy("detail")),
            Err(TryLockError::Poisoned(_)) => Err(broken("detail")),
        }
    }

    /// What was committed last.
    pub fn view(&self) -> Arc<View> {
        // Held only for as long as a clone or an assignment takes.
        self.view.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// What is committed of a channel, which adds its changed tiles and says how large it may be.
fn commit_channel<T: Texel>(
    channel: Option<&mut Channel<T>>,
    changed: &mut Vec<u32>,
) -> (Option<Arc<Snapshot<T>>>, [u64; 2]) {
    let Some(channel) = channel else { return (None, [0; 2]) };
    let snapshot = channel.commit();
    changed.extend(snapshot.changed());
    (Some(snapshot), [channel.full_bytes(), channel.budget()])
}

/// Makes everything up to now a view.
fn commit(object: &mut DisplacedObject, cage: Arc<Mesh>, options: SurfaceOptions, pose: u64) -> Arc<View> {
    let snapshot = object.commit();
    let mut changed = snapshot.changed().to_vec();
    let heights = [object.displacement().full_bytes(), object.displacement().budget()];
    let (paint, colors) = commit_channel(object.paint_mut(), &mut changed);
    let (vectors, directions) = commit_channel(object.vectors_mut(), &mut changed);
    let (traces, contacts) = commit_channel(object.traces_mut(), &mut changed);
    changed.sort_unstable();
    changed.dedup();
    Arc::new(View {
        surface: object.surface().clone(),
        cage,
        options,
        snapshot,
        paint,
        vectors,
        traces,
        time: object.time(),
        changed,
        transform: *object.transform(),
        pose,
        limits: [heights, colors, directions, contacts],
        stamp_bytes: object.fading().map_or(0, |fading| fading.displacement.bytes() + fading.paint.bytes()),
    })
}

/// The affine transform of twelve doubles, the identity for NULL.
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
        let mut options = DisplacementOptions::default();
        if given.tile_size != 0 {
            options.size = given.tile_size;
        }
        if given.budget != 0 {
            options.budget = given.budget;
        }
        // SAFETY: the caller promises `face_size_count` pairs.
        let sizes = unsafe {
            Input::new("face_sizes", given.face_sizes.cast::<[u32; 2]>(), given.face_size_count, given.face_size_stride)
        }?;
        options.face_sizes = sizes.iter().map(|[face, size]| (face, size)).collect();
        let context = surface.context.clone();
        let pose = surface.snapshot();
        let displacement = Displacement::new(pose.surface.topology().clone(), &options)?;
        let mut object = DisplacedObject::new(&context.context, pose.surface, &pose.points, displacement, matrix)?;
        let view = RwLock::new(commit(&mut object, surface.cage.clone(), surface.options, 0));
        let editor = Editor { object, imprinter: Imprinter::new(), written: Default::default(), pose: 0, moved: false };
        let handle = registry::insert(DetailObject { context, editor: Mutex::new(editor), view })?;
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
        let info = RlvDetailInfo {
            struct_size: 0,
            is_painted: u32::from(view.paint.is_some()),
            tile_count: view.surface.tile_count(),
            allocated_count: view.snapshot.field().allocated().count(),
            revision: view.revision(),
            bytes: view.snapshot.bytes(),
            full_bytes: view.limits[0][0],
            budget: view.limits[0][1],
            painted_count: view.paint.as_ref().map_or(0, |paint| paint.field().allocated().count()),
            paint_bytes: view.paint.as_ref().map_or(0, |paint| paint.bytes()),
            paint_budget: view.limits[1][1],
            time: view.time,
            stamp_bytes: view.stamp_bytes,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_set_budget(detail: RlvDetail, budget: u64) {
        let object = registry::get(detail)?;
        object.edit()?.object.displacement_mut().set_budget(budget);
        Ok(())
    }

    fn rlv_detail_add_paint(detail: RlvDetail, options: *const RlvPaintOptions) {
        let object = registry::get(detail)?;
        let white = RlvPaintOptions { struct_size: 0, tile_size: 0, budget: 0, color: [1.0; 4] };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, white) }?;
        if given.color.iter().any(|value| !(0.0..=1.0).contains(value)) {
            return Err(Error::invalid("its numbers are not from 0 to 1").at("color"));
        }
        let mut channel = ChannelOptions::default();
        if given.tile_size != 0 {
            channel.size = given.tile_size;
        }
        if given.budget != 0 {
            channel.budget = given.budget;
        }
        let mut editor = object.edit()?;
        if editor.object.paint().is_some() {
            return Err(Error::invalid("it has colours already").at("detail"));
        }
        let topology = editor.object.surface().topology().clone();
        editor.object.set_paint(Paint::of_color(topology, Vec4::from(given.color), &channel)?)
    }

    fn rlv_detail_add_vectors(detail: RlvDetail, options: *const RlvVectorOptions) {
        let object = registry::get(detail)?;
        let default = RlvVectorOptions { struct_size: 0, tile_size: 0, budget: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        let mut channel = ChannelOptions::default();
        if given.tile_size != 0 {
            channel.size = given.tile_size;
        }
        if given.budget != 0 {
            channel.budget = given.budget;
        }
        let mut editor = object.edit()?;
        if editor.object.vectors().is_some() {
            return Err(Error::invalid("it has vector displacement already").at("detail"));
        }
        let vectors = VectorDisplacement::on(editor.object.surface(), &channel)?;
        editor.object.set_vectors(vectors)
    }

    fn rlv_detail_add_traces(detail: RlvDetail, budget: u64) {
        let object = registry::get(detail)?;
        let mut editor = object.edit()?;
        if editor.object.traces().is_some() {
            return Err(Error::invalid("it has traces already").at("detail"));
        }
        let budget = if budget == 0 { ChannelOptions::default().budget } else { budget };
        let traces = Traces::of(editor.object.displacement().field(), budget)?;
        editor.object.set_traces(traces)
    }

    fn rlv_detail_set_decay(detail: RlvDetail, options: *const RlvDecayOptions) {
        let object = registry::get(detail)?;
        let default = RlvDecayOptions { struct_size: 0, delay: 0.0, duration: 10.0, reserved: 0, budget: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        let budget = if given.budget == 0 { ChannelOptions::default().budget } else { given.budget };
        let mut editor = object.edit()?;
        if editor.object.fading().is_some() {
            return Err(Error::invalid("its edits fade already").at("detail"));
        }
        let layers = editor.object.layers();
        if [true, false].iter().any(|color| layers.iter().filter(|layer| layer.kind.is_color() == *color).count() > 1) {
            return Err(Error::unsupported("edits that fade are on one layer").advise("flatten the layers first"));
        }
        editor.object.set_decay(DecayOptions { delay: given.delay, duration: given.duration }, budget)
    }

    fn rlv_detail_advance(detail: RlvDetail, time: f64) {
        let object = registry::get(detail)?;
        let mut editor = object.edit()?;
        let before = editor.object.time();
        if editor.object.fading().is_some() && time < before {
            return Err(Error::invalid(format!("edits that fade are at {before} s, and {time} s is before that"))
                .at("time")
                .advise("put back blocks of an earlier time in a new detail"));
        }
        let refused = editor.object.stamp(&object.context.context).len();
        editor.object.advance(&object.context.context, time)?;
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
        fn state<T: Texel>(snapshot: &Arc<Snapshot<T>>) -> (usize, u64, usize) {
            (snapshot.field().allocated().count(), snapshot.bytes(), size_of::<T>())
        }
        let found = match channel {
            RLV_CHANNEL_COLOR => view.paint.as_ref().map(state),
            RLV_CHANNEL_VECTORS => view.vectors.as_ref().map(state),
            RLV_CHANNEL_TRACES => view.traces.as_ref().map(state),
            _ => Some(state(&view.snapshot)),
        };
        let (allocated_count, bytes, texel_size) = found.unwrap_or_default();
        let info = RlvChannelInfo {
            struct_size: 0,
            is_there: u32::from(found.is_some()),
            allocated_count,
            bytes,
            full_bytes,
            budget,
            texel_size: texel_size as u32,
            reserved: 0,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_set_face_sizes(detail: RlvDetail, face_sizes: *const u32, count: usize, stride: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `count` pairs.
        let sizes = unsafe { Input::new("face_sizes", face_sizes.cast::<[u32; 2]>(), count, stride) }?;
        let sizes = sizes.to_vec("face_sizes", object.context.context.memory_limit())?;
        let sizes: Vec<(u32, u32)> = sizes.into_iter().map(|[face, size]| (face, size)).collect();
        let mut editor = object.edit()?;
        let context = &object.context.context;
        let displacement = editor.object.displacement_mut();
        let before = displacement.clone();
        let mut refused = displacement.resize(context, &sizes)?;
        let budget = displacement.budget();
        // Traces have the sizes of the displacement.
        match editor.object.traces_mut().map(|traces| traces.resize(context, &sizes)) {
            None => {}
            Some(Ok(more)) => refused.extend(more),
            Some(Err(error)) => {
                *editor.object.displacement_mut() = before;
                return Err(error.at("traces"));
            }
        }
        // The log may call back.
        drop(editor);
        log_refusal(&object.context, refused.len(), budget);
        Ok(())
    }

    fn rlv_detail_set_transform(detail: RlvDetail, matrix: *const f64) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises NULL or twelve doubles.
        let matrix = unsafe { transform(matrix) }?;
        let mut editor = object.edit()?;
        editor.object.set_transform(matrix)?;
        editor.moved = true;
        Ok(())
    }

    fn rlv_detail_set_points(detail: RlvDetail, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let points = points.to_vec("points", object.context.context.memory_limit())?;
        let mut editor = object.edit()?;
        editor.object.pose(&object.context.context, &points)?;
        editor.pose += 1;
        editor.moved = true;
        Ok(())
    }

    fn rlv_detail_commit(detail: RlvDetail, out: *mut RlvDetailChanges) {
        let object = registry::get(detail)?;
        if !out.is_null() {
            // SAFETY: the caller gives a descriptor that starts with its size.
            unsafe { check_descriptor(out) }?;
        }
        let mut editor = object.edit()?;
        let Editor { object: displaced, written, pose, moved, .. } = &mut *editor;
        let context = &object.context.context;
        let [heights, colors, directions, contacts] = std::mem::take(written);
        if !heights.is_empty() {
            displaced.displacement_mut().update_rings(context, &heights)?;
        }
        bring_rings(context, displaced.paint_mut(), &colors)?;
        bring_rings(context, displaced.vectors_mut(), &directions)?;
        bring_rings(context, displaced.traces_mut(), &contacts)?;
        // A stroke that is being drawn is seen as far as it got.
        displaced.settle_colors(&object.context.context)?;
        let before = object.view();
        let view = commit(displaced, before.cage.clone(), before.options, *pose);
        let moved = std::mem::take(moved);
        *object.view.write().unwrap_or_else(PoisonError::into_inner) = view.clone();
        drop(editor);
        if out.is_null() {
            return Ok(());
        }
        let tiles = &view.changed;
        let surface = view.displaced()?;
        let bounds = tiles.iter().map(|tile| surface.tile_bounds(*tile)).reduce(|a, b| {
            (std::array::from_fn(|axis| a.0[axis].min(b.0[axis])), std::array::from_fn(|axis| a.1[axis].max(b.1[axis])))
        });
        let (low, high) = bounds.unwrap_or_default();
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
        // SAFETY: the caller promises room for `capacity` tiles, or NULL to ask for the number alone.
        if let Some(out) = unsafe { Output::optional("tiles", tiles, capacity, 0) }? {
            out.holds("tiles", changed.len())?.fill(changed.iter().copied());
        }
        // SAFETY: checked above.
        unsafe { put(count, changed.len()) };
        Ok(())
    }

    fn rlv_detail_tile_info(detail: RlvDetail, channel: u32, tile: u32, out: *mut RlvDetailTileInfo) {
        let view = registry::get(detail)?.view();
        let state = view.tile(channel, tile, false)?;
        let (low, high) = view.displaced()?.tile_bounds(tile);
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
        // SAFETY: the caller promises `capacity` bytes, or NULL to ask for the size alone.
        if let Some(out) = unsafe { Output::<u8>::optional("bytes", bytes.cast(), capacity, 0) }? {
            out.holds("bytes", block.len())?.fill(block.iter().copied());
        }
        // SAFETY: checked above.
        unsafe { put(size, block.len()) };
        Ok(())
    }

    fn rlv_detail_write_block(detail: RlvDetail, channel: u32, tile: u32, bytes: *const c_void, size: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { Input::<u8>::new("bytes", bytes.cast(), size, 0) }?;
        let bytes = bytes.to_vec("bytes", object.context.context.memory_limit())?;
        let mut editor = object.edit()?;
        let block = if size == 0 { None } else { Some(bytes.as_slice()) };
        let colors = editor.object.layers().iter().filter(|layer| layer.kind.is_color()).count();
        if channel == RLV_CHANNEL_COLOR && colors > 1 {
            return Err(Error::unsupported("blocks of colours cannot be put back where they have several layers")
                .at("channel")
                .advise("keep the edits in a document"));
        }
        let displaced = &mut editor.object;
        match channel {
            RLV_CHANNEL_DISPLACEMENT => Some(displaced.displacement_mut().write(tile, block)),
            RLV_CHANNEL_COLOR => displaced.paint_mut().map(|it| it.write(tile, block)),
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
pub fn log_refusal(context: &ContextObject, refused: usize, budget: u64) {
    if refused > 0 {
        context.log(RLV_LOG_WARNING, &format!("{refused} tiles were refused by the budget of {budget} bytes"));
    }
}
