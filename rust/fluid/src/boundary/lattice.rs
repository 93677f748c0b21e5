//! A square lattice in a flat mesh: places whose cells have their middle in it, and the area that they are to stand for.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use relievo_core::{Error, Result};

use crate::boundary::collider::join;

/// How far normals may be from the mean, as a cosine: a degree.
const FLAT: f64 = 0.99985;
/// The share of the area that may face elsewhere: slivers do, by rounding.
const STRAY: f64 = 1e-3;
/// Places nearer to one in the same cell than this are the same, in spacings.
const APART: f64 = 0.9;
/// How much nearer to the area another lattice must come to be taken instead of the one that is even about the middle.
const BETTER: f64 = 0.02;
/// Cells of a spacing along an axis by which an area is measured where triangles lie on each other.
const FINE: f64 = 8.0;
/// Cells to look at, at most.
const MAX: f64 = (1u32 << 26) as f64;

/// Places on a mesh, and what it is.
pub struct Lattice {
    pub places: Vec<Vec3>,
    pub normal: Vec3,
    /// m², counted once where triangles lie on each other.
    pub area: f64,
}

/// A mesh seen along its normal, with the middle of its bounds as the origin.
struct Flat {
    /// Across, along and up.
    axes: [DVec3; 3],
    origin: DVec3,
    extent: DVec2,
    /// Counter-clockwise, with heights.
    triangles: Vec<[DVec3; 3]>,
}

/// The lattice of a spacing in triangles that all face the same way, whose sides it goes along; `None` if they do not, or
/// have no area. Fails if they are too large for the spacing.
pub fn lattice(points: &[Vec3], triangles: &[[u32; 3]], spacing: f32) -> Result<Option<Lattice>> {
    let Some(flat) = Flat::new(points, triangles) else { return Ok(None) };
    let spacing = f64::from(spacing);
    let mut area: f64 =
        flat.triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).truncate().perp_dot((*c - *a).truncate())).sum();
    // Even about the middle first.
    let odd = |extent: f64| if (extent / spacing).round() % 2.0 == 1.0 { 0.0 } else { 0.5 };
    let even = DVec2::new(odd(flat.extent.x), odd(flat.extent.y));
    let shifts = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]].map(|shift| (even + DVec2::from(shift)).fract());
    let mut best: Option<(f64, Vec<DVec3>)> = None;
    for shift in shifts {
        let (places, has_doubles) = flat.places(spacing, shift)?;
        if has_doubles && best.is_none() {
            area = flat.places(spacing / FINE, DVec2::splat(0.5))?.0.len() as f64 * (spacing / FINE).powi(2);
        }
        let off = (places.len() as f64 * spacing * spacing / area).ln().abs();
        if best.as_ref().is_none_or(|(least, _)| off < least - BETTER) {
            best = Some((off, places));
        }
    }
    let [u, v, normal] = flat.axes;
    let place = |at: &DVec3| (flat.origin + at.x * u + at.y * v + at.z * normal).as_vec3();
    let places = best.iter().flat_map(|(_, places)| places).map(place).collect();
    Ok(Some(Lattice { places, normal: normal.as_vec3(), area }))
}

impl Flat {
    fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let corners = |triangle: &[u32; 3]| triangle.map(|point| points[point as usize].as_dvec3());
        let cross = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let normal = triangles.iter().map(|triangle| cross(corners(triangle))).sum::<DVec3>().try_normalize()?;
        let is_seen = |triangle: &&[u32; 3]| cross(corners(triangle)).normalize_or_zero().dot(normal) >= FLAT;
        let double = |triangle: &[u32; 3]| cross(corners(triangle)).length();
        let seen: Vec<[u32; 3]> = triangles.iter().filter(is_seen).copied().collect();
        let all: f64 = triangles.iter().map(double).sum();
        if seen.iter().map(double).sum::<f64>() < (1.0 - STRAY) * all {
            return None;
        }
        let triangles = seen;
        let (u, v) = normal.any_orthonormal_pair();
        let first = points[triangles[0][0] as usize].as_dvec3();
        let seen = |at: DVec3, u: DVec3, v: DVec3| {
            DVec3::new((at - first).dot(u), (at - first).dot(v), (at - first).dot(normal))
        };
        // The sides of the mesh, all a quarter turn alike.
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        let joined = join(points);
        let sides = |triangle: &[u32; 3]| {
            [0, 1, 2].map(|side| [side, (side + 1) % 3].map(|corner| joined[triangle[corner] as usize]))
        };
        for [a, b] in triangles.iter().flat_map(sides) {
            *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
        let rims = triangles.iter().flat_map(sides).filter(|[a, b]| edges[&[*a.min(b), *a.max(b)]] != 0);
        let turned: DVec2 = rims
            .map(|[a, b]| {
                let side = points[b as usize].as_dvec3() - points[a as usize].as_dvec3();
                let side = DVec2::new(side.dot(u), side.dot(v));
                side.length() * DVec2::from_angle(4.0 * side.to_angle())
            })
            .sum();
        let turn = DVec2::from_angle(0.25 * turned.to_angle());
        let (u, v) = (turn.x * u + turn.y * v, turn.x * v - turn.y * u);
        let mut triangles: Vec<[DVec3; 3]> =
            triangles.iter().map(|triangle| corners(triangle).map(|at| seen(at, u, v))).collect();
        let all = || triangles.iter().flatten().map(|at| at.truncate());
        let low = all().fold(DVec2::INFINITY, DVec2::min);
        let high = all().fold(DVec2::NEG_INFINITY, DVec2::max);
        let middle = (0.5 * (low + high)).extend(0.0);
        triangles.iter_mut().flatten().for_each(|at| *at -= middle);
        let origin = first + middle.x * u + middle.y * v;
        Some(Self { axes: [u, v, normal], origin, extent: high - low, triangles })
    }

