//! Sparse grids of OpenVDB; see `include/relievo/grid.h`.

use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, RwLock};

use relievo_core::progress::Silent;
use relievo_core::{Error, ErrorKind, Mesh, Progress, Result};
use relievo_openvdb::{
    Block, Box3, Change, Class, Entry, Filter, Frustum, Grid, GridInfo, GridSettings, Kind, Module, Operation, Order,
    Packing, Polygons, Survey, Transform, Writing,
};

use crate::border::array::{Input, Output, Plain, fixed, present, put, text};
use crate::border::descriptor::{numbered, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::context::{ContextObject, HostProgress, RLV_TEXT_SIZE, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};
use crate::simulation::particles::{ParticlesObject, RlvParticles};
use crate::surfaces::mesh::{self, MeshObject, RlvMesh};

handle!(RlvGrid, 24, GridObject);

settings!(RlvGridSettings, GridSettings);

// SAFETY: a handle is one integer.
unsafe impl Plain for RlvGrid {}

constants! {
    u32:
    RLV_GRID_FLOAT = 0,
    RLV_GRID_DOUBLE = 1,
    RLV_GRID_BOOL = 2,
    RLV_GRID_MASK = 3,
    RLV_GRID_INT32 = 4,
    RLV_GRID_INT64 = 5,
    RLV_GRID_VEC3S = 6,
    RLV_GRID_VEC3D = 7,
    RLV_GRID_VEC3I = 8,
    RLV_GRID_POINTS = 9,
    RLV_GRID_OTHER = 10,
    RLV_GRID_UNKNOWN = 0,
    RLV_GRID_LEVEL_SET = 1,
    RLV_GRID_FOG = 2,
    RLV_GRID_STAGGERED = 3,
    RLV_GRID_PACK_BLOSC = 0,
    RLV_GRID_PACK_ZIP = 1,
    RLV_GRID_PACK_NONE = 2,
    RLV_GRID_HALF = 4,
    RLV_GRID_STREAM = 8,
    RLV_GRID_UNION = 0,
    RLV_GRID_INTERSECTION = 1,
    RLV_GRID_DIFFERENCE = 2,
    RLV_GRID_OFFSET = 0,
    RLV_GRID_MEAN = 1,
    RLV_GRID_GAUSSIAN = 2,
    RLV_GRID_MEDIAN = 3,
    RLV_GRID_LAPLACIAN = 4,
    RLV_GRID_MEAN_CURVATURE = 5,
    RLV_GRID_RESAMPLE = 6,
    RLV_GRID_TO_FOG = 7,
    RLV_GRID_TO_LEVEL_SET = 8,
}

descriptor! {
    pub struct RlvGridInfo {
        struct_size: u32,
        kind: u32,
        grid_class: u32,
        is_half: u32,
        is_linear: u32,
        is_empty: u32,
        matrix: [f64; 12],
        voxel_size: [f64; 3],
        low: [i32; 3],
        high: [i32; 3],
        active_voxels: u64,
        leaf_count: u64,
        memory_bytes: u64,
        name: [u8; RLV_TEXT_SIZE as usize],
    }
}

/// A grid and the context it belongs to.
pub struct GridObject {
    context: Arc<ContextObject>,
    grid: RwLock<Grid>,
}

/// Registers a grid.
///
/// # Errors
/// Fails with `Memory` if there are too many objects.
pub fn register(context: Arc<ContextObject>, grid: Grid) -> Result<RlvGrid> {
    registry::insert(GridObject { context, grid: RwLock::new(grid) })
}

const KINDS: &[(Kind, &str)] = &[
    (Kind::Float, "float"),
    (Kind::Double, "double"),
    (Kind::Bool, "bool"),
    (Kind::Mask, "mask"),
    (Kind::Int32, "int32"),
    (Kind::Int64, "int64"),
    (Kind::Vec3s, "vec3s"),
    (Kind::Vec3d, "vec3d"),
    (Kind::Vec3i, "vec3i"),
];

const CLASSES: &[(Class, &str)] = &[
    (Class::Unknown, "unknown"),
    (Class::LevelSet, "level set"),
    (Class::Fog, "fog"),
    (Class::Staggered, "staggered"),
];

const OPERATIONS: &[(Operation, &str)] =
    &[(Operation::Union, "union"), (Operation::Intersection, "intersection"), (Operation::Difference, "difference")];

const CHANGES: &[(Change, &str)] = &[
    (Change::Offset, "offset"),
    (Change::Smooth(Filter::Mean), "mean"),
    (Change::Smooth(Filter::Gaussian), "gaussian"),
    (Change::Smooth(Filter::Median), "median"),
    (Change::Smooth(Filter::Laplacian), "laplacian"),
    (Change::Smooth(Filter::MeanCurvature), "mean curvature"),
    (Change::Resample(Order::Linear), "resample"),
    (Change::Fog, "to fog"),
    (Change::LevelSet, "to level set"),
];

/// Describes a grid for C.
fn described(info: &GridInfo) -> RlvGridInfo {
    let [low, high] = info.bounds.unwrap_or_default();
    let rows = info.transform.rows;
    RlvGridInfo {
        struct_size: 0,
        kind: info.kind.map_or(RLV_GRID_OTHER, |kind| kind as u32),
        grid_class: info.class as u32,
        is_half: info.is_half.into(),
        is_linear: info.transform.is_linear.into(),
        is_empty: info.bounds.is_none().into(),
        matrix: std::array::from_fn(|at| rows[at / 3][at % 3]),
        voxel_size: info.transform.voxel_size,
        low,
        high,
        active_voxels: info.active_voxels,
        leaf_count: info.leaf_count,
        memory_bytes: info.memory_bytes,
        name: fixed(&info.name),
    }
}

/// Reads `N` numbers at a pointer.
///
/// # Safety
/// `pointer` is NULL or has so many numbers.
unsafe fn numbers<T: Copy, const N: usize>(name: &str, pointer: *const T) -> Result<[T; N]> {
    if pointer.is_null() {
        return Err(Error::invalid("the pointer is NULL").at(name).advise(format!("pass {N} numbers")));
    }
    // SAFETY: promised by the caller.
    Ok(unsafe { pointer.cast::<[T; N]>().read_unaligned() })
}

/// Returns the entry of metadata called `name`. Fails if `owner` has none.
fn entry_of<'a>(entries: &'a [Entry], owner: &str, name: &str) -> Result<&'a Entry> {
    entries
        .iter()
        .find(|entry| entry.name == name)
        .ok_or_else(|| Error::new(ErrorKind::NotFound, format!("{owner} has no metadata called `{name}`")).at("name"))
}

