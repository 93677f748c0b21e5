//! Binding to OpenSubdiv: adaptive refinement, patch tables and stencils, and its own evaluators for comparison.
//!
//! The C++ side (`cpp/opensubdiv`) has no algorithms: it fills in OpenSubdiv's descriptors and copies its tables out.
//! `bridge.rs` declares what crosses the boundary; cxx generates both sides of it and compares them when it compiles.

mod bridge;
#[cfg(target_os = "linux")]
mod library;
#[cfg(not(target_os = "linux"))]
mod library {
    /// Does nothing: OpenSubdiv is linked.
    pub fn open() -> relievo_core::Result<()> {
        Ok(())
    }
}
pub mod reference;
pub mod subdivision;
mod table;

pub use table::{BoundaryRule, Expected, Options, PatchKind, PatchRecord, Table};

/// Returns the version of OpenSubdiv that this was built with: `[major, minor, patch]`.
pub fn version() -> [u32; 3] {
    let number = bridge::ffi::version_number();
    [number / 10_000, number / 100 % 100, number % 100]
}
