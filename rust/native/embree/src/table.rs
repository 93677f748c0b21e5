//! The table of Embree's functions, one per process.
//!
//! Most functions have the same signature in every 3.x and 4.x; what differs between major versions, tracing, is
//! behind [`Trace`], so that another version is another implementation of it.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use relievo_core::{Error, ErrorKind, Result};

use crate::abi::{
    self, DeviceHandle, GeometryHandle, IntersectContext, Ray8Record, RayHit8Record, RayHitRecord, RayRecord,
    SceneHandle, Valid8,
};
use crate::arena::Arena;

/// The file that is opened unless `RELIEVO_EMBREE` names another.
const FILE: &str = "libembree3.so.3";

/// Tracing of rays, whose signature depends on the major version.
pub trait Trace: Send + Sync {
    /// Closest hit.
    ///
    /// # Safety
    /// `scene` is alive and committed, and nobody changes it during the call.
    unsafe fn intersect(&self, scene: SceneHandle, ray_hit: &mut RayHitRecord);

    /// Any hit: `far` of the ray becomes negative infinity if there is one.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn occluded(&self, scene: SceneHandle, ray: &mut RayRecord);

    /// Closest hits of eight rays that go much the same way.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn intersect8(&self, valid: &Valid8, scene: SceneHandle, ray_hit: &mut RayHit8Record);

    /// As `occluded`, for eight rays that go much the same way.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn occluded8(&self, valid: &Valid8, scene: SceneHandle, ray: &mut Ray8Record);
}

/// Tracing as 3.x has it, with a context structure.
struct Trace3 {
    intersect: unsafe extern "C" fn(SceneHandle, *mut IntersectContext, *mut RayHitRecord),
    occluded: unsafe extern "C" fn(SceneHandle, *mut IntersectContext, *mut RayRecord),
    intersect8: unsafe extern "C" fn(*const Valid8, SceneHandle, *mut IntersectContext, *mut RayHit8Record),
    occluded8: unsafe extern "C" fn(*const Valid8, SceneHandle, *mut IntersectContext, *mut Ray8Record),
}

impl Trace3 {
    fn context(flags: c_int) -> IntersectContext {
        IntersectContext { flags, filter: std::ptr::null(), instance: [abi::INVALID_ID] }
    }
}

impl Trace for Trace3 {
    unsafe fn intersect(&self, scene: SceneHandle, ray_hit: &mut RayHitRecord) {
        // SAFETY: the caller vouches for the scene; the structures are those of the version that was checked.
        unsafe { (self.intersect)(scene, &mut Self::context(0), ray_hit) }
    }

    unsafe fn occluded(&self, scene: SceneHandle, ray: &mut RayRecord) {
        // SAFETY: as above.
        unsafe { (self.occluded)(scene, &mut Self::context(0), ray) }
    }

    unsafe fn intersect8(&self, valid: &Valid8, scene: SceneHandle, ray_hit: &mut RayHit8Record) {
        // SAFETY: as above; the records are aligned to their 32 bytes.
        unsafe { (self.intersect8)(valid, scene, &mut Self::context(abi::CONTEXT_COHERENT), ray_hit) }
    }

    unsafe fn occluded8(&self, valid: &Valid8, scene: SceneHandle, ray: &mut Ray8Record) {
        // SAFETY: as above.
        unsafe { (self.occluded8)(valid, scene, &mut Self::context(abi::CONTEXT_COHERENT), ray) }
    }
}

/// Declares the functions common to all versions and how they are looked up.
macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of Embree, and the library that keeps them loaded.
        pub struct Table {
            $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            pub trace: Box<dyn Trace>,
            /// Major, minor and patch number.
            pub version: [u32; 3],
            /// The one-thread arena in which devices are made, where Embree schedules with TBB.
            pub arena: Option<Arena>,
            _library: Library,
        }

        impl Table {
            fn of(library: Library) -> Result<Self> {
                // SAFETY: the symbols have these signatures in every version that `admit` lets pass, and none is
                // called before that but those which never changed.
                unsafe {
                    let mut table = Self {
                        $($field: symbol(&library, $symbol)?,)*
                        trace: Box::new(Trace3 {
                            intersect: symbol(&library, "rtcIntersect1")?,
                            occluded: symbol(&library, "rtcOccluded1")?,
                            intersect8: symbol(&library, "rtcIntersect8")?,
                            occluded8: symbol(&library, "rtcOccluded8")?,
                        }),
                        version: [0; 3],
                        arena: None,
                        _library: library,
                    };
                    table.admit()?;
                    Ok(table)
                }
            }
        }
    };
}

