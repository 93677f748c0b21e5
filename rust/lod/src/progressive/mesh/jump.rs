//! How a mesh becomes one far from it: all splits at once, in the order of memory.
//!
//! A cut is closed, so a bit a number says which splits are made and which vertices there are, and the vertex at a corner is
//! the last one up to its leaf, as on a device (`device`). The rest follows from keys, which fall along the trees: numbers
//! are those of an in-order walk, so each tree is the Cartesian tree of its keys (Vuillemin 1980). The vertex that a split
//! has split begins at the last number before it that has a greater key; and of two vertices next to each other, the split
//! of the one is what the other comes from, whichever has the lesser key. No tree is walked through, and only what is in
//! the mesh before or after is touched.

use std::sync::atomic::Ordering::Relaxed;

use relievo_core::Context;

use super::active::ActiveMesh;
use super::bitset::{BitSet, bits};
use crate::connectivity::NONE;
use crate::progressive::build::cut::Cut;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::build::recording::Key;

/// Words of [`BitSet`] of one task.
const CHUNK_LEN: usize = 256;
/// A split that is made or taken back by itself takes the time that this many vertices take, of the meshes before and
/// after together, where all is done at once.
const NEAR: usize = 16;
/// As many numbers of splits are looked at in the time that a vertex takes.
const LOOKED: usize = 8;

/// What a task has changed.
#[derive(Default)]
struct Changed {
    /// Splits that are made and taken back, with the vertices they split.
    splits: [Vec<[u32; 2]>; 2],
    triangles: usize,
    /// Corners at vertices of other tasks.
    outside: Vec<u32>,
}

impl ActiveMesh {
    /// The vertices of its cut, if there are so many other ones that [`Self::jump`] is the shorter way there.
    pub(crate) fn far(&self, context: &Context) -> Option<BitSet> {
        let whole = &*self.whole;
        let is_far = |splits: usize, vertices: usize| NEAR * splits > vertices + whole.splits.len() / LOOKED;
        let (count, about) = (self.triangle_count(), self.cut.triangles_about(whole));
        let most = about.into_iter().map(|then| then.abs_diff(count)).max().unwrap_or(0);
        if self.moves.is_some() || !is_far(most, self.vertex_count()) {
            return None;
        }
        let words = words_of_all(context, whole, self.cut);
        let other = (0..).zip(&words).map(|(at, word)| (word ^ self.there.word(at)).count_ones() as usize).sum();
        let vertices = words.iter().map(|word| word.count_ones() as usize).sum::<usize>();
        is_far(other, self.vertex_count() + vertices).then(|| BitSet::of_words(words))
    }

    /// Becomes the mesh of its cut, which has the vertices `there`, if nothing was edited. Returns how many splits were made
    /// and taken back.
    pub(crate) fn jump(&mut self, context: &Context, there: BitSet) -> [usize; 2] {
        let whole = self.whole.clone();
        let before = std::mem::replace(&mut self.there, there);
        let parts = before.word_count().div_ceil(CHUNK_LEN);
        let mesh = &*self;
        let changed = context.map(parts, |part| {
            let mut changed = Changed::default();
            mesh.jump_vertices(&before, part, &mut changed);
            mesh.jump_triangles(&before, part, &mut changed);
            changed
        });
        if let Some(last) = mesh.there.last_up_to(whole.splits.len() as u32 - 1) {
            mesh.slots[last as usize].node.store(own_node(&whole, last), Relaxed);
        }
        // All lists have what is of their own task now.
        context.map(parts, |part| {
            for corner in &changed[part].outside {
                mesh.insert(*corner, mesh.corners[*corner as usize].vertex.load(Relaxed));
            }
        });
        let at_end = whole.base_faces.iter().filter(|face| **face as usize >= 2 * whole.splits.len());
        let mut triangles = 0;
        for face in at_end {
            for (corner, leaf) in (3 * face..).zip(whole.faces[*face as usize]) {
                mesh.insert(corner, mesh.there.last_up_to(leaf).unwrap_or(NONE));
            }
            triangles += 1;
        }
        if mesh.wedges.is_some() {
            for (way, change) in [(1, Self::merge_wedges as fn(&Self, u32)), (0, Self::split_wedges)] {
                context.map(parts, |part| changed[part].splits[way].iter().for_each(|[split, _]| change(mesh, *split)));
            }
        }
        self.triangles = triangles + changed.iter().map(|changed| changed.triangles).sum::<usize>();
        let [made, gone] = [0, 1].map(|way| changed.iter().map(|changed| changed.splits[way].len()).sum::<usize>());
        self.vertices = self.vertices + made - gone;
        self.blocks.clear();
        if let Some(places) = &mut self.places {
            changed.into_iter().for_each(|changed| places.note_splits(changed.splits.into_iter().flatten()));
        }
        [made, gone]
    }

