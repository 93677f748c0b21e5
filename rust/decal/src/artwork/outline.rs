//! The outline of a sticker: a simple polygon in the plane of the image.

use relievo_core::{Error, Result};

use crate::map::energy::Vec2;

/// The most corners of an outline.
pub const MAX: usize = 1 << 16;
/// Rows that hold the edges which cross them.
const ROWS: usize = 256;

/// A simple polygon, counter-clockwise, with its edges sorted into rows for fast queries.
#[derive(Clone, Debug)]
pub struct Outline {
    corners: Vec<Vec2>,
    low: Vec2,
    high: Vec2,
    rows: Vec<Vec<u32>>,
}

impl Outline {
    /// Makes an outline of corners in order, in either sense.
    ///
    /// # Errors
    /// There are fewer than three corners or more than 65,536; a coordinate is not finite; the polygon has no area or
    /// crosses itself.
    pub fn new(mut corners: Vec<Vec2>) -> Result<Self> {
        let refuse = |what: String, remedy: &str| Err(Error::invalid(what).at("outline").advise(remedy));
        if corners.len() < 3 || corners.len() > MAX {
            return refuse(format!("it has {} corners", corners.len()), "give 3 to 65,536 corners");
        }
        if let Some(corner) = corners.iter().position(|corner| !corner.iter().all(|value| value.is_finite())) {
            return refuse(format!("corner {corner} is not finite"), "remove the corner");
        }
        let edges = || (0..corners.len()).map(|first| (corners[first], corners[(first + 1) % corners.len()]));
        let area: f64 = edges().map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
        let pick = |choose: fn(f64, f64) -> f64| {
            corners.iter().fold(corners[0], |sum, corner| [choose(sum[0], corner[0]), choose(sum[1], corner[1])])
        };
        let (low, high) = (pick(f64::min), pick(f64::max));
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        if area.abs() <= 1e-12 * extent * extent {
            return refuse("it encloses no area".into(), "give corners that are not on one line");
        }
        if area < 0.0 {
            corners.reverse();
        }
        let mut outline = Self { corners, low, high, rows: vec![Vec::new(); ROWS] };
        for edge in 0..outline.corners.len() {
            let (a, b) = outline.edge(edge);
            let (first, last) = (outline.row(a[1].min(b[1])), outline.row(a[1].max(b[1])));
            for row in &mut outline.rows[first..=last] {
                row.push(edge as u32);
            }
        }
        if let Some((first, second)) = outline.crossing() {
            return refuse(
                format!("the edges after corners {first} and {second} cross"),
                "give a polygon that does not cross itself",
            );
        }
        Ok(outline)
    }

    /// Makes the outline of a rectangle.
    ///
    /// # Errors
    /// Fails with `Invalid` if a coordinate is not finite, or the rectangle has no area.
    pub fn rectangle(low: Vec2, high: Vec2) -> Result<Self> {
        Self::new(vec![low, [high[0], low[1]], high, [low[0], high[1]]])
    }

    /// Returns the corners, counter-clockwise.
    pub fn corners(&self) -> &[Vec2] {
        &self.corners
    }

    /// Returns the smallest and the largest coordinates.
    pub fn bounds(&self) -> (Vec2, Vec2) {
        (self.low, self.high)
    }

    /// Returns the enclosed area.
    pub fn area(&self) -> f64 {
        let edges = (0..self.corners.len()).map(|edge| self.edge(edge));
        edges.map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
    }

    fn edge(&self, edge: usize) -> (Vec2, Vec2) {
        (self.corners[edge], self.corners[(edge + 1) % self.corners.len()])
    }

    fn row(&self, y: f64) -> usize {
        let share = (y - self.low[1]) / (self.high[1] - self.low[1]);
        ((share * ROWS as f64) as usize).min(ROWS - 1)
    }

