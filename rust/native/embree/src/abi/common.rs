// Made by `cargo xtask bindings` from the headers of Embree 3.13.5 and 4.4.0, which declare this alike; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0

pub const RTC_FORMAT_UINT: RTCFormat = 20481;
pub const RTC_FORMAT_UINT2: RTCFormat = 20482;
pub const RTC_FORMAT_UINT3: RTCFormat = 20483;
pub const RTC_FORMAT_FLOAT: RTCFormat = 36865;
pub const RTC_FORMAT_FLOAT3: RTCFormat = 36867;
pub const RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR: RTCFormat = 37428;
pub type RTCFormat = ::std::ffi::c_uint;
pub const RTC_BUILD_QUALITY_LOW: RTCBuildQuality = 0;
pub const RTC_BUILD_QUALITY_MEDIUM: RTCBuildQuality = 1;
pub const RTC_BUILD_QUALITY_REFIT: RTCBuildQuality = 3;
pub type RTCBuildQuality = ::std::ffi::c_uint;
#[repr(C)]
#[derive(Debug)]
pub struct RTCDeviceTy {
    _unused: [u8; 0],
}
pub type RTCDevice = *mut RTCDeviceTy;
pub const RTC_DEVICE_PROPERTY_VERSION: RTCDeviceProperty = 0;
pub const RTC_DEVICE_PROPERTY_TASKING_SYSTEM: RTCDeviceProperty = 128;
pub type RTCDeviceProperty = ::std::ffi::c_uint;
pub type RTCError = ::std::ffi::c_uint;
pub type RTCErrorFunction = ::std::option::Option<
    unsafe extern "C" fn(
        userPtr: *mut ::std::ffi::c_void,
        code: RTCError,
        str_: *const ::std::ffi::c_char,
    ),
>;
pub type RTCMemoryMonitorFunction = ::std::option::Option<
    unsafe extern "C" fn(ptr: *mut ::std::ffi::c_void, bytes: isize, post: bool) -> bool,
