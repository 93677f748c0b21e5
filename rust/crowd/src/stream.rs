//! Models that are read cluster by cluster while they are drawn, within a budget of memory (Section 5).
//!
//! The coarsest clusters are always there. A cut asks for what it draws; what has not been read yet is drawn by the clusters
//! above it: their group is taken as coarse, and all groups below it are. So what is shown has no cracks either.

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use crate::file::Reader;
use crate::hierarchy::{CrowdModel, NONE};

/// Bytes of a triangle in memory: three vertices and a material.
const TRIANGLE: u64 = 16;

/// A cluster that was read.
#[derive(Clone, Debug)]
struct Resident {
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    /// The request that last asked for it.
    asked: u64,
}

/// A model of which some clusters are in memory.
#[derive(Debug)]
pub struct Stream {
    reader: Reader,
    budget: u64,
    bytes: u64,
    resident: Vec<Option<Resident>>,
    requests: u64,
    /// The clusters that each group simplifies, and the clusters that it makes.
    below: Vec<Vec<u32>>,
    above: Vec<Vec<u32>>,
}

/// What a request did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streamed {
    /// Clusters that were read.
    pub read: u32,
    /// Clusters that were removed from memory for them.
    pub dropped: u32,
    /// Clusters that are still missing.
    pub missing: u32,
}

impl Stream {
    /// Opens a file and reads its coarsest clusters. The triangles of clusters take at most `budget` bytes of memory;
    /// vertices, poses and the hierarchy, which the memory limit of the context bounds, come on top.
    ///
    /// # Errors
    /// As [`Reader::open`], or the coarsest clusters exceed the budget.
    pub fn open(context: &Context, path: &Path, budget: u64) -> Result<Self> {
        let reader = Reader::open(context, path)?;
        let model = reader.model();
        let groups = model.groups.len();
        let (mut below, mut above) = (vec![Vec::new(); groups], vec![Vec::new(); groups]);
        for (cluster, number) in model.clusters.iter().zip(0u32..) {
            if let Some(list) = below.get_mut(cluster.used_by as usize) {
                list.push(number);
            }
            if let Some(list) = above.get_mut(cluster.made_by as usize) {
                list.push(number);
            }
        }
        let resident = vec![None; model.clusters.len()];
        let mut made = Self { reader, budget, bytes: 0, resident, requests: 0, below, above };
        let roots: Vec<u32> = (0..made.resident.len() as u32).filter(|cluster| made.is_root(*cluster)).collect();
        let needed: u64 = roots.iter().map(|cluster| made.size(*cluster)).sum();
        if needed > budget {
            return Err(Error::memory(format!("the coarsest clusters have {needed} bytes, the budget {budget}"))
                .at(path.display().to_string())
                .advise("raise the budget"));
        }
        roots.into_iter().try_for_each(|cluster| made.read(cluster))?;
        Ok(made)
    }

    /// Returns the model without the triangles of clusters, for cuts.
    pub fn model(&self) -> &CrowdModel {
        self.reader.model()
    }

    /// Returns the same, for a crowd.
    pub fn shared(&self) -> Arc<CrowdModel> {
        self.reader.shared()
    }

    /// Returns the bytes of the triangles in memory.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reads at most `most` of the clusters of a cut that are not in memory, the coarsest first. Where the budget is
    /// exhausted, those go that no request has asked for longest; those of this cut stay.
    ///
    /// # Errors
    /// A cluster is damaged or does not exist.
    pub fn request(&mut self, cut: &[u32], most: u32) -> Result<Streamed> {
        self.requests += 1;
        let mut wanted = Vec::new();
        for cluster in cut {
            match self.resident.get_mut(*cluster as usize) {
                Some(Some(resident)) => resident.asked = self.requests,
                Some(None) => wanted.push(*cluster),
                None => return Err(Error::invalid(format!("cluster {cluster} does not exist"))),
            }
        }
        wanted.sort_unstable_by(|a, b| b.cmp(a));
        wanted.dedup();
        let mut old: Vec<(u64, u32)> = Vec::new();
        if !wanted.is_empty() {
            let known = self.resident.iter().zip(0..).filter_map(|(it, cluster)| Some((it.as_ref()?.asked, cluster)));
            let is_free = |(asked, cluster): &(u64, u32)| *asked < self.requests && !self.is_root(*cluster);
            old = known.filter(is_free).collect();
            // The last is the first to go: the oldest, and of these the finest.
            old.sort_unstable_by(|a, b| b.cmp(a));
        }
        let mut done = Streamed { missing: wanted.len() as u32, ..Streamed::default() };
        for cluster in wanted {
            if done.read == most {
                break;
            }
            while self.bytes + self.size(cluster) > self.budget {
                let Some((_, gone)) = old.pop() else { return Ok(done) };
                self.bytes -= self.size(gone);
                self.resident[gone as usize] = None;
                done.dropped += 1;
            }
            self.read(cluster)?;
            done.read += 1;
            done.missing -= 1;
        }
        Ok(done)
    }

    /// Returns what is drawn in place of a cut: its clusters that are in memory, and coarser ones where some are not.
    pub fn shown(&self, cut: &[u32]) -> Vec<u32> {
        let clusters = &self.model().clusters;
        let mut is_coarse = vec![false; self.below.len()];
        let mut waiting: Vec<u32> = Vec::new();
        let is_missing = |cluster: u32| self.resident[cluster as usize].is_none();
        waiting.extend(cut.iter().filter(|it| is_missing(**it)).map(|it| clusters[*it as usize].used_by));
        let mut coarse = Vec::new();
        while let Some(group) = waiting.pop() {
            let at = group as usize;
            if group == NONE || std::mem::replace(&mut is_coarse[at], true) {
                continue;
            }
            coarse.push(group);
            waiting.extend(self.below[at].iter().map(|it| clusters[*it as usize].made_by));
            waiting
                .extend(self.above[at].iter().filter(|it| is_missing(**it)).map(|it| clusters[*it as usize].used_by));
        }
        let is_drawn =
            |cluster: &u32| !is_coarse.get(clusters[*cluster as usize].used_by as usize).is_some_and(|it| *it);
        let mut shown: Vec<u32> = cut.iter().copied().filter(is_drawn).collect();
        shown.extend(coarse.iter().flat_map(|group| &self.above[*group as usize]).copied().filter(is_drawn));
        shown.sort_unstable();
        shown.dedup();
        shown
    }

    /// Returns the triangles of a cluster and their materials, if it is in memory.
    pub fn triangles(&self, cluster: u32) -> Option<(&[[u32; 3]], &[u32])> {
        let found = self.resident.get(cluster as usize)?.as_ref()?;
        Some((&found.triangles, &found.materials))
    }

    fn read(&mut self, cluster: u32) -> Result<()> {
        let (triangles, materials) = self.reader.cluster(cluster)?;
        self.bytes += self.size(cluster);
        self.resident[cluster as usize] = Some(Resident { triangles, materials, asked: self.requests });
        Ok(())
    }

    fn is_root(&self, cluster: u32) -> bool {
        self.model().clusters[cluster as usize].used_by == NONE
    }

    fn size(&self, cluster: u32) -> u64 {
        TRIANGLE * u64::from(self.model().clusters[cluster as usize].count)
    }
}
