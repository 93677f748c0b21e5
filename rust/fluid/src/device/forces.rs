//! Forces on all particles, as a device has them.

use relievo_gpu::wgsl::fluid_forces::ForceRow;

use crate::Force;
use crate::solver::noise::slice;

/// Returns the row of a force at a time in seconds.
pub fn row(force: &Force, time: f64) -> ForceRow {
    let none = ForceRow::default();
    match *force {
        Force::Gravity(place) => ForceRow { place: place.to_array(), kind: 0, ..none },
        Force::Wind { velocity, share } => ForceRow { place: velocity.to_array(), kind: 1, strength: share, ..none },
        Force::Drag { share, square } => ForceRow { kind: 2, strength: share, radius: square, ..none },
        Force::Vortex { place, axis, strength, radius } => ForceRow {
            place: place.to_array(),
            kind: 3,
            axis: axis.normalize_or_zero().to_array(),
            strength,
            radius,
            ..none
        },
        Force::Attractor { place, strength, radius } => {
            ForceRow { place: place.to_array(), kind: 4, strength, radius, ..none }
        }
        Force::Turbulence { strength, scale, rate, seed } => {
            let (slice, later) = slice(time * f64::from(rate));
            ForceRow { kind: 5, strength, radius: scale, seed, slice, later, ..none }
        }
    }
}
