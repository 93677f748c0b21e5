//! Details: surfaces with displacement that can be edited; see `include/relievo/detail.h`.

use std::ffi::c_void;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError};

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Error, Mesh, Result};
use relievo_detail::{DisplacedObject, Imprinter, LayeredObject};
use relievo_surface::Surface;
use relievo_tiles::{
    Change, ChannelOptions, Displaced, Displacement, DisplacementOptions, Paint, Rgba8, Snapshot, Vector,
    VectorDisplacement,
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
    pub snapshot: Arc<Snapshot>,
    /// Colours, if the detail has any.
    pub paint: Option<Arc<Snapshot<Rgba8>>>,
    pub vectors: Option<Arc<Snapshot<Vector>>>,
    /// Tiles that changed with the commit, ascending.
    pub changed: Vec<u32>,
    pub transform: DAffine3,
    /// How often the cage was posed before.
    pub pose: u64,
    full_bytes: u64,
    budget: u64,
    paint_budget: u64,
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
        self.snapshot.revision() + paint + self.vectors.as_ref().map_or(0, |vectors| vectors.revision())
    }

    /// The numbers of the edits that changed `tile` last, by channel.
    pub fn versions(&self, tile: u32) -> [u64; 3] {
        let paint = self.paint.as_ref().map_or(0, |paint| paint.field().version(tile));
        let vectors = self.vectors.as_ref().map_or(0, |vectors| vectors.field().version(tile));
        [self.snapshot.field().version(tile), paint, vectors]
    }

    /// Texels along an edge of the cage at `tile`, the most of what is allocated there.
    pub fn density(&self, tile: u32) -> u32 {
        let paint = self.paint.as_ref().map_or(0, |paint| paint.field().density(tile));
        let vectors = self.vectors.as_ref().map_or(0, |vectors| vectors.field().density(tile));
        self.snapshot.field().density(tile).max(paint).max(vectors)
    }
}

/// What a call that edits has to itself.
pub struct Editor {
    pub object: DisplacedObject,
    pub imprinter: Imprinter,
    /// Tiles whose blocks were put back since the last commit.
    written: Vec<Change>,
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

/// Makes everything up to now a view.
fn commit(object: &mut DisplacedObject, cage: Arc<Mesh>, pose: u64) -> Arc<View> {
    let snapshot = object.commit();
    let paint = object.paint_mut().map(Paint::commit);
    let vectors = object.vectors_mut().map(VectorDisplacement::commit);
    let mut changed = snapshot.changed().to_vec();
    changed.extend(paint.iter().flat_map(|paint| paint.changed()));
    changed.extend(vectors.iter().flat_map(|vectors| vectors.changed()));
    changed.sort_unstable();
    changed.dedup();
    let displacement = object.displacement();
    Arc::new(View {
        surface: object.surface().clone(),
        cage,
        snapshot,
        paint,
        vectors,
        changed,
        transform: *object.transform(),
        pose,
        full_bytes: displacement.full_bytes(),
        budget: displacement.budget(),
        paint_budget: object.paint().map_or(0, |paint| paint.budget()),
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
        let view = RwLock::new(commit(&mut object, surface.cage.clone(), 0));
        let editor = Editor { object, imprinter: Imprinter::new(), written: Vec::new(), pose: 0, moved: false };
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
            full_bytes: view.full_bytes,
            budget: view.budget,
            painted_count: view.paint.as_ref().map_or(0, |paint| paint.field().allocated().count()),
            paint_bytes: view.paint.as_ref().map_or(0, |paint| paint.bytes()),
            paint_budget: view.paint_budget,
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

    fn rlv_detail_set_face_sizes(detail: RlvDetail, face_sizes: *const u32, count: usize, stride: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `count` pairs.
        let sizes = unsafe { Input::new("face_sizes", face_sizes.cast::<[u32; 2]>(), count, stride) }?;
        let sizes = sizes.to_vec("face_sizes", object.context.context.memory_limit())?;
        let sizes: Vec<(u32, u32)> = sizes.into_iter().map(|[face, size]| (face, size)).collect();
        let mut editor = object.edit()?;
        let displacement = editor.object.displacement_mut();
        let refused = displacement.resize(&object.context.context, &sizes)?;
        let budget = displacement.budget();
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
        if !written.is_empty() {
            displaced.displacement_mut().update_rings(&object.context.context, written)?;
            written.clear();
        }
        // A stroke that is being drawn is seen as far as it got.
        displaced.settle_colors(&object.context.context)?;
        let view = commit(displaced, object.view().cage.clone(), *pose);
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

    fn rlv_detail_tile_info(detail: RlvDetail, tile: u32, out: *mut RlvDetailTileInfo) {
        let view = registry::get(detail)?.view();
        check_tile(&view.surface, tile)?;
        let field = view.snapshot.field();
        let (low, high) = view.displaced()?.tile_bounds(tile);
        let info = RlvDetailTileInfo {
            struct_size: 0,
            is_allocated: u32::from(field.is_allocated(tile)),
            size: field.size(tile),
            reserved: 0,
            version: field.version(tile),
            block_size: usize::try_from(field.block_bytes(tile)).unwrap_or(usize::MAX),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_detail_read_block(detail: RlvDetail, tile: u32, bytes: *mut c_void, capacity: usize, size: *mut usize) {
        present("size", size)?;
        let view = registry::get(detail)?.view();
        check_tile(&view.surface, tile)?;
        let block = view.snapshot.field().block(tile).unwrap_or(&[]);
        let length = 2 * block.len();
        // SAFETY: the caller promises `capacity` bytes, or NULL to ask for the size alone.
        if let Some(out) = unsafe { Output::<u8>::optional("bytes", bytes.cast(), capacity, 0) }? {
            out.holds("bytes", length)?.fill(block.iter().flat_map(|coefficient| coefficient.to_le_bytes()));
        }
        // SAFETY: checked above.
        unsafe { put(size, length) };
        Ok(())
    }

    fn rlv_detail_write_block(detail: RlvDetail, tile: u32, bytes: *const c_void, size: usize) {
        let object = registry::get(detail)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { Input::<u8>::new("bytes", bytes.cast(), size, 0) }?;
        let bytes = bytes.to_vec("bytes", object.context.context.memory_limit())?;
        let mut editor = object.edit()?;
        let block = if size == 0 { None } else { Some(bytes.as_slice()) };
        editor.object.displacement_mut().write(tile, block)?;
        editor.written.push(Change::all(tile));
        Ok(())
    }
}

/// Tells the host that tiles could not be had.
pub fn log_refusal(context: &ContextObject, refused: usize, budget: u64) {
    if refused > 0 {
        context.log(RLV_LOG_WARNING, &format!("{refused} tiles were refused by the budget of {budget} bytes"));
    }
}
