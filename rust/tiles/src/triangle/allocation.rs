//! Which faces and edges of a triangle mesh have blocks: given and taken away, all with their edges.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 4
//! and 6. A face and its edges get their blocks together or not at all; an edge gives its block back when no face with
//! a block uses it. A face keeps its block while anything inside, on an edge or at a corner of it is not blank: without
//! one it would follow its edges and corners as far as the opposite side. Units: bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use super::block::TriangleBlock;
use super::change::TriangleSets;
use super::channel::TriangleChannel;
use super::field::{Entry, TriangleClass, TriangleField, barycentric};
use super::pattern::{Pattern, Slot};
use crate::store::heap::Class;
use crate::store::paging::Paged;
use crate::store::slot;
use crate::texel::Texel;

/// A block that an edit makes: of a face or an edge.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    class: TriangleClass,
    element: u32,
}

impl Wanted {
    fn block(&self) -> TriangleBlock {
        if self.class.face { TriangleBlock::Face(self.element) } else { TriangleBlock::Edge(self.element) }
    }
}

/// The blocks of `faces` and their edges that are there.
fn there<T: Texel>(field: &TriangleField<T>, faces: &[u32]) -> BTreeSet<TriangleBlock> {
    let edges = faces.iter().flat_map(|face| field.topology().edges_of(*face)).map(TriangleBlock::Edge);
    let blocks = faces.iter().copied().map(TriangleBlock::Face).chain(edges);
    blocks.filter(|block| field.block(*block).is_some()).collect()
}

impl<T: Texel> TriangleChannel<T> {
    /// Gives faces blocks of `pattern`, and takes others' away. Nothing reads otherwise where a block is made, but for
    /// rounding. Faces that already are as wished are left out. Returns the faces the budget refused, ascending. With
    /// pages, the blocks edited longest ago make room.
    ///
    /// # Errors
    /// Fails, and does nothing, if a face does not exist, the pattern is not the finest, half or a quarter of it, or a
    /// page cannot be read.
    #[inline(never)]
    pub fn apply(&mut self, context: &Context, pattern: Pattern, sets: &TriangleSets) -> Result<Vec<u32>> {
        let finest = self.field.pattern().segments();
        if ![1, 2, 4].iter().any(|part| pattern.segments() * part == finest) {
            return Err(Error::invalid(format!("the mesh has no level of {} segments", pattern.segments()))
                .advise(format!("use {finest}, {} or {}", finest / 2, finest / 4)));
        }
        self.check_faces(sets.allocate.iter().chain(&sets.deallocate))?;
        self.report_fault()?;
        if self.blocks.paging.count > 0 {
            let coarser = |face: &&u32| self.field.face_pattern(**face).is_none_or(|own| own < pattern);
            let made: Vec<u32> = sets.allocate.iter().filter(coarser).copied().collect();
            self.check_pages(there(&self.field, &made))?;
        }
        self.blocks.revision += 1;
        self.deallocate(&sets.deallocate);
        let refused = self.allocate(context, pattern, sets);
        self.trim();
        Ok(refused)
    }

    #[inline(never)]
    pub(super) fn deallocate(&mut self, faces: &[u32]) {
        let topology = self.field.topology().clone();
        let mut freed = Vec::new();
        for face in faces {
            if !self.field.is_allocated(*face) {
                continue;
            }
            freed.extend(self.take_block(TriangleBlock::Face(*face)));
            self.changed.faces.push(*face);
            for edge in topology.edges_of(*face) {
                if topology.faces_along(edge).any(|(face, _)| self.field.is_allocated(face)) {
                    continue;
                }
                if self.field.edge_pattern(edge).is_some() {
                    freed.extend(self.take_block(TriangleBlock::Edge(edge)));
                    self.changed.edges.push(edge);
                }
            }
        }
        self.blocks.heap.free(&freed);
    }

