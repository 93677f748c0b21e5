//! The table of Embree's functions, one per process.
//!
//! Most functions have the same signature in every 3.x and 4.x; what differs between major versions, tracing, is
//! behind [`Trace`], so that another version is another implementation of it. The tables are made by bindgen, and filled
//! from a library that is opened here.

use std::sync::OnceLock;

use relievo_core::{Error, ErrorKind, Result};

use crate::abi::embree3::{self, Embree3, RTCIntersectContext};
use crate::abi::embree4::{self, Embree4, RTCIntersectArguments, RTCOccludedArguments};
use crate::abi::{self, Embree, INVALID_ID, RTCRay, RTCRay8, RTCRayHit, RTCRayHit8, RTCScene, Valid8};
use crate::arena::Arena;
use crate::binding;
use crate::loader::Library;

/// The files of which the first that is there is opened, unless `RELIEVO_EMBREE` names another.
const FILES: [&str; 2] = if cfg!(windows) {
    ["embree3.dll", "embree4.dll"]
} else if cfg!(target_vendor = "apple") {
    // Homebrew's, whose folder the loader does not look into.
    ["libembree4.dylib", "/opt/homebrew/lib/libembree4.dylib"]
} else {
    ["libembree3.so.3", "libembree4.so.4"]
};

/// What to do where there is no Embree that can be used.
const ADVICE: &str =
    "install Embree 3.13 (Debian: libembree3-3) or 4, or set RELIEVO_EMBREE to the file of one of these";

/// Tracing of rays, whose signature depends on the major version.
pub trait Trace: Send + Sync {
    /// Closest hit.
    ///
    /// # Safety
    /// `scene` is alive and committed, and nobody changes it during the call.
    unsafe fn intersect(&self, scene: RTCScene, ray_hit: &mut RTCRayHit);

    /// Any hit: `tfar` of the ray becomes negative infinity if there is one.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn occluded(&self, scene: RTCScene, ray: &mut RTCRay);

    /// Closest hits of eight rays of much the same origin and direction.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn intersect8(&self, valid: &Valid8, scene: RTCScene, ray_hit: &mut RTCRayHit8);

    /// As `occluded`, for eight rays of much the same origin and direction.
    ///
    /// # Safety
    /// As for `intersect`.
    unsafe fn occluded8(&self, valid: &Valid8, scene: RTCScene, ray: &mut RTCRay8);
}

/// The context of a query of 3.x.
fn context(flags: embree3::RTCIntersectContextFlags) -> RTCIntersectContext {
    RTCIntersectContext { flags, filter: None, instID: [INVALID_ID] }
}

impl Trace for Embree3 {
    unsafe fn intersect(&self, scene: RTCScene, ray_hit: &mut RTCRayHit) {
        let mut context = context(embree3::RTC_INTERSECT_CONTEXT_FLAG_NONE);
        // SAFETY: the caller vouches for the scene; the record begins as that of 3.x, which `abi` asserts.
        unsafe { self.rtcIntersect1(scene, &mut context, (&raw mut *ray_hit).cast()) }
    }

    unsafe fn occluded(&self, scene: RTCScene, ray: &mut RTCRay) {
        let mut context = context(embree3::RTC_INTERSECT_CONTEXT_FLAG_NONE);
        // SAFETY: the caller vouches for the scene.
        unsafe { self.rtcOccluded1(scene, &mut context, ray) }
    }