/// Writes `text` with a final zero to `size` bytes at `to`, the parameter `name`; a longer one is cut between characters.
/// Fails if `to` is NULL or there is no room for the zero.
///
/// # Safety
/// `to` is NULL or has `size` bytes.
unsafe fn write_text(name: &str, text: &str, to: *mut c_char, size: usize) -> Result<()> {
    present(name, to)?;
    if size == 0 {
        return Err(Error::invalid("there is no room for the text").at(name).advise("give one byte at least"));
    }
    let mut length = text.len().min(size - 1);
    while !text.is_char_boundary(length) {
        length -= 1;
    }
    // SAFETY: `length` and the zero are at most `size`, which the caller promises.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr(), to.cast(), length);
        to.add(length).write(0);
    }
    Ok(())
}

/// Makes a mesh of polygons. Fails if there is none.
fn mesh_of(polygons: Polygons) -> Result<Mesh> {
    let sizes: Vec<u32> = polygons.triangles.iter().map(|_| 3).chain(polygons.quads.iter().map(|_| 4)).collect();
    if sizes.is_empty() {
        return Err(Error::invalid("the grid has no surface at the value")
            .at("value")
            .advise("take another value; a level set of a mesh with holes has no inside"));
    }
    let mut corners = polygons.triangles.into_flattened();
    corners.extend(polygons.quads.into_flattened());
    Ok(Mesh::new(polygons.points, sizes, corners))
}

