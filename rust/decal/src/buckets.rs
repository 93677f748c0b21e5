//! Buckets of the plane with the faces of a map, to find the faces at a point.

use crate::energy::Vec2;

/// Buckets along each side at most.
const MOST: f64 = 512.0;
/// Faces of a bucket on average.
const FACES: f64 = 4.0;

/// A rectangle of the plane in square buckets. Points and faces outside of it are left out.
pub struct Buckets {
    low: Vec2,
    step: f64,
    counts: [usize; 2],
    faces: Vec<Vec<(u32, [Vec2; 3])>>,
}

impl Buckets {
    /// Makes empty buckets for about `count` faces between two corners.
    pub fn new((low, high): (Vec2, Vec2), count: usize) -> Self {
        let side = (count as f64 / FACES).sqrt().clamp(1.0, MOST);
        let step = ((high[0] - low[0]).max(high[1] - low[1]) / side).max(f64::MIN_POSITIVE);
        let counts = [0, 1].map(|axis| ((high[axis] - low[axis]) / step).ceil().clamp(1.0, MOST + 1.0) as usize);
        Self { low, step, counts, faces: vec![Vec::new(); counts[0] * counts[1]] }
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
                self.faces[row * self.counts[0] + column].push((face, corners));
            }
        }
    }

    /// Returns the faces that hold a point, in the order in which they were added.
    pub fn at(&self, point: Vec2) -> impl Iterator<Item = u32> {
        let [columns, rows] = [0, 1].map(|axis| self.span(axis, point[axis], point[axis]));
        let bucket = rows.start * self.counts[0] + columns.start;
        let is_inside = point.iter().all(|place| place.is_finite()) && !columns.is_empty() && !rows.is_empty();
        let faces = if is_inside { self.faces.get(bucket).map_or(&[][..], Vec::as_slice) } else { &[] };
        let holds = move |corners: &[Vec2; 3]| {
            let [a, b, c] = *corners;
            let is_left =
                |p: Vec2, q: Vec2| (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0]) > 0.0;
            let sides = [is_left(a, b), is_left(b, c), is_left(c, a)];
            sides == [true; 3] || sides == [false; 3]
        };
        faces.iter().filter(move |(_, corners)| holds(corners)).map(|(face, _)| *face)
    }
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
        let corners = [[0.1, 0.1], [0.9, 0.2], [0.3, 0.8]];
        buckets.insert(7, corners);
        buckets.insert(8, [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
        assert_eq!(buckets.at(middle(corners)).collect::<Vec<_>>(), [7, 8]);
        assert_eq!(buckets.at([0.95, 0.95]).collect::<Vec<_>>(), [8]);
        assert_eq!(buckets.at([2.0, 0.5]).count() + buckets.at([f64::NAN, 0.0]).count(), 0);
    }
}
