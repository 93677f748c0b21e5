//! Structures and constants of the C interface of Embree 3.13 and 4, as their public headers lay them out. Sizes and
//! offsets are held by tests. Hits have room for what 4.3 and later write at their end.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// An `RTCDevice`.
pub type DeviceHandle = *mut c_void;
/// An `RTCScene`.
pub type SceneHandle = *mut c_void;
/// An `RTCGeometry`.
pub type GeometryHandle = *mut c_void;

/// The id of no geometry, no instance and no primitive.
pub const INVALID_ID: u32 = u32::MAX;

/// Ids for `rtcGetDeviceProperty`.
pub mod property {
    pub const VERSION: super::c_int = 0;
    pub const TASKING_SYSTEM: super::c_int = 128;
}

/// What `TASKING_SYSTEM` answers for TBB.
pub const TASKING_TBB: isize = 1;

/// `RTCGeometryType`.
pub mod geometry {
    pub const TRIANGLE: super::c_int = 0;
    pub const SUBDIVISION: super::c_int = 8;
    pub const INSTANCE: super::c_int = 121;
}

/// `RTCBufferType`.
pub mod buffer {
    pub const INDEX: super::c_int = 0;
    pub const VERTEX: super::c_int = 1;
    pub const FACE: super::c_int = 16;
    pub const EDGE_CREASE_INDEX: super::c_int = 18;
    pub const EDGE_CREASE_WEIGHT: super::c_int = 19;
    pub const VERTEX_CREASE_INDEX: super::c_int = 20;
    pub const VERTEX_CREASE_WEIGHT: super::c_int = 21;
    pub const HOLE: super::c_int = 22;
}

/// `RTCFormat`.
pub mod format {
    pub const UINT: super::c_int = 0x5001;
    pub const UINT2: super::c_int = 0x5002;
    pub const UINT3: super::c_int = 0x5003;
    pub const FLOAT: super::c_int = 0x9001;
    pub const FLOAT3: super::c_int = 0x9003;
    pub const FLOAT3X4_COLUMN_MAJOR: super::c_int = 0x9234;
}

/// `RTC_BUILD_QUALITY_LOW`: the Morton-order builder.
pub const QUALITY_LOW: c_int = 0;
/// `RTC_BUILD_QUALITY_MEDIUM`: the surface area heuristic.
pub const QUALITY_MEDIUM: c_int = 1;
/// `RTC_SCENE_FLAG_DYNAMIC`: one tree per geometry under a small one, so that an edit rebuilds what it touched.
pub const SCENE_DYNAMIC: c_int = 1;
/// `RTC_SCENE_FLAG_ROBUST`: rays do not slip through between triangles that share an edge.
pub const SCENE_ROBUST: c_int = 4;

/// `RTCRay`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub struct RayRecord {
    pub origin: [f32; 3],
    pub near: f32,
    pub direction: [f32; 3],
    pub time: f32,
    pub far: f32,
    pub mask: c_uint,
    pub id: c_uint,
    pub flags: c_uint,
}

/// `RTCHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub struct HitRecord {
    pub normal: [f32; 3],
    pub u: f32,
    pub v: f32,
    pub primitive: c_uint,
    pub geometry: c_uint,
    pub instance: [c_uint; 1],
    /// Which of an array of instances, since 4.3.
    pub instance_primitive: [c_uint; 1],
}

/// `RTCRayHit`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RayHitRecord {
    pub ray: RayRecord,
    pub hit: HitRecord,
}

/// `RTCRay8`.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Ray8Record {
    pub origin: [[f32; 8]; 3],
    pub near: [f32; 8],
    pub direction: [[f32; 8]; 3],
    pub time: [f32; 8],
    pub far: [f32; 8],
    pub mask: [c_uint; 8],
    pub id: [c_uint; 8],
    pub flags: [c_uint; 8],
}

/// `RTCHit8`.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Hit8Record {
    pub normal: [[f32; 8]; 3],
    pub u: [f32; 8],
    pub v: [f32; 8],
    pub primitive: [c_uint; 8],
    pub geometry: [c_uint; 8],
    pub instance: [[c_uint; 8]; 1],
    /// As in [`HitRecord`].
    pub instance_primitive: [[c_uint; 8]; 1],
}

/// `RTCRayHit8`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RayHit8Record {
    pub ray: Ray8Record,
    pub hit: Hit8Record,
}

/// Which rays of a packet are traced: −1 for yes, 0 for no.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Valid8(pub [c_int; 8]);

/// `RTC_INTERSECT_CONTEXT_FLAG_COHERENT`: the rays of a packet go much the same way.
pub const CONTEXT_COHERENT: c_int = 1;

/// `RTCIntersectContext` of 3.x.
#[repr(C)]
#[derive(Debug)]
pub struct IntersectContext {
    pub flags: c_int,
    pub filter: *const c_void,
    pub instance: [c_uint; 1],
}

/// `RTC_RAY_QUERY_FLAG_COHERENT` of 4.x.
pub const QUERY_COHERENT: c_int = 1 << 16;
/// `RTC_FEATURE_FLAG_ALL` of 4.x.
pub const FEATURES_ALL: c_uint = c_uint::MAX;

/// `RTCIntersectArguments` and `RTCOccludedArguments` of 4.x, whose last field only some builds have.
#[repr(C)]
#[derive(Debug)]
pub struct QueryArguments {
    pub flags: c_int,
    pub features: c_uint,
    pub context: *const c_void,
    pub filter: *const c_void,
    pub callback: *const c_void,
    pub least_width: f32,
}

/// `RTCInterpolateArguments`.
#[repr(C)]
#[derive(Debug)]
pub struct InterpolateArguments {
    pub geometry: GeometryHandle,
    pub primitive: c_uint,
    pub u: f32,
    pub v: f32,
    pub buffer: c_int,
    pub slot: c_uint,
    pub p: *mut f32,
    pub du: *mut f32,
    pub dv: *mut f32,
    pub duu: *mut f32,
    pub dvv: *mut f32,
    pub duv: *mut f32,
    pub width: c_uint,
}

/// `RTCErrorFunction`.
pub type ErrorFunction = unsafe extern "C" fn(user: *mut c_void, code: c_int, message: *const c_char);

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{align_of, offset_of, size_of};

    #[test]
    fn structures_have_the_layout_of_the_headers() {
        assert_eq!((size_of::<RayRecord>(), align_of::<RayRecord>()), (48, 16));
        assert_eq!(offset_of!(RayRecord, far), 32);
        assert_eq!((size_of::<HitRecord>(), align_of::<HitRecord>()), (48, 16));
        assert_eq!((offset_of!(HitRecord, instance), offset_of!(HitRecord, instance_primitive)), (28, 32));
        assert_eq!(offset_of!(RayHitRecord, hit), 48);
        assert_eq!((size_of::<Ray8Record>(), align_of::<Ray8Record>()), (384, 32));
        assert_eq!((offset_of!(Hit8Record, instance_primitive), offset_of!(RayHit8Record, hit)), (256, 384));
        assert_eq!((offset_of!(Ray8Record, far), offset_of!(Hit8Record, geometry)), (256, 192));
        assert_eq!((size_of::<IntersectContext>(), offset_of!(IntersectContext, instance)), (24, 16));
        assert_eq!((offset_of!(QueryArguments, context), offset_of!(QueryArguments, least_width)), (8, 32));
        assert_eq!(offset_of!(InterpolateArguments, p), 32);
        assert_eq!(offset_of!(InterpolateArguments, width), 80);
    }
}
