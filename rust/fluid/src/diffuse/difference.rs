//! Velocities of frames that have none, from the places of the same particles in the frame before.

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Error, Result};
use relievo_particleio::Particles;

/// Returns the positions and velocities of the particles that are in both of two frames, `seconds` apart, in the order of
/// the second. Fails if one of the frames has no numbers.
pub fn differences(before: &Particles, after: &Particles, seconds: f32) -> Result<(Vec<Vec3>, Vec<Vec3>)> {
    let (Some(old), Some(new)) = (&before.numbers, &after.numbers) else {
        return Err(Error::invalid("the frame has neither velocities nor numbers of its particles")
            .advise("write the frames with a channel `velocity`, or with numbers"));
    };
    let places: HashMap<u32, [f32; 3]> = old.iter().copied().zip(before.points.iter().copied()).collect();
    let both =
        new.iter().zip(&after.points).filter_map(|(number, point)| Some((Vec3::from(*point), places.get(number)?)));
    Ok(both.map(|(point, from)| (point, (point - Vec3::from(*from)) / seconds)).unzip())
}