    /// Brings the vertices of a task up to date but for the split that its last one comes from.
    fn jump_vertices(&self, before: &BitSet, part: usize, changed: &mut Changed) {
        let whole = &*self.whole;
        // Vertices that can still be split further on, with the keys they come from.
        let mut open = Vec::new();
        let mut at = (64 * (part * CHUNK_LEN) as u32).checked_sub(1).and_then(|last| self.there.last_up_to(last));
        while let Some(vertex) = at {
            open.push((key_of(whole, vertex), vertex));
            at = split_vertex(whole, vertex);
        }
        open.reverse();
        for word in words(before, part) {
            let [before, now] = [before.word(word), self.there.word(word)];
            for split in bits(word, before & !now) {
                let slot = &self.slots[split as usize];
                changed.splits[1].push([split, slot.target.load(Relaxed)]);
                [&slot.node, &slot.first, &slot.target].into_iter().for_each(|entry| entry.store(NONE, Relaxed));
            }
            for vertex in bits(word, now) {
                let key = key_of(whole, vertex);
                if let Some((last_key, last)) = open.last() {
                    let node = if *last_key > key { 2 * vertex } else { own_node(whole, *last) };
                    self.slots[*last as usize].node.store(node, Relaxed);
                }
                while open.pop_if(|(last, _)| *last < key || key == BASE).is_some() {}
                let target = open.last().map_or(NONE, |(_, vertex)| *vertex);
                open.push((key, vertex));
                let slot = &self.slots[vertex as usize];
                slot.first.store(NONE, Relaxed);
                slot.target.store(target, Relaxed);
                if before >> (vertex % 64) & 1 == 0 {
                    changed.splits[0].push([vertex, target]);
                }
            }
        }
    }

    /// Brings the triangles of the splits of a task up to date, and the lists of its vertices but for corners outside.
    fn jump_triangles(&self, before: &BitSet, part: usize, changed: &mut Changed) {
        let own = 64 * (part * CHUNK_LEN) as u32..64 * ((part + 1) * CHUNK_LEN) as u32;
        for word in words(before, part) {
            let [before, now] = [before.word(word), self.there.word(word)];
            for split in bits(word, before | now) {
                let is_there = now >> (split % 64) & 1 != 0;
                for face in [2 * split, 2 * split + 1] {
                    let leaves = self.whole.faces[face as usize];
                    if leaves[0] == NONE {
                        continue;
                    }
                    for (number, leaf) in (3 * face..).zip(leaves) {
                        let corner = &self.corners[number as usize];
                        let vertex = if is_there { self.there.last_up_to(leaf).unwrap_or(NONE) } else { NONE };
                        corner.vertex.store(vertex, Relaxed);
                        if own.contains(&vertex) {
                            let first = &self.slots[vertex as usize].first;
                            corner.following.store(first.load(Relaxed), Relaxed);
                            first.store(number, Relaxed);
                        } else if is_there {
                            changed.outside.push(number);
                        }
                    }
                    changed.triangles += usize::from(is_there);
                }
            }
        }
    }
}

/// In place of the key of a base vertex.
const BASE: Key = Key(u32::MAX);

/// Which splits a cut has, and base vertices, by their bits.
pub fn words_of_all(context: &Context, whole: &Progressive, cut: Cut) -> Vec<u64> {
    context.map(whole.splits.len().div_ceil(64 * CHUNK_LEN), |part| words_of(whole, cut, part)).concat()
}

/// Which splits of a task a cut has, and base vertices.
fn words_of(whole: &Progressive, cut: Cut, part: usize) -> Vec<u64> {
    let all = &whole.splits[64 * CHUNK_LEN * part..whole.splits.len().min(64 * CHUNK_LEN * (part + 1))];
    let first = (64 * CHUNK_LEN * part) as u32;
    let has = |number: u32, key: Key| u64::from(cut.has(key, number)) << (number % 64);
    let words = (first..).step_by(64).zip(all.chunks(64));
    let mut words: Vec<u64> = words
        .map(|(first, splits)| (first..).zip(splits).fold(0, |word, (at, split)| word | has(at, split.key)))
        .collect();
    let base = &whole.base_vertices;
    let base = &base[base.partition_point(|leaf| *leaf < first)..];
    for leaf in base.iter().map(|leaf| leaf - first).take_while(|leaf| (*leaf as usize) < all.len()) {
        words[leaf as usize / 64] |= 1 << (leaf % 64);
    }
    words
}

