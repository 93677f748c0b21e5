//! Exploration of shaders in a build without it: every function fails.

use std::ffi::{c_char, c_void};

use relievo_core::Error;

use crate::border::registry::handle;

handle!(RlvShader, 27, ());

/// Returns the error of every function of `include/relievo/shader.h`.
fn absent() -> Error {
    Error::unsupported("this library was built without the exploration of shaders")
        .advise("build it with the feature `shader`")
}

entry! {
    fn rlv_shader_create(_source: *const c_char, _options: *const c_void, _out: *mut RlvShader) {
        Err(absent())
    }

    fn rlv_shader_retain(_shader: RlvShader) {
        Err(absent())
    }

    fn rlv_shader_release(_shader: RlvShader) {
        Err(absent())
    }

    fn rlv_shader_variable_count(_shader: RlvShader, _out: *mut usize) {
        Err(absent())
    }

    fn rlv_shader_variable(_shader: RlvShader, _index: usize, _out: *mut c_void) {
        Err(absent())
    }

    fn rlv_shader_mark(
        _shader: RlvShader,
        _variables: *const u32,
        _count: usize,
        _weight: *const c_char,
        _out: *mut RlvShader,
    ) {
        Err(absent())
    }

    fn rlv_shader_text(_shader: RlvShader, _kind: u32, _text: *mut c_char, _size: usize, _length: *mut usize) {
        Err(absent())
    }

    fn rlv_shader_layout(_shader: RlvShader, _out: *mut c_void) {
        Err(absent())
    }

    fn rlv_shader_feature(_shader: RlvShader, _index: usize, _out: *mut c_void) {
        Err(absent())
    }

    fn rlv_shader_pack_examples(
        _examples: *const c_void,
        _mode: u32,
        _x: u32,
        _y: u32,
        _words: *mut u32,
        _capacity: usize,
        _count: *mut usize,
    ) {
        Err(absent())
    }

    fn rlv_shader_unpack_log(
        _shader: RlvShader,
        _words: *const u32,
        _count: usize,
        _vector: *mut f32,
        _capacity: usize,
        _taken: *mut u32,
    ) {
        Err(absent())
    }

    fn rlv_shader_membership(
        _examples: *const c_void,
        _vectors: *const f32,
        _count: usize,
        _stride: usize,
        _out: *mut f32,
    ) {
        Err(absent())
    }
}
