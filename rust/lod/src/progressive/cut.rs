//! Which splits make a mesh.

use super::hierarchy::Progressive;
use super::recording::Key;

/// A mesh of a progressive mesh: the splits above a key, and of those at the key the ones of a greater number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cut {
    key: Key,
    split: u32,
}

impl Cut {
    /// No split at all.
    pub const BASE: Self = Self { key: Key(u32::MAX), split: u32::MAX };
    /// All splits.
    pub const FINEST: Self = Self { key: Key(0), split: u32::MAX };

    /// The coarsest mesh that deviates by at most `error`. Negative numbers are taken as 0.
    pub fn of_error(error: f32) -> Self {
        Self { key: Key::up_to(error.max(0.0)), split: u32::MAX }
    }

    /// The finest mesh of at most `faces` triangles, or the base mesh if that has more.
    pub fn of_faces(mesh: &Progressive, faces: usize) -> Self {
        let room = faces.saturating_sub(mesh.base_faces().len());
        let mut counts = vec![0usize; 1 << 16];
        mesh.splits().for_each(|(_, key, made)| counts[(key.0 >> 16) as usize] += made);
        let mut sum = 0;
        let Some(bin) = (0..counts.len()).rev().find(|bin| {
            sum += counts[*bin];
            sum > room
        }) else {
            return Self::FINEST;
        };
        let mut left = room - (sum - counts[bin]);
        let mut last: Vec<_> = mesh.splits().filter(|(_, key, _)| (key.0 >> 16) as usize == bin).collect();
        last.sort_unstable_by_key(|(split, key, _)| std::cmp::Reverse((*key, *split)));
        let cut = last.into_iter().find(|(_, _, made)| {
            let fits = *made <= left;
            left = left.saturating_sub(*made);
            !fits
        });
        cut.map_or(Self::FINEST, |(split, key, _)| Self { key, split })
    }

    /// The key, and the split at it, as numbers.
    pub(super) fn parts(self) -> (u32, u32) {
        (self.key.0, self.split)
    }

    /// Whether a split is one of those that make the mesh.
    #[inline(always)]
    pub fn has(self, key: Key, split: u32) -> bool {
        (key, split) > (self.key, self.split)
    }
}
