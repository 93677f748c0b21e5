// Made by `cargo xtask bindings` from the headers of Embree 4.4.0; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0
use super::common::*;

pub const RTC_FEATURE_FLAG_ALL: RTCFeatureFlags = 4294967295;
pub type RTCFeatureFlags = ::std::ffi::c_uint;
pub const RTC_RAY_QUERY_FLAG_NONE: RTCRayQueryFlags = 0;
pub const RTC_RAY_QUERY_FLAG_COHERENT: RTCRayQueryFlags = 65536;
pub type RTCRayQueryFlags = ::std::ffi::c_uint;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCFilterFunctionNArguments {
    pub valid: *mut ::std::ffi::c_int,
    pub geometryUserPtr: *mut ::std::ffi::c_void,
    pub context: *mut RTCRayQueryContext,
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
pub type RTCIntersectFunctionN = ::std::option::Option<
    unsafe extern "C" fn(args: *const RTCIntersectFunctionNArguments),
>;
pub type RTCOccludedFunctionN = ::std::option::Option<
    unsafe extern "C" fn(args: *const RTCOccludedFunctionNArguments),
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCRayQueryContext {
    pub instID: [::std::ffi::c_uint; 1usize],
    pub instPrimID: [::std::ffi::c_uint; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRayQueryContext"][::std::mem::size_of::<RTCRayQueryContext>() - 8usize];
    [
        "Alignment of RTCRayQueryContext",
    ][::std::mem::align_of::<RTCRayQueryContext>() - 4usize];
    [
        "Offset of field: RTCRayQueryContext::instID",
    ][::std::mem::offset_of!(RTCRayQueryContext, instID) - 0usize];
    [
        "Offset of field: RTCRayQueryContext::instPrimID",
    ][::std::mem::offset_of!(RTCRayQueryContext, instPrimID) - 4usize];
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
    pub instPrimID: [::std::ffi::c_uint; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCHit"][::std::mem::size_of::<RTCHit>() - 48usize];
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
    [
        "Offset of field: RTCHit::instPrimID",
    ][::std::mem::offset_of!(RTCHit, instPrimID) - 32usize];
};
#[repr(C)]
#[repr(align(16))]
pub struct RTCRayHit {
    pub ray: RTCRay,
    pub hit: RTCHit,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRayHit"][::std::mem::size_of::<RTCRayHit>() - 96usize];
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
    pub instPrimID: [[::std::ffi::c_uint; 8usize]; 1usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCHit8"][::std::mem::size_of::<RTCHit8>() - 288usize];
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
    [
        "Offset of field: RTCHit8::instPrimID",
    ][::std::mem::offset_of!(RTCHit8, instPrimID) - 256usize];
};
#[repr(C)]
#[repr(align(32))]
pub struct RTCRayHit8 {
    pub ray: RTCRay8,
    pub hit: RTCHit8,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRayHit8"][::std::mem::size_of::<RTCRayHit8>() - 672usize];
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
#[repr(C)]
#[derive(Debug)]
pub struct RTCRayHitN {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCIntersectFunctionNArguments {
    pub valid: *mut ::std::ffi::c_int,
    pub geometryUserPtr: *mut ::std::ffi::c_void,
    pub primID: ::std::ffi::c_uint,
    pub context: *mut RTCRayQueryContext,
    pub rayhit: *mut RTCRayHitN,
    pub N: ::std::ffi::c_uint,
    pub geomID: ::std::ffi::c_uint,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCIntersectFunctionNArguments",
    ][::std::mem::size_of::<RTCIntersectFunctionNArguments>() - 48usize];
    [
        "Alignment of RTCIntersectFunctionNArguments",
    ][::std::mem::align_of::<RTCIntersectFunctionNArguments>() - 8usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::valid",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, valid) - 0usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::geometryUserPtr",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, geometryUserPtr) - 8usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::primID",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, primID) - 16usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::context",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, context) - 24usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::rayhit",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, rayhit) - 32usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::N",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, N) - 40usize];
    [
        "Offset of field: RTCIntersectFunctionNArguments::geomID",
    ][::std::mem::offset_of!(RTCIntersectFunctionNArguments, geomID) - 44usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCOccludedFunctionNArguments {
    pub valid: *mut ::std::ffi::c_int,
    pub geometryUserPtr: *mut ::std::ffi::c_void,
    pub primID: ::std::ffi::c_uint,
    pub context: *mut RTCRayQueryContext,
    pub ray: *mut RTCRayN,
    pub N: ::std::ffi::c_uint,
    pub geomID: ::std::ffi::c_uint,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCOccludedFunctionNArguments",
    ][::std::mem::size_of::<RTCOccludedFunctionNArguments>() - 48usize];
    [
        "Alignment of RTCOccludedFunctionNArguments",
    ][::std::mem::align_of::<RTCOccludedFunctionNArguments>() - 8usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::valid",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, valid) - 0usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::geometryUserPtr",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, geometryUserPtr) - 8usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::primID",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, primID) - 16usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::context",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, context) - 24usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::ray",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, ray) - 32usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::N",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, N) - 40usize];
    [
        "Offset of field: RTCOccludedFunctionNArguments::geomID",
    ][::std::mem::offset_of!(RTCOccludedFunctionNArguments, geomID) - 44usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCIntersectArguments {
    pub flags: RTCRayQueryFlags,
    pub feature_mask: RTCFeatureFlags,
    pub context: *mut RTCRayQueryContext,
    pub filter: RTCFilterFunctionN,
    pub intersect: RTCIntersectFunctionN,
    pub minWidthDistanceFactor: f32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCIntersectArguments",
    ][::std::mem::size_of::<RTCIntersectArguments>() - 40usize];
    [
        "Alignment of RTCIntersectArguments",
    ][::std::mem::align_of::<RTCIntersectArguments>() - 8usize];
    [
        "Offset of field: RTCIntersectArguments::flags",
    ][::std::mem::offset_of!(RTCIntersectArguments, flags) - 0usize];
    [
        "Offset of field: RTCIntersectArguments::feature_mask",
    ][::std::mem::offset_of!(RTCIntersectArguments, feature_mask) - 4usize];
    [
        "Offset of field: RTCIntersectArguments::context",
    ][::std::mem::offset_of!(RTCIntersectArguments, context) - 8usize];
    [
        "Offset of field: RTCIntersectArguments::filter",
    ][::std::mem::offset_of!(RTCIntersectArguments, filter) - 16usize];
    [
        "Offset of field: RTCIntersectArguments::intersect",
    ][::std::mem::offset_of!(RTCIntersectArguments, intersect) - 24usize];
    [
        "Offset of field: RTCIntersectArguments::minWidthDistanceFactor",
    ][::std::mem::offset_of!(RTCIntersectArguments, minWidthDistanceFactor) - 32usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCOccludedArguments {
    pub flags: RTCRayQueryFlags,
    pub feature_mask: RTCFeatureFlags,
    pub context: *mut RTCRayQueryContext,
    pub filter: RTCFilterFunctionN,
    pub occluded: RTCOccludedFunctionN,
    pub minWidthDistanceFactor: f32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCOccludedArguments",
    ][::std::mem::size_of::<RTCOccludedArguments>() - 40usize];
    [
        "Alignment of RTCOccludedArguments",
    ][::std::mem::align_of::<RTCOccludedArguments>() - 8usize];
    [
        "Offset of field: RTCOccludedArguments::flags",
    ][::std::mem::offset_of!(RTCOccludedArguments, flags) - 0usize];
    [
        "Offset of field: RTCOccludedArguments::feature_mask",
    ][::std::mem::offset_of!(RTCOccludedArguments, feature_mask) - 4usize];
    [
        "Offset of field: RTCOccludedArguments::context",
    ][::std::mem::offset_of!(RTCOccludedArguments, context) - 8usize];
    [
        "Offset of field: RTCOccludedArguments::filter",
    ][::std::mem::offset_of!(RTCOccludedArguments, filter) - 16usize];
    [
        "Offset of field: RTCOccludedArguments::occluded",
    ][::std::mem::offset_of!(RTCOccludedArguments, occluded) - 24usize];
    [
        "Offset of field: RTCOccludedArguments::minWidthDistanceFactor",
    ][::std::mem::offset_of!(RTCOccludedArguments, minWidthDistanceFactor) - 32usize];
};
pub struct Embree4 {
    __library: ::libloading::Library,
    pub rtcIntersect1: unsafe extern "C" fn(
        scene: RTCScene,
        rayhit: *mut RTCRayHit,
        args: *mut RTCIntersectArguments,
    ),
    pub rtcIntersect8: unsafe extern "C" fn(
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        rayhit: *mut RTCRayHit8,
        args: *mut RTCIntersectArguments,
    ),
    pub rtcOccluded1: unsafe extern "C" fn(
        scene: RTCScene,
        ray: *mut RTCRay,
        args: *mut RTCOccludedArguments,
    ),
    pub rtcOccluded8: unsafe extern "C" fn(
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        ray: *mut RTCRay8,
        args: *mut RTCOccludedArguments,
    ),
}
impl Embree4 {
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
        Ok(Embree4 {
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
        rayhit: *mut RTCRayHit,
        args: *mut RTCIntersectArguments,
    ) {
        unsafe { (self.rtcIntersect1)(scene, rayhit, args) }
    }
    pub unsafe fn rtcIntersect8(
        &self,
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        rayhit: *mut RTCRayHit8,
        args: *mut RTCIntersectArguments,
    ) {
        unsafe { (self.rtcIntersect8)(valid, scene, rayhit, args) }
    }
    pub unsafe fn rtcOccluded1(
        &self,
        scene: RTCScene,
        ray: *mut RTCRay,
        args: *mut RTCOccludedArguments,
    ) {
        unsafe { (self.rtcOccluded1)(scene, ray, args) }
    }
    pub unsafe fn rtcOccluded8(
        &self,
        valid: *const ::std::ffi::c_int,
        scene: RTCScene,
        ray: *mut RTCRay8,
        args: *mut RTCOccludedArguments,
    ) {
        unsafe { (self.rtcOccluded8)(valid, scene, ray, args) }
    }
}