    unsafe fn intersect8(&self, valid: &Valid8, scene: RTCScene, ray_hit: &mut RTCRayHit8) {
        let mut context = context(embree3::RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
        // SAFETY: as for `intersect`; mask and record are aligned to their 32 bytes.
        unsafe { self.rtcIntersect8(valid.0.as_ptr(), scene, &mut context, (&raw mut *ray_hit).cast()) }
    }

    unsafe fn occluded8(&self, valid: &Valid8, scene: RTCScene, ray: &mut RTCRay8) {
        let mut context = context(embree3::RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
        // SAFETY: as for `occluded`; mask and record are aligned to their 32 bytes.
        unsafe { self.rtcOccluded8(valid.0.as_ptr(), scene, &mut context, ray) }
    }
}

/// The arguments of a query of 4.x for the closest hit.
fn closest(flags: embree4::RTCRayQueryFlags) -> RTCIntersectArguments {
    RTCIntersectArguments {
        flags,
        feature_mask: embree4::RTC_FEATURE_FLAG_ALL,
        context: std::ptr::null_mut(),
        filter: None,
        intersect: None,
        minWidthDistanceFactor: 0.0,
    }
}

/// The arguments of a query of 4.x for any hit.
fn any(flags: embree4::RTCRayQueryFlags) -> RTCOccludedArguments {
    RTCOccludedArguments {
        flags,
        feature_mask: embree4::RTC_FEATURE_FLAG_ALL,
        context: std::ptr::null_mut(),
        filter: None,
        occluded: None,
        minWidthDistanceFactor: 0.0,
    }
}

impl Trace for Embree4 {
    unsafe fn intersect(&self, scene: RTCScene, ray_hit: &mut RTCRayHit) {
        // SAFETY: the caller vouches for the scene; structures are those of the version that was checked, or longer.
        unsafe { self.rtcIntersect1(scene, ray_hit, &mut closest(embree4::RTC_RAY_QUERY_FLAG_NONE)) }
    }

    unsafe fn occluded(&self, scene: RTCScene, ray: &mut RTCRay) {
        // SAFETY: as above.
        unsafe { self.rtcOccluded1(scene, ray, &mut any(embree4::RTC_RAY_QUERY_FLAG_NONE)) }
    }

    unsafe fn intersect8(&self, valid: &Valid8, scene: RTCScene, ray_hit: &mut RTCRayHit8) {
        let mut arguments = closest(embree4::RTC_RAY_QUERY_FLAG_COHERENT);
        // SAFETY: as above; mask and record are aligned to their 32 bytes.
        unsafe { self.rtcIntersect8(valid.0.as_ptr(), scene, ray_hit, &mut arguments) }
    }

    unsafe fn occluded8(&self, valid: &Valid8, scene: RTCScene, ray: &mut RTCRay8) {
        let mut arguments = any(embree4::RTC_RAY_QUERY_FLAG_COHERENT);
        // SAFETY: as above; mask and record are aligned to their 32 bytes.
        unsafe { self.rtcOccluded8(valid.0.as_ptr(), scene, ray, &mut arguments) }
    }
}

/// The functions of an Embree that was opened and checked.
pub struct Table {
    /// The functions that every version has alike.
    pub embree: Embree,
    /// The functions that trace rays.
    pub trace: Box<dyn Trace>,
    /// Major, minor and patch number.
    pub version: [u32; 3],
    /// The one-thread arena in which devices are made, where Embree schedules with TBB.
    pub arena: Option<Arena>,
}

impl Table {
    /// Opens `file` with local symbols and checks what it is.
    ///
    /// # Errors
    /// There is no such library, it is of another version than 3.13 or 4.x, lacks a function, or makes no device.
    pub fn open(file: &str) -> Result<Self> {
        Self::look_up(file).map_err(|error| error.at(file))
    }

    fn look_up(file: &str) -> Result<Self> {
        // SAFETY: the functions have these signatures in every 3.x and 4.x.
        let embree = unsafe { Embree::from_library(open(file)?) }.map_err(incomplete)?;
        let (version, tasking) = identify(&embree)?;
        // SAFETY: the version says which of the two has the library's signatures.
        let trace: Box<dyn Trace> = unsafe {
            match version[0] {
                3 => Box::new(Embree3::from_library(open(file)?).map_err(incomplete)?),
                _ => Box::new(Embree4::from_library(open(file)?).map_err(incomplete)?),
            }
        };
        let arena = if tasking == TASKING_TBB { Arena::find(open(file)?) } else { None };
        Ok(Self { embree, trace, version, arena })
    }
}

/// What Embree answers for `RTC_DEVICE_PROPERTY_TASKING_SYSTEM` where that is TBB.
const TASKING_TBB: isize = 1;

/// Opens `file` with local symbols. A file that is open is not loaded again: the loader counts how often it was opened.
pub fn open(file: &str) -> Result<Library> {
    binding::open(file).map_err(|error| {
        Error::new(ErrorKind::NotFound, format!("Embree cannot be loaded: {}", reason(&error))).advise(ADVICE)
    })
}

fn incomplete(error: libloading::Error) -> Error {
    Error::unsupported(format!("Embree lacks a function: {}", reason(&error))).advise(ADVICE)
}

/// What the loader says, which is more than what the crate that calls it says.
fn reason(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}

/// The version of the library, found with a device that is thrown away, and its tasking system.
///
/// # Errors
/// It makes no device, or is of another version than 3.13 or 4.x.
fn identify(embree: &Embree) -> Result<([u32; 3], isize)> {
    // SAFETY: a null configuration is allowed; the device is alive until it is released.
    let (version, tasking) = unsafe {
        let device = embree.rtcNewDevice(std::ptr::null());
        if device.is_null() {
            let code = embree.rtcGetDeviceError(device);
            return Err(Error::unsupported(format!("Embree makes no device (its error {code})"))
                .advise("it needs a processor with SSE2 and enough memory"));
        }
        let version = embree.rtcGetDeviceProperty(device, abi::RTC_DEVICE_PROPERTY_VERSION);
        let tasking = embree.rtcGetDeviceProperty(device, abi::RTC_DEVICE_PROPERTY_TASKING_SYSTEM);
        embree.rtcReleaseDevice(device);
        (version, tasking)
    };
    let version = u32::try_from(version).unwrap_or(0);
    let version = [version / 10_000, version / 100 % 100, version % 100];
    if !is_known(version) {
        let [major, minor, patch] = version;
        return Err(Error::unsupported(format!("this is Embree {major}.{minor}.{patch}")).advise(ADVICE));
    }
    Ok((version, tasking))
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
