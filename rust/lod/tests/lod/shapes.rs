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

/// A block from -1 to 1 with a round bore from top to bottom, as CAD programs write it: every face has triangles of its own,
/// and the bore has other points on its rims than top and bottom have. `around` points on a rim of the bore, in `rows`,
/// meet `outline` points on that of the top. Coincident points are one.
pub fn bored_block(around: u32, outline: u32, rows: u32) -> Triangles {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let rim = |step: u32, count: u32| {
        let angle = std::f32::consts::TAU * step as f32 / count as f32;
        [0.6 * angle.cos(), 0.6 * angle.sin()]
    };
    for row in 0..=rows {
        let z = 1.0 - 2.0 * row as f32 / rows as f32;
        points.extend((0..around).map(|step| rim(step, around)).map(|[x, y]| [x, y, z]));
    }
    for (row, step) in (0..rows).flat_map(|row| (0..around).map(move |step| (row, step))) {
        let [a, b] = [step, (step + 1) % around].map(|step| row * around + step);
        triangles.extend([[a, b, a + around], [b, b + around, a + around]]);
    }
    // Top and bottom: from each point of the outline to the square around it.
    for (z, turned) in [(1.0, false), (-1.0, true)] {
        let first = points.len() as u32;
        let square = |[x, y]: [f32; 2]| [x, y].map(|value| value / x.abs().max(y.abs()));
        let inner = (0..outline).map(|step| rim(step, outline));
        points.extend(inner.clone().map(|[x, y]| [x, y, z]));
        points.extend(inner.map(square).map(|[x, y]| [x, y, z]));
        for step in 0..outline {
            let [a, b] = [step, (step + 1) % outline].map(|step| first + step);
            let sides = [[a, a + outline, b], [b, a + outline, b + outline]];
            triangles.extend(sides.map(|[a, b, c]| if turned { [a, c, b] } else { [a, b, c] }));
        }
    }
    // The sides, of points of their own.
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let first = points.len() as u32;
        let corner = |along: f32, z: f32| if axis == 0 { [sign, along, z] } else { [-along, sign, z] };
        points.extend([corner(-sign, -1.0), corner(sign, -1.0), corner(sign, 1.0), corner(-sign, 1.0)]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let mut numbers = HashMap::new();
    let mut kept = Vec::new();
    let number = |point: &[f32; 3]| {
        *numbers.entry(point.map(|value| (value + 0.0).to_bits())).or_insert_with(|| {
            kept.push(*point);
            kept.len() as u32 - 1
        })
    };
    let numbers: Vec<u32> = points.iter().map(number).collect();
    let triangles = triangles.into_iter().map(|triangle| triangle.map(|vertex| numbers[vertex as usize])).collect();
    (kept, triangles)
}

/// A wavy plate of n × n squares over the unit square, and above it a row of frames of windows with rounded corners, each of
/// `around` points on its inner and its outer border, a frame `width` wide.
pub fn framed_windows(n: u32, windows: u32, around: u32, width: f32) -> Triangles {
    let (mut points, mut triangles) = lifted(n, |x, y| 0.05 * (11.0 * x).sin() * (9.0 * y).cos());
    let half = 0.4 / windows as f32;
    for window in 0..windows {
        let first = points.len() as u32;
        let centre = (window as f32 + 0.5) / windows as f32;
        for border in [half - width, half] {
            points.extend((0..around).map(|step| {
                let (sine, cosine) = (std::f32::consts::TAU * step as f32 / around as f32).sin_cos();
                // A superellipse: straight sides, rounded corners.
                let [x, z] = [cosine, sine].map(|it| it.signum() * it.abs().powf(0.4) * border);
                [centre + x, 0.5, 0.4 + z]
            }));
        }
        for step in 0..around {
            let [a, b] = [step, (step + 1) % around].map(|step| first + step);
            triangles.extend([[a, a + around, b], [b, a + around, b + around]]);
        }
    }
    (points, triangles)
}
