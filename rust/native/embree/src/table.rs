//! The table of Embree's functions, one per process.
//!
//! Most functions have the same signature in every 3.x and 4.x; what differs between major versions, tracing, is
//! behind [`Trace`], so that another version is another implementation of it.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use relievo_core::{Error, ErrorKind, Result};

use crate::abi::{
    self, DeviceHandle, GeometryHandle, IntersectContext, QueryArguments, Ray8Record, RayHit8Record, RayHitRecord,
    RayRecord, SceneHandle, Valid8,
};
use crate::arena::Arena;

/// The files of which the first that is there is opened, unless `RELIEVO_EMBREE` names another.
const FILES: [&str; 2] = ["libembree3.so.3", "libembree4.so.4"];

/// What to do where there is no Embree that can be used.
const ADVICE: &str =
    "install Embree 3.13 (Debian: libembree3-3) or 4, or set RELIEVO_EMBREE to the file of one of these";

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

/// Tracing as 4.x has it, with arguments that say how.
struct Trace4 {
    intersect: unsafe extern "C" fn(SceneHandle, *mut RayHitRecord, *mut QueryArguments),
    occluded: unsafe extern "C" fn(SceneHandle, *mut RayRecord, *mut QueryArguments),
    intersect8: unsafe extern "C" fn(*const Valid8, SceneHandle, *mut RayHit8Record, *mut QueryArguments),
    occluded8: unsafe extern "C" fn(*const Valid8, SceneHandle, *mut Ray8Record, *mut QueryArguments),
}

impl Trace4 {
    fn arguments(flags: c_int) -> QueryArguments {
        let none = std::ptr::null();
        let features = abi::FEATURES_ALL;
        QueryArguments { flags, features, context: none, filter: none, callback: none, least_width: 0.0 }
    }
}

impl Trace for Trace4 {
    unsafe fn intersect(&self, scene: SceneHandle, ray_hit: &mut RayHitRecord) {
        // SAFETY: the caller vouches for the scene; the structures are those of the version that was checked.
        unsafe { (self.intersect)(scene, ray_hit, &mut Self::arguments(0)) }
    }

    unsafe fn occluded(&self, scene: SceneHandle, ray: &mut RayRecord) {
        // SAFETY: as above.
        unsafe { (self.occluded)(scene, ray, &mut Self::arguments(0)) }
    }

    unsafe fn intersect8(&self, valid: &Valid8, scene: SceneHandle, ray_hit: &mut RayHit8Record) {
        // SAFETY: as above; the records are aligned to their 32 bytes.
        unsafe { (self.intersect8)(valid, scene, ray_hit, &mut Self::arguments(abi::QUERY_COHERENT)) }
    }

    unsafe fn occluded8(&self, valid: &Valid8, scene: SceneHandle, ray: &mut Ray8Record) {
        // SAFETY: as above.
        unsafe { (self.occluded8)(valid, scene, ray, &mut Self::arguments(abi::QUERY_COHERENT)) }
    }
}

/// How the major version `major` of `library` traces.
///
/// # Safety
/// `library` is an Embree of that version.
unsafe fn trace(library: &Library, major: u32) -> Result<Box<dyn Trace>> {
    let names = ["rtcIntersect1", "rtcOccluded1", "rtcIntersect8", "rtcOccluded8"];
    let [intersect, occluded, intersect8, occluded8] = names;
    // SAFETY: the symbols have these signatures in every 3.x and 4.x.
    unsafe {
        Ok(if major == 3 {
            Box::new(Trace3 {
                intersect: symbol(library, intersect)?,
                occluded: symbol(library, occluded)?,
                intersect8: symbol(library, intersect8)?,
                occluded8: symbol(library, occluded8)?,
            })
        } else {
            Box::new(Trace4 {
                intersect: symbol(library, intersect)?,
                occluded: symbol(library, occluded)?,
                intersect8: symbol(library, intersect8)?,
                occluded8: symbol(library, occluded8)?,
            })
        })
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
            /// Kept loaded by this; tests look for more in it.
            #[cfg_attr(not(test), expect(dead_code))]
            pub library: Library,
        }

        impl Table {
            fn of(library: Library) -> Result<Self> {
                let (version, arena) = admit(&library)?;
                // SAFETY: the symbols have these signatures in every version that is admitted.
                unsafe {
                    Ok(Self {
                        $($field: symbol(&library, $symbol)?,)*
                        trace: trace(&library, version[0])?,
                        version,
                        arena,
                        library,
                    })
                }
            }
        }
    };
}

