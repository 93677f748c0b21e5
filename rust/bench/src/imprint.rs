//! Bench `imprint`: what the stages of an imprint cost (Schäfer et al. 2014, Section 7).

use relievo_core::{Context, ContextOptions, Result};

use crate::report::Report;
use crate::voxels;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    voxels::run(&context, report)
}
