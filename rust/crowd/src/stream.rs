//! Crowds whose clusters are read from files while they are drawn, within a budget of memory (Section 5).
//!
//! Triangles are in slots of equal size, as many as the budget has room for, so that a host mirrors them in an index buffer
//! of fixed size. The coarsest clusters never leave them. A frame draws every cut of which the clusters are in memory, or are
//! read for it; in place of another it draws the finest of the cuts that are coarser by one error everywhere of which they are.
//! Cuts have no cracks, so what is drawn has none. What is drawn stays in its slots while what replaces it is read.

mod part;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use self::part::{Coarser, Part};
use crate::crowd::{Crowd, Drawn, Frame};
use crate::draws::too_large;
use crate::hierarchy::{Cluster, CrowdModel, NONE};

/// Bytes of a triangle in memory: three vertices and a material.
const TRIANGLE: u64 = 16;
/// Errors, in sizes of a model, that cuts may have which would exceed the budget: the smallest, how many, and the factor from
/// one to the next. The largest is far above that of the coarsest clusters.
const ERRORS: (f32, u32, f32) = (1e-6, 96, 1.25);

/// The clusters in memory of the models of a crowd.
#[derive(Debug)]
pub struct Stream {
    parts: Vec<Part>,
    /// Clusters that a frame reads at most.
    most_read: u32,
    /// Triangles of a slot.
    slot_triangles: u32,
    /// Of all slots, one after the other.
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    /// Model and cluster of each slot in use.
    owners: Vec<Option<[u32; 2]>>,
    /// Slots that are not in use.
    free: Vec<u32>,
    frames: u64,
    read: Vec<[u32; 2]>,
    counts: Streamed,
}

/// What the last cut of a crowd read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streamed {
    /// Clusters that were read.
    pub read: u32,
    /// Clusters that left memory for them.
    pub dropped: u32,
    /// Clusters of the cuts of all agents that are not in memory; agents of one step of a model count once.
    pub missing: u32,
    /// Clusters in memory.
    pub resident: u32,
    /// Triangles of the cut, as if all its clusters were in memory.
    pub wanted_triangles: u64,
}

/// Clusters of a model that agents show.
#[derive(Debug)]
struct Want {
    model: u32,
    /// What the view deserves.
    cut: Vec<u32>,
    /// What the budget has room for.
    target: Vec<u32>,
    /// What is drawn.
    shown: Vec<u32>,
    /// Where the frame has that, once it has.
    place: Option<Drawn>,
}

/// Slots of clusters that the frame does not draw.
struct Unused {
    /// From the last to the first that may be used anew, with model and cluster.
    slots: Vec<(u32, [u32; 2])>,
    /// Clusters that the frame may read still.
    reads: usize,
}

impl Stream {
    /// Opens the files of some models and reads their coarsest clusters. The triangles of clusters take at most `budget`
    /// bytes; vertices, poses and hierarchies, which the memory limit of the context bounds for each file, come on top. A cut
    /// reads at most `most_read` clusters.
    ///
    /// # Errors
    /// There is no file, one is no crowd model or is damaged, the coarsest clusters exceed the budget, the budget exceeds the
    /// memory limit, or no cluster may be read.
    pub fn open<P: AsRef<Path>>(context: &Context, paths: &[P], budget: u64, most_read: u32) -> Result<Self> {
        if paths.is_empty() || most_read == 0 {
            return Err(Error::invalid("no model or no cluster may be read").advise("give one at least"));
        }
        let parts = paths.iter().map(|path| Part::open(context, path.as_ref())).collect::<Result<Vec<_>>>()?;
        let all = || parts.iter().flat_map(|part| part.clusters());
        let slot_triangles = all().map(|cluster| cluster.count).max().unwrap_or_default().max(1);
        let size = TRIANGLE * u64::from(slot_triangles);
        let roots: Vec<[u32; 2]> =
            (0..).zip(&parts).flat_map(|(model, part)| part.roots().map(move |cluster| [model, cluster])).collect();
        let count = (budget / size).min(all().count() as u64);
        if count < roots.len() as u64 {
            let needed = size * roots.len() as u64;
            return Err(Error::memory(format!("the coarsest clusters take {needed} bytes, the budget is {budget}"))
                .advise("raise the budget"));
        }
        if count * size > context.memory_limit() {
            return Err(Error::memory(format!("the budget of {budget} bytes exceeds the memory limit"))
                .advise("lower the budget or raise the limit"));
        }
        if count * u64::from(slot_triangles) > u64::from(u32::MAX / 3) {
            return Err(too_large("indices").advise("lower the budget"));
        }
        let places = count as usize * slot_triangles as usize;
        let mut made = Self {
            parts,
            most_read,
            slot_triangles,
            triangles: vec![[0; 3]; places],
            materials: vec![0; places],
            owners: vec![None; count as usize],
            free: (0..count as u32).rev().collect(),
            frames: 0,
            read: Vec::new(),
            counts: Streamed::default(),
        };
        for cluster in roots {
            if let Some(slot) = made.free.pop() {
                made.read_into(slot, cluster)?;
            }
        }
        made.counts.resident = made.read.len() as u32;
        Ok(made)
    }

