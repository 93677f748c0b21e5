//! Particles that would go through a moving triangle in a step are held before it.
//!
//! Points and the corners of triangles move in straight lines during a step, so a point is in the plane of a triangle where a
//! polynomial of the third degree is 0 (Provot 1997). The first such time at which it lies within is where they meet. What
//! follows from that must not lead through another triangle, so it is looked at anew.

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::Context;

use crate::boundary::collider::{Collider, Contact};
use crate::solver::neighbours::CHUNK_LEN;
use crate::surface::hierarchy::Bounds;

/// How far before a triangle a particle is put that met it, in spacings, and as a share of its coordinates.
const GAP: [f64; 2] = [0.01, 1e-6];
/// Triangles that a particle may meet in a step before it is taken along by the last one.
const MEETINGS: usize = 8;
/// How far beyond a side of a triangle counts as within, as a share of it: neighbours leave no gap where numbers are rounded.
const BEYOND: f64 = 1e-7;

/// Which triangles each particle may meet in a step.
#[derive(Default)]
pub struct Sweep {
    parts: Vec<Part>,
}

/// Those of a part of [`CHUNK_LEN`] particles.
#[derive(Default)]
struct Part {
    /// Particles that may meet some, where their lists begin, and at the end how many triangles there are.
    particles: Vec<u32>,
    starts: Vec<u32>,
    /// Colliders and triangles of theirs.
    triangles: Vec<[u32; 2]>,
    met: Vec<Meeting>,
}

/// A particle that met a collider.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    pub particle: u32,
    pub collider: u32,
    /// Where it was held, in metres.
    pub place: Vec3,
    /// Its velocity after it, and by how much that has changed, in m/s.
    pub velocity: Vec3,
    pub change: Vec3,
    /// Whether this is the last one that it met.
    pub is_last: bool,
}

impl Sweep {
    /// Finds what particles at places may meet that go no farther than `reach`. Some may be skipped; an empty list skips none.
    pub fn find(&mut self, context: &Context, colliders: &[Collider], places: &[Vec4], reach: f32, skipped: &[bool]) {
        self.parts.resize_with(if colliders.is_empty() { 0 } else { places.len().div_ceil(CHUNK_LEN) }, Part::default);
        context.for_each_mut(&mut self.parts, |part, lists| {
            lists.particles.clear();
            lists.triangles.clear();
            lists.starts.clear();
            lists.starts.push(0);
            let mut found = Vec::new();
            for (number, place) in (0u32..).zip(&places[part * CHUNK_LEN..places.len().min((part + 1) * CHUNK_LEN)]) {
                if skipped.get(part * CHUNK_LEN + number as usize).is_some_and(|skipped| *skipped) {
                    continue;
                }
                let around = Bounds { low: (place.xyz() - reach).into(), high: (place.xyz() + reach).into() };
                for (at, collider) in (0u32..).zip(colliders) {
                    collider.hierarchy.overlap(&around, &mut found);
                    lists.triangles.extend(found.iter().map(|triangle| [at, *triangle]));
                }
                if lists.triangles.len() > *lists.starts.last().unwrap_or(&0) as usize {
                    lists.particles.push(number);
                    lists.starts.push(lists.triangles.len() as u32);
                }
            }
        });
    }

    /// Holds particles before what they meet on the way from places to `ends`, none of which is then farther than the
    /// spacing if it does not move with a collider.
    pub fn hold(&mut self, context: &Context, colliders: &[Collider], places: &[Vec4], ends: &mut [Vec4], step: Step) {
        let mut parts: Vec<_> = self.parts.iter_mut().zip(ends.chunks_mut(CHUNK_LEN)).collect();
        context.for_each_mut(&mut parts, |part, (lists, ends)| {
            lists.met.clear();
            for (at, particle) in lists.particles.iter().enumerate() {
                let triangles = &lists.triangles[lists.starts[at] as usize..lists.starts[at + 1] as usize];
                let (number, end) = (part * CHUNK_LEN + *particle as usize, &mut ends[*particle as usize]);
                let path = [places[number].xyz(), end.xyz()];
                if let Some(held) = hold_one(colliders, triangles, number as u32, path, step, &mut lists.met) {
                    *end = held.extend(end.w);
                }
            }
        });
    }

    /// What was met when particles were held last, in their order.
    pub fn met(&self) -> impl Iterator<Item = &Meeting> {
        self.parts.iter().flat_map(|part| &part.met)
    }
}

