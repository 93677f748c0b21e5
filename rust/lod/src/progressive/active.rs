//! A mesh of a progressive mesh, refined and coarsened in place (Derzapf, Grund, Guthe 2014, Section 5).
//!
//! Splits are made in the order of their depths, the deepest first, and taken back in the opposite one. No two of the
//! same depth have vertices that share an edge, so all of a depth are made at the same time, and none has to be checked:
//! whatever a split stands on is deeper and deviates no less, so a cut that has the one has the other.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use relievo_core::Context;
use relievo_core::simd::prefetch;

use super::cut::Cut;
use super::hierarchy::{Child, Progressive};
use super::history::History;
use super::moves::{Coarsening, Moves, Refining};
use super::place::Place;
use crate::connectivity::NONE;

/// Beside the vertex of a corner: its triangle is gone, but the vertex has it in its list still.
const GONE: u32 = 1 << 31;
/// Vertices that are looked at by one task.
const PART: usize = 8192;
/// Splits between the steps in which memory is asked for.
const AHEAD: usize = 4;
/// Splits that are made by one task.
const BATCH: usize = 128;

/// A mesh of a progressive mesh.
pub struct ActiveMesh<'a> {
    whole: &'a Progressive,
    cut: Cut,
    /// Vertices, by the first of their leaves.
    slots: Vec<Slot>,
    /// Three a triangle.
    corners: Vec<Corner>,
    /// Counts rounds of coarsening.
    round: u32,
    triangles: usize,
    vertices: usize,
    /// What was edited, if anything was.
    pub(super) moves: Option<Moves>,
    pub(super) history: History,
}

/// A vertex, and the split of the same number.
struct Slot {
    /// Twice the number of the split the vertex comes from, and 1 if it is the second vertex of that, or [`NONE`] where no
    /// vertex begins. Base vertices come from their own number.
    node: AtomicU32,
    /// Its first corner.
    first: AtomicU32,
    /// The vertex that was split, if the split is made.
    target: AtomicU32,
    /// The last round in which its corners were cleaned.
    cleaned: AtomicU32,
}

impl Default for Slot {
    fn default() -> Self {
        let [node, first, target, cleaned] = [NONE; 4].map(AtomicU32::new);
        Self { node, first, target, cleaned }
    }
}

/// A corner of a triangle.
struct Corner {
    /// Its vertex, [`NONE`] where the triangle is not there.
    vertex: AtomicU32,
    /// The next corner of the same vertex.
    following: AtomicU32,
    /// Its leaf.
    leaf: u32,
}

/// The places, normals and triangles of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extract {
    /// Positions. The finest mesh has the vertices of the input in their order, others go along the surface.
    pub points: Vec<[f32; 3]>,
    /// Normals of length 1, or 0 at vertices without triangles.
    pub normals: Vec<[f32; 3]>,
    /// Vertices of every triangle, in the order of the input.
    pub triangles: Vec<[u32; 3]>,
}