/// The words of a task.
fn words(set: &BitSet, part: usize) -> std::ops::Range<u32> {
    (part * CHUNK_LEN) as u32..set.word_count().min((part + 1) * CHUNK_LEN) as u32
}

fn is_base(whole: &Progressive, vertex: u32) -> bool {
    whole.parent(vertex) == NONE
}

/// The key of the split of a number.
fn key_of(whole: &Progressive, number: u32) -> Key {
    if is_base(whole, number) { BASE } else { whole.splits[number as usize].key }
}

/// What a vertex comes from whose number has been split no more since: as [`ActiveMesh::node`].
fn own_node(whole: &Progressive, vertex: u32) -> u32 {
    if is_base(whole, vertex) { 2 * vertex } else { 2 * vertex + 1 }
}

/// The vertex that a split splits, or none in the place of a base vertex.
fn split_vertex(whole: &Progressive, mut split: u32) -> Option<u32> {
    loop {
        match whole.parent(split) {
            NONE => return None,
            from if from % 2 == 1 || is_base(whole, from / 2) => return Some(from / 2),
            from => split = from / 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use relievo_core::progress::Silent;

    use super::*;
    use crate::progressive::BuildOptions;

    /// Every vertex with its node, the split of its number and its corners, and the vertex at every corner.
    fn state(mesh: &ActiveMesh) -> (Vec<(u32, u32, u32, Vec<u32>)>, Vec<u32>) {
        let vertex = |vertex: u32| {
            let mut faces: Vec<u32> = mesh.faces_at(vertex).collect();
            faces.sort_unstable();
            (vertex, mesh.node(vertex), mesh.target(vertex), faces)
        };
        assert!((0..mesh.slots.len() as u32).filter(|at| mesh.node(*at) != NONE).eq(mesh.vertices()));
        (mesh.vertices().map(vertex).collect(), mesh.corners.iter().map(|corner| corner.vertex.load(Relaxed)).collect())
    }

    #[test]
    fn a_jump_is_all_steps_at_once() {
        let side = 150u32;
        let place = |at: u32| {
            let [x, y] = [at % side, at / side].map(|at| at as f32 / side as f32);
            // Half of it is flat, where all splits deviate as much.
            [x, y, if x < 0.5 { 0.0 } else { 0.1 * (9.0 * x).sin() * (7.0 * y).cos() }]
        };
        let points: Vec<_> = (0..side * side).map(place).collect();
        let corners = |at: u32| [[at, at + 1, at + side + 1], [at, at + side + 1, at + side]];
        let quads = (0..side * (side - 1)).filter(|at| at % side != side - 1);
        let triangles: Vec<_> = quads.flat_map(corners).collect();
        let context = Context::new(&Default::default()).unwrap();
        for faces in [40, 10_000] {
            let options = BuildOptions { faces, ..BuildOptions::default() };
            let built = Arc::new(Progressive::build(&context, &points, &triangles, &options, &mut Silent).unwrap());
            let few = |faces| Cut::of_faces(&built, faces);
            let cuts = [Cut::BASE, few(12_000), few(30_000), Cut::of_error(1e-3), Cut::of_error(0.0), Cut::FINEST];
            for (from, to) in cuts.iter().flat_map(|from| cuts.iter().map(move |to| (*from, *to))) {
                let [mut walked, mut jumped] = [0; 2].map(|_| ActiveMesh::new(&built));
                for mesh in [&mut walked, &mut jumped] {
                    mesh.cut = from;
                    mesh.walk(&context, true, false);
                    mesh.cut = to;
                }
                let words =
                    (0..jumped.there.word_count().div_ceil(CHUNK_LEN)).flat_map(|part| words_of(&built, to, part));
                let there = BitSet::of_words(words.collect());
                assert_eq!(jumped.jump(&context, there), walked.walk(&context, true, true));
                assert_eq!(jumped.vertex_count(), walked.vertex_count());
                assert_eq!(jumped.triangle_count(), walked.triangle_count());
                assert!(state(&jumped) == state(&walked));
            }
            let mut mesh = ActiveMesh::new(&built);
            mesh.cut = Cut::FINEST;
            assert!(mesh.far(&context).is_some_and(|there| there.iter().count() == points.len()));
        }
    }
}
