// Made by `cargo xtask bindings` from include/relievo; do not edit.

use std::ffi::{c_char, c_void};

use relievo::version::*;
use relievo::error::*;
use relievo::context::*;
use relievo::adapter::*;
use relievo::allocator::*;
use relievo::bytes::*;
use relievo::mesh::*;
use relievo::simplify::*;
use relievo::progressive::*;
use relievo::arrival::*;
use relievo::surface::*;
use relievo::detail::*;
use relievo::bake::*;
use relievo::evaluate::*;
use relievo::bezier::*;
use relievo::parameter::*;
use relievo::brush::*;
use relievo::tessellate::*;
use relievo::buffer::*;
use relievo::capability::*;
use relievo::caster::*;
use relievo::isosurface::*;
use relievo::particles::*;
use relievo::client::*;
use relievo::collider::*;
use relievo::color_buffer::*;
use relievo::crowd::*;
use relievo::crowd_stream::*;
use relievo::stream::*;
use relievo::document::*;
use relievo::layer::*;
use relievo::decal::*;
use relievo::device_crowd::*;
use relievo::stroke::*;
use relievo::level::*;
use relievo::device_level::*;
use relievo::diffuse::*;
use relievo::fluid::*;
use relievo::foam::*;
use relievo::grid::*;
use relievo::imprint::*;
use relievo::picture::*;
use relievo::procedural::*;
use relievo::ptex::*;
use relievo::repair::*;
use relievo::tissue::*;
use relievo::job::*;
use relievo::object::*;
use relievo::shader::*;
use relievo::subdivision::*;
use relievo::vulkan::*;

use super::{Initial, Offsets};

