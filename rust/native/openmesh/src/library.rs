//! Opens OpenMesh.

use relievo_core::{Error, ErrorKind, Result};

use crate::bridge::ffi;

/// The file that is opened unless `RELIEVO_OPENMESH` names another one.
const FILE: &str = "libOpenMeshCore.so.9.0";

/// Opens OpenMesh, once for the process.
///
/// # Errors
/// It is not installed, or another version.
pub fn open() -> Result<()> {
    let file = std::env::var("RELIEVO_OPENMESH").ok().filter(|file| !file.is_empty());
    ffi::open_library(file.as_deref().unwrap_or(FILE)).map_err(|error| {
        Error::new(ErrorKind::NotFound, format!("OpenMesh cannot be used: {}", error.what())).advise(
            "install OpenMesh 9.0 (Debian: libopenmesh1), or set RELIEVO_OPENMESH to the file of libOpenMeshCore",
        )
    })
}
