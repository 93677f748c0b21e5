//! The declarations of `cpp/opensubdiv/refine.h`.

use std::ffi::c_char;

#[repr(C)]
pub struct Cage {
    pub point_count: i32,
    pub face_count: i32,
    pub face_sizes: *const i32,
    pub corners: *const i32,
    pub crease_count: i32,
    pub crease_points: *const i32,
    pub crease_sharpness: *const f32,
    pub sharp_point_count: i32,
    pub sharp_points: *const i32,
    pub sharp_point_sharpness: *const f32,
    pub hole_count: i32,
    pub holes: *const i32,
    pub boundary_rule: i32,
    pub isolation: i32,
    pub single_crease: i32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Patch {
    pub tile: i32,
    pub u: u16,
    pub v: u16,
    pub depth: u8,
    pub boundary: u8,
    pub kind: u8,
    pub crease: u8,
    pub sharpness: f32,
    pub first: u32,
}

#[repr(C)]
pub struct Arrays {
    pub tile_count: i32,
    pub patch_count: i32,
    pub patches: *const Patch,
    pub index_count: i32,
    pub indices: *const i32,
    pub stencil_count: i32,
    pub stencil_sizes: *const i32,
    pub weight_count: i64,
    pub stencil_indices: *const i32,
    pub stencil_weights: *const f64,
}

#[repr(C)]
pub struct Table {
    _opaque: [u8; 0],
}

#[repr(C)]
pub struct Bfr {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    pub fn rlv_osd_expected_patches(
        cage: *const Cage,
        first: i32,
        last: i32,
        counts: *mut f64,
        error: *mut c_char,
        error_size: usize,
    ) -> i32;
    pub fn rlv_osd_refine(cage: *const Cage, error: *mut c_char, error_size: usize) -> *mut Table;
    pub fn rlv_osd_arrays_of(table: *const Table, arrays: *mut Arrays);
    pub fn rlv_osd_free(table: *mut Table);
    pub fn rlv_osd_evaluate(
        table: *const Table,
        points: *const f64,
        place_count: i32,
        tiles: *const i32,
        uv: *const f64,
        out: *mut f64,
    ) -> i32;
    pub fn rlv_osd_far_grid(
        table: *const Table,
        points: *const f32,
        size: i32,
        buffer: *mut f32,
        buffer_floats: i64,
    ) -> i64;
    pub fn rlv_osd_bfr_create(table: *const Table, level: i32, error: *mut c_char, error_size: usize) -> *mut Bfr;
    pub fn rlv_osd_bfr_grid(bfr: *mut Bfr, points: *const f32, size: i32, buffer: *mut f32, buffer_floats: i64) -> i64;
    pub fn rlv_osd_bfr_free(bfr: *mut Bfr);
}
