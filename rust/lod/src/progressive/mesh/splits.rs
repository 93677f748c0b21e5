//! How a split is made and taken back in a mesh: what becomes of its vertices, triangles and lists of corners.
//!
//! Numbers are atomic so that splits whose vertices share no edge are made at the same time. All that two of them may have
//! in common is a vertex beside both, to whose list each adds a corner; where corners leave such a list, it is cleaned
//! once for all, after the round.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use relievo_core::simd::prefetch;

use super::active::ActiveMesh;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::Child;

/// Beside the vertex of a corner: its triangle is gone, but the vertex has it in its list still.
const GONE: u32 = 1 << 31;
/// Splits between the steps in which memory is asked for.
const AHEAD: usize = 4;

/// A vertex, and the split of the same number.
pub struct Slot {
    /// Twice the number of the split the vertex comes from, and 1 if it is the second vertex of that, or [`NONE`] where no
    /// vertex begins. Base vertices come from their own number.
    pub node: AtomicU32,
    /// Its first corner.
    pub first: AtomicU32,
    /// The vertex that was split, if the split is made.
    pub target: AtomicU32,
    /// The last round in which its corners were cleaned.
    pub cleaned: AtomicU32,
}

impl Default for Slot {
    fn default() -> Self {
        let [node, first, target, cleaned] = [NONE; 4].map(AtomicU32::new);
        Self { node, first, target, cleaned }
    }
}

/// A corner of a triangle.
pub struct Corner {
    /// Its vertex, [`NONE`] where the triangle is not there.
    pub vertex: AtomicU32,
    /// The next corner of the same vertex.
    pub following: AtomicU32,
    /// Its leaf.
    pub leaf: u32,
}

fn corner_after(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

fn corner_before(corner: u32) -> u32 {
    if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 }
}

impl ActiveMesh {
    pub(crate) fn insert(&self, corner: u32, vertex: u32) {
        self.corners[corner as usize].vertex.store(vertex, Relaxed);
        let following = self.slots[vertex as usize].first.swap(corner, Relaxed);
        self.corners[corner as usize].following.store(following, Relaxed);
    }

    /// Asks for what splits of a batch will touch: more steps are known of splits that come sooner.
    #[inline(always)]
    pub(crate) fn ask_ahead(&self, batch: &[u32], index: usize) {
        if let Some(vertex) = batch.get(index + 3 * AHEAD) {
            prefetch(&self.slots, *vertex as usize);
        }
        if let Some(vertex) = batch.get(index + 2 * AHEAD) {
            let slot = &self.slots[*vertex as usize];
            prefetch(&self.corners, slot.first.load(Relaxed) as usize);
            prefetch(&self.whole.splits, slot.node.load(Relaxed) as usize / 2);
        }
        if let Some(vertex) = batch.get(index + AHEAD) {
            let slot = &self.slots[*vertex as usize];
            if let Child::Split(split) = self.whole.child(slot.node.load(Relaxed)) {
                prefetch(&self.whole.faces, 2 * split as usize);
                prefetch(&self.corners, 6 * split as usize);
                prefetch(&self.corners, 6 * split as usize + 5);
                prefetch(&self.slots, split as usize);
                prefetch(&self.whole.splits, split as usize);
            }
            let corner = slot.first.load(Relaxed) as usize;
            if let Some(corner) = self.corners.get(corner) {
                prefetch(&self.corners, corner.following.load(Relaxed) as usize);
            }
        }
    }

    /// Splits a vertex. Returns the second vertex, and how many triangles there are more.
    pub(crate) fn split(&self, vertex: u32) -> (u32, usize) {
        let Child::Split(split) = self.whole.child(self.slots[vertex as usize].node.load(Relaxed)) else {
            return (vertex, 0);
        };
        let faces = [2 * split, 2 * split + 1];
        let leaves = faces.map(|face| self.whole.faces[face as usize]);
        // The vertex at a leaf is the one of the greatest number up to it, and is next to the one that is split.
        let own = |leaf| {
            if leaf >= split {
                split
            } else if leaf >= vertex {
                vertex
            } else {
                0
            }
        };
        let mut vertices = leaves.map(|leaves| leaves.map(own));
        let mut lists = [NONE; 2];
        let mut corner = self.slots[vertex as usize].first.load(Relaxed);
        while corner != NONE {
            let following = self.corners[corner as usize].following.load(Relaxed);
            for neighbour in [corner_after(corner), corner_before(corner)] {
                let neighbour = self.corners[neighbour as usize].vertex.load(Relaxed);
                for (vertices, leaves) in vertices.iter_mut().zip(&leaves) {
                    for (found, leaf) in vertices.iter_mut().zip(leaves) {
                        if neighbour <= *leaf && neighbour > *found {
                            *found = neighbour;
                        }
                    }
                }
            }
            let second = self.corners[corner as usize].leaf >= split;
            let list = &mut lists[usize::from(second)];
            self.corners[corner as usize].following.store(std::mem::replace(list, corner), Relaxed);
            if second {
                self.corners[corner as usize].vertex.store(split, Relaxed);
            }
            corner = following;
        }
        self.slots[vertex as usize].first.store(lists[0], Relaxed);
        self.slots[split as usize].first.store(lists[1], Relaxed);
        self.slots[vertex as usize].node.store(2 * split, Relaxed);
        self.slots[split as usize].node.store(2 * split + 1, Relaxed);
        self.slots[split as usize].target.store(vertex, Relaxed);
        self.there.insert(split);
        self.split_wedges(split);
        let mut made = 0;
        for (face, vertices) in faces.into_iter().zip(vertices) {
            if self.whole.faces[face as usize][0] != NONE {
                (0..).zip(vertices).for_each(|(side, vertex)| self.insert(3 * face + side, vertex));
                made += 1;
            }
        }
        (split, made)
    }