/// A long call on grids, with what it needs copied.
pub enum Work {
    Read { context: Arc<ContextObject>, path: PathBuf, name: Option<String>, bounds: Option<Box3> },
    FromMesh(Arc<MeshObject>, GridSettings),
    FromParticles(Arc<ParticlesObject>, GridSettings),
    Change(Arc<GridObject>, Change, GridSettings),
    Combine(Arc<GridObject>, Arc<GridObject>, Operation),
}

impl Work {
    /// Copies what reading a file needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or the path or the name is no text.
    ///
    /// # Safety
    /// The texts are NULL or end with zeros, and `bounds` is NULL or has six numbers.
    pub unsafe fn reading(
        context: RlvContext,
        path: *const c_char,
        name: *const c_char,
        bounds: *const f64,
    ) -> Result<Self> {
        let context = registry::get(context)?;
        // SAFETY: promised by the caller.
        let path = PathBuf::from(unsafe { text("path", path) }?);
        // SAFETY: promised by the caller.
        let name = if name.is_null() { None } else { Some(unsafe { text("name", name) }?.to_owned()) };
        let bounds = match bounds.is_null() {
            true => None,
            // SAFETY: promised by the caller.
            false => Some(unsafe { numbers::<f64, 6>("bounds", bounds) }?),
        };
        let bounds = bounds.map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
        Ok(Self::Read { context, path, name, bounds })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        match self {
            Self::Read { context, .. } => context,
            Self::FromMesh(mesh, _) => &mesh.context,
            Self::FromParticles(particles, _) => particles.context(),
            Self::Change(grid, ..) | Self::Combine(grid, ..) => &grid.context,
        }
    }

    /// Makes the grid.
    ///
    /// # Errors
    /// Fails with `Busy` if a mesh or grid is being changed, with `Invalid` if particles have no spacing and no radius
    /// is given, with `Cancelled` if `progress` asks to stop, and as the function of OpenVDB that makes the grid does.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvGrid> {
        let context = &self.context().context;
        let made = match self {
            Self::Read { path, name, bounds, .. } => {
                relievo_openvdb::read(context, path, name.as_deref(), *bounds, progress)?
            }
            Self::FromMesh(object, settings) => {
                let mesh = try_read(&object.mesh, "mesh")?;
                let transform = Transform::uniform(settings.voxel.into());
                Grid::of_mesh(context, &mesh.points, &mesh.triangles(), &transform, [settings.band; 2], progress)?
            }
            Self::FromParticles(object, settings) => {
                let particles = object.particles();
                let radius = if settings.radius > 0.0 { Some(settings.radius) } else { particles.spacing };
                let radius = radius.ok_or_else(|| {
                    Error::invalid("the particles have no spacing").at("radius").advise("give a radius above 0")
                })?;
                let radii = vec![radius; particles.points.len()];
                let (voxel, band) = (settings.voxel.into(), settings.band);
                Grid::of_spheres(context, &particles.points, &radii, voxel, band, progress)?
            }
            Self::Change(object, change, settings) => {
                try_read(&object.grid, "grid")?.changed(context, *change, settings, progress)?
            }
            Self::Combine(a, b, operation) => {
                let (a, b) = (try_read(&a.grid, "grid")?, try_read(&b.grid, "grid")?);
                a.combined(context, &b, *operation, progress)?
            }
        };
        register(self.context().clone(), made)
    }
}

/// Meshing of a grid.
pub struct Meshing(Arc<GridObject>, GridSettings);

impl Meshing {
    /// Copies what is needed.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive or a setting is out of range.
    ///
    /// # Safety
    /// `settings` is NULL or a descriptor that starts with its size.
    pub unsafe fn read(grid: RlvGrid, settings: *const RlvGridSettings) -> Result<Self> {
        // SAFETY: promised by the caller.
        Ok(Self(registry::get(grid)?, unsafe { RlvGridSettings::read(settings) }?))
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.0.context
    }

    /// Makes the mesh.
    ///
    /// # Errors
    /// Fails with `Busy` if the grid is being changed, with `Invalid` if it has no surface at the value, with `Memory`
    /// if the host refuses the bytes of the mesh, with `Cancelled` if `progress` asks to stop, and as [`Grid::meshed`]
    /// does.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvMesh> {
        let polygons = try_read(&self.0.grid, "grid")?.meshed(&self.context().context, &self.1, progress)?;
        mesh::register(self.context().clone(), mesh_of(polygons)?)
    }
}

