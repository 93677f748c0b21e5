//! The part of a sticker that a map covers, counted on a lattice of samples.

use crate::artwork::outline::Outline;
use crate::map::energy::Vec2;

/// Samples along the longer side of the outline's bounds.
const SIDE: f64 = 256.0;

/// Shares of the sticker's area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// The share that at least one triangle covers.
    pub covered: f64,
    /// The share that more than one triangle covers: that part of the image appears twice on the surface.
    pub doubled: f64,
}

/// Measures the coverage of an outline by triangles of the plane.
pub fn coverage(outline: &Outline, faces: &[[u32; 3]], positions: &[Vec2]) -> Coverage {
    let (low, high) = outline.bounds();
    let step = (high[0] - low[0]).max(high[1] - low[1]) / SIDE;
    let counts = [0, 1].map(|axis| (((high[axis] - low[axis]) / step).ceil() as usize).max(1));
    let place = |column: usize, row: usize| [low[0] + (column as f64 + 0.5) * step, low[1] + (row as f64 + 0.5) * step];
    let mut layers = vec![0_u8; counts[0] * counts[1]];
    for face in faces {
        let corners = face.map(|vertex| positions[vertex as usize]);
        let span = |axis: usize| {
            let values = corners.map(|corner| (corner[axis] - low[axis]) / step - 0.5);
            let least = values.into_iter().fold(f64::INFINITY, f64::min).ceil().max(0.0);
            let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().min(counts[axis] as f64 - 1.0);
            if least <= most { least as usize..most as usize + 1 } else { 0..0 }
        };
        let (columns, rows) = (span(0), span(1));
        for row in rows {
            for column in columns.clone() {
                if is_within(face, positions, place(column, row)) {
                    let count = &mut layers[row * counts[0] + column];
                    *count = count.saturating_add(1);
                }
            }
        }
    }
    let (mut all, mut covered, mut doubled) = (0_usize, 0_usize, 0_usize);
    for (index, count) in layers.iter().enumerate() {
        if outline.contains(place(index % counts[0], index / counts[0])) {
            all += 1;
            covered += usize::from(*count > 0);
            doubled += usize::from(*count > 1);
        }
    }
    // An outline thinner than the lattice has no samples.
    let share = |count: usize| if all > 0 { count as f64 / all as f64 } else { 0.0 };
    Coverage { covered: share(covered), doubled: share(doubled) }
}

/// Returns whether a point lies within a triangle. A point on an edge lies within one of the two triangles there, as both
/// evaluate the edge from its vertex of the smaller number.
fn is_within(face: &[u32; 3], positions: &[Vec2], point: Vec2) -> bool {
    let mut sides = [false; 3];
    for (corner, side) in sides.iter_mut().enumerate() {
        let (from, to) = (face[corner], face[(corner + 1) % 3]);
        let (a, b) = (positions[from.min(to) as usize], positions[from.max(to) as usize]);
        let is_left = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) > 0.0;
        *side = is_left == (from < to);
    }
    sides == [true; 3] || sides == [false; 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_cover_a_square_once() {
        let outline = Outline::rectangle([0.0, 0.0], [1.0, 0.5]).expect("simple");
        let positions = [[-0.1, -0.1], [1.1, -0.1], [1.1, 0.6], [-0.1, 0.6]];
        let both = coverage(&outline, &[[0, 1, 2], [0, 2, 3]], &positions);
        assert_eq!(both, Coverage { covered: 1.0, doubled: 0.0 });
        let one = coverage(&outline, &[[0, 1, 2]], &positions);
        assert!((one.covered - 0.5).abs() < 0.01 && one.doubled == 0.0, "{one:?}");
        let twice = coverage(&outline, &[[0, 1, 2], [0, 2, 3], [0, 1, 2]], &positions);
        assert!((twice.doubled - 0.5).abs() < 0.01 && twice.covered == 1.0, "{twice:?}");
    }
}