    /// Returns the models, without the triangles of clusters.
    fn models(&self) -> Vec<Arc<CrowdModel>> {
        self.parts.iter().map(|part| part.reader.shared()).collect()
    }

    /// Returns how many slots there are.
    pub fn slot_count(&self) -> u32 {
        self.owners.len() as u32
    }

    /// Returns how many triangles a slot has room for. The slot of number n begins at triangle n times this.
    pub fn slot_triangles(&self) -> u32 {
        self.slot_triangles
    }

    /// Returns the bytes of all slots.
    pub fn bytes(&self) -> u64 {
        TRIANGLE * self.triangles.len() as u64
    }

    /// Returns what the last cut read.
    pub fn counts(&self) -> Streamed {
        self.counts
    }

    /// Returns model and cluster of what the last cut read, or opening did.
    pub fn read(&self) -> &[[u32; 2]] {
        &self.read
    }

    /// Returns the slot of a cluster that is in memory.
    pub fn slot(&self, model: u32, cluster: u32) -> Option<u32> {
        *self.parts.get(model as usize)?.slots.get(cluster as usize)?
    }

    /// Returns model and cluster of what is in a slot.
    pub fn content(&self, slot: u32) -> Option<[u32; 2]> {
        *self.owners.get(slot as usize)?
    }

    /// Returns where the triangles of a cluster begin in all slots, 0 if it is not in memory.
    pub(crate) fn first_triangle(&self, model: u32, cluster: u32) -> u32 {
        self.slot(model, cluster).unwrap_or_default() * self.slot_triangles
    }

    /// Returns the triangles of a cluster that is in memory, and their materials.
    pub fn triangles(&self, model: u32, cluster: u32) -> Option<(&[[u32; 3]], &[u32])> {
        let first = self.slot(model, cluster)? as usize * self.slot_triangles as usize;
        let count = self.parts[model as usize].clusters()[cluster as usize].count as usize;
        Some((&self.triangles[first..][..count], &self.materials[first..][..count]))
    }

    /// Reads what a frame draws as far as the budget and the number of reads go, and draws coarser clusters in the frame
    /// where some are missing. A frame of a crowd with a stream has no impostors.
    pub(crate) fn update(&mut self, crowd: &Crowd, frame: &mut Frame) -> Result<()> {
        let model = |agent: u32| crowd.agents()[agent as usize].model;
        let mut wants: Vec<Want> = Vec::new();
        let mut steps: HashMap<(u32, u32), usize> = HashMap::new();
        let mut want_of = Vec::with_capacity(frame.drawn.len());
        for drawn in &frame.drawn {
            let number = model(drawn.0);
            let next = wants.len();
            let at = match drawn.1 {
                Drawn::Step(step) => *steps.entry((number, step)).or_insert(next),
                Drawn::Mixed { .. } | Drawn::Impostor => next,
            };
            if at == next {
                let cut = crowd.clusters(frame, *drawn).to_vec();
                wants.push(Want { model: number, target: cut.clone(), cut, shown: Vec::new(), place: None });
            }
            want_of.push(at);
        }
        self.counts = Streamed { wanted_triangles: frame.triangles, ..Streamed::default() };
        let done = self.choose(crowd, &mut wants);
        for want in &wants {
            let missing = self.parts[want.model as usize].missing(&want.cut).count() as u32;
            self.counts.missing = self.counts.missing.saturating_add(missing);
        }
        self.counts.read = self.read.len() as u32;
        self.counts.resident = (self.owners.len() - self.free.len()) as u32;
        done?;
        let (mut mixed, mut blends) = (Vec::new(), Vec::new());
        let (mut clusters, mut triangles) = (0, 0);
        let mut all = std::mem::take(&mut frame.drawn);
        for (entry, at) in all.iter_mut().zip(want_of) {
            let Want { shown, cut, model, place, .. } = &mut wants[at];
            clusters += shown.len() as u64;
            triangles += crowd.models()[*model as usize].triangle_count(shown);
            if matches!(entry.1, Drawn::Step(_)) && shown == cut {
                continue;
            }
            // Agents of a step have the same clusters, so that they are instances of the same draws.
            entry.1 = *place.get_or_insert_with(|| {
                if !frame.blends.is_empty() {
                    let before = crowd.blends(frame, *entry).iter().copied();
                    let of: HashMap<u32, f32> = cut.iter().copied().zip(before).collect();
                    blends.extend(shown.iter().map(|cluster| of.get(cluster).copied().unwrap_or_default()));
                }
                let first = mixed.len() as u32;
                mixed.extend_from_slice(shown);
                Drawn::Mixed { first, count: shown.len() as u32 }
            });
        }
        (frame.drawn, frame.clusters, frame.triangles) = (all, clusters, triangles);
        (frame.mixed, frame.blends) = (mixed, blends);
        Ok(())
    }

