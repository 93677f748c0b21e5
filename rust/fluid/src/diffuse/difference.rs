//! Positions and velocities of frames of files: velocities are those of the file or, where it has none, come from the places
//! of the same particles in the frame before.

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Error, Result};
use relievo_particleio::Particles;

/// Returns the positions and velocities of the particles that are in both of two frames, `seconds` apart, in the order
/// of the second.
///
/// # Errors
/// Fails if one of the frames has no numbers.
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

/// Returns the positions and velocities of a frame: those of the file, or as [`differences`] does to the frame
/// `seconds` before.
///
/// # Errors
/// Fails if the frame has no velocities, and one of the frames no numbers.
pub fn positions_and_velocities(before: &Particles, after: &Particles, seconds: f32) -> Result<(Vec<Vec3>, Vec<Vec3>)> {
    match after.velocities() {
        Some(velocities) => {
            let vectors = |list: &[[f32; 3]]| list.iter().map(|vector| Vec3::from(*vector)).collect();
            Ok((vectors(&after.points), vectors(velocities)))
        }
        None => differences(before, after, seconds),
    }
}