    /// Fails if one of `faces` does not exist.
    pub(super) fn check_faces<'a>(&self, faces: impl IntoIterator<Item = &'a u32>) -> Result<()> {
        let count = self.field.topology().face_count();
        match faces.into_iter().find(|face| **face as usize >= count) {
            Some(face) => {
                Err(Error::invalid(format!("face {face} does not exist")).advise(format!("use 0 to {}", count - 1)))
            }
            None => Ok(()),
        }
    }

    #[inline(never)]
    fn allocate(&mut self, context: &Context, pattern: Pattern, sets: &TriangleSets) -> Vec<u32> {
        let coarser = |own: Option<Pattern>| own.is_none_or(|own| own < pattern);
        let mut faces: Vec<u32> =
            sets.allocate.iter().copied().filter(|face| coarser(self.field.face_pattern(*face))).collect();
        faces.sort_unstable();
        faces.dedup();
        let (wanted, refused) = match self.clear_the_way(pattern, &faces) {
            Some(granted) => granted,
            None => {
                self.lose_for(pattern, &faces, sets);
                self.granted(pattern, &faces, self.blocks.heap.bytes())
            }
        };
        let field = &self.field;
        let blocks = context.map(wanted.len(), |index| values_of(field, wanted[index].class, wanted[index].element));
        let freed: Vec<_> = wanted.iter().filter_map(|wanted| self.take_block(wanted.block())).collect();
        self.blocks.heap.free(&freed);
        let classes: Vec<TriangleClass> = wanted.iter().map(|wanted| wanted.class).collect();
        for ((wanted, texels), id) in wanted.iter().zip(blocks).zip(self.blocks.heap.allocate(&classes)) {
            let version = self.blocks.revision;
            if let (Some(id), Some(entry)) = (id, self.field.block_mut(wanted.block())) {
                *entry = Some(Entry { texels: slot::Slot::Here(texels), id, version });
                self.mark(wanted.block());
            }
        }
        refused
    }

    /// With pages: makes room for the blocks of `faces`, and says which are granted and which of the faces refused.
    /// `None` if there are no pages, or no room for more of them.
    fn clear_the_way(&mut self, pattern: Pattern, faces: &[u32]) -> Option<(Vec<Wanted>, Vec<u32>)> {
        self.pager()?;
        let there = there(&self.field, faces);
        let size = |block: &TriangleBlock| {
            self.field.block(*block).map_or(0, |entry| self.blocks.heap.bytes_of(entry.id.class))
        };
        // Together with what the faces have, on pages too.
        let granted = self.granted(pattern, faces, there.iter().map(size).sum());
        let keep: Vec<u32> = there.iter().map(|block| block.number(self.field.topology())).collect();
        self.make_room(self.more_bytes(&granted.0), &keep).then_some(granted)
    }

    /// Bytes that the heap hands out for `wanted` beyond what it takes back.
    fn more_bytes(&self, wanted: &[Wanted]) -> u64 {
        let more: u64 = wanted.iter().map(|wanted| self.blocks.heap.bytes_of(wanted.class)).sum();
        let less: u64 = wanted.iter().map(|wanted| self.bytes_here(wanted.block())).sum();
        more.saturating_sub(less)
    }

    /// Loses faces until `faces` of `sets` have room for blocks of `pattern`, as far as there are any.
    fn lose_for(&mut self, pattern: Pattern, faces: &[u32], sets: &TriangleSets) {
        if self.expendable.is_empty() || faces.is_empty() {
            return;
        }
        let mut used = [sets.allocate.as_slice(), &sets.modify].concat();
        used.sort_unstable();
        self.expendable.retain(|face| used.binary_search(&face.face).is_err());
        // An edge that goes with a face may be one that is wanted.
        loop {
            let needed = self.more_bytes(&self.granted_within(u64::MAX, pattern, faces, 0).0);
            let full = |own: &Self| own.blocks.heap.bytes().saturating_add(needed) > own.blocks.heap.budget();
            if !full(self) {
                return;
            }
            while full(self) {
                let Some(face) = self.expendable.pop() else { return };
                // What is on a page takes no room.
                if self.bytes_here(TriangleBlock::Face(face.face)) > 0 && face.is_untouched(&self.field) {
                    self.lose(&[face.face]);
                }
            }
        }
    }

    /// The blocks of those of `faces` that fit the budget beside `bytes`, among which is what they have, and the other
    /// faces.
    fn granted(&self, pattern: Pattern, faces: &[u32], bytes: u64) -> (Vec<Wanted>, Vec<u32>) {
        self.granted_within(self.blocks.heap.budget(), pattern, faces, bytes)
    }

    /// As [`Self::granted`] within another budget.
    fn granted_within(&self, budget: u64, pattern: Pattern, faces: &[u32], mut bytes: u64) -> (Vec<Wanted>, Vec<u32>) {
        let coarser = |own: Option<Pattern>| own.is_none_or(|own| own < pattern);
        let (mut refused, mut wanted) = (Vec::new(), Vec::new());
        let mut edges = BTreeMap::new();
        let size = |class: TriangleClass| (class.values() * size_of::<T>()) as u64;
        let class = |face: bool| TriangleClass { face, pattern };
        for face in faces.iter().copied() {
            let own = self.field.topology().edges_of(face);
            let new =
                own.into_iter().filter(|edge| coarser(self.field.edge_pattern(*edge)) && !edges.contains_key(edge));
            let new: Vec<u32> = new.collect();
            let old = |edge: &u32| {
                self.field.edge_pattern(*edge).map_or(0, |pattern| size(TriangleClass { face: false, pattern }))
            };
            let replaced =
                self.field.face_pattern(face).map_or(0, |pattern| size(TriangleClass { face: true, pattern }));
            let more = size(class(true)) + new.len() as u64 * size(class(false));
            let less = replaced + new.iter().map(old).sum::<u64>();
            // What is replaced is smaller.
            let then = bytes.saturating_add(more - less);
            if then > budget {
                refused.push(face);
                continue;
            }
            bytes = then;
            edges.extend(new.into_iter().map(|edge| (edge, ())));
            wanted.push(Wanted { class: class(true), element: face });
        }
        wanted.extend(edges.into_keys().map(|element| Wanted { class: class(false), element }));
        (wanted, refused)
    }

    /// Gives edges blocks of other patterns than they have. Returns whether the budget allowed all.
    #[inline(never)]
    pub(super) fn set_edges(&mut self, context: &Context, edges: &[(u32, Pattern)]) -> bool {
        let class = |pattern: Pattern| TriangleClass { face: false, pattern };
        let field = &self.field;
        let blocks = context.map(edges.len(), |index| {
            let (element, pattern) = edges[index];
            values_of(field, class(pattern), element)
        });
        let mut keep: Vec<u32> =
            edges.iter().map(|(edge, _)| TriangleBlock::Edge(*edge).number(self.field.topology())).collect();
        keep.sort_unstable();
        let mut all = true;
        for ((edge, pattern), texels) in edges.iter().zip(blocks) {
            all &= self.put(TriangleBlock::Edge(*edge), class(*pattern), texels, &keep);
        }
        all
    }

    /// Gives a face or an edge a block of `class` in place of the one it may have, with `values`. Returns whether the
    /// budget allowed it, with room that others than `keep`, which ascend, may make.
    pub(super) fn put(&mut self, block: TriangleBlock, class: TriangleClass, values: Arc<[T]>, keep: &[u32]) -> bool {
        let (before, now) = (self.bytes_here(block), self.blocks.heap.bytes_of(class));
        let fits = self.blocks.heap.bytes() - before + now <= self.blocks.heap.budget();
        if !fits && !self.make_room(now.saturating_sub(before), keep) {
            return false;
        }
        let old = self.take_block(block);
        self.blocks.heap.free(old.as_slice());
        self.create(block, class, values);
        true
    }

    /// Gives back the blocks of those of `faces` that are blank inside, on their edges and at their corners. Returns the
    /// faces, ascending.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a page could not be read or written before.
    #[inline(never)]
    pub fn reclaim(&mut self, context: &Context, faces: &[u32]) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let (field, blank) = (&self.field, self.field.blank());
        // What cannot be read is not empty.
        let empty = |block: TriangleBlock| {
            let held = field.try_held(block);
            held.is_ok_and(|held| held.is_none_or(|values| values.iter().all(|value| value.is_blank(blank))))
        };
        let idle = |face: &u32| {
            field.is_allocated(*face)
                && topology.face(*face).iter().all(|vertex| field.vertex(*vertex).is_blank(blank))
                && empty(TriangleBlock::Face(*face))
                && topology.edges_of(*face).into_iter().all(|edge| empty(TriangleBlock::Edge(edge)))
        };
        let mut gone: Vec<u32> =
            faces.iter().copied().filter(|face| (*face as usize) < topology.face_count()).filter(idle).collect();
        gone.sort_unstable();
        gone.dedup();
        let pattern = self.field.pattern();
        self.apply(context, pattern, &TriangleSets { deallocate: gone.clone(), ..Default::default() })?;
        Ok(gone)
    }
}

