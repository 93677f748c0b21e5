//! Placements between keyframes: translation, angles, scale and shear each change evenly, so that a wheel may turn many times
//! between two keyframes.

use crate::format::description::Keyframe;
use crate::format::placement::Placement;

/// Where a body with `keys`, in order of time, is at `time` seconds; before the first and after the last it rests.
/// `None` without keys.
pub fn placement_at(keys: &[Keyframe], time: f64) -> Option<Placement> {
    let after = keys.partition_point(|key| key.time <= time);
    let (Some(before), Some(next)) = (after.checked_sub(1).and_then(|at| keys.get(at)), keys.get(after)) else {
        return keys.get(after).or(keys.last()).map(|key| key.placement);
    };
    let share = (time - before.time) / (next.time - before.time);
    let (a, b) = (before.placement, next.placement);
    Some(Placement {
        translation: a.translation.lerp(b.translation, share),
        rotation: a.rotation.lerp(b.rotation, share),
        scale: a.scale.lerp(b.scale, share),
        shear: a.shear.lerp(b.shear, share),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn placements_change_evenly_and_rest_outside() {
        let place = |x: f64| Placement {
            translation: DVec3::X * x,
            rotation: DVec3::Y * x * 10.0,
            scale: DVec3::splat(1.0 + x),
            shear: DVec3::Z * x,
        };
        let keys = [Keyframe { time: 1.0, placement: place(0.0) }, Keyframe { time: 3.0, placement: place(2.0) }];
        for (time, x) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.5), (3.0, 2.0), (9.0, 2.0)] {
            assert_eq!(placement_at(&keys, time), Some(place(x)), "at {time}");
        }
        assert_eq!(placement_at(&[], 1.0), None);
    }

    #[test]
    fn a_sheared_placement_takes_x_along_with_y() {
        let placement = Placement {
            translation: DVec3::Z,
            rotation: DVec3::ZERO,
            scale: DVec3::new(1.0, 2.0, 3.0),
            shear: DVec3::new(0.5, 0.25, 0.0),
        };
        let point = placement.transform().transform_point3(DVec3::new(1.0, 1.0, 1.0));
        assert_eq!(point, DVec3::new(1.0 + 0.5 * 2.0 + 0.25 * 3.0, 2.0, 4.0));
    }
}
