//! Sheets of triangles whose answer is known.

use std::collections::HashSet;

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

/// How often the boundary of a disk turns around in the plane: the sum of half a turn less the angle of the faces, over the
/// vertices of the boundary, in full turns. It is 1 for a map without folds that is injective around each vertex inside, and
/// larger by 1 for each one around which the faces turn twice.
pub fn turns(triangles: &[[u32; 3]], uv: &[[f64; 2]]) -> f64 {
    let edges = triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
    let edges: HashSet<(u32, u32)> = edges.collect();
    let border: HashSet<u32> =
        edges.iter().filter(|(from, to)| !edges.contains(&(*to, *from))).map(|(from, _)| *from).collect();
    let way = |from: u32, to: u32| [0, 1].map(|axis| uv[to as usize][axis] - uv[from as usize][axis]);
    let angle = |(here, next, last): (u32, u32, u32)| {
        let ([a, b], [c, d]) = (way(here, next), way(here, last));
        (a * d - b * c).atan2(a * c + b * d)
    };
    let corners = triangles.iter().flat_map(|[a, b, c]| [(*a, *b, *c), (*b, *c, *a), (*c, *a, *b)]);
    let angles: f64 = corners.filter(|(here, ..)| border.contains(here)).map(angle).sum();
    0.5 * border.len() as f64 - angles / std::f64::consts::TAU
}

/// A fan of faces around a vertex that goes around it `count` times, all of them upright.
#[test]
fn the_boundary_of_a_fan_turns_as_often_as_the_fan() {
    for count in 1..=3_u32 {
        let steps = 7 * count;
        let place = |step: u32| (std::f64::consts::TAU * f64::from(step) / 7.0).sin_cos();
        let around = (0..steps).map(|step| [place(step).1, place(step).0]);
        let uv: Vec<[f64; 2]> = std::iter::once([0.0; 2]).chain(around).collect();
        let triangles: Vec<[u32; 3]> = (0..steps).map(|step| [0, 1 + step, 1 + (step + 1) % steps]).collect();
        let found = turns(&triangles, &uv);
        assert!((found - f64::from(count)).abs() < 1e-9, "{found}, and not {count}");
    }
}
