//! What the benches measure on: generated meshes and, where they are there, public models beside the checkout.

use std::f32::consts::TAU;
use std::path::PathBuf;

use relievo_core::{Context, Mesh, Result};

/// The model `name` of the test data, `None` where there is no such file. The folder is `RELIEVO_DATA`, or
/// `shared/data` beside the checkout.
pub fn model(context: &Context, name: &str) -> Result<Option<Mesh>> {
    let folder = std::env::var_os("RELIEVO_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")), PathBuf::from);
    let path = folder.join(name);
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
