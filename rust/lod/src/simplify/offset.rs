//! How far a collapse moves the surface around its edge.
//!
//! Costs measure distances from planes, which reach beyond their triangles: a vertex near all of them may be far outside of
//! the surface, and a thin limb may vanish at little cost. So a collapse that is about to be made is measured once more,
//! from triangles: the new vertex from the triangles before the collapse, both old vertices from the triangles after it.
//! Eight triangles are looked at together.

use glam::{Vec3, Vec4, Vec4Swizzles};
use relievo_core::simd::{Arithmetic, Level};

use crate::connectivity::Fan;
use crate::simplify::decimation::{Decimation, Edge};

/// Triangles that are looked at together.
pub const LANES: usize = 8;
/// Groups of so many: two fans of [`Fan::MAX`] triangles.
const GROUPS: usize = 2 * Fan::MAX / LANES;

/// Triangles around an edge, one array a number.
pub struct Around {
    /// The vertex of the fan and the two others of every triangle, by axis.
    triangles: [[[[f32; LANES]; 3]; 3]; GROUPS],
    /// 0, or infinity for triangles that vanish with the edge.
    vanishing: [[f32; LANES]; GROUPS],
    count: usize,
}

impl Default for Around {
    fn default() -> Self {
        Self { triangles: [[[[0.0; LANES]; 3]; 3]; GROUPS], vanishing: [[0.0; LANES]; GROUPS], count: 0 }
    }
}

impl Around {
    /// Adds a triangle, of which there may be two full fans.
    #[inline(always)]
    fn push(&mut self, corners: [Vec3; 3], is_vanishing: bool) {
        let (group, lane) = (self.count / LANES, self.count % LANES);
        for (room, corner) in self.triangles[group].iter_mut().zip(corners) {
            for axis in 0..3 {
                room[axis][lane] = corner[axis];
            }
        }
        self.vanishing[group][lane] = if is_vanishing { f32::INFINITY } else { 0.0 };
        self.count += 1;
    }

    /// Repeats the last triangle to the end of its group.
    fn fill_group(&mut self) {
        let used = self.count % LANES;
        if used > 0 {
            let group = self.count / LANES;
            let rows = self.triangles[group].as_flattened_mut().iter_mut().chain([&mut self.vanishing[group]]);
            rows.for_each(|row| {
                let last = row[used - 1];
                row[used..].fill(last);
            });
        }
    }
}

impl<const Q: usize> Decimation<Q> {
    /// Returns the largest distance of the vertices of a collapse, which puts the vertex of an edge at `point`: of the new
    /// one from the triangles of the fans, and of the old ones from the triangles after the collapse.
    pub fn offset(&self, level: Level, edge: &Edge, fans: &[Fan; 2], point: Vec4, around: &mut Around) -> f32 {
        let place = |vertex: u32| self.points[vertex as usize].xyz();
        let ends = edge.ends.map(place);
        let gone = [edge.corner, self.mesh.mate(edge.corner)].map(|side| side / 4);
        around.count = 0;
        for (fan, here) in fans.iter().zip(ends) {
            for spoke in fan.spokes() {
                around.push([here, place(spoke.to), place(spoke.from)], gone.contains(&(spoke.corner / 4)));
            }
        }
        around.fill_group();
        let [new, old @ ..] = nearest(level, around, [point.xyz(), ends[0], ends[1]].map(|it| it.to_array()));
        // Nothing is left of a triangle on its own.
        let old = old.into_iter().filter(|old| *old < f32::INFINITY);
        old.fold(new, f32::max).sqrt()
    }
}

relievo_core::dispatch_simd! {
    /// Returns the squares of the distances of the new vertex from the nearest triangle, and of both old ones from the
    /// nearest after the collapse; infinity where there is none.
    fn nearest = nearest_body(around: &Around, vertices: [[f32; 3]; 3]) -> [f32; 3]
}

