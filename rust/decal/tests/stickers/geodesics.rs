//! Geodesics of solids whose faces unfold into the plane.

use std::collections::HashMap;

use relievo_core::Mesh;
use relievo_decal::{nearest, shortest_path};

/// How far the length of a path may be from that of the segment in the plane.
const NEAR: f64 = 1e-9;

/// The cube from 0 to 1 with `count` by `count` squares of two triangles on each side.
fn cube(count: u32) -> Mesh {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    for axis in 0..3 {
        for side in [0, count] {
            for square in 0..count * count {
                let [i, j] = [square % count, square / count];
                let mut corner = |u: u32, v: u32| {
                    let mut at = [0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, u, v);
                    *numbers.entry(at).or_insert_with(|| {
                        points.push(at.map(|value| value as f32 / count as f32));
                        points.len() as u32 - 1
                    })
                };
                let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                triangles.extend(if side > 0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    Mesh::from_triangles(points, &triangles)
}

/// The length of the geodesic between the places nearest to two points.
fn length(mesh: &Mesh, points: [[f64; 3]; 2]) -> f64 {
    let places = points.map(|point| nearest(mesh, point).expect("a place").0);
    let path = shortest_path(mesh, places).expect("a path");
    for (end, point) in [path[0], path[path.len() - 1]].into_iter().zip(points) {
        assert!(distance(end, point) < NEAR, "{end:?} is not {point:?}");
    }
    path.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn a_geodesic_on_a_cube_is_as_long_as_the_segment_between_unfolded_sides() {
    for count in [1, 8] {
        let mesh = cube(count);
        // From the side z = 1 over the edge to the side x = 1, directly and over the side y = 1.
        for ([x, y], [u, v]) in [
            ([0.30, 0.42], [0.55, 0.37]),
            ([0.81, 0.13], [0.29, 0.72]),
            ([0.47, 0.66], [0.61, 0.11]),
            ([0.12, 0.53], [0.44, 0.81]),
        ] {
            let direct = f64::hypot((1.0 - x) + (1.0 - v), y - u);
            let around = f64::hypot((1.0 - x) + (1.0 - u), (1.0 - y) + (1.0 - v));
            let found = length(&mesh, [[x, y, 1.0], [1.0, u, v]]);
            assert!(direct < around, "the test takes the shorter way");
            assert!((found - direct).abs() < NEAR, "{count}: {found}, and not {direct}");
        }
        // Across the whole side x = 1, from z = 1 to z = 0.
        let found = length(&mesh, [[0.9, 0.35, 1.0], [0.8, 0.55, 0.0]]);
        assert!((found - 1.3_f64.hypot(0.2)).abs() < NEAR, "{count}: {found}");
    }
}

#[test]
fn a_geodesic_over_an_edge_of_a_tetrahedron_is_straight_once_its_faces_are_unfolded() {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let points = corners.map(|corner: [f64; 3]| corner.map(|value| value as f32));
    let mesh = Mesh::from_triangles(points.to_vec(), &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]);
    // Coordinates along the edge from the first corner to the second and away from it, on both of its faces.
    let edge = 8.0_f64.sqrt();
    let at = |third: usize, along: f64, away: f64| -> [f64; 3] {
        let height = edge * 0.75_f64.sqrt();
        std::array::from_fn(|axis| {
            let (from, to) = (corners[0][axis], corners[1][axis]);
            let middle = 0.5 * (from + to);
            from + along / edge * (to - from) + away / height * (corners[third][axis] - middle)
        })
    };
    for ([along, away], [other, beyond]) in
        [([1.1, 0.4], [1.6, 0.7]), ([0.7, 0.3], [1.9, 0.2]), ([1.4, 1.2], [1.3, 0.9])]
    {
        let found = length(&mesh, [at(2, along, away), at(3, other, beyond)]);
        let expected = f64::hypot(along - other, away + beyond);
        assert!((found - expected).abs() < NEAR, "{found}, and not {expected}");
    }
}

#[test]
fn places_on_two_components_have_no_path() {
    let mut mesh = cube(1);
    let other = cube(1);
    let count = mesh.points.len() as u32;
    mesh.points.extend(other.points.iter().map(|[x, y, z]| [x + 3.0, *y, *z]));
    let triangles: Vec<[u32; 3]> = mesh.corners.as_chunks::<3>().0.to_vec();
    let moved = triangles.iter().map(|triangle| triangle.map(|corner| corner + count));
    let both: Vec<[u32; 3]> = triangles.iter().copied().chain(moved).collect();
    let mesh = Mesh::from_triangles(mesh.points, &both);
    let places = [[0.3, 0.4, 1.0], [3.3, 0.4, 1.0]].map(|point| nearest(&mesh, point).expect("a place").0);
    let error = shortest_path(&mesh, places).expect_err("they are apart").to_string();
    assert!(error.contains("no path joins the places"), "{error}");
}
