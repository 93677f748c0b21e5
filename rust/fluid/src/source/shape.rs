//! Meshes of simple shapes, to fill, to emit from and to collide with.

use std::f32::consts::{PI, TAU};

use glam::{BVec3, Vec3};

/// Cells of a sphere around its axis, and half as many from pole to pole.
const AROUND: u32 = 48;

/// The points of a box from its low to its high corner in metres, and its triangles, counter-clockwise from outside.
pub fn cuboid(low: Vec3, high: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |number: u32| Vec3::select(BVec3::new(number & 1 != 0, number & 2 != 0, number & 4 != 0), high, low);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    ((0..8).map(corner).collect(), triangles.collect())
}

/// The points of a sphere about a place, of a radius in metres, and its triangles, counter-clockwise from outside.
pub fn sphere(middle: Vec3, radius: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let rings = AROUND / 2;
    let ring = |ring: u32| {
        let (height, out) = ((PI * ring as f32 / rings as f32).cos(), (PI * ring as f32 / rings as f32).sin());
        (0..AROUND).map(move |at| {
            let turn = TAU * at as f32 / AROUND as f32;
            Vec3::new(out * turn.cos(), out * turn.sin(), height)
        })
    };
    let poles = [Vec3::Z, Vec3::NEG_Z];
    let points = poles.into_iter().chain((1..rings).flat_map(ring)).map(|point| middle + radius * point);
    let number = |ring: u32, at: u32| 2 + (ring - 1) * AROUND + at % AROUND;
    let mut triangles = Vec::new();
    for at in 0..AROUND {
        triangles.push([0, number(1, at), number(1, at + 1)]);
        for ring in 1..rings - 1 {
            let [a, b] = [number(ring, at), number(ring, at + 1)];
            let [c, d] = [number(ring + 1, at + 1), number(ring + 1, at)];
            triangles.extend([[a, d, c], [a, c, b]]);
        }
        triangles.push([1, number(rings - 1, at + 1), number(rings - 1, at)]);
    }
    (points.collect(), triangles)
}