    /// Finds what is drawn for each of the cuts, and reads it.
    fn choose(&mut self, crowd: &Crowd, wants: &mut [Want]) -> Result<()> {
        self.frames += 1;
        self.read.clear();
        if wants.iter().any(|want| self.parts[want.model as usize].missing(&want.cut).next().is_some()) {
            self.fit(wants);
        }
        let mut fallbacks: Vec<(usize, Coarser)> = Vec::new();
        for (at, want) in wants.iter_mut().enumerate() {
            let part = &mut self.parts[want.model as usize];
            let ladder = crowd.ladder(want.model).filter(|_| part.missing(&want.target).next().is_some());
            let fallback = ladder.map(|ladder| part.finest(ladder, &want.target, 0));
            part.mark(&want.target, self.frames);
            want.shown.clone_from(&want.target);
            if let Some(fallback) = fallback {
                part.mark(&fallback.clusters, self.frames);
                want.shown.clone_from(&fallback.clusters);
                fallbacks.push((at, fallback));
            }
        }
        if fallbacks.is_empty() {
            return Ok(());
        }
        let mut unused = Unused { slots: self.unused(), reads: self.most_read as usize };
        // Cuts of many clusters are those of agents that are near.
        fallbacks.sort_by_key(|(at, _)| std::cmp::Reverse(wants[*at].target.len()));
        for (at, fallback) in fallbacks {
            let want = &mut wants[at];
            let Some(ladder) = crowd.ladder(want.model) else { continue };
            let room = self.room(&unused);
            let part = &mut self.parts[want.model as usize];
            let goal = part.goal(ladder, &want.target, &fallback, (unused.reads, room));
            if self.fetch(want.model, &goal, &mut unused)? {
                want.shown = goal;
            }
        }
        Ok(())
    }

    /// Returns how many slots may be filled still.
    fn room(&self, unused: &Unused) -> usize {
        let is_unused = |[model, cluster]: [u32; 2]| self.parts[model as usize].used[cluster as usize] < self.frames;
        self.free.len() + unused.slots.iter().filter(|(_, owner)| is_unused(*owner)).count()
    }

