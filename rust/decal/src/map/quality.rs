//! The distortion of a decal.

use crate::artwork::outline::Outline;
use crate::map::energy::Vec2;
use crate::map::turns::count_turned_twice;
use crate::print::coverage::{Coverage, coverage};
use crate::surface::{Surface, cross, dot, length, minus};

/// How much a decal stretches the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// Root mean square stretch (Sander, Snyder, Gortler and Hoppe 2001), scaled so that 1 is an isometric map.
    pub l2: f64,
    /// The largest stretch, scaled likewise.
    pub l_infinity: f64,
    /// The largest difference of an angle between image and surface, in radians.
    pub worst_angle: f64,
    /// The largest ratio of the scale of an area to the mean scale, or its inverse if that is larger.
    pub area_ratio: f64,
    /// The number of triangles that are turned over.
    pub flips: usize,
    /// The number of vertices inside around which the triangles turn more than once: none of them is turned over, but the map
    /// is not injective there.
    pub turned_twice: usize,
    /// The number of faces of the mesh's surface that lie under more than one layer of the sticker.
    pub overlaps: usize,
    /// The share of the sticker's area that lies on the surface: below 1 where the surface ends or cannot be reached.
    pub coverage: f64,
    /// The share of the sticker's area that lies on more than one place of the surface.
    pub doubled: f64,
    /// The number of triangles.
    pub triangles: usize,
}

/// Returns the largest and smallest stretch of a triangle of the plane onto a triangle of space, and the signed area in the
/// plane.
pub fn stretch(plane: [Vec2; 3], space: [[f64; 3]; 3]) -> (f64, f64, f64) {
    let [a, b, c] = plane;
    let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    if area == 0.0 {
        return (f64::INFINITY, 0.0, 0.0);
    }
    let [p, q, r] = space;
    let (first, second) = (minus(q, p), minus(r, p));
    let partial = |u: f64, v: f64| -> [f64; 3] {
        std::array::from_fn(|axis| (first[axis] * u + second[axis] * v) / (2.0 * area))
    };
    let along_x = partial(c[1] - a[1], a[1] - b[1]);
    let along_y = partial(a[0] - c[0], b[0] - a[0]);
    let (e, f, g) = (dot(along_x, along_x), dot(along_x, along_y), dot(along_y, along_y));
    let root = ((e - g) * (e - g) + 4.0 * f * f).sqrt();
    ((0.5 * (e + g + root)).sqrt(), (0.5 * (e + g - root)).max(0.0).sqrt(), area)
}

/// Measures a map of triangles of a surface into the plane of a sticker.
pub fn measure(
    surface: &Surface,
    outline: &Outline,
    faces: &[[u32; 3]],
    triangles: &[u32],
    positions: &[Vec2],
) -> Quality {
    let Coverage { covered, doubled } = coverage(outline, faces, positions);
    let turned_twice = count_turned_twice(faces, positions);
    let mut quality =
        Quality { turned_twice, coverage: covered, doubled, triangles: faces.len(), ..Quality::default() };
    let (mut squares, mut area, mut flat) = (0.0, 0.0, 0.0);
    let mut scales = Vec::with_capacity(faces.len());
    for (face, triangle) in faces.iter().zip(triangles) {
        let plane = face.map(|vertex| positions[vertex as usize]);
        let space = surface.corners(*triangle);
        let (larger, smaller, signed) = stretch(plane, space);
        let size = surface.area(*triangle);
        quality.flips += usize::from(signed <= 0.0);
        if size <= 0.0 {
            continue;
        }
        squares += 0.5 * (larger * larger + smaller * smaller) * size;
        area += size;
        flat += signed.abs();
        quality.l_infinity = quality.l_infinity.max(larger);
        scales.push(signed.abs() / size);
        for corner in 0..3 {
            let (here, next, last) = (corner, (corner + 1) % 3, (corner + 2) % 3);
            let (u, v) = (minus(space[next], space[here]), minus(space[last], space[here]));
            let (s, t) = (
                [plane[next][0] - plane[here][0], plane[next][1] - plane[here][1]],
                [plane[last][0] - plane[here][0], plane[last][1] - plane[here][1]],
            );
            let on_surface = length(cross(u, v)).atan2(dot(u, v));
            let in_plane = (s[0] * t[1] - s[1] * t[0]).atan2(s[0] * t[0] + s[1] * t[1]);
            quality.worst_angle = quality.worst_angle.max((on_surface - in_plane).abs());
        }
    }
    if area > 0.0 {
        let scale = (flat / area).sqrt();
        quality.l2 = (squares / area).sqrt() * scale;
        quality.l_infinity *= scale;
        let ratios = scales.iter().map(|ratio| (ratio * area / flat).max(flat / (ratio * area)));
        quality.area_ratio = ratios.fold(0.0, f64::max);
    }
    let mut sorted = triangles.to_vec();
    sorted.sort_unstable();
    quality.overlaps = sorted.chunk_by(|a, b| a == b).filter(|copies| copies.len() > 1).count();
    quality
}
