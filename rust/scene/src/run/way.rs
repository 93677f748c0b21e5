//! The way of the objects of a scene through a frame, and the pairs of them that press.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use relievo_core::{Context, Result};
use relievo_detail::ImprintSettings;

use crate::format::description::ToolEntry;
use crate::state::world::World;

/// Radians a collider may turn in a part of a frame that is taken as one even motion.
const EVEN_TURN: f64 = 1.0;

/// A collider at work: who presses into whom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub by: usize,
    pub into: usize,
    pub number: u32,
    pub settings: ImprintSettings,
    pub tool: Option<ToolEntry>,
}

/// How a collider presses in each of the `parts` of its way.
pub(crate) fn settings_of(pair: &Pair, parts: u32) -> ImprintSettings {
    part_of(&pair.settings, parts)
}

/// As [`settings_of`], from the settings for the whole way.
pub(crate) fn part_of(whole: &ImprintSettings, parts: u32) -> ImprintSettings {
    let mut settings = *whole;
    // The limit holds for a sweep; what a frame's sweeps do adds up.
    if settings.depth_limit < ImprintSettings::default().depth_limit {
        settings.depth_limit /= parts as f32;
    }
    settings
}

/// The way of all objects through a frame.
pub(crate) struct Way<'a> {
    /// Their transforms at even times.
    pub path: &'a [Vec<DAffine3>],
    pub before: f64,
    pub now: f64,
    pub frame: u32,
}

impl Way<'_> {
    /// The time after a `share` of the way, seconds.
    pub fn time(&self, share: f64) -> f64 {
        self.before + (self.now - self.before) * share
    }

    /// The points of `object` after two shares of the way, where they move.
    ///
    /// # Errors
    /// A file of the mesh cannot be read.
    pub fn points(
        &self,
        context: &Context,
        world: &mut World,
        object: usize,
        shares: [f64; 2],
    ) -> Result<[Option<Arc<[[f32; 3]]>>; 2]> {
        let [from, to] = shares.map(|share| world.moving_points(context, object, self.time(share)));
        Ok([from?.map(Into::into), to?.map(Into::into)])
    }

    /// Where `object` is after a `share` of the way.
    pub fn at(&self, object: usize, share: f64) -> DAffine3 {
        let place = share * (self.path.len() - 1) as f64;
        let before = (place.floor() as usize).min(self.path.len() - 1);
        let after = (before + 1).min(self.path.len() - 1);
        let share = place - before as f64;
        let (a, b) = (self.path[before][object], self.path[after][object]);
        if share <= 0.0 || a == b {
            return a;
        }
        let [(turn_a, stretch_a), (turn_b, stretch_b)] = [turn_and_stretch(&a), turn_and_stretch(&b)];
        let turn = DMat3::from_quat(turn_a.slerp(turn_b, share));
        DAffine3 {
            matrix3: turn * (stretch_a * (1.0 - share) + stretch_b * share),
            translation: a.translation.lerp(b.translation, share),
        }
    }

    /// The even times that the way is known at.
    pub fn steps(&self) -> u32 {
        (self.path.len() as u32 - 1).max(1)
    }

    /// Whether `object` is not where it was all the time.
    pub fn moves(&self, object: usize) -> bool {
        self.path.windows(2).any(|pose| pose[0][object] != pose[1][object])
    }

    /// Parts of the way in which the two objects turn so little that they may be taken as turning evenly.
    pub fn parts(&self, pair: &Pair) -> u32 {
        let turn = |pose: &[Vec<DAffine3>], object: usize| {
            let [a, b] = [0, 1].map(|at| turn_and_stretch(&pose[at][object]).0);
            a.angle_between(b)
        };
        let angle: f64 = self.path.windows(2).map(|pose| turn(pose, pair.by) + turn(pose, pair.into)).sum();
        ((angle / EVEN_TURN).ceil() as u32).clamp(1, self.steps())
    }
}

/// A transform as a rotation and what comes before it: scale and shear, with zeros below the diagonal.
fn turn_and_stretch(transform: &DAffine3) -> (DQuat, DMat3) {
    let matrix = transform.matrix3;
    // Gram and Schmidt; a mirroring goes along x.
    let x = matrix.x_axis.normalize_or(DVec3::X) * matrix.determinant().signum();
    let y = matrix.y_axis.reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
    let turn = DMat3::from_cols(x, y, x.cross(y));
    (DQuat::from_mat3(&turn), turn.transpose() * matrix)
}
