//! Meshes and objects that several of these tests begin with.

mod objects;

use glam::DVec3;
use relievo_core::Mesh;

pub(crate) use objects::{fine_values, painted, redo_both, stored_bytes, stored_triangles, undo_both, value_bytes};

/// Makes a square from 0 to `n` in z = 0, of unit faces.
pub(crate) fn plane(n: u32) -> Mesh {
    quads(n, 0.0)
}

/// Makes a square of n × n unit faces around the origin in z = 0.
pub(crate) fn centred_plane(n: u32) -> Mesh {
    quads(n, -0.5 * n as f32)
}

/// Makes a square from 0 to `n` in z = 0, of unit squares cut in two.
pub(crate) fn triangle_plane(n: u32) -> Mesh {
    halves(&plane(n))
}

/// Makes a square from −n/2 to n/2 in z = 0, of unit squares cut in two.
pub(crate) fn centred_triangle_plane(n: u32) -> Mesh {
    halves(&centred_plane(n))
}

/// Makes a square of n × n unit faces in z = 0 whose first corner is at `first` along x and y.
fn quads(n: u32, first: f32) -> Mesh {
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [first + x as f32, first + y as f32, 0.0])).collect();
    let corners = squares(n).into_flattened();
    Mesh::new(points, vec![4; (n * n) as usize], corners)
}

/// Returns the corners of n × n squares, row by row, whose points are row by row too.
pub(crate) fn squares(n: u32) -> Vec<[u32; 4]> {
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let square = |x: u32, y: u32| [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
    (0..n).flat_map(|y| (0..n).map(move |x| square(x, y))).collect()
}

/// Cuts squares in two, from the first corner to the third.
pub(crate) fn halved(squares: &[[u32; 4]]) -> Vec<[u32; 3]> {
    squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

/// Cuts the faces of a mesh of quads in two.
fn halves(mesh: &Mesh) -> Mesh {
    Mesh::from_triangles(mesh.points.clone(), &halved(mesh.corners.as_chunks().0))
}

/// Makes a cube around the origin, `half` from its middle to its sides, whose corners have valence 3.
pub(crate) fn cube(half: f32) -> Mesh {
    let points = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -half } else { half })).collect();
    let corners = vec![0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6];
    Mesh::new(points, vec![4; 6], corners)
}

/// Makes an octahedron whose faces are cut in `n` by `n` and brought to the sphere of `radius`.
pub(crate) fn octahedral_ball(n: i32, radius: f64) -> Mesh {
    let (mut points, mut triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
    let mut numbers = std::collections::BTreeMap::new();
    for sign in 0..8u32 {
        let side = |axis: u32| if sign >> axis & 1 == 0 { 1 } else { -1 };
        let mut at = |i: i32, j: i32| {
            let place = [side(0) * i, side(1) * j, side(2) * (n - i - j)];
            *numbers.entry(place).or_insert_with(|| {
                points.push((DVec3::from(place.map(f64::from)).normalize() * radius).as_vec3().to_array());
                points.len() as u32 - 1
            })
        };
        let mut add = |[a, b, c]: [u32; 3]| {
            triangles.push(if sign.count_ones() % 2 == 0 { [a, b, c] } else { [a, c, b] });
        };
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            add([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < n {
                add([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    Mesh::from_triangles(points, &triangles)
}
