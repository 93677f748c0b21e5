//! Places on triangles that are about a spacing apart, for the particles of walls.
//!
//! Candidates are taken in a fixed order, corners first, then edges, then what is within, and those are kept that are not too
//! near to one before. So the result depends on the mesh alone, and no place of it is without one near.

use std::collections::HashMap;

use glam::{IVec3, Vec3};
use relievo_core::{Error, Result};

/// The least distance between places, in spacings: a little less than one, since they lie in no lattice.
const MIN: f32 = 0.9;
/// Candidates of a spacing.
const FINE: f32 = 3.0;
/// Candidates at most.
const MAX: f64 = (1u32 << 26) as f64;

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    pub triangle: u32,
    /// The weights of its second and third corner.
    pub weights: [f32; 2],
}

impl Sample {
    /// Where it is, or what it has of what is known at the corners.
    #[inline]
    pub fn of(&self, values: &[Vec3], triangles: &[[u32; 3]]) -> Vec3 {
        let [a, b, c] = triangles[self.triangle as usize].map(|corner| values[corner as usize]);
        let [v, w] = self.weights;
        (1.0 - v - w) * a + v * b + w * c
    }
}

/// Samples triangles of points. Fails if they are too large for the spacing.
pub fn sample(points: &[Vec3], triangles: &[[u32; 3]], spacing: f32) -> Result<Vec<Sample>> {
    let step = spacing / FINE;
    let parts = |length: f32| f64::from((length / step).ceil().max(1.0));
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| points[corner as usize]);
    let count: f64 = triangles
        .iter()
        .map(|triangle| {
            let (longest, height) = size(corners(triangle));
            3.0 * parts(longest) + parts(longest) * parts(height)
        })
        .sum();
    // What is not a number is refused too.
    if !matches!(count.partial_cmp(&MAX), Some(std::cmp::Ordering::Less)) {
        return Err(Error::memory("a mesh is too large to be covered by particles of the fluid's spacing")
            .advise("take a larger spacing or a smaller mesh"));
    }
    let mut kept = Kept { near: HashMap::new(), places: Vec::new(), samples: Vec::new(), least: MIN * spacing };
    let numbered = || (0u32..).zip(triangles.iter().map(corners));
    for (triangle, at) in numbered() {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().for_each(|weights| kept.offer(triangle, at, weights));
    }
    for (triangle, at) in numbered() {
        for side in 0..3 {
            let count = parts(at[side].distance(at[(side + 1) % 3])) as u32;
            for part in 1..count {
                let share = part as f32 / count as f32;
                let weights = match side {
                    0 => [share, 0.0],
                    1 => [1.0 - share, share],
                    _ => [0.0, 1.0 - share],
                };
                kept.offer(triangle, at, weights);
            }
        }
    }
    for (triangle, at) in numbered() {
        let (longest, height) = size(at);
        let rows = parts(height) as u32;
        for row in 1..rows {
            let up = row as f32 / rows as f32;
            let count = parts((1.0 - up) * longest) as u32;
            (1..count).for_each(|part| {
                kept.offer(triangle, at, turned(at, [(1.0 - up) * part as f32 / count as f32, up]));
            });
        }
    }
    Ok(kept.samples)
}

/// The longest side of a triangle, and how high it stands on it.
fn size(at: [Vec3; 3]) -> (f32, f32) {
    let longest = at[longest(at)].distance(at[(longest(at) + 1) % 3]);
    let double = (at[1] - at[0]).cross(at[2] - at[0]).length();
    (longest, if longest > 0.0 { double / longest } else { 0.0 })
}

/// The corner at which the longest side begins.
fn longest(at: [Vec3; 3]) -> usize {
    let lengths = [0, 1, 2].map(|side| at[side].distance_squared(at[(side + 1) % 3]));
    (0..3).fold(0, |best, side| if lengths[side] > lengths[best] { side } else { best })
}

