//! Bench `native`: what the bindings to C++ libraries cost and what they do, one module for each library.

mod opensubdiv;

use relievo_core::Result;

use crate::report::Report;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    opensubdiv::run(report)
}
