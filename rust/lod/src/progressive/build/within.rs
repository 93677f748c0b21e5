//! The coarse level of a progressive mesh whose distance from the finest is within a bound.
//!
//! Levels are made by what splits are estimated to deviate by, which may be exceeded. So levels are measured, and the limit of
//! the estimates is halved between one that holds the bound and one that does not.

use relievo_core::{Context, Progress, Result};

use super::cut::Cut;
use crate::distance::MeasuredMesh;
use crate::progressive::mesh::active::ActiveMesh;

/// Levels that are measured, at most.
const TRIALS: u32 = 12;
/// The part of the bound from which on a measured distance is near enough.
const ENOUGH: f32 = 0.9;
/// The relative difference of two limits between which no other is tried.
const FINE: f32 = 1.02;

impl ActiveMesh {
    /// Adapts the mesh to a coarse level whose surface is nowhere farther than `bound` from that of the finest level with
    /// its edits, nor that from it, in object units. Returns the distance, never less than the true one. Less than 10⁻⁷ of
    /// the largest coordinate, its rounding, counts as that.
    ///
    /// # Errors
    /// Fails if memory does not suffice, or `progress` asks to stop.
    pub fn adapt_within(&mut self, context: &Context, bound: f32, progress: &mut dyn Progress) -> Result<f32> {
        self.adapt(context, Cut::FINEST);
        let finest = self.surface();
        let finest = MeasuredMesh::new(context, (&finest.0, &finest.1))?;
        let bound = bound.max(finest.rounding() as f32);
        // The finest level needs no measure; nobody has measured `too_coarse` at first.
        let (mut best, mut fine_enough, mut too_coarse) = ((Cut::FINEST, 0.0), 0.0, f32::INFINITY);
        let mut error = bound;
        for trial in 0..TRIALS {
            let mut part =
                |fraction: f32, stage: &str| progress.report((trial as f32 + fraction) / TRIALS as f32, stage);
            let cut = Cut::of_error(error);
            self.adapt(context, cut);
            let level = self.surface();
            let distance =
                finest.distance(context, &MeasuredMesh::new(context, (&level.0, &level.1))?, &mut part)?.at_most;
            if distance <= bound {
                (best, fine_enough) = ((cut, distance), error);
                if distance >= ENOUGH * bound {
                    break;
                }
            } else {
                too_coarse = error;
            }
            // A distance grows about as the estimate does.
            let guess = error * bound / distance.max(0.1 * bound);
            error = match (fine_enough > 0.0, too_coarse < f32::INFINITY) {
                (true, true) => (fine_enough * too_coarse).sqrt(),
                (true, false) => guess.max(1.5 * error),
                _ => guess.min(0.7 * error),
            };
            if too_coarse <= FINE * fine_enough || error <= f32::MIN_POSITIVE {
                break;
            }
        }
        self.adapt(context, best.0);
        progress.step(1.0, "measure")?;
        Ok(best.1)
    }

    /// Returns the points and triangles of the mesh at its present level.
    fn surface(&self) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mesh = self.extract();
        (mesh.points, mesh.triangles)
    }
}
