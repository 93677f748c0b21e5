//! Triangle meshes for tests.

use relievo_core::Mesh;

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
