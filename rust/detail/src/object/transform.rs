//! Checks of the transforms and times that hosts give to objects.

use glam::DAffine3;
use relievo_core::{Error, Result};

/// Fails unless edits can be made then, in seconds.
pub(crate) fn check_time(time: f64) -> Result<()> {
    if time.is_finite() && time.abs() <= f64::from(f32::MAX) {
        return Ok(());
    }
    Err(Error::invalid(format!("{time} is no time")).advise("give finite seconds"))
}

/// Fails unless all numbers are finite and the transform can be undone.
pub(crate) fn check_transform(transform: &DAffine3) -> Result<()> {
    let inverse = transform.inverse();
    if transform.is_finite() && inverse.is_finite() && transform.matrix3.determinant() != 0.0 {
        return Ok(());
    }
    Err(Error::invalid("the transform cannot be undone").advise("give finite numbers and no scale of 0"))
}
