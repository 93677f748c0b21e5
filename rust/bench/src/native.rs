//! Bench `native`: what the bindings to C++ libraries cost and what they do, one module for each library.

mod opensubdiv;
mod openvdb;

use relievo_core::Result;

use crate::report::Report;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    // Opening the module is measured once, at its first call.
    openvdb::run(report)?;
    opensubdiv::run(report)
}