    /// Two edges that meet elsewhere than in the corner they share.
    fn crossing(&self) -> Option<(u32, u32)> {
        let count = self.corners.len() as u32;
        for row in &self.rows {
            let mut sorted: Vec<(f64, f64, u32)> = row
                .iter()
                .map(|edge| {
                    let (a, b) = self.edge(*edge as usize);
                    (a[0].min(b[0]), a[0].max(b[0]), *edge)
                })
                .collect();
            sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            for (index, (_, end, first)) in sorted.iter().enumerate() {
                for (_, _, second) in sorted[index + 1..].iter().take_while(|other| other.0 <= *end) {
                    let (a, b) = self.edge(*first as usize);
                    let (c, d) = self.edge(*second as usize);
                    let is_after = (first + 1) % count == *second;
                    let is_before = (second + 1) % count == *first;
                    let meets = match (is_after, is_before) {
                        (false, false) => meet(a, b, c, d),
                        // Neighbours may share their corner, but not fold back onto each other.
                        (true, _) => side(a, b, d) == 0.0 && along(b, a, d) > 0.0,
                        (_, true) => side(c, d, b) == 0.0 && along(d, c, b) > 0.0,
                    };
                    if meets {
                        return Some((*first, *second));
                    }
                }
            }
        }
        None
    }

    /// Returns whether a point lies inside; points on the border belong to either side.
    pub fn contains(&self, point: Vec2) -> bool {
        let is_within = (0..2).all(|axis| point[axis] >= self.low[axis] && point[axis] <= self.high[axis]);
        if !is_within {
            return false;
        }
        let crossed = self.rows[self.row(point[1])].iter().filter(|edge| {
            let (a, b) = self.edge(**edge as usize);
            (a[1] > point[1]) != (b[1] > point[1])
                && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    /// Returns whether a segment meets the polygon or its inside.
    pub fn touches(&self, from: Vec2, to: Vec2) -> bool {
        self.contains(from) || self.contains(to) || self.is_crossed(from, to)
    }

    /// Returns whether a segment lies inside.
    pub fn encloses(&self, from: Vec2, to: Vec2) -> bool {
        self.contains(from) && self.contains(to) && !self.is_crossed(from, to)
    }

    fn is_crossed(&self, from: Vec2, to: Vec2) -> bool {
        let is_apart =
            (0..2).any(|axis| from[axis].max(to[axis]) < self.low[axis] || from[axis].min(to[axis]) > self.high[axis]);
        if is_apart {
            return false;
        }
        let (first, last) = (self.row(from[1].min(to[1])), self.row(from[1].max(to[1])));
        self.rows[first..=last].iter().flatten().any(|edge| {
            let (a, b) = self.edge(*edge as usize);
            meet(a, b, from, to)
        })
    }
}

/// Twice the signed area of a triangle.
fn side(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The scalar product of the ways from `a` to `b` and to `c`.
fn along(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1])
}

/// Whether two segments have a point in common.
fn meet(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let (first, second) = (side(a, b, c), side(a, b, d));
    let (third, fourth) = (side(c, d, a), side(c, d, b));
    if first == 0.0 && second == 0.0 && third == 0.0 && fourth == 0.0 {
        let overlap =
            |axis: usize| a[axis].max(b[axis]) >= c[axis].min(d[axis]) && c[axis].max(d[axis]) >= a[axis].min(b[axis]);
        return overlap(0) && overlap(1);
    }
    first * second <= 0.0 && third * fourth <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The letter L.
    fn angle() -> Outline {
        Outline::new(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]).expect("simple")
    }

    #[test]
    fn segments_and_points_are_told_apart() {
        let angle = angle();
        assert!(angle.contains([0.5, 2.5]) && angle.contains([1.5, 0.5]) && !angle.contains([1.5, 2.0]));
        assert!(angle.encloses([0.5, 0.5], [1.5, 0.5]));
        assert!(!angle.encloses([0.5, 2.9], [1.9, 0.5]), "it leaves through the inner corner");
        assert!(angle.touches([-1.0, 2.0], [3.0, 2.0]) && !angle.touches([1.5, 1.5], [3.0, 3.0]));
        assert!((angle.area() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn unusable_outlines_are_refused() {
        let cases: [(Vec<Vec2>, &str); 5] = [
            (vec![[0.0, 0.0], [1.0, 0.0]], "2 corners"),
            (vec![[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]], "corner 1 is not finite"),
            (vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], "no area"),
            (vec![[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]], "cross"),
            (vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, -1.0], [1.0, 1.0]], "cross"),
        ];
        for (corners, expected) in cases {
            let error = Outline::new(corners).expect_err("unusable").to_string();
            assert!(error.contains(expected), "{error} should contain {expected}");
        }
        let clockwise = Outline::new(vec![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]).expect("simple");
        assert!(clockwise.area() > 0.0);
    }
}
