//! Full turns of the faces around a vertex of a map.
//!
//! Faces that are not flipped may still go around a vertex twice: the map is not injective there. A full turn crosses each
//! direction once, so that crossings of one direction count turns, by comparisons alone.

use crate::map::energy::Vec2;

/// Returns a vertex inside, as `is_inside` says, around which unflipped faces turn more than once, if there is one.
pub fn turned_twice(faces: &[[u32; 3]], positions: &[Vec2], is_inside: impl Fn(u32) -> bool) -> Option<u32> {
    let counts = turns(faces, positions);
    (0..).zip(counts).find_map(|(vertex, count)| (count > 1 && is_inside(vertex)).then_some(vertex))
}

/// Returns how many vertices inside have unflipped faces that turn around them more than once.
pub fn count_turned_twice(faces: &[[u32; 3]], positions: &[Vec2]) -> usize {
    // Around a vertex inside, each neighbour is the next one of a face and the last one of another.
    let mut open = vec![0_i64; positions.len()];
    for [a, b, c] in faces {
        for (here, next, last) in [(a, b, c), (b, c, a), (c, a, b)] {
            open[*here as usize] += i64::from(*next) - i64::from(*last);
        }
    }
    turns(faces, positions).into_iter().zip(open).filter(|(count, open)| *count > 1 && *open == 0).count()
}

/// How often the faces around each vertex cross the direction to the right, counter-clockwise.
fn turns(faces: &[[u32; 3]], positions: &[Vec2]) -> Vec<u8> {
    let mut counts = vec![0_u8; positions.len()];
    for face in faces {
        let heights = face.map(|vertex| positions[vertex as usize][1]);
        for corner in 0..3 {
            let [here, next, last] = [0, 1, 2].map(|step| heights[(corner + step) % 3]);
            let count = &mut counts[face[corner] as usize];
            *count = count.saturating_add(u8::from(next < here && last >= here));
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_that_goes_around_twice_is_found() {
        for count in 1..=3_u32 {
            let steps = 7 * count;
            // The first direction is the one that is counted.
            let place = |step: u32| (std::f64::consts::TAU * f64::from(step % 7) / 7.0).sin_cos();
            let around = (0..steps).map(|step| [place(step).1, place(step).0]);
            let positions: Vec<Vec2> = std::iter::once([0.0; 2]).chain(around).collect();
            let faces: Vec<[u32; 3]> = (0..steps).map(|step| [0, 1 + step, 1 + (step + 1) % steps]).collect();
            assert_eq!(turned_twice(&faces, &positions, |vertex| vertex == 0), (count > 1).then_some(0));
            assert_eq!(count_turned_twice(&faces, &positions), usize::from(count > 1));
            // Without one of its faces the fan is open, and its vertex lies on the boundary.
            assert_eq!(count_turned_twice(&faces[1..], &positions), 0);
        }
    }
}