    /// Takes a split back but for the lists of vertices at both sides. Returns how many triangles are gone.
    pub(crate) fn merge(&self, split: u32) -> usize {
        let vertex = self.slots[split as usize].target.load(Relaxed);
        let faces = [2 * split, 2 * split + 1].into_iter().filter(|face| self.whole.faces[*face as usize][0] != NONE);
        let gone = faces.clone().count();
        for corner in faces.flat_map(|face| 3 * face..3 * face + 3) {
            let at = self.corners[corner as usize].vertex.load(Relaxed);
            let left = if at == vertex || at == split { NONE } else { at | GONE };
            self.corners[corner as usize].vertex.store(left, Relaxed);
        }
        let mut last = NONE;
        let mut list = NONE;
        for from in [split, vertex] {
            let mut corner = self.slots[from as usize].first.load(Relaxed);
            while corner != NONE {
                let following = self.corners[corner as usize].following.load(Relaxed);
                if self.corners[corner as usize].vertex.load(Relaxed) != NONE {
                    self.corners[corner as usize].vertex.store(vertex, Relaxed);
                    match last {
                        NONE => list = corner,
                        last => self.corners[last as usize].following.store(corner, Relaxed),
                    }
                    last = corner;
                }
                corner = following;
            }
        }
        if last != NONE {
            self.corners[last as usize].following.store(NONE, Relaxed);
        }
        self.slots[vertex as usize].first.store(list, Relaxed);
        self.slots[split as usize].first.store(NONE, Relaxed);
        self.slots[split as usize].node.store(NONE, Relaxed);
        self.slots[split as usize].target.store(NONE, Relaxed);
        self.there.remove(split);
        self.merge_wedges(split);
        self.slots[vertex as usize].node.store(self.whole.parent(split), Relaxed);
        gone
    }

    /// Cleans the lists of the vertices at both sides of a split that was taken back. Returns the split that its vertex
    /// comes from, or that vertex, if it is one of the base.
    pub(super) fn finish_merge(&self, split: u32) -> u32 {
        for corner in 6 * split..6 * split + 6 {
            let at = self.corners[corner as usize].vertex.load(Relaxed);
            // The first to come cleans for all, also for splits on other sides of the vertex.
            if at != NONE && self.slots[(at & !GONE) as usize].cleaned.swap(self.round, Relaxed) != self.round {
                self.clean(at & !GONE);
            }
        }
        self.whole.parent(split) / 2
    }

    fn clean(&self, vertex: u32) {
        let mut link = &self.slots[vertex as usize].first;
        loop {
            let corner = link.load(Relaxed);
            if corner == NONE {
                return;
            }
            let following = &self.corners[corner as usize].following;
            if self.corners[corner as usize].vertex.load(Relaxed) & GONE != 0 {
                self.corners[corner as usize].vertex.store(NONE, Relaxed);
                link.store(following.load(Relaxed), Relaxed);
            } else {
                link = following;
            }
        }
    }

    /// Whether the next split of a vertex is deeper than those of all vertices around, deviates no less, and has its
    /// triangles between them.
    pub(super) fn stands(&self, vertex: u32) -> bool {
        let Some(Child::Split(split)) = self.child(vertex) else { return false };
        let key = self.whole.splits[split as usize].key;
        let mut lowest = vertex;
        for neighbour in self.spokes(vertex).flatten() {
            lowest = lowest.min(neighbour);
            // Where splits come in another order than that of their depths, splits that are made stand on none that are not.
            if neighbour != vertex && self.made_by(neighbour).is_some_and(|made| made.depth() <= key.depth()) {
                return false;
            }
            if neighbour != vertex
                && let Some(Child::Split(other)) = self.child(neighbour)
            {
                let other = self.whole.splits[other as usize].key;
                if other.depth() >= key.depth() || other > key {
                    return false;
                }
            }
        }
        let faces = &self.whole.faces[2 * split as usize..2 * split as usize + 2];
        faces.iter().flatten().all(|leaf| *leaf >= lowest)
    }

    /// The corners at a vertex, as the vertices after and before each.
    #[inline(always)]
    pub(crate) fn spokes(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> {
        let mut corner = self.slots[vertex as usize].first.load(Relaxed);
        std::iter::from_fn(move || {
            (corner != NONE).then(|| {
                let ends = [corner_after(corner), corner_before(corner)];
                corner = self.corners[corner as usize].following.load(Relaxed);
                ends.map(|at| self.corners[at as usize].vertex.load(Relaxed))
            })
        })
    }

    /// The triangles at a vertex.
    pub(crate) fn faces_at(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let mut corner = self.slots[vertex as usize].first.load(Relaxed);
        std::iter::from_fn(move || {
            (corner != NONE).then(|| {
                let face = corner / 3;
                corner = self.corners[corner as usize].following.load(Relaxed);
                face
            })
        })
    }

    /// The vertex that a split has split.
    pub(crate) fn target(&self, split: u32) -> u32 {
        self.slots[split as usize].target.load(Relaxed)
    }
}
