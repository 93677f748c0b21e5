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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_the_package_version() {
        let package = format!("{RLV_VERSION_MAJOR}.{RLV_VERSION_MINOR}.{RLV_VERSION_PATCH}");
        assert_eq!(package, env!("CARGO_PKG_VERSION"));
    }
}