>;
pub const RTC_BUFFER_TYPE_INDEX: RTCBufferType = 0;
pub const RTC_BUFFER_TYPE_VERTEX: RTCBufferType = 1;
pub const RTC_BUFFER_TYPE_FACE: RTCBufferType = 16;
pub const RTC_BUFFER_TYPE_EDGE_CREASE_INDEX: RTCBufferType = 18;
pub const RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT: RTCBufferType = 19;
pub const RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX: RTCBufferType = 20;
pub const RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT: RTCBufferType = 21;
pub const RTC_BUFFER_TYPE_HOLE: RTCBufferType = 22;
pub type RTCBufferType = ::std::ffi::c_uint;
#[repr(C)]
#[repr(align(16))]
#[derive(Debug, Copy, Clone)]
pub struct RTCRay {
    pub org_x: f32,
    pub org_y: f32,
    pub org_z: f32,
    pub tnear: f32,
    pub dir_x: f32,
    pub dir_y: f32,
    pub dir_z: f32,
    pub time: f32,
    pub tfar: f32,
    pub mask: ::std::ffi::c_uint,
    pub id: ::std::ffi::c_uint,
    pub flags: ::std::ffi::c_uint,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRay"][::std::mem::size_of::<RTCRay>() - 48usize];
    ["Alignment of RTCRay"][::std::mem::align_of::<RTCRay>() - 16usize];
    ["Offset of field: RTCRay::org_x"][::std::mem::offset_of!(RTCRay, org_x) - 0usize];
    ["Offset of field: RTCRay::org_y"][::std::mem::offset_of!(RTCRay, org_y) - 4usize];
    ["Offset of field: RTCRay::org_z"][::std::mem::offset_of!(RTCRay, org_z) - 8usize];
    ["Offset of field: RTCRay::tnear"][::std::mem::offset_of!(RTCRay, tnear) - 12usize];
    ["Offset of field: RTCRay::dir_x"][::std::mem::offset_of!(RTCRay, dir_x) - 16usize];
    ["Offset of field: RTCRay::dir_y"][::std::mem::offset_of!(RTCRay, dir_y) - 20usize];
    ["Offset of field: RTCRay::dir_z"][::std::mem::offset_of!(RTCRay, dir_z) - 24usize];
    ["Offset of field: RTCRay::time"][::std::mem::offset_of!(RTCRay, time) - 28usize];
    ["Offset of field: RTCRay::tfar"][::std::mem::offset_of!(RTCRay, tfar) - 32usize];
    ["Offset of field: RTCRay::mask"][::std::mem::offset_of!(RTCRay, mask) - 36usize];
    ["Offset of field: RTCRay::id"][::std::mem::offset_of!(RTCRay, id) - 40usize];
    ["Offset of field: RTCRay::flags"][::std::mem::offset_of!(RTCRay, flags) - 44usize];
};
#[repr(C)]
#[repr(align(32))]
#[derive(Debug, Copy, Clone)]
pub struct RTCRay8 {
    pub org_x: [f32; 8usize],
    pub org_y: [f32; 8usize],
    pub org_z: [f32; 8usize],
    pub tnear: [f32; 8usize],
    pub dir_x: [f32; 8usize],
    pub dir_y: [f32; 8usize],
    pub dir_z: [f32; 8usize],
    pub time: [f32; 8usize],
    pub tfar: [f32; 8usize],
    pub mask: [::std::ffi::c_uint; 8usize],
    pub id: [::std::ffi::c_uint; 8usize],
    pub flags: [::std::ffi::c_uint; 8usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of RTCRay8"][::std::mem::size_of::<RTCRay8>() - 384usize];
    ["Alignment of RTCRay8"][::std::mem::align_of::<RTCRay8>() - 32usize];
    ["Offset of field: RTCRay8::org_x"][::std::mem::offset_of!(RTCRay8, org_x) - 0usize];
    [
        "Offset of field: RTCRay8::org_y",
    ][::std::mem::offset_of!(RTCRay8, org_y) - 32usize];
    [
        "Offset of field: RTCRay8::org_z",
    ][::std::mem::offset_of!(RTCRay8, org_z) - 64usize];
    [
        "Offset of field: RTCRay8::tnear",
    ][::std::mem::offset_of!(RTCRay8, tnear) - 96usize];
    [
        "Offset of field: RTCRay8::dir_x",
    ][::std::mem::offset_of!(RTCRay8, dir_x) - 128usize];
    [
        "Offset of field: RTCRay8::dir_y",
    ][::std::mem::offset_of!(RTCRay8, dir_y) - 160usize];
    [
        "Offset of field: RTCRay8::dir_z",
    ][::std::mem::offset_of!(RTCRay8, dir_z) - 192usize];
    ["Offset of field: RTCRay8::time"][::std::mem::offset_of!(RTCRay8, time) - 224usize];
    ["Offset of field: RTCRay8::tfar"][::std::mem::offset_of!(RTCRay8, tfar) - 256usize];
    ["Offset of field: RTCRay8::mask"][::std::mem::offset_of!(RTCRay8, mask) - 288usize];
    ["Offset of field: RTCRay8::id"][::std::mem::offset_of!(RTCRay8, id) - 320usize];
    [
        "Offset of field: RTCRay8::flags",
    ][::std::mem::offset_of!(RTCRay8, flags) - 352usize];
};
#[repr(C)]
#[derive(Debug)]
pub struct RTCSceneTy {
    _unused: [u8; 0],
}
pub type RTCScene = *mut RTCSceneTy;
#[repr(C)]
#[derive(Debug)]
pub struct RTCGeometryTy {
    _unused: [u8; 0],
}
pub type RTCGeometry = *mut RTCGeometryTy;
pub const RTC_GEOMETRY_TYPE_TRIANGLE: RTCGeometryType = 0;
pub const RTC_GEOMETRY_TYPE_SUBDIVISION: RTCGeometryType = 8;
pub const RTC_GEOMETRY_TYPE_INSTANCE: RTCGeometryType = 121;
pub type RTCGeometryType = ::std::ffi::c_uint;
pub const RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY: RTCSubdivisionMode = 1;
pub const RTC_SUBDIVISION_MODE_PIN_CORNERS: RTCSubdivisionMode = 2;
pub type RTCSubdivisionMode = ::std::ffi::c_uint;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct RTCInterpolateArguments {
    pub geometry: RTCGeometry,
    pub primID: ::std::ffi::c_uint,
    pub u: f32,
    pub v: f32,
    pub bufferType: RTCBufferType,
    pub bufferSlot: ::std::ffi::c_uint,
    pub P: *mut f32,
    pub dPdu: *mut f32,
    pub dPdv: *mut f32,
    pub ddPdudu: *mut f32,
    pub ddPdvdv: *mut f32,
    pub ddPdudv: *mut f32,
    pub valueCount: ::std::ffi::c_uint,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    [
        "Size of RTCInterpolateArguments",
    ][::std::mem::size_of::<RTCInterpolateArguments>() - 88usize];
    [
        "Alignment of RTCInterpolateArguments",
    ][::std::mem::align_of::<RTCInterpolateArguments>() - 8usize];
    [
        "Offset of field: RTCInterpolateArguments::geometry",
    ][::std::mem::offset_of!(RTCInterpolateArguments, geometry) - 0usize];
    [
        "Offset of field: RTCInterpolateArguments::primID",
    ][::std::mem::offset_of!(RTCInterpolateArguments, primID) - 8usize];
    [
        "Offset of field: RTCInterpolateArguments::u",
    ][::std::mem::offset_of!(RTCInterpolateArguments, u) - 12usize];
    [
        "Offset of field: RTCInterpolateArguments::v",
    ][::std::mem::offset_of!(RTCInterpolateArguments, v) - 16usize];
    [
        "Offset of field: RTCInterpolateArguments::bufferType",
    ][::std::mem::offset_of!(RTCInterpolateArguments, bufferType) - 20usize];
    [
        "Offset of field: RTCInterpolateArguments::bufferSlot",
    ][::std::mem::offset_of!(RTCInterpolateArguments, bufferSlot) - 24usize];
    [
        "Offset of field: RTCInterpolateArguments::P",
    ][::std::mem::offset_of!(RTCInterpolateArguments, P) - 32usize];
    [
        "Offset of field: RTCInterpolateArguments::dPdu",
    ][::std::mem::offset_of!(RTCInterpolateArguments, dPdu) - 40usize];
    [
        "Offset of field: RTCInterpolateArguments::dPdv",
    ][::std::mem::offset_of!(RTCInterpolateArguments, dPdv) - 48usize];
    [
        "Offset of field: RTCInterpolateArguments::ddPdudu",
    ][::std::mem::offset_of!(RTCInterpolateArguments, ddPdudu) - 56usize];
    [
        "Offset of field: RTCInterpolateArguments::ddPdvdv",
    ][::std::mem::offset_of!(RTCInterpolateArguments, ddPdvdv) - 64usize];
    [
        "Offset of field: RTCInterpolateArguments::ddPdudv",
    ][::std::mem::offset_of!(RTCInterpolateArguments, ddPdudv) - 72usize];
    [
        "Offset of field: RTCInterpolateArguments::valueCount",
    ][::std::mem::offset_of!(RTCInterpolateArguments, valueCount) - 80usize];
};
pub const RTC_SCENE_FLAG_NONE: RTCSceneFlags = 0;
pub const RTC_SCENE_FLAG_DYNAMIC: RTCSceneFlags = 1;
pub const RTC_SCENE_FLAG_ROBUST: RTCSceneFlags = 4;
pub type RTCSceneFlags = ::std::ffi::c_uint;
pub const INVALID_ID: ::std::ffi::c_uint = 4294967295;
pub struct Embree {
    __library: ::libloading::Library,
    pub rtcNewDevice: unsafe extern "C" fn(
        config: *const ::std::ffi::c_char,
    ) -> RTCDevice,
    pub rtcReleaseDevice: unsafe extern "C" fn(device: RTCDevice),
    pub rtcGetDeviceProperty: unsafe extern "C" fn(
        device: RTCDevice,
        prop: RTCDeviceProperty,
    ) -> isize,
    pub rtcGetDeviceError: unsafe extern "C" fn(device: RTCDevice) -> RTCError,
    pub rtcSetDeviceErrorFunction: unsafe extern "C" fn(
        device: RTCDevice,
        error: RTCErrorFunction,
        userPtr: *mut ::std::ffi::c_void,
    ),
    pub rtcSetDeviceMemoryMonitorFunction: unsafe extern "C" fn(
        device: RTCDevice,
        memoryMonitor: RTCMemoryMonitorFunction,
        userPtr: *mut ::std::ffi::c_void,
    ),
    pub rtcNewGeometry: unsafe extern "C" fn(
        device: RTCDevice,
        type_: RTCGeometryType,
    ) -> RTCGeometry,
    pub rtcReleaseGeometry: unsafe extern "C" fn(geometry: RTCGeometry),
    pub rtcCommitGeometry: unsafe extern "C" fn(geometry: RTCGeometry),
    pub rtcSetGeometryBuildQuality: unsafe extern "C" fn(
        geometry: RTCGeometry,
        quality: RTCBuildQuality,
    ),
    pub rtcSetNewGeometryBuffer: unsafe extern "C" fn(
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
        format: RTCFormat,
        byteStride: usize,
        itemCount: usize,
    ) -> *mut ::std::ffi::c_void,
    pub rtcGetGeometryBufferData: unsafe extern "C" fn(
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
    ) -> *mut ::std::ffi::c_void,
    pub rtcUpdateGeometryBuffer: unsafe extern "C" fn(
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
    ),
    pub rtcSetGeometryInstancedScene: unsafe extern "C" fn(
        geometry: RTCGeometry,
        scene: RTCScene,
    ),
    pub rtcSetGeometryTransform: unsafe extern "C" fn(
        geometry: RTCGeometry,
        timeStep: ::std::ffi::c_uint,
        format: RTCFormat,
        xfm: *const ::std::ffi::c_void,
    ),
    pub rtcSetGeometrySubdivisionMode: unsafe extern "C" fn(
        geometry: RTCGeometry,
        topologyID: ::std::ffi::c_uint,
        mode: RTCSubdivisionMode,
    ),
    pub rtcInterpolate: unsafe extern "C" fn(args: *const RTCInterpolateArguments),
    pub rtcNewScene: unsafe extern "C" fn(device: RTCDevice) -> RTCScene,
    pub rtcReleaseScene: unsafe extern "C" fn(scene: RTCScene),
    pub rtcAttachGeometryByID: unsafe extern "C" fn(
        scene: RTCScene,
        geometry: RTCGeometry,
        geomID: ::std::ffi::c_uint,
    ),
    pub rtcDetachGeometry: unsafe extern "C" fn(
        scene: RTCScene,
        geomID: ::std::ffi::c_uint,
    ),
    pub rtcCommitScene: unsafe extern "C" fn(scene: RTCScene),
    pub rtcSetSceneBuildQuality: unsafe extern "C" fn(
        scene: RTCScene,
        quality: RTCBuildQuality,
    ),
    pub rtcSetSceneFlags: unsafe extern "C" fn(scene: RTCScene, flags: RTCSceneFlags),
}
impl Embree {
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
        let rtcNewDevice = unsafe { __library.get(b"rtcNewDevice\0") }.map(|sym| *sym)?;
        let rtcReleaseDevice = unsafe { __library.get(b"rtcReleaseDevice\0") }
            .map(|sym| *sym)?;
        let rtcGetDeviceProperty = unsafe { __library.get(b"rtcGetDeviceProperty\0") }
            .map(|sym| *sym)?;
        let rtcGetDeviceError = unsafe { __library.get(b"rtcGetDeviceError\0") }
            .map(|sym| *sym)?;
        let rtcSetDeviceErrorFunction = unsafe {
            __library.get(b"rtcSetDeviceErrorFunction\0")
        }
            .map(|sym| *sym)?;
        let rtcSetDeviceMemoryMonitorFunction = unsafe {
            __library.get(b"rtcSetDeviceMemoryMonitorFunction\0")
        }
            .map(|sym| *sym)?;
        let rtcNewGeometry = unsafe { __library.get(b"rtcNewGeometry\0") }
            .map(|sym| *sym)?;
        let rtcReleaseGeometry = unsafe { __library.get(b"rtcReleaseGeometry\0") }
            .map(|sym| *sym)?;
        let rtcCommitGeometry = unsafe { __library.get(b"rtcCommitGeometry\0") }
            .map(|sym| *sym)?;
        let rtcSetGeometryBuildQuality = unsafe {
            __library.get(b"rtcSetGeometryBuildQuality\0")
        }
            .map(|sym| *sym)?;
        let rtcSetNewGeometryBuffer = unsafe {
            __library.get(b"rtcSetNewGeometryBuffer\0")
        }
            .map(|sym| *sym)?;
        let rtcGetGeometryBufferData = unsafe {
            __library.get(b"rtcGetGeometryBufferData\0")
        }
            .map(|sym| *sym)?;
        let rtcUpdateGeometryBuffer = unsafe {
            __library.get(b"rtcUpdateGeometryBuffer\0")
        }
            .map(|sym| *sym)?;
        let rtcSetGeometryInstancedScene = unsafe {
            __library.get(b"rtcSetGeometryInstancedScene\0")
        }
            .map(|sym| *sym)?;
        let rtcSetGeometryTransform = unsafe {
            __library.get(b"rtcSetGeometryTransform\0")
        }
            .map(|sym| *sym)?;
        let rtcSetGeometrySubdivisionMode = unsafe {
            __library.get(b"rtcSetGeometrySubdivisionMode\0")
        }
            .map(|sym| *sym)?;
        let rtcInterpolate = unsafe { __library.get(b"rtcInterpolate\0") }
            .map(|sym| *sym)?;
        let rtcNewScene = unsafe { __library.get(b"rtcNewScene\0") }.map(|sym| *sym)?;
        let rtcReleaseScene = unsafe { __library.get(b"rtcReleaseScene\0") }
            .map(|sym| *sym)?;
        let rtcAttachGeometryByID = unsafe { __library.get(b"rtcAttachGeometryByID\0") }
            .map(|sym| *sym)?;
        let rtcDetachGeometry = unsafe { __library.get(b"rtcDetachGeometry\0") }
            .map(|sym| *sym)?;
        let rtcCommitScene = unsafe { __library.get(b"rtcCommitScene\0") }
            .map(|sym| *sym)?;
        let rtcSetSceneBuildQuality = unsafe {
            __library.get(b"rtcSetSceneBuildQuality\0")
        }
            .map(|sym| *sym)?;
        let rtcSetSceneFlags = unsafe { __library.get(b"rtcSetSceneFlags\0") }
            .map(|sym| *sym)?;
        Ok(Embree {
            __library,
            rtcNewDevice,
            rtcReleaseDevice,
            rtcGetDeviceProperty,
            rtcGetDeviceError,
            rtcSetDeviceErrorFunction,
            rtcSetDeviceMemoryMonitorFunction,
            rtcNewGeometry,
            rtcReleaseGeometry,
            rtcCommitGeometry,
            rtcSetGeometryBuildQuality,
            rtcSetNewGeometryBuffer,
            rtcGetGeometryBufferData,
            rtcUpdateGeometryBuffer,
            rtcSetGeometryInstancedScene,
            rtcSetGeometryTransform,
            rtcSetGeometrySubdivisionMode,
            rtcInterpolate,
            rtcNewScene,
            rtcReleaseScene,
            rtcAttachGeometryByID,
            rtcDetachGeometry,
            rtcCommitScene,
            rtcSetSceneBuildQuality,
            rtcSetSceneFlags,
        })
    }
    pub unsafe fn rtcNewDevice(&self, config: *const ::std::ffi::c_char) -> RTCDevice {
        unsafe { (self.rtcNewDevice)(config) }
    }
    pub unsafe fn rtcReleaseDevice(&self, device: RTCDevice) {
        unsafe { (self.rtcReleaseDevice)(device) }
    }
    pub unsafe fn rtcGetDeviceProperty(
        &self,
        device: RTCDevice,
        prop: RTCDeviceProperty,
    ) -> isize {
        unsafe { (self.rtcGetDeviceProperty)(device, prop) }
    }
    pub unsafe fn rtcGetDeviceError(&self, device: RTCDevice) -> RTCError {
        unsafe { (self.rtcGetDeviceError)(device) }
    }
    pub unsafe fn rtcSetDeviceErrorFunction(
        &self,
        device: RTCDevice,
        error: RTCErrorFunction,
        userPtr: *mut ::std::ffi::c_void,
    ) {
        unsafe { (self.rtcSetDeviceErrorFunction)(device, error, userPtr) }
    }
    pub unsafe fn rtcSetDeviceMemoryMonitorFunction(
        &self,
        device: RTCDevice,
        memoryMonitor: RTCMemoryMonitorFunction,
        userPtr: *mut ::std::ffi::c_void,
    ) {
        unsafe {
            (self.rtcSetDeviceMemoryMonitorFunction)(device, memoryMonitor, userPtr)
        }
    }
    pub unsafe fn rtcNewGeometry(
        &self,
        device: RTCDevice,
        type_: RTCGeometryType,
    ) -> RTCGeometry {
        unsafe { (self.rtcNewGeometry)(device, type_) }
    }
    pub unsafe fn rtcReleaseGeometry(&self, geometry: RTCGeometry) {
        unsafe { (self.rtcReleaseGeometry)(geometry) }
    }
    pub unsafe fn rtcCommitGeometry(&self, geometry: RTCGeometry) {
        unsafe { (self.rtcCommitGeometry)(geometry) }
    }
    pub unsafe fn rtcSetGeometryBuildQuality(
        &self,
        geometry: RTCGeometry,
        quality: RTCBuildQuality,
    ) {
        unsafe { (self.rtcSetGeometryBuildQuality)(geometry, quality) }
    }
    pub unsafe fn rtcSetNewGeometryBuffer(
        &self,
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
        format: RTCFormat,
        byteStride: usize,
        itemCount: usize,
    ) -> *mut ::std::ffi::c_void {
        unsafe {
            (self
                .rtcSetNewGeometryBuffer)(
                geometry,
                type_,
                slot,
                format,
                byteStride,
                itemCount,
            )
        }
    }
    pub unsafe fn rtcGetGeometryBufferData(
        &self,
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
    ) -> *mut ::std::ffi::c_void {
        unsafe { (self.rtcGetGeometryBufferData)(geometry, type_, slot) }
    }
    pub unsafe fn rtcUpdateGeometryBuffer(
        &self,
        geometry: RTCGeometry,
        type_: RTCBufferType,
        slot: ::std::ffi::c_uint,
    ) {
        unsafe { (self.rtcUpdateGeometryBuffer)(geometry, type_, slot) }
    }
    pub unsafe fn rtcSetGeometryInstancedScene(
        &self,
        geometry: RTCGeometry,
        scene: RTCScene,
    ) {
        unsafe { (self.rtcSetGeometryInstancedScene)(geometry, scene) }
    }
    pub unsafe fn rtcSetGeometryTransform(
        &self,
        geometry: RTCGeometry,
        timeStep: ::std::ffi::c_uint,
        format: RTCFormat,
        xfm: *const ::std::ffi::c_void,
    ) {
        unsafe { (self.rtcSetGeometryTransform)(geometry, timeStep, format, xfm) }
    }
    pub unsafe fn rtcSetGeometrySubdivisionMode(
        &self,
        geometry: RTCGeometry,
        topologyID: ::std::ffi::c_uint,
        mode: RTCSubdivisionMode,
    ) {
        unsafe { (self.rtcSetGeometrySubdivisionMode)(geometry, topologyID, mode) }
    }
    pub unsafe fn rtcInterpolate(&self, args: *const RTCInterpolateArguments) {
        unsafe { (self.rtcInterpolate)(args) }
    }
    pub unsafe fn rtcNewScene(&self, device: RTCDevice) -> RTCScene {
        unsafe { (self.rtcNewScene)(device) }
    }
    pub unsafe fn rtcReleaseScene(&self, scene: RTCScene) {
        unsafe { (self.rtcReleaseScene)(scene) }
    }
    pub unsafe fn rtcAttachGeometryByID(
        &self,
        scene: RTCScene,
        geometry: RTCGeometry,
        geomID: ::std::ffi::c_uint,
    ) {
        unsafe { (self.rtcAttachGeometryByID)(scene, geometry, geomID) }
    }
    pub unsafe fn rtcDetachGeometry(&self, scene: RTCScene, geomID: ::std::ffi::c_uint) {
        unsafe { (self.rtcDetachGeometry)(scene, geomID) }
    }
    pub unsafe fn rtcCommitScene(&self, scene: RTCScene) {
        unsafe { (self.rtcCommitScene)(scene) }
    }
    pub unsafe fn rtcSetSceneBuildQuality(
        &self,
        scene: RTCScene,
        quality: RTCBuildQuality,
    ) {
        unsafe { (self.rtcSetSceneBuildQuality)(scene, quality) }
    }
    pub unsafe fn rtcSetSceneFlags(&self, scene: RTCScene, flags: RTCSceneFlags) {
        unsafe { (self.rtcSetSceneFlags)(scene, flags) }
    }
}
