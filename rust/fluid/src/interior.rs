//! Cubes within a fluid, which rays leap over. The function is looked at in the middle of a cube, when the first ray
//! comes to it: where it is well above 0 there and hardly changes, the whole cube counts as fluid. So a hollow may be
//! missed that is narrower than a cube and has fluid all around.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::function::Combination;
use crate::probe::Probe;
use crate::rows::Cell;
use crate::surface::Surface;

/// Cubes of a support radius: with the usual steps two of a march.
const CUBES: f32 = 6.0;
/// Cubes of a word.
const WORD: i64 = 32;
/// Bits of a cube: it was looked at; it is within the fluid.
const SEEN: u64 = 1;
const WITHIN: u64 = 2;

/// What is known of the cubes of the cells of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Interior {
    /// Bits of the cubes of one cell after the other. They do not depend on who writes them first.
    bits: Arc<[AtomicU64]>,
    /// Cubes along a cell, and words of one.
    along: i64,
    words: usize,
    edge: f64,
    low: DVec3,
    /// The value from which on a place is well within the fluid.
    pub depth: f32,
}

impl Interior {
    pub fn new(surface: &Surface) -> Self {
        let (low, edge) = surface.rows.lattice();
        let along = (edge as f32 * CUBES / surface.function.support()).ceil() as i64;
        let words = ((along * along * along + WORD - 1) / WORD) as usize;
        let edge = edge / along as f64;
        let depth = match surface.combination {
            // The distance to the mean grows by about as much as a place is moved.
            Combination::Mean { .. } => 1.25 * half_diagonal(edge),
            Combination::Sum { iso } => 0.4 * iso,
        };
        let bits = (0..surface.rows.len() * words).map(|_| AtomicU64::new(0)).collect();
        Self { bits, along, words, edge, low: low.into(), depth }
    }

    /// Up to which distance a ray goes through such cubes alone, from a place within the fluid on, and from where on it is
    /// worth while to ask again.
    pub fn stretch(
        &self,
        probe: &mut Probe<'_>,
        (origin, direction): (DVec3, DVec3),
        from: f32,
        last: f32,
    ) -> [f32; 2] {
        let inverse = 1.0 / direction;
        let (origin, mut at) = (origin - self.low, f64::from(from));
        loop {
            let cube = ((origin + at * direction) / self.edge).floor();
            // Where it leaves the cube, and a little more, so that it is in the next one.
            let side = cube + DVec3::select(direction.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
            let leaves =
                DVec3::select(direction.cmpeq(DVec3::ZERO), DVec3::INFINITY, (side * self.edge - origin) * inverse);
            let next = leaves.min_element().max(at) + 1e-3 * self.edge;
            if !self.is_within(probe, cube) {
                return [at as f32, next as f32];
            }
            at = next;
            if at >= f64::from(last) {
                return [last; 2];
            }
        }
    }

    fn is_within(&self, probe: &mut Probe<'_>, cube: DVec3) -> bool {
        let whole: Cell = cube.to_array().map(|at| at as i64);
        let Some(cell) = probe.surface.rows.find(whole.map(|at| at.div_euclid(self.along))) else { return false };
        let [x, y, z] = whole.map(|at| at.rem_euclid(self.along));
        let place = (z * self.along + y) * self.along + x;
        let (word, shift) = (&self.bits[cell * self.words + (place / WORD) as usize], 2 * (place % WORD));
        let known = word.load(Ordering::Relaxed) >> shift;
        if known & SEEN != 0 {
            return known & WITHIN != 0;
        }
        let middle = self.low + (cube + 0.5) * self.edge;
        let sample = probe.sample(middle.as_vec3().to_array());
        let change = DVec3::from(sample.gradient.map(f64::from)).length() as f32 * half_diagonal(self.edge);
        let is_within = sample.value >= self.depth && 2.0 * change <= sample.value;
        word.fetch_or((SEEN | if is_within { WITHIN } else { 0 }) << shift, Ordering::Relaxed);
        is_within
    }
}

fn half_diagonal(edge: f64) -> f32 {
    (0.5 * 3.0f64.sqrt() * edge) as f32
}
