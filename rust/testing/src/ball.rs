//! Balls of triangles.

use std::f32::consts::{PI, TAU};

/// Makes a ball of triangles about the origin: two poles and `rings` − 1 circles of 2 `rings` points between them.
pub fn ball(radius: f32, rings: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let around = 2 * rings;
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    for ring in 1..rings {
        let polar = PI * ring as f32 / rings as f32;
        points.extend((0..around).map(|at| {
            let angle = TAU * at as f32 / around as f32;
            [radius * polar.sin() * angle.cos(), radius * polar.sin() * angle.sin(), -radius * polar.cos()]
        }));
    }
    let id = |ring: u32, at: u32| 2 + (ring - 1) * around + at % around;
    let mut triangles = Vec::new();
    for at in 0..around {
        triangles.push([0, id(1, at + 1), id(1, at)]);
        triangles.push([1, id(rings - 1, at), id(rings - 1, at + 1)]);
        for ring in 1..rings - 1 {
            triangles.push([id(ring, at), id(ring, at + 1), id(ring + 1, at + 1)]);
            triangles.push([id(ring, at), id(ring + 1, at + 1), id(ring + 1, at)]);
        }
    }
    (points, triangles)
}
