//! Meshes to try things on.

use std::collections::HashMap;

pub type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A grid of n × n squares over the unit square, lifted by a function.
pub fn lifted(n: u32, height: impl Fn(f32, f32) -> f32) -> Triangles {
    let at = |x: u32, y: u32| [x as f32 / n as f32, y as f32 / n as f32];
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| at(x, y))).map(|[x, y]| [x, y, height(x, y)]).collect();
    let squares = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    (points, squares.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect())
}

/// A closed surface over a grid that wraps round, u and v from 0 to 1.
pub fn wrapped(n: u32, m: u32, place: impl Fn(f32, f32) -> [f32; 3]) -> Triangles {
    let points = (0..m).flat_map(|y| (0..n).map(move |x| (x, y)));
    let points = points.map(|(x, y)| place(x as f32 / n as f32, y as f32 / m as f32)).collect();
    let at = |x: u32, y: u32| y % m * n + x % n;
    let squares = (0..m).flat_map(|y| (0..n).map(move |x| (x, y)));
    let sides = |(x, y)| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]];
    (points, squares.flat_map(sides).collect())
}

pub fn torus(n: u32, m: u32) -> Triangles {
    let turn = std::f32::consts::TAU;
    wrapped(n, m, |u, v| {
        let radius = 1.0 + 0.4 * (turn * v).cos();
        [radius * (turn * u).cos(), radius * (turn * u).sin(), 0.4 * (turn * v).sin()]
    })
}

/// How many triangles there are at every edge.
pub fn edges(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], u32> {
    let mut edges = HashMap::new();
    for [a, b, c] in triangles {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            *edges.entry([*u.min(v), *u.max(v)]).or_default() += 1;
        }
    }
    edges
}

/// Two tori that touch along an edge, a triangle twice, one without area, and a point of none.
pub fn two_tori() -> Triangles {
    let (mut points, mut triangles) = torus(30, 16);
    let count = points.len() as u32;
    let shared = [0, 1];
    let number = |vertex: u32| if shared.contains(&vertex) { vertex } else { vertex + count };
    triangles.extend(triangles.clone().into_iter().map(|triangle| triangle.map(number)));
    points.extend(points.clone().into_iter().map(|[x, y, z]| [2.8 - x, y, z]));
    let more = points.len() as u32;
    points.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0], [9.0, 9.0, 9.0]]);
    triangles.extend([[more, more + 1, more + 2], [more, more + 1, more + 2], [more, more, more + 1]]);
    (points, triangles)
}
