//! Buckets of the plane with the faces of a map, to find the faces at a point.

use crate::map::energy::Vec2;
use crate::map::gradual::push;
use crate::surface::NONE;

/// Buckets along each side at most.
const MAX: f64 = 512.0;
/// Faces of a bucket on average.
const FACES: f64 = 4.0;

/// A rectangle of the plane in square buckets. Points and faces outside of it are left out.
pub struct Buckets {
    low: Vec2,
    step: f64,
    counts: [usize; 2],
    /// The last entry of each bucket, or [`NONE`].
    last: Vec<u32>,
    /// A face and the entry of its bucket before it.
    entries: Vec<[u32; 2]>,
}

impl Buckets {
    /// Makes empty buckets for about `count` faces between two corners.
    pub fn new((low, high): (Vec2, Vec2), count: usize) -> Self {
        let side = (count as f64 / FACES).sqrt().clamp(1.0, MAX);
        let step = ((high[0] - low[0]).max(high[1] - low[1]) / side).max(f64::MIN_POSITIVE);
        let counts = [0, 1].map(|axis| ((high[axis] - low[axis]) / step).ceil().clamp(1.0, MAX + 1.0) as usize);
        // A face reaches into three buckets, as most do.
        let entries = Vec::with_capacity(3 * count);
        Self { low, step, counts, last: vec![NONE; counts[0] * counts[1]], entries }
    }

    /// The buckets from a least to a largest coordinate, if there are any.
    fn span(&self, axis: usize, least: f64, most: f64) -> std::ops::Range<usize> {
        let first = ((least - self.low[axis]) / self.step).floor().max(0.0);
        let last = ((most - self.low[axis]) / self.step).floor().min(self.counts[axis] as f64 - 1.0);
        if first <= last { first as usize..last as usize + 1 } else { 0..0 }
    }

    /// Adds a face.
    pub fn insert(&mut self, face: u32, corners: [Vec2; 3]) {
        let [columns, rows] = [0, 1].map(|axis| {
            let values = corners.map(|corner| corner[axis]);
            let least = values.into_iter().fold(f64::INFINITY, f64::min);
            self.span(axis, least, values.into_iter().fold(f64::NEG_INFINITY, f64::max))
        });
        for row in rows {
            for column in columns.clone() {
                let entry = self.entries.len() as u32;
                let last = std::mem::replace(&mut self.last[row * self.counts[0] + column], entry);
                push(&mut self.entries, [face, last]);
            }
        }
    }

    /// Returns the faces that reach into the bucket of a point, the one that was added last at first.
    pub fn at(&self, point: Vec2) -> impl Iterator<Item = u32> {
        let [columns, rows] = [0, 1].map(|axis| self.span(axis, point[axis], point[axis]));
        let bucket = rows.start * self.counts[0] + columns.start;
        let is_inside = point.iter().all(|place| place.is_finite()) && !columns.is_empty() && !rows.is_empty();
        let last = if is_inside { self.last.get(bucket).copied().unwrap_or(NONE) } else { NONE };
        let entry = |at: u32| self.entries.get(at as usize);
        std::iter::successors(entry(last), move |[_, before]| entry(*before)).map(|[face, _]| *face)
    }
}

/// Returns whether a triangle holds a point.
pub fn holds([a, b, c]: [Vec2; 3], point: Vec2) -> bool {
    let is_left = |p: Vec2, q: Vec2| (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0]) > 0.0;
    let sides = [is_left(a, b), is_left(b, c), is_left(c, a)];
    sides == [true; 3] || sides == [false; 3]
}

/// Returns the mean of three points.
pub fn middle(corners: [Vec2; 3]) -> Vec2 {
    std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_found_where_they_are() {
        let mut buckets = Buckets::new(([0.0, 0.0], [1.0, 1.0]), 1000);
        let corners = [[[0.1, 0.1], [0.9, 0.2], [0.3, 0.8]], [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]];
        buckets.insert(7, corners[0]);
        buckets.insert(8, corners[1]);
        let found = |point: Vec2| -> Vec<u32> {
            buckets.at(point).filter(|face| holds(corners[*face as usize - 7], point)).collect()
        };
        assert_eq!(found(middle(corners[0])), [8, 7]);
        assert_eq!(found([0.95, 0.95]), [8]);
        assert_eq!(buckets.at([2.0, 0.5]).count() + buckets.at([f64::NAN, 0.0]).count(), 0);
    }
}