#[inline(always)]
fn nearest_body<A: Arithmetic>(_: A, around: &Around, [new, start, end]: [[f32; 3]; 3]) -> [f32; 3] {
    let mut least = [[f32::INFINITY; LANES]; 3];
    let groups = around.count.div_ceil(LANES);
    for (triangles, vanishing) in around.triangles[..groups].iter().zip(&around.vanishing[..groups]) {
        let [c, a, b] = triangles;
        for i in 0..LANES {
            let [c, a, b] = [[c[0][i], c[1][i], c[2][i]], [a[0][i], a[1][i], a[2][i]], [b[0][i], b[1][i], b[2][i]]];
            least[0][i] = lesser(least[0][i], distance_squared(new, [c, a, b]));
            least[1][i] = lesser(least[1][i], distance_squared(start, [new, a, b]) + vanishing[i]);
            least[2][i] = lesser(least[2][i], distance_squared(end, [new, a, b]) + vanishing[i]);
        }
    }
    let mut nearest = [f32::INFINITY; 3];
    for (nearest, least) in nearest.iter_mut().zip(&least) {
        for least in least {
            *nearest = lesser(*nearest, *least);
        }
    }
    nearest
}

/// Below it nothing is divided.
const MIN: f32 = 1e-37;

/// Returns the square of the distance of a point from a triangle (Ericson 2005, Section 5.1.5), without a branch.
#[inline(always)]
pub fn distance_squared(p: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> f32 {
    let (ab, ac, bc, ap, bp) = (minus(b, a), minus(c, a), minus(c, b), minus(p, a), minus(p, b));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    let (ee, ff, ef) = (dot(ab, ab), dot(ac, ac), dot(ab, ac));
    let whole = ee * ff - ef * ef;
    let (s, t) = (ff * d1 - ef * d2, ee * d2 - ef * d1);
    let inverse = 1.0 / greater(whole, MIN);
    let above = without(without(ap, ab, s * inverse), ac, t * inverse);
    let [first, second] = [without(ap, ab, part(d1, ee)), without(ap, ac, part(d2, ff))];
    let third = without(bp, bc, part(dot(bp, bc), dot(bc, bc)));
    let sides = lesser(lesser(dot(first, first), dot(second, second)), dot(third, third));
    let is_above = (whole > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= whole);
    if is_above { dot(above, above) } else { sides }
}

#[inline(always)]
fn minus(x: [f32; 3], y: [f32; 3]) -> [f32; 3] {
    [x[0] - y[0], x[1] - y[1], x[2] - y[2]]
}

#[inline(always)]
fn dot(x: [f32; 3], y: [f32; 3]) -> f32 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// Returns `x` without a share of `y`.
#[inline(always)]
fn without(x: [f32; 3], y: [f32; 3], share: f32) -> [f32; 3] {
    [x[0] - share * y[0], x[1] - share * y[1], x[2] - share * y[2]]
}

/// Returns a part as a share of the whole, 0 to 1.
#[inline(always)]
fn part(part: f32, whole: f32) -> f32 {
    lesser(greater(part / greater(whole, MIN), 0.0), 1.0)
}

#[inline(always)]
pub fn lesser(x: f32, y: f32) -> f32 {
    if x < y { x } else { y }
}

#[inline(always)]
fn greater(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_surface::triangle::closest;

    use super::*;

    fn distance(p: Vec3, corners: [Vec3; 3]) -> f64 {
        let corners = corners.map(|corner| corner.as_dvec3());
        let shares = closest(p.as_dvec3(), corners);
        (corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2]).distance(p.as_dvec3())
    }

    proptest! {
        #[test]
        fn distances_are_those_of_the_closest_places(numbers in prop::collection::vec(-1.0f32..1.0, 9..90)) {
            let place = |at: usize| Vec3::from_slice(&numbers[3 * at..]);
            let [new, start, end] = [0, 1, 2].map(place);
            let mut around = Around::default();
            let mut expected = [f64::INFINITY; 3];
            for at in 2..numbers.len() / 3 - 1 {
                let [a, b] = [place(at), place(at + 1)];
                let is_vanishing = at % 3 == 0;
                around.push([start, a, b], is_vanishing);
                expected[0] = expected[0].min(distance(new, [start, a, b]));
                for (expected, old) in expected[1..].iter_mut().zip([start, end]).filter(|_| !is_vanishing) {
                    *expected = expected.min(distance(old, [new, a, b]));
                }
            }
            around.fill_group();
            for level in [Level::Baseline, Level::best()] {
                let found = nearest(level, &around, [new, start, end].map(|it| it.to_array()));
                for (found, expected) in found.into_iter().zip(expected) {
                    let is_none = f64::from(found) == expected;
                    prop_assert!(is_none || (f64::from(found).sqrt() - expected).abs() < 1e-3, "{found} {expected}");
                }
            }
        }
    }
}
