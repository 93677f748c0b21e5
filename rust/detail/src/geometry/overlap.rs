//! The overlap of a pair of boxes: a new oriented box that conservatively bounds their intersection, and its jitter
//! (Schäfer et al. 2014, Section 5, Overlap Regions, and Section 6, discretisation artefacts).

use glam::{DMat3, DVec3, EulerRot};

use crate::geometry::obb::Obb;

/// A box that holds everything that is in both boxes, `None` if nothing is.
///
/// The intersection is a convex body whose every vertex lies on an edge of one box clipped by the other, so the 24
/// clipped edges bound it exactly; the box takes the axes of whichever of the two bounds it in less volume.
pub fn overlap(a: &Obb, b: &Obb) -> Option<Obb> {
    if !a.overlaps(b) {
        return None;
    }
    // Boxes that merely touch still give a box, of no depth.
    let slack = 1e-12 * (a.half.max_element() + b.half.max_element());
    let mut vertices = Vertices { list: [DVec3::ZERO; 48], count: 0 };
    clipped_edges(a, b, slack, &mut vertices);
    clipped_edges(b, a, slack, &mut vertices);
    let vertices = &vertices.list[..vertices.count];
    if vertices.is_empty() {
        return None;
    }
    let bound = |axes: DMat3| {
        let inverse = axes.transpose();
        let (low, high) = vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), vertex| {
            let place = inverse * *vertex;
            (low.min(place), high.max(place))
        });
        Obb::from_interval(axes, low, high).enlarged(slack)
    };
    let (first, second) = (bound(a.axes), bound(b.axes));
    Some(if second.volume() < first.volume() { second } else { first })
}

/// Ends of edges of two boxes: two of each at most.
struct Vertices {
    list: [DVec3; 48],
    count: usize,
}

/// The ends of what the box `clip` leaves of the edges of `of`.
fn clipped_edges(of: &Obb, clip: &Obb, slack: f64, vertices: &mut Vertices) {
    let corners = of.corners();
    let inverse = clip.axes.transpose();
    let half = clip.half + DVec3::splat(slack);
    for start in 0..8usize {
        for bit in (0..3).filter(|bit| start >> bit & 1 == 0) {
            let (from, to) = (corners[start], corners[start | 1 << bit]);
            let (origin, direction) = (inverse * (from - clip.center), inverse * (to - from));
            let (mut enter, mut leave) = (0.0f64, 1.0f64);
            for axis in 0..3 {
                if direction[axis].abs() < 1e-300 {
                    if origin[axis].abs() > half[axis] {
                        leave = -1.0;
                    }
                    continue;
                }
                let near = (-half[axis] - origin[axis]) / direction[axis];
                let far = (half[axis] - origin[axis]) / direction[axis];
                enter = enter.max(near.min(far));
                leave = leave.min(near.max(far));
            }
            if enter <= leave {
                for share in [enter, leave] {
                    vertices.list[vertices.count] = from + (to - from) * share;
                    vertices.count += 1;
                }
            }
        }
    }
}