functions! {
    new_device = "rtcNewDevice": fn(*const c_char) -> DeviceHandle;
    release_device = "rtcReleaseDevice": fn(DeviceHandle);
    device_property = "rtcGetDeviceProperty": fn(DeviceHandle, c_int) -> isize;
    device_error = "rtcGetDeviceError": fn(DeviceHandle) -> c_int;
    set_error_function = "rtcSetDeviceErrorFunction": fn(DeviceHandle, Option<abi::ErrorFunction>, *mut c_void);
    new_scene = "rtcNewScene": fn(DeviceHandle) -> SceneHandle;
    release_scene = "rtcReleaseScene": fn(SceneHandle);
    set_scene_flags = "rtcSetSceneFlags": fn(SceneHandle, c_int);
    set_scene_quality = "rtcSetSceneBuildQuality": fn(SceneHandle, c_int);
    commit_scene = "rtcCommitScene": fn(SceneHandle);
    attach = "rtcAttachGeometryByID": fn(SceneHandle, GeometryHandle, c_uint);
    detach = "rtcDetachGeometry": fn(SceneHandle, c_uint);
    new_geometry = "rtcNewGeometry": fn(DeviceHandle, c_int) -> GeometryHandle;
    release_geometry = "rtcReleaseGeometry": fn(GeometryHandle);
    commit_geometry = "rtcCommitGeometry": fn(GeometryHandle);
    set_geometry_quality = "rtcSetGeometryBuildQuality": fn(GeometryHandle, c_int);
    new_buffer = "rtcSetNewGeometryBuffer": fn(GeometryHandle, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
    buffer_data = "rtcGetGeometryBufferData": fn(GeometryHandle, c_int, c_uint) -> *mut c_void;
    update_buffer = "rtcUpdateGeometryBuffer": fn(GeometryHandle, c_int, c_uint);
    set_instanced = "rtcSetGeometryInstancedScene": fn(GeometryHandle, SceneHandle);
    set_transform = "rtcSetGeometryTransform": fn(GeometryHandle, c_uint, c_int, *const c_void);
    set_subdivision_mode = "rtcSetGeometrySubdivisionMode": fn(GeometryHandle, c_uint, c_int);
    interpolate = "rtcInterpolate": fn(*const abi::InterpolateArguments);
}

/// The function `name` of `library`.
///
/// # Safety
/// `F` is the function pointer type of that function.
unsafe fn symbol<F: Copy>(library: &Library, name: &str) -> Result<F> {
    // SAFETY: the caller vouches for the type.
    unsafe { library.get::<F>(name.as_bytes()) }.map(|symbol| *symbol).map_err(|error| {
        Error::unsupported(format!("Embree lacks the function `{name}`: {error}"))
            .advise("install Embree 3.13 (Debian: libembree3-3)")
    })
}

impl Table {
    /// Opens `file` with local symbols and checks what it is.
    pub fn open(file: &str) -> Result<Self> {
        // SAFETY: opening a library runs its initialisers; which library that is, is the user's choice.
        let library = unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) }.map_err(|error| {
            Error::new(ErrorKind::NotFound, format!("Embree cannot be loaded: {error}"))
                .at(file)
                .advise("install libembree3-3, or set RELIEVO_EMBREE to the file of an Embree 3.13")
        })?;
        Self::of(library).map_err(|error| error.at(file))
    }

    /// Checks the version with a device that is thrown away, and finds out how threads are scheduled.
    fn admit(&mut self) -> Result<()> {
        // SAFETY: these functions have the same signature in all versions since 3.0; a null configuration is allowed.
        let (version, tasking) = unsafe {
            let device = (self.new_device)(std::ptr::null());
            if device.is_null() {
                let code = (self.device_error)(std::ptr::null_mut());
                return Err(Error::unsupported(format!("Embree makes no device (its error {code})"))
                    .advise("it needs a processor with SSE2 and enough memory"));
            }
            let version = (self.device_property)(device, abi::property::VERSION);
            let tasking = (self.device_property)(device, abi::property::TASKING_SYSTEM);
            (self.release_device)(device);
            (version, tasking)
        };
        let version = u32::try_from(version).unwrap_or(0);
        self.version = [version / 10_000, version / 100 % 100, version % 100];
        if self.version[0] != 3 || self.version[1] < 13 {
            let [major, minor, patch] = self.version;
            return Err(Error::unsupported(format!("this is Embree {major}.{minor}.{patch}"))
                .advise("use Embree 3.13 (Debian: libembree3-3), whose file RELIEVO_EMBREE may name"));
        }
        if tasking == abi::TASKING_TBB {
            self.arena = Arena::find();
        }
        Ok(())
    }
}

/// The table of this process, loaded on first use.
pub fn table() -> Result<&'static Table> {
    static TABLE: OnceLock<Result<Table>> = OnceLock::new();
    let loaded = TABLE.get_or_init(|| {
        let file = std::env::var("RELIEVO_EMBREE").ok().filter(|file| !file.is_empty());
        Table::open(file.as_deref().unwrap_or(FILE))
    });
    loaded.as_ref().map_err(Error::clone)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_library_and_a_foreign_one_are_errors_with_advice() {
        let missing = Table::open("libembree-that-is-not-there.so").err().unwrap();
        assert_eq!(missing.kind, ErrorKind::NotFound);
        assert!(missing.to_string().contains("RELIEVO_EMBREE"), "{missing}");
        let foreign = Table::open("libc.so.6").err().unwrap();
        assert_eq!(foreign.kind, ErrorKind::Unsupported);
        assert!(foreign.to_string().contains("rtc"), "{foreign}");
    }

    #[test]
    fn the_system_library_is_admitted() {
        let table = table().unwrap();
        assert_eq!(table.version[0], 3);
        assert!(table.version[1] >= 13);
    }
}
