//! Cubes within a fluid, which rays leap over. The function is looked at in the middle of a cube, when the first ray
//! comes to it: where it is well above 0 there and hardly changes, the whole cube counts as fluid. So a hollow may be
//! missed that is narrower than a cube and has fluid all around.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::surface::Surface;
use crate::surface::chords::Piece;
use crate::surface::function::Combination;
use crate::surface::probe::Probe;
use crate::surface::rows::Cell;

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

    /// Up to which distance a piece of a ray goes through such cubes alone, from a place within the fluid on, and from
    /// where on it is worth while to ask again.
    pub fn stretch(&self, probe: &mut Probe<'_>, piece: &Piece, from: f32, last: f32) -> [f32; 2] {
        let origin = piece.anchor.as_dvec3() + piece.offset.as_dvec3() - self.low;
        let (direction, mut at) = (piece.direction.as_dvec3(), f64::from(from));
        let mut cube: Cell = ((origin + at * direction) / self.edge).to_array().map(floor);
        // Along each axis: which way it goes, where the next side is, and how far sides are apart.
        let ways = direction.to_array().map(|along| if along < 0.0 { -1 } else { 1 });
        let apart = (self.edge / direction).abs();
        let mut sides = DVec3::INFINITY;
        for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
            let side = (cube[axis] + i64::from(ways[axis] > 0)) as f64 * self.edge;
            sides[axis] = (side - origin[axis]) / direction[axis];
        }
        let mut seen = None;
        loop {
            let (axis, next) = (sides.min_position(), sides.min_element().max(at));
            if !self.is_within(probe, cube, &mut seen) {
                return [at as f32, next as f32];
            }
            at = next;
            if at >= f64::from(last) {
                return [last; 2];
            }
            cube[axis] += ways[axis];
            sides[axis] += apart[axis];
        }
    }

    /// `seen` is the cell that was looked up before, and its number.
    fn is_within(&self, probe: &mut Probe<'_>, cube: Cell, seen: &mut Option<(Cell, Option<usize>)>) -> bool {
        let cell = cube.map(|at| at.div_euclid(self.along));
        let number = match seen {
            Some((before, number)) if *before == cell => *number,
            _ => seen.insert((cell, probe.surface.rows.find(cell))).1,
        };
        let Some(number) = number else { return false };
        let [x, y, z] = [0, 1, 2].map(|axis| cube[axis] - cell[axis] * self.along);
        let place = (z * self.along + y) * self.along + x;
        let (word, shift) = (&self.bits[number * self.words + (place / WORD) as usize], 2 * (place % WORD));
        let known = word.load(Ordering::Relaxed) >> shift;
        if known & SEEN != 0 {
            return known & WITHIN != 0;
        }
        let middle = self.low + (DVec3::from(cube.map(|at| at as f64)) + 0.5) * self.edge;
        let sample = probe.sample(middle.as_vec3().to_array());
        let change = DVec3::from(sample.gradient.map(f64::from)).length() as f32 * half_diagonal(self.edge);
        let is_within = sample.value >= self.depth && 2.0 * change <= sample.value;
        word.fetch_or((SEEN | if is_within { WITHIN } else { 0 }) << shift, Ordering::Relaxed);
        is_within
    }
}

/// The next lower whole number: that of the library is a call where processors are not known to have it.
fn floor(value: f64) -> i64 {
    let whole = value as i64;
    whole - i64::from(whole as f64 > value)
}

fn half_diagonal(edge: f64) -> f32 {
    (0.5 * 3.0f64.sqrt() * edge) as f32
}
