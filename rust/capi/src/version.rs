//! The version of the library that is loaded; see `include/relievo/version.h`.

constants! {
    u32:
    RLV_VERSION_MAJOR = 0,
    RLV_VERSION_MINOR = 1,
    RLV_VERSION_PATCH = 0,
}

#[unsafe(no_mangle)]
pub extern "C" fn rlv_version() -> u32 {
    RLV_VERSION_MAJOR << 22 | RLV_VERSION_MINOR << 12 | RLV_VERSION_PATCH
}
