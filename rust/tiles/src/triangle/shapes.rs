//! Triangle meshes for tests, and channels over them.

use std::sync::Arc;

use half::f16;
use relievo_core::Mesh;
use relievo_surface::TriangleTopology;

use super::{TriangleChannel, TriangleOptions, TriangleSets, TriangleValues};

/// A bent square of `n` by `n` pairs of triangles, with a third triangle along an edge in its middle.
pub(crate) fn sail(n: u32) -> Mesh {
    let side = n + 1;
    let at = |i: u32, j: u32| {
        let [x, y] = [i, j].map(|i| i as f32 / n as f32);
        [x, y, 0.2 * x * x - 0.1 * x * y]
    };
    let mut points: Vec<[f32; 3]> = (0..side * side).map(|k| at(k % side, k / side)).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let corner = |a: u32, b: u32| (j + b) * side + i + a;
        triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
        triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
    }
    points.push([0.5, 0.5, 1.0]);
    let middle = n / 2 * side + n / 2;
    triangles.push([middle, middle + 1, side * side]);
    Mesh::from_triangles(points, &triangles)
}

/// A displacement of a small mesh.
pub(crate) fn channel(segments: u32, budget: u64) -> TriangleChannel {
    let topology = Arc::new(TriangleTopology::of_mesh(&sail(3)).unwrap());
    TriangleChannel::displacement(topology, &TriangleOptions { segments, budget }).unwrap()
}

/// Faces to be given blocks.
pub(crate) fn sets(allocate: &[u32]) -> TriangleSets {
    TriangleSets { allocate: allocate.to_vec(), ..TriangleSets::default() }
}

/// Numbers below what is asked for.
pub(crate) fn random(seed: u64) -> impl FnMut(u32) -> u32 {
    let mut state = seed | 1;
    move |below| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as u32 % below
    }
}

/// Fills what has a block with numbers.
pub(crate) fn fill(channel: &mut TriangleChannel, mut random: impl FnMut(u32) -> u32) {
    let field = channel.field().clone();
    let mut number = || f16::from_f32(random(1000) as f32 / 256.0 - 2.0);
    let mut block = |block: Option<&[f16]>| block.unwrap_or(&[]).iter().map(|_| number()).collect::<Vec<_>>();
    let faces = field.allocated().map(|face| (face, block(field.face(face)))).collect();
    let edges = field.allocated_edges().map(|edge| (edge, block(field.edge(edge)))).collect();
    let mut vertices: Vec<u32> = field.allocated().flat_map(|face| field.topology().face(face)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let vertices = vertices.into_iter().map(|vertex| (vertex, number())).collect();
    channel.write(TriangleValues { faces, edges, vertices }).unwrap();
}
