//! What the benches measure on: generated meshes and, where they are there, public models beside the checkout.

use std::f32::consts::TAU;

use relievo_core::{Context, Mesh, Result};

/// The model `name` of the folder of models, `None` where there is no such file.
pub fn model(context: &Context, name: &str) -> Result<Option<Mesh>> {
    let path = relievo_testing::folder().join(name);
    if path.is_file() { relievo_meshio::read(context, &path).map(Some) } else { Ok(None) }
}

/// A closed tube around a knotted circle: `n` × `m` quads, each cut in two.
pub fn knot(n: u32, m: u32) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (TAU * i as f32 / n as f32, TAU * j as f32 / m as f32);
            let tube = 0.35 + 0.05 * (7.0 * a + 3.0 * b).sin();
            let radius = 1.0 + tube * b.cos();
            points.push([radius * a.cos(), radius * a.sin(), tube * b.sin() + 0.2 * (2.0 * a).sin()]);
            let at = |i: u32, j: u32| i % n * m + j % m;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    Mesh::from_triangles(points, &triangles)
}

/// A torus of `around` × `across` quads, all of them regular.
pub fn torus(around: u32, across: u32) -> Mesh {
    let angle = |index: u32, count: u32| TAU * index as f32 / count as f32;
    let mut points = Vec::new();
    let mut corners = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (angle(i, around), angle(j, across));
            let radius = 3.0 + b.cos();
            points.push([radius * a.cos(), radius * a.sin(), b.sin()]);
            let point = |i: u32, j: u32| i % around * across + j % across;
            corners.extend([point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
        }
    }
    Mesh::new(points, vec![4; (around * across) as usize], corners)
}

/// A rolling plane of `side` × `side` faces of edge 1 around the origin, z up.
pub fn terrain(side: u32) -> Mesh {
    let half = side as f32 / 2.0;
    let row = side + 1;
    let mut points = Vec::new();
    for (j, i) in (0..row).flat_map(|j| (0..row).map(move |i| (j, i))) {
        let (x, y) = (i as f32 - half, j as f32 - half);
        points.push([x, y, 0.04 * ((0.9 * x).sin() + (1.1 * y + 0.3 * x).cos())]);
    }
    let corners = (0..side).flat_map(|j| (0..side).map(move |i| j * row + i));
    let corners: Vec<u32> = corners.flat_map(|at| [at, at + 1, at + row + 1, at + row]).collect();
    Mesh::new(points, vec![4; (side * side) as usize], corners)
}

/// A sphere around the origin with `meridians` and `bands` of equal area, so that a tenth of its height holds a tenth
/// of its 2·`meridians`·(`bands` − 1) triangles.
pub fn ball(radius: f32, meridians: u32, bands: u32) -> Mesh {
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    for j in 1..bands {
        let z = 2.0 * j as f32 / bands as f32 - 1.0;
        let ring = (1.0 - z * z).sqrt();
        for i in 0..meridians {
            let turn = TAU * i as f32 / meridians as f32;
            points.push([radius * ring * turn.cos(), radius * ring * turn.sin(), radius * z]);
        }
    }
    let at = |i: u32, j: u32| match j {
        0 => 0,
        j if j == bands => 1,
        j => 2 + (j - 1) * meridians + i % meridians,
    };
    let mut triangles = Vec::new();
    for (j, i) in (0..bands).flat_map(|j| (0..meridians).map(move |i| (j, i))) {
        let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if j > 0 {
            triangles.push([p, q, r]);
        }
        if j + 1 < bands {
            triangles.push([p, r, s]);
        }
    }
    Mesh::from_triangles(points, &triangles)
}
