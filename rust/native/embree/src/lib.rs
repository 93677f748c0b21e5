//! Embree reached through a table of functions loaded at run time.
//!
//! A host program often ships its own Embree. Were ours linked in the ordinary way, the host's would answer our calls,
//! in another version with other structures, and rays would miss without an error. So the library is opened with local
//! symbols, its version is checked before the first trace, and nothing here refers to an `rtc…` symbol by name at link
//! time. The device never starts threads, pins none and changes no process-wide limit.

mod abi;
mod arena;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod binding;
#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod binding {
    use crate::loader::Library;

    /// Opens `file` with local symbols.
    #[cfg(unix)]
    pub fn open(file: &str) -> Result<Library, libloading::Error> {
        use libloading::os::unix::{RTLD_LOCAL, RTLD_NOW};
        // SAFETY: opening a library runs its initialisers; which library that is, is the user's choice.
        unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) }
    }

    /// Opens `file`. Names belong to libraries there, so that no other can answer.
    #[cfg(windows)]
    pub fn open(file: &str) -> Result<Library, libloading::Error> {
        // SAFETY: opening a library runs its initialisers; which library that is, is the user's choice.
        unsafe { Library::new(file) }
    }
}
mod device;
mod scene;
mod subdivision;
mod table;

#[cfg(unix)]
use libloading::os::unix as loader;
#[cfg(windows)]
use libloading::os::windows as loader;

pub use device::{Device, Monitor};
pub use scene::{Hit, ObjectId, Ray, Scene, Tracer};
pub use subdivision::{Boundary, Cage, Evaluation, Subdivision};

/// Makes sure that Embree can be loaded, and says which version answers: `[major, minor, patch]`.
///
/// # Errors
/// The library is missing, incomplete or of a version this crate has no table for.
pub fn version() -> relievo_core::Result<[u32; 3]> {
    Ok(table::table()?.version)
}
