//! Sheets of triangles whose answer is known.

use relievo_core::Mesh;
use relievo_decal::Place;

/// A grid of `count` by `count` quads of two triangles over the unit square, moved by `shape`.
pub fn sheet(count: u32, shape: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for row in 0..=count {
        for column in 0..=count {
            let (u, v) = (f64::from(column) / f64::from(count), f64::from(row) / f64::from(count));
            points.push(shape(u, v).map(|value| value as f32));
            if row < count && column < count {
                let first = row * (count + 1) + column;
                let above = first + count + 1;
                triangles.extend([[first, first + 1, above + 1], [first, above + 1, above]]);
            }
        }
    }
    Mesh::from_triangles(points, &triangles)
}

/// The place of parameters (u, v) on such a grid.
pub fn on_sheet(count: u32, u: f64, v: f64) -> Place {
    let (x, y) = (u * f64::from(count), v * f64::from(count));
    let cell = [x, y].map(|value| (value as u32).min(count - 1));
    let (s, t) = (x - f64::from(cell[0]), y - f64::from(cell[1]));
    let face = 2 * (cell[1] * count + cell[0]);
    if s >= t {
        Place { face, barycentric: [1.0 - s, s - t, t] }
    } else {
        Place { face: face + 1, barycentric: [1.0 - t, s, t - s] }
    }
}
