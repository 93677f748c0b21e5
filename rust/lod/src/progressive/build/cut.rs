//! Which splits make a mesh.

use std::sync::Arc;

use super::hierarchy::{Child, Progressive};
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

    /// The finest mesh of at most `faces` triangles, or the base mesh if that has more. All splits are looked at the first
    /// time and for meshes that have about all, else those of that mesh.
    pub fn of_faces(mesh: &Progressive, faces: usize) -> Self {
        let room = faces.saturating_sub(mesh.base_faces().len());
        let sums = mesh.triangle_sums();
        let at = sums.partition_point(|(_, sum)| *sum <= room);
        let Some((error, sum)) = sums.get(at) else { return Self::FINEST };
        let mut left = room - at.checked_sub(1).map_or(0, |before| sums[before].1);
        // In the order of memory splits take half as long as in that of their tree.
        let mut last = if 2 * sum > mesh.triangle_count() {
            let deviating = mesh.splits().filter(|(_, key, _)| key.0 >> 16 == *error);
            deviating.map(|(split, key, _)| (key, split)).collect()
        } else {
            mesh.splits_deviating(*error)
        };
        last.sort_unstable_by_key(|split| std::cmp::Reverse(*split));
        let cut = last.into_iter().find(|(_, split)| {
            let made = mesh.triangles_made(*split);
            let fits = made <= left;
            left = left.saturating_sub(made);
            !fits
        });
        cut.map_or(Self::FINEST, |(key, split)| Self { key, split })
    }

    /// How many triangles the mesh has at least and at most, which differ by the splits that deviate as much as the first it
    /// has not. All splits are looked at the first time.
    pub(crate) fn triangles_about(self, mesh: &Progressive) -> [usize; 2] {
        let error = self.key.0 >> 16;
        let first_not = if self.key.depth() + 1 == Key::DEPTHS { error + 1 } else { error };
        let sums = mesh.triangle_sums();
        [error + 1, first_not].map(|least| {
            let count = sums.partition_point(|(error, _)| *error >= least);
            mesh.base_faces().len() + count.checked_sub(1).map_or(0, |last| sums[last].1)
        })
    }

    /// The key, and the split at it, as numbers.
    pub(crate) fn parts(self) -> (u32, u32) {
        (self.key.0, self.split)
    }

    /// The cut of what [`Self::parts`] tells.
    pub(crate) fn of_parts((key, split): (u32, u32)) -> Self {
        Self { key: Key(key), split }
    }

    /// Whether a split is one of the splits that make the mesh.
    #[inline(always)]
    pub fn has(self, key: Key, split: u32) -> bool {
        (key, split) > (self.key, self.split)
    }
}

/// Which splits a mesh has: those of a cut, or what a view wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Front {
    /// Those of a cut.
    Cut(Cut),
    /// Those of a mesh that was made for a view.
    View(ViewSplits),
}

/// The splits and base vertices of a mesh that was made for a view, a bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewSplits(pub(crate) Arc<[u64]>);

impl Front {
    /// Whether a split is one of the splits that make the mesh.
    #[inline(always)]
    pub(crate) fn has(&self, key: Key, split: u32) -> bool {
        match self {
            Self::Cut(cut) => cut.has(key, split),
            // That of another mesh may have fewer.
            Self::View(made) => made.0.get(split as usize / 64).is_some_and(|word| word >> (split % 64) & 1 == 1),
        }
    }
}

impl Progressive {
    /// Takes note that splits were read up to `last`, and so many are not yet.
    pub(crate) fn set_floor(&mut self, last: (Key, u32), left: usize) {
        let (key, split) = last;
        self.floor = if left == 0 { Cut::FINEST } else { Cut { key, split: split.saturating_sub(1) } };
        self.triangle_sums.take();
    }

    /// Of every deviation that splits have, as keys tell it, from the greatest on: how many triangles those splits make that
    /// deviate as much or more.
    fn triangle_sums(&self) -> &[(u32, usize)] {
        self.triangle_sums.get_or_init(|| {
            let mut counts = vec![0usize; 1 << 16];
            self.splits().for_each(|(_, key, made)| counts[(key.0 >> 16) as usize] += made);
            let mut sum = 0;
            let counts = counts.into_iter().enumerate().rev().filter(|(_, count)| *count > 0);
            let sums = counts.map(|(error, count)| {
                sum += count;
                (error as u32, sum)
            });
            sums.collect()
        })
    }

    /// Splits of one deviation, as keys tell it: found from the base, since none deviates more than the one it comes from.
    fn splits_deviating(&self, error: u32) -> Vec<(Key, u32)> {
        let mut found = Vec::new();
        let mut waiting: Vec<Child> = self.base_vertices().iter().map(|leaf| self.child(2 * leaf)).collect();
        while let Some(child) = waiting.pop() {
            let Child::Split(split) = child else { continue };
            let key = self.splits[split as usize].key;
            if key.depth() == 0 || key.0 >> 16 < error {
                continue;
            }
            if key.0 >> 16 == error {
                found.push((key, split));
            }
            waiting.extend([2 * split, 2 * split + 1].map(|node| self.child(node)));
        }
        found
    }
}