/// How a step is made.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub seconds: f32,
    pub spacing: f32,
}

/// Holds one particle, and returns where it ends if it met something.
fn hold_one(
    colliders: &[Collider],
    triangles: &[[u32; 2]],
    particle: u32,
    [from, end]: [Vec3; 2],
    step: Step,
    met: &mut Vec<Meeting>,
) -> Option<Vec3> {
    let seconds = f64::from(step.seconds);
    let free = (end - from).clamp_length_max(step.spacing).as_dvec3();
    let from = from.as_dvec3();
    let (mut end, mut velocity) = (from + free, free / seconds);
    let first = met.len();
    for meeting in 0..=MEETINGS {
        let hits = triangles.iter().filter_map(|[collider, triangle]| {
            let hit = Moving::new(&colliders[*collider as usize], *triangle, from, end - from, seconds).meet()?;
            Some((hit, *collider, *triangle))
        });
        let Some((hit, number, triangle)) = hits.reduce(|a, b| if b.0.time < a.0.time { b } else { a }) else { break };
        let collider = &colliders[number as usize];
        let corners = collider.triangles[triangle as usize].map(|corner| corner as usize);
        let mean = |values: &[Vec3]| -> DVec3 {
            corners.iter().zip(hit.weights).map(|(corner, weight)| weight * values[*corner].as_dvec3()).sum()
        };
        let surface = mean(&collider.paces);
        let relative = velocity - surface;
        let into = (-relative.dot(hit.normal)).max(0.0);
        let along = relative + into * hit.normal;
        let kept = match collider.options.contact {
            // What meets one triangle after the other is in a wedge between them.
            _ if meeting == MEETINGS => DVec3::ZERO,
            Contact::Stop => DVec3::ZERO,
            Contact::Slip => along,
            Contact::Friction(share) => along * (1.0 - f64::from(share) * into / along.length().max(1e-30)).max(0.0),
        };
        let touched = mean(&collider.points) + seconds * surface;
        let gap = GAP[0] * f64::from(step.spacing) + GAP[1] * touched.abs().max_element();
        end = touched + gap * hit.normal + (1.0 - hit.time) * seconds * kept;
        let after = surface + kept;
        met.push(Meeting {
            particle,
            collider: number,
            place: end.as_vec3(),
            velocity: after.as_vec3(),
            change: (after - velocity).as_vec3(),
            is_last: false,
        });
        velocity = after;
    }
    let last = met[first..].last_mut()?;
    last.is_last = true;
    Some(last.place)
}

/// A triangle as a particle sees it, that moves from the first corners to these and their motions in a time of 1.
struct Moving {
    corners: [DVec3; 3],
    motions: [DVec3; 3],
}

/// Where a particle meets a triangle.
struct Hit {
    /// In 0..=1 of the step.
    time: f64,
    weights: [f64; 3],
    /// Towards where the particle came from.
    normal: DVec3,
}

impl Moving {
    fn new(collider: &Collider, triangle: u32, from: DVec3, motion: DVec3, seconds: f64) -> Self {
        let corners = collider.triangles[triangle as usize].map(|corner| corner as usize);
        Self {
            corners: corners.map(|corner| collider.points[corner].as_dvec3() - from),
            motions: corners.map(|corner| seconds * collider.paces[corner].as_dvec3() - motion),
        }
    }

    fn at(&self, time: f64) -> [DVec3; 3] {
        [0, 1, 2].map(|corner| self.corners[corner] + time * self.motions[corner])
    }