/// Copies the box of active voxels of a grid, and returns it with the grid's context.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or no voxel is active, with `Busy` if the grid is being changed,
/// with `Unsupported` if values are not single numbers or voxels no boxes along the axes, and with `Memory` above the
/// context's memory limit.
pub fn scan(grid: RlvGrid) -> Result<(Arc<ContextObject>, relievo_tissue::Scan)> {
    let object = registry::get(grid)?;
    let scan = relievo_tissue::Scan::of_grid(&object.context.context, &*try_read(&object.grid, "grid")?)?;
    Ok((object.context.clone(), scan))
}

/// Reads settings and what a change is.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive, there is no such change or a setting is out of range.
///
/// # Safety
/// `settings` is NULL or a descriptor that starts with its size.
pub unsafe fn changing(grid: RlvGrid, change: u32, settings: *const RlvGridSettings) -> Result<Work> {
    let object = registry::get(grid)?;
    let change = numbered("change", CHANGES, change)?;
    // SAFETY: promised by the caller.
    Ok(Work::Change(object, change, unsafe { RlvGridSettings::read(settings) }?))
}

/// Reads what a level set is made of a mesh with.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or a setting is out of range.
///
/// # Safety
/// `settings` is NULL or a descriptor that starts with its size.
pub unsafe fn from_mesh(mesh: RlvMesh, settings: *const RlvGridSettings) -> Result<Work> {
    // SAFETY: promised by the caller.
    Ok(Work::FromMesh(registry::get(mesh)?, unsafe { RlvGridSettings::read(settings) }?))
}

/// Hands out what a call made.
///
/// # Safety
/// `out` was checked.
unsafe fn done(work: &Work, progress: RlvProgress, user: *mut c_void, out: *mut RlvGrid) -> Result<()> {
    let made = work.run(&mut HostProgress { callback: progress, user })?;
    // SAFETY: promised by the caller.
    unsafe { put(out, made) };
    Ok(())
}

/// Lists a file.
///
/// # Safety
/// `path` is NULL or ends with a zero.
unsafe fn survey(context: RlvContext, path: *const c_char) -> Result<Survey> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    Survey::of_file(Path::new(unsafe { text("path", path) }?), context.context.memory_limit())
}

/// The grids of an array of handles. Fails if there is none, or they belong to different contexts.
///
/// # Safety
/// The array has `count` handles.
unsafe fn grids(handles: *const RlvGrid, count: usize) -> Result<Vec<Arc<GridObject>>> {
    // SAFETY: promised by the caller.
    let handles = unsafe { Input::new("grids", handles, count, 0) }?;
    let objects = handles.iter().map(registry::get).collect::<Result<Vec<_>>>()?;
    let Some(first) = objects.first() else {
        return Err(Error::invalid("there is no grid").at("grids").advise("give one at least"));
    };
    if objects.iter().all(|object| Arc::ptr_eq(&object.context, &first.context)) {
        return Ok(objects);
    }
    Err(Error::invalid("the grids belong to different contexts").at("grids"))
}

