//! The version of the library that is loaded; see `include/relievo/version.h`.

constants! {
    u32:
    RLV_VERSION_MAJOR = 0,
    RLV_VERSION_MINOR = 1,
    RLV_VERSION_PATCH = 0,
}

#[unsafe(no_mangle)]
pub extern "C" fn rlv_version() -> u32 {
    version_of(RLV_VERSION_MAJOR, RLV_VERSION_MINOR, RLV_VERSION_PATCH)
}

/// A version as one number, as `RLV_MAKE_VERSION` makes it.
pub const fn version_of(major: u32, minor: u32, patch: u32) -> u32 {
    major << 22 | minor << 12 | patch
}
