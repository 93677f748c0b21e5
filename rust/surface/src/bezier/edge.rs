//! Edges of Bézier patches: which of them are one curve, and in which direction all evaluate it.
//!
//! Edges are the same if their four control points and weights are equal to the bit, in either direction. Every edge is
//! evaluated from the end whose control points come first by their bits, whichever patch was asked: that alone makes
//! the points of both sides equal to the bit. Edges are numbered as in [`crate::Place::on_edge`].

use std::cmp::Ordering;

use relievo_core::Result;
use relievo_core::budget::Budget;

/// How the curve of an edge is evaluated, seen from a patch's own direction along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum EdgeSense {
    /// In its own direction.
    Along = 0,
    /// In the opposite direction.
    Against = 1,
    /// Both directions are the same curve: by the parameter that is nearer to an end.
    Folded = 2,
    /// All of it is one point.
    Collapsed = 3,
}

impl EdgeSense {
    /// Of the curve with these control points.
    fn of(curve: &[[f32; 4]; 4]) -> Self {
        if curve.iter().all(|control| control[..3] == curve[0][..3]) {
            return Self::Collapsed;
        }
        let bits = |index: usize| curve[index].map(f32::to_bits);
        let order = (0..2).map(|index| bits(index).cmp(&bits(3 - index))).find(|order| order.is_ne());
        match order {
            Some(Ordering::Less) => Self::Along,
            Some(_) => Self::Against,
            None => Self::Folded,
        }
    }

    /// The parameter at which the curve is evaluated for `t` in the patch's own direction, as numbers of `n` segments.
    #[inline]
    pub fn segment(self, t: u32, n: u32) -> u32 {
        match self {
            Self::Along => t,
            Self::Against => n - t,
            Self::Folded => t.min(n - t),
            Self::Collapsed => 0,
        }
    }

    /// As [`Self::segment`], for a parameter of 0 to 1.
    #[inline]
    pub fn parameter(self, t: f32) -> f32 {
        match self {
            Self::Along => t,
            Self::Against => 1.0 - t,
            Self::Folded => t.min(1.0 - t),
            Self::Collapsed => 0.0,
        }
    }
}

/// Number of the `index`th control point along `edge`, counted from corner `edge`.
#[inline]
pub(super) fn along(edge: usize, index: usize) -> usize {
    match edge & 3 {
        0 => index,
        1 => 3 + 4 * index,
        2 => 15 - index,
        _ => 12 - 4 * index,
    }
}

/// The control points along `edge`.
pub(super) fn curve(controls: &[[f32; 4]; 16], edge: usize) -> [[f32; 4]; 4] {
    std::array::from_fn(|index| controls[along(edge, index)])
}

/// Edges of all patches.
#[derive(Clone, Debug)]
pub struct EdgeTable {
    senses: Vec<[EdgeSense; 4]>,
    /// Number of the curve of every edge.
    curves: Vec<[u32; 4]>,
    /// Edges, as 4 · patch + edge, curve after curve.
    sharing: Vec<u32>,
    /// The first of every curve, and their number at the end.
    first: Vec<u32>,
}

impl EdgeTable {
    pub(super) fn new(controls: &[[[f32; 4]; 16]], budget: &mut Budget) -> Result<Self> {
        let count = controls.len();
        let mut senses = budget.filled(count, [EdgeSense::Along; 4])?;
        for (senses, controls) in senses.iter_mut().zip(controls) {
            *senses = std::array::from_fn(|edge| EdgeSense::of(&curve(controls, edge)));
        }
        let key = |side: u32| {
            let (patch, edge) = ((side / 4) as usize, (side % 4) as usize);
            let mut curve = curve(&controls[patch], edge);
            if senses[patch][edge] == EdgeSense::Against {
                curve.reverse();
            }
            curve.map(|control| control.map(f32::to_bits))
        };
        let collapsed = |side: u32| senses[(side / 4) as usize][(side % 4) as usize] == EdgeSense::Collapsed;
        let mut sharing = Vec::new();
        budget.reserve(&mut sharing, 4 * count)?;
        sharing.extend(0..4 * count as u32);
        sharing.sort_unstable_by(|a, b| key(*a).cmp(&key(*b)).then(a.cmp(b)));
        let mut first = Vec::new();
        budget.reserve(&mut first, 4 * count + 1)?;
        let mut curves = budget.filled(count, [0; 4])?;
        for (place, side) in sharing.iter().enumerate() {
            // A point is no curve that patches could meet along.
            let same = place > 0 && !collapsed(*side) && key(sharing[place - 1]) == key(*side);
            if !same {
                first.push(place as u32);
            }
            curves[(side / 4) as usize][(side % 4) as usize] = first.len() as u32 - 1;
        }
        first.push(sharing.len() as u32);
        Ok(Self { senses, curves, sharing, first })
    }

    /// How the edges of `patch` are evaluated.
    ///
    /// # Panics
    /// `patch` does not exist.
    #[inline]
    pub fn senses(&self, patch: usize) -> [EdgeSense; 4] {
        self.senses[patch]
    }

    /// The curves of the edges of `patch`, by number. Edges that are the same curve have the same number.
    ///
    /// # Panics
    /// `patch` does not exist.
    pub fn curves(&self, patch: usize) -> [u32; 4] {
        self.curves[patch]
    }

    /// How many curves there are.
    pub fn curve_count(&self) -> usize {
        self.first.len() - 1
    }

    /// The patches and their edges that are this curve, ascending.
    ///
    /// # Panics
    /// `curve` is not below [`Self::curve_count`].
    pub fn sharing(&self, curve: usize) -> impl Iterator<Item = (u32, u8)> {
        let range = self.first[curve] as usize..self.first[curve + 1] as usize;
        self.sharing[range].iter().map(|side| (side / 4, (side % 4) as u8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;

    #[test]
    fn edges_run_as_those_of_places() {
        for edge in 0..4 {
            for index in 0..4 {
                let place = Place::on_edge(0, edge as u8, index as f32 / 3.0);
                let number = along(edge, index);
                let expected = [(number % 4) as f32 / 3.0, (number / 4) as f32 / 3.0];
                assert!((place.u - expected[0]).abs() < 1e-6 && (place.v - expected[1]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn directions_are_told_apart() {
        let curve = |xs: [f32; 4]| xs.map(|x| [x, 0.0, 0.0, 1.0]);
        assert_eq!(EdgeSense::of(&curve([0.0, 1.0, 2.0, 3.0])), EdgeSense::Along);
        assert_eq!(EdgeSense::of(&curve([3.0, 2.0, 1.0, 0.0])), EdgeSense::Against);
        assert_eq!(EdgeSense::of(&curve([1.0, 2.0, 3.0, 1.0])), EdgeSense::Along);
        assert_eq!(EdgeSense::of(&curve([1.0, 2.0, 2.0, 1.0])), EdgeSense::Folded);
        assert_eq!(EdgeSense::of(&curve([2.0; 4])), EdgeSense::Collapsed);
        let mut weighted = curve([2.0; 4]);
        weighted[1][3] = 5.0;
        assert_eq!(EdgeSense::of(&weighted), EdgeSense::Collapsed, "weights do not move a point");
        for sense in [EdgeSense::Folded, EdgeSense::Along] {
            assert_eq!(sense.segment(1, 7), 1);
        }
        assert_eq!((EdgeSense::Against.segment(1, 7), EdgeSense::Folded.segment(6, 7)), (6, 1));
    }
}
