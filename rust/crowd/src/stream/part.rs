//! A model of which some clusters are in memory, and coarser cuts of it.

use std::path::Path;

use relievo_core::{Context, Result};

use crate::file::Reader;
use crate::hierarchy::{Cluster, NONE};
use crate::ladder::Ladder;

/// A model of a stream.
#[derive(Debug)]
pub(super) struct Part {
    pub reader: Reader,
    /// The clusters that each group simplifies, and the clusters that it makes.
    below: Vec<Vec<u32>>,
    above: Vec<Vec<u32>>,
    /// The slot of each cluster that is in memory.
    pub slots: Vec<Option<u32>>,
    /// The last frame that draws each cluster, or reads it.
    pub used: Vec<u64>,
    /// The error of the cut that is being read over several frames.
    pending: Option<f32>,
}

/// A cut in place of a finer one.
#[derive(Clone, Debug)]
pub(super) struct Coarser {
    /// The step of the model's ladder whose error it may have; their number for the coarsest clusters.
    pub step: u32,
    pub clusters: Vec<u32>,
}

impl Part {
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        let reader = Reader::open(context, path)?;
        let clusters = &reader.model().clusters;
        let groups = reader.model().groups.len();
        let (mut below, mut above) = (vec![Vec::new(); groups], vec![Vec::new(); groups]);
        for (cluster, number) in clusters.iter().zip(0u32..) {
            if let Some(list) = below.get_mut(cluster.used_by as usize) {
                list.push(number);
            }
            if let Some(list) = above.get_mut(cluster.made_by as usize) {
                list.push(number);
            }
        }
        let (slots, used) = (vec![None; clusters.len()], vec![0; clusters.len()]);
        Ok(Self { reader, below, above, slots, used, pending: None })
    }

    pub fn clusters(&self) -> &[Cluster] {
        &self.reader.model().clusters
    }

    /// Returns the coarsest clusters.
    pub fn roots(&self) -> impl Iterator<Item = u32> + '_ {
        self.clusters().iter().zip(0..).filter(|(cluster, _)| cluster.used_by == NONE).map(|(_, number)| number)
    }

    /// Returns the clusters of a cut that are not in memory.
    pub fn missing<'a>(&'a self, cut: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
        cut.iter().copied().filter(|cluster| self.slots[*cluster as usize].is_none())
    }

    /// Notes that a frame draws those of some clusters that are in memory.
    pub fn mark(&mut self, clusters: &[u32], frame: u64) {
        for cluster in clusters {
            if self.slots[*cluster as usize].is_some() {
                self.used[*cluster as usize] = frame;
            }
        }
    }

    /// Returns the finest cut that is no finer than `cut` and lets every group be coarse whose error is at most `error`.
    pub fn coarsened(&self, cut: &[u32], error: f32) -> Vec<u32> {
        let clusters = self.clusters();
        let groups = &self.reader.model().groups;
        let made_by = |cluster: u32| clusters[cluster as usize].made_by;
        let used_by = |cluster: u32| clusters[cluster as usize].used_by;
        let leaves = |cluster: &u32| groups.get(used_by(*cluster) as usize).is_some_and(|group| group.error <= error);
        // Groups that are coarse in the cut, of which some clusters may be used by groups that are coarse too.
        let mut is_coarse = vec![false; groups.len()];
        let mut waiting: Vec<u32> = cut.iter().copied().map(made_by).collect();
        while let Some(group) = waiting.pop() {
            let at = group as usize;
            if group != NONE && !std::mem::replace(&mut is_coarse[at], true) {
                waiting.extend(self.below[at].iter().copied().map(made_by));
            }
        }
        let mut new = Vec::new();
        let mut waiting: Vec<u32> = cut.iter().copied().filter(leaves).map(used_by).collect();
        while let Some(group) = waiting.pop() {
            let at = group as usize;
            if group != NONE && !std::mem::replace(&mut is_coarse[at], true) {
                new.push(at);
                // Groups below a coarse one are coarse too.
                waiting.extend(self.below[at].iter().copied().map(made_by));
                waiting.extend(self.above[at].iter().copied().filter(leaves).map(used_by));
            }
        }
        let is_drawn = |cluster: &u32| !is_coarse.get(used_by(*cluster) as usize).is_some_and(|is_coarse| *is_coarse);
        let above = new.iter().flat_map(|group| &self.above[*group]);
        let mut made: Vec<u32> = cut.iter().chain(above).copied().filter(is_drawn).collect();
        made.sort_unstable();
        made.dedup();
        made
    }

    /// Returns the finest cut, no finer than `cut`, of which at most `most` clusters are missing. The coarsest clusters are always
    /// in memory, so that there is one.
    pub fn finest(&self, ladder: &Ladder, cut: &[u32], most: usize) -> Coarser {
        let of = |step: u32| Coarser { step, clusters: self.coarsened(cut, ladder.error(step)) };
        let steps = 0..ladder.len() as u32;
        let found = steps.map(of).find(|coarser| self.missing(&coarser.clusters).count() <= most);
        found.unwrap_or_else(|| Coarser { step: ladder.len() as u32, clusters: self.roots().collect() })
    }

    /// Returns the cut to read next where `fallback` is drawn in place of `target`: the target if so many reads suffice; otherwise the
    /// finest cut of which at most twice as many clusters are missing as are drawn now, so that what is drawn grows by a factor from
    /// one to the next. An unfinished cut of frames before comes first, if there is `room`.
    pub fn goal(
        &mut self,
        ladder: &Ladder,
        target: &[u32],
        fallback: &Coarser,
        (reads, room): (usize, usize),
    ) -> Vec<u32> {
        let missing = |cut: &[u32]| self.missing(cut).count();
        if missing(target) <= reads.min(room) {
            return target.to_vec();
        }
        if let Some(error) = self.pending.filter(|error| *error < ladder.error(fallback.step)) {
            let cut = self.coarsened(target, error);
            if (1..=room).contains(&missing(&cut)) {
                return cut;
            }
        }
        let most = reads.max(2 * fallback.clusters.len()).min(room);
        let found = self.finest(ladder, target, most);
        let step = found.step.min(fallback.step.saturating_sub(1));
        let error = ladder.error(step);
        self.pending = Some(error);
        self.coarsened(target, error)
    }

    /// Returns how late a cluster is read and how soon it leaves memory among clusters that are used alike: by the error of the
    /// group that it is simplified in. The bits of errors, which are 0 or more, have their order.
    pub fn rank(&self, cluster: u32) -> u32 {
        let group = self.clusters()[cluster as usize].used_by;
        self.reader.model().groups.get(group as usize).map_or(u32::MAX, |group| group.error.to_bits())
    }
}