/// Weights along the longest side and up from it, as those of the second and third corner.
fn turned(at: [Vec3; 3], [along, up]: [f32; 2]) -> [f32; 2] {
    let mut weights = [0.0; 3];
    let first = longest(at);
    weights[first] = 1.0 - along - up;
    weights[(first + 1) % 3] = along;
    weights[(first + 2) % 3] = up;
    [weights[1], weights[2]]
}

/// What was kept, and where.
struct Kept {
    near: HashMap<IVec3, Vec<u32>>,
    places: Vec<Vec3>,
    samples: Vec<Sample>,
    least: f32,
}

impl Kept {
    fn offer(&mut self, triangle: u32, [a, b, c]: [Vec3; 3], [v, w]: [f32; 2]) {
        let place = (1.0 - v - w) * a + v * b + w * c;
        let cell = (place / self.least).floor().as_ivec3();
        let is_taken = |cell: IVec3| {
            self.near.get(&cell).is_some_and(|others| {
                others
                    .iter()
                    .any(|other| self.places[*other as usize].distance_squared(place) < self.least * self.least)
            })
        };
        // Its own cell first, where most candidates have one that is too near.
        let axis = |number: i32| [0, -1, 1][number as usize % 3];
        let mut around = (0..27).map(|number| [axis(number), axis(number / 3), axis(number / 9)]);
        if !around.any(|offset| is_taken(cell.saturating_add(IVec3::from(offset)))) {
            self.near.entry(cell).or_default().push(self.places.len() as u32);
            self.places.push(place);
            self.samples.push(Sample { triangle, weights: [v, w] });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_of_a_mesh_is_without_a_sample_near() {
        // A long triangle and a small one on one of its sides.
        let points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.1], [2.0, 1.1, 0.0], [2.6, 0.5, 0.6]].map(Vec3::from);
        let triangles = [[0, 1, 2], [1, 2, 3]];
        let samples = sample(&points, &triangles, 0.2).unwrap();
        let places: Vec<Vec3> = samples.iter().map(|sample| sample.of(&points, &triangles)).collect();
        for (at, place) in places.iter().enumerate() {
            assert!(places[..at].iter().all(|other| other.distance(*place) >= 0.9 * 0.2));
        }
        for number in 0..2000 {
            let [v, w] = [number % 45, number / 45].map(|at| at as f32 / 44.0);
            if v + w <= 1.0 {
                let place = Sample { triangle: number % 2, weights: [v, w] }.of(&points, &triangles);
                assert!(places.iter().any(|other| other.distance(place) < 1.2 * 0.2), "{place}");
            }
        }
    }

    #[test]
    fn no_place_of_a_side_is_further_than_half_the_spacing_from_a_sample() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.866, 0.0]].map(Vec3::from);
        let samples = sample(&points, &[[0, 1, 2]], 0.2).unwrap();
        let places: Vec<Vec3> = samples.iter().map(|sample| sample.of(&points, &[[0, 1, 2]])).collect();
        for (side, part) in (0..3).flat_map(|side| (0..=100).map(move |part| (side, part as f32 / 100.0))) {
            let place = points[side].lerp(points[(side + 1) % 3], part);
            assert!(places.iter().any(|other| other.distance(place) < 0.51 * 0.2), "{side} {part}");
        }
    }

    #[test]
    fn triangles_that_are_too_large_or_nothing_are_no_trouble() {
        let points = [Vec3::ZERO, Vec3::X * 1e6, Vec3::Y * 1e6, Vec3::X * 1e6];
        assert!(sample(&points, &[[0, 1, 2]], 0.01).is_err());
        assert!(sample(&[Vec3::ZERO, Vec3::X * 1e38, Vec3::Y * 1e38], &[[0, 1, 2]], 0.01).is_err());
        assert_eq!(sample(&points, &[[0, 0, 0]], 0.01).unwrap().len(), 1);
    }
}
