//! How far a collapse moves the surface around its edge.
//!
//! Costs measure distances from planes, which reach beyond their triangles: a vertex near all of them may be far outside of
//! the surface, and a thin limb may vanish at little cost. So a collapse that is about to be made is measured once more,
//! from triangles: the new vertex from the triangles before the collapse, both old vertices from the triangles after it.

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::connectivity::Fan;
use crate::decimation::{Decimation, Edge};

impl<const Q: usize> Decimation<Q> {
    /// Returns the largest distance of the vertices of a collapse, which puts the vertex of an edge at `point`: of the new
    /// one from the triangles of the fans, and of the old ones from the triangles after the collapse.
    pub fn offset(&self, edge: &Edge, fans: &[Fan; 2], point: Vec4) -> f32 {
        let place = |vertex: u32| self.points[vertex as usize].xyz();
        let (point, ends) = (point.xyz(), edge.ends.map(place));
        let gone = [edge.corner, self.mesh.mate(edge.corner)].map(|side| side / 4);
        let (mut new, mut old) = (f32::INFINITY, [f32::INFINITY; 2]);
        for (fan, here) in fans.iter().zip(ends) {
            for spoke in fan.spokes() {
                let [a, b] = [spoke.to, spoke.from].map(place);
                new = new.min(distance_squared(point, [here, a, b]));
                if !gone.contains(&(spoke.corner / 4)) {
                    for (old, end) in old.iter_mut().zip(ends) {
                        *old = old.min(distance_squared(end, [point, a, b]));
                    }
                }
            }
        }
        // Nothing is left of a triangle on its own.
        let old = old.into_iter().filter(|old| *old < f32::INFINITY);
        old.fold(new, f32::max).sqrt()
    }
}

/// Returns the square of the distance of a point from a triangle (Ericson 2005, Section 5.1.5).
#[inline(always)]
fn distance_squared(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let part = |part: f32, whole: f32| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    let (ee, ff, ef) = (ab.dot(ab), ac.dot(ac), ab.dot(ac));
    let whole = ee * ff - ef * ef;
    let (s, t) = (ff * d1 - ef * d2, ee * d2 - ef * d1);
    if whole > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= whole {
        return (ap - ab * (s / whole) - ac * (t / whole)).length_squared();
    }
    let bc = c - b;
    let bp = point - b;
    let first = (ap - ab * part(d1, ee)).length_squared();
    let second = (ap - ac * part(d2, ff)).length_squared();
    first.min(second).min((bp - bc * part(bp.dot(bc), bc.dot(bc))).length_squared())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_surface::triangle::closest;

    use super::*;

    proptest! {
        #[test]
        fn distances_are_those_of_the_closest_places(numbers in prop::array::uniform12(-1.0f32..1.0)) {
            let [p, a, b, c] = [0, 1, 2, 3].map(|at| Vec3::from_slice(&numbers[3 * at..]));
            let corners = [a, b, c].map(|corner| corner.as_dvec3());
            let shares = closest(p.as_dvec3(), corners);
            let place = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
            let expected = place.distance(p.as_dvec3());
            prop_assert!((f64::from(distance_squared(p, [a, b, c])).sqrt() - expected).abs() < 1e-3);
        }
    }
}