/// Reads which grids are written, where to and how.
///
/// # Errors
/// Fails with `Invalid` if there is no grid, one is not alive, they belong to different contexts, the path is no text, or
/// `writing` is no way to write. What the work refuses, it returns: a grid that is busy, a file that cannot be written, or
/// `Cancelled`.
///
/// # Safety
/// `handles` has `count` handles, `path` is NULL or a NUL-terminated text.
pub unsafe fn writing(handles: *const RlvGrid, count: usize, path: *const c_char, writing: u32) -> Result<Making<()>> {
    // SAFETY: promised by the caller.
    let (objects, path) = unsafe { (grids(handles, count)?, PathBuf::from(text("path", path)?)) };
    if writing > (RLV_GRID_PACK_ZIP | RLV_GRID_PACK_NONE | RLV_GRID_HALF | RLV_GRID_STREAM) || writing & 3 == 3 {
        let error = Error::invalid(format!("{writing} is no way to write")).at("writing");
        return Err(error.advise("combine one RLV_GRID_PACK_… with RLV_GRID_HALF and RLV_GRID_STREAM"));
    }
    let (zip, plain) = (writing & RLV_GRID_PACK_ZIP != 0, writing & RLV_GRID_PACK_NONE != 0);
    let packing = Packing { zip, active: true, blosc: !zip && !plain };
    let writing_as = Writing { packing, is_stream: writing & RLV_GRID_STREAM != 0, metadata: Vec::new() };
    Ok(Making::new(objects[0].context.clone(), move |progress| {
        let locked = objects.iter().map(|object| try_read(&object.grid, "grid")).collect::<Result<Vec<_>>>()?;
        progress.step(0.0, "write")?;
        let mut halves = Vec::new();
        if writing & RLV_GRID_HALF != 0 {
            for grid in &locked {
                let mut copy = grid.copy()?;
                copy.set_half(true)?;
                halves.push(copy);
            }
        }
        let list: Vec<&Grid> = match halves.is_empty() {
            true => locked.iter().map(|grid| &**grid).collect(),
            false => halves.iter().collect(),
        };
        relievo_openvdb::write(&objects[0].context.context, &path, &list, &writing_as, progress)?;
        progress.report(1.0, "write");
        Ok(())
    }))
}

