//! Closed triangle meshes for the tests.

use std::f32::consts::TAU;

/// Points and triangles.
pub type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A cube of half edge `half`.
pub fn cube(half: f32) -> Soup {
    let points = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -half } else { half })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    (points, triangles)
}

/// A torus around z with `n` × `m` quads, each cut in two.
pub fn torus(major: f32, minor: f32, n: u32, m: u32) -> Soup {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (TAU * i as f32 / n as f32, TAU * j as f32 / m as f32);
            let r = major + minor * b.cos();
            points.push([r * a.cos(), r * a.sin(), minor * b.sin()]);
            let at = |i: u32, j: u32| i % n * m + j % m;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    (points, triangles)
}

/// A sphere with poles on z, `n` meridians and `m` bands; `bump` shakes its radius.
pub fn sphere(radius: f32, n: u32, m: u32, bump: f32) -> Soup {
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    let at = |i: u32, j: u32| match j {
        0 => 0,
        j if j == m => 1,
        j => 2 + (j - 1) * n + i % n,
    };
    for j in 1..m {
        for i in 0..n {
            let (a, b) = (TAU * i as f32 / n as f32, TAU * (j as f32 / m as f32 / 2.0 - 0.25));
            let r = radius + bump * ((5.0 * a).sin() * (7.0 * b).cos());
            points.push([r * b.cos() * a.cos(), r * b.cos() * a.sin(), r * b.sin()]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..m {
        for i in 0..n {
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if j > 0 {
                triangles.push([p, q, r]);
            }
            if j + 1 < m {
                triangles.push([p, r, s]);
            }
        }
    }
    (points, triangles)
}

/// Both meshes as one.
pub fn joined((mut points, mut triangles): Soup, other: Soup) -> Soup {
    let shift = points.len() as u32;
    points.extend(other.0);
    triangles.extend(other.1.iter().map(|triangle| triangle.map(|point| point + shift)));
    (points, triangles)
}

/// The mesh moved.
pub fn moved((mut points, triangles): Soup, by: [f32; 3]) -> Soup {
    for point in &mut points {
        for axis in 0..3 {
            point[axis] += by[axis];
        }
    }
    (points, triangles)
}

/// The mesh turned inside out.
pub fn inverted((points, mut triangles): Soup) -> Soup {
    for triangle in &mut triangles {
        triangle.swap(1, 2);
    }
    (points, triangles)
}