constant!(RLV_VERSION_MAJOR = 0);
constant!(RLV_VERSION_MINOR = 1);
constant!(RLV_VERSION_PATCH = 0);
function!(rlv_version: unsafe extern "C" fn() -> u32);
constant!(RLV_NAME_SIZE = 48);
constant!(RLV_TEXT_SIZE = 256);
alias!(RlvResult = i32);
constant!(RLV_OK = 0);
constant!(RLV_ERROR_INVALID = 1);
constant!(RLV_ERROR_UNSUPPORTED = 2);
constant!(RLV_ERROR_NOT_FOUND = 3);
constant!(RLV_ERROR_IO = 4);
constant!(RLV_ERROR_MEMORY = 5);
constant!(RLV_ERROR_BUSY = 6);
constant!(RLV_ERROR_CANCELLED = 7);
constant!(RLV_ERROR_INTERNAL = 8);
constant!(RLV_ERROR_DEVICE = 9);
constant!(RLV_ELEMENT_NONE = 0);
constant!(RLV_ELEMENT_POINT = 1);
constant!(RLV_ELEMENT_CORNER = 2);
constant!(RLV_ELEMENT_EDGE = 3);
constant!(RLV_ELEMENT_FACE = 4);
constant!(RLV_ELEMENT_TRIANGLE = 5);
constant!(RLV_ELEMENT_TILE = 6);
constant!(RLV_ELEMENT_PATCH = 7);
constant!(RLV_ELEMENT_ITEM = 8);
constant!(RLV_ELEMENT_PARTICLE = 9);
constant!(RLV_ELEMENT_LINE = 10);
constant!(RLV_ELEMENT_PIN = 11);
constant!(RLV_ELEMENT_CREASE = 12);
layout!(RlvError: 56, 8);
function!(rlv_error_last: unsafe extern "C" fn() -> *const c_char);
function!(rlv_error_get: unsafe extern "C" fn(*mut RlvError) -> RlvResult);
layout!(RlvContext: 8, 8);
constant!(RLV_DEVICE_CPU = 0);
constant!(RLV_DEVICE_GPU = 1);
constant!(RLV_DEVICE_AUTO = 2);
alias!(RlvLoopBody = Option<unsafe extern "C" fn(*mut c_void, usize)>);
alias!(RlvLoop = Option<unsafe extern "C" fn(*mut c_void, usize, RlvLoopBody, *mut c_void)>);
alias!(RlvTask = Option<unsafe extern "C" fn(*mut c_void)>);
alias!(RlvSpawn = Option<unsafe extern "C" fn(*mut c_void, RlvTask, *mut c_void)>);
layout!(RlvContextOptions: 72, 8);
layout!(RlvContextInfo: 600, 8);
layout!(RlvContextStat: 112, 8);
constant!(RLV_PROGRESS_CONTINUE = 0);
constant!(RLV_PROGRESS_CANCEL = 1);
alias!(RlvProgress = Option<unsafe extern "C" fn(*mut c_void, f32, *const c_char) -> u32>);
constant!(RLV_LOG_INFO = 0);
constant!(RLV_LOG_WARNING = 1);
alias!(RlvLog = Option<unsafe extern "C" fn(*mut c_void, u32, *const c_char)>);
function!(rlv_context_create: unsafe extern "C" fn(*const RlvContextOptions, *mut RlvContext) -> RlvResult);
function!(rlv_context_retain: unsafe extern "C" fn(RlvContext) -> RlvResult);
function!(rlv_context_release: unsafe extern "C" fn(RlvContext) -> RlvResult);
function!(rlv_context_info: unsafe extern "C" fn(RlvContext, *mut RlvContextInfo) -> RlvResult);
function!(rlv_context_close_device: unsafe extern "C" fn(RlvContext) -> RlvResult);
function!(rlv_context_set_log: unsafe extern "C" fn(RlvContext, RlvLog, *mut c_void) -> RlvResult);
alias!(RlvMemoryMonitor = Option<unsafe extern "C" fn(*mut c_void, i64) -> u32>);
function!(rlv_context_set_memory_monitor: unsafe extern "C" fn(RlvContext, RlvMemoryMonitor, *mut c_void) -> RlvResult);
function!(rlv_context_stats: unsafe extern "C" fn(RlvContext, *mut RlvContextStat, usize, *mut usize) -> RlvResult);
function!(rlv_context_reset_stats: unsafe extern "C" fn(RlvContext) -> RlvResult);
constant!(RLV_ADAPTER_DISCRETE = 0);
constant!(RLV_ADAPTER_INTEGRATED = 1);
constant!(RLV_ADAPTER_VIRTUAL = 2);
constant!(RLV_ADAPTER_SOFTWARE = 3);
layout!(RlvAdapterInfo: 584, 8);
function!(rlv_adapter_list: unsafe extern "C" fn(*mut RlvAdapterInfo, usize, *mut usize) -> RlvResult);
alias!(RlvAllocate = Option<unsafe extern "C" fn(*mut c_void, usize, usize) -> *mut c_void>);
alias!(RlvFree = Option<unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize)>);
layout!(RlvAllocator: 32, 8);
function!(rlv_allocator_set: unsafe extern "C" fn(*const RlvAllocator) -> RlvResult);
layout!(RlvAllocatorInfo: 24, 8);
function!(rlv_allocator_info: unsafe extern "C" fn(*mut RlvAllocatorInfo) -> RlvResult);
function!(rlv_allocator_set_limit: unsafe extern "C" fn(u64) -> RlvResult);
layout!(RlvBytes: 8, 8);
function!(rlv_bytes_retain: unsafe extern "C" fn(RlvBytes) -> RlvResult);
function!(rlv_bytes_release: unsafe extern "C" fn(RlvBytes) -> RlvResult);
function!(rlv_bytes_get: unsafe extern "C" fn(RlvBytes, *mut *const u8, *mut usize) -> RlvResult);
layout!(RlvMesh: 8, 8);
constant!(RLV_DOMAIN_POINT = 0);
constant!(RLV_DOMAIN_CORNER = 1);
constant!(RLV_DOMAIN_FACE = 2);
constant!(RLV_TYPE_F32 = 0);
constant!(RLV_TYPE_U32 = 1);
layout!(RlvMeshArrays: 184, 8);
layout!(RlvMeshInfo: 88, 8);
layout!(RlvAttributeArrays: 72, 8);
layout!(RlvAttributeInfo: 80, 8);
function!(rlv_mesh_create: unsafe extern "C" fn(RlvContext, *const RlvMeshArrays, *mut RlvMesh) -> RlvResult);
alias!(RlvMeshReleased = Option<unsafe extern "C" fn(*mut c_void)>);
function!(rlv_mesh_create_borrowed: unsafe extern "C" fn(RlvContext, *const RlvMeshArrays, RlvMeshReleased, *mut c_void, *mut RlvMesh) -> RlvResult);
function!(rlv_mesh_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvMesh) -> RlvResult);
function!(rlv_mesh_write: unsafe extern "C" fn(RlvMesh, *const c_char) -> RlvResult);
function!(rlv_mesh_read_bytes: unsafe extern "C" fn(RlvContext, *const c_char, *const u8, usize, *mut RlvMesh) -> RlvResult);
function!(rlv_mesh_write_bytes: unsafe extern "C" fn(RlvMesh, *const c_char, *mut RlvBytes) -> RlvResult);
function!(rlv_mesh_split: unsafe extern "C" fn(RlvMesh, f64, *mut RlvMesh) -> RlvResult);
function!(rlv_mesh_retain: unsafe extern "C" fn(RlvMesh) -> RlvResult);
function!(rlv_mesh_release: unsafe extern "C" fn(RlvMesh) -> RlvResult);
function!(rlv_mesh_info: unsafe extern "C" fn(RlvMesh, *mut RlvMeshInfo) -> RlvResult);
function!(rlv_mesh_set_points: unsafe extern "C" fn(RlvMesh, *const f32, usize, usize) -> RlvResult);
function!(rlv_mesh_add_attribute: unsafe extern "C" fn(RlvMesh, *const RlvAttributeArrays) -> RlvResult);
function!(rlv_mesh_get_points: unsafe extern "C" fn(RlvMesh, *mut f32, usize, usize) -> RlvResult);
function!(rlv_mesh_get_faces: unsafe extern "C" fn(RlvMesh, *mut u32, usize, *mut u32, usize) -> RlvResult);
function!(rlv_mesh_get_triangles: unsafe extern "C" fn(RlvMesh, *mut u32, usize, usize) -> RlvResult);
function!(rlv_mesh_find_attribute: unsafe extern "C" fn(RlvMesh, *const c_char, *mut u32) -> RlvResult);
function!(rlv_mesh_attribute_info: unsafe extern "C" fn(RlvMesh, u32, *mut RlvAttributeInfo) -> RlvResult);
function!(rlv_mesh_get_attribute: unsafe extern "C" fn(RlvMesh, u32, *mut c_void, usize, *mut u32, usize) -> RlvResult);
layout!(RlvSimplifyWeight: 16, 8);
layout!(RlvSimplifyOptions: 96, 8);
function!(rlv_simplify_mesh: unsafe extern "C" fn(RlvMesh, *const RlvSimplifyOptions, RlvProgress, *mut c_void, *mut f32, *mut RlvMesh) -> RlvResult);
layout!(RlvProgressive: 8, 8);
layout!(RlvProgressiveOptions: 64, 8);
layout!(RlvProgressiveInfo: 64, 8);
function!(rlv_progressive_create: unsafe extern "C" fn(RlvMesh, *const RlvProgressiveOptions, RlvProgress, *mut c_void, *mut RlvProgressive) -> RlvResult);
function!(rlv_progressive_read: unsafe extern "C" fn(RlvContext, *const c_char, usize, *mut RlvProgressive) -> RlvResult);
function!(rlv_progressive_write: unsafe extern "C" fn(RlvProgressive, *const c_char) -> RlvResult);
function!(rlv_progressive_read_bytes: unsafe extern "C" fn(RlvContext, *const u8, usize, usize, *mut RlvProgressive) -> RlvResult);
function!(rlv_progressive_write_bytes: unsafe extern "C" fn(RlvProgressive, *mut RlvBytes) -> RlvResult);
function!(rlv_progressive_retain: unsafe extern "C" fn(RlvProgressive) -> RlvResult);
function!(rlv_progressive_release: unsafe extern "C" fn(RlvProgressive) -> RlvResult);
function!(rlv_progressive_info: unsafe extern "C" fn(RlvProgressive, *mut RlvProgressiveInfo) -> RlvResult);
function!(rlv_progressive_attribute_info: unsafe extern "C" fn(RlvProgressive, u32, *mut RlvAttributeInfo) -> RlvResult);
layout!(RlvArrival: 8, 8);
layout!(RlvArrivalInfo: 16, 8);
function!(rlv_arrival_create: unsafe extern "C" fn(RlvContext, *mut RlvArrival) -> RlvResult);
function!(rlv_arrival_retain: unsafe extern "C" fn(RlvArrival) -> RlvResult);
function!(rlv_arrival_release: unsafe extern "C" fn(RlvArrival) -> RlvResult);
function!(rlv_arrival_push: unsafe extern "C" fn(RlvArrival, *const c_void, usize, *mut RlvArrivalInfo) -> RlvResult);
function!(rlv_arrival_progressive: unsafe extern "C" fn(RlvArrival, *mut RlvProgressive) -> RlvResult);
layout!(RlvSurface: 8, 8);
constant!(RLV_BOUNDARY_EDGES_AND_CORNERS = 0);
constant!(RLV_BOUNDARY_EDGES = 1);
constant!(RLV_BOUNDARY_NONE = 2);
constant!(RLV_SURFACE_CATMULL_CLARK = 0);
constant!(RLV_SURFACE_TRIANGLES = 1);
constant!(RLV_SURFACE_BILINEAR = 2);
layout!(RlvSurfaceOptions: 24, 4);
layout!(RlvSurfaceInfo: 80, 8);
layout!(RlvTileInfo: 44, 4);
function!(rlv_surface_create: unsafe extern "C" fn(RlvContext, RlvMesh, *const RlvSurfaceOptions, *mut RlvSurface) -> RlvResult);
function!(rlv_surface_retain: unsafe extern "C" fn(RlvSurface) -> RlvResult);
function!(rlv_surface_release: unsafe extern "C" fn(RlvSurface) -> RlvResult);
function!(rlv_surface_info: unsafe extern "C" fn(RlvSurface, *mut RlvSurfaceInfo) -> RlvResult);
function!(rlv_surface_set_points: unsafe extern "C" fn(RlvSurface, *const f32, usize, usize) -> RlvResult);
function!(rlv_surface_tile_info: unsafe extern "C" fn(RlvSurface, u32, *mut RlvTileInfo) -> RlvResult);
function!(rlv_surface_face_tiles: unsafe extern "C" fn(RlvSurface, u32, *mut u32, *mut u32) -> RlvResult);
layout!(RlvDetail: 8, 8);
layout!(RlvDetailOptions: 40, 8);
layout!(RlvDetailInfo: 96, 8);
constant!(RLV_CHANNEL_DISPLACEMENT = 0);
constant!(RLV_CHANNEL_COLOR = 1);
constant!(RLV_CHANNEL_VECTORS = 2);
constant!(RLV_CHANNEL_TRACES = 3);
layout!(RlvChannelInfo: 48, 8);
layout!(RlvDetailFolds: 24, 8);
constant!(RLV_COLOR_RGBA8 = 0);
constant!(RLV_COLOR_RGBA16F = 1);
layout!(RlvPaintOptions: 40, 8);
layout!(RlvVectorOptions: 16, 8);
layout!(RlvDecayOptions: 24, 8);
layout!(RlvDetailChanges: 48, 8);
layout!(RlvDetailTileInfo: 56, 8);
function!(rlv_detail_create: unsafe extern "C" fn(RlvSurface, *const RlvDetailOptions, *const f64, *mut RlvDetail) -> RlvResult);
function!(rlv_detail_retain: unsafe extern "C" fn(RlvDetail) -> RlvResult);
function!(rlv_detail_release: unsafe extern "C" fn(RlvDetail) -> RlvResult);
function!(rlv_detail_info: unsafe extern "C" fn(RlvDetail, *mut RlvDetailInfo) -> RlvResult);
function!(rlv_detail_device_fault: unsafe extern "C" fn(RlvDetail) -> RlvResult);
function!(rlv_detail_set_budget: unsafe extern "C" fn(RlvDetail, u64) -> RlvResult);
function!(rlv_detail_set_paging: unsafe extern "C" fn(RlvDetail, u32, *const c_char) -> RlvResult);
function!(rlv_detail_add_paint: unsafe extern "C" fn(RlvDetail, *const RlvPaintOptions) -> RlvResult);
function!(rlv_detail_add_vectors: unsafe extern "C" fn(RlvDetail, *const RlvVectorOptions) -> RlvResult);
function!(rlv_detail_add_traces: unsafe extern "C" fn(RlvDetail, u64) -> RlvResult);
function!(rlv_detail_set_decay: unsafe extern "C" fn(RlvDetail, *const RlvDecayOptions) -> RlvResult);
function!(rlv_detail_advance: unsafe extern "C" fn(RlvDetail, f64) -> RlvResult);
function!(rlv_detail_channel_info: unsafe extern "C" fn(RlvDetail, u32, *mut RlvChannelInfo) -> RlvResult);
function!(rlv_detail_folds: unsafe extern "C" fn(RlvDetail, *mut RlvDetailFolds) -> RlvResult);
function!(rlv_detail_set_face_sizes: unsafe extern "C" fn(RlvDetail, *const u32, usize, usize) -> RlvResult);
function!(rlv_detail_set_transform: unsafe extern "C" fn(RlvDetail, *const f64) -> RlvResult);
function!(rlv_detail_set_points: unsafe extern "C" fn(RlvDetail, *const f32, usize, usize) -> RlvResult);
function!(rlv_detail_commit: unsafe extern "C" fn(RlvDetail, *mut RlvDetailChanges) -> RlvResult);
function!(rlv_detail_changed_tiles: unsafe extern "C" fn(RlvDetail, *mut u32, usize, *mut usize) -> RlvResult);
function!(rlv_detail_refused_faces: unsafe extern "C" fn(RlvDetail, *mut u32, usize, *mut usize) -> RlvResult);
function!(rlv_detail_tile_info: unsafe extern "C" fn(RlvDetail, u32, u32, *mut RlvDetailTileInfo) -> RlvResult);
function!(rlv_detail_read_block: unsafe extern "C" fn(RlvDetail, u32, u32, *mut c_void, usize, *mut usize) -> RlvResult);
function!(rlv_detail_write_block: unsafe extern "C" fn(RlvDetail, u32, u32, *const c_void, usize) -> RlvResult);
constant!(RLV_BAKE_DISPLACEMENT = 0);
constant!(RLV_BAKE_VECTOR = 1);
constant!(RLV_BAKE_NORMAL = 2);
constant!(RLV_BAKE_COLOR = 3);
constant!(RLV_BAKE_MASK = 4);
constant!(RLV_BAKE_CONTACT = 5);
constant!(RLV_BAKE_DEPTH = 6);
constant!(RLV_BAKE_TIME = 7);
constant!(RLV_BAKE_TANGENT = 0);
constant!(RLV_BAKE_OBJECT = 1);
constant!(RLV_BAKE_TNB = 0);
constant!(RLV_BAKE_TBN = 1);
constant!(RLV_BAKE_OPENGL = 0);
constant!(RLV_BAKE_DIRECTX = 1);
layout!(RlvBakeOptions: 56, 8);
layout!(RlvBakePicture: 40, 8);
layout!(RlvBakeReport: 56, 8);
alias!(RlvBakeReceiver = Option<unsafe extern "C" fn(*mut c_void, *const RlvBakePicture) -> u32>);
function!(rlv_bake_run: unsafe extern "C" fn(RlvDetail, *const RlvBakeOptions, RlvBakeReceiver, RlvProgress, *mut c_void, *mut RlvBakeReport) -> RlvResult);
function!(rlv_bake_write: unsafe extern "C" fn(RlvDetail, *const RlvBakeOptions, *const c_char, RlvProgress, *mut c_void, *mut RlvBakeReport) -> RlvResult);
layout!(RlvEvaluateArrays: 240, 8);
function!(rlv_evaluate_surface: unsafe extern "C" fn(RlvSurface, *const RlvEvaluateArrays) -> RlvResult);
function!(rlv_evaluate_detail: unsafe extern "C" fn(RlvDetail, *const RlvEvaluateArrays) -> RlvResult);
layout!(RlvBezier: 8, 8);
layout!(RlvBezierArrays: 72, 8);
layout!(RlvBezierInfo: 48, 8);
layout!(RlvBezierView: 80, 8);
layout!(RlvBezierLevels: 32, 8);
layout!(RlvBezierTriangles: 72, 8);
function!(rlv_bezier_create: unsafe extern "C" fn(RlvContext, *const RlvBezierArrays, *mut RlvBezier) -> RlvResult);
function!(rlv_bezier_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvBezier) -> RlvResult);
function!(rlv_bezier_retain: unsafe extern "C" fn(RlvBezier) -> RlvResult);
function!(rlv_bezier_release: unsafe extern "C" fn(RlvBezier) -> RlvResult);
function!(rlv_bezier_info: unsafe extern "C" fn(RlvBezier, *mut RlvBezierInfo) -> RlvResult);
function!(rlv_bezier_get_controls: unsafe extern "C" fn(RlvBezier, usize, *mut f32, usize) -> RlvResult);
function!(rlv_bezier_evaluate: unsafe extern "C" fn(RlvBezier, *const RlvEvaluateArrays) -> RlvResult);
function!(rlv_bezier_levels: unsafe extern "C" fn(RlvBezier, *const RlvBezierView, *mut u32, usize) -> RlvResult);
function!(rlv_bezier_count: unsafe extern "C" fn(RlvBezier, *const RlvBezierLevels, *mut usize, *mut usize) -> RlvResult);
function!(rlv_bezier_tessellate: unsafe extern "C" fn(RlvBezier, *const RlvBezierLevels, *const RlvBezierTriangles) -> RlvResult);
function!(rlv_bezier_mesh: unsafe extern "C" fn(RlvBezier, *const RlvBezierLevels, *mut RlvMesh) -> RlvResult);
constant!(RLV_PARAMETER_F32 = 0);
constant!(RLV_PARAMETER_U32 = 1);
constant!(RLV_PARAMETER_BOOL = 2);
layout!(RlvParameter: 56, 8);
layout!(RlvBrush: 8, 8);
constant!(RLV_BRUSH_PAINT = 0);
constant!(RLV_BRUSH_SCULPT = 1);
constant!(RLV_PAINT_MIX = 0);
constant!(RLV_PAINT_ADD = 1);
constant!(RLV_PAINT_MULTIPLY = 2);
constant!(RLV_PAINT_ERASE = 3);
constant!(RLV_PAINT_BLUR = 4);
constant!(RLV_PAINT_SMEAR = 5);
constant!(RLV_SCULPT_DRAW = 0);
constant!(RLV_SCULPT_SMOOTH = 1);
constant!(RLV_SCULPT_FLATTEN = 2);
constant!(RLV_SCULPT_ERASE = 3);
constant!(RLV_SCULPT_CLAY = 4);
constant!(RLV_SCULPT_SCRAPE = 5);
constant!(RLV_SCULPT_LAYER = 6);
constant!(RLV_SCULPT_INFLATE = 7);
constant!(RLV_SCULPT_PINCH = 8);
constant!(RLV_SCULPT_VECTOR = 9);
constant!(RLV_FALLOFF_CONSTANT = 0);
constant!(RLV_FALLOFF_LINEAR = 1);
constant!(RLV_FALLOFF_SMOOTH = 2);
constant!(RLV_FALLOFF_SPHERE = 3);
constant!(RLV_FALLOFF_GAUSSIAN = 4);
constant!(RLV_CURVE_SIZE = 0);
constant!(RLV_CURVE_STRENGTH = 1);
constant!(RLV_CURVE_ANGLE = 2);
layout!(RlvBrushOptions: 40, 4);
layout!(RlvBrushSettings: 84, 4);
layout!(RlvStampOptions: 32, 8);
layout!(RlvStampSettings: 28, 4);
function!(rlv_brush_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_brush_stamp_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_brush_create: unsafe extern "C" fn(RlvContext, *const RlvBrushOptions, *const RlvBrushSettings, *mut RlvBrush) -> RlvResult);
function!(rlv_brush_retain: unsafe extern "C" fn(RlvBrush) -> RlvResult);
function!(rlv_brush_release: unsafe extern "C" fn(RlvBrush) -> RlvResult);
function!(rlv_brush_set: unsafe extern "C" fn(RlvBrush, *const RlvBrushOptions, *const RlvBrushSettings) -> RlvResult);
function!(rlv_brush_set_curve: unsafe extern "C" fn(RlvBrush, u32, *const f64, usize) -> RlvResult);
function!(rlv_brush_set_stamp: unsafe extern "C" fn(RlvBrush, *const RlvStampOptions, *const RlvStampSettings) -> RlvResult);
layout!(RlvTessellateOptions: 24, 4);
function!(rlv_tessellate_surface: unsafe extern "C" fn(RlvSurface, *const RlvTessellateOptions, *mut RlvMesh) -> RlvResult);
function!(rlv_tessellate_detail: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvMesh) -> RlvResult);
layout!(RlvTessellation: 8, 8);
layout!(RlvTessellationInfo: 32, 8);
layout!(RlvTessellationChanges: 48, 8);
function!(rlv_tessellation_create: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvTessellation) -> RlvResult);
function!(rlv_tessellation_retain: unsafe extern "C" fn(RlvTessellation) -> RlvResult);
function!(rlv_tessellation_release: unsafe extern "C" fn(RlvTessellation) -> RlvResult);
function!(rlv_tessellation_info: unsafe extern "C" fn(RlvTessellation, *mut RlvTessellationInfo) -> RlvResult);
function!(rlv_tessellation_update: unsafe extern "C" fn(RlvTessellation, *mut RlvTessellationChanges) -> RlvResult);
function!(rlv_tessellation_changed_ranges: unsafe extern "C" fn(RlvTessellation, *mut u32, usize, *mut usize) -> RlvResult);
function!(rlv_tessellation_get_points: unsafe extern "C" fn(RlvTessellation, usize, usize, *mut f32, usize, *mut f32, usize) -> RlvResult);
function!(rlv_tessellation_get_colors: unsafe extern "C" fn(RlvTessellation, usize, usize, *mut f32, usize) -> RlvResult);
function!(rlv_tessellation_get_traces: unsafe extern "C" fn(RlvTessellation, usize, usize, *mut f32, usize) -> RlvResult);
function!(rlv_tessellation_mesh: unsafe extern "C" fn(RlvTessellation, *mut RlvMesh) -> RlvResult);
layout!(RlvBuffer: 8, 8);
layout!(RlvBufferInfo: 40, 8);
layout!(RlvBufferVulkan: 64, 8);
function!(rlv_buffer_create: unsafe extern "C" fn(RlvTessellation, *mut RlvBuffer) -> RlvResult);
function!(rlv_buffer_retain: unsafe extern "C" fn(RlvBuffer) -> RlvResult);
function!(rlv_buffer_release: unsafe extern "C" fn(RlvBuffer) -> RlvResult);
function!(rlv_buffer_update: unsafe extern "C" fn(RlvBuffer, *mut RlvBufferInfo) -> RlvResult);
function!(rlv_buffer_info: unsafe extern "C" fn(RlvBuffer, *mut RlvBufferInfo) -> RlvResult);
function!(rlv_buffer_vulkan: unsafe extern "C" fn(RlvBuffer, *mut RlvBufferVulkan) -> RlvResult);
function!(rlv_buffer_read: unsafe extern "C" fn(RlvBuffer, usize, usize, *mut f32, usize) -> RlvResult);
layout!(RlvCapability: 112, 8);
constant!(RLV_CONTENT_MESH = 0);
constant!(RLV_CONTENT_PATCHES = 1);
constant!(RLV_CONTENT_PARTICLES = 2);
constant!(RLV_CONTENT_GRID = 3);
constant!(RLV_CONTENT_TEXTURE = 4);
constant!(RLV_CONTENT_DOCUMENT = 5);
constant!(RLV_CONTENT_PROGRESSIVE = 6);
constant!(RLV_CONTENT_CROWD = 7);
constant!(RLV_CONTENT_TISSUE = 8);
layout!(RlvCapabilityFormat: 64, 4);
function!(rlv_capability_get: unsafe extern "C" fn(*mut RlvCapability) -> RlvResult);
function!(rlv_capability_list: unsafe extern "C" fn(*mut RlvCapabilityFormat, usize, *mut usize) -> RlvResult);
layout!(RlvCaster: 8, 8);
constant!(RLV_NO_ELEMENT = 4294967295);
layout!(RlvHit: 44, 4);
layout!(RlvRayArrays: 136, 8);
function!(rlv_caster_create_mesh: unsafe extern "C" fn(RlvContext, RlvMesh, *mut RlvCaster) -> RlvResult);
function!(rlv_caster_create_detail: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvCaster) -> RlvResult);
function!(rlv_caster_create_tessellation: unsafe extern "C" fn(RlvTessellation, *mut RlvCaster) -> RlvResult);
function!(rlv_caster_update: unsafe extern "C" fn(RlvCaster) -> RlvResult);
function!(rlv_caster_retain: unsafe extern "C" fn(RlvCaster) -> RlvResult);
function!(rlv_caster_release: unsafe extern "C" fn(RlvCaster) -> RlvResult);
function!(rlv_caster_set_mask: unsafe extern "C" fn(RlvCaster, u32) -> RlvResult);
function!(rlv_caster_cast: unsafe extern "C" fn(RlvCaster, *const RlvRayArrays) -> RlvResult);
function!(rlv_caster_occluded: unsafe extern "C" fn(RlvCaster, *const RlvRayArrays, *mut u8, usize) -> RlvResult);
layout!(RlvIsosurface: 8, 8);
constant!(RLV_ISOSURFACE_BLOBS = 0);
constant!(RLV_ISOSURFACE_ZHU_BRIDSON = 1);
constant!(RLV_ISOSURFACE_DENSITY = 2);
constant!(RLV_ISOSURFACE_ANISOTROPIC = 3);
constant!(RLV_ISOSURFACE_SURFACE = 0);
constant!(RLV_ISOSURFACE_BLIND = 1);
constant!(RLV_ISOSURFACE_HIDDEN = 2);
layout!(RlvIsosurfaceOptions: 40, 4);
layout!(RlvIsosurfaceParticles: 64, 8);
layout!(RlvIsosurfaceInfo: 32, 8);
layout!(RlvIsosurfaceMeshOptions: 48, 8);
layout!(RlvIsosurfaceClasses: 40, 8);
layout!(RlvIsosurfaceRay: 36, 4);
layout!(RlvIsosurfaceHit: 44, 4);
alias!(RlvIsosurfaceIntersect = Option<unsafe extern "C" fn(*const c_void, *const RlvIsosurfaceRay, *mut RlvIsosurfaceHit) -> u32>);
layout!(RlvIsosurfaceTable: 48, 8);
function!(rlv_isosurface_create: unsafe extern "C" fn(RlvContext, *const RlvIsosurfaceParticles, *const RlvIsosurfaceOptions, *mut RlvIsosurface) -> RlvResult);
function!(rlv_isosurface_retain: unsafe extern "C" fn(RlvIsosurface) -> RlvResult);
function!(rlv_isosurface_release: unsafe extern "C" fn(RlvIsosurface) -> RlvResult);
function!(rlv_isosurface_info: unsafe extern "C" fn(RlvIsosurface, *mut RlvIsosurfaceInfo) -> RlvResult);
function!(rlv_isosurface_mesh: unsafe extern "C" fn(RlvIsosurface, *const RlvIsosurfaceMeshOptions, RlvProgress, *mut c_void, *mut RlvMesh) -> RlvResult);
function!(rlv_isosurface_classify: unsafe extern "C" fn(RlvIsosurface, f32, *mut u8, usize, usize, RlvProgress, *mut c_void, *mut RlvIsosurfaceClasses) -> RlvResult);
function!(rlv_isosurface_cast: unsafe extern "C" fn(RlvIsosurface, *const RlvRayArrays, *mut RlvIsosurfaceHit, usize) -> RlvResult);
function!(rlv_isosurface_table: unsafe extern "C" fn(RlvIsosurface, *mut RlvIsosurfaceTable) -> RlvResult);
layout!(RlvParticles: 8, 8);
layout!(RlvParticlesArrays: 88, 8);
layout!(RlvParticlesInfo: 40, 8);
function!(rlv_particles_create: unsafe extern "C" fn(RlvContext, *const RlvParticlesArrays, *mut RlvParticles) -> RlvResult);
function!(rlv_particles_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvParticles) -> RlvResult);
function!(rlv_particles_write: unsafe extern "C" fn(RlvParticles, *const c_char) -> RlvResult);
function!(rlv_particles_retain: unsafe extern "C" fn(RlvParticles) -> RlvResult);
function!(rlv_particles_release: unsafe extern "C" fn(RlvParticles) -> RlvResult);
function!(rlv_particles_info: unsafe extern "C" fn(RlvParticles, *mut RlvParticlesInfo) -> RlvResult);
function!(rlv_particles_get_points: unsafe extern "C" fn(RlvParticles, *mut f32, usize, usize) -> RlvResult);
function!(rlv_particles_get_numbers: unsafe extern "C" fn(RlvParticles, *mut u32, usize, usize) -> RlvResult);
function!(rlv_particles_find_channel: unsafe extern "C" fn(RlvParticles, *const c_char, *mut u32) -> RlvResult);
function!(rlv_particles_channel_info: unsafe extern "C" fn(RlvParticles, u32, *mut RlvAttributeInfo) -> RlvResult);
function!(rlv_particles_get_channel: unsafe extern "C" fn(RlvParticles, u32, *mut f32, usize, usize) -> RlvResult);
function!(rlv_particles_keep: unsafe extern "C" fn(RlvParticles, *const u8, usize, usize, *mut RlvParticles) -> RlvResult);
function!(rlv_particles_isosurface: unsafe extern "C" fn(RlvParticles, *const RlvIsosurfaceOptions, *mut RlvIsosurface) -> RlvResult);
layout!(RlvClient: 8, 8);
layout!(RlvClientOptions: 48, 8);
constant!(RLV_CLIENT_RUNNING = 0);
constant!(RLV_CLIENT_FORCES = 1);
constant!(RLV_CLIENT_PAUSED = 2);
constant!(RLV_CLIENT_DONE = 3);
constant!(RLV_CLIENT_CANCELLED = 4);
constant!(RLV_CLIENT_FAILED = 5);
layout!(RlvClientStatus: 304, 8);
layout!(RlvClientInfo: 576, 4);
layout!(RlvClientFile: 16, 8);
layout!(RlvClientScene: 48, 8);
constant!(RLV_CLIENT_PAUSE = 0);
constant!(RLV_CLIENT_RESUME = 1);
constant!(RLV_CLIENT_CANCEL = 2);
constant!(RLV_CLIENT_REMOVE = 3);
constant!(RLV_CLIENT_ALL = 0);
constant!(RLV_CLIENT_BLIND = 1);
constant!(RLV_CLIENT_SURFACE = 2);
layout!(RlvClientFetch: 24, 8);
constant!(RLV_CLIENT_FRAME = 0);
constant!(RLV_CLIENT_MESH = 1);
constant!(RLV_CLIENT_LEVEL_SET = 2);
function!(rlv_client_connect: unsafe extern "C" fn(RlvContext, *const RlvClientOptions, *mut RlvClient) -> RlvResult);
function!(rlv_client_retain: unsafe extern "C" fn(RlvClient) -> RlvResult);
function!(rlv_client_release: unsafe extern "C" fn(RlvClient) -> RlvResult);
function!(rlv_client_info: unsafe extern "C" fn(RlvClient, *mut RlvClientInfo) -> RlvResult);
function!(rlv_client_submit: unsafe extern "C" fn(RlvClient, *const RlvClientScene, RlvProgress, *mut c_void, *mut RlvClientStatus) -> RlvResult);
function!(rlv_client_poll: unsafe extern "C" fn(RlvClient, *const c_char, *mut RlvClientStatus) -> RlvResult);
function!(rlv_client_wait: unsafe extern "C" fn(RlvClient, *const c_char, u64, RlvProgress, *mut c_void, *mut RlvClientStatus) -> RlvResult);
function!(rlv_client_steer: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const c_char, *mut RlvClientStatus) -> RlvResult);
function!(rlv_client_force: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const f32, usize, usize, *mut RlvClientStatus) -> RlvResult);
function!(rlv_client_control: unsafe extern "C" fn(RlvClient, *const c_char, u32) -> RlvResult);
function!(rlv_client_fetch: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const RlvClientFetch, RlvProgress, *mut c_void, *mut RlvParticles) -> RlvResult);
function!(rlv_client_fetch_mesh: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const c_char, RlvProgress, *mut c_void, *mut RlvMesh) -> RlvResult);
function!(rlv_client_save: unsafe extern "C" fn(RlvClient, *const c_char, u64, u32, *const c_char, *const c_char, RlvProgress, *mut c_void) -> RlvResult);
layout!(RlvCollider: 8, 8);
layout!(RlvColliderInfo: 128, 8);
layout!(RlvToolSettings: 12, 4);
function!(rlv_collider_create_mesh: unsafe extern "C" fn(RlvContext, RlvMesh, *const f64, *mut RlvCollider) -> RlvResult);
function!(rlv_collider_create_surface: unsafe extern "C" fn(RlvSurface, *const RlvTessellateOptions, *const f64, *mut RlvCollider) -> RlvResult);
function!(rlv_collider_create_detail: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvCollider) -> RlvResult);
function!(rlv_collider_retain: unsafe extern "C" fn(RlvCollider) -> RlvResult);
function!(rlv_collider_release: unsafe extern "C" fn(RlvCollider) -> RlvResult);
function!(rlv_collider_info: unsafe extern "C" fn(RlvCollider, *mut RlvColliderInfo) -> RlvResult);
function!(rlv_collider_set_transform: unsafe extern "C" fn(RlvCollider, *const f64) -> RlvResult);
function!(rlv_collider_set_points: unsafe extern "C" fn(RlvCollider, *const f32, usize, usize) -> RlvResult);
function!(rlv_collider_press_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_collider_press: unsafe extern "C" fn(RlvCollider, *const f64, *const f64, f64, *const RlvToolSettings) -> RlvResult);
layout!(RlvColorBuffer: 8, 8);
layout!(RlvColorBufferInfo: 64, 8);
layout!(RlvColorBufferVulkan: 80, 8);
function!(rlv_color_buffer_create: unsafe extern "C" fn(RlvDetail, *mut RlvColorBuffer) -> RlvResult);
function!(rlv_color_buffer_retain: unsafe extern "C" fn(RlvColorBuffer) -> RlvResult);
function!(rlv_color_buffer_release: unsafe extern "C" fn(RlvColorBuffer) -> RlvResult);
function!(rlv_color_buffer_update: unsafe extern "C" fn(RlvColorBuffer, *mut RlvColorBufferInfo) -> RlvResult);
function!(rlv_color_buffer_info: unsafe extern "C" fn(RlvColorBuffer, *mut RlvColorBufferInfo) -> RlvResult);
function!(rlv_color_buffer_vulkan: unsafe extern "C" fn(RlvColorBuffer, *mut RlvColorBufferVulkan) -> RlvResult);
function!(rlv_color_buffer_read: unsafe extern "C" fn(RlvColorBuffer, u32, u32, *mut c_void, usize, *mut usize) -> RlvResult);
layout!(RlvCrowdModel: 8, 8);
layout!(RlvCrowd: 8, 8);
constant!(RLV_CROWD_BLEND_LINEAR = 0);
constant!(RLV_CROWD_BLEND_DUAL_QUATERNION = 1);
layout!(RlvCrowdBuildSettings: 20, 4);
layout!(RlvCrowdClipName: 8, 8);
layout!(RlvCrowdRefitReport: 24, 8);
layout!(RlvCrowdModelInfo: 104, 8);
layout!(RlvCrowdClip: 60, 4);
layout!(RlvCrowdMaterial: 260, 4);
layout!(RlvCrowdVertices: 56, 8);
layout!(RlvCrowdCollapse: 8, 4);
layout!(RlvCrowdOffset: 20, 4);
layout!(RlvCrowdCluster: 24, 4);
layout!(RlvCrowdAgent: 112, 8);
layout!(RlvCrowdSun: 32, 8);
layout!(RlvCrowdView: 144, 8);
layout!(RlvCrowdFrame: 72, 8);
layout!(RlvCrowdDraw: 20, 4);
layout!(RlvCrowdInstance: 56, 4);
layout!(RlvCrowdBuffers: 128, 8);
constant!(RLV_CROWD_PICTURE_SIDE = 32);
layout!(RlvCrowdImpostor: 56, 4);
layout!(RlvCrowdPicture: 64, 8);
layout!(RlvCrowdTexel: 20, 4);
layout!(RlvCrowdImpostors: 72, 8);
function!(rlv_crowd_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_crowd_model_build: unsafe extern "C" fn(RlvContext, *const c_char, *const RlvCrowdClipName, usize, *const RlvCrowdBuildSettings, RlvProgress, *mut c_void, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_refit: unsafe extern "C" fn(RlvCrowdModel, *const c_char, *const RlvCrowdClipName, usize, *const RlvCrowdBuildSettings, RlvProgress, *mut c_void, *mut RlvCrowdRefitReport, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_with_blend: unsafe extern "C" fn(RlvCrowdModel, u32, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_write: unsafe extern "C" fn(RlvCrowdModel, *const c_char) -> RlvResult);
function!(rlv_crowd_model_read_bytes: unsafe extern "C" fn(RlvContext, *const u8, usize, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_write_bytes: unsafe extern "C" fn(RlvCrowdModel, *mut RlvBytes) -> RlvResult);
function!(rlv_crowd_model_retain: unsafe extern "C" fn(RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_release: unsafe extern "C" fn(RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_model_info: unsafe extern "C" fn(RlvCrowdModel, *mut RlvCrowdModelInfo) -> RlvResult);
function!(rlv_crowd_model_clip: unsafe extern "C" fn(RlvCrowdModel, u32, *mut RlvCrowdClip) -> RlvResult);
function!(rlv_crowd_model_material: unsafe extern "C" fn(RlvCrowdModel, u32, *mut RlvCrowdMaterial) -> RlvResult);
function!(rlv_crowd_model_get_vertices: unsafe extern "C" fn(RlvCrowdModel, *const RlvCrowdVertices) -> RlvResult);
function!(rlv_crowd_model_get_collapses: unsafe extern "C" fn(RlvCrowdModel, *mut RlvCrowdCollapse, usize, usize) -> RlvResult);
function!(rlv_crowd_model_get_offsets: unsafe extern "C" fn(RlvCrowdModel, *mut RlvCrowdOffset, usize, usize) -> RlvResult);
function!(rlv_crowd_model_get_triangles: unsafe extern "C" fn(RlvCrowdModel, *mut u32, *mut u32, usize) -> RlvResult);
function!(rlv_crowd_model_get_clusters: unsafe extern "C" fn(RlvCrowdModel, *mut RlvCrowdCluster, usize, usize) -> RlvResult);
function!(rlv_crowd_model_mesh: unsafe extern "C" fn(RlvCrowdModel, f32, u32, u32, *mut RlvMesh) -> RlvResult);
function!(rlv_crowd_create: unsafe extern "C" fn(RlvContext, *const RlvCrowdModel, usize, *mut RlvCrowd) -> RlvResult);
function!(rlv_crowd_retain: unsafe extern "C" fn(RlvCrowd) -> RlvResult);
function!(rlv_crowd_release: unsafe extern "C" fn(RlvCrowd) -> RlvResult);
function!(rlv_crowd_add: unsafe extern "C" fn(RlvCrowd, *const RlvCrowdAgent, usize, usize, *mut u32) -> RlvResult);
function!(rlv_crowd_set: unsafe extern "C" fn(RlvCrowd, u32, *const RlvCrowdAgent, usize, usize) -> RlvResult);
function!(rlv_crowd_set_weights: unsafe extern "C" fn(RlvCrowd, u32, *const f32, usize) -> RlvResult);
function!(rlv_crowd_cut: unsafe extern "C" fn(RlvCrowd, *const RlvCrowdView, *mut RlvCrowdFrame) -> RlvResult);
function!(rlv_crowd_get: unsafe extern "C" fn(RlvCrowd, *const RlvCrowdBuffers) -> RlvResult);
function!(rlv_crowd_get_impostors: unsafe extern "C" fn(RlvCrowd, *const RlvCrowdImpostors) -> RlvResult);
layout!(RlvCrowdStreamFile: 8, 8);
layout!(RlvCrowdStreamSettings: 16, 8);
layout!(RlvCrowdStreamInfo: 40, 8);
layout!(RlvCrowdStreamCluster: 16, 4);
function!(rlv_crowd_stream_open: unsafe extern "C" fn(RlvContext, *const RlvCrowdStreamFile, usize, *const RlvCrowdStreamSettings, *mut RlvCrowd) -> RlvResult);
function!(rlv_crowd_stream_model: unsafe extern "C" fn(RlvCrowd, u32, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_crowd_stream_info: unsafe extern "C" fn(RlvCrowd, *mut RlvCrowdStreamInfo) -> RlvResult);
function!(rlv_crowd_stream_get_read: unsafe extern "C" fn(RlvCrowd, *mut RlvCrowdStreamCluster, usize, usize) -> RlvResult);
function!(rlv_crowd_stream_get_triangles: unsafe extern "C" fn(RlvCrowd, u32, *mut u32, *mut u32, usize) -> RlvResult);
alias!(RlvStreamRead = Option<unsafe extern "C" fn(*mut c_void, u64, *mut u8, usize) -> u32>);
alias!(RlvStreamWrite = Option<unsafe extern "C" fn(*mut c_void, u64, *const u8, usize) -> u32>);
alias!(RlvStreamLength = Option<unsafe extern "C" fn(*mut c_void, *mut u64) -> u32>);
alias!(RlvStreamCut = Option<unsafe extern "C" fn(*mut c_void, u64) -> u32>);
alias!(RlvStreamSync = Option<unsafe extern "C" fn(*mut c_void) -> u32>);
alias!(RlvStreamClose = Option<unsafe extern "C" fn(*mut c_void)>);
layout!(RlvStream: 64, 8);
layout!(RlvDocument: 8, 8);
layout!(RlvDocumentInfo: 32, 8);
layout!(RlvDocumentChanges: 32, 8);
layout!(RlvTransferOptions: 24, 8);
layout!(RlvTransferReport: 48, 8);
function!(rlv_document_create: unsafe extern "C" fn(RlvDetail, *const c_char, u64, *mut RlvDocument) -> RlvResult);
function!(rlv_document_open: unsafe extern "C" fn(RlvDetail, *const c_char, u64, *mut RlvDocument) -> RlvResult);
function!(rlv_document_create_stream: unsafe extern "C" fn(RlvDetail, *const RlvStream, u64, *mut RlvDocument) -> RlvResult);
function!(rlv_document_open_stream: unsafe extern "C" fn(RlvDetail, *const RlvStream, u64, *mut RlvDocument) -> RlvResult);
function!(rlv_document_open_bytes: unsafe extern "C" fn(RlvDetail, *const u8, usize, u64, *mut RlvDocument) -> RlvResult);
function!(rlv_document_retain: unsafe extern "C" fn(RlvDocument) -> RlvResult);
function!(rlv_document_release: unsafe extern "C" fn(RlvDocument) -> RlvResult);
function!(rlv_document_info: unsafe extern "C" fn(RlvDocument, *mut RlvDocumentInfo) -> RlvResult);
function!(rlv_document_begin: unsafe extern "C" fn(RlvDocument, *const c_char) -> RlvResult);
function!(rlv_document_end: unsafe extern "C" fn(RlvDocument, *mut RlvDocumentChanges) -> RlvResult);
function!(rlv_document_abandon: unsafe extern "C" fn(RlvDocument) -> RlvResult);
function!(rlv_document_undo: unsafe extern "C" fn(RlvDocument, *mut RlvDocumentChanges) -> RlvResult);
function!(rlv_document_redo: unsafe extern "C" fn(RlvDocument, *mut RlvDocumentChanges) -> RlvResult);
function!(rlv_document_save: unsafe extern "C" fn(RlvDocument, *const c_char) -> RlvResult);
function!(rlv_document_save_stream: unsafe extern "C" fn(RlvDocument, *const RlvStream) -> RlvResult);
function!(rlv_document_save_bytes: unsafe extern "C" fn(RlvDocument, *mut RlvBytes) -> RlvResult);
function!(rlv_document_sync: unsafe extern "C" fn(RlvDocument) -> RlvResult);
function!(rlv_document_compact: unsafe extern "C" fn(RlvContext, *const c_char, usize) -> RlvResult);
function!(rlv_document_mesh: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvMesh) -> RlvResult);
function!(rlv_document_mesh_bytes: unsafe extern "C" fn(RlvContext, *const u8, usize, *mut RlvMesh) -> RlvResult);
function!(rlv_document_transfer: unsafe extern "C" fn(RlvContext, RlvMesh, *const c_char, *const c_char, *const RlvTransferOptions, RlvProgress, *mut c_void, *mut RlvTransferReport) -> RlvResult);
constant!(RLV_LAYER_NAME_SIZE = 256);
constant!(RLV_LAYER_DISPLACEMENT = 0);
constant!(RLV_LAYER_COLOR = 1);
constant!(RLV_BLEND_NORMAL = 0);
constant!(RLV_BLEND_ADD = 1);
constant!(RLV_BLEND_SUBTRACT = 2);
constant!(RLV_BLEND_MULTIPLY = 3);
constant!(RLV_BLEND_SCREEN = 4);
constant!(RLV_BLEND_OVERLAY = 5);
constant!(RLV_BLEND_MAX = 6);
constant!(RLV_BLEND_MIN = 7);
layout!(RlvLayerOptions: 24, 4);
layout!(RlvLayerInfo: 296, 8);
function!(rlv_layer_count: unsafe extern "C" fn(RlvDetail, *mut usize) -> RlvResult);
function!(rlv_layer_info: unsafe extern "C" fn(RlvDetail, usize, *mut RlvLayerInfo) -> RlvResult);
function!(rlv_layer_add: unsafe extern "C" fn(RlvDetail, *const c_char, *const RlvLayerOptions, *mut u32) -> RlvResult);
function!(rlv_layer_set: unsafe extern "C" fn(RlvDetail, u32, *const RlvLayerOptions) -> RlvResult);
function!(rlv_layer_set_active: unsafe extern "C" fn(RlvDetail, u32) -> RlvResult);
function!(rlv_layer_rename: unsafe extern "C" fn(RlvDetail, u32, *const c_char) -> RlvResult);
function!(rlv_layer_place: unsafe extern "C" fn(RlvDetail, u32, usize) -> RlvResult);
function!(rlv_layer_remove: unsafe extern "C" fn(RlvDetail, u32) -> RlvResult);
function!(rlv_layer_merge: unsafe extern "C" fn(RlvDetail, u32) -> RlvResult);
function!(rlv_layer_flatten: unsafe extern "C" fn(RlvDetail) -> RlvResult);
layout!(RlvDecal: 8, 8);
layout!(RlvDecalPin: 48, 8);
layout!(RlvDecalOptions: 88, 8);
layout!(RlvDecalQuality: 80, 8);
layout!(RlvDecalImage: 24, 8);
layout!(RlvDecalInk: 24, 4);
layout!(RlvDecalTexture: 40, 8);
layout!(RlvDecalReport: 32, 8);
layout!(RlvDecalRecipe: 48, 8);
function!(rlv_decal_on_mesh: unsafe extern "C" fn(RlvMesh, *const RlvDecalOptions, *const RlvDecalPin, usize, usize, RlvProgress, *mut c_void, *mut RlvDecal) -> RlvResult);
function!(rlv_decal_on_detail: unsafe extern "C" fn(RlvDetail, *const RlvDecalOptions, *const RlvDecalPin, usize, usize, RlvProgress, *mut c_void, *mut RlvDecal) -> RlvResult);
function!(rlv_decal_retain: unsafe extern "C" fn(RlvDecal) -> RlvResult);
function!(rlv_decal_release: unsafe extern "C" fn(RlvDecal) -> RlvResult);
function!(rlv_decal_quality: unsafe extern "C" fn(RlvDecal, *mut RlvDecalQuality) -> RlvResult);
function!(rlv_decal_mesh: unsafe extern "C" fn(RlvDecal, f64, *mut RlvMesh) -> RlvResult);
function!(rlv_decal_drag_pin: unsafe extern "C" fn(RlvDecal, usize, *const f64) -> RlvResult);
function!(rlv_decal_move_image: unsafe extern "C" fn(RlvDecal, usize, *const f64, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_decal_pose: unsafe extern "C" fn(RlvDecal, *const f32, usize, usize, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_decal_settle: unsafe extern "C" fn(RlvDecal, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_decal_paint: unsafe extern "C" fn(RlvDecal, *const RlvDecalImage, f32, *mut RlvDecalReport) -> RlvResult);
function!(rlv_decal_emboss: unsafe extern "C" fn(RlvDecal, *const RlvDecalImage, f32, *mut RlvDecalReport) -> RlvResult);
function!(rlv_decal_write: unsafe extern "C" fn(RlvDecal, *const RlvDecalImage, *const RlvDecalInk, *mut RlvDecalReport) -> RlvResult);
function!(rlv_decal_paint_texture: unsafe extern "C" fn(RlvDecal, *const RlvDecalImage, f32, *const RlvDecalTexture, *mut usize) -> RlvResult);
function!(rlv_decal_contour: unsafe extern "C" fn(*const RlvDecalImage, u32, u32, f64, f64, *mut f64, usize, *mut usize) -> RlvResult);
function!(rlv_decal_strip_on_mesh: unsafe extern "C" fn(RlvMesh, *const RlvDecalOptions, *const f64, usize, usize, *mut RlvDecalPin, usize, *mut usize, *mut f64) -> RlvResult);
function!(rlv_decal_strip_on_detail: unsafe extern "C" fn(RlvDetail, *const RlvDecalOptions, *const f64, usize, usize, *mut RlvDecalPin, usize, *mut usize, *mut f64) -> RlvResult);
function!(rlv_decal_pins: unsafe extern "C" fn(RlvDecal, *mut RlvDecalPin, usize, *mut usize) -> RlvResult);
function!(rlv_decal_count: unsafe extern "C" fn(RlvDocument, *mut usize) -> RlvResult);
function!(rlv_decal_recipe: unsafe extern "C" fn(RlvDocument, usize, *mut RlvDecalRecipe) -> RlvResult);
function!(rlv_decal_apply: unsafe extern "C" fn(RlvDecal, RlvDocument, *const c_char, *const RlvDecalImage, *const RlvDecalInk, RlvProgress, *mut c_void, *mut u32) -> RlvResult);
function!(rlv_decal_take_up: unsafe extern "C" fn(RlvDocument, u32, RlvProgress, *mut c_void, *mut RlvDecal) -> RlvResult);
function!(rlv_decal_update: unsafe extern "C" fn(RlvDecal, RlvDocument, u32, *const RlvDecalImage, *const RlvDecalInk, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_decal_remove: unsafe extern "C" fn(RlvDocument, u32) -> RlvResult);
layout!(RlvDeviceCrowd: 8, 8);
layout!(RlvDeviceCrowdInfo: 56, 8);
layout!(RlvDeviceCrowdVulkan: 104, 8);
function!(rlv_device_crowd_create: unsafe extern "C" fn(RlvCrowd, *mut RlvDeviceCrowd) -> RlvResult);
function!(rlv_device_crowd_retain: unsafe extern "C" fn(RlvDeviceCrowd) -> RlvResult);
function!(rlv_device_crowd_release: unsafe extern "C" fn(RlvDeviceCrowd) -> RlvResult);
function!(rlv_device_crowd_cut: unsafe extern "C" fn(RlvDeviceCrowd, *const RlvCrowdView, *mut RlvDeviceCrowdInfo) -> RlvResult);
function!(rlv_device_crowd_get: unsafe extern "C" fn(RlvDeviceCrowd, *const RlvCrowdBuffers) -> RlvResult);
function!(rlv_device_crowd_get_impostors: unsafe extern "C" fn(RlvDeviceCrowd, *const RlvCrowdImpostors) -> RlvResult);
function!(rlv_device_crowd_vulkan: unsafe extern "C" fn(RlvDeviceCrowd, *mut RlvDeviceCrowdVulkan) -> RlvResult);
layout!(RlvStroke: 8, 8);
layout!(RlvStrokePoint: 40, 8);
layout!(RlvStrokeReport: 88, 8);
function!(rlv_stroke_run: unsafe extern "C" fn(RlvDetail, RlvBrush, *const RlvStrokePoint, usize, usize, *mut RlvStrokeReport) -> RlvResult);
function!(rlv_stroke_begin: unsafe extern "C" fn(RlvDetail, RlvBrush, *mut RlvStroke) -> RlvResult);
function!(rlv_stroke_retain: unsafe extern "C" fn(RlvStroke) -> RlvResult);
function!(rlv_stroke_release: unsafe extern "C" fn(RlvStroke) -> RlvResult);
function!(rlv_stroke_extend: unsafe extern "C" fn(RlvStroke, *const RlvStrokePoint, usize, usize, *mut RlvStrokeReport) -> RlvResult);
function!(rlv_stroke_end: unsafe extern "C" fn(RlvStroke, *mut RlvStrokeReport) -> RlvResult);
layout!(RlvLevel: 8, 8);
layout!(RlvLevelInfo: 32, 8);
layout!(RlvLevelView: 80, 8);
layout!(RlvLevelRegion: 32, 8);
layout!(RlvLevelHandle: 64, 8);
layout!(RlvLevelEdit: 56, 8);
layout!(RlvLevelKey: 40, 8);
layout!(RlvLevelTrack: 56, 8);
layout!(RlvLevelMotion: 56, 8);
layout!(RlvLevelSculpted: 32, 8);
layout!(RlvLevelBuffers: 128, 8);
layout!(RlvLevelUpdate: 80, 8);
layout!(RlvLevelMisplaced: 20, 4);
function!(rlv_level_create: unsafe extern "C" fn(RlvProgressive, *mut RlvLevel) -> RlvResult);
function!(rlv_level_take_up: unsafe extern "C" fn(RlvLevel, RlvProgressive) -> RlvResult);
function!(rlv_level_retain: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_release: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_info: unsafe extern "C" fn(RlvLevel, *mut RlvLevelInfo) -> RlvResult);
function!(rlv_level_set_error: unsafe extern "C" fn(RlvLevel, f32) -> RlvResult);
function!(rlv_level_set_bound: unsafe extern "C" fn(RlvLevel, f32, RlvProgress, *mut c_void, *mut f32) -> RlvResult);
function!(rlv_level_set_triangles: unsafe extern "C" fn(RlvLevel, usize) -> RlvResult);
function!(rlv_level_set_view: unsafe extern "C" fn(RlvLevel, *const RlvLevelView) -> RlvResult);
function!(rlv_level_edit: unsafe extern "C" fn(RlvLevel, *const RlvLevelEdit, *mut usize) -> RlvResult);
function!(rlv_level_sculpt: unsafe extern "C" fn(RlvLevel, RlvBrush, *const RlvStrokePoint, usize, usize, *mut RlvLevelSculpted) -> RlvResult);
function!(rlv_level_undo: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_redo: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_add_motion: unsafe extern "C" fn(RlvLevel, *const RlvLevelMotion) -> RlvResult);
function!(rlv_level_set_time: unsafe extern "C" fn(RlvLevel, f64, *mut usize) -> RlvResult);
function!(rlv_level_clear_motions: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_open_journal: unsafe extern "C" fn(RlvLevel, *const c_char) -> RlvResult);
function!(rlv_level_sync_journal: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_close_journal: unsafe extern "C" fn(RlvLevel) -> RlvResult);
function!(rlv_level_update: unsafe extern "C" fn(RlvLevel, *const RlvLevelBuffers, *mut RlvLevelUpdate) -> RlvResult);
function!(rlv_level_changed_ranges: unsafe extern "C" fn(RlvLevel, u32, *mut u32, usize, *mut usize) -> RlvResult);
function!(rlv_level_mesh: unsafe extern "C" fn(RlvLevel, *mut RlvMesh) -> RlvResult);
function!(rlv_level_settle: unsafe extern "C" fn(RlvLevel, *mut RlvProgressive) -> RlvResult);
function!(rlv_level_misplaced: unsafe extern "C" fn(RlvLevel, *mut RlvLevelMisplaced, usize, *mut usize) -> RlvResult);
function!(rlv_level_rebuild: unsafe extern "C" fn(RlvLevel, *const RlvProgressiveOptions, RlvProgress, *mut c_void, *mut RlvProgressive) -> RlvResult);
layout!(RlvDeviceLevel: 8, 8);
layout!(RlvDeviceLevelInfo: 40, 8);
layout!(RlvDeviceLevelVulkan: 96, 8);
function!(rlv_device_level_create: unsafe extern "C" fn(RlvProgressive, *mut RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_retain: unsafe extern "C" fn(RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_release: unsafe extern "C" fn(RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_info: unsafe extern "C" fn(RlvDeviceLevel, *mut RlvDeviceLevelInfo) -> RlvResult);
function!(rlv_device_level_set_error: unsafe extern "C" fn(RlvDeviceLevel, f32) -> RlvResult);
function!(rlv_device_level_set_triangles: unsafe extern "C" fn(RlvDeviceLevel, usize) -> RlvResult);
function!(rlv_device_level_set_view: unsafe extern "C" fn(RlvDeviceLevel, *const RlvLevelView) -> RlvResult);
function!(rlv_device_level_edit: unsafe extern "C" fn(RlvDeviceLevel, *const RlvLevelEdit, *mut usize) -> RlvResult);
function!(rlv_device_level_undo: unsafe extern "C" fn(RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_redo: unsafe extern "C" fn(RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_add_motion: unsafe extern "C" fn(RlvDeviceLevel, *const RlvLevelMotion) -> RlvResult);
function!(rlv_device_level_set_time: unsafe extern "C" fn(RlvDeviceLevel, f64, *mut usize) -> RlvResult);
function!(rlv_device_level_clear_motions: unsafe extern "C" fn(RlvDeviceLevel) -> RlvResult);
function!(rlv_device_level_read: unsafe extern "C" fn(RlvDeviceLevel, *const RlvLevelBuffers, *mut RlvLevelUpdate) -> RlvResult);
function!(rlv_device_level_vulkan: unsafe extern "C" fn(RlvDeviceLevel, *mut RlvDeviceLevelVulkan) -> RlvResult);
layout!(RlvDiffuse: 8, 8);
layout!(RlvDiffuseOptions: 72, 8);
layout!(RlvDiffuseSettings: 72, 4);
layout!(RlvDiffuseFluid: 48, 8);
layout!(RlvDiffuseInfo: 32, 8);
layout!(RlvDiffuseReport: 32, 8);
layout!(RlvDiffusePotentials: 40, 8);
layout!(RlvDiffuseArrays: 72, 8);
function!(rlv_diffuse_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_diffuse_create: unsafe extern "C" fn(RlvContext, *const RlvDiffuseOptions, *const RlvDiffuseSettings, *mut RlvDiffuse) -> RlvResult);
function!(rlv_diffuse_retain: unsafe extern "C" fn(RlvDiffuse) -> RlvResult);
function!(rlv_diffuse_release: unsafe extern "C" fn(RlvDiffuse) -> RlvResult);
function!(rlv_diffuse_info: unsafe extern "C" fn(RlvDiffuse, *mut RlvDiffuseInfo) -> RlvResult);
function!(rlv_diffuse_advance: unsafe extern "C" fn(RlvDiffuse, *const RlvDiffuseFluid, f32, *mut RlvDiffuseReport, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_diffuse_potentials: unsafe extern "C" fn(RlvDiffuse, *const RlvDiffuseFluid, *const RlvDiffusePotentials) -> RlvResult);
function!(rlv_diffuse_get: unsafe extern "C" fn(RlvDiffuse, *const RlvDiffuseArrays) -> RlvResult);
function!(rlv_diffuse_particles: unsafe extern "C" fn(RlvDiffuse, f64, *mut RlvParticles) -> RlvResult);
function!(rlv_diffuse_save: unsafe extern "C" fn(RlvDiffuse, *const c_char, f64) -> RlvResult);
function!(rlv_diffuse_restore: unsafe extern "C" fn(RlvDiffuse, *const c_char) -> RlvResult);
layout!(RlvFluid: 8, 8);
constant!(RLV_FLUID_WENDLAND = 0);
constant!(RLV_FLUID_MUELLER = 1);
constant!(RLV_FLUID_PCISPH = 0);
constant!(RLV_FLUID_DFSPH = 1);
constant!(RLV_FLUID_COURANT = 0);
constant!(RLV_FLUID_FIXED = 1);
constant!(RLV_FLUID_SLIP = 0);
constant!(RLV_FLUID_STOP = 1);
constant!(RLV_FLUID_FRICTION = 2);
constant!(RLV_FLUID_WALLS = 4294967295);
constant!(RLV_FLUID_GRAVITY = 0);
constant!(RLV_FLUID_WIND = 1);
constant!(RLV_FLUID_DRAG = 2);
constant!(RLV_FLUID_VORTEX = 3);
constant!(RLV_FLUID_ATTRACTOR = 4);
constant!(RLV_FLUID_TURBULENCE = 5);
constant!(RLV_FLUID_DISC = 0);
constant!(RLV_FLUID_RECTANGLE = 1);
constant!(RLV_FLUID_SURFACE = 2);
layout!(RlvFluidOptions: 76, 4);
layout!(RlvFluidInfo: 56, 8);
layout!(RlvFluidParticles: 88, 8);
layout!(RlvFluidArrays: 112, 8);
layout!(RlvFluidColliderOptions: 16, 4);
layout!(RlvFluidForce: 56, 8);
layout!(RlvFluidEmitterOptions: 112, 8);
layout!(RlvFluidReport: 160, 8);
function!(rlv_fluid_create: unsafe extern "C" fn(RlvContext, *const RlvFluidOptions, *mut RlvFluid) -> RlvResult);
function!(rlv_fluid_retain: unsafe extern "C" fn(RlvFluid) -> RlvResult);
function!(rlv_fluid_release: unsafe extern "C" fn(RlvFluid) -> RlvResult);
function!(rlv_fluid_info: unsafe extern "C" fn(RlvFluid, *mut RlvFluidInfo) -> RlvResult);
function!(rlv_fluid_add: unsafe extern "C" fn(RlvFluid, *const RlvFluidParticles) -> RlvResult);
function!(rlv_fluid_add_box: unsafe extern "C" fn(RlvFluid, *const f64, *const f64, *const f32) -> RlvResult);
function!(rlv_fluid_fill: unsafe extern "C" fn(RlvFluid, RlvMesh, *const f64, *const f32, *mut usize) -> RlvResult);
function!(rlv_fluid_add_emitter: unsafe extern "C" fn(RlvFluid, RlvMesh, *const f64, *const RlvFluidEmitterOptions) -> RlvResult);
function!(rlv_fluid_add_sink: unsafe extern "C" fn(RlvFluid, *const f64, *const f64, u32) -> RlvResult);
function!(rlv_fluid_add_sink_mesh: unsafe extern "C" fn(RlvFluid, RlvMesh, *const f64) -> RlvResult);
function!(rlv_fluid_clear_sources: unsafe extern "C" fn(RlvFluid) -> RlvResult);
function!(rlv_fluid_set_budget: unsafe extern "C" fn(RlvFluid, usize, u32) -> RlvResult);
function!(rlv_fluid_set_forces: unsafe extern "C" fn(RlvFluid, *const RlvFluidForce, usize, usize) -> RlvResult);
function!(rlv_fluid_remove: unsafe extern "C" fn(RlvFluid, *const u32, usize, usize, *mut usize) -> RlvResult);
function!(rlv_fluid_set_walls: unsafe extern "C" fn(RlvFluid, *const f32, usize, usize) -> RlvResult);
function!(rlv_fluid_set_basin: unsafe extern "C" fn(RlvFluid, *const f64, *const f64) -> RlvResult);
function!(rlv_fluid_set_wall_points: unsafe extern "C" fn(RlvFluid, *const f32, usize, usize, *const f32, usize) -> RlvResult);
function!(rlv_fluid_add_collider: unsafe extern "C" fn(RlvFluid, RlvMesh, *const f64, *const RlvFluidColliderOptions, *mut u32) -> RlvResult);
function!(rlv_fluid_move_collider: unsafe extern "C" fn(RlvFluid, u32, *const f32, *const f32, usize, usize, f32) -> RlvResult);
function!(rlv_fluid_impulse: unsafe extern "C" fn(RlvFluid, u32, *mut f64, *mut f64) -> RlvResult);
function!(rlv_fluid_accelerate: unsafe extern "C" fn(RlvFluid, *const f32, usize, usize) -> RlvResult);
function!(rlv_fluid_step: unsafe extern "C" fn(RlvFluid, f32, *mut RlvFluidReport) -> RlvResult);
function!(rlv_fluid_advance: unsafe extern "C" fn(RlvFluid, f64, RlvProgress, *mut c_void, *mut RlvFluidReport) -> RlvResult);
function!(rlv_fluid_get: unsafe extern "C" fn(RlvFluid, *const RlvFluidArrays) -> RlvResult);
function!(rlv_fluid_set_channel: unsafe extern "C" fn(RlvFluid, *const RlvAttributeArrays) -> RlvResult);
function!(rlv_fluid_find_channel: unsafe extern "C" fn(RlvFluid, *const c_char, *mut u32) -> RlvResult);
function!(rlv_fluid_channel_info: unsafe extern "C" fn(RlvFluid, u32, *mut RlvAttributeInfo) -> RlvResult);
function!(rlv_fluid_get_channel: unsafe extern "C" fn(RlvFluid, u32, *mut f32, usize, usize) -> RlvResult);
function!(rlv_fluid_save: unsafe extern "C" fn(RlvFluid, *const c_char) -> RlvResult);
function!(rlv_fluid_restore: unsafe extern "C" fn(RlvFluid, *const c_char) -> RlvResult);
function!(rlv_fluid_save_bytes: unsafe extern "C" fn(RlvFluid, *mut RlvBytes) -> RlvResult);
function!(rlv_fluid_restore_bytes: unsafe extern "C" fn(RlvFluid, *const u8, usize) -> RlvResult);
function!(rlv_fluid_particles: unsafe extern "C" fn(RlvFluid, *mut RlvParticles) -> RlvResult);
function!(rlv_fluid_add_particles: unsafe extern "C" fn(RlvFluid, RlvParticles) -> RlvResult);
function!(rlv_fluid_isosurface: unsafe extern "C" fn(RlvFluid, *const RlvIsosurfaceOptions, *mut RlvIsosurface) -> RlvResult);
layout!(RlvFoam: 8, 8);
constant!(RLV_FOAM_SPRAY = 0);
constant!(RLV_FOAM_FLOAT = 1);
constant!(RLV_FOAM_BUBBLE = 2);
layout!(RlvFoamSettings: 156, 4);
layout!(RlvFoamView: 120, 8);
layout!(RlvFoamParticles: 96, 8);
layout!(RlvFoamLight: 32, 8);
layout!(RlvFoamLayers: 56, 8);
function!(rlv_foam_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_foam_create: unsafe extern "C" fn(RlvContext, *const RlvFoamView, *const RlvFoamSettings, *mut RlvFoam) -> RlvResult);
function!(rlv_foam_retain: unsafe extern "C" fn(RlvFoam) -> RlvResult);
function!(rlv_foam_release: unsafe extern "C" fn(RlvFoam) -> RlvResult);
function!(rlv_foam_add: unsafe extern "C" fn(RlvFoam, *const RlvFoamParticles) -> RlvResult);
function!(rlv_foam_shade: unsafe extern "C" fn(RlvFoam, *const RlvFoamLight, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_foam_get: unsafe extern "C" fn(RlvFoam, *const RlvFoamLayers) -> RlvResult);
function!(rlv_foam_composite: unsafe extern "C" fn(RlvFoam, *const f32, u32, *mut f32) -> RlvResult);
layout!(RlvGrid: 8, 8);
constant!(RLV_GRID_FLOAT = 0);
constant!(RLV_GRID_DOUBLE = 1);
constant!(RLV_GRID_BOOL = 2);
constant!(RLV_GRID_MASK = 3);
constant!(RLV_GRID_INT32 = 4);
constant!(RLV_GRID_INT64 = 5);
constant!(RLV_GRID_VEC3S = 6);
constant!(RLV_GRID_VEC3D = 7);
constant!(RLV_GRID_VEC3I = 8);
constant!(RLV_GRID_POINTS = 9);
constant!(RLV_GRID_OTHER = 10);
constant!(RLV_GRID_UNKNOWN = 0);
constant!(RLV_GRID_LEVEL_SET = 1);
constant!(RLV_GRID_FOG = 2);
constant!(RLV_GRID_STAGGERED = 3);
constant!(RLV_GRID_PACK_BLOSC = 0);
constant!(RLV_GRID_PACK_ZIP = 1);
constant!(RLV_GRID_PACK_NONE = 2);
constant!(RLV_GRID_HALF = 4);
constant!(RLV_GRID_STREAM = 8);
constant!(RLV_GRID_UNION = 0);
constant!(RLV_GRID_INTERSECTION = 1);
constant!(RLV_GRID_DIFFERENCE = 2);
constant!(RLV_GRID_OFFSET = 0);
constant!(RLV_GRID_MEAN = 1);
constant!(RLV_GRID_GAUSSIAN = 2);
constant!(RLV_GRID_MEDIAN = 3);
constant!(RLV_GRID_LAPLACIAN = 4);
constant!(RLV_GRID_MEAN_CURVATURE = 5);
constant!(RLV_GRID_RESAMPLE = 6);
constant!(RLV_GRID_TO_FOG = 7);
constant!(RLV_GRID_TO_LEVEL_SET = 8);
layout!(RlvGridSettings: 36, 4);
layout!(RlvGridInfo: 448, 8);
function!(rlv_grid_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_grid_available: unsafe extern "C" fn() -> RlvResult);
function!(rlv_grid_file_count: unsafe extern "C" fn(RlvContext, *const c_char, *mut usize) -> RlvResult);
function!(rlv_grid_file_info: unsafe extern "C" fn(RlvContext, *const c_char, usize, *mut RlvGridInfo) -> RlvResult);
function!(rlv_grid_file_metadata: unsafe extern "C" fn(RlvContext, *const c_char, *const c_char, *mut c_char, usize) -> RlvResult);
function!(rlv_grid_create: unsafe extern "C" fn(RlvContext, u32, *const f64, f64, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_read: unsafe extern "C" fn(RlvContext, *const c_char, *const c_char, *const f64, RlvProgress, *mut c_void, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_write: unsafe extern "C" fn(*const RlvGrid, usize, *const c_char, u32) -> RlvResult);
function!(rlv_grid_retain: unsafe extern "C" fn(RlvGrid) -> RlvResult);
function!(rlv_grid_release: unsafe extern "C" fn(RlvGrid) -> RlvResult);
function!(rlv_grid_info: unsafe extern "C" fn(RlvGrid, *mut RlvGridInfo) -> RlvResult);
function!(rlv_grid_set_name: unsafe extern "C" fn(RlvGrid, *const c_char) -> RlvResult);
function!(rlv_grid_set_class: unsafe extern "C" fn(RlvGrid, u32) -> RlvResult);
function!(rlv_grid_set_matrix: unsafe extern "C" fn(RlvGrid, *const f64) -> RlvResult);
function!(rlv_grid_set_frustum: unsafe extern "C" fn(RlvGrid, *const f64, f64, f64, *const f64) -> RlvResult);
function!(rlv_grid_metadata_count: unsafe extern "C" fn(RlvGrid, *mut usize) -> RlvResult);
function!(rlv_grid_metadata_entry: unsafe extern "C" fn(RlvGrid, usize, *mut c_char, usize, *mut c_char, usize) -> RlvResult);
function!(rlv_grid_metadata: unsafe extern "C" fn(RlvGrid, *const c_char, *mut c_char, usize) -> RlvResult);
function!(rlv_grid_set_metadata: unsafe extern "C" fn(RlvGrid, *const c_char, *const c_char, *const c_char) -> RlvResult);
function!(rlv_grid_sample: unsafe extern "C" fn(RlvGrid, *const f64, usize, usize, u32, *mut f64, usize) -> RlvResult);
function!(rlv_grid_get_block: unsafe extern "C" fn(RlvGrid, *const i32, *const u32, *mut c_void, usize) -> RlvResult);
function!(rlv_grid_set_block: unsafe extern "C" fn(RlvGrid, *const i32, *const u32, *const c_void, usize, f64) -> RlvResult);
function!(rlv_grid_from_mesh: unsafe extern "C" fn(RlvMesh, *const RlvGridSettings, RlvProgress, *mut c_void, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_from_particles: unsafe extern "C" fn(RlvParticles, *const RlvGridSettings, RlvProgress, *mut c_void, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_mesh: unsafe extern "C" fn(RlvGrid, *const RlvGridSettings, RlvProgress, *mut c_void, *mut RlvMesh) -> RlvResult);
function!(rlv_grid_change: unsafe extern "C" fn(RlvGrid, u32, *const RlvGridSettings, RlvProgress, *mut c_void, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_convert: unsafe extern "C" fn(RlvGrid, u32, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_combine: unsafe extern "C" fn(RlvGrid, RlvGrid, u32, RlvProgress, *mut c_void, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_labels: unsafe extern "C" fn(*const RlvGrid, *const i32, usize, *mut RlvGrid) -> RlvResult);
function!(rlv_grid_label_mask: unsafe extern "C" fn(RlvGrid, i64, *mut RlvGrid) -> RlvResult);
layout!(RlvImprintSettings: 60, 4);
layout!(RlvImprintMoment: 24, 8);
layout!(RlvImprintReport: 128, 8);
function!(rlv_imprint_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_imprint_run: unsafe extern "C" fn(RlvDetail, RlvCollider, *const RlvImprintSettings, *const RlvImprintMoment, *mut RlvImprintReport) -> RlvResult);
function!(rlv_imprint_sweep: unsafe extern "C" fn(RlvDetail, RlvCollider, *const f64, *const f64, *const RlvImprintSettings, *const RlvImprintMoment, RlvProgress, *mut c_void, *mut RlvImprintReport) -> RlvResult);
function!(rlv_imprint_sweep_points: unsafe extern "C" fn(RlvDetail, RlvCollider, *const f64, *const f64, *const f32, *const f32, usize, usize, *const RlvImprintSettings, *const RlvImprintMoment, RlvProgress, *mut c_void, *mut RlvImprintReport) -> RlvResult);
function!(rlv_imprint_collide: unsafe extern "C" fn(RlvDetail, RlvDetail, *const RlvImprintSettings, *const RlvImprintSettings, *const RlvImprintMoment, *mut RlvImprintReport, *mut RlvImprintReport) -> RlvResult);
constant!(RLV_PICTURE_NAME_SIZE = 264);
constant!(RLV_PICTURE_NONE = 4294967295);
layout!(RlvPicture: 8, 8);
constant!(RLV_PICTURE_DOCUMENT = 0);
constant!(RLV_PICTURE_PTEX = 1);
constant!(RLV_PICTURE_U8 = 0);
constant!(RLV_PICTURE_U16 = 1);
constant!(RLV_PICTURE_F16 = 2);
constant!(RLV_PICTURE_F32 = 3);
constant!(RLV_PICTURE_I32 = 4);
constant!(RLV_PICTURE_F64 = 5);
constant!(RLV_PICTURE_TEXT = 6);
constant!(RLV_PICTURE_COLOR = 0);
constant!(RLV_PICTURE_DISPLACEMENT = 1);
constant!(RLV_PICTURE_VECTORS = 2);
constant!(RLV_PICTURE_TRACES = 3);
constant!(RLV_PICTURE_NUMBERS = 4);
layout!(RlvPictureInfo: 24, 4);
layout!(RlvPictureImage: 336, 4);
layout!(RlvPictureMeta: 32, 8);
function!(rlv_picture_open: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvPicture) -> RlvResult);
function!(rlv_picture_retain: unsafe extern "C" fn(RlvPicture) -> RlvResult);
function!(rlv_picture_release: unsafe extern "C" fn(RlvPicture) -> RlvResult);
function!(rlv_picture_info: unsafe extern "C" fn(RlvPicture, *mut RlvPictureInfo) -> RlvResult);
function!(rlv_picture_image: unsafe extern "C" fn(RlvPicture, u32, *mut RlvPictureImage) -> RlvResult);
function!(rlv_picture_meta: unsafe extern "C" fn(RlvPicture, u32, *mut RlvPictureMeta) -> RlvResult);
function!(rlv_picture_read: unsafe extern "C" fn(RlvPicture, u32, u32, u32, u32, u32, u32, *mut c_void, usize) -> RlvResult);
layout!(RlvProcedural: 8, 8);
layout!(RlvProceduralOptions: 16, 4);
layout!(RlvProceduralInfo: 56, 8);
alias!(RlvProceduralBounds = Option<unsafe extern "C" fn(*const c_void, u32, u32, *mut f32)>);
alias!(RlvProceduralIntersect = Option<unsafe extern "C" fn(*const c_void, *const i32, u32, u32, u32, *mut c_void, u32)>);
alias!(RlvProceduralOccluded = Option<unsafe extern "C" fn(*const c_void, *const i32, u32, *mut c_void, u32)>);
layout!(RlvProceduralTable: 56, 8);
layout!(RlvProceduralHits: 128, 8);
function!(rlv_procedural_create: unsafe extern "C" fn(RlvDetail, *const RlvProceduralOptions, *mut RlvProcedural) -> RlvResult);
function!(rlv_procedural_create_moving: unsafe extern "C" fn(RlvProcedural, RlvDetail, *mut RlvProcedural) -> RlvResult);
function!(rlv_procedural_retain: unsafe extern "C" fn(RlvProcedural) -> RlvResult);
function!(rlv_procedural_release: unsafe extern "C" fn(RlvProcedural) -> RlvResult);
function!(rlv_procedural_info: unsafe extern "C" fn(RlvProcedural, *mut RlvProceduralInfo) -> RlvResult);
function!(rlv_procedural_table: unsafe extern "C" fn(RlvProcedural, *mut RlvProceduralTable) -> RlvResult);
function!(rlv_procedural_evaluate: unsafe extern "C" fn(RlvProcedural, *const RlvProceduralHits) -> RlvResult);
constant!(RLV_PTEX_STATED = 0);
constant!(RLV_PTEX_DISPLACEMENT = 1);
constant!(RLV_PTEX_COLOR = 2);
constant!(RLV_PTEX_VECTORS = 3);
layout!(RlvPtexOptions: 16, 8);
layout!(RlvPtexReport: 64, 8);
function!(rlv_ptex_write: unsafe extern "C" fn(RlvDetail, u32, *const c_char, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_ptex_read: unsafe extern "C" fn(RlvDetail, *const c_char, *const RlvPtexOptions, RlvProgress, *mut c_void, *mut RlvPtexReport) -> RlvResult);
layout!(RlvRepairSettings: 56, 4);
layout!(RlvRepairFinding: 72, 8);
layout!(RlvRepairTopology: 88, 8);
layout!(RlvRepairReport: 1168, 8);
function!(rlv_repair_params: unsafe extern "C" fn(*mut *const RlvParameter, *mut usize) -> RlvResult);
function!(rlv_repair_check: unsafe extern "C" fn(RlvMesh, *const RlvRepairSettings, RlvProgress, *mut c_void, *mut RlvRepairReport) -> RlvResult);
function!(rlv_repair_mesh: unsafe extern "C" fn(RlvMesh, *const RlvRepairSettings, RlvProgress, *mut c_void, *mut RlvRepairReport, *mut RlvMesh) -> RlvResult);
function!(rlv_repair_arrays: unsafe extern "C" fn(RlvContext, *const RlvMeshArrays, *const RlvAttributeArrays, usize, *const RlvRepairSettings, RlvProgress, *mut c_void, *mut RlvRepairReport, *mut RlvMesh) -> RlvResult);
function!(rlv_repair_read: unsafe extern "C" fn(RlvContext, *const c_char, *const RlvRepairSettings, RlvProgress, *mut c_void, *mut RlvRepairReport, *mut RlvMesh) -> RlvResult);
layout!(RlvTissue: 8, 8);
layout!(RlvTissueSimulation: 8, 8);
constant!(RLV_TISSUE_HOLD = 0);
constant!(RLV_TISSUE_SLIDE = 1);
constant!(RLV_TISSUE_BIND = 2);
constant!(RLV_TISSUE_FLOOR = 0);
constant!(RLV_TISSUE_BALL = 1);
constant!(RLV_TISSUE_MESH = 2);
layout!(RlvTissueMaterial: 32, 8);
layout!(RlvTissueVolume: 88, 8);
layout!(RlvTissueLayer: 16, 4);
layout!(RlvTissueSurface: 32, 8);
layout!(RlvTissueDescription: 152, 8);
layout!(RlvTissueLabel: 16, 4);
layout!(RlvTissueLabels: 64, 8);
layout!(RlvTissueReport: 24, 8);
layout!(RlvTissueInfo: 80, 8);
layout!(RlvTissueMuscle: 64, 4);
layout!(RlvTissueSet: 64, 8);
layout!(RlvTissueOptions: 44, 4);
layout!(RlvTissueSimulationInfo: 48, 8);
layout!(RlvTissueEnergies: 32, 8);
layout!(RlvTissueRelaxation: 24, 8);
layout!(RlvTissueCollider: 56, 8);
layout!(RlvTissueArrays: 104, 8);
function!(rlv_tissue_build: unsafe extern "C" fn(RlvContext, *const RlvTissueDescription, RlvProgress, *mut c_void, *mut RlvTissueReport, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_block: unsafe extern "C" fn(RlvContext, *const f64, *const f32, *const u32, *const RlvTissueMaterial, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_scan: unsafe extern "C" fn(RlvContext, *const c_char, *const RlvTissueLabels, *mut RlvTissueReport, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_from_grid: unsafe extern "C" fn(RlvGrid, *const RlvTissueLabels, *mut RlvTissueReport, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_write: unsafe extern "C" fn(RlvTissue, *const c_char) -> RlvResult);
function!(rlv_tissue_read_bytes: unsafe extern "C" fn(RlvContext, *const u8, usize, *mut RlvTissue) -> RlvResult);
function!(rlv_tissue_write_bytes: unsafe extern "C" fn(RlvTissue, *mut RlvBytes) -> RlvResult);
function!(rlv_tissue_retain: unsafe extern "C" fn(RlvTissue) -> RlvResult);
function!(rlv_tissue_release: unsafe extern "C" fn(RlvTissue) -> RlvResult);
function!(rlv_tissue_info: unsafe extern "C" fn(RlvTissue, *mut RlvTissueInfo) -> RlvResult);
function!(rlv_tissue_get_nodes: unsafe extern "C" fn(RlvTissue, *mut f32, usize, usize) -> RlvResult);
function!(rlv_tissue_get_elements: unsafe extern "C" fn(RlvTissue, *mut u32, *mut u32, usize) -> RlvResult);
function!(rlv_tissue_find_muscle: unsafe extern "C" fn(RlvTissue, *const c_char, *mut u32) -> RlvResult);
function!(rlv_tissue_muscle: unsafe extern "C" fn(RlvTissue, u32, *mut RlvTissueMuscle) -> RlvResult);
function!(rlv_tissue_find_set: unsafe extern "C" fn(RlvTissue, *const c_char, *mut u32) -> RlvResult);
function!(rlv_tissue_set: unsafe extern "C" fn(RlvTissue, u32, *mut RlvTissueSet) -> RlvResult);
function!(rlv_tissue_get_set: unsafe extern "C" fn(RlvTissue, u32, *mut u32, usize) -> RlvResult);
function!(rlv_tissue_add_set: unsafe extern "C" fn(RlvTissue, *const c_char, *const f64, *const f64, *mut u32) -> RlvResult);
function!(rlv_tissue_hold: unsafe extern "C" fn(RlvTissue, *const u32, usize, usize, u32) -> RlvResult);
function!(rlv_tissue_bind: unsafe extern "C" fn(RlvTissue, RlvMesh, *const c_char, *mut u32) -> RlvResult);
function!(rlv_tissue_simulate: unsafe extern "C" fn(RlvTissue, *const RlvTissueOptions, *mut RlvTissueSimulation) -> RlvResult);
function!(rlv_tissue_simulation_retain: unsafe extern "C" fn(RlvTissueSimulation) -> RlvResult);
function!(rlv_tissue_simulation_release: unsafe extern "C" fn(RlvTissueSimulation) -> RlvResult);
function!(rlv_tissue_simulation_info: unsafe extern "C" fn(RlvTissueSimulation, *mut RlvTissueSimulationInfo) -> RlvResult);
function!(rlv_tissue_simulation_energies: unsafe extern "C" fn(RlvTissueSimulation, *mut RlvTissueEnergies) -> RlvResult);
function!(rlv_tissue_simulation_activate: unsafe extern "C" fn(RlvTissueSimulation, u32, *const f64, *const f32, usize) -> RlvResult);
function!(rlv_tissue_simulation_drive: unsafe extern "C" fn(RlvTissueSimulation, *const u32, usize, u32, *const f64, *const f32, usize) -> RlvResult);
function!(rlv_tissue_simulation_load: unsafe extern "C" fn(RlvTissueSimulation, *const f32, usize, usize) -> RlvResult);
function!(rlv_tissue_simulation_press: unsafe extern "C" fn(RlvTissueSimulation, *const u32, usize, *const f64, *const f32, usize) -> RlvResult);
function!(rlv_tissue_simulation_add_collider: unsafe extern "C" fn(RlvTissueSimulation, *const RlvTissueCollider) -> RlvResult);
function!(rlv_tissue_simulation_step: unsafe extern "C" fn(RlvTissueSimulation, u64) -> RlvResult);
function!(rlv_tissue_simulation_advance: unsafe extern "C" fn(RlvTissueSimulation, f64, RlvProgress, *mut c_void) -> RlvResult);
function!(rlv_tissue_simulation_relax: unsafe extern "C" fn(RlvTissueSimulation, f32, u64, RlvProgress, *mut c_void, *mut RlvTissueRelaxation) -> RlvResult);
function!(rlv_tissue_simulation_get: unsafe extern "C" fn(RlvTissueSimulation, *const RlvTissueArrays) -> RlvResult);
function!(rlv_tissue_simulation_get_bound: unsafe extern "C" fn(RlvTissueSimulation, u32, *mut f32, usize, usize) -> RlvResult);
function!(rlv_tissue_simulation_mesh: unsafe extern "C" fn(RlvTissueSimulation, u32, *mut RlvMesh) -> RlvResult);
function!(rlv_tissue_simulation_save: unsafe extern "C" fn(RlvTissueSimulation, *const c_char) -> RlvResult);
function!(rlv_tissue_simulation_restore: unsafe extern "C" fn(RlvTissueSimulation, *const c_char) -> RlvResult);
function!(rlv_tissue_simulation_save_bytes: unsafe extern "C" fn(RlvTissueSimulation, *mut RlvBytes) -> RlvResult);
function!(rlv_tissue_simulation_restore_bytes: unsafe extern "C" fn(RlvTissueSimulation, *const u8, usize) -> RlvResult);
function!(rlv_tissue_simulation_write_vtu: unsafe extern "C" fn(RlvTissueSimulation, *const c_char) -> RlvResult);
function!(rlv_tissue_simulation_write_vdb: unsafe extern "C" fn(RlvTissueSimulation, *const c_char) -> RlvResult);
layout!(RlvJob: 8, 8);
constant!(RLV_JOB_RUNNING = 0);
constant!(RLV_JOB_DONE = 1);
constant!(RLV_JOB_FAILED = 2);
constant!(RLV_JOB_CANCELLED = 3);
constant!(RLV_JOB_KIND_NONE = 0);
constant!(RLV_JOB_KIND_MESH = 1);
constant!(RLV_JOB_KIND_PROGRESSIVE = 2);
constant!(RLV_JOB_KIND_GRID = 3);
constant!(RLV_JOB_KIND_DECAL = 4);
constant!(RLV_JOB_KIND_CROWD_MODEL = 5);
constant!(RLV_JOB_KIND_TISSUE = 6);
constant!(RLV_JOB_KIND_PARTICLES = 7);
constant!(RLV_JOB_KIND_SURFACE = 8);
constant!(RLV_JOB_KIND_CASTER = 9);
constant!(RLV_JOB_KIND_PROCEDURAL = 10);
constant!(RLV_JOB_KIND_COLLIDER = 11);
constant!(RLV_JOB_KIND_PICTURE = 12);
constant!(RLV_JOB_KIND_DOCUMENT = 13);
constant!(RLV_JOB_KIND_IMPRINT_REPORT = 14);
constant!(RLV_JOB_KIND_BAKE_REPORT = 15);
constant!(RLV_JOB_KIND_PTEX_REPORT = 16);
constant!(RLV_JOB_KIND_TRANSFER_REPORT = 17);
constant!(RLV_JOB_KIND_FLUID_REPORT = 18);
constant!(RLV_JOB_KIND_CLIENT_STATUS = 19);
constant!(RLV_JOB_KIND_BYTES = 20);
layout!(RlvJobInfo: 68, 4);
function!(rlv_job_tessellate: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_sweep: unsafe extern "C" fn(RlvDetail, RlvCollider, *const f64, *const f64, *const RlvImprintSettings, *const RlvImprintMoment, *mut RlvJob) -> RlvResult);
function!(rlv_job_sweep_points: unsafe extern "C" fn(RlvDetail, RlvCollider, *const f64, *const f64, *const f32, *const f32, usize, usize, *const RlvImprintSettings, *const RlvImprintMoment, *mut RlvJob) -> RlvResult);
function!(rlv_job_bake: unsafe extern "C" fn(RlvDetail, *const RlvBakeOptions, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_ptex_write: unsafe extern "C" fn(RlvDetail, u32, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_ptex_read: unsafe extern "C" fn(RlvDetail, *const c_char, *const RlvPtexOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_transfer: unsafe extern "C" fn(RlvContext, RlvMesh, *const c_char, *const c_char, *const RlvTransferOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_progressive: unsafe extern "C" fn(RlvMesh, *const RlvProgressiveOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_simplify: unsafe extern "C" fn(RlvMesh, *const RlvSimplifyOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_repair: unsafe extern "C" fn(RlvMesh, *const RlvRepairSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_isosurface: unsafe extern "C" fn(RlvIsosurface, *const RlvIsosurfaceMeshOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_grid_read: unsafe extern "C" fn(RlvContext, *const c_char, *const c_char, *const f64, *mut RlvJob) -> RlvResult);
function!(rlv_job_grid_from_mesh: unsafe extern "C" fn(RlvMesh, *const RlvGridSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_grid_change: unsafe extern "C" fn(RlvGrid, u32, *const RlvGridSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_grid_mesh: unsafe extern "C" fn(RlvGrid, *const RlvGridSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_decal_on_mesh: unsafe extern "C" fn(RlvMesh, *const RlvDecalOptions, *const RlvDecalPin, usize, usize, *mut RlvJob) -> RlvResult);
function!(rlv_job_decal_on_detail: unsafe extern "C" fn(RlvDetail, *const RlvDecalOptions, *const RlvDecalPin, usize, usize, *mut RlvJob) -> RlvResult);
function!(rlv_job_crowd: unsafe extern "C" fn(RlvContext, *const c_char, *const RlvCrowdClipName, usize, *const RlvCrowdBuildSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_crowd_refit: unsafe extern "C" fn(RlvCrowdModel, *const c_char, *const RlvCrowdClipName, usize, *const RlvCrowdBuildSettings, *mut RlvJob) -> RlvResult);
function!(rlv_job_crowd_model_with_blend: unsafe extern "C" fn(RlvCrowdModel, u32, *mut RlvJob) -> RlvResult);
function!(rlv_job_fluid: unsafe extern "C" fn(RlvFluid, f64, *mut RlvJob) -> RlvResult);
function!(rlv_job_tissue_build: unsafe extern "C" fn(RlvContext, *const RlvTissueDescription, *mut RlvJob) -> RlvResult);
function!(rlv_job_tissue_advance: unsafe extern "C" fn(RlvTissueSimulation, f64, *mut RlvJob) -> RlvResult);
function!(rlv_job_client_submit: unsafe extern "C" fn(RlvClient, *const RlvClientScene, *mut RlvJob) -> RlvResult);
function!(rlv_job_client_fetch: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const RlvClientFetch, *mut RlvJob) -> RlvResult);
function!(rlv_job_client_fetch_mesh: unsafe extern "C" fn(RlvClient, *const c_char, u64, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_surface_create: unsafe extern "C" fn(RlvContext, RlvMesh, *const RlvSurfaceOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_caster_create_mesh: unsafe extern "C" fn(RlvContext, RlvMesh, *mut RlvJob) -> RlvResult);
function!(rlv_job_caster_create_detail: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_caster_create_tessellation: unsafe extern "C" fn(RlvTessellation, *mut RlvJob) -> RlvResult);
function!(rlv_job_procedural_create: unsafe extern "C" fn(RlvDetail, *const RlvProceduralOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_procedural_create_moving: unsafe extern "C" fn(RlvProcedural, RlvDetail, *mut RlvJob) -> RlvResult);
function!(rlv_job_collider_create_mesh: unsafe extern "C" fn(RlvContext, RlvMesh, *const f64, *mut RlvJob) -> RlvResult);
function!(rlv_job_collider_create_surface: unsafe extern "C" fn(RlvSurface, *const RlvTessellateOptions, *const f64, *mut RlvJob) -> RlvResult);
function!(rlv_job_collider_create_detail: unsafe extern "C" fn(RlvDetail, *const RlvTessellateOptions, *mut RlvJob) -> RlvResult);
function!(rlv_job_mesh_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_mesh_write: unsafe extern "C" fn(RlvMesh, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_particles_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_particles_write: unsafe extern "C" fn(RlvParticles, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_progressive_read: unsafe extern "C" fn(RlvContext, *const c_char, usize, *mut RlvJob) -> RlvResult);
function!(rlv_job_progressive_write: unsafe extern "C" fn(RlvProgressive, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_crowd_model_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_crowd_model_write: unsafe extern "C" fn(RlvCrowdModel, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_tissue_read: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_tissue_write: unsafe extern "C" fn(RlvTissue, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_grid_write: unsafe extern "C" fn(*const RlvGrid, usize, *const c_char, u32, *mut RlvJob) -> RlvResult);
function!(rlv_job_picture_open: unsafe extern "C" fn(RlvContext, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_create: unsafe extern "C" fn(RlvDetail, *const c_char, u64, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_open: unsafe extern "C" fn(RlvDetail, *const c_char, u64, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_save: unsafe extern "C" fn(RlvDocument, *const c_char, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_open_bytes: unsafe extern "C" fn(RlvDetail, *const u8, usize, u64, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_save_bytes: unsafe extern "C" fn(RlvDocument, *mut RlvJob) -> RlvResult);
function!(rlv_job_document_compact: unsafe extern "C" fn(RlvContext, *const c_char, usize, *mut RlvJob) -> RlvResult);
function!(rlv_job_retain: unsafe extern "C" fn(RlvJob) -> RlvResult);
function!(rlv_job_release: unsafe extern "C" fn(RlvJob) -> RlvResult);
function!(rlv_job_poll: unsafe extern "C" fn(RlvJob, *mut RlvJobInfo) -> RlvResult);
function!(rlv_job_wait: unsafe extern "C" fn(RlvJob, f64, *mut RlvJobInfo) -> RlvResult);
alias!(RlvJobDone = Option<unsafe extern "C" fn(*mut c_void)>);
function!(rlv_job_notify: unsafe extern "C" fn(RlvJob, RlvJobDone, *mut c_void) -> RlvResult);
function!(rlv_job_cancel: unsafe extern "C" fn(RlvJob) -> RlvResult);
function!(rlv_job_result: unsafe extern "C" fn(RlvJob) -> RlvResult);
function!(rlv_job_mesh: unsafe extern "C" fn(RlvJob, *mut RlvMesh) -> RlvResult);
function!(rlv_job_simplify_error: unsafe extern "C" fn(RlvJob, *mut f32) -> RlvResult);
function!(rlv_job_repair_report: unsafe extern "C" fn(RlvJob, *mut RlvRepairReport) -> RlvResult);
function!(rlv_job_progressive_mesh: unsafe extern "C" fn(RlvJob, *mut RlvProgressive) -> RlvResult);
function!(rlv_job_grid: unsafe extern "C" fn(RlvJob, *mut RlvGrid) -> RlvResult);
function!(rlv_job_decal: unsafe extern "C" fn(RlvJob, *mut RlvDecal) -> RlvResult);
function!(rlv_job_tissue: unsafe extern "C" fn(RlvJob, *mut RlvTissue) -> RlvResult);
function!(rlv_job_tissue_report: unsafe extern "C" fn(RlvJob, *mut RlvTissueReport) -> RlvResult);
function!(rlv_job_particles: unsafe extern "C" fn(RlvJob, *mut RlvParticles) -> RlvResult);
function!(rlv_job_client_status: unsafe extern "C" fn(RlvJob, *mut RlvClientStatus) -> RlvResult);
function!(rlv_job_surface: unsafe extern "C" fn(RlvJob, *mut RlvSurface) -> RlvResult);
function!(rlv_job_caster: unsafe extern "C" fn(RlvJob, *mut RlvCaster) -> RlvResult);
function!(rlv_job_procedural: unsafe extern "C" fn(RlvJob, *mut RlvProcedural) -> RlvResult);
function!(rlv_job_collider: unsafe extern "C" fn(RlvJob, *mut RlvCollider) -> RlvResult);
function!(rlv_job_picture: unsafe extern "C" fn(RlvJob, *mut RlvPicture) -> RlvResult);
function!(rlv_job_document: unsafe extern "C" fn(RlvJob, *mut RlvDocument) -> RlvResult);
function!(rlv_job_bytes: unsafe extern "C" fn(RlvJob, *mut RlvBytes) -> RlvResult);
function!(rlv_job_crowd_model: unsafe extern "C" fn(RlvJob, *mut RlvCrowdModel) -> RlvResult);
function!(rlv_job_crowd_refit_report: unsafe extern "C" fn(RlvJob, *mut RlvCrowdRefitReport) -> RlvResult);
function!(rlv_job_imprint_report: unsafe extern "C" fn(RlvJob, *mut RlvImprintReport) -> RlvResult);
function!(rlv_job_bake_report: unsafe extern "C" fn(RlvJob, *mut RlvBakeReport) -> RlvResult);
function!(rlv_job_fluid_report: unsafe extern "C" fn(RlvJob, *mut RlvFluidReport) -> RlvResult);
function!(rlv_job_ptex_report: unsafe extern "C" fn(RlvJob, *mut RlvPtexReport) -> RlvResult);
function!(rlv_job_transfer_report: unsafe extern "C" fn(RlvJob, *mut RlvTransferReport) -> RlvResult);
layout!(RlvObjectInfo: 104, 4);
function!(rlv_object_wait: unsafe extern "C" fn(u64, f64, *mut RlvObjectInfo) -> RlvResult);
layout!(RlvShader: 8, 8);
constant!(RLV_SHADER_GLSL = 0);
constant!(RLV_SHADER_WGSL = 1);
constant!(RLV_SHADER_VERTEX = 0);
constant!(RLV_SHADER_FRAGMENT = 1);
constant!(RLV_SHADER_COMPUTE = 2);
constant!(RLV_SHADER_MARKED = 0);
constant!(RLV_SHADER_AUGMENTED = 1);
constant!(RLV_SHADER_AUGMENTED_WGSL = 2);
constant!(RLV_SHADER_GLOBAL = 0);
constant!(RLV_SHADER_PARAMETER = 1);
constant!(RLV_SHADER_LOCAL = 2);
constant!(RLV_SHADER_AVERAGE = 0);
constant!(RLV_SHADER_SUM = 1);
constant!(RLV_SHADER_MIN = 2);
constant!(RLV_SHADER_MAX = 3);
constant!(RLV_SHADER_FIRST = 4);
constant!(RLV_SHADER_LAST = 5);
constant!(RLV_SHADER_NEGATIVE = 0);
constant!(RLV_SHADER_POSITIVE = 1);
constant!(RLV_SHADER_RENDER = 0);
constant!(RLV_SHADER_CLASSIFY = 1);
constant!(RLV_SHADER_MASK = 2);
constant!(RLV_SHADER_CLASSIFY_VERTEX = 3);
constant!(RLV_SHADER_VERTICES = 4);
layout!(RlvShaderOptions: 24, 8);
layout!(RlvShaderVariable: 440, 8);
layout!(RlvShaderLayout: 40, 4);
layout!(RlvShaderFeature: 776, 4);
layout!(RlvShaderExamples: 56, 8);
function!(rlv_shader_create: unsafe extern "C" fn(*const c_char, *const RlvShaderOptions, *mut RlvShader) -> RlvResult);
function!(rlv_shader_retain: unsafe extern "C" fn(RlvShader) -> RlvResult);
function!(rlv_shader_release: unsafe extern "C" fn(RlvShader) -> RlvResult);
function!(rlv_shader_variable_count: unsafe extern "C" fn(RlvShader, *mut usize) -> RlvResult);
function!(rlv_shader_variable: unsafe extern "C" fn(RlvShader, usize, *mut RlvShaderVariable) -> RlvResult);
function!(rlv_shader_mark: unsafe extern "C" fn(RlvShader, *const u32, usize, *const c_char, *mut RlvShader) -> RlvResult);
function!(rlv_shader_text: unsafe extern "C" fn(RlvShader, u32, *mut c_char, usize, *mut usize) -> RlvResult);
function!(rlv_shader_layout: unsafe extern "C" fn(RlvShader, *mut RlvShaderLayout) -> RlvResult);
function!(rlv_shader_feature: unsafe extern "C" fn(RlvShader, usize, *mut RlvShaderFeature) -> RlvResult);
function!(rlv_shader_pack_examples: unsafe extern "C" fn(*const RlvShaderExamples, u32, u32, u32, *mut u32, usize, *mut usize) -> RlvResult);
function!(rlv_shader_unpack_log: unsafe extern "C" fn(RlvShader, *const u32, usize, *mut f32, usize, *mut u32) -> RlvResult);
function!(rlv_shader_membership: unsafe extern "C" fn(*const RlvShaderExamples, *const f32, usize, usize, *mut f32) -> RlvResult);
layout!(RlvSubdivision: 8, 8);
constant!(RLV_SCHEME_CATMULL_CLARK = 0);
constant!(RLV_SCHEME_LOOP = 1);
constant!(RLV_SCHEME_BILINEAR = 2);
constant!(RLV_FACE_VARYING_NONE = 0);
constant!(RLV_FACE_VARYING_CORNERS_ONLY = 1);
constant!(RLV_FACE_VARYING_CORNERS_PLUS_1 = 2);
constant!(RLV_FACE_VARYING_CORNERS_PLUS_2 = 3);
constant!(RLV_FACE_VARYING_BOUNDARIES = 4);
constant!(RLV_FACE_VARYING_ALL = 5);
constant!(RLV_CREASING_UNIFORM = 0);
constant!(RLV_CREASING_CHAIKIN = 1);
constant!(RLV_TRIANGLE_CATMULL_CLARK = 0);
constant!(RLV_TRIANGLE_SMOOTH = 1);
constant!(RLV_POINT_VERTEX = 0);
constant!(RLV_POINT_VARYING = 1);
layout!(RlvSubdivisionOptions: 32, 4);
layout!(RlvSubdivisionInfo: 32, 8);
layout!(RlvSubdivisionArrays: 144, 8);
function!(rlv_subdivision_create: unsafe extern "C" fn(RlvContext, RlvMesh, *const RlvSubdivisionOptions, *mut RlvSubdivision) -> RlvResult);
function!(rlv_subdivision_retain: unsafe extern "C" fn(RlvSubdivision) -> RlvResult);
function!(rlv_subdivision_release: unsafe extern "C" fn(RlvSubdivision) -> RlvResult);
function!(rlv_subdivision_info: unsafe extern "C" fn(RlvSubdivision, *mut RlvSubdivisionInfo) -> RlvResult);
function!(rlv_subdivision_set_points: unsafe extern "C" fn(RlvSubdivision, *const f32, usize, usize) -> RlvResult);
function!(rlv_subdivision_face_tiles: unsafe extern "C" fn(RlvSubdivision, u32, *mut u32, *mut u32) -> RlvResult);
function!(rlv_subdivision_evaluate: unsafe extern "C" fn(RlvSubdivision, *const c_char, *const RlvSubdivisionArrays) -> RlvResult);
function!(rlv_subdivision_refine: unsafe extern "C" fn(RlvSubdivision, u32, *mut RlvMesh) -> RlvResult);
alias!(RlvVulkanLoader = Option<unsafe extern "C" fn(*mut c_void, *const c_char) -> *mut c_void>);
alias!(RlvVulkanNotice = Option<unsafe extern "C" fn(*mut c_void)>);
layout!(RlvVulkanDevice: 88, 8);
layout!(RlvVulkanBuffers: 40, 8);
function!(rlv_vulkan_create_context: unsafe extern "C" fn(*const RlvVulkanDevice, *const RlvContextOptions, *mut RlvContext) -> RlvResult);
function!(rlv_vulkan_create_buffer: unsafe extern "C" fn(RlvTessellation, *const RlvVulkanBuffers, *mut RlvBuffer) -> RlvResult);
function!(rlv_vulkan_wait: unsafe extern "C" fn(RlvContext, u64, u64) -> RlvResult);
function!(rlv_vulkan_signal: unsafe extern "C" fn(RlvContext, u64, u64) -> RlvResult);

pub fn offsets(list: &mut Offsets) {
    fields!(list, RlvError {
        struct_size: u32 = 0,
        result: RlvResult = 4,
        message: *const c_char = 8,
        what: *const c_char = 16,
        place: *const c_char = 24,
        remedy: *const c_char = 32,
        code: u32 = 40,
        element_kind: u32 = 44,
        element: u64 = 48,
    });
    fields!(list, RlvContext {
        id: u64 = 0,
    });
    fields!(list, RlvContextOptions {
        struct_size: u32 = 0,
        device: u32 = 4,
        threads: u32 = 8,
        reserved: u32 = 12,
        memory_limit: u64 = 16,
        device_memory_limit: u64 = 24,
        adapter: *const c_char = 32,
        shared: RlvContext = 40,
        host_loop: RlvLoop = 48,
        host_spawn: RlvSpawn = 56,
        host_user: *mut c_void = 64,
    });
    fields!(list, RlvContextInfo {
        struct_size: u32 = 0,
        device: u32 = 4,
        threads: u32 = 8,
        reserved: u32 = 12,
        memory_limit: u64 = 16,
        simd: [u8; 48] = 24,
        device_memory_limit: u64 = 72,
        device_memory: u64 = 80,
        adapter: [u8; 256] = 88,
        fallback: [u8; 256] = 344,
    });
    fields!(list, RlvContextStat {
        stage: [u8; 48] = 0,
        quantity: [u8; 48] = 48,
        total: f64 = 96,
        samples: u64 = 104,
    });
    fields!(list, RlvAdapterInfo {
        kind: u32 = 0,
        is_usable: u32 = 4,
        buffer_limit: u64 = 8,
        binding_limit: u64 = 16,
        backend: [u8; 48] = 24,
        name: [u8; 256] = 72,
        driver: [u8; 256] = 328,
    });
    fields!(list, RlvAllocator {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        allocate: RlvAllocate = 8,
        free: RlvFree = 16,
        user: *mut c_void = 24,
    });
    fields!(list, RlvAllocatorInfo {
        struct_size: u32 = 0,
        is_set: u32 = 4,
        bytes: u64 = 8,
        limit: u64 = 16,
    });
    fields!(list, RlvBytes {
        id: u64 = 0,
    });
    fields!(list, RlvMesh {
        id: u64 = 0,
    });
    fields!(list, RlvMeshArrays {
        struct_size: u32 = 0,
        face_size: u32 = 4,
        points: *const f32 = 8,
        point_count: usize = 16,
        point_stride: usize = 24,
        face_sizes: *const u32 = 32,
        face_count: usize = 40,
        face_stride: usize = 48,
        corners: *const u32 = 56,
        corner_count: usize = 64,
        corner_stride: usize = 72,
        creases: *const u32 = 80,
        crease_sharpness: *const f32 = 88,
        crease_count: usize = 96,
        crease_stride: usize = 104,
        crease_sharpness_stride: usize = 112,
        sharp_points: *const u32 = 120,
        sharp_point_sharpness: *const f32 = 128,
        sharp_point_count: usize = 136,
        sharp_point_stride: usize = 144,
        sharp_point_sharpness_stride: usize = 152,
        holes: *const u32 = 160,
        hole_count: usize = 168,
        hole_stride: usize = 176,
    });
    fields!(list, RlvMeshInfo {
        struct_size: u32 = 0,
        attribute_count: u32 = 4,
        point_count: usize = 8,
        face_count: usize = 16,
        corner_count: usize = 24,
        triangle_count: usize = 32,
        crease_count: usize = 40,
        sharp_point_count: usize = 48,
        hole_count: usize = 56,
        low: [f32; 3] = 64,
        high: [f32; 3] = 76,
    });
    fields!(list, RlvAttributeArrays {
        struct_size: u32 = 0,
        domain: u32 = 4,
        type_: u32 = 8,
        width: u32 = 12,
        name: *const c_char = 16,
        values: *const c_void = 24,
        value_count: usize = 32,
        value_stride: usize = 40,
        indices: *const u32 = 48,
        index_count: usize = 56,
        index_stride: usize = 64,
    });
    fields!(list, RlvAttributeInfo {
        struct_size: u32 = 0,
        domain: u32 = 4,
        type_: u32 = 8,
        width: u32 = 12,
        value_count: usize = 16,
        index_count: usize = 24,
        name: [u8; 48] = 32,
    });
    fields!(list, RlvSimplifyWeight {
        name: *const c_char = 0,
        weight: f32 = 8,
        is_left_out: u32 = 12,
    });
    fields!(list, RlvSimplifyOptions {
        struct_size: u32 = 0,
        error: f32 = 4,
        triangles: usize = 8,
        weights: *const RlvSimplifyWeight = 16,
        weight_count: usize = 24,
        weight_stride: usize = 32,
        locked: *const u32 = 40,
        locked_count: usize = 48,
        locked_stride: usize = 56,
        factors: *const f32 = 64,
        factor_count: usize = 72,
        factor_stride: usize = 80,
        bound: f32 = 88,
        is_border_locked: u32 = 92,
    });
    fields!(list, RlvProgressive {
        id: u64 = 0,
    });
    fields!(list, RlvProgressiveOptions {
        struct_size: u32 = 0,
        keeps_attributes: u32 = 4,
        base_triangles: usize = 8,
        locked: *const u32 = 16,
        locked_count: usize = 24,
        locked_stride: usize = 32,
        weights: *const RlvSimplifyWeight = 40,
        weight_count: usize = 48,
        weight_stride: usize = 56,
    });
    fields!(list, RlvProgressiveInfo {
        struct_size: u32 = 0,
        attribute_count: u32 = 4,
        vertex_count: usize = 8,
        triangle_count: usize = 16,
        base_vertex_count: usize = 24,
        base_triangle_count: usize = 32,
        bytes: usize = 40,
        wedge_count: usize = 48,
        wedge_width: u32 = 56,
        face_width: u32 = 60,
    });
    fields!(list, RlvArrival {
        id: u64 = 0,
    });
    fields!(list, RlvArrivalInfo {
        struct_size: u32 = 0,
        is_complete: u32 = 4,
        triangle_count: usize = 8,
    });
    fields!(list, RlvSurface {
        id: u64 = 0,
    });
    fields!(list, RlvSurfaceOptions {
        struct_size: u32 = 0,
        boundary: u32 = 4,
        isolation: u32 = 8,
        patch_limit: u32 = 12,
        kind: u32 = 16,
        reserved: u32 = 20,
    });
    fields!(list, RlvSurfaceInfo {
        struct_size: u32 = 0,
        non_manifold: u32 = 4,
        point_count: usize = 8,
        face_count: usize = 16,
        tile_count: usize = 24,
        patch_count: usize = 32,
        bytes: u64 = 40,
        low: [f32; 3] = 48,
        high: [f32; 3] = 60,
        extent: f32 = 72,
        kind: u32 = 76,
    });
    fields!(list, RlvTileInfo {
        struct_size: u32 = 0,
        face: u32 = 4,
        corner: u32 = 8,
        is_part: u32 = 12,
        is_hole: u32 = 16,
        low: [f32; 3] = 20,
        high: [f32; 3] = 32,
    });
    fields!(list, RlvDetail {
        id: u64 = 0,
    });
    fields!(list, RlvDetailOptions {
        struct_size: u32 = 0,
        tile_size: u32 = 4,
        budget: u64 = 8,
        face_sizes: *const u32 = 16,
        face_size_count: usize = 24,
        face_size_stride: usize = 32,
    });
    fields!(list, RlvDetailInfo {
        struct_size: u32 = 0,
        is_painted: u32 = 4,
        tile_count: usize = 8,
        allocated_count: usize = 16,
        revision: u64 = 24,
        bytes: u64 = 32,
        full_bytes: u64 = 40,
        budget: u64 = 48,
        painted_count: usize = 56,
        paint_bytes: u64 = 64,
        paint_budget: u64 = 72,
        time: f64 = 80,
        stamp_bytes: u64 = 88,
    });
    fields!(list, RlvChannelInfo {
        struct_size: u32 = 0,
        is_there: u32 = 4,
        allocated_count: usize = 8,
        bytes: u64 = 16,
        full_bytes: u64 = 24,
        budget: u64 = 32,
        texel_size: u32 = 40,
        paged_count: u32 = 44,
    });
    fields!(list, RlvDetailFolds {
        struct_size: u32 = 0,
        tile: u32 = 4,
        triangle_count: u64 = 8,
        folded_count: u64 = 16,
    });
    fields!(list, RlvPaintOptions {
        struct_size: u32 = 0,
        tile_size: u32 = 4,
        budget: u64 = 8,
        color: [f32; 4] = 16,
        format: u32 = 32,
        reserved: u32 = 36,
    });
    fields!(list, RlvVectorOptions {
        struct_size: u32 = 0,
        tile_size: u32 = 4,
        budget: u64 = 8,
    });
    fields!(list, RlvDecayOptions {
        struct_size: u32 = 0,
        delay: f32 = 4,
        duration: f32 = 8,
        reserved: u32 = 12,
        budget: u64 = 16,
    });
    fields!(list, RlvDetailChanges {
        struct_size: u32 = 0,
        moved: u32 = 4,
        revision: u64 = 8,
        tile_count: usize = 16,
        low: [f32; 3] = 24,
        high: [f32; 3] = 36,
    });
    fields!(list, RlvDetailTileInfo {
        struct_size: u32 = 0,
        is_allocated: u32 = 4,
        size: u32 = 8,
        reserved: u32 = 12,
        version: u64 = 16,
        block_size: usize = 24,
        low: [f32; 3] = 32,
        high: [f32; 3] = 44,
    });
    fields!(list, RlvBakeOptions {
        struct_size: u32 = 0,
        quantity: u32 = 4,
        width: u32 = 8,
        height: u32 = 12,
        is_udim: u32 = 16,
        gutter: u32 = 20,
        samples: u32 = 24,
        space: u32 = 28,
        axes: u32 = 32,
        handedness: u32 = 36,
        scale: f32 = 40,
        mid_level: f32 = 44,
        uv: *const c_char = 48,
    });
    fields!(list, RlvBakePicture {
        struct_size: u32 = 0,
        udim: u32 = 4,
        width: u32 = 8,
        height: u32 = 12,
        channels: u32 = 16,
        reserved: u32 = 20,
        pixels: *const f32 = 24,
        covered: *const u8 = 32,
    });
    fields!(list, RlvBakeReport {
        struct_size: u32 = 0,
        picture_count: u32 = 4,
        covered_pixels: u64 = 8,
        gutter_pixels: u64 = 16,
        overlapping_pixels: u64 = 24,
        flat_tiles: usize = 32,
        outside_count: usize = 40,
        scale: f32 = 48,
        mid_level: f32 = 52,
    });
    fields!(list, RlvEvaluateArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        tiles: *const u32 = 16,
        tile_stride: usize = 24,
        uvs: *const f32 = 32,
        uv_stride: usize = 40,
        positions: *mut f32 = 48,
        position_stride: usize = 56,
        normals: *mut f32 = 64,
        normal_stride: usize = 72,
        du: *mut f32 = 80,
        du_stride: usize = 88,
        dv: *mut f32 = 96,
        dv_stride: usize = 104,
        duu: *mut f32 = 112,
        duu_stride: usize = 120,
        duv: *mut f32 = 128,
        duv_stride: usize = 136,
        dvv: *mut f32 = 144,
        dvv_stride: usize = 152,
        displacements: *mut f32 = 160,
        displacement_stride: usize = 168,
        colors: *mut f32 = 176,
        color_stride: usize = 184,
        vectors: *mut f32 = 192,
        vector_stride: usize = 200,
        traces: *mut f32 = 208,
        trace_stride: usize = 216,
        footprints: *const f32 = 224,
        footprint_stride: usize = 232,
    });
    fields!(list, RlvBezier {
        id: u64 = 0,
    });
    fields!(list, RlvBezierArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        points: *const f32 = 8,
        point_count: usize = 16,
        point_stride: usize = 24,
        weights: *const f32 = 32,
        weight_stride: usize = 40,
        indices: *const u32 = 48,
        index_count: usize = 56,
        index_stride: usize = 64,
    });
    fields!(list, RlvBezierInfo {
        struct_size: u32 = 0,
        is_rational: u32 = 4,
        patch_count: usize = 8,
        curve_count: usize = 16,
        low: [f32; 3] = 24,
        high: [f32; 3] = 36,
    });
    fields!(list, RlvBezierView {
        struct_size: u32 = 0,
        most: u32 = 4,
        eye: [f64; 3] = 8,
        forward: [f64; 3] = 32,
        pixels: f64 = 56,
        corner: f64 = 64,
        tolerance: f64 = 72,
    });
    fields!(list, RlvBezierLevels {
        struct_size: u32 = 0,
        level: u32 = 4,
        levels: *const u32 = 8,
        level_count: usize = 16,
        level_stride: usize = 24,
    });
    fields!(list, RlvBezierTriangles {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        positions: *mut f32 = 8,
        position_stride: usize = 16,
        normals: *mut f32 = 24,
        normal_stride: usize = 32,
        point_capacity: usize = 40,
        corners: *mut u32 = 48,
        triangle_stride: usize = 56,
        triangle_capacity: usize = 64,
    });
    fields!(list, RlvParameter {
        name: *const c_char = 0,
        unit: *const c_char = 8,
        help: *const c_char = 16,
        kind: u32 = 24,
        offset: u32 = 28,
        min: f64 = 32,
        max: f64 = 40,
        value: f64 = 48,
    });
    fields!(list, RlvBrush {
        id: u64 = 0,
    });
    fields!(list, RlvBrushOptions {
        struct_size: u32 = 0,
        action: u32 = 4,
        mode: u32 = 8,
        falloff: u32 = 12,
        color: [f32; 4] = 16,
        height: f32 = 32,
        reserved: u32 = 36,
    });
    fields!(list, RlvBrushSettings {
        struct_size: u32 = 0,
        radius: f32 = 4,
        depth: f32 = 8,
        spacing: f32 = 12,
        strength: f32 = 16,
        strength_pressure: f32 = 20,
        size_pressure: f32 = 24,
        angle: f32 = 28,
        angle_pressure: f32 = 32,
        jitter_position: f32 = 36,
        jitter_size: f32 = 40,
        jitter_strength: f32 = 44,
        jitter_angle: f32 = 48,
        seed: u32 = 52,
        string: f32 = 56,
        rate: f32 = 60,
        symmetry_x: u32 = 64,
        symmetry_y: u32 = 68,
        symmetry_z: u32 = 72,
        reach: f32 = 76,
        level: u32 = 80,
    });
    fields!(list, RlvStampOptions {
        struct_size: u32 = 0,
        channel: u32 = 4,
        width: u32 = 8,
        height: u32 = 12,
        channels: u32 = 16,
        reserved: u32 = 20,
        pixels: *const f32 = 24,
    });
    fields!(list, RlvStampSettings {
        struct_size: u32 = 0,
        angle: f32 = 4,
        repeat: f32 = 8,
        mirror: u32 = 12,
        alternate: u32 = 16,
        mid: f32 = 20,
        scale: f32 = 24,
    });
    fields!(list, RlvTessellateOptions {
        struct_size: u32 = 0,
        coarse: u32 = 4,
        fine: u32 = 8,
        places: u32 = 12,
        smooth_uvs: u32 = 16,
        reserved: u32 = 20,
    });
    fields!(list, RlvTessellation {
        id: u64 = 0,
    });
    fields!(list, RlvTessellationInfo {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        point_count: usize = 8,
        triangle_count: usize = 16,
        revision: u64 = 24,
    });
    fields!(list, RlvTessellationChanges {
        struct_size: u32 = 0,
        rebuilt: u32 = 4,
        range_count: usize = 8,
        point_count: usize = 16,
        low: [f32; 3] = 24,
        high: [f32; 3] = 36,
    });
    fields!(list, RlvBuffer {
        id: u64 = 0,
    });
    fields!(list, RlvBufferInfo {
        struct_size: u32 = 0,
        rebuilt: u32 = 4,
        point_count: usize = 8,
        triangle_count: usize = 16,
        written_count: usize = 24,
        bytes: u64 = 32,
    });
    fields!(list, RlvBufferVulkan {
        struct_size: u32 = 0,
        queue_family: u32 = 4,
        queue_index: u32 = 8,
        reserved: u32 = 12,
        instance: u64 = 16,
        physical_device: u64 = 24,
        device: u64 = 32,
        queue: u64 = 40,
        points: u64 = 48,
        triangles: u64 = 56,
    });
    fields!(list, RlvCapability {
        struct_size: u32 = 0,
        version: u32 = 4,
        embree_version: u32 = 8,
        opensubdiv_version: u32 = 12,
        openvdb_version: u32 = 16,
        has_devices: u32 = 20,
        has_usd: u32 = 24,
        has_shaders: u32 = 28,
        has_tls: u32 = 32,
        adapter_count: u32 = 36,
        cores: u32 = 40,
        max_threads: u32 = 44,
        max_isolation: u32 = 48,
        reserved: u32 = 52,
        max_objects: u64 = 56,
        simd: [u8; 48] = 64,
    });
    fields!(list, RlvCapabilityFormat {
        content: u32 = 0,
        can_read: u32 = 4,
        can_write: u32 = 8,
        can_write_bytes: u32 = 12,
        extension: [u8; 48] = 16,
    });
    fields!(list, RlvCaster {
        id: u64 = 0,
    });
    fields!(list, RlvHit {
        distance: f32 = 0,
        face: u32 = 4,
        tile: u32 = 8,
        u: f32 = 12,
        v: f32 = 16,
        position: [f32; 3] = 20,
        normal: [f32; 3] = 32,
    });
    fields!(list, RlvRayArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        origins: *const f32 = 16,
        origin_stride: usize = 24,
        directions: *const f32 = 32,
        direction_stride: usize = 40,
        hits: *mut RlvHit = 48,
        hit_stride: usize = 56,
        min_distance: f32 = 64,
        max_distance: f32 = 68,
        min_distances: *const f32 = 72,
        min_distance_stride: usize = 80,
        max_distances: *const f32 = 88,
        max_distance_stride: usize = 96,
        masks: *const u32 = 104,
        mask_stride: usize = 112,
        times: *const f32 = 120,
        time_stride: usize = 128,
    });
    fields!(list, RlvIsosurface {
        id: u64 = 0,
    });
    fields!(list, RlvIsosurfaceOptions {
        struct_size: u32 = 0,
        function: u32 = 4,
        radius: f32 = 8,
        support: f32 = 12,
        sharpness: f32 = 16,
        iso: f32 = 20,
        centring: f32 = 24,
        shutter_open: f32 = 28,
        shutter_close: f32 = 32,
        march_steps: f32 = 36,
    });
    fields!(list, RlvIsosurfaceParticles {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        points: *const f32 = 16,
        point_stride: usize = 24,
        velocities: *const f32 = 32,
        velocity_stride: usize = 40,
        blind: *const u8 = 48,
        blind_stride: usize = 56,
    });
    fields!(list, RlvIsosurfaceInfo {
        struct_size: u32 = 0,
        has_velocities: u32 = 4,
        particle_count: usize = 8,
        support: f32 = 16,
        reach: f32 = 20,
        influence: f32 = 24,
        reserved: f32 = 28,
    });
    fields!(list, RlvIsosurfaceMeshOptions {
        struct_size: u32 = 0,
        iterations: u32 = 4,
        cell: f32 = 8,
        forwards: f32 = 12,
        backwards: f32 = 16,
        reserved: u32 = 20,
        channels: *const RlvAttributeArrays = 24,
        channel_count: usize = 32,
        channel_stride: usize = 40,
    });
    fields!(list, RlvIsosurfaceClasses {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        surface_count: usize = 8,
        blind_count: usize = 16,
        hidden_count: usize = 24,
        kept: f64 = 32,
    });
    fields!(list, RlvIsosurfaceRay {
        origin: [f32; 3] = 0,
        direction: [f32; 3] = 12,
        min_distance: f32 = 24,
        max_distance: f32 = 28,
        time: f32 = 32,
    });
    fields!(list, RlvIsosurfaceHit {
        distance: f32 = 0,
        position: [f32; 3] = 4,
        normal: [f32; 3] = 16,
        velocity: [f32; 3] = 28,
        enters: u32 = 40,
    });
    fields!(list, RlvIsosurfaceTable {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        data: *const c_void = 8,
        intersect: RlvIsosurfaceIntersect = 16,
        low: [f32; 3] = 24,
        high: [f32; 3] = 36,
    });
    fields!(list, RlvParticles {
        id: u64 = 0,
    });
    fields!(list, RlvParticlesArrays {
        struct_size: u32 = 0,
        has_time: u32 = 4,
        time: f64 = 8,
        spacing: f32 = 16,
        reserved: u32 = 20,
        count: usize = 24,
        points: *const f32 = 32,
        point_stride: usize = 40,
        numbers: *const u32 = 48,
        number_stride: usize = 56,
        channels: *const RlvAttributeArrays = 64,
        channel_count: usize = 72,
        channel_stride: usize = 80,
    });
    fields!(list, RlvParticlesInfo {
        struct_size: u32 = 0,
        channel_count: u32 = 4,
        count: usize = 8,
        has_numbers: u32 = 16,
        has_time: u32 = 20,
        time: f64 = 24,
        spacing: f32 = 32,
        reserved: u32 = 36,
    });
    fields!(list, RlvClient {
        id: u64 = 0,
    });
    fields!(list, RlvClientOptions {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        address: *const c_char = 8,
        token: *const c_char = 16,
        authorities: *const c_char = 24,
        timeout: f64 = 32,
        patience: f64 = 40,
    });
    fields!(list, RlvClientStatus {
        struct_size: u32 = 0,
        state: u32 = 4,
        ready: u64 = 8,
        frames: u64 = 16,
        particles: u64 = 24,
        seconds_left: f64 = 32,
        fraction: f32 = 40,
        reserved: u32 = 44,
        text: [u8; 256] = 48,
    });
    fields!(list, RlvClientInfo {
        struct_size: u32 = 0,
        protocol: [u32; 2] = 4,
        reserved: u32 = 12,
        server: [u8; 48] = 16,
        user: [u8; 256] = 64,
        kinds: [u8; 256] = 320,
    });
    fields!(list, RlvClientFile {
        name: *const c_char = 0,
        path: *const c_char = 8,
    });
    fields!(list, RlvClientScene {
        struct_size: u32 = 0,
        is_forced: u32 = 4,
        name: *const c_char = 8,
        kind: *const c_char = 16,
        description: *const c_char = 24,
        files: *const RlvClientFile = 32,
        file_count: usize = 40,
    });
    fields!(list, RlvClientFetch {
        struct_size: u32 = 0,
        particles: u32 = 4,
        is_half: u32 = 8,
        is_plain: u32 = 12,
        channels: *const c_char = 16,
    });
    fields!(list, RlvCollider {
        id: u64 = 0,
    });
    fields!(list, RlvColliderInfo {
        struct_size: u32 = 0,
        is_closed: u32 = 4,
        point_count: usize = 8,
        triangle_count: usize = 16,
        matrix: [f64; 12] = 24,
        open_edge_count: usize = 120,
    });
    fields!(list, RlvToolSettings {
        struct_size: u32 = 0,
        stiffness: f32 = 4,
        max_depth: f32 = 8,
    });
    fields!(list, RlvColorBuffer {
        id: u64 = 0,
    });
    fields!(list, RlvColorBufferInfo {
        struct_size: u32 = 0,
        rebuilt: u32 = 4,
        format: u32 = 8,
        reserved: u32 = 12,
        tile_count: usize = 16,
        allocated_count: usize = 24,
        written_count: usize = 32,
        bytes: u64 = 40,
        color: [f32; 4] = 48,
    });
    fields!(list, RlvColorBufferVulkan {
        struct_size: u32 = 0,
        queue_family: u32 = 4,
        queue_index: u32 = 8,
        reserved: u32 = 12,
        instance: u64 = 16,
        physical_device: u64 = 24,
        device: u64 = 32,
        queue: u64 = 40,
        tiles: u64 = 48,
        texels: u64 = 56,
        mip_firsts: u64 = 64,
        mips: u64 = 72,
    });
    fields!(list, RlvCrowdModel {
        id: u64 = 0,
    });
    fields!(list, RlvCrowd {
        id: u64 = 0,
    });
    fields!(list, RlvCrowdBuildSettings {
        struct_size: u32 = 0,
        pose_distance: f32 = 4,
        cluster_triangles: u32 = 8,
        group_clusters: u32 = 12,
        pose_rate: f32 = 16,
    });
    fields!(list, RlvCrowdClipName {
        name: *const c_char = 0,
    });
    fields!(list, RlvCrowdRefitReport {
        struct_size: u32 = 0,
        grown_groups: u32 = 4,
        growth: f64 = 8,
        is_rebuild_due: u32 = 16,
        reserved: u32 = 20,
    });
    fields!(list, RlvCrowdModelInfo {
        struct_size: u32 = 0,
        vertex_count: u32 = 4,
        triangle_count: u32 = 8,
        input_triangles: u32 = 12,
        cluster_count: u32 = 16,
        group_count: u32 = 20,
        bone_count: u32 = 24,
        clip_count: u32 = 28,
        material_count: u32 = 32,
        pose_count: u32 = 36,
        representatives: u32 = 40,
        largest_error: f32 = 44,
        measured: u64 = 48,
        exceeded: u64 = 56,
        low: [f32; 3] = 64,
        high: [f32; 3] = 76,
        morph_count: u32 = 88,
        offset_count: u32 = 92,
        blend: u32 = 96,
        reserved: u32 = 100,
    });
    fields!(list, RlvCrowdClip {
        struct_size: u32 = 0,
        pose_count: u32 = 4,
        rate: f32 = 8,
        name: [u8; 48] = 12,
    });
    fields!(list, RlvCrowdMaterial {
        struct_size: u32 = 0,
        name: [u8; 256] = 4,
    });
    fields!(list, RlvCrowdVertices {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        capacity: usize = 8,
        points: *mut f32 = 16,
        normals: *mut f32 = 24,
        uvs: *mut f32 = 32,
        bones: *mut u32 = 40,
        weights: *mut f32 = 48,
    });
    fields!(list, RlvCrowdCollapse {
        group: u32 = 0,
        target: u32 = 4,
    });
    fields!(list, RlvCrowdOffset {
        vertex: u32 = 0,
        morph: u32 = 4,
        offset: [f32; 3] = 8,
    });
    fields!(list, RlvCrowdCluster {
        first_triangle: u32 = 0,
        triangle_count: u32 = 4,
        made_by: u32 = 8,
        used_by: u32 = 12,
        depth: u32 = 16,
        deformation: f32 = 20,
    });
    fields!(list, RlvCrowdAgent {
        model: u32 = 0,
        clip: u32 = 4,
        phase: f64 = 8,
        transform: [f64; 12] = 16,
    });
    fields!(list, RlvCrowdSun {
        towards: [f64; 3] = 0,
        angular_radius: f64 = 24,
    });
    fields!(list, RlvCrowdView {
        struct_size: u32 = 0,
        width: u32 = 4,
        height: u32 = 8,
        tolerance: f32 = 12,
        eye: [f64; 3] = 16,
        target: [f64; 3] = 40,
        up: [f64; 3] = 64,
        fov: f64 = 88,
        time: f64 = 96,
        occlusion: u32 = 104,
        geomorph: u32 = 108,
        impostors: u32 = 112,
        reserved: u32 = 116,
        suns: *const RlvCrowdSun = 120,
        sun_count: usize = 128,
        around: f64 = 136,
    });
    fields!(list, RlvCrowdFrame {
        struct_size: u32 = 0,
        agent_count: u32 = 4,
        draw_count: u32 = 8,
        matrix_count: u32 = 12,
        changed: u32 = 16,
        hidden: u32 = 20,
        clusters: u64 = 24,
        triangles: u64 = 32,
        hidden_triangles: u64 = 40,
        occluder_triangles: u64 = 48,
        weight_count: u32 = 56,
        impostor_count: u32 = 60,
        picture_count: u32 = 64,
        hidden_clusters: u32 = 68,
    });
    fields!(list, RlvCrowdDraw {
        index_count: u32 = 0,
        instance_count: u32 = 4,
        first_index: u32 = 8,
        base_vertex: i32 = 12,
        first_instance: u32 = 16,
    });
    fields!(list, RlvCrowdInstance {
        agent: u32 = 0,
        first_matrix: u32 = 4,
        transform: [f32; 12] = 8,
    });
    fields!(list, RlvCrowdBuffers {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        draws: *mut RlvCrowdDraw = 8,
        draw_capacity: usize = 16,
        draw_stride: usize = 24,
        clusters: *mut u32 = 32,
        instances: *mut RlvCrowdInstance = 40,
        instance_capacity: usize = 48,
        instance_stride: usize = 56,
        matrices: *mut f32 = 64,
        matrix_capacity: usize = 72,
        matrix_stride: usize = 80,
        weights: *mut f32 = 88,
        weight_capacity: usize = 96,
        first_weights: *mut u32 = 104,
        blends: *mut f32 = 112,
        dual_rows: *mut f32 = 120,
    });
    fields!(list, RlvCrowdImpostor {
        agent: u32 = 0,
        picture: u32 = 4,
        transform: [f32; 12] = 8,
    });
    fields!(list, RlvCrowdPicture {
        number: u64 = 0,
        model: u32 = 8,
        radius: f32 = 12,
        center: [f32; 3] = 16,
        axes: [f32; 9] = 28,
    });
    fields!(list, RlvCrowdTexel {
        cluster: u32 = 0,
        material: u32 = 4,
        normal: [f32; 3] = 8,
    });
    fields!(list, RlvCrowdImpostors {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        impostors: *mut RlvCrowdImpostor = 8,
        impostor_capacity: usize = 16,
        impostor_stride: usize = 24,
        pictures: *mut RlvCrowdPicture = 32,
        picture_capacity: usize = 40,
        picture_stride: usize = 48,
        texels: *mut RlvCrowdTexel = 56,
        texel_capacity: usize = 64,
    });
    fields!(list, RlvCrowdStreamFile {
        path: *const c_char = 0,
    });
    fields!(list, RlvCrowdStreamSettings {
        struct_size: u32 = 0,
        most_read: u32 = 4,
        budget: u64 = 8,
    });
    fields!(list, RlvCrowdStreamInfo {
        struct_size: u32 = 0,
        slot_triangles: u32 = 4,
        slot_count: u32 = 8,
        resident: u32 = 12,
        read: u32 = 16,
        dropped: u32 = 20,
        missing: u32 = 24,
        reserved: u32 = 28,
        wanted_triangles: u64 = 32,
    });
    fields!(list, RlvCrowdStreamCluster {
        model: u32 = 0,
        cluster: u32 = 4,
        slot: u32 = 8,
        triangle_count: u32 = 12,
    });
    fields!(list, RlvStream {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        user: *mut c_void = 8,
        read: RlvStreamRead = 16,
        write: RlvStreamWrite = 24,
        length: RlvStreamLength = 32,
        cut: RlvStreamCut = 40,
        sync: RlvStreamSync = 48,
        close: RlvStreamClose = 56,
    });
    fields!(list, RlvDocument {
        id: u64 = 0,
    });
    fields!(list, RlvDocumentInfo {
        struct_size: u32 = 0,
        is_open: u32 = 4,
        undo_count: usize = 8,
        redo_count: usize = 16,
        bytes: u64 = 24,
    });
    fields!(list, RlvDocumentChanges {
        struct_size: u32 = 0,
        is_done: u32 = 4,
        layer_count: usize = 8,
        block_count: usize = 16,
        bytes: u64 = 24,
    });
    fields!(list, RlvTransferOptions {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        from: RlvMesh = 8,
        reach: f64 = 16,
    });
    fields!(list, RlvTransferReport {
        struct_size: u32 = 0,
        layer_count: u32 = 4,
        area: f64 = 8,
        uncovered_area: f64 = 16,
        edited_area: f64 = 24,
        lost_area: f64 = 32,
        reach: f64 = 40,
    });
    fields!(list, RlvLayerOptions {
        struct_size: u32 = 0,
        kind: u32 = 4,
        blend: u32 = 8,
        is_visible: u32 = 12,
        opacity: f32 = 16,
        tile_size: u32 = 20,
    });
    fields!(list, RlvLayerInfo {
        struct_size: u32 = 0,
        id: u32 = 4,
        kind: u32 = 8,
        blend: u32 = 12,
        is_visible: u32 = 16,
        is_active: u32 = 20,
        opacity: f32 = 24,
        reserved: u32 = 28,
        tile_count: usize = 32,
        name: [u8; 256] = 40,
    });
    fields!(list, RlvDecal {
        id: u64 = 0,
    });
    fields!(list, RlvDecalPin {
        image: [f64; 2] = 0,
        position: [f64; 3] = 16,
        depth: f64 = 40,
    });
    fields!(list, RlvDecalOptions {
        struct_size: u32 = 0,
        width: u32 = 4,
        height: u32 = 8,
        can_overlap: u32 = 12,
        outline: *const f64 = 16,
        outline_count: usize = 24,
        outline_stride: usize = 32,
        pose_width: f64 = 40,
        pose_up: [f64; 3] = 48,
        steps: u32 = 72,
        decrease: f32 = 76,
        triangles: u32 = 80,
        cells: u32 = 84,
    });
    fields!(list, RlvDecalQuality {
        struct_size: u32 = 0,
        pin_count: u32 = 4,
        triangle_count: usize = 8,
        flip_count: usize = 16,
        overlap_count: usize = 24,
        l2: f64 = 32,
        l_infinity: f64 = 40,
        worst_angle: f64 = 48,
        area_ratio: f64 = 56,
        coverage: f64 = 64,
        doubled: f64 = 72,
    });
    fields!(list, RlvDecalImage {
        struct_size: u32 = 0,
        channels: u32 = 4,
        pixels: *const f32 = 8,
        pixel_count: usize = 16,
    });
    fields!(list, RlvDecalInk {
        struct_size: u32 = 0,
        channel: u32 = 4,
        blend: u32 = 8,
        opacity: f32 = 12,
        height: f32 = 16,
        reserved: u32 = 20,
    });
    fields!(list, RlvDecalTexture {
        struct_size: u32 = 0,
        width: u32 = 4,
        height: u32 = 8,
        channels: u32 = 12,
        gutter: u32 = 16,
        reserved: u32 = 20,
        pixels: *mut f32 = 24,
        pixel_count: usize = 32,
    });
    fields!(list, RlvDecalReport {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        changed_tiles: u64 = 8,
        texels: u64 = 16,
        refused_tiles: u64 = 24,
    });
    fields!(list, RlvDecalRecipe {
        struct_size: u32 = 0,
        id: u32 = 4,
        layer: u32 = 8,
        pin_count: u32 = 12,
        width: u32 = 16,
        height: u32 = 20,
        channel: u32 = 24,
        blend: u32 = 28,
        opacity: f32 = 32,
        relief: f32 = 36,
        image_hash: u64 = 40,
    });
    fields!(list, RlvDeviceCrowd {
        id: u64 = 0,
    });
    fields!(list, RlvDeviceCrowdInfo {
        struct_size: u32 = 0,
        agent_count: u32 = 4,
        draw_count: u32 = 8,
        matrix_count: u32 = 12,
        weight_count: u32 = 16,
        impostor_count: u32 = 20,
        picture_count: u32 = 24,
        hidden: u32 = 28,
        hidden_triangles: u64 = 32,
        occluder_triangles: u64 = 40,
        hidden_clusters: u32 = 48,
        reserved: u32 = 52,
    });
    fields!(list, RlvDeviceCrowdVulkan {
        struct_size: u32 = 0,
        queue_family: u32 = 4,
        queue_index: u32 = 8,
        reserved: u32 = 12,
        instance: u64 = 16,
        physical_device: u64 = 24,
        device: u64 = 32,
        queue: u64 = 40,
        draws: u64 = 48,
        clusters: u64 = 56,
        instances: u64 = 64,
        counts: u64 = 72,
        matrices: u64 = 80,
        weights: u64 = 88,
        blends: u64 = 96,
    });
    fields!(list, RlvStroke {
        id: u64 = 0,
    });
    fields!(list, RlvStrokePoint {
        position: [f64; 3] = 0,
        pressure: f64 = 24,
        time: f64 = 32,
    });
    fields!(list, RlvStrokeReport {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        dabs: u64 = 8,
        missed_dabs: u64 = 16,
        tested_tiles: u64 = 24,
        tested_texels: u64 = 32,
        changed_tiles: u64 = 40,
        changed_texels: u64 = 48,
        allocated_tiles: u64 = 56,
        freed_tiles: u64 = 64,
        refused_tiles: u64 = 72,
        bytes: u64 = 80,
    });
    fields!(list, RlvLevel {
        id: u64 = 0,
    });
    fields!(list, RlvLevelInfo {
        struct_size: u32 = 0,
        undo_count: u32 = 4,
        redo_count: u32 = 8,
        reserved: u32 = 12,
        vertex_count: usize = 16,
        triangle_count: usize = 24,
    });
    fields!(list, RlvLevelView {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        eye: [f64; 3] = 8,
        pixels: f64 = 32,
        tolerance: f64 = 40,
        outline: f64 = 48,
        planes: *const f32 = 56,
        plane_count: usize = 64,
        plane_stride: usize = 72,
    });
    fields!(list, RlvLevelRegion {
        center: [f64; 3] = 0,
        radius: f32 = 24,
        falloff: u32 = 28,
    });
    fields!(list, RlvLevelHandle {
        region: RlvLevelRegion = 0,
        translation: [f32; 3] = 32,
        axis: [f32; 3] = 44,
        angle: f32 = 56,
        reserved: u32 = 60,
    });
    fields!(list, RlvLevelEdit {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        handles: *const RlvLevelHandle = 8,
        handle_count: usize = 16,
        handle_stride: usize = 24,
        anchors: *const RlvLevelRegion = 32,
        anchor_count: usize = 40,
        anchor_stride: usize = 48,
    });
    fields!(list, RlvLevelKey {
        time: f64 = 0,
        translation: [f32; 3] = 8,
        axis: [f32; 3] = 20,
        angle: f32 = 32,
        reserved: u32 = 36,
    });
    fields!(list, RlvLevelTrack {
        region: RlvLevelRegion = 0,
        keys: *const RlvLevelKey = 32,
        key_count: usize = 40,
        key_stride: usize = 48,
    });
    fields!(list, RlvLevelMotion {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        tracks: *const RlvLevelTrack = 8,
        track_count: usize = 16,
        track_stride: usize = 24,
        anchors: *const RlvLevelRegion = 32,
        anchor_count: usize = 40,
        anchor_stride: usize = 48,
    });
    fields!(list, RlvLevelSculpted {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        dabs: u64 = 8,
        missed_dabs: u64 = 16,
        vertices: u64 = 24,
    });
    fields!(list, RlvLevelBuffers {
        struct_size: u32 = 0,
        is_whole: u32 = 4,
        points: *mut f32 = 8,
        point_stride: usize = 16,
        normals: *mut f32 = 24,
        normal_stride: usize = 32,
        vertex_capacity: usize = 40,
        triangles: *mut u32 = 48,
        triangle_stride: usize = 56,
        triangle_capacity: usize = 64,
        wedges: *mut u32 = 72,
        wedge_stride: usize = 80,
        wedge_values: *mut f32 = 88,
        wedge_value_stride: usize = 96,
        wedge_capacity: usize = 104,
        face_values: *mut u32 = 112,
        face_value_stride: usize = 120,
    });
    fields!(list, RlvLevelUpdate {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        vertex_count: usize = 8,
        triangle_count: usize = 16,
        first_vertex: usize = 24,
        changed_vertex_count: usize = 32,
        first_triangle: usize = 40,
        changed_triangle_count: usize = 48,
        wedge_count: usize = 56,
        first_wedge: usize = 64,
        changed_wedge_count: usize = 72,
    });
    fields!(list, RlvLevelMisplaced {
        point: [f32; 3] = 0,
        told: f32 = 12,
        now: f32 = 16,
    });
    fields!(list, RlvDeviceLevel {
        id: u64 = 0,
    });
    fields!(list, RlvDeviceLevelInfo {
        struct_size: u32 = 0,
        undo_count: u32 = 4,
        redo_count: u32 = 8,
        reserved: u32 = 12,
        vertex_count: usize = 16,
        triangle_count: usize = 24,
        wedge_count: usize = 32,
    });
    fields!(list, RlvDeviceLevelVulkan {
        struct_size: u32 = 0,
        queue_family: u32 = 4,
        queue_index: u32 = 8,
        reserved: u32 = 12,
        instance: u64 = 16,
        physical_device: u64 = 24,
        device: u64 = 32,
        queue: u64 = 40,
        vertices: u64 = 48,
        triangles: u64 = 56,
        arguments: u64 = 64,
        wedges: u64 = 72,
        wedge_values: u64 = 80,
        face_values: u64 = 88,
    });
    fields!(list, RlvDiffuse {
        id: u64 = 0,
    });
    fields!(list, RlvDiffuseOptions {
        struct_size: u32 = 0,
        spacing: f32 = 4,
        gravity: [f32; 3] = 8,
        has_bounds: u32 = 20,
        low: [f64; 3] = 24,
        high: [f64; 3] = 48,
    });
    fields!(list, RlvDiffuseSettings {
        struct_size: u32 = 0,
        air_min: f32 = 4,
        air_max: f32 = 8,
        crest_min: f32 = 12,
        crest_max: f32 = 16,
        energy_min: f32 = 20,
        energy_max: f32 = 24,
        air_rate: f32 = 28,
        crest_rate: f32 = 32,
        lifetime_min: f32 = 36,
        lifetime_max: f32 = 40,
        spray_below: u32 = 44,
        bubbles_above: u32 = 48,
        buoyancy: f32 = 52,
        drag: f32 = 56,
        steps: u32 = 60,
        most: u32 = 64,
        seed: u32 = 68,
    });
    fields!(list, RlvDiffuseFluid {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        positions: *const f32 = 16,
        position_stride: usize = 24,
        velocities: *const f32 = 32,
        velocity_stride: usize = 40,
    });
    fields!(list, RlvDiffuseInfo {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        frames: u64 = 16,
        births: u64 = 24,
    });
    fields!(list, RlvDiffuseReport {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        born: u64 = 8,
        gone: u64 = 16,
        refused: u64 = 24,
    });
    fields!(list, RlvDiffusePotentials {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        capacity: usize = 8,
        air: *mut f32 = 16,
        crests: *mut f32 = 24,
        energies: *mut f32 = 32,
    });
    fields!(list, RlvDiffuseArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        capacity: usize = 8,
        positions: *mut f32 = 16,
        velocities: *mut f32 = 24,
        ids: *mut u32 = 32,
        kinds: *mut u32 = 40,
        ages: *mut f32 = 48,
        lifetimes: *mut f32 = 56,
        lives: *mut f32 = 64,
    });
    fields!(list, RlvFluid {
        id: u64 = 0,
    });
    fields!(list, RlvFluidOptions {
        struct_size: u32 = 0,
        kernels: u32 = 4,
        spacing: f32 = 8,
        density: f32 = 12,
        viscosity: f32 = 16,
        friction: f32 = 20,
        cohesion: f32 = 24,
        gravity: [f32; 3] = 28,
        max_excess: f32 = 40,
        mean_excess: f32 = 44,
        min_corrections: u32 = 48,
        max_corrections: u32 = 52,
        steps: u32 = 56,
        courant: f32 = 60,
        step: f32 = 64,
        solver: u32 = 68,
        tension: f32 = 72,
    });
    fields!(list, RlvFluidInfo {
        struct_size: u32 = 0,
        channel_count: u32 = 4,
        particle_count: usize = 8,
        wall_count: usize = 16,
        seconds: f64 = 24,
        mass: f32 = 32,
        time_step: f32 = 36,
        momentum: [f32; 3] = 40,
        kinetic_energy: f32 = 52,
    });
    fields!(list, RlvFluidParticles {
        struct_size: u32 = 0,
        lifetime: f32 = 4,
        count: usize = 8,
        points: *const f32 = 16,
        point_stride: usize = 24,
        velocities: *const f32 = 32,
        velocity_stride: usize = 40,
        velocity: [f32; 3] = 48,
        reserved: u32 = 60,
        channels: *const RlvAttributeArrays = 64,
        channel_count: usize = 72,
        channel_stride: usize = 80,
    });
    fields!(list, RlvFluidArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        capacity: usize = 8,
        points: *mut f32 = 16,
        point_stride: usize = 24,
        velocities: *mut f32 = 32,
        velocity_stride: usize = 40,
        numbers: *mut u32 = 48,
        number_stride: usize = 56,
        pressures: *mut f32 = 64,
        pressure_stride: usize = 72,
        densities: *mut f32 = 80,
        density_stride: usize = 88,
        births: *mut f64 = 96,
        birth_stride: usize = 104,
    });
    fields!(list, RlvFluidColliderOptions {
        struct_size: u32 = 0,
        contact: u32 = 4,
        friction: f32 = 8,
        is_container: u32 = 12,
    });
    fields!(list, RlvFluidForce {
        kind: u32 = 0,
        seed: u32 = 4,
        vector: [f32; 3] = 8,
        strength: f32 = 20,
        place: [f64; 3] = 24,
        radius: f32 = 48,
        rate: f32 = 52,
    });
    fields!(list, RlvFluidEmitterOptions {
        struct_size: u32 = 0,
        shape: u32 = 4,
        center: [f64; 3] = 8,
        u: [f32; 3] = 32,
        v: [f32; 3] = 44,
        radius: f32 = 56,
        speed: f32 = 60,
        lifetime: f32 = 64,
        reserved: u32 = 68,
        begin: f64 = 72,
        end: f64 = 80,
        channels: *const RlvAttributeArrays = 88,
        channel_count: usize = 96,
        channel_stride: usize = 104,
    });
    fields!(list, RlvFluidReport {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        seconds: f64 = 8,
        steps: u64 = 16,
        corrections: u64 = 24,
        max_excess: f32 = 32,
        mean_excess: f32 = 36,
        gravity: [f64; 3] = 40,
        host: [f64; 3] = 64,
        forces: [f64; 3] = 88,
        walls: [f64; 3] = 112,
        added: u64 = 136,
        removed: u64 = 144,
        divergence_corrections: u64 = 152,
    });
    fields!(list, RlvFoam {
        id: u64 = 0,
    });
    fields!(list, RlvFoamSettings {
        struct_size: u32 = 0,
        radius: f32 = 4,
        near_depth: f32 = 8,
        spray_n: f32 = 12,
        spray_m: f32 = 16,
        foam_n: f32 = 20,
        foam_m: f32 = 24,
        bubble_n: f32 = 28,
        bubble_m: f32 = 32,
        lifetime_n: f32 = 36,
        lifetime_m: f32 = 40,
        eta_max: f32 = 44,
        eta_n: f32 = 48,
        eta_m: f32 = 52,
        rho_mod: f32 = 56,
        rho_exp: f32 = 60,
        ao_init_sr_fac: f32 = 64,
        ao_sr_inc_fac: f32 = 68,
        ao_passes: u32 = 72,
        ao_s_dens: f32 = 76,
        ao_min_samp: u32 = 80,
        ao_max_samp: u32 = 84,
        ao_max_occl_dist: f32 = 88,
        ao_fluid_opacity: f32 = 92,
        ao_solid_opacity: f32 = 96,
        ao_hemisphere: u32 = 100,
        ao_sh_scale: f32 = 104,
        ao_sh_exp: f32 = 108,
        ao_sh_offset: f32 = 112,
        shadow_red: f32 = 116,
        shadow_green: f32 = 120,
        shadow_blue: f32 = 124,
        irradiance_map: u32 = 128,
        irr_scale: f32 = 132,
        filter: f32 = 136,
        aperture: f32 = 140,
        focus: f32 = 144,
        shutter: f32 = 148,
        shutter_samples: u32 = 152,
    });
    fields!(list, RlvFoamView {
        struct_size: u32 = 0,
        width: u32 = 4,
        height: u32 = 8,
        reserved: u32 = 12,
        eye: [f64; 3] = 16,
        target: [f64; 3] = 40,
        up: [f64; 3] = 64,
        fov: f64 = 88,
        orthographic: f64 = 96,
        solids: *const f32 = 104,
        fluid: *const f32 = 112,
    });
    fields!(list, RlvFoamParticles {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        positions: *const f32 = 16,
        position_stride: usize = 24,
        ids: *const u32 = 32,
        id_stride: usize = 40,
        kinds: *const u32 = 48,
        kind_stride: usize = 56,
        lives: *const f32 = 64,
        life_stride: usize = 72,
        velocities: *const f32 = 80,
        velocity_stride: usize = 88,
    });
    fields!(list, RlvFoamLight {
        struct_size: u32 = 0,
        width: u32 = 4,
        height: u32 = 8,
        up: [f32; 3] = 12,
        radiance: *const f32 = 24,
    });
    fields!(list, RlvFoamLayers {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        intensity: *mut f32 = 8,
        thickness: *mut f32 = 16,
        depth: *mut f32 = 24,
        normal: *mut f32 = 32,
        occlusion: *mut f32 = 40,
        irradiance: *mut f32 = 48,
    });
    fields!(list, RlvGrid {
        id: u64 = 0,
    });
    fields!(list, RlvGridSettings {
        struct_size: u32 = 0,
        voxel: f32 = 4,
        band: f32 = 8,
        radius: f32 = 12,
        value: f32 = 16,
        adaptivity: f32 = 20,
        distance: f32 = 24,
        width: u32 = 28,
        iterations: u32 = 32,
    });
    fields!(list, RlvGridInfo {
        struct_size: u32 = 0,
        kind: u32 = 4,
        grid_class: u32 = 8,
        is_half: u32 = 12,
        is_linear: u32 = 16,
        is_empty: u32 = 20,
        matrix: [f64; 12] = 24,
        voxel_size: [f64; 3] = 120,
        low: [i32; 3] = 144,
        high: [i32; 3] = 156,
        active_voxels: u64 = 168,
        leaf_count: u64 = 176,
        memory_bytes: u64 = 184,
        name: [u8; 256] = 192,
    });
    fields!(list, RlvImprintSettings {
        struct_size: u32 = 0,
        voxels: u32 = 4,
        jitter: f32 = 8,
        seed: u32 = 12,
        max_displacement: f32 = 16,
        share: f32 = 20,
        depth_limit: f32 = 24,
        smoothing: f32 = 28,
        smoothing_passes: u32 = 32,
        sub_steps: u32 = 36,
        culling: u32 = 40,
        compaction: u32 = 44,
        rim: f32 = 48,
        rim_width: f32 = 52,
        repose: f32 = 56,
    });
    fields!(list, RlvImprintMoment {
        struct_size: u32 = 0,
        pair: u32 = 4,
        frame: u64 = 8,
        step: u32 = 16,
        reserved: u32 = 20,
    });
    fields!(list, RlvImprintReport {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        steps: u64 = 8,
        wanted_steps: u64 = 16,
        tested_tiles: u64 = 24,
        tested_coefficients: u64 = 32,
        changed_tiles: u64 = 40,
        changed_coefficients: u64 = 48,
        allocated_tiles: u64 = 56,
        refused_tiles: u64 = 64,
        clamped_rays: u64 = 72,
        triangles: u64 = 80,
        bytes: u64 = 88,
        voxel_diagonal: f64 = 96,
        pushed_volume: f64 = 104,
        raised_volume: f64 = 112,
        open_edges: u64 = 120,
    });
    fields!(list, RlvPicture {
        id: u64 = 0,
    });
    fields!(list, RlvPictureInfo {
        struct_size: u32 = 0,
        format: u32 = 4,
        image_count: u32 = 8,
        face_count: u32 = 12,
        tile_count: u32 = 16,
        meta_count: u32 = 20,
    });
    fields!(list, RlvPictureImage {
        struct_size: u32 = 0,
        content: u32 = 4,
        type_: u32 = 8,
        channels: u32 = 12,
        alpha: u32 = 16,
        width: u32 = 20,
        height: u32 = 24,
        level_count: u32 = 28,
        face: u32 = 32,
        columns: u32 = 36,
        cell: u32 = 40,
        side: u32 = 44,
        gutter: u32 = 48,
        is_layer: u32 = 52,
        blend: u32 = 56,
        is_visible: u32 = 60,
        opacity: f32 = 64,
        reserved: u32 = 68,
        name: [u8; 264] = 72,
    });
    fields!(list, RlvPictureMeta {
        struct_size: u32 = 0,
        type_: u32 = 4,
        count: usize = 8,
        name: *const c_char = 16,
        values: *const c_void = 24,
    });
    fields!(list, RlvProcedural {
        id: u64 = 0,
    });
    fields!(list, RlvProceduralOptions {
        struct_size: u32 = 0,
        coarse: u32 = 4,
        fine: u32 = 8,
        reserved: u32 = 12,
    });
    fields!(list, RlvProceduralInfo {
        struct_size: u32 = 0,
        primitive_count: u32 = 4,
        time_step_count: u32 = 8,
        step: f32 = 12,
        cell_count: u64 = 16,
        bytes: u64 = 24,
        low: [f32; 3] = 32,
        high: [f32; 3] = 44,
    });
    fields!(list, RlvProceduralTable {
        struct_size: u32 = 0,
        primitive_count: u32 = 4,
        time_step_count: u32 = 8,
        reserved: u32 = 12,
        data: *const c_void = 16,
        tiles: *const u32 = 24,
        bounds: RlvProceduralBounds = 32,
        intersect: RlvProceduralIntersect = 40,
        occluded: RlvProceduralOccluded = 48,
    });
    fields!(list, RlvProceduralHits {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        primitives: *const u32 = 16,
        primitive_stride: usize = 24,
        uvs: *const f32 = 32,
        uv_stride: usize = 40,
        times: *const f32 = 48,
        time_stride: usize = 56,
        tiles: *mut u32 = 64,
        tile_stride: usize = 72,
        positions: *mut f32 = 80,
        position_stride: usize = 88,
        normals: *mut f32 = 96,
        normal_stride: usize = 104,
        colors: *mut f32 = 112,
        color_stride: usize = 120,
    });
    fields!(list, RlvPtexOptions {
        struct_size: u32 = 0,
        kind: u32 = 4,
        budget: u64 = 8,
    });
    fields!(list, RlvPtexReport {
        struct_size: u32 = 0,
        channel: u32 = 4,
        face_count: usize = 8,
        constant_count: usize = 16,
        squared_count: usize = 24,
        reduced_count: usize = 32,
        enlarged_count: usize = 40,
        ignored_numbers: usize = 48,
        deviation: f32 = 56,
        reserved: u32 = 60,
    });
    fields!(list, RlvRepairSettings {
        struct_size: u32 = 0,
        weld: u32 = 4,
        tolerance: f32 = 8,
        degenerate: u32 = 12,
        duplicates: u32 = 16,
        orient: u32 = 20,
        split: u32 = 24,
        fill: u32 = 28,
        hole_edges: u32 = 32,
        hole_area: f32 = 36,
        refine: u32 = 40,
        fair: u32 = 44,
        unused: u32 = 48,
        listed: u32 = 52,
    });
    fields!(list, RlvRepairFinding {
        count: usize = 0,
        first: [u32; 16] = 8,
    });
    fields!(list, RlvRepairTopology {
        points: usize = 0,
        faces: usize = 8,
        edges: usize = 16,
        boundary_edges: usize = 24,
        boundary_loops: usize = 32,
        non_manifold_edges: usize = 40,
        components: usize = 48,
        closed_components: usize = 56,
        euler: i32 = 64,
        reserved: u32 = 68,
        area: f64 = 72,
        volume: f64 = 80,
    });
    fields!(list, RlvRepairReport {
        struct_size: u32 = 0,
        is_solid: u32 = 4,
        invalid_faces: RlvRepairFinding = 8,
        coincident_points: RlvRepairFinding = 80,
        unused_points: RlvRepairFinding = 152,
        degenerate_faces: RlvRepairFinding = 224,
        flat_faces: RlvRepairFinding = 296,
        duplicate_faces: RlvRepairFinding = 368,
        non_manifold_edges: RlvRepairFinding = 440,
        non_manifold_points: RlvRepairFinding = 512,
        misoriented_edges: RlvRepairFinding = 584,
        one_sided_edges: RlvRepairFinding = 656,
        inverted_components: RlvRepairFinding = 728,
        holes: RlvRepairFinding = 800,
        open_holes: RlvRepairFinding = 872,
        before: RlvRepairTopology = 944,
        after: RlvRepairTopology = 1032,
        turned_faces: usize = 1120,
        split_points: usize = 1128,
        filled_holes: usize = 1136,
        filling_points: usize = 1144,
        filling_faces: usize = 1152,
        seam_attributes: usize = 1160,
    });
    fields!(list, RlvTissue {
        id: u64 = 0,
    });
    fields!(list, RlvTissueSimulation {
        id: u64 = 0,
    });
    fields!(list, RlvTissueMaterial {
        struct_size: u32 = 0,
        density: f32 = 4,
        name: *const c_char = 8,
        library: *const c_char = 16,
        young: f32 = 24,
        poisson: f32 = 28,
    });
    fields!(list, RlvTissueVolume {
        struct_size: u32 = 0,
        level: u32 = 4,
        name: *const c_char = 8,
        mesh: RlvMesh = 16,
        material: u32 = 24,
        has_layers: u32 = 28,
        is_muscle: u32 = 32,
        stiffness: f32 = 36,
        strength: f32 = 40,
        ring_size: u32 = 44,
        direction: [f64; 3] = 48,
        rings: *const f64 = 72,
        ring_count: usize = 80,
    });
    fields!(list, RlvTissueLayer {
        struct_size: u32 = 0,
        material: u32 = 4,
        start: f32 = 8,
        thickness: f32 = 12,
    });
    fields!(list, RlvTissueSurface {
        struct_size: u32 = 0,
        purpose: u32 = 4,
        name: *const c_char = 8,
        mesh: RlvMesh = 16,
        is_internal: u32 = 24,
        angle: f32 = 28,
    });
    fields!(list, RlvTissueDescription {
        struct_size: u32 = 0,
        samples: u32 = 4,
        cell: [f32; 3] = 8,
        share: f32 = 20,
        materials: *const RlvTissueMaterial = 24,
        material_count: usize = 32,
        material_stride: usize = 40,
        volumes: *const RlvTissueVolume = 48,
        volume_count: usize = 56,
        volume_stride: usize = 64,
        surfaces: *const RlvTissueSurface = 72,
        surface_count: usize = 80,
        surface_stride: usize = 88,
        skin: RlvMesh = 96,
        layers: *const RlvTissueLayer = 104,
        layer_count: usize = 112,
        layer_stride: usize = 120,
        epidermis_material: u32 = 128,
        epidermis_thickness: f32 = 132,
        bend: [f64; 2] = 136,
    });
    fields!(list, RlvTissueLabel {
        struct_size: u32 = 0,
        material: u32 = 4,
        low: f32 = 8,
        high: f32 = 12,
    });
    fields!(list, RlvTissueLabels {
        struct_size: u32 = 0,
        block: u32 = 4,
        share: f32 = 8,
        reserved: u32 = 12,
        materials: *const RlvTissueMaterial = 16,
        material_count: usize = 24,
        material_stride: usize = 32,
        labels: *const RlvTissueLabel = 40,
        label_count: usize = 48,
        label_stride: usize = 56,
    });
    fields!(list, RlvTissueReport {
        struct_size: u32 = 0,
        voxels: [u32; 3] = 4,
        volume: f64 = 16,
    });
    fields!(list, RlvTissueInfo {
        struct_size: u32 = 0,
        has_cells: u32 = 4,
        node_count: usize = 8,
        element_count: usize = 16,
        cell: [f32; 3] = 24,
        low: [f32; 3] = 36,
        high: [f32; 3] = 48,
        material_count: u32 = 60,
        muscle_count: u32 = 64,
        set_count: u32 = 68,
        bound_count: u32 = 72,
        checksum: u32 = 76,
    });
    fields!(list, RlvTissueMuscle {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        stiffness: f32 = 8,
        strength: f32 = 12,
        name: [u8; 48] = 16,
    });
    fields!(list, RlvTissueSet {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        count: usize = 8,
        name: [u8; 48] = 16,
    });
    fields!(list, RlvTissueOptions {
        struct_size: u32 = 0,
        halvings: u32 = 4,
        gravity: [f32; 3] = 8,
        damping: f32 = 20,
        step: f32 = 24,
        safety: f32 = 28,
        hourglass: f32 = 32,
        mass_scaling: f32 = 36,
        self_friction: f32 = 40,
    });
    fields!(list, RlvTissueSimulationInfo {
        struct_size: u32 = 0,
        stiffest_element: u32 = 4,
        step: f32 = 8,
        stable_step: f32 = 12,
        added_mass: f32 = 16,
        reserved: u32 = 20,
        steps: u64 = 24,
        seconds: f64 = 32,
        halved: u64 = 40,
    });
    fields!(list, RlvTissueEnergies {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        kinetic: f64 = 8,
        elastic: f64 = 16,
        potential: f64 = 24,
    });
    fields!(list, RlvTissueRelaxation {
        struct_size: u32 = 0,
        is_at_rest: u32 = 4,
        steps: u64 = 8,
        unbalanced: f32 = 16,
        largest: f32 = 20,
    });
    fields!(list, RlvTissueCollider {
        struct_size: u32 = 0,
        body: u32 = 4,
        mesh: RlvMesh = 8,
        radius: f32 = 16,
        friction: f32 = 20,
        times: *const f64 = 24,
        translations: *const f32 = 32,
        rotations: *const f32 = 40,
        key_count: usize = 48,
    });
    fields!(list, RlvTissueArrays {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        node_count: usize = 8,
        positions: *mut f32 = 16,
        velocities: *mut f32 = 24,
        element_count: usize = 32,
        stresses: *mut f32 = 40,
        principal_stresses: *mut f32 = 48,
        von_mises: *mut f32 = 56,
        volumes: *mut f32 = 64,
        fibre_stretches: *mut f32 = 72,
        strains: *mut f32 = 80,
        principal_strains: *mut f32 = 88,
        contact_pressures: *mut f32 = 96,
    });
    fields!(list, RlvJob {
        id: u64 = 0,
    });
    fields!(list, RlvJobInfo {
        struct_size: u32 = 0,
        state: u32 = 4,
        result: RlvResult = 8,
        fraction: f32 = 12,
        stage: [u8; 48] = 16,
        kind: u32 = 64,
    });
    fields!(list, RlvObjectInfo {
        struct_size: u32 = 0,
        is_busy: u32 = 4,
        noun: [u8; 48] = 8,
        worker: [u8; 48] = 56,
    });
    fields!(list, RlvShader {
        id: u64 = 0,
    });
    fields!(list, RlvShaderOptions {
        struct_size: u32 = 0,
        language: u32 = 4,
        stage: u32 = 8,
        reserved: u32 = 12,
        name: *const c_char = 16,
    });
    fields!(list, RlvShaderVariable {
        struct_size: u32 = 0,
        components: u32 = 4,
        declared: u32 = 8,
        is_initialized: u32 = 12,
        line: u32 = 16,
        column: u32 = 20,
        scope_start: u64 = 24,
        scope_end: u64 = 32,
        name: [u8; 48] = 40,
        label: [u8; 48] = 88,
        function: [u8; 48] = 136,
        description: [u8; 256] = 184,
    });
    fields!(list, RlvShaderLayout {
        struct_size: u32 = 0,
        group: u32 = 4,
        examples_binding: u32 = 8,
        log_binding: u32 = 12,
        feature_count: u32 = 16,
        accumulation: u32 = 20,
        site_count: u32 = 24,
        uses_confidence: u32 = 28,
        examples_head: u32 = 32,
        log_head: u32 = 36,
    });
    fields!(list, RlvShaderFeature {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        name: [u8; 256] = 8,
        expression: [u8; 256] = 264,
        description: [u8; 256] = 520,
    });
    fields!(list, RlvShaderExamples {
        struct_size: u32 = 0,
        feature_count: u32 = 4,
        count: usize = 8,
        classes: *const u32 = 16,
        class_stride: usize = 24,
        vectors: *const f32 = 32,
        vector_stride: usize = 40,
        exponent: f32 = 48,
        is_scaled: u32 = 52,
    });
    fields!(list, RlvSubdivision {
        id: u64 = 0,
    });
    fields!(list, RlvSubdivisionOptions {
        struct_size: u32 = 0,
        scheme: u32 = 4,
        boundary: u32 = 8,
        face_varying: u32 = 12,
        creasing: u32 = 16,
        triangle_rule: u32 = 20,
        isolation: u32 = 24,
        reserved: u32 = 28,
    });
    fields!(list, RlvSubdivisionInfo {
        struct_size: u32 = 0,
        scheme: u32 = 4,
        point_count: usize = 8,
        face_count: usize = 16,
        tile_count: usize = 24,
    });
    fields!(list, RlvSubdivisionArrays {
        struct_size: u32 = 0,
        point_rule: u32 = 4,
        count: usize = 8,
        tiles: *const u32 = 16,
        tile_stride: usize = 24,
        uvs: *const f32 = 32,
        uv_stride: usize = 40,
        values: *mut f32 = 48,
        value_stride: usize = 56,
        du: *mut f32 = 64,
        du_stride: usize = 72,
        dv: *mut f32 = 80,
        dv_stride: usize = 88,
        duu: *mut f32 = 96,
        duu_stride: usize = 104,
        duv: *mut f32 = 112,
        duv_stride: usize = 120,
        dvv: *mut f32 = 128,
        dvv_stride: usize = 136,
    });
    fields!(list, RlvVulkanDevice {
        struct_size: u32 = 0,
        api_version: u32 = 4,
        queue_family: u32 = 8,
        queue_index: u32 = 12,
        instance: u64 = 16,
        physical_device: u64 = 24,
        device: u64 = 32,
        loader: RlvVulkanLoader = 40,
        features: *const c_void = 48,
        lock: RlvVulkanNotice = 56,
        unlock: RlvVulkanNotice = 64,
        released: RlvVulkanNotice = 72,
        user: *mut c_void = 80,
    });
    fields!(list, RlvVulkanBuffers {
        struct_size: u32 = 0,
        reserved: u32 = 4,
        points: u64 = 8,
        point_bytes: u64 = 16,
        triangles: u64 = 24,
        triangle_bytes: u64 = 32,
    });
}

pub const INITIAL: &[Initial] = &[
    Initial { header: "allocator.h", name: "RlvAllocatorInfo", initializer: "RLV_ALLOCATOR_INFO_INIT", fields: &[
        ("uint32_t is_set", 0.0),
        ("uint64_t bytes", 0.0),
        ("uint64_t limit", 0.0),
    ] },
    Initial { header: "progressive.h", name: "RlvProgressiveInfo", initializer: "RLV_PROGRESSIVE_INFO_INIT", fields: &[
        ("uint32_t attribute_count", 0.0),
        ("size_t vertex_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("size_t base_vertex_count", 0.0),
        ("size_t base_triangle_count", 0.0),
        ("size_t bytes", 0.0),
        ("size_t wedge_count", 0.0),
        ("uint32_t wedge_width", 0.0),
        ("uint32_t face_width", 0.0),
    ] },
    Initial { header: "arrival.h", name: "RlvArrivalInfo", initializer: "RLV_ARRIVAL_INFO_INIT", fields: &[
        ("uint32_t is_complete", 0.0),
        ("size_t triangle_count", 0.0),
    ] },
    Initial { header: "surface.h", name: "RlvSurfaceOptions", initializer: "RLV_SURFACE_OPTIONS_INIT", fields: &[
        ("uint32_t boundary", 0.0),
        ("uint32_t isolation", 0.0),
        ("uint32_t patch_limit", 0.0),
        ("uint32_t kind", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "detail.h", name: "RlvDetailInfo", initializer: "RLV_DETAIL_INFO_INIT", fields: &[
        ("uint32_t is_painted", 0.0),
        ("size_t tile_count", 0.0),
        ("size_t allocated_count", 0.0),
        ("uint64_t revision", 0.0),
        ("uint64_t bytes", 0.0),
        ("uint64_t full_bytes", 0.0),
        ("uint64_t budget", 0.0),
        ("size_t painted_count", 0.0),
        ("uint64_t paint_bytes", 0.0),
        ("uint64_t paint_budget", 0.0),
        ("double time", 0.0),
        ("uint64_t stamp_bytes", 0.0),
    ] },
    Initial { header: "detail.h", name: "RlvChannelInfo", initializer: "RLV_CHANNEL_INFO_INIT", fields: &[
        ("uint32_t is_there", 0.0),
        ("size_t allocated_count", 0.0),
        ("uint64_t bytes", 0.0),
        ("uint64_t full_bytes", 0.0),
        ("uint64_t budget", 0.0),
        ("uint32_t texel_size", 0.0),
        ("uint32_t paged_count", 0.0),
    ] },
    Initial { header: "detail.h", name: "RlvDetailFolds", initializer: "RLV_DETAIL_FOLDS_INIT", fields: &[
        ("uint32_t tile", 0.0),
        ("uint64_t triangle_count", 0.0),
        ("uint64_t folded_count", 0.0),
    ] },
    Initial { header: "detail.h", name: "RlvVectorOptions", initializer: "RLV_VECTOR_OPTIONS_INIT", fields: &[
        ("uint32_t tile_size", 0.0),
        ("uint64_t budget", 0.0),
    ] },
    Initial { header: "detail.h", name: "RlvDecayOptions", initializer: "RLV_DECAY_OPTIONS_INIT", fields: &[
        ("float delay", 0.0),
        ("float duration", 10.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t budget", 0.0),
    ] },
    Initial { header: "bake.h", name: "RlvBakeReport", initializer: "RLV_BAKE_REPORT_INIT", fields: &[
        ("uint32_t picture_count", 0.0),
        ("uint64_t covered_pixels", 0.0),
        ("uint64_t gutter_pixels", 0.0),
        ("uint64_t overlapping_pixels", 0.0),
        ("size_t flat_tiles", 0.0),
        ("size_t outside_count", 0.0),
        ("float scale", 0.0),
        ("float mid_level", 0.0),
    ] },
    Initial { header: "brush.h", name: "RlvBrushSettings", initializer: "RLV_BRUSH_SETTINGS_INIT", fields: &[
        ("float radius", 0.1),
        ("float depth", 1.0),
        ("float spacing", 0.25),
        ("float strength", 1.0),
        ("float strength_pressure", 1.0),
        ("float size_pressure", 0.0),
        ("float angle", 0.0),
        ("float angle_pressure", 0.0),
        ("float jitter_position", 0.0),
        ("float jitter_size", 0.0),
        ("float jitter_strength", 0.0),
        ("float jitter_angle", 0.0),
        ("uint32_t seed", 0.0),
        ("float string", 0.0),
        ("float rate", 0.0),
        ("uint32_t symmetry_x", 0.0),
        ("uint32_t symmetry_y", 0.0),
        ("uint32_t symmetry_z", 0.0),
        ("float reach", 2.0),
        ("uint32_t level", 0.0),
    ] },
    Initial { header: "brush.h", name: "RlvStampSettings", initializer: "RLV_STAMP_SETTINGS_INIT", fields: &[
        ("float angle", 0.0),
        ("float repeat", 1.0),
        ("uint32_t mirror", 0.0),
        ("uint32_t alternate", 0.0),
        ("float mid", 0.5),
        ("float scale", 2.0),
    ] },
    Initial { header: "tessellate.h", name: "RlvTessellateOptions", initializer: "RLV_TESSELLATE_OPTIONS_INIT", fields: &[
        ("uint32_t coarse", 0.0),
        ("uint32_t fine", 0.0),
        ("uint32_t places", 0.0),
        ("uint32_t smooth_uvs", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "tessellate.h", name: "RlvTessellationInfo", initializer: "RLV_TESSELLATION_INFO_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("size_t point_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("uint64_t revision", 0.0),
    ] },
    Initial { header: "buffer.h", name: "RlvBufferInfo", initializer: "RLV_BUFFER_INFO_INIT", fields: &[
        ("uint32_t rebuilt", 0.0),
        ("size_t point_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("size_t written_count", 0.0),
        ("uint64_t bytes", 0.0),
    ] },
    Initial { header: "buffer.h", name: "RlvBufferVulkan", initializer: "RLV_BUFFER_VULKAN_INIT", fields: &[
        ("uint32_t queue_family", 0.0),
        ("uint32_t queue_index", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t instance", 0.0),
        ("uint64_t physical_device", 0.0),
        ("uint64_t device", 0.0),
        ("uint64_t queue", 0.0),
        ("uint64_t points", 0.0),
        ("uint64_t triangles", 0.0),
    ] },
    Initial { header: "isosurface.h", name: "RlvIsosurfaceOptions", initializer: "RLV_ISOSURFACE_OPTIONS_INIT", fields: &[
        ("uint32_t function", 1.0),
        ("float radius", 0.01),
        ("float support", 0.0),
        ("float sharpness", 8.0),
        ("float iso", 0.6),
        ("float centring", 0.9),
        ("float shutter_open", 0.0),
        ("float shutter_close", 0.0),
        ("float march_steps", 12.0),
    ] },
    Initial { header: "isosurface.h", name: "RlvIsosurfaceInfo", initializer: "RLV_ISOSURFACE_INFO_INIT", fields: &[
        ("uint32_t has_velocities", 0.0),
        ("size_t particle_count", 0.0),
        ("float support", 0.0),
        ("float reach", 0.0),
        ("float influence", 0.0),
        ("float reserved", 0.0),
    ] },
    Initial { header: "isosurface.h", name: "RlvIsosurfaceClasses", initializer: "RLV_ISOSURFACE_CLASSES_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("size_t surface_count", 0.0),
        ("size_t blind_count", 0.0),
        ("size_t hidden_count", 0.0),
        ("double kept", 0.0),
    ] },
    Initial { header: "particles.h", name: "RlvParticlesInfo", initializer: "RLV_PARTICLES_INFO_INIT", fields: &[
        ("uint32_t channel_count", 0.0),
        ("size_t count", 0.0),
        ("uint32_t has_numbers", 0.0),
        ("uint32_t has_time", 0.0),
        ("double time", 0.0),
        ("float spacing", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "collider.h", name: "RlvToolSettings", initializer: "RLV_TOOL_SETTINGS_INIT", fields: &[
        ("float stiffness", 1.0),
        ("float max_depth", 1.0),
    ] },
    Initial { header: "color_buffer.h", name: "RlvColorBufferVulkan", initializer: "RLV_COLOR_BUFFER_VULKAN_INIT", fields: &[
        ("uint32_t queue_family", 0.0),
        ("uint32_t queue_index", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t instance", 0.0),
        ("uint64_t physical_device", 0.0),
        ("uint64_t device", 0.0),
        ("uint64_t queue", 0.0),
        ("uint64_t tiles", 0.0),
        ("uint64_t texels", 0.0),
        ("uint64_t mip_firsts", 0.0),
        ("uint64_t mips", 0.0),
    ] },
    Initial { header: "crowd.h", name: "RlvCrowdBuildSettings", initializer: "RLV_CROWD_BUILD_SETTINGS_INIT", fields: &[
        ("float pose_distance", 0.15),
        ("uint32_t cluster_triangles", 100.0),
        ("uint32_t group_clusters", 16.0),
        ("float pose_rate", 30.0),
    ] },
    Initial { header: "crowd.h", name: "RlvCrowdRefitReport", initializer: "RLV_CROWD_REFIT_REPORT_INIT", fields: &[
        ("uint32_t grown_groups", 0.0),
        ("double growth", 0.0),
        ("uint32_t is_rebuild_due", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "crowd.h", name: "RlvCrowdFrame", initializer: "RLV_CROWD_FRAME_INIT", fields: &[
        ("uint32_t agent_count", 0.0),
        ("uint32_t draw_count", 0.0),
        ("uint32_t matrix_count", 0.0),
        ("uint32_t changed", 0.0),
        ("uint32_t hidden", 0.0),
        ("uint64_t clusters", 0.0),
        ("uint64_t triangles", 0.0),
        ("uint64_t hidden_triangles", 0.0),
        ("uint64_t occluder_triangles", 0.0),
        ("uint32_t weight_count", 0.0),
        ("uint32_t impostor_count", 0.0),
        ("uint32_t picture_count", 0.0),
        ("uint32_t hidden_clusters", 0.0),
    ] },
    Initial { header: "crowd_stream.h", name: "RlvCrowdStreamSettings", initializer: "RLV_CROWD_STREAM_SETTINGS_INIT", fields: &[
        ("uint32_t most_read", 1024.0),
        ("uint64_t budget", 67108864.0),
    ] },
    Initial { header: "crowd_stream.h", name: "RlvCrowdStreamInfo", initializer: "RLV_CROWD_STREAM_INFO_INIT", fields: &[
        ("uint32_t slot_triangles", 0.0),
        ("uint32_t slot_count", 0.0),
        ("uint32_t resident", 0.0),
        ("uint32_t read", 0.0),
        ("uint32_t dropped", 0.0),
        ("uint32_t missing", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t wanted_triangles", 0.0),
    ] },
    Initial { header: "document.h", name: "RlvDocumentInfo", initializer: "RLV_DOCUMENT_INFO_INIT", fields: &[
        ("uint32_t is_open", 0.0),
        ("size_t undo_count", 0.0),
        ("size_t redo_count", 0.0),
        ("uint64_t bytes", 0.0),
    ] },
    Initial { header: "document.h", name: "RlvDocumentChanges", initializer: "RLV_DOCUMENT_CHANGES_INIT", fields: &[
        ("uint32_t is_done", 0.0),
        ("size_t layer_count", 0.0),
        ("size_t block_count", 0.0),
        ("uint64_t bytes", 0.0),
    ] },
    Initial { header: "document.h", name: "RlvTransferReport", initializer: "RLV_TRANSFER_REPORT_INIT", fields: &[
        ("uint32_t layer_count", 0.0),
        ("double area", 0.0),
        ("double uncovered_area", 0.0),
        ("double edited_area", 0.0),
        ("double lost_area", 0.0),
        ("double reach", 0.0),
    ] },
    Initial { header: "layer.h", name: "RlvLayerOptions", initializer: "RLV_LAYER_OPTIONS_INIT", fields: &[
        ("uint32_t kind", 0.0),
        ("uint32_t blend", 1.0),
        ("uint32_t is_visible", 1.0),
        ("float opacity", 1.0),
        ("uint32_t tile_size", 0.0),
    ] },
    Initial { header: "decal.h", name: "RlvDecalQuality", initializer: "RLV_DECAL_QUALITY_INIT", fields: &[
        ("uint32_t pin_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("size_t flip_count", 0.0),
        ("size_t overlap_count", 0.0),
        ("double l2", 0.0),
        ("double l_infinity", 0.0),
        ("double worst_angle", 0.0),
        ("double area_ratio", 0.0),
        ("double coverage", 0.0),
        ("double doubled", 0.0),
    ] },
    Initial { header: "decal.h", name: "RlvDecalInk", initializer: "RLV_DECAL_INK_INIT", fields: &[
        ("uint32_t channel", 1.0),
        ("uint32_t blend", 0.0),
        ("float opacity", 1.0),
        ("float height", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "decal.h", name: "RlvDecalReport", initializer: "RLV_DECAL_REPORT_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t changed_tiles", 0.0),
        ("uint64_t texels", 0.0),
        ("uint64_t refused_tiles", 0.0),
    ] },
    Initial { header: "decal.h", name: "RlvDecalRecipe", initializer: "RLV_DECAL_RECIPE_INIT", fields: &[
        ("uint32_t id", 0.0),
        ("uint32_t layer", 0.0),
        ("uint32_t pin_count", 0.0),
        ("uint32_t width", 0.0),
        ("uint32_t height", 0.0),
        ("uint32_t channel", 0.0),
        ("uint32_t blend", 0.0),
        ("float opacity", 0.0),
        ("float relief", 0.0),
        ("uint64_t image_hash", 0.0),
    ] },
    Initial { header: "device_crowd.h", name: "RlvDeviceCrowdInfo", initializer: "RLV_DEVICE_CROWD_INFO_INIT", fields: &[
        ("uint32_t agent_count", 0.0),
        ("uint32_t draw_count", 0.0),
        ("uint32_t matrix_count", 0.0),
        ("uint32_t weight_count", 0.0),
        ("uint32_t impostor_count", 0.0),
        ("uint32_t picture_count", 0.0),
        ("uint32_t hidden", 0.0),
        ("uint64_t hidden_triangles", 0.0),
        ("uint64_t occluder_triangles", 0.0),
        ("uint32_t hidden_clusters", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "device_crowd.h", name: "RlvDeviceCrowdVulkan", initializer: "RLV_DEVICE_CROWD_VULKAN_INIT", fields: &[
        ("uint32_t queue_family", 0.0),
        ("uint32_t queue_index", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t instance", 0.0),
        ("uint64_t physical_device", 0.0),
        ("uint64_t device", 0.0),
        ("uint64_t queue", 0.0),
        ("uint64_t draws", 0.0),
        ("uint64_t clusters", 0.0),
        ("uint64_t instances", 0.0),
        ("uint64_t counts", 0.0),
        ("uint64_t matrices", 0.0),
        ("uint64_t weights", 0.0),
        ("uint64_t blends", 0.0),
    ] },
    Initial { header: "stroke.h", name: "RlvStrokeReport", initializer: "RLV_STROKE_REPORT_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t dabs", 0.0),
        ("uint64_t missed_dabs", 0.0),
        ("uint64_t tested_tiles", 0.0),
        ("uint64_t tested_texels", 0.0),
        ("uint64_t changed_tiles", 0.0),
        ("uint64_t changed_texels", 0.0),
        ("uint64_t allocated_tiles", 0.0),
        ("uint64_t freed_tiles", 0.0),
        ("uint64_t refused_tiles", 0.0),
        ("uint64_t bytes", 0.0),
    ] },
    Initial { header: "level.h", name: "RlvLevelInfo", initializer: "RLV_LEVEL_INFO_INIT", fields: &[
        ("uint32_t undo_count", 0.0),
        ("uint32_t redo_count", 0.0),
        ("uint32_t reserved", 0.0),
        ("size_t vertex_count", 0.0),
        ("size_t triangle_count", 0.0),
    ] },
    Initial { header: "level.h", name: "RlvLevelSculpted", initializer: "RLV_LEVEL_SCULPTED_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t dabs", 0.0),
        ("uint64_t missed_dabs", 0.0),
        ("uint64_t vertices", 0.0),
    ] },
    Initial { header: "level.h", name: "RlvLevelUpdate", initializer: "RLV_LEVEL_UPDATE_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("size_t vertex_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("size_t first_vertex", 0.0),
        ("size_t changed_vertex_count", 0.0),
        ("size_t first_triangle", 0.0),
        ("size_t changed_triangle_count", 0.0),
        ("size_t wedge_count", 0.0),
        ("size_t first_wedge", 0.0),
        ("size_t changed_wedge_count", 0.0),
    ] },
    Initial { header: "device_level.h", name: "RlvDeviceLevelInfo", initializer: "RLV_DEVICE_LEVEL_INFO_INIT", fields: &[
        ("uint32_t undo_count", 0.0),
        ("uint32_t redo_count", 0.0),
        ("uint32_t reserved", 0.0),
        ("size_t vertex_count", 0.0),
        ("size_t triangle_count", 0.0),
        ("size_t wedge_count", 0.0),
    ] },
    Initial { header: "device_level.h", name: "RlvDeviceLevelVulkan", initializer: "RLV_DEVICE_LEVEL_VULKAN_INIT", fields: &[
        ("uint32_t queue_family", 0.0),
        ("uint32_t queue_index", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t instance", 0.0),
        ("uint64_t physical_device", 0.0),
        ("uint64_t device", 0.0),
        ("uint64_t queue", 0.0),
        ("uint64_t vertices", 0.0),
        ("uint64_t triangles", 0.0),
        ("uint64_t arguments", 0.0),
        ("uint64_t wedges", 0.0),
        ("uint64_t wedge_values", 0.0),
        ("uint64_t face_values", 0.0),
    ] },
    Initial { header: "diffuse.h", name: "RlvDiffuseSettings", initializer: "RLV_DIFFUSE_SETTINGS_INIT", fields: &[
        ("float air_min", 5.0),
        ("float air_max", 20.0),
        ("float crest_min", 2.0),
        ("float crest_max", 8.0),
        ("float energy_min", 5.0),
        ("float energy_max", 50.0),
        ("float air_rate", 4000.0),
        ("float crest_rate", 4000.0),
        ("float lifetime_min", 2.0),
        ("float lifetime_max", 5.0),
        ("uint32_t spray_below", 6.0),
        ("uint32_t bubbles_above", 20.0),
        ("float buoyancy", 2.0),
        ("float drag", 0.8),
        ("uint32_t steps", 2.0),
        ("uint32_t most", 100000000.0),
        ("uint32_t seed", 1.0),
    ] },
    Initial { header: "diffuse.h", name: "RlvDiffuseInfo", initializer: "RLV_DIFFUSE_INFO_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("size_t count", 0.0),
        ("uint64_t frames", 0.0),
        ("uint64_t births", 0.0),
    ] },
    Initial { header: "diffuse.h", name: "RlvDiffuseReport", initializer: "RLV_DIFFUSE_REPORT_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t born", 0.0),
        ("uint64_t gone", 0.0),
        ("uint64_t refused", 0.0),
    ] },
    Initial { header: "fluid.h", name: "RlvFluidColliderOptions", initializer: "RLV_FLUID_COLLIDER_OPTIONS_INIT", fields: &[
        ("uint32_t contact", 0.0),
        ("float friction", 0.0),
        ("uint32_t is_container", 0.0),
    ] },
    Initial { header: "foam.h", name: "RlvFoamSettings", initializer: "RLV_FOAM_SETTINGS_INIT", fields: &[
        ("float radius", 0.01),
        ("float near_depth", 0.05),
        ("float spray_n", 1.5),
        ("float spray_m", 1.0),
        ("float foam_n", 2.25),
        ("float foam_m", 1.0),
        ("float bubble_n", 2.0),
        ("float bubble_m", 1.0),
        ("float lifetime_n", 2.0),
        ("float lifetime_m", 0.4),
        ("float eta_max", 0.5),
        ("float eta_n", 1.0),
        ("float eta_m", 2.0),
        ("float rho_mod", 3.0),
        ("float rho_exp", 1.25),
        ("float ao_init_sr_fac", 1.0),
        ("float ao_sr_inc_fac", 7.0),
        ("uint32_t ao_passes", 3.0),
        ("float ao_s_dens", 0.5),
        ("uint32_t ao_min_samp", 16.0),
        ("uint32_t ao_max_samp", 512.0),
        ("float ao_max_occl_dist", 5.0),
        ("float ao_fluid_opacity", 0.5),
        ("float ao_solid_opacity", 1.0),
        ("uint32_t ao_hemisphere", 1.0),
        ("float ao_sh_scale", 1.0),
        ("float ao_sh_exp", 1.5),
        ("float ao_sh_offset", -0.05),
        ("float shadow_red", 0.0),
        ("float shadow_green", 0.0),
        ("float shadow_blue", 0.2),
        ("uint32_t irradiance_map", 1.0),
        ("float irr_scale", 1.0),
        ("float filter", 1.5),
        ("float aperture", 0.0),
        ("float focus", 10.0),
        ("float shutter", 0.0),
        ("uint32_t shutter_samples", 8.0),
    ] },
    Initial { header: "grid.h", name: "RlvGridSettings", initializer: "RLV_GRID_SETTINGS_INIT", fields: &[
        ("float voxel", 0.1),
        ("float band", 3.0),
        ("float radius", 0.0),
        ("float value", 0.0),
        ("float adaptivity", 0.0),
        ("float distance", 0.0),
        ("uint32_t width", 1.0),
        ("uint32_t iterations", 1.0),
    ] },
    Initial { header: "imprint.h", name: "RlvImprintSettings", initializer: "RLV_IMPRINT_SETTINGS_INIT", fields: &[
        ("uint32_t voxels", 16777216.0),
        ("float jitter", 0.09817477),
        ("uint32_t seed", 0.0),
        ("float max_displacement", 1.0),
        ("float share", 1.0),
        ("float depth_limit", 60000.0),
        ("float smoothing", 0.0),
        ("uint32_t smoothing_passes", 1.0),
        ("uint32_t sub_steps", 256.0),
        ("uint32_t culling", 1.0),
        ("uint32_t compaction", 1.0),
        ("float rim", 0.0),
        ("float rim_width", 0.1),
        ("float repose", 0.6),
    ] },
    Initial { header: "imprint.h", name: "RlvImprintMoment", initializer: "RLV_IMPRINT_MOMENT_INIT", fields: &[
        ("uint32_t pair", 0.0),
        ("uint64_t frame", 0.0),
        ("uint32_t step", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "imprint.h", name: "RlvImprintReport", initializer: "RLV_IMPRINT_REPORT_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t steps", 0.0),
        ("uint64_t wanted_steps", 0.0),
        ("uint64_t tested_tiles", 0.0),
        ("uint64_t tested_coefficients", 0.0),
        ("uint64_t changed_tiles", 0.0),
        ("uint64_t changed_coefficients", 0.0),
        ("uint64_t allocated_tiles", 0.0),
        ("uint64_t refused_tiles", 0.0),
        ("uint64_t clamped_rays", 0.0),
        ("uint64_t triangles", 0.0),
        ("uint64_t bytes", 0.0),
        ("double voxel_diagonal", 0.0),
        ("double pushed_volume", 0.0),
        ("double raised_volume", 0.0),
        ("uint64_t open_edges", 0.0),
    ] },
    Initial { header: "picture.h", name: "RlvPictureInfo", initializer: "RLV_PICTURE_INFO_INIT", fields: &[
        ("uint32_t format", 0.0),
        ("uint32_t image_count", 0.0),
        ("uint32_t face_count", 0.0),
        ("uint32_t tile_count", 0.0),
        ("uint32_t meta_count", 0.0),
    ] },
    Initial { header: "procedural.h", name: "RlvProceduralOptions", initializer: "RLV_PROCEDURAL_OPTIONS_INIT", fields: &[
        ("uint32_t coarse", 0.0),
        ("uint32_t fine", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "ptex.h", name: "RlvPtexOptions", initializer: "RLV_PTEX_OPTIONS_INIT", fields: &[
        ("uint32_t kind", 0.0),
        ("uint64_t budget", 0.0),
    ] },
    Initial { header: "ptex.h", name: "RlvPtexReport", initializer: "RLV_PTEX_REPORT_INIT", fields: &[
        ("uint32_t channel", 0.0),
        ("size_t face_count", 0.0),
        ("size_t constant_count", 0.0),
        ("size_t squared_count", 0.0),
        ("size_t reduced_count", 0.0),
        ("size_t enlarged_count", 0.0),
        ("size_t ignored_numbers", 0.0),
        ("float deviation", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "repair.h", name: "RlvRepairSettings", initializer: "RLV_REPAIR_SETTINGS_INIT", fields: &[
        ("uint32_t weld", 1.0),
        ("float tolerance", 0.0),
        ("uint32_t degenerate", 1.0),
        ("uint32_t duplicates", 1.0),
        ("uint32_t orient", 1.0),
        ("uint32_t split", 1.0),
        ("uint32_t fill", 1.0),
        ("uint32_t hole_edges", 0.0),
        ("float hole_area", 0.75),
        ("uint32_t refine", 1.0),
        ("uint32_t fair", 1.0),
        ("uint32_t unused", 1.0),
        ("uint32_t listed", 8.0),
    ] },
    Initial { header: "tissue.h", name: "RlvTissueLayer", initializer: "RLV_TISSUE_LAYER_INIT", fields: &[
        ("uint32_t material", 0.0),
        ("float start", 0.0),
        ("float thickness", 0.0),
    ] },
    Initial { header: "tissue.h", name: "RlvTissueLabel", initializer: "RLV_TISSUE_LABEL_INIT", fields: &[
        ("uint32_t material", 0.0),
        ("float low", 0.0),
        ("float high", 0.0),
    ] },
    Initial { header: "tissue.h", name: "RlvTissueSimulationInfo", initializer: "RLV_TISSUE_SIMULATION_INFO_INIT", fields: &[
        ("uint32_t stiffest_element", 0.0),
        ("float step", 0.0),
        ("float stable_step", 0.0),
        ("float added_mass", 0.0),
        ("uint32_t reserved", 0.0),
        ("uint64_t steps", 0.0),
        ("double seconds", 0.0),
        ("uint64_t halved", 0.0),
    ] },
    Initial { header: "tissue.h", name: "RlvTissueEnergies", initializer: "RLV_TISSUE_ENERGIES_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("double kinetic", 0.0),
        ("double elastic", 0.0),
        ("double potential", 0.0),
    ] },
    Initial { header: "tissue.h", name: "RlvTissueRelaxation", initializer: "RLV_TISSUE_RELAXATION_INIT", fields: &[
        ("uint32_t is_at_rest", 0.0),
        ("uint64_t steps", 0.0),
        ("float unbalanced", 0.0),
        ("float largest", 0.0),
    ] },
    Initial { header: "shader.h", name: "RlvShaderLayout", initializer: "RLV_SHADER_LAYOUT_INIT", fields: &[
        ("uint32_t group", 0.0),
        ("uint32_t examples_binding", 0.0),
        ("uint32_t log_binding", 0.0),
        ("uint32_t feature_count", 0.0),
        ("uint32_t accumulation", 0.0),
        ("uint32_t site_count", 0.0),
        ("uint32_t uses_confidence", 0.0),
        ("uint32_t examples_head", 0.0),
        ("uint32_t log_head", 0.0),
    ] },
    Initial { header: "subdivision.h", name: "RlvSubdivisionOptions", initializer: "RLV_SUBDIVISION_OPTIONS_INIT", fields: &[
        ("uint32_t scheme", 0.0),
        ("uint32_t boundary", 0.0),
        ("uint32_t face_varying", 1.0),
        ("uint32_t creasing", 0.0),
        ("uint32_t triangle_rule", 0.0),
        ("uint32_t isolation", 0.0),
        ("uint32_t reserved", 0.0),
    ] },
    Initial { header: "subdivision.h", name: "RlvSubdivisionInfo", initializer: "RLV_SUBDIVISION_INFO_INIT", fields: &[
        ("uint32_t scheme", 0.0),
        ("size_t point_count", 0.0),
        ("size_t face_count", 0.0),
        ("size_t tile_count", 0.0),
    ] },
    Initial { header: "vulkan.h", name: "RlvVulkanBuffers", initializer: "RLV_VULKAN_BUFFERS_INIT", fields: &[
        ("uint32_t reserved", 0.0),
        ("uint64_t points", 0.0),
        ("uint64_t point_bytes", 0.0),
        ("uint64_t triangles", 0.0),
        ("uint64_t triangle_bytes", 0.0),
    ] },
];

pub const NAMES: &[&str] = &[
    "RLV_ADAPTER_DISCRETE",
    "RLV_ADAPTER_INTEGRATED",
    "RLV_ADAPTER_SOFTWARE",
    "RLV_ADAPTER_VIRTUAL",
    "RLV_ALLOCATOR_INFO_INIT",
    "RLV_ALLOCATOR_INIT",
    "RLV_API",
    "RLV_ARRIVAL_INFO_INIT",
    "RLV_ATTRIBUTE_ARRAYS_INIT",
    "RLV_ATTRIBUTE_INFO_INIT",
    "RLV_BAKE_COLOR",
    "RLV_BAKE_CONTACT",
    "RLV_BAKE_DEPTH",
    "RLV_BAKE_DIRECTX",
    "RLV_BAKE_DISPLACEMENT",
    "RLV_BAKE_MASK",
    "RLV_BAKE_NORMAL",
    "RLV_BAKE_OBJECT",
    "RLV_BAKE_OPENGL",
    "RLV_BAKE_OPTIONS_INIT",
    "RLV_BAKE_REPORT_INIT",
    "RLV_BAKE_TANGENT",
    "RLV_BAKE_TBN",
    "RLV_BAKE_TIME",
    "RLV_BAKE_TNB",
    "RLV_BAKE_VECTOR",
    "RLV_BEZIER_ARRAYS_INIT",
    "RLV_BEZIER_INFO_INIT",
    "RLV_BEZIER_LEVELS_INIT",
    "RLV_BEZIER_TRIANGLES_INIT",
    "RLV_BEZIER_VIEW_INIT",
    "RLV_BLEND_ADD",
    "RLV_BLEND_MAX",
    "RLV_BLEND_MIN",
    "RLV_BLEND_MULTIPLY",
    "RLV_BLEND_NORMAL",
    "RLV_BLEND_OVERLAY",
    "RLV_BLEND_SCREEN",
    "RLV_BLEND_SUBTRACT",
    "RLV_BOUNDARY_EDGES",
    "RLV_BOUNDARY_EDGES_AND_CORNERS",
    "RLV_BOUNDARY_NONE",
    "RLV_BRUSH_OPTIONS_INIT",
    "RLV_BRUSH_PAINT",
    "RLV_BRUSH_SCULPT",
    "RLV_BRUSH_SETTINGS_INIT",
    "RLV_BUFFER_INFO_INIT",
    "RLV_BUFFER_VULKAN_INIT",
    "RLV_CAPABILITY_INIT",
    "RLV_CHANNEL_COLOR",
    "RLV_CHANNEL_DISPLACEMENT",
    "RLV_CHANNEL_INFO_INIT",
    "RLV_CHANNEL_TRACES",
    "RLV_CHANNEL_VECTORS",
    "RLV_CLIENT_ALL",
    "RLV_CLIENT_BLIND",
    "RLV_CLIENT_CANCEL",
    "RLV_CLIENT_CANCELLED",
    "RLV_CLIENT_DONE",
    "RLV_CLIENT_FAILED",
    "RLV_CLIENT_FETCH_INIT",
    "RLV_CLIENT_FORCES",
    "RLV_CLIENT_FRAME",
    "RLV_CLIENT_INFO_INIT",
    "RLV_CLIENT_LEVEL_SET",
    "RLV_CLIENT_MESH",
    "RLV_CLIENT_OPTIONS_INIT",
    "RLV_CLIENT_PAUSE",
    "RLV_CLIENT_PAUSED",
    "RLV_CLIENT_REMOVE",
    "RLV_CLIENT_RESUME",
    "RLV_CLIENT_RUNNING",
    "RLV_CLIENT_SCENE_INIT",
    "RLV_CLIENT_STATUS_INIT",
    "RLV_CLIENT_SURFACE",
    "RLV_COLLIDER_INFO_INIT",
    "RLV_COLOR_BUFFER_INFO_INIT",
    "RLV_COLOR_BUFFER_VULKAN_INIT",
    "RLV_COLOR_RGBA16F",
    "RLV_COLOR_RGBA8",
    "RLV_CONTENT_CROWD",
    "RLV_CONTENT_DOCUMENT",
    "RLV_CONTENT_GRID",
    "RLV_CONTENT_MESH",
    "RLV_CONTENT_PARTICLES",
    "RLV_CONTENT_PATCHES",
    "RLV_CONTENT_PROGRESSIVE",
    "RLV_CONTENT_TEXTURE",
    "RLV_CONTENT_TISSUE",
    "RLV_CONTEXT_INFO_INIT",
    "RLV_CONTEXT_OPTIONS_INIT",
    "RLV_CREASING_CHAIKIN",
    "RLV_CREASING_UNIFORM",
    "RLV_CROWD_BLEND_DUAL_QUATERNION",
    "RLV_CROWD_BLEND_LINEAR",
    "RLV_CROWD_BUFFERS_INIT",
    "RLV_CROWD_BUILD_SETTINGS_INIT",
    "RLV_CROWD_CLIP_INIT",
    "RLV_CROWD_FRAME_INIT",
    "RLV_CROWD_IMPOSTORS_INIT",
    "RLV_CROWD_MATERIAL_INIT",
    "RLV_CROWD_MODEL_INFO_INIT",
    "RLV_CROWD_PICTURE_SIDE",
    "RLV_CROWD_REFIT_REPORT_INIT",
    "RLV_CROWD_STREAM_INFO_INIT",
    "RLV_CROWD_STREAM_SETTINGS_INIT",
    "RLV_CROWD_VERTICES_INIT",
    "RLV_CROWD_VIEW_INIT",
    "RLV_CURVE_ANGLE",
    "RLV_CURVE_SIZE",
    "RLV_CURVE_STRENGTH",
    "RLV_DECAL_IMAGE_INIT",
    "RLV_DECAL_INK_INIT",
    "RLV_DECAL_OPTIONS_INIT",
    "RLV_DECAL_QUALITY_INIT",
    "RLV_DECAL_RECIPE_INIT",
    "RLV_DECAL_REPORT_INIT",
    "RLV_DECAL_TEXTURE_INIT",
    "RLV_DECAY_OPTIONS_INIT",
    "RLV_DETAIL_CHANGES_INIT",
    "RLV_DETAIL_FOLDS_INIT",
    "RLV_DETAIL_INFO_INIT",
    "RLV_DETAIL_OPTIONS_INIT",
    "RLV_DETAIL_TILE_INFO_INIT",
    "RLV_DEVICE_AUTO",
    "RLV_DEVICE_CPU",
    "RLV_DEVICE_CROWD_INFO_INIT",
    "RLV_DEVICE_CROWD_VULKAN_INIT",
    "RLV_DEVICE_GPU",
    "RLV_DEVICE_LEVEL_INFO_INIT",
    "RLV_DEVICE_LEVEL_VULKAN_INIT",
    "RLV_DIFFUSE_ARRAYS_INIT",
    "RLV_DIFFUSE_FLUID_INIT",
    "RLV_DIFFUSE_INFO_INIT",
    "RLV_DIFFUSE_OPTIONS_INIT",
    "RLV_DIFFUSE_POTENTIALS_INIT",
    "RLV_DIFFUSE_REPORT_INIT",
    "RLV_DIFFUSE_SETTINGS_INIT",
    "RLV_DOCUMENT_CHANGES_INIT",
    "RLV_DOCUMENT_INFO_INIT",
    "RLV_DOMAIN_CORNER",
    "RLV_DOMAIN_FACE",
    "RLV_DOMAIN_POINT",
    "RLV_ELEMENT_CORNER",
    "RLV_ELEMENT_CREASE",
    "RLV_ELEMENT_EDGE",
    "RLV_ELEMENT_FACE",
    "RLV_ELEMENT_ITEM",
    "RLV_ELEMENT_LINE",
    "RLV_ELEMENT_NONE",
    "RLV_ELEMENT_PARTICLE",
    "RLV_ELEMENT_PATCH",
    "RLV_ELEMENT_PIN",
    "RLV_ELEMENT_POINT",
    "RLV_ELEMENT_TILE",
    "RLV_ELEMENT_TRIANGLE",
    "RLV_ERROR_BUSY",
    "RLV_ERROR_CANCELLED",
    "RLV_ERROR_DEVICE",
    "RLV_ERROR_INIT",
    "RLV_ERROR_INTERNAL",
    "RLV_ERROR_INVALID",
    "RLV_ERROR_IO",
    "RLV_ERROR_MEMORY",
    "RLV_ERROR_NOT_FOUND",
    "RLV_ERROR_UNSUPPORTED",
    "RLV_EVALUATE_ARRAYS_INIT",
    "RLV_EXTERN_C",
    "RLV_FACE_VARYING_ALL",
    "RLV_FACE_VARYING_BOUNDARIES",
    "RLV_FACE_VARYING_CORNERS_ONLY",
    "RLV_FACE_VARYING_CORNERS_PLUS_1",
    "RLV_FACE_VARYING_CORNERS_PLUS_2",
    "RLV_FACE_VARYING_NONE",
    "RLV_FALLOFF_CONSTANT",
    "RLV_FALLOFF_GAUSSIAN",
    "RLV_FALLOFF_LINEAR",
    "RLV_FALLOFF_SMOOTH",
    "RLV_FALLOFF_SPHERE",
    "RLV_FLUID_ARRAYS_INIT",
    "RLV_FLUID_ATTRACTOR",
    "RLV_FLUID_COLLIDER_OPTIONS_INIT",
    "RLV_FLUID_COURANT",
    "RLV_FLUID_DFSPH",
    "RLV_FLUID_DISC",
    "RLV_FLUID_DRAG",
    "RLV_FLUID_EMITTER_OPTIONS_INIT",
    "RLV_FLUID_FIXED",
    "RLV_FLUID_FRICTION",
    "RLV_FLUID_GRAVITY",
    "RLV_FLUID_INFO_INIT",
    "RLV_FLUID_MUELLER",
    "RLV_FLUID_OPTIONS_INIT",
    "RLV_FLUID_PARTICLES_INIT",
    "RLV_FLUID_PCISPH",
    "RLV_FLUID_RECTANGLE",
    "RLV_FLUID_REPORT_INIT",
    "RLV_FLUID_SLIP",
    "RLV_FLUID_STOP",
    "RLV_FLUID_SURFACE",
    "RLV_FLUID_TURBULENCE",
    "RLV_FLUID_VORTEX",
    "RLV_FLUID_WALLS",
    "RLV_FLUID_WENDLAND",
    "RLV_FLUID_WIND",
    "RLV_FOAM_BUBBLE",
    "RLV_FOAM_FLOAT",
    "RLV_FOAM_LAYERS_INIT",
    "RLV_FOAM_LIGHT_INIT",
    "RLV_FOAM_PARTICLES_INIT",
    "RLV_FOAM_SETTINGS_INIT",
    "RLV_FOAM_SPRAY",
    "RLV_FOAM_VIEW_INIT",
    "RLV_GRID_BOOL",
    "RLV_GRID_DIFFERENCE",
    "RLV_GRID_DOUBLE",
    "RLV_GRID_FLOAT",
    "RLV_GRID_FOG",
    "RLV_GRID_GAUSSIAN",
    "RLV_GRID_HALF",
    "RLV_GRID_INFO_INIT",
    "RLV_GRID_INT32",
    "RLV_GRID_INT64",
    "RLV_GRID_INTERSECTION",
    "RLV_GRID_LAPLACIAN",
    "RLV_GRID_LEVEL_SET",
    "RLV_GRID_MASK",
    "RLV_GRID_MEAN",
    "RLV_GRID_MEAN_CURVATURE",
    "RLV_GRID_MEDIAN",
    "RLV_GRID_OFFSET",
    "RLV_GRID_OTHER",
    "RLV_GRID_PACK_BLOSC",
    "RLV_GRID_PACK_NONE",
    "RLV_GRID_PACK_ZIP",
    "RLV_GRID_POINTS",
    "RLV_GRID_RESAMPLE",
    "RLV_GRID_SETTINGS_INIT",
    "RLV_GRID_STAGGERED",
    "RLV_GRID_STREAM",
    "RLV_GRID_TO_FOG",
    "RLV_GRID_TO_LEVEL_SET",
    "RLV_GRID_UNION",
    "RLV_GRID_UNKNOWN",
    "RLV_GRID_VEC3D",
    "RLV_GRID_VEC3I",
    "RLV_GRID_VEC3S",
    "RLV_IMPRINT_MOMENT_INIT",
    "RLV_IMPRINT_REPORT_INIT",
    "RLV_IMPRINT_SETTINGS_INIT",
    "RLV_ISOSURFACE_ANISOTROPIC",
    "RLV_ISOSURFACE_BLIND",
    "RLV_ISOSURFACE_BLOBS",
    "RLV_ISOSURFACE_CLASSES_INIT",
    "RLV_ISOSURFACE_DENSITY",
    "RLV_ISOSURFACE_HIDDEN",
    "RLV_ISOSURFACE_INFO_INIT",
    "RLV_ISOSURFACE_MESH_OPTIONS_INIT",
    "RLV_ISOSURFACE_OPTIONS_INIT",
    "RLV_ISOSURFACE_PARTICLES_INIT",
    "RLV_ISOSURFACE_SURFACE",
    "RLV_ISOSURFACE_TABLE_INIT",
    "RLV_ISOSURFACE_ZHU_BRIDSON",
    "RLV_JOB_CANCELLED",
    "RLV_JOB_DONE",
    "RLV_JOB_FAILED",
    "RLV_JOB_INFO_INIT",
    "RLV_JOB_KIND_BAKE_REPORT",
    "RLV_JOB_KIND_BYTES",
    "RLV_JOB_KIND_CASTER",
    "RLV_JOB_KIND_CLIENT_STATUS",
    "RLV_JOB_KIND_COLLIDER",
    "RLV_JOB_KIND_CROWD_MODEL",
    "RLV_JOB_KIND_DECAL",
    "RLV_JOB_KIND_DOCUMENT",
    "RLV_JOB_KIND_FLUID_REPORT",
    "RLV_JOB_KIND_GRID",
    "RLV_JOB_KIND_IMPRINT_REPORT",
    "RLV_JOB_KIND_MESH",
    "RLV_JOB_KIND_NONE",
    "RLV_JOB_KIND_PARTICLES",
    "RLV_JOB_KIND_PICTURE",
    "RLV_JOB_KIND_PROCEDURAL",
    "RLV_JOB_KIND_PROGRESSIVE",
    "RLV_JOB_KIND_PTEX_REPORT",
    "RLV_JOB_KIND_SURFACE",
    "RLV_JOB_KIND_TISSUE",
    "RLV_JOB_KIND_TRANSFER_REPORT",
    "RLV_JOB_RUNNING",
    "RLV_LAYER_COLOR",
    "RLV_LAYER_DISPLACEMENT",
    "RLV_LAYER_INFO_INIT",
    "RLV_LAYER_NAME_SIZE",
    "RLV_LAYER_OPTIONS_INIT",
    "RLV_LEVEL_BUFFERS_INIT",
    "RLV_LEVEL_EDIT_INIT",
    "RLV_LEVEL_INFO_INIT",
    "RLV_LEVEL_MOTION_INIT",
    "RLV_LEVEL_SCULPTED_INIT",
    "RLV_LEVEL_UPDATE_INIT",
    "RLV_LEVEL_VIEW_INIT",
    "RLV_LOG_INFO",
    "RLV_LOG_WARNING",
    "RLV_MAKE_VERSION",
    "RLV_MESH_ARRAYS_INIT",
    "RLV_MESH_INFO_INIT",
    "RLV_NAME_SIZE",
    "RLV_NO_ELEMENT",
    "RLV_NULL",
    "RLV_OBJECT_INFO_INIT",
    "RLV_OK",
    "RLV_PAINT_ADD",
    "RLV_PAINT_BLUR",
    "RLV_PAINT_ERASE",
    "RLV_PAINT_MIX",
    "RLV_PAINT_MULTIPLY",
    "RLV_PAINT_OPTIONS_INIT",
    "RLV_PAINT_SMEAR",
    "RLV_PARAMETER_BOOL",
    "RLV_PARAMETER_F32",
    "RLV_PARAMETER_U32",
    "RLV_PARTICLES_ARRAYS_INIT",
    "RLV_PARTICLES_INFO_INIT",
    "RLV_PICTURE_COLOR",
    "RLV_PICTURE_DISPLACEMENT",
    "RLV_PICTURE_DOCUMENT",
    "RLV_PICTURE_F16",
    "RLV_PICTURE_F32",
    "RLV_PICTURE_F64",
    "RLV_PICTURE_I32",
    "RLV_PICTURE_IMAGE_INIT",
    "RLV_PICTURE_INFO_INIT",
    "RLV_PICTURE_META_INIT",
    "RLV_PICTURE_NAME_SIZE",
    "RLV_PICTURE_NONE",
    "RLV_PICTURE_NUMBERS",
    "RLV_PICTURE_PTEX",
    "RLV_PICTURE_TEXT",
    "RLV_PICTURE_TRACES",
    "RLV_PICTURE_U16",
    "RLV_PICTURE_U8",
    "RLV_PICTURE_VECTORS",
    "RLV_POINT_VARYING",
    "RLV_POINT_VERTEX",
    "RLV_PROCEDURAL_HITS_INIT",
    "RLV_PROCEDURAL_INFO_INIT",
    "RLV_PROCEDURAL_OPTIONS_INIT",
    "RLV_PROCEDURAL_TABLE_INIT",
    "RLV_PROGRESSIVE_INFO_INIT",
    "RLV_PROGRESSIVE_OPTIONS_INIT",
    "RLV_PROGRESS_CANCEL",
    "RLV_PROGRESS_CONTINUE",
    "RLV_PTEX_COLOR",
    "RLV_PTEX_DISPLACEMENT",
    "RLV_PTEX_OPTIONS_INIT",
    "RLV_PTEX_REPORT_INIT",
    "RLV_PTEX_STATED",
    "RLV_PTEX_VECTORS",
    "RLV_RAY_ARRAYS_INIT",
    "RLV_REPAIR_REPORT_INIT",
    "RLV_REPAIR_SETTINGS_INIT",
    "RLV_SCHEME_BILINEAR",
    "RLV_SCHEME_CATMULL_CLARK",
    "RLV_SCHEME_LOOP",
    "RLV_SCULPT_CLAY",
    "RLV_SCULPT_DRAW",
    "RLV_SCULPT_ERASE",
    "RLV_SCULPT_FLATTEN",
    "RLV_SCULPT_INFLATE",
    "RLV_SCULPT_LAYER",
    "RLV_SCULPT_PINCH",
    "RLV_SCULPT_SCRAPE",
    "RLV_SCULPT_SMOOTH",
    "RLV_SCULPT_VECTOR",
    "RLV_SHADER_AUGMENTED",
    "RLV_SHADER_AUGMENTED_WGSL",
    "RLV_SHADER_AVERAGE",
    "RLV_SHADER_CLASSIFY",
    "RLV_SHADER_CLASSIFY_VERTEX",
    "RLV_SHADER_COMPUTE",
    "RLV_SHADER_EXAMPLES_INIT",
    "RLV_SHADER_FEATURE_INIT",
    "RLV_SHADER_FIRST",
    "RLV_SHADER_FRAGMENT",
    "RLV_SHADER_GLOBAL",
    "RLV_SHADER_GLSL",
    "RLV_SHADER_LAST",
    "RLV_SHADER_LAYOUT_INIT",
    "RLV_SHADER_LOCAL",
    "RLV_SHADER_MARKED",
    "RLV_SHADER_MASK",
    "RLV_SHADER_MAX",
    "RLV_SHADER_MIN",
    "RLV_SHADER_NEGATIVE",
    "RLV_SHADER_OPTIONS_INIT",
    "RLV_SHADER_PARAMETER",
    "RLV_SHADER_POSITIVE",
    "RLV_SHADER_RENDER",
    "RLV_SHADER_SUM",
    "RLV_SHADER_VARIABLE_INIT",
    "RLV_SHADER_VERTEX",
    "RLV_SHADER_VERTICES",
    "RLV_SHADER_WGSL",
    "RLV_SIMPLIFY_OPTIONS_INIT",
    "RLV_STAMP_OPTIONS_INIT",
    "RLV_STAMP_SETTINGS_INIT",
    "RLV_STREAM_INIT",
    "RLV_STROKE_REPORT_INIT",
    "RLV_SUBDIVISION_ARRAYS_INIT",
    "RLV_SUBDIVISION_INFO_INIT",
    "RLV_SUBDIVISION_OPTIONS_INIT",
    "RLV_SURFACE_BILINEAR",
    "RLV_SURFACE_CATMULL_CLARK",
    "RLV_SURFACE_INFO_INIT",
    "RLV_SURFACE_OPTIONS_INIT",
    "RLV_SURFACE_TRIANGLES",
    "RLV_TESSELLATE_OPTIONS_INIT",
    "RLV_TESSELLATION_CHANGES_INIT",
    "RLV_TESSELLATION_INFO_INIT",
    "RLV_TEXT_SIZE",
    "RLV_TILE_INFO_INIT",
    "RLV_TISSUE_ARRAYS_INIT",
    "RLV_TISSUE_BALL",
    "RLV_TISSUE_BIND",
    "RLV_TISSUE_COLLIDER_INIT",
    "RLV_TISSUE_DESCRIPTION_INIT",
    "RLV_TISSUE_ENERGIES_INIT",
    "RLV_TISSUE_FLOOR",
    "RLV_TISSUE_HOLD",
    "RLV_TISSUE_INFO_INIT",
    "RLV_TISSUE_LABELS_INIT",
    "RLV_TISSUE_LABEL_INIT",
    "RLV_TISSUE_LAYER_INIT",
    "RLV_TISSUE_MATERIAL_INIT",
    "RLV_TISSUE_MESH",
    "RLV_TISSUE_MUSCLE_INIT",
    "RLV_TISSUE_OPTIONS_INIT",
    "RLV_TISSUE_RELAXATION_INIT",
    "RLV_TISSUE_REPORT_INIT",
    "RLV_TISSUE_SET_INIT",
    "RLV_TISSUE_SIMULATION_INFO_INIT",
    "RLV_TISSUE_SLIDE",
    "RLV_TISSUE_SURFACE_INIT",
    "RLV_TISSUE_VOLUME_INIT",
    "RLV_TOOL_SETTINGS_INIT",
    "RLV_TRANSFER_OPTIONS_INIT",
    "RLV_TRANSFER_REPORT_INIT",
    "RLV_TRIANGLE_CATMULL_CLARK",
    "RLV_TRIANGLE_SMOOTH",
    "RLV_TYPE_F32",
    "RLV_TYPE_U32",
    "RLV_VECTOR_OPTIONS_INIT",
    "RLV_VERSION",
    "RLV_VERSION_MAJOR",
    "RLV_VERSION_MINOR",
    "RLV_VERSION_PATCH",
    "RLV_VULKAN_BUFFERS_INIT",
    "RLV_VULKAN_DEVICE_INIT",
];