entry! {
    fn rlv_grid_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, GridSettings::PARAMETERS, params, count) }
    }

    fn rlv_grid_available() {
        Module::open().map(|_| ())
    }

    fn rlv_grid_file_count(context: RlvContext, path: *const c_char, out: *mut usize) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let survey = unsafe { survey(context, path) }?;
        // SAFETY: checked above.
        unsafe { put(out, survey.grids.len()) };
        Ok(())
    }

    fn rlv_grid_file_info(context: RlvContext, path: *const c_char, index: usize, out: *mut RlvGridInfo) {
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let survey = unsafe { survey(context, path) }?;
        let info = survey.grids.get(index).ok_or_else(|| {
            let count = survey.grids.len();
            Error::invalid(format!("grid {index} does not exist")).at("index").advise(format!("the file has {count}"))
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, described(info)) }
    }

    fn rlv_grid_file_metadata(
        context: RlvContext,
        path: *const c_char,
        name: *const c_char,
        value: *mut c_char,
        size: usize,
    ) {
        // SAFETY: the caller gives NULL or NUL-terminated texts.
        let (survey, name) = unsafe { (survey(context, path)?, text("name", name)?) };
        let entry = entry_of(&survey.metadata, "the file", name)?;
        // SAFETY: the caller promises `size` bytes.
        unsafe { write_text("value", &entry.value, value, size) }
    }

    fn rlv_grid_create(context: RlvContext, kind: u32, background: *const f64, voxel: f64, out: *mut RlvGrid) {
        present("out", out)?;
        let context = registry::get(context)?;
        let kind = numbered("kind", KINDS, kind)?;
        // SAFETY: the caller gives NULL or three numbers.
        let background = unsafe { numbers("background", background) }?;
        let made = register(context, Grid::new(kind, background, voxel)?)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_grid_read(
        context: RlvContext,
        path: *const c_char,
        name: *const c_char,
        bounds: *const f64,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvGrid,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts, and NULL or six numbers; `out` was checked.
        unsafe { done(&Work::reading(context, path, name, bounds)?, progress, user, out) }
    }

    fn rlv_grid_write(grids: *const RlvGrid, count: usize, path: *const c_char, writing: u32) {
        // SAFETY: the caller gives so many handles and NULL or a NUL-terminated text.
        unsafe { self::writing(grids, count, path, writing) }?.now()
    }

    fn rlv_grid_retain(grid: RlvGrid) {
        registry::retain(grid)
    }

    fn rlv_grid_release(grid: RlvGrid) {
        registry::release(grid)
    }

    fn rlv_grid_info(grid: RlvGrid, out: *mut RlvGridInfo) {
        let object = registry::get(grid)?;
        let info = try_read(&object.grid, "grid")?.info()?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, described(&info)) }
    }

    fn rlv_grid_set_name(grid: RlvGrid, name: *const c_char) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        try_write(&object.grid, "grid")?.set_name(name)
    }

    fn rlv_grid_set_class(grid: RlvGrid, grid_class: u32) {
        let object = registry::get(grid)?;
        let class = numbered("class", CLASSES, grid_class)?;
        try_write(&object.grid, "grid")?.set_class(class)
    }

    fn rlv_grid_set_matrix(grid: RlvGrid, matrix: *const f64) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or twelve numbers.
        let numbers: [[f64; 3]; 4] = unsafe { numbers("matrix", matrix.cast::<[f64; 3]>()) }?;
        try_write(&object.grid, "grid")?.set_transform(&Transform::affine(numbers))
    }

    fn rlv_grid_set_frustum(grid: RlvGrid, voxels: *const f64, taper: f64, depth: f64, matrix: *const f64) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL, or six and twelve numbers.
        let (voxels, after): ([[f64; 3]; 2], [[f64; 3]; 4]) =
            unsafe { (numbers("voxels", voxels.cast::<[f64; 3]>())?, numbers("matrix", matrix.cast::<[f64; 3]>())?) };
        let frustum = Frustum { voxels, taper, depth };
        try_write(&object.grid, "grid")?.set_frustum(&frustum, &Transform::affine(after))
    }

    fn rlv_grid_metadata_count(grid: RlvGrid, out: *mut usize) {
        present("out", out)?;
        let object = registry::get(grid)?;
        let entries = try_read(&object.grid, "grid")?.metadata()?;
        // SAFETY: checked above.
        unsafe { put(out, entries.len()) };
        Ok(())
    }

    fn rlv_grid_metadata_entry(
        grid: RlvGrid,
        index: usize,
        name: *mut c_char,
        name_size: usize,
        kind: *mut c_char,
        kind_size: usize,
    ) {
        let object = registry::get(grid)?;
        let entries = try_read(&object.grid, "grid")?.metadata()?;
        let entry = entries.get(index).ok_or_else(|| {
            let advice = format!("the grid has {}", entries.len());
            Error::invalid(format!("entry {index} does not exist")).at("index").advise(advice)
        })?;
        // SAFETY: the caller promises so many bytes of each.
        unsafe {
            write_text("name", &entry.name, name, name_size)?;
            write_text("type", &entry.kind, kind, kind_size)
        }
    }

    fn rlv_grid_metadata(grid: RlvGrid, name: *const c_char, value: *mut c_char, size: usize) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        let entries = try_read(&object.grid, "grid")?.metadata()?;
        let entry = entry_of(&entries, "the grid", name)?;
        // SAFETY: the caller promises `size` bytes.
        unsafe { write_text("value", &entry.value, value, size) }
    }

    fn rlv_grid_set_metadata(grid: RlvGrid, name: *const c_char, kind: *const c_char, value: *const c_char) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts.
        let [name, kind, value] = unsafe { [text("name", name)?, text("type", kind)?, text("value", value)?] };
        let entry = Entry { name: name.into(), kind: kind.into(), value: value.into() };
        try_write(&object.grid, "grid")?.set_metadata(&entry)
    }

    fn rlv_grid_sample(
        grid: RlvGrid,
        points: *const f64,
        count: usize,
        stride: usize,
        is_linear: u32,
        values: *mut f64,
        capacity: usize,
    ) {
        let object = registry::get(grid)?;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises so many points.
        let points = unsafe { Input::new("points", points.cast::<[f64; 3]>(), count, stride) }?.to_vec("points", limit)?;
        if is_linear > 1 {
            return Err(Error::invalid(format!("is_linear is {is_linear}")).at("is_linear").advise("use 0 or 1"));
        }
        let grid = try_read(&object.grid, "grid")?;
        // SAFETY: the caller promises room for so many numbers.
        let out = unsafe { Output::new("values", values, capacity, 0) }?;
        let out = out.holds("values", points.len() * grid.kind()?.components())?;
        out.fill(grid.sample(&points, is_linear == 1)?);
        Ok(())
    }

    fn rlv_grid_get_block(grid: RlvGrid, low: *const i32, size: *const u32, values: *mut c_void, bytes: usize) {
        present("values", values)?;
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or three numbers each.
        let (low, size) = unsafe { (numbers("low", low)?, numbers("size", size)?) };
        let block = try_read(&object.grid, "grid")?.block(&object.context.context, low, size)?;
        if block.bytes.len() != bytes {
            let error = Error::invalid(format!("the room of {bytes} bytes is not that of the block")).at("bytes");
            return Err(error.advise(format!("give {} bytes", block.bytes.len())));
        }
        // SAFETY: the caller promises so many bytes.
        unsafe { std::ptr::copy_nonoverlapping(block.bytes.as_ptr(), values.cast(), bytes) };
        Ok(())
    }

    fn rlv_grid_set_block(
        grid: RlvGrid,
        low: *const i32,
        size: *const u32,
        values: *const c_void,
        bytes: usize,
        tolerance: f64,
    ) {
        let object = registry::get(grid)?;
        // SAFETY: the caller gives NULL or three numbers each, and so many bytes.
        let (low, size, values) = unsafe {
            (numbers("low", low)?, numbers("size", size)?, Input::new("values", values.cast::<u8>(), bytes, 1)?)
        };
        let context = &object.context.context;
        let bytes = values.to_vec("values", context.memory_limit())?;
        let mut grid = try_write(&object.grid, "grid")?;
        let kind = grid.kind()?;
        grid.set_block(context, &Block { low, size, kind, bytes }, tolerance)
    }

    fn rlv_grid_from_mesh(
        mesh: RlvMesh,
        settings: *const RlvGridSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvGrid,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size; `out` was checked.
        unsafe { done(&from_mesh(mesh, settings)?, progress, user, out) }
    }

    fn rlv_grid_from_particles(
        particles: RlvParticles,
        settings: *const RlvGridSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvGrid,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let settings = unsafe { RlvGridSettings::read(settings) }?;
        // SAFETY: `out` was checked.
        unsafe { done(&Work::FromParticles(registry::get(particles)?, settings), progress, user, out) }
    }

    fn rlv_grid_mesh(
        grid: RlvGrid,
        settings: *const RlvGridSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let made = unsafe { Meshing::read(grid, settings) }?.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_grid_change(
        grid: RlvGrid,
        change: u32,
        settings: *const RlvGridSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvGrid,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size; `out` was checked.
        unsafe { done(&changing(grid, change, settings)?, progress, user, out) }
    }

    fn rlv_grid_convert(grid: RlvGrid, kind: u32, out: *mut RlvGrid) {
        present("out", out)?;
        let object = registry::get(grid)?;
        let kind = numbered("kind", KINDS, kind)?;
        let made = try_read(&object.grid, "grid")?.converted(&object.context.context, kind, &mut Silent)?;
        let made = register(object.context.clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_grid_combine(
        a: RlvGrid,
        b: RlvGrid,
        operation: u32,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvGrid,
    ) {
        present("out", out)?;
        let operation = numbered("operation", OPERATIONS, operation)?;
        let work = Work::Combine(registry::get(a)?, registry::get(b)?, operation);
        // SAFETY: `out` was checked.
        unsafe { done(&work, progress, user, out) }
    }

    fn rlv_grid_labels(level_sets: *const RlvGrid, labels: *const i32, count: usize, out: *mut RlvGrid) {
        present("out", out)?;
        // SAFETY: the caller gives so many handles and labels.
        let (objects, labels) = unsafe { (grids(level_sets, count)?, Input::new("labels", labels, count, 0)?) };
        let labels: Vec<i32> = labels.iter().collect();
        let locked = objects.iter().map(|object| try_read(&object.grid, "grid")).collect::<Result<Vec<_>>>()?;
        let list: Vec<&Grid> = locked.iter().map(|grid| &**grid).collect();
        let context = &objects[0].context;
        let made = relievo_openvdb::labels(&context.context, &list, &labels, &mut Silent)?;
        let made = register(context.clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_grid_label_mask(grid: RlvGrid, label: i64, out: *mut RlvGrid) {
        present("out", out)?;
        let object = registry::get(grid)?;
        let made = try_read(&object.grid, "grid")?.label_mask(&object.context.context, label, &mut Silent)?;
        let made = register(object.context.clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