    /// The places of a lattice in it, shifted from its middle by so many spacings, in the order of its rows; and whether
    /// there was a place more than once.
    fn places(&self, spacing: f64, shift: DVec2) -> Result<(Vec<DVec3>, bool)> {
        let cells = |triangle: &[DVec3; 3]| {
            let low = triangle.iter().fold(DVec2::INFINITY, |low, at| low.min(at.truncate()));
            let high = triangle.iter().fold(DVec2::NEG_INFINITY, |high, at| high.max(at.truncate()));
            [(low / spacing - shift).ceil(), (high / spacing - shift).floor()]
        };
        let count = |[low, high]: [DVec2; 2]| ((high - low + 1.0).max(DVec2::ZERO)).element_product();
        let all: f64 = self.triangles.iter().map(|triangle| 1.0 + count(cells(triangle))).sum();
        // What is not a number is refused too.
        if !matches!(all.partial_cmp(&MAX), Some(std::cmp::Ordering::Less)) {
            return Err(Error::memory("a mesh is too large for a layer of particles of the fluid's spacing")
                .advise("take a larger spacing or a smaller mesh"));
        }
        let mut taken: HashMap<[i64; 2], Vec<f64>> = HashMap::new();
        let mut has_doubles = false;
        for triangle in &self.triangles {
            let [low, high] = cells(triangle).map(|cell| cell.as_i64vec2());
            for (y, x) in (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| (y, x))) {
                let at = spacing * (DVec2::new(x as f64, y as f64) + shift);
                let Some(height) = height(triangle, at) else { continue };
                let heights = taken.entry([y, x]).or_default();
                match heights.iter().any(|other| (other - height).abs() < APART * spacing) {
                    true => has_doubles = true,
                    false => heights.push(height),
                }
            }
        }
        let mut taken: Vec<_> = taken.into_iter().collect();
        taken.iter_mut().for_each(|(_, heights)| heights.sort_unstable_by(f64::total_cmp));
        taken.sort_unstable_by_key(|(cell, _)| *cell);
        let places = taken.iter().flat_map(|([y, x], heights)| {
            let at = spacing * (DVec2::new(*x as f64, *y as f64) + shift);
            heights.iter().map(move |height| at.extend(*height))
        });
        Ok((places.collect(), has_doubles))
    }
}

/// How high a triangle is at a place; `None` beside it. A place on a side that two triangles share is in one of them.
fn height(triangle: &[DVec3; 3], at: DVec2) -> Option<f64> {
    let mut weights = [0.0; 3];
    for corner in 0..3 {
        let (from, to) = (triangle[(corner + 1) % 3].truncate(), triangle[(corner + 2) % 3].truncate());
        // Both triangles of a side compute the same.
        let is_along = (from.x, from.y) < (to.x, to.y);
        let (low, high) = if is_along { (from, to) } else { (to, from) };
        let side = (high - low).perp_dot(at - low);
        // A place on a side is taken for one next to it, with a slightly larger x.
        let next = if high.y == low.y { high.x - low.x } else { low.y - high.y };
        let is_left = if side == 0.0 { next > 0.0 } else { side > 0.0 };
        if is_left != is_along {
            return None;
        }
        weights[corner] = side.abs();
    }
    let sum: f64 = weights.iter().sum();
    let heights = triangle.iter().zip(weights).map(|(corner, weight)| weight * corner.z).sum::<f64>();
    (sum > 0.0).then(|| heights / sum)
}