functions! {
    new_device = "rtcNewDevice": fn(*const c_char) -> DeviceHandle;
    release_device = "rtcReleaseDevice": fn(DeviceHandle);
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
    unsafe { library.get::<F>(name.as_bytes()) }
        .map(|symbol| *symbol)
        .map_err(|error| Error::unsupported(format!("Embree lacks the function `{name}`: {error}")).advise(ADVICE))
}

impl Table {
    /// Opens `file` with local symbols and checks what it is.
    pub fn open(file: &str) -> Result<Self> {
        // SAFETY: opening a library runs its initialisers; which library that is, is the user's choice.
        let library = unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) }.map_err(|error| {
            let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
            Error::new(ErrorKind::NotFound, format!("Embree cannot be loaded: {reason}")).at(file).advise(ADVICE)
        })?;
        Self::of(library).map_err(|error| error.at(file))
    }
}

/// The version of `library`, found with a device that is thrown away, and the arena for its devices. Fails if it is
/// another than [`Trace3`] and [`Trace4`] know.
fn admit(library: &Library) -> Result<([u32; 3], Option<Arena>)> {
    // SAFETY: these functions have the same signature in all versions since 3.0; a null configuration is allowed.
    let (version, tasking) = unsafe {
        let new_device: unsafe extern "C" fn(*const c_char) -> DeviceHandle = symbol(library, "rtcNewDevice")?;
        let device_error: unsafe extern "C" fn(DeviceHandle) -> c_int = symbol(library, "rtcGetDeviceError")?;
        let property: unsafe extern "C" fn(DeviceHandle, c_int) -> isize = symbol(library, "rtcGetDeviceProperty")?;
        let release: unsafe extern "C" fn(DeviceHandle) = symbol(library, "rtcReleaseDevice")?;
        let device = new_device(std::ptr::null());
        if device.is_null() {
            let code = device_error(std::ptr::null_mut());
            return Err(Error::unsupported(format!("Embree makes no device (its error {code})"))
                .advise("it needs a processor with SSE2 and enough memory"));
        }
        let found = (property(device, abi::property::VERSION), property(device, abi::property::TASKING_SYSTEM));
        release(device);
        found
    };
    let version = u32::try_from(version).unwrap_or(0);
    let version = [version / 10_000, version / 100 % 100, version % 100];
    if !is_known(version) {
        let [major, minor, patch] = version;
        return Err(Error::unsupported(format!("this is Embree {major}.{minor}.{patch}")).advise(ADVICE));
    }
    Ok((version, if tasking == abi::TASKING_TBB { Arena::find(library) } else { None }))
}

/// Whether there is a table for a version.
fn is_known([major, minor, _]: [u32; 3]) -> bool {
    major == 4 || major == 3 && minor >= 13
}

/// The table of this process, loaded on first use.
pub fn table() -> Result<&'static Table> {
    static TABLE: OnceLock<Result<Table>> = OnceLock::new();
    let loaded = TABLE.get_or_init(|| {
        let file = std::env::var("RELIEVO_EMBREE").ok().filter(|file| !file.is_empty());
        match file {
            Some(file) => Table::open(&file),
            // What is said is said of the first.
            None => Table::open(FILES[0]).or_else(|error| Table::open(FILES[1]).map_err(|_| error)),
        }
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
        assert!(is_known(table.version), "{:?}", table.version);
    }
}