fn corner_after(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

fn corner_before(corner: u32) -> u32 {
    if corner % 3 == 0 { corner + 2 } else { corner - 1 }
}

impl<'a> ActiveMesh<'a> {
    /// The base mesh.
    pub fn new(whole: &'a Progressive) -> Self {
        let corner = |leaf: &u32| Corner { vertex: AtomicU32::new(NONE), following: AtomicU32::new(NONE), leaf: *leaf };
        let made = Self {
            whole,
            cut: Cut::BASE,
            slots: (0..whole.vertex_count()).map(|_| Slot::default()).collect(),
            corners: whole.faces.iter().flatten().map(corner).collect(),
            round: 0,
            triangles: whole.base_faces().len(),
            vertices: whole.base_vertices().len(),
            moves: None,
            history: History::default(),
        };
        for leaf in whole.base_vertices() {
            made.slots[*leaf as usize].node.store(2 * leaf, Relaxed);
        }
        // Base vertices come in the order of their leaves.
        let vertex_of = |leaf: u32| {
            let above = whole.base_vertices().partition_point(|first| *first <= leaf);
            whole.base_vertices()[above - 1]
        };
        for face in whole.base_faces() {
            for (side, leaf) in (0..).zip(whole.faces[*face as usize]) {
                made.insert(3 * face + side, vertex_of(leaf));
            }
        }
        made
    }

    /// Triangles of this mesh.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// Vertices of this mesh.
    pub fn vertex_count(&self) -> usize {
        self.vertices
    }

    /// The mesh this is.
    pub fn cut(&self) -> Cut {
        self.cut
    }

    /// Becomes another mesh. Returns how many splits were made and taken back.
    pub fn adapt(&mut self, context: &Context, cut: Cut) -> [usize; 2] {
        let (finer, coarser) = (cut < self.cut, cut > self.cut);
        self.cut = cut;
        context.within(|| {
            let splits = if finer { self.refine(context, |_, _| true).unwrap_or(0) } else { 0 };
            [splits, if coarser { self.coarsen(context) } else { 0 }]
        })
    }

    /// Becomes the finest mesh, and tells whether on that way every split comes after those it stands on.
    pub(super) fn is_sound(&mut self, context: &Context) -> bool {
        self.cut = Cut::FINEST;
        context.within(|| self.refine(context, Self::stands).is_some())
    }

    /// Makes the splits of the cut, or some of them if `check` finds a vertex that must not be split.
    fn refine(&mut self, context: &Context, check: impl Fn(&Self, u32) -> bool + Sync) -> Option<usize> {
        let mesh = &*self;
        let parts = context.map(mesh.slots.len().div_ceil(PART), |part| {
            let range = part * PART..mesh.slots.len().min((part + 1) * PART);
            range.filter_map(|vertex| mesh.wanted(vertex as u32)).collect::<Vec<_>>()
        });
        let mut waiting = Waiting::default();
        parts.into_iter().flatten().for_each(|(depth, vertex)| waiting.add(depth, vertex));
        let (mut splits, mut triangles) = (0, 0);
        for depth in (0..waiting.0.len()).rev() {
            let vertices = std::mem::take(&mut waiting.0[depth]);
            let parts = vertices.len().div_ceil(BATCH);
            let batch = |part: usize| &vertices[part * BATCH..vertices.len().min((part + 1) * BATCH)];
            let mesh = &*self;
            let may = |part: usize| batch(part).iter().all(|vertex| check(mesh, *vertex));
            if !context.map(parts, may).into_iter().all(|may| may) {
                return None;
            }
            let made = context.map(parts, |part| {
                let (mut next, mut triangles) = (Vec::with_capacity(2 * batch(part).len()), 0);
                let mut refining = mesh.moves.as_ref().map(|moves| Refining::new(mesh, moves));
                for (index, vertex) in batch(part).iter().enumerate() {
                    mesh.ask_ahead(batch(part), index);
                    let before = refining.as_mut().and_then(|moves| moves.before(*vertex));
                    let (second, made) = mesh.split(*vertex);
                    if let Some((refining, before)) = refining.as_mut().zip(before) {
                        refining.split(before, [*vertex, second]);
                    }
                    next.extend([*vertex, second].into_iter().filter_map(|vertex| mesh.wanted(vertex)));
                    triangles += made;
                }
                (next, triangles, refining.map(|refining| refining.noted))
            });
            splits += vertices.len();
            for (next, made, noted) in made {
                triangles += made;
                if let Some((moves, noted)) = self.moves.as_mut().zip(noted) {
                    moves.keep(noted);
                }
                next.into_iter().for_each(|(depth, vertex)| waiting.add(depth, vertex));
            }
        }
        self.triangles += triangles;
        self.vertices += splits;
        Some(splits)
    }

    /// Whether the next split of a vertex is deeper than those of all vertices around, deviates no less, and has its
    /// triangles between them.
    fn stands(&self, vertex: u32) -> bool {
        let Some(Child::Split(split)) = self.child(vertex) else { return false };
        let key = self.whole.splits[split as usize].key;
        let mut lowest = vertex;
        let mut corner = self.slots[vertex as usize].first.load(Relaxed);
        while corner != NONE {
            for at in [corner_after(corner), corner_before(corner)] {
                let neighbour = self.corners[at as usize].vertex.load(Relaxed);
                lowest = lowest.min(neighbour);
                if neighbour != vertex
                    && let Some(Child::Split(other)) = self.child(neighbour)
                {
                    let other = self.whole.splits[other as usize].key;
                    if other.depth() >= key.depth() || other > key {
                        return false;
                    }
                }
            }
            corner = self.corners[corner as usize].following.load(Relaxed);
        }
        let faces = &self.whole.faces[2 * split as usize..2 * split as usize + 2];
        faces.iter().flatten().all(|leaf| *leaf >= lowest)
    }

    /// The depth of the split that is next at a vertex, and the vertex, if that split is part of the cut.
    #[inline(always)]
    fn wanted(&self, vertex: u32) -> Option<(u32, u32)> {
        let Some(Child::Split(split)) = self.child(vertex) else { return None };
        let key = self.whole.splits[split as usize].key;
        self.cut.has(key, split).then(|| (key.depth(), vertex))
    }

    fn coarsen(&mut self, context: &Context) -> usize {
        let mesh = &*self;
        let parts = context.map(mesh.slots.len().div_ceil(PART), |part| {
            let range = part * PART..mesh.slots.len().min((part + 1) * PART);
            range.filter_map(|split| mesh.unwanted(split as u32)).collect::<Vec<_>>()
        });
        let mut waiting = Waiting::default();
        parts.into_iter().flatten().for_each(|(depth, split)| waiting.add(depth, split));
        let (mut splits, mut triangles, mut depth) = (0, 0, 0);
        while depth < waiting.0.len() {
            let mut list = std::mem::take(&mut waiting.0[depth]);
            // Both vertices of a split may have told that it can be taken back.
            list.sort_unstable();
            list.dedup();
            self.round += 1;
            let mesh = &*self;
            let batches = list.len().div_ceil(BATCH);
            let batch = |part: usize| &list[part * BATCH..list.len().min((part + 1) * BATCH)];
            let gone = context.map(batches, |part| {
                let moved = mesh.moves.as_ref().map(|moves| Coarsening::new(context, mesh, moves).merge(batch(part)));
                (batch(part).iter().map(|split| mesh.merge(*split)).sum::<usize>(), moved)
            });
            let next = context.map(batches, |part| {
                batch(part).iter().filter_map(|split| mesh.finish_merge(*split)).collect::<Vec<_>>()
            });
            splits += list.len();
            for (gone, moved) in gone {
                triangles += gone;
                if let Some((moves, moved)) = self.moves.as_mut().zip(moved) {
                    moves.keep(moved);
                }
            }
            next.into_iter().flatten().for_each(|(depth, split)| waiting.add(depth, split));
            depth += 1;
        }
        self.triangles -= triangles;
        self.vertices -= splits;
        splits
    }

    /// The depth of a split and the split, if it is made, not part of the cut, and its vertices are not split further.
    #[inline(always)]
    fn unwanted(&self, split: u32) -> Option<(u32, u32)> {
        let node = 2 * split;
        let target = self.slots[split as usize].target.load(Relaxed);
        let is_whole = target != NONE
            && self.slots[split as usize].node.load(Relaxed) == node + 1
            && self.slots[target as usize].node.load(Relaxed) == node;
        let key = self.whole.splits[split as usize].key;
        (is_whole && !self.cut.has(key, split)).then(|| (key.depth(), split))
    }

    fn insert(&self, corner: u32, vertex: u32) {
        self.corners[corner as usize].vertex.store(vertex, Relaxed);
        let following = self.slots[vertex as usize].first.swap(corner, Relaxed);
        self.corners[corner as usize].following.store(following, Relaxed);
    }

    /// Asks for what splits of a batch will touch: more steps are known of those that come sooner.
    #[inline(always)]
    fn ask_ahead(&self, batch: &[u32], index: usize) {
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
    fn split(&self, vertex: u32) -> (u32, usize) {
        let Child::Split(split) = self.whole.child(self.slots[vertex as usize].node.load(Relaxed)) else {
            return (vertex, 0);
        };
        let faces = [2 * split, 2 * split + 1];
        let leaves = faces.map(|face| self.whole.faces[face as usize]);
        // The vertex at a leaf is the one of the greatest number up to it, and is next to the one that is split.
        let mut vertices = leaves.map(|leaves| leaves.map(|leaf| if leaf >= split { split } else { vertex }));
        for (vertices, leaves) in vertices.iter_mut().zip(&leaves) {
            for (found, leaf) in vertices.iter_mut().zip(leaves) {
                *found = if vertex <= *leaf { *found } else { 0 };
            }
        }
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
    fn merge(&self, split: u32) -> usize {
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
        self.slots[vertex as usize].node.store(self.whole.parent(split), Relaxed);
        gone
    }

    /// Cleans the lists of the vertices at both sides of a split that was taken back, and returns the split whose vertex
    /// is whole again, if that is to be taken back too.
    fn finish_merge(&self, split: u32) -> Option<(u32, u32)> {
        for corner in 6 * split..6 * split + 6 {
            let at = self.corners[corner as usize].vertex.load(Relaxed);
            // The first to come cleans for all, also for splits on other sides of the vertex.
            if at != NONE && self.slots[(at & !GONE) as usize].cleaned.swap(self.round, Relaxed) != self.round {
                self.clean(at & !GONE);
            }
        }
        self.unwanted(self.whole.parent(split) / 2)
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

    /// Vertices of this mesh.
    pub(super) fn vertices(&self) -> impl Iterator<Item = u32> {
        let is_there = |vertex: &u32| self.slots[*vertex as usize].node.load(Relaxed) != NONE;
        (0..self.slots.len() as u32).filter(is_there)
    }

    /// Where a vertex is now.
    pub(super) fn place(&self, vertex: u32, child: Child) -> Place {
        self.moves.as_ref().and_then(|moves| moves.place(vertex)).unwrap_or_else(|| self.whole.place(child, vertex))
    }

    /// Where a vertex was built.
    pub(super) fn built(&self, vertex: u32) -> Place {
        self.child(vertex).map_or_else(Place::default, |child| self.whole.place(child, vertex))
    }

    /// The vertex that a split has split.
    pub(super) fn target(&self, split: u32) -> u32 {
        self.slots[split as usize].target.load(Relaxed)
    }

    /// The corners at a vertex, as the vertices after and before each.
    #[inline(always)]
    pub(super) fn spokes(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> {
        let mut corner = self.slots[vertex as usize].first.load(Relaxed);
        std::iter::from_fn(move || {
            (corner != NONE).then(|| {
                let ends = [corner_after(corner), corner_before(corner)];
                corner = self.corners[corner as usize].following.load(Relaxed);
                ends.map(|at| self.corners[at as usize].vertex.load(Relaxed))
            })
        })
    }

    pub(super) fn whole(&self) -> &'a Progressive {
        self.whole
    }

    pub(super) fn child(&self, vertex: u32) -> Option<Child> {
        let node = self.slots[vertex as usize].node.load(Relaxed);
        (node != NONE).then(|| self.whole.child(node))
    }

    /// The mesh as lists.
    pub fn extract(&self) -> Extract {
        let whole = self.whole;
        let mut order: Vec<(u32, Child)> =
            (0..whole.vertex_count() as u32).filter_map(|vertex| Some((vertex, self.child(vertex)?))).collect();
        if order.len() == whole.vertex_count() {
            order.sort_unstable_by_key(|(_, child)| match child {
                Child::Leaf(number) | Child::Split(number) => *number,
            });
        }
        let mut made = Extract::default();
        let mut numbers = vec![NONE; whole.vertex_count()];
        for (vertex, child) in order {
            let place = self.place(vertex, child);
            numbers[vertex as usize] = made.points.len() as u32;
            made.points.push(place.point.to_array());
            made.normals.push(place.normal.to_array());
        }
        let mut triangles = vec![[NONE; 3]; whole.triangle_count()];
        for (face, corners) in self.corners.as_chunks::<3>().0.iter().enumerate() {
            let [a, b, c] = [&corners[0], &corners[1], &corners[2]].map(|corner| corner.vertex.load(Relaxed));
            if a != NONE {
                triangles[whole.face_id(face as u32) as usize] = [a, b, c].map(|vertex| numbers[vertex as usize]);
            }
        }
        made.triangles = triangles.into_iter().filter(|triangle| triangle[0] != NONE).collect();
        made
    }
}

/// Splits or vertices by depth.
#[derive(Default)]
struct Waiting(Vec<Vec<u32>>);

impl Waiting {
    fn add(&mut self, depth: u32, number: u32) {
        let depth = depth as usize;
        if depth >= self.0.len() {
            self.0.resize_with(depth + 1, Vec::new);
        }
        self.0[depth].push(number);
    }
}
