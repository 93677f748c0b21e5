// Made by `cargo xtask bindings` from the headers of Embree 3.13.5; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0
use super::common::*;

pub const RTC_INTERSECT_CONTEXT_FLAG_NONE: RTCIntersectContextFlags = 0;
pub const RTC_INTERSECT_CONTEXT_FLAG_COHERENT: RTCIntersectContextFlags = 1;
pub type RTCIntersectContextFlags = ::std::ffi::c_uint;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCFilterFunctionNArguments {
    pub valid: *mut ::std::ffi::c_int,
    pub geometryUserPtr: *mut ::std::ffi::c_void,
    pub context: *mut RTCIntersectContext,
    pub ray: *mut RTCRayN,
    pub hit: *mut RTCHitN,
    pub N: ::std::ffi::c_uint,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCFilterFunctionNArguments",
    ][::std::mem::size_of::<RTCFilterFunctionNArguments>() - 48usize];
    [
        "Alignment of RTCFilterFunctionNArguments",
    ][::std::mem::align_of::<RTCFilterFunctionNArguments>() - 8usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::valid",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, valid) - 0usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::geometryUserPtr",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, geometryUserPtr) - 8usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::context",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, context) - 16usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::ray",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, ray) - 24usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::hit",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, hit) - 32usize];
    [
        "Offset of field: RTCFilterFunctionNArguments::N",
    ][::std::mem::offset_of!(RTCFilterFunctionNArguments, N) - 40usize];
};
pub type RTCFilterFunctionN = ::std::option::Option<
    unsafe extern "C" fn(args: *const RTCFilterFunctionNArguments),
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCIntersectContext {
    pub flags: RTCIntersectContextFlags,
    pub filter: RTCFilterFunctionN,
    pub instID: [::std::ffi::c_uint; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCIntersectContext",
    ][::std::mem::size_of::<RTCIntersectContext>() - 24usize];
    [
        "Alignment of RTCIntersectContext",
    ][::std::mem::align_of::<RTCIntersectContext>() - 8usize];
    [
        "Offset of field: RTCIntersectContext::flags",
    ][::std::mem::offset_of!(RTCIntersectContext, flags) - 0usize];
    [
        "Offset of field: RTCIntersectContext::filter",
    ][::std::mem::offset_of!(RTCIntersectContext, filter) - 8usize];
    [
        "Offset of field: RTCIntersectContext::instID",
    ][::std::mem::offset_of!(RTCIntersectContext, instID) - 16usize];
};
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Copy, Clone)]
pub struct RTCHit {
    pub Ng_x: f32,
    pub Ng_y: f32,
    pub Ng_z: f32,
    pub u: f32,
    pub v: f32,
    pub primID: ::std::ffi::c_uint,
    pub geomID: ::std::ffi::c_uint,
    pub instID: [::std::ffi::c_uint; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCHit"][::std::mem::size_of::<RTCHit>() - 32usize];
    ["Alignment of RTCHit"][::std::mem::align_of::<RTCHit>() - 16usize];
    ["Offset of field: RTCHit::Ng_x"][::std::mem::offset_of!(RTCHit, Ng_x) - 0usize];
    ["Offset of field: RTCHit::Ng_y"][::std::mem::offset_of!(RTCHit, Ng_y) - 4usize];
    ["Offset of field: RTCHit::Ng_z"][::std::mem::offset_of!(RTCHit, Ng_z) - 8usize];
    ["Offset of field: RTCHit::u"][::std::mem::offset_of!(RTCHit, u) - 12usize];
    ["Offset of field: RTCHit::v"][::std::mem::offset_of!(RTCHit, v) - 16usize];
    [
        "Offset of field: RTCHit::primID",
    ][::std::mem::offset_of!(RTCHit, primID) - 20usize];
    [
        "Offset of field: RTCHit::geomID",
    ][::std::mem::offset_of!(RTCHit, geomID) - 24usize];
    [
        "Offset of field: RTCHit::instID",
    ][::std::mem::offset_of!(RTCHit, instID) - 28usize];
};
#[repr(C)]
#[repr(align(16))]
pub struct RTCRayHit {
    pub ray: RTCRay,
    pub hit: RTCHit,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRayHit"][::std::mem::size_of::<RTCRayHit>() - 80usize];
    ["Alignment of RTCRayHit"][::std::mem::align_of::<RTCRayHit>() - 16usize];
    ["Offset of field: RTCRayHit::ray"][::std::mem::offset_of!(RTCRayHit, ray) - 0usize];
    [
        "Offset of field: RTCRayHit::hit",
    ][::std::mem::offset_of!(RTCRayHit, hit) - 48usize];
};
#[repr(C)]
#[repr(align(32))]
#[derive(Debug, Copy, Clone)]
pub struct RTCHit8 {
    pub Ng_x: [f32; 8usize],
    pub Ng_y: [f32; 8usize],
    pub Ng_z: [f32; 8usize],
    pub u: [f32; 8usize],
    pub v: [f32; 8usize],
    pub primID: [::std::ffi::c_uint; 8usize],
    pub geomID: [::std::ffi::c_uint; 8usize],
    pub instID: [[::std::ffi::c_uint; 8usize]; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCHit8"][::std::mem::size_of::<RTCHit8>() - 256usize];
    ["Alignment of RTCHit8"][::std::mem::align_of::<RTCHit8>() - 32usize];
    ["Offset of field: RTCHit8::Ng_x"][::std::mem::offset_of!(RTCHit8, Ng_x) - 0usize];
    ["Offset of field: RTCHit8::Ng_y"][::std::mem::offset_of!(RTCHit8, Ng_y) - 32usize];
    ["Offset of field: RTCHit8::Ng_z"][::std::mem::offset_of!(RTCHit8, Ng_z) - 64usize];
    ["Offset of field: RTCHit8::u"][::std::mem::offset_of!(RTCHit8, u) - 96usize];
    ["Offset of field: RTCHit8::v"][::std::mem::offset_of!(RTCHit8, v) - 128usize];
    [
        "Offset of field: RTCHit8::primID",
    ][::std::mem::offset_of!(RTCHit8, primID) - 160usize];
    [
        "Offset of field: RTCHit8::geomID",
    ][::std::mem::offset_of!(RTCHit8, geomID) - 192usize];
    [
        "Offset of field: RTCHit8::instID",
    ][::std::mem::offset_of!(RTCHit8, instID) - 224usize];
};
#[repr(C)]
#[repr(align(32))]
pub struct RTCRayHit8 {
    pub ray: RTCRay8,
    pub hit: RTCHit8,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRayHit8"][::std::mem::size_of::<RTCRayHit8>() - 640usize];
    ["Alignment of RTCRayHit8"][::std::mem::align_of::<RTCRayHit8>() - 32usize];
    [
        "Offset of field: RTCRayHit8::ray",
    ][::std::mem::offset_of!(RTCRayHit8, ray) - 0usize];
    [
        "Offset of field: RTCRayHit8::hit",
    ][::std::mem::offset_of!(RTCRayHit8, hit) - 384usize];
};
#[repr(C)]
#[derive(Debug)]
pub struct RTCRayN {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug)]
pub struct RTCHitN {
    _unused: [u8; 0],
}
pub struct Embree3 {
    __library: ::libloading::Library,
    pub rtcIntersect1: unsafe extern "C" fn(
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        rayhit: *mut RTCRayHit,
    ),
    pub rtcIntersect8: unsafe extern "C" fn(
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        rayhit: *mut RTCRayHit8,
    ),
    pub rtcOccluded1: unsafe extern "C" fn(
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        ray: *mut RTCRay,
    ),
    pub rtcOccluded8: unsafe extern "C" fn(
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        ray: *mut RTCRay8,
    ),
}
impl Embree3 {
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
        let rtcIntersect1 = unsafe { __library.get(b"rtcIntersect1\0") }
            .map(|sym| *sym)?;
        let rtcIntersect8 = unsafe { __library.get(b"rtcIntersect8\0") }
            .map(|sym| *sym)?;
        let rtcOccluded1 = unsafe { __library.get(b"rtcOccluded1\0") }.map(|sym| *sym)?;
        let rtcOccluded8 = unsafe { __library.get(b"rtcOccluded8\0") }.map(|sym| *sym)?;
        Ok(Embree3 {
            __library,
            rtcIntersect1,
            rtcIntersect8,
            rtcOccluded1,
            rtcOccluded8,
        })
    }
    pub unsafe fn rtcIntersect1(
        &self,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        rayhit: *mut RTCRayHit,
    ) {
        unsafe { (self.rtcIntersect1)(scene, context, rayhit) }
    }
    pub unsafe fn rtcIntersect8(
        &self,
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        rayhit: *mut RTCRayHit8,
    ) {
        unsafe { (self.rtcIntersect8)(valid, scene, context, rayhit) }
    }
    pub unsafe fn rtcOccluded1(
        &self,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        ray: *mut RTCRay,
    ) {
        unsafe { (self.rtcOccluded1)(scene, context, ray) }
    }
    pub unsafe fn rtcOccluded8(
        &self,
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        context: *mut RTCIntersectContext,
        ray: *mut RTCRay8,
    ) {
        unsafe { (self.rtcOccluded8)(valid, scene, context, ray) }
    }
}
