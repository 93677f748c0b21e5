//! Poses that agents share where the difference cannot be seen.
//!
//! An agent that is cut as a whole leaves a part of the error that may be seen: what its step does not use. Within that part it
//! is shown in a pose that others show too. Both errors together hold the budget of pixels, no triangle more is drawn, and fewer
//! poses are skinned.
//!
//! Linear blending moves a vertex by a mean of what its bones move it by, so two poses differ by at most what one of the bones
//! moves a corner of the box of its vertices by. A bound by bones costs little beside one by vertices.

use glam::Vec3;

use crate::build::norm::norm;
use crate::character::Character;
use crate::clip::{BoneMatrix, Clip, Pose};
use crate::weights::linear;

/// Levels of a clip at most.
const LEVELS: i32 = 10;
/// The largest difference of the coarsest level, as a share of the size of the model; each finer one has half of it.
const LARGEST: f32 = 0.25;
/// Poses that a pose is compared with at most: the last that were chosen.
const COMPARED: usize = 64;
/// Widens bounds by what single precision rounds.
const ROUNDING: f32 = 1.0001;

/// The poses that stand for those of a clip, by the difference that may be seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sharing {
    levels: Vec<SharedPoses>,
}

#[derive(Clone, Debug)]
struct SharedPoses {
    /// The largest difference of a pose from the one that is shown, in units of the model.
    error: f32,
    /// The pose that is shown for each pose.
    shown: Vec<u32>,
}

/// The boxes of the vertices of each bone at binding, and how far morph targets move vertices at most.
#[derive(Clone, Debug)]
pub(crate) struct BoneBoxes {
    boxes: Vec<Option<[Vec3; 2]>>,
    longest: Vec<f64>,
}

impl BoneBoxes {
    pub fn of(character: &Character) -> Self {
        let mut boxes: Vec<Option<[Vec3; 2]>> = vec![None; character.bones.len()];
        for (point, influence) in character.points.iter().zip(&character.influences) {
            let point = Vec3::from(*point);
            for (bone, _) in influence.bones.iter().zip(influence.weights).filter(|(_, weight)| *weight > 0.0) {
                if let Some(known) = boxes.get_mut(usize::from(*bone)) {
                    let [low, high] = known.unwrap_or([point; 2]);
                    *known = Some([low.min(point), high.max(point)]);
                }
            }
        }
        Self { boxes, longest: character.morphs.extents() }
    }

    /// Returns a bound of how far two poses put a vertex apart.
    fn difference(&self, one: &Pose, other: &Pose) -> f32 {
        let weights = |pose: &Pose, at: usize| f64::from(pose.weights.get(at).copied().unwrap_or_default());
        let (mut reach, mut moved) = (0.0, 0.0);
        for (at, longest) in self.longest.iter().enumerate() {
            let [a, b] = [weights(one, at), weights(other, at)];
            reach += a.abs() * longest;
            moved += (a - b).abs() * longest;
        }
        let mut largest = 0.0f32;
        let mut stretch = 0.0f64;
        for ((a, b), bounds) in one.bones.iter().zip(&other.bones).zip(&self.boxes) {
            let Some([low, high]) = bounds else { continue };
            if !self.longest.is_empty() {
                stretch = stretch.max(norm(&linear(b)));
            }
            let pad = Vec3::splat(reach as f32);
            let change: BoneMatrix =
                std::array::from_fn(|row| std::array::from_fn(|column| a[row][column] - b[row][column]));
            largest = largest.max(moves(&change, *low - pad, *high + pad));
        }
        (largest + (stretch * moved) as f32) * ROUNDING
    }
}

/// Returns how far a map moves a corner of a box at most, from the origin.
fn moves(map: &BoneMatrix, low: Vec3, high: Vec3) -> f32 {
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    let row = |[x, y, z, w]: [f32; 4]| {
        (x * center.x + y * center.y + z * center.z + w).abs() + x.abs() * half.x + y.abs() * half.y + z.abs() * half.z
    };
    Vec3::from_array(map.map(row)).length()
}

impl Sharing {
    /// Finds the poses that stand for others in a clip of a model of this size. Each is one of the clip's.
    pub fn of(clip: &Clip, boxes: &BoneBoxes, size: f32) -> Self {
        let mut levels: Vec<SharedPoses> = Vec::new();
        for level in (0..LEVELS).rev() {
            let allowed = size * LARGEST * 0.5f32.powi(level);
            let (mut chosen, mut error): (Vec<u32>, f32) = (Vec::new(), 0.0);
            let shown: Vec<u32> = (0..clip.poses.len() as u32)
                .map(|pose| {
                    let difference = |other: u32| {
                        let of = |pose: u32| &clip.poses[pose as usize];
                        (boxes.difference(of(pose), of(other)), other)
                    };
                    let late = chosen.iter().rev().take(COMPARED).map(|other| difference(*other));
                    match late.filter(|(found, _)| *found <= allowed).min_by(|a, b| a.0.total_cmp(&b.0)) {
                        Some((found, other)) => {
                            error = error.max(found);
                            other
                        }
                        None => {
                            chosen.push(pose);
                            pose
                        }
                    }
                })
                .collect();
            let before = levels.last().map_or(clip.poses.len(), |last| count(&last.shown));
            if chosen.len() < before {
                while levels.last().is_some_and(|finer| finer.error >= error) {
                    levels.pop();
                }
                levels.push(SharedPoses { error, shown });
            }
        }
        Self { levels }
    }

    /// Returns the level whose poses differ by at most `room` from those of the clip; 0 has those of the clip.
    pub fn level(&self, room: f32) -> u8 {
        self.levels.partition_point(|level| level.error <= room) as u8
    }

    /// Returns the pose that is shown for one of the clip.
    pub fn shown(&self, level: u8, pose: u32) -> u32 {
        let level = usize::from(level).min(self.levels.len());
        let found = level.checked_sub(1).map(|at| &self.levels[at].shown);
        found.and_then(|shown| shown.get(pose as usize)).copied().unwrap_or(pose)
    }
}

/// Returns how many poses a list shows.
fn count(shown: &[u32]) -> usize {
    (0..).zip(shown).filter(|(pose, shown)| pose == *shown).count()
}