/// The box turned by three random angles of at most `angle` radians and enlarged so that it holds the one given. The
/// angles depend on `seed`, `frame` and `pair` alone.
pub fn jittered(obb: &Obb, angle: f64, seed: u32, frame: u64, pair: u32) -> Obb {
    if angle == 0.0 {
        return *obb;
    }
    let mut state = mix(u64::from(seed) << 32 | u64::from(pair)) ^ mix(frame ^ 0x6a09_e667_f3bc_c908);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        // 53 random bits, spread over -1..1.
        angle * ((mix(state) >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    };
    let turn = DMat3::from_euler(EulerRot::XYZ, next(), next(), next());
    obb.realigned(obb.axes * turn)
}

/// The finaliser of SplitMix64 (Steele et al. 2014, Fast Splittable Pseudorandom Number Generators).
fn mix(value: u64) -> u64 {
    let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ value >> 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn make(v: [f64; 9]) -> Obb {
        Obb {
            center: DVec3::new(v[0], v[1], v[2]),
            axes: DMat3::from_euler(EulerRot::XYZ, v[3] * 3.0, v[4] * 3.0, v[5] * 3.0),
            half: DVec3::new(v[6], v[7], v[8]),
        }
    }

    #[test]
    fn small_boxes_that_touch_have_an_overlap() {
        let mut touching = 0;
        for step in 0..500 {
            let angle = 0.013 * f64::from(step);
            let axes = DMat3::from_euler(EulerRot::XYZ, angle, 2.0 * angle, 3.0 * angle);
            let half = DVec3::new(1.0, 2.0, 3.0) * 1e-3;
            let a = Obb { center: DVec3::new(0.7, -0.4, 0.9), axes, half };
            let b = Obb { center: a.center + axes.x_axis * 2e-3, axes, half };
            touching += u32::from(a.overlaps(&b));
            assert_eq!(overlap(&a, &b).is_some(), a.overlaps(&b), "{step}");
        }
        assert!(touching > 100, "{touching}");
    }

    proptest! {
        #[test]
        fn the_overlap_holds_what_both_hold_and_no_more_than_either(
            a in prop::array::uniform9(0.0f64..2.0), b in prop::array::uniform9(0.0f64..2.0),
            places in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 50)
        ) {
            let (a, b) = (make(a), make(b));
            let both = overlap(&a, &b);
            for place in places {
                let point = a.center + a.axes * (a.half * DVec3::from(place));
                if b.contains(point, 0.0) {
                    prop_assert!(both.is_some_and(|both| both.contains(point, 1e-9)));
                }
            }
            if let Some(both) = both {
                prop_assert!(both.volume() <= a.volume().min(b.volume()) * (1.0 + 1e-6) + 1e-9);
                prop_assert!(overlap(&b, &a).is_some());
            }
        }

        #[test]
        fn a_jittered_box_holds_the_one_it_came_from(v in prop::array::uniform9(0.0f64..2.0), frame in 0u64..1000) {
            let obb = make(v);
            let angle = std::f64::consts::PI / 32.0;
            let turned = jittered(&obb, angle, 7, frame, 0);
            prop_assert!(obb.corners().iter().all(|corner| turned.contains(*corner, 1e-9)));
            prop_assert_eq!(turned, jittered(&obb, angle, 7, frame, 0));
        }
    }

    #[test]
    fn aligned_boxes_overlap_in_exactly_their_intersection() {
        let a = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::new(50.0, 1.0, 50.0) };
        let b = Obb { center: DVec3::new(3.0, 2.5, 0.0), axes: DMat3::IDENTITY, half: DVec3::splat(2.0) };
        let both = overlap(&a, &b).unwrap();
        assert!((both.center - DVec3::new(3.0, 0.75, 0.0)).length() < 1e-9);
        assert!((both.half - DVec3::new(2.0, 0.25, 2.0)).length() < 1e-9);
        assert_eq!(overlap(&a, &Obb { center: DVec3::new(0.0, 4.0, 0.0), ..b }), None);
    }

    #[test]
    fn frames_pairs_and_seeds_turn_differently_and_evenly() {
        let obb = Obb { center: DVec3::ZERO, axes: DMat3::IDENTITY, half: DVec3::ONE };
        let angle = 0.1;
        let angles: Vec<f64> =
            (0..2000).map(|frame| jittered(&obb, angle, 1, frame, 0).axes.to_euler(EulerRot::XYZ).0).collect();
        assert!(angles.iter().all(|found| found.abs() <= angle));
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        assert!(mean.abs() < 0.005, "{mean}");
        assert!(angles.iter().any(|found| *found > 0.09) && angles.iter().any(|found| *found < -0.09));
        assert_ne!(jittered(&obb, angle, 1, 1, 0), jittered(&obb, angle, 2, 1, 0));
        assert_ne!(jittered(&obb, angle, 1, 1, 0), jittered(&obb, angle, 1, 1, 1));
    }
}