/// What the block of an element reads as before it has it.
pub(super) fn values_of<T: Texel>(field: &TriangleField<T>, class: TriangleClass, element: u32) -> Arc<[T]> {
    let TriangleClass { face, pattern } = class;
    if !face {
        let segments = pattern.segments();
        let value = |step: u32| T::nearest(field.on_edge(element, step as f32 / segments as f32));
        return (1..segments).map(value).collect();
    }
    if field.is_blank(element) {
        return vec![field.blank(); pattern.face_values()].into();
    }
    let value = |index: u32| {
        let node = pattern.at_slot(Slot::Inside(index));
        T::nearest(field.value(element, barycentric(pattern, node)))
    };
    (0..pattern.face_values() as u32).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel::Rgba8;
    use crate::triangle::TriangleOptions;
    use crate::triangle::shapes::{self, channel, fill, random, sets};
    use proptest::prelude::*;
    use relievo_surface::TriangleTopology;
    use std::collections::BTreeSet;

    #[test]
    fn a_face_and_its_edges_take_the_bytes_of_the_formula() {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let vertices = 2 * channel.field().topology().vertex_count() as u64;
        assert_eq!(channel.bytes(), vertices);
        let pattern = channel.field().pattern();
        assert!(channel.apply(&context, pattern, &sets(&[0])).unwrap().is_empty());
        assert_eq!(channel.bytes(), vertices + 2 * (169 + 3 * 15));
        // The neighbour across the diagonal shares an edge.
        assert!(channel.apply(&context, pattern, &sets(&[0, 1])).unwrap().is_empty());
        assert_eq!(channel.bytes(), vertices + 2 * (2 * 169 + 5 * 15));
        let gone = TriangleSets { deallocate: vec![0], ..Default::default() };
        channel.apply(&context, pattern, &gone).unwrap();
        assert_eq!(channel.bytes(), vertices + 2 * (169 + 3 * 15));
        assert_eq!(channel.reclaim(&context, &[0, 1, 2, 999]).unwrap(), [1]);
        assert_eq!(channel.bytes(), vertices);
        let full = channel.full_bytes();
        let all: Vec<u32> = (0..channel.field().topology().face_count() as u32).collect();
        channel.apply(&context, pattern, &sets(&all)).unwrap();
        assert_eq!(channel.bytes(), full);
    }

    #[test]
    fn edge_blocks_grow_two_for_each_face_block_in_a_table_of_their_own() {
        let mut tables = BTreeSet::new();
        for segments in [2, 4, 8, 16, 32, 64] {
            let [face, edge] =
                [true, false].map(|face| TriangleClass { face, pattern: Pattern::new(segments).unwrap() });
            assert_eq!(edge.group(), 2 * face.group());
            assert!(tables.insert(face.index()) && tables.insert(edge.index()));
        }
        assert!(tables.iter().all(|table| *table < TriangleClass::COUNT));
    }

    #[test]
    fn what_does_not_fit_is_refused_whole() {
        let context = Context::serial();
        let small = channel(16, 1 << 20);
        let vertices = small.bytes();
        let one = 2 * (169 + 3 * 15);
        let mut channel = channel(16, vertices + one + 2 * 169);
        let pattern = channel.field().pattern();
        assert_eq!(channel.apply(&context, pattern, &sets(&[0, 1, 2])).unwrap(), [1, 2]);
        assert_eq!(channel.bytes(), vertices + one);
        channel.set_budget(vertices + one + 2 * (169 + 2 * 15));
        assert_eq!(channel.apply(&context, pattern, &sets(&[0, 1, 2])).unwrap(), [2]);
        let topology = channel.field().topology().clone();
        let starved = TriangleOptions { segments: 16, budget: vertices - 1 };
        assert!(TriangleChannel::displacement(topology.clone(), &starved).is_err());
        for segments in [0, 4, 12, 128] {
            let options = TriangleOptions { segments, budget: 1 << 30 };
            assert!(TriangleChannel::displacement(topology.clone(), &options).is_err());
        }
        assert!(channel.apply(&context, Pattern::new(32).unwrap(), &sets(&[0])).is_err());
        assert!(channel.apply(&context, pattern, &sets(&[u32::MAX])).is_err());
    }

    #[test]
    fn nothing_reads_otherwise_where_a_block_is_made() {
        let context = Context::serial();
        let mut channel = channel(32, 1 << 20);
        let [fine, middle, coarse] = [32, 16, 8].map(|segments| Pattern::new(segments).unwrap());
        channel.apply(&context, coarse, &sets(&[4])).unwrap();
        channel.apply(&context, fine, &sets(&[5])).unwrap();
        fill(&mut channel, random(3));
        let places: Vec<[f32; 3]> =
            (0..=30).flat_map(|i| (0..=30 - i).map(move |j| [i, j, 30 - i - j].map(|k| k as f32 / 30.0))).collect();
        let faces = channel.field().topology().face_count() as u32;
        let read = |channel: &TriangleChannel| -> Vec<f64> {
            (0..faces)
                .flat_map(|face| places.iter().map(move |at| (face, at)))
                .map(|(face, at)| channel.field().value(face, *at))
                .collect()
        };
        let before = read(&channel);
        // At the vertices of the finer pattern it is what it was; the surface between them is another.
        let old = channel.field().clone();
        for pattern in [middle, fine] {
            let before = channel.field().clone();
            channel.apply(&context, pattern, &sets(&[4, 7, 9])).unwrap();
            for face in 0..faces {
                let Some(pattern) = channel.field().face_pattern(face) else { continue };
                for index in 0..pattern.face_values() as u32 {
                    let node = pattern.at_slot(Slot::Inside(index));
                    let [now, then] = [channel.field(), &before].map(|field| field.at(face, pattern, node));
                    assert!((now - then).abs() < 4e-3, "face {face} {now} {then}");
                }
            }
        }
        let furthest = read(&channel).iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(furthest < 4.0, "{furthest}");
        // Values that were there are the same to the bit.
        for index in 0..coarse.face_values() as u32 {
            let node = coarse.at_slot(Slot::Inside(index));
            let refined = middle.refined(coarse.refined(node));
            let (Slot::Inside(now), Some(block)) = (fine.slot(refined), channel.field().face(4)) else { panic!() };
            assert_eq!(block[now as usize], old.face(4).unwrap()[index as usize]);
        }
    }

    #[test]
    fn colours_of_one_colour_stay_that_colour() {
        let context = Context::serial();
        let topology = Arc::new(TriangleTopology::of_mesh(&shapes::sail(2)).unwrap());
        let grey = Rgba8([120, 130, 140, 255]);
        let mut channel =
            TriangleChannel::blank(topology, grey, &TriangleOptions { segments: 16, budget: 1 << 20 }).unwrap();
        channel.apply(&context, Pattern::new(8).unwrap(), &sets(&[2])).unwrap();
        channel.apply(&context, Pattern::new(16).unwrap(), &sets(&[2, 3])).unwrap();
        assert!(channel.field().face(2).unwrap().iter().all(|value| *value == grey));
        for face in 0..4 {
            assert_eq!(Rgba8::nearest(channel.field().value(face, [0.2, 0.35, 0.45])), grey);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Against a model: the pattern of every face, and of every edge the finest it was ever given with.
        #[test]
        fn blocks_are_those_of_a_model(seed: u64, budget in 0u64..60_000) {
            let context = Context::serial();
            let mut channel = channel(32, 1 << 30);
            let vertices = channel.bytes();
            channel.set_budget(vertices + budget);
            let topology = channel.field().topology().clone();
            let faces = topology.face_count() as u32;
            let mut random = random(seed);
            let mut model: BTreeMap<u32, Pattern> = BTreeMap::new();
            let mut edges: BTreeMap<u32, Pattern> = BTreeMap::new();
            for _ in 0..400 {
                let list: BTreeSet<u32> = (0..random(6)).map(|_| random(faces)).collect();
                if random(3) > 0 {
                    let pattern = Pattern::new([8, 16, 32][random(3) as usize]).unwrap();
                    let refused = channel.apply(&context, pattern, &sets(&list.iter().copied().collect::<Vec<_>>())).unwrap();
                    prop_assert!(refused.iter().all(|face| list.contains(face)));
                    for face in list.iter().filter(|face| refused.binary_search(face).is_err()) {
                        let own = model.entry(*face).or_insert(pattern);
                        *own = pattern.max(*own);
                        for edge in topology.edges_of(*face) {
                            let own = edges.entry(edge).or_insert(pattern);
                            *own = pattern.max(*own);
                        }
                    }
                } else {
                    let gone = TriangleSets { deallocate: list.iter().copied().collect(), ..Default::default() };
                    channel.apply(&context, channel.field().pattern(), &gone).unwrap();
                    model.retain(|face, _| !list.contains(face));
                    let used: BTreeSet<u32> = model.keys().flat_map(|face| topology.edges_of(*face)).collect();
                    edges.retain(|edge, _| used.contains(edge));
                }
                let field = channel.field();
                prop_assert!(field.allocated().eq(model.keys().copied()));
                prop_assert!(field.allocated_edges().eq(edges.keys().copied()));
                prop_assert!(model.iter().all(|(face, pattern)| field.face_pattern(*face) == Some(*pattern)));
                prop_assert!(edges.iter().all(|(edge, pattern)| field.edge_pattern(*edge) == Some(*pattern)));
                let values = model.values().map(|pattern| pattern.face_values()).sum::<usize>()
                    + edges.values().map(|pattern| pattern.edge_values()).sum::<usize>();
                prop_assert_eq!(channel.bytes(), vertices + 2 * values as u64);
                prop_assert!(channel.bytes() <= channel.budget());
            }
            let all: Vec<u32> = (0..faces).collect();
            channel.reclaim(&context, &all).unwrap();
            prop_assert_eq!(channel.bytes(), vertices);
        }
    }
}
