// Made by `cargo xtask bindings` from cpp/openvdb/module.h; do not edit.

pub const RLVDB_VERSION: u32 = 1;
pub const RLVDB_OK: u32 = 0;
pub const RLVDB_FAILED: u32 = 1;
pub const RLVDB_CANCELLED: u32 = 2;
pub const RLVDB_MEMORY: u32 = 3;
pub const RLVDB_INVALID: u32 = 4;
pub const RLVDB_NOT_FOUND: u32 = 5;
pub const RLVDB_FLOAT: u32 = 0;
pub const RLVDB_DOUBLE: u32 = 1;
pub const RLVDB_BOOL: u32 = 2;
pub const RLVDB_MASK: u32 = 3;
pub const RLVDB_INT32: u32 = 4;
pub const RLVDB_INT64: u32 = 5;
pub const RLVDB_VEC3S: u32 = 6;
pub const RLVDB_VEC3D: u32 = 7;
pub const RLVDB_VEC3I: u32 = 8;
pub const RLVDB_UNKNOWN: u32 = 0;
pub const RLVDB_LEVEL_SET: u32 = 1;
pub const RLVDB_FOG: u32 = 2;
pub const RLVDB_STAGGERED: u32 = 3;
pub const RLVDB_ZIP: u32 = 1;
pub const RLVDB_ACTIVE: u32 = 2;
pub const RLVDB_BLOSC: u32 = 4;
pub const RLVDB_STREAM: u32 = 256;
pub const RLVDB_UNION: u32 = 0;
pub const RLVDB_INTERSECTION: u32 = 1;
pub const RLVDB_DIFFERENCE: u32 = 2;
pub const RLVDB_MEAN: u32 = 0;
pub const RLVDB_GAUSSIAN: u32 = 1;
pub const RLVDB_MEDIAN: u32 = 2;
pub const RLVDB_LAPLACIAN: u32 = 3;
pub const RLVDB_MEAN_CURVATURE: u32 = 4;
#[repr(C)]
#[derive(Debug)]
pub struct RlvdbGrid {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug)]
pub struct RlvdbMesh {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RlvdbError {
    pub text: [::std::ffi::c_char; 512usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RlvdbError"][::std::mem::size_of::<RlvdbError>() - 512usize];
    ["Alignment of RlvdbError"][::std::mem::align_of::<RlvdbError>() - 1usize];
    [
        "Offset of field: RlvdbError::text",
    ][::std::mem::offset_of!(RlvdbError, text) - 0usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RlvdbCall {
    pub threads: u32,
    pub user: *mut ::std::ffi::c_void,
    pub progress: ::std::option::Option<
        unsafe extern "C" fn(user: *mut ::std::ffi::c_void, percent: i32) -> i32,
    >,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RlvdbCall"][::std::mem::size_of::<RlvdbCall>() - 24usize];
    ["Alignment of RlvdbCall"][::std::mem::align_of::<RlvdbCall>() - 8usize];
    [
        "Offset of field: RlvdbCall::threads",
    ][::std::mem::offset_of!(RlvdbCall, threads) - 0usize];
    [
        "Offset of field: RlvdbCall::user",
    ][::std::mem::offset_of!(RlvdbCall, user) - 8usize];
    [
        "Offset of field: RlvdbCall::progress",
    ][::std::mem::offset_of!(RlvdbCall, progress) - 16usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RlvdbInfo {
    pub kind: i32,
    pub grid_class: i32,
    pub is_half: i32,
    pub is_linear: i32,
    pub background: [f64; 3usize],
    pub matrix: [f64; 16usize],
    pub voxel_size: [f64; 3usize],
    pub low: [i32; 3usize],
    pub high: [i32; 3usize],
    pub active_voxels: u64,
    pub leaf_count: u64,
    pub memory_bytes: u64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RlvdbInfo"][::std::mem::size_of::<RlvdbInfo>() - 240usize];
    ["Alignment of RlvdbInfo"][::std::mem::align_of::<RlvdbInfo>() - 8usize];
    [
        "Offset of field: RlvdbInfo::kind",
    ][::std::mem::offset_of!(RlvdbInfo, kind) - 0usize];
    [
        "Offset of field: RlvdbInfo::grid_class",
    ][::std::mem::offset_of!(RlvdbInfo, grid_class) - 4usize];
    [
        "Offset of field: RlvdbInfo::is_half",
    ][::std::mem::offset_of!(RlvdbInfo, is_half) - 8usize];
    [
        "Offset of field: RlvdbInfo::is_linear",
    ][::std::mem::offset_of!(RlvdbInfo, is_linear) - 12usize];
    [
        "Offset of field: RlvdbInfo::background",
    ][::std::mem::offset_of!(RlvdbInfo, background) - 16usize];
    [
        "Offset of field: RlvdbInfo::matrix",
    ][::std::mem::offset_of!(RlvdbInfo, matrix) - 40usize];
    [
        "Offset of field: RlvdbInfo::voxel_size",
    ][::std::mem::offset_of!(RlvdbInfo, voxel_size) - 168usize];
    [
        "Offset of field: RlvdbInfo::low",
    ][::std::mem::offset_of!(RlvdbInfo, low) - 192usize];
    [
        "Offset of field: RlvdbInfo::high",
    ][::std::mem::offset_of!(RlvdbInfo, high) - 204usize];
    [
        "Offset of field: RlvdbInfo::active_voxels",
    ][::std::mem::offset_of!(RlvdbInfo, active_voxels) - 216usize];
    [
        "Offset of field: RlvdbInfo::leaf_count",
    ][::std::mem::offset_of!(RlvdbInfo, leaf_count) - 224usize];
    [
        "Offset of field: RlvdbInfo::memory_bytes",
    ][::std::mem::offset_of!(RlvdbInfo, memory_bytes) - 232usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RlvdbMeshView {
    pub points: *const f32,
    pub point_count: usize,
    pub triangles: *const u32,
    pub triangle_count: usize,
    pub quads: *const u32,
    pub quad_count: usize,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RlvdbMeshView"][::std::mem::size_of::<RlvdbMeshView>() - 48usize];
    ["Alignment of RlvdbMeshView"][::std::mem::align_of::<RlvdbMeshView>() - 8usize];
    [
        "Offset of field: RlvdbMeshView::points",
    ][::std::mem::offset_of!(RlvdbMeshView, points) - 0usize];
    [
        "Offset of field: RlvdbMeshView::point_count",
    ][::std::mem::offset_of!(RlvdbMeshView, point_count) - 8usize];
    [
        "Offset of field: RlvdbMeshView::triangles",
    ][::std::mem::offset_of!(RlvdbMeshView, triangles) - 16usize];
    [
        "Offset of field: RlvdbMeshView::triangle_count",
    ][::std::mem::offset_of!(RlvdbMeshView, triangle_count) - 24usize];
    [
        "Offset of field: RlvdbMeshView::quads",
    ][::std::mem::offset_of!(RlvdbMeshView, quads) - 32usize];
    [
        "Offset of field: RlvdbMeshView::quad_count",
    ][::std::mem::offset_of!(RlvdbMeshView, quad_count) - 40usize];
};
pub struct Rlvdb {
    __library: ::libloading::Library,
    pub rlvdb_version: unsafe extern "C" fn() -> u32,
    pub rlvdb_library_version: unsafe extern "C" fn() -> u32,
    pub rlvdb_initialize: unsafe extern "C" fn(
        ends_logging: i32,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_grid_new: unsafe extern "C" fn(
        kind: i32,
        background: *const f64,
        voxel: f64,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_grid_copy: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_grid_free: unsafe extern "C" fn(grid: *mut RlvdbGrid),
    pub rlvdb_grid_info: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        out: *mut RlvdbInfo,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_set_class: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        grid_class: i32,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_set_half: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        is_half: i32,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_set_matrix: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        matrix: *const f64,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_set_frustum: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        box_: *const f64,
        taper: f64,
        depth: f64,
        matrix: *const f64,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_metadata_count: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        out: *mut usize,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_metadata_get: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        index: usize,
        name: *mut ::std::ffi::c_char,
        name_size: usize,
        type_: *mut ::std::ffi::c_char,
        type_size: usize,
        value: *mut ::std::ffi::c_char,
        value_size: usize,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_metadata_set: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        name: *const ::std::ffi::c_char,
        type_: *const ::std::ffi::c_char,
        value: *const ::std::ffi::c_char,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_read: unsafe extern "C" fn(
        path: *const ::std::ffi::c_char,
        unique_name: *const ::std::ffi::c_char,
        box_: *const f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_write: unsafe extern "C" fn(
        path: *const ::std::ffi::c_char,
        grids: *const *const RlvdbGrid,
        count: usize,
        packing: u32,
        metadata: *const *const ::std::ffi::c_char,
        metadata_count: usize,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_sample: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        points: *const f64,
        count: usize,
        is_linear: i32,
        values: *mut f64,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_voxels: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        voxels: *const i32,
        count: usize,
        values: *mut f64,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_dense_get: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        low: *const i32,
        size: *const u32,
        values: *mut ::std::ffi::c_void,
        byte_count: usize,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_dense_set: unsafe extern "C" fn(
        grid: *mut RlvdbGrid,
        low: *const i32,
        size: *const u32,
        values: *const ::std::ffi::c_void,
        byte_count: usize,
        tolerance: f64,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_from_mesh: unsafe extern "C" fn(
        points: *const f32,
        point_count: usize,
        triangles: *const u32,
        triangle_count: usize,
        matrix: *const f64,
        exterior: f32,
        interior: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_from_spheres: unsafe extern "C" fn(
        points: *const f32,
        radii: *const f32,
        count: usize,
        voxel: f64,
        band: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_to_mesh: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        value: f64,
        adaptivity: f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbMesh,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_mesh_view: unsafe extern "C" fn(
        mesh: *const RlvdbMesh,
        out: *mut RlvdbMeshView,
    ),
    pub rlvdb_mesh_free: unsafe extern "C" fn(mesh: *mut RlvdbMesh),
    pub rlvdb_combine: unsafe extern "C" fn(
        a: *const RlvdbGrid,
        b: *const RlvdbGrid,
        operation: i32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_offset: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        distance: f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_filter: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        filter: i32,
        width: u32,
        iterations: u32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_resample: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        matrix: *const f64,
        order: u32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_convert: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        kind: i32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_to_fog: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_to_level_set: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        value: f64,
        band: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_labels: unsafe extern "C" fn(
        level_sets: *const *const RlvdbGrid,
        labels: *const i32,
        count: usize,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_label_mask: unsafe extern "C" fn(
        grid: *const RlvdbGrid,
        label: i64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_test_points_read: unsafe extern "C" fn(
        path: *const ::std::ffi::c_char,
        name: *const ::std::ffi::c_char,
        values: *mut f32,
        capacity: usize,
        count: *mut usize,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_test_points_write: unsafe extern "C" fn(
        path: *const ::std::ffi::c_char,
        points: *const f32,
        velocities: *const f32,
        count: usize,
        voxel: f64,
        is_fixed: i32,
        packing: u32,
        error: *mut RlvdbError,
    ) -> i32,
    pub rlvdb_test_instances_write: unsafe extern "C" fn(
        path: *const ::std::ffi::c_char,
        grid: *const RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32,
}
impl Rlvdb {
    pub unsafe fn new<P>(path: P) -> Result<Self, ::libloading::Error>
    where
        P: AsRef<::std::ffi::OsStr>,
    {
        let path = path.as_ref();
        let library = unsafe { ::libloading::Library::new(path) }?;
        unsafe { Self::from_library(library) }
    }
    pub unsafe fn from_library<L>(library: L) -> Result<Self, ::libloading::Error>
    where
        L: Into<::libloading::Library>,
    {
        let __library = library.into();
        let rlvdb_version = unsafe { __library.get(b"rlvdb_version\0") }
            .map(|sym| *sym)?;
        let rlvdb_library_version = unsafe { __library.get(b"rlvdb_library_version\0") }
            .map(|sym| *sym)?;
        let rlvdb_initialize = unsafe { __library.get(b"rlvdb_initialize\0") }
            .map(|sym| *sym)?;
        let rlvdb_grid_new = unsafe { __library.get(b"rlvdb_grid_new\0") }
            .map(|sym| *sym)?;
        let rlvdb_grid_copy = unsafe { __library.get(b"rlvdb_grid_copy\0") }
            .map(|sym| *sym)?;
        let rlvdb_grid_free = unsafe { __library.get(b"rlvdb_grid_free\0") }
            .map(|sym| *sym)?;
        let rlvdb_grid_info = unsafe { __library.get(b"rlvdb_grid_info\0") }
            .map(|sym| *sym)?;
        let rlvdb_set_class = unsafe { __library.get(b"rlvdb_set_class\0") }
            .map(|sym| *sym)?;
        let rlvdb_set_half = unsafe { __library.get(b"rlvdb_set_half\0") }
            .map(|sym| *sym)?;
        let rlvdb_set_matrix = unsafe { __library.get(b"rlvdb_set_matrix\0") }
            .map(|sym| *sym)?;
        let rlvdb_set_frustum = unsafe { __library.get(b"rlvdb_set_frustum\0") }
            .map(|sym| *sym)?;
        let rlvdb_metadata_count = unsafe { __library.get(b"rlvdb_metadata_count\0") }
            .map(|sym| *sym)?;
        let rlvdb_metadata_get = unsafe { __library.get(b"rlvdb_metadata_get\0") }
            .map(|sym| *sym)?;
        let rlvdb_metadata_set = unsafe { __library.get(b"rlvdb_metadata_set\0") }
            .map(|sym| *sym)?;
        let rlvdb_read = unsafe { __library.get(b"rlvdb_read\0") }.map(|sym| *sym)?;
        let rlvdb_write = unsafe { __library.get(b"rlvdb_write\0") }.map(|sym| *sym)?;
        let rlvdb_sample = unsafe { __library.get(b"rlvdb_sample\0") }.map(|sym| *sym)?;
        let rlvdb_voxels = unsafe { __library.get(b"rlvdb_voxels\0") }.map(|sym| *sym)?;
        let rlvdb_dense_get = unsafe { __library.get(b"rlvdb_dense_get\0") }
            .map(|sym| *sym)?;
        let rlvdb_dense_set = unsafe { __library.get(b"rlvdb_dense_set\0") }
            .map(|sym| *sym)?;
        let rlvdb_from_mesh = unsafe { __library.get(b"rlvdb_from_mesh\0") }
            .map(|sym| *sym)?;
        let rlvdb_from_spheres = unsafe { __library.get(b"rlvdb_from_spheres\0") }
            .map(|sym| *sym)?;
        let rlvdb_to_mesh = unsafe { __library.get(b"rlvdb_to_mesh\0") }
            .map(|sym| *sym)?;
        let rlvdb_mesh_view = unsafe { __library.get(b"rlvdb_mesh_view\0") }
            .map(|sym| *sym)?;
        let rlvdb_mesh_free = unsafe { __library.get(b"rlvdb_mesh_free\0") }
            .map(|sym| *sym)?;
        let rlvdb_combine = unsafe { __library.get(b"rlvdb_combine\0") }
            .map(|sym| *sym)?;
        let rlvdb_offset = unsafe { __library.get(b"rlvdb_offset\0") }.map(|sym| *sym)?;
        let rlvdb_filter = unsafe { __library.get(b"rlvdb_filter\0") }.map(|sym| *sym)?;
        let rlvdb_resample = unsafe { __library.get(b"rlvdb_resample\0") }
            .map(|sym| *sym)?;
        let rlvdb_convert = unsafe { __library.get(b"rlvdb_convert\0") }
            .map(|sym| *sym)?;
        let rlvdb_to_fog = unsafe { __library.get(b"rlvdb_to_fog\0") }.map(|sym| *sym)?;
        let rlvdb_to_level_set = unsafe { __library.get(b"rlvdb_to_level_set\0") }
            .map(|sym| *sym)?;
        let rlvdb_labels = unsafe { __library.get(b"rlvdb_labels\0") }.map(|sym| *sym)?;
        let rlvdb_label_mask = unsafe { __library.get(b"rlvdb_label_mask\0") }
            .map(|sym| *sym)?;
        let rlvdb_test_points_read = unsafe {
            __library.get(b"rlvdb_test_points_read\0")
        }
            .map(|sym| *sym)?;
        let rlvdb_test_points_write = unsafe {
            __library.get(b"rlvdb_test_points_write\0")
        }
            .map(|sym| *sym)?;
        let rlvdb_test_instances_write = unsafe {
            __library.get(b"rlvdb_test_instances_write\0")
        }
            .map(|sym| *sym)?;
        Ok(Rlvdb {
            __library,
            rlvdb_version,
            rlvdb_library_version,
            rlvdb_initialize,
            rlvdb_grid_new,
            rlvdb_grid_copy,
            rlvdb_grid_free,
            rlvdb_grid_info,
            rlvdb_set_class,
            rlvdb_set_half,
            rlvdb_set_matrix,
            rlvdb_set_frustum,
            rlvdb_metadata_count,
            rlvdb_metadata_get,
            rlvdb_metadata_set,
            rlvdb_read,
            rlvdb_write,
            rlvdb_sample,
            rlvdb_voxels,
            rlvdb_dense_get,
            rlvdb_dense_set,
            rlvdb_from_mesh,
            rlvdb_from_spheres,
            rlvdb_to_mesh,
            rlvdb_mesh_view,
            rlvdb_mesh_free,
            rlvdb_combine,
            rlvdb_offset,
            rlvdb_filter,
            rlvdb_resample,
            rlvdb_convert,
            rlvdb_to_fog,
            rlvdb_to_level_set,
            rlvdb_labels,
            rlvdb_label_mask,
            rlvdb_test_points_read,
            rlvdb_test_points_write,
            rlvdb_test_instances_write,
        })
    }
    pub unsafe fn rlvdb_version(&self) -> u32 {
        unsafe { (self.rlvdb_version)() }
    }
    pub unsafe fn rlvdb_library_version(&self) -> u32 {
        unsafe { (self.rlvdb_library_version)() }
    }
    pub unsafe fn rlvdb_initialize(
        &self,
        ends_logging: i32,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_initialize)(ends_logging, error) }
    }
    pub unsafe fn rlvdb_grid_new(
        &self,
        kind: i32,
        background: *const f64,
        voxel: f64,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_grid_new)(kind, background, voxel, out, error) }
    }
    pub unsafe fn rlvdb_grid_copy(
        &self,
        grid: *const RlvdbGrid,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_grid_copy)(grid, out, error) }
    }
    pub unsafe fn rlvdb_grid_free(&self, grid: *mut RlvdbGrid) {
        unsafe { (self.rlvdb_grid_free)(grid) }
    }
    pub unsafe fn rlvdb_grid_info(
        &self,
        grid: *const RlvdbGrid,
        out: *mut RlvdbInfo,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_grid_info)(grid, out, error) }
    }
    pub unsafe fn rlvdb_set_class(
        &self,
        grid: *mut RlvdbGrid,
        grid_class: i32,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_set_class)(grid, grid_class, error) }
    }
    pub unsafe fn rlvdb_set_half(
        &self,
        grid: *mut RlvdbGrid,
        is_half: i32,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_set_half)(grid, is_half, error) }
    }
    pub unsafe fn rlvdb_set_matrix(
        &self,
        grid: *mut RlvdbGrid,
        matrix: *const f64,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_set_matrix)(grid, matrix, error) }
    }
    pub unsafe fn rlvdb_set_frustum(
        &self,
        grid: *mut RlvdbGrid,
        box_: *const f64,
        taper: f64,
        depth: f64,
        matrix: *const f64,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_set_frustum)(grid, box_, taper, depth, matrix, error) }
    }
    pub unsafe fn rlvdb_metadata_count(
        &self,
        grid: *const RlvdbGrid,
        out: *mut usize,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_metadata_count)(grid, out, error) }
    }
    pub unsafe fn rlvdb_metadata_get(
        &self,
        grid: *const RlvdbGrid,
        index: usize,
        name: *mut ::std::ffi::c_char,
        name_size: usize,
        type_: *mut ::std::ffi::c_char,
        type_size: usize,
        value: *mut ::std::ffi::c_char,
        value_size: usize,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_metadata_get)(
                grid,
                index,
                name,
                name_size,
                type_,
                type_size,
                value,
                value_size,
                error,
            )
        }
    }
    pub unsafe fn rlvdb_metadata_set(
        &self,
        grid: *mut RlvdbGrid,
        name: *const ::std::ffi::c_char,
        type_: *const ::std::ffi::c_char,
        value: *const ::std::ffi::c_char,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_metadata_set)(grid, name, type_, value, error) }
    }
    pub unsafe fn rlvdb_read(
        &self,
        path: *const ::std::ffi::c_char,
        unique_name: *const ::std::ffi::c_char,
        box_: *const f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_read)(path, unique_name, box_, call, out, error) }
    }
    pub unsafe fn rlvdb_write(
        &self,
        path: *const ::std::ffi::c_char,
        grids: *const *const RlvdbGrid,
        count: usize,
        packing: u32,
        metadata: *const *const ::std::ffi::c_char,
        metadata_count: usize,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_write)(
                path,
                grids,
                count,
                packing,
                metadata,
                metadata_count,
                call,
                error,
            )
        }
    }
    pub unsafe fn rlvdb_sample(
        &self,
        grid: *const RlvdbGrid,
        points: *const f64,
        count: usize,
        is_linear: i32,
        values: *mut f64,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_sample)(grid, points, count, is_linear, values, error) }
    }
    pub unsafe fn rlvdb_voxels(
        &self,
        grid: *const RlvdbGrid,
        voxels: *const i32,
        count: usize,
        values: *mut f64,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_voxels)(grid, voxels, count, values, error) }
    }
    pub unsafe fn rlvdb_dense_get(
        &self,
        grid: *const RlvdbGrid,
        low: *const i32,
        size: *const u32,
        values: *mut ::std::ffi::c_void,
        byte_count: usize,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self.rlvdb_dense_get)(grid, low, size, values, byte_count, call, error)
        }
    }
    pub unsafe fn rlvdb_dense_set(
        &self,
        grid: *mut RlvdbGrid,
        low: *const i32,
        size: *const u32,
        values: *const ::std::ffi::c_void,
        byte_count: usize,
        tolerance: f64,
        call: *const RlvdbCall,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_dense_set)(
                grid,
                low,
                size,
                values,
                byte_count,
                tolerance,
                call,
                error,
            )
        }
    }
    pub unsafe fn rlvdb_from_mesh(
        &self,
        points: *const f32,
        point_count: usize,
        triangles: *const u32,
        triangle_count: usize,
        matrix: *const f64,
        exterior: f32,
        interior: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_from_mesh)(
                points,
                point_count,
                triangles,
                triangle_count,
                matrix,
                exterior,
                interior,
                call,
                out,
                error,
            )
        }
    }
    pub unsafe fn rlvdb_from_spheres(
        &self,
        points: *const f32,
        radii: *const f32,
        count: usize,
        voxel: f64,
        band: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_from_spheres)(points, radii, count, voxel, band, call, out, error)
        }
    }
    pub unsafe fn rlvdb_to_mesh(
        &self,
        grid: *const RlvdbGrid,
        value: f64,
        adaptivity: f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbMesh,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_to_mesh)(grid, value, adaptivity, call, out, error) }
    }
    pub unsafe fn rlvdb_mesh_view(
        &self,
        mesh: *const RlvdbMesh,
        out: *mut RlvdbMeshView,
    ) {
        unsafe { (self.rlvdb_mesh_view)(mesh, out) }
    }
    pub unsafe fn rlvdb_mesh_free(&self, mesh: *mut RlvdbMesh) {
        unsafe { (self.rlvdb_mesh_free)(mesh) }
    }
    pub unsafe fn rlvdb_combine(
        &self,
        a: *const RlvdbGrid,
        b: *const RlvdbGrid,
        operation: i32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_combine)(a, b, operation, call, out, error) }
    }
    pub unsafe fn rlvdb_offset(
        &self,
        grid: *const RlvdbGrid,
        distance: f64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_offset)(grid, distance, call, out, error) }
    }
    pub unsafe fn rlvdb_filter(
        &self,
        grid: *const RlvdbGrid,
        filter: i32,
        width: u32,
        iterations: u32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_filter)(grid, filter, width, iterations, call, out, error) }
    }
    pub unsafe fn rlvdb_resample(
        &self,
        grid: *const RlvdbGrid,
        matrix: *const f64,
        order: u32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_resample)(grid, matrix, order, call, out, error) }
    }
    pub unsafe fn rlvdb_convert(
        &self,
        grid: *const RlvdbGrid,
        kind: i32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_convert)(grid, kind, call, out, error) }
    }
    pub unsafe fn rlvdb_to_fog(
        &self,
        grid: *const RlvdbGrid,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_to_fog)(grid, call, out, error) }
    }
    pub unsafe fn rlvdb_to_level_set(
        &self,
        grid: *const RlvdbGrid,
        value: f64,
        band: f32,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_to_level_set)(grid, value, band, call, out, error) }
    }
    pub unsafe fn rlvdb_labels(
        &self,
        level_sets: *const *const RlvdbGrid,
        labels: *const i32,
        count: usize,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_labels)(level_sets, labels, count, call, out, error) }
    }
    pub unsafe fn rlvdb_label_mask(
        &self,
        grid: *const RlvdbGrid,
        label: i64,
        call: *const RlvdbCall,
        out: *mut *mut RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_label_mask)(grid, label, call, out, error) }
    }
    pub unsafe fn rlvdb_test_points_read(
        &self,
        path: *const ::std::ffi::c_char,
        name: *const ::std::ffi::c_char,
        values: *mut f32,
        capacity: usize,
        count: *mut usize,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self.rlvdb_test_points_read)(path, name, values, capacity, count, error)
        }
    }
    pub unsafe fn rlvdb_test_points_write(
        &self,
        path: *const ::std::ffi::c_char,
        points: *const f32,
        velocities: *const f32,
        count: usize,
        voxel: f64,
        is_fixed: i32,
        packing: u32,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe {
            (self
                .rlvdb_test_points_write)(
                path,
                points,
                velocities,
                count,
                voxel,
                is_fixed,
                packing,
                error,
            )
        }
    }
    pub unsafe fn rlvdb_test_instances_write(
        &self,
        path: *const ::std::ffi::c_char,
        grid: *const RlvdbGrid,
        error: *mut RlvdbError,
    ) -> i32 {
        unsafe { (self.rlvdb_test_instances_write)(path, grid, error) }
    }
}