    fn meet(&self) -> Option<Hit> {
        let ends = self.at(1.0);
        let (low, high) = self
            .corners
            .iter()
            .chain(&ends)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(*at), high.max(*at)));
        if low.max_element() > 0.0 || high.min_element() < 0.0 {
            return None;
        }
        let volume = |a: DVec3, b: DVec3, c: DVec3| a.dot(b.cross(c));
        let ([a, b, c], [u, v, w]) = (self.corners, self.motions);
        let terms = [
            volume(a, b, c),
            volume(u, b, c) + volume(a, v, c) + volume(a, b, w),
            volume(u, v, c) + volume(u, b, w) + volume(a, v, w),
            volume(u, v, w),
        ];
        let value = |time: f64| ((terms[3] * time + terms[2]) * time + terms[1]) * time + terms[0];
        let [first, second] = turns(terms);
        let mut start = 0.0;
        for stop in [first, second, 1.0].into_iter().filter(|turn| *turn > 0.0 && *turn <= 1.0) {
            let before = value(start);
            if before != 0.0 && before * value(stop) <= 0.0 {
                let (mut low, mut high) = (start, stop);
                for _ in 0..64 {
                    let middle = 0.5 * (low + high);
                    if before * value(middle) > 0.0 { low = middle } else { high = middle }
                }
                if let Some(hit) = self.within(high, before) {
                    return Some(hit);
                }
            }
            start = stop;
        }
        None
    }

    /// The hit at a time at which the particle is in the plane, if it is within the triangle.
    fn within(&self, time: f64, before: f64) -> Option<Hit> {
        let [a, b, c] = self.at(time);
        let normal = (b - a).cross(c - a);
        let square = normal.length_squared();
        let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|part| part.dot(normal) / square);
        // A triangle without an area has no weights that are numbers.
        let is_within = weights.iter().all(|weight| *weight >= -BEYOND);
        is_within.then(|| Hit { time, weights, normal: -before.signum() * normal / square.sqrt() })
    }
}

/// Where a polynomial of the third degree turns, in order, or twice 2 if it does not within 0..1.
fn turns(terms: [f64; 4]) -> [f64; 2] {
    let [a, b, c] = [3.0 * terms[3], 2.0 * terms[2], terms[1]];
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    // One of them is far away, or no number, where the degree is less.
    let [first, second] = [q / a, c / q].map(|turn| if turn > 0.0 && turn < 1.0 { turn } else { 2.0 });
    [first.min(second), first.max(second)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_particle_meets_a_triangle_where_it_is_swept_to_its_place(
            corners in prop::array::uniform3(prop::array::uniform3(-2.0f64..2.0)),
            motions in prop::array::uniform3(prop::array::uniform3(-0.5f64..0.5)),
            weights in prop::array::uniform3(0.05f64..1.0), time in 0.05f64..0.95,
            direction in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let corners = corners.map(DVec3::from);
            let sum: f64 = weights.iter().sum();
            let motions = motions.map(DVec3::from);
            let at = |time: f64| [0, 1, 2].map(|corner| corners[corner] + time * motions[corner]);
            let touched: DVec3 = at(time).iter().zip(weights).map(|(corner, weight)| *corner * (weight / sum)).sum();
            let normal = (at(time)[1] - at(time)[0]).cross(at(time)[2] - at(time)[0]);
            let motion = DVec3::from(direction);
            let speed: DVec3 = motions.iter().zip(weights).map(|(motion, weight)| *motion * (weight / sum)).sum();
            // It neither slides along nor meets one that is nearly none.
            prop_assume!(normal.length() > 0.3 && (motion - speed).dot(normal).abs() > 0.1);
            let from = touched - time * motion;
            let moving = Moving {
                corners: corners.map(|corner| corner - from),
                motions: motions.map(|corner| corner - motion),
            };
            let hit = moving.meet();
            prop_assert!(hit.is_some());
            let hit = hit.unwrap();
            // It may have met it before.
            prop_assert!(hit.time <= time + 1e-9);
            if (hit.time - time).abs() < 1e-9 {
                prop_assert!(hit.normal.dot(motion - speed) < 0.0);
                prop_assert!(hit.weights.iter().zip(weights).all(|(found, weight)| (found - weight / sum).abs() < 1e-6));
            }
        }
    }

    #[test]
    fn polynomials_of_any_degree_turn_where_their_slopes_are_none() {
        let near = |found: [f64; 2], expected: [f64; 2]| {
            assert!((0..2).all(|at| (found[at] - expected[at]).abs() < 1e-12), "{found:?} {expected:?}");
        };
        // The slope (t − 1/4) (t − 1/2), 2 t − 1, and others.
        near(turns([0.0, 0.125, -0.375, 1.0 / 3.0]), [0.25, 0.5]);
        near(turns([0.0, -1.0, 1.0, 0.0]), [0.5, 2.0]);
        near(turns([1.0, 1.0, 0.0, 0.0]), [2.0, 2.0]);
        near(turns([1.0, 0.0, 0.0, 0.0]), [2.0, 2.0]);
        near(turns([0.0, 0.0, 0.0, 1.0]), [2.0, 2.0]);
    }
}
