//! Forces on all particles, as a device has them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::Force;
use crate::solver::noise::slice;

/// As in `fluid_forces.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ForceRow {
    pub place: Vec3,
    pub kind: u32,
    pub axis: Vec3,
    pub strength: f32,
    pub radius: f32,
    pub seed: u32,
    pub slice: i32,
    pub later: f32,
}

impl ForceRow {
    /// Of a force at a time in seconds.
    pub fn new(force: &Force, time: f64) -> Self {
        let none = Self::default();
        match *force {
            Force::Gravity(place) => Self { place, kind: 0, ..none },
            Force::Wind { velocity, share } => Self { place: velocity, kind: 1, strength: share, ..none },
            Force::Drag { share, square } => Self { kind: 2, strength: share, radius: square, ..none },
            Force::Vortex { place, axis, strength, radius } => {
                Self { place, kind: 3, axis: axis.normalize_or_zero(), strength, radius, ..none }
            }
            Force::Attractor { place, strength, radius } => Self { place, kind: 4, strength, radius, ..none },
            Force::Turbulence { strength, scale, rate, seed } => {
                let (slice, later) = slice(time * f64::from(rate));
                Self { kind: 5, strength, radius: scale, seed, slice, later, ..none }
            }
        }
    }
}