    /// Makes cuts coarser, by the least error for which all their clusters have slots beside the coarsest.
    fn fit(&self, wants: &mut [Want]) {
        let fits = |cuts: &mut dyn Iterator<Item = (u32, Vec<u32>)>| {
            let roots = (0..).zip(&self.parts).map(|(model, part)| (model, part.roots().collect::<Vec<_>>()));
            let all = cuts.chain(roots).flat_map(|(model, cut)| cut.into_iter().map(move |cluster| (model, cluster)));
            let mut all: Vec<(u32, u32)> = all.collect();
            all.sort_unstable();
            all.dedup();
            all.len() <= self.owners.len()
        };
        if fits(&mut wants.iter().map(|want| (want.model, want.cut.clone()))) {
            return;
        }
        let coarser = |want: &Want, step: u32| {
            let part = &self.parts[want.model as usize];
            let (least, _, factor) = ERRORS;
            part.coarsened(&want.cut, part.reader.model().size() * least * factor.powi(step as i32))
        };
        let (mut low, mut high) = (0, ERRORS.1);
        while low < high {
            let middle = (low + high) / 2;
            if fits(&mut wants.iter().map(|want| (want.model, coarser(want, middle)))) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        for want in wants {
            want.target = coarser(want, high);
        }
    }

    /// Returns the slots of clusters that the frame does not draw, with model and cluster: the last is the one that was drawn
    /// longest ago, and of these the one with the smallest error.
    fn unused(&self) -> Vec<(u32, [u32; 2])> {
        let used = (0..).zip(&self.owners).filter_map(|(slot, owner)| owner.map(|owner| (slot, owner)));
        let ranked = used.map(|(slot, [model, cluster])| {
            let part = &self.parts[model as usize];
            (part.used[cluster as usize], part.rank(cluster), slot, [model, cluster])
        });
        let is_free = |(frame, _, _, [model, cluster]): &(u64, u32, u32, [u32; 2])| {
            *frame < self.frames && self.parts[*model as usize].clusters()[*cluster as usize].used_by != NONE
        };
        let mut unused: Vec<_> = ranked.filter(is_free).collect();
        unused.sort_unstable_by(|a, b| b.cmp(a));
        unused.into_iter().map(|(_, _, slot, owner)| (slot, owner)).collect()
    }

    /// Reads clusters of a cut that are missing, those of the largest errors first, if there is room for all. Returns whether all are
    /// in memory then.
    fn fetch(&mut self, model: u32, cut: &[u32], unused: &mut Unused) -> Result<bool> {
        let part = &mut self.parts[model as usize];
        part.mark(cut, self.frames);
        let mut missing: Vec<u32> = part.missing(cut).collect();
        missing.sort_unstable_by_key(|cluster| std::cmp::Reverse((part.rank(*cluster), *cluster)));
        if missing.len() > self.room(unused) {
            return Ok(false);
        }
        for cluster in missing {
            if unused.reads == 0 {
                return Ok(false);
            }
            let Some(slot) = self.free.pop().or_else(|| self.take(unused)) else { return Ok(false) };
            if let Err(error) = self.read_into(slot, [model, cluster]) {
                self.free.push(slot);
                return Err(error);
            }
            self.parts[model as usize].used[cluster as usize] = self.frames;
            unused.reads -= 1;
        }
        Ok(true)
    }

    /// Takes the slot of the cluster that was drawn longest ago.
    fn take(&mut self, unused: &mut Unused) -> Option<u32> {
        while let Some((slot, [model, cluster])) = unused.slots.pop() {
            let part = &mut self.parts[model as usize];
            // Another cut of the frame may draw it by now.
            if part.used[cluster as usize] < self.frames {
                part.slots[cluster as usize] = None;
                self.owners[slot as usize] = None;
                self.counts.dropped += 1;
                return Some(slot);
            }
        }
        None
    }

    /// Reads a cluster into a slot that is not in use.
    fn read_into(&mut self, slot: u32, [model, cluster]: [u32; 2]) -> Result<()> {
        let part = &mut self.parts[model as usize];
        let (triangles, materials) = part.reader.cluster(cluster)?;
        let first = slot as usize * self.slot_triangles as usize;
        self.triangles[first..][..triangles.len()].copy_from_slice(&triangles);
        self.materials[first..][..materials.len()].copy_from_slice(&materials);
        part.slots[cluster as usize] = Some(slot);
        self.owners[slot as usize] = Some([model, cluster]);
        self.read.push([model, cluster]);
        Ok(())
    }
}

impl Crowd {
    /// Makes a crowd without agents whose cuts read clusters from files, and draw coarser ones where some are missing.
    pub fn streamed(stream: Stream) -> Self {
        let mut crowd = Self::new(stream.models());
        crowd.stream = Some(stream);
        crowd
    }

    /// Returns the clusters in memory, if clusters are read while they are drawn.
    pub fn stream(&self) -> Option<&Stream> {
        self.stream.as_ref()
    }

    /// Returns the triangles of a cluster of a model, and their materials. Nothing while the cluster is not in memory.
    pub fn triangles(&self, model: u32, cluster: u32) -> (&[[u32; 3]], &[u32]) {
        if let Some(stream) = &self.stream {
            return stream.triangles(model, cluster).unwrap_or_default();
        }
        let model = &self.models()[model as usize];
        let Cluster { first, count, .. } = model.clusters[cluster as usize];
        (model.triangles(cluster), &model.character.materials[first as usize..(first + count) as usize])
    }

    /// Checks that whole models are in memory.
    ///
    /// # Errors
    /// Clusters are read while they are drawn.
    pub(crate) fn check_whole(&self) -> Result<()> {
        self.models().iter().try_for_each(|model| model.check_triangles())
    }
}
