//! Blocks that are there for the sake of others, after blocks were put back one by one: those of the edges of a face, and
//! those of faces along an edge that is not blank.
//!
//! Some may be lost, given back since, or never made by an earlier version, which gave an edge one face with a block at
//! least. Units: bytes.

use std::collections::{BTreeMap, BTreeSet};

use relievo_core::{Context, Error, Result};

use super::block::TriangleBlock;
use super::change::{TriangleSets, TriangleValues};
use super::channel::TriangleChannel;
use super::pattern::Pattern;
use crate::store::paging::Paged;
use crate::texel::Texel;

impl<T: Texel> TriangleChannel<T> {
    /// Gives edges blocks as fine as those of their faces, takes blocks away from edges that no face uses, and gives blocks
    /// to faces along edges that are not blank, as far as the budget allows. Fails if it does not allow the edges.
    pub(super) fn mend(&mut self, context: &Context) -> Result<()> {
        let topology = self.field.topology();
        let of_faces = self.field.allocated().flat_map(|face| topology.edges_of(face));
        let edges: BTreeSet<u32> = self.field.allocated_edges().chain(of_faces).collect();
        self.mend_edges(context, &edges)?;
        self.mend_faces(context, &edges)
    }

    /// As [`Self::mend`], whatever the budget says, around `blocks` that were put back: what was there beside them then
    /// may have been given back since. Blank faces go with an edge that has no block any more.
    ///
    /// # Errors
    /// Fails if a page cannot be read or written.
    #[inline(never)]
    pub fn mend_around(&mut self, context: &Context, blocks: &[u32]) -> Result<()> {
        let topology = self.field.topology().clone();
        let edges: BTreeSet<u32> = TriangleBlock::change(&topology, blocks.iter().copied()).edges.into_iter().collect();
        let field = &self.field;
        let bare = edges.iter().filter(|edge| field.edge_pattern(**edge).is_none());
        let beside: BTreeSet<u32> = bare.flat_map(|edge| topology.faces_along(*edge)).map(|(face, _)| face).collect();
        let idle = |face: &u32| field.is_allocated(*face) && field.is_blank(*face);
        let idle: Vec<u32> = beside.into_iter().filter(idle).collect();
        self.deallocate(&idle);
        self.mend_edges_around(context, blocks)?;
        self.without_budget(|own| own.mend_faces(context, &edges))
    }

    /// As [`Self::mend_around`], of edges alone.
    pub(super) fn mend_edges_around(&mut self, context: &Context, blocks: &[u32]) -> Result<()> {
        let topology = self.field.topology();
        let change = TriangleBlock::change(topology, blocks.iter().copied());
        let of_faces = change.faces.iter().flat_map(|face| topology.edges_of(*face));
        let edges: BTreeSet<u32> = change.edges.iter().copied().chain(of_faces).collect();
        self.without_budget(|own| own.mend_edges(context, &edges))
    }

    /// Does something while the budget allows everything.
    pub(super) fn without_budget<R>(&mut self, work: impl FnOnce(&mut Self) -> R) -> R {
        let budget = self.budget();
        self.set_budget(u64::MAX);
        let done = work(self);
        self.set_budget(budget);
        done
    }

    fn mend_edges(&mut self, context: &Context, edges: &BTreeSet<u32>) -> Result<()> {
        let topology = self.field.topology().clone();
        self.blocks.revision += 1;
        let mut wanted: Vec<(u32, Pattern)> = Vec::new();
        for edge in edges {
            let finest = topology.faces_along(*edge).filter_map(|(face, _)| self.field.face_pattern(face)).max();
            let own = self.field.edge_pattern(*edge);
            match finest {
                Some(finest) if own < Some(finest) => wanted.push((*edge, finest)),
                None if own.is_some() => {
                    let freed = self.take_block(TriangleBlock::Edge(*edge));
                    self.blocks.heap.free(freed.as_slice());
                    self.changed.edges.push(*edge);
                }
                _ => {}
            }
        }
        let set = self.set_edges(context, &wanted);
        self.trim();
        self.report_fault()?;
        match set {
            true => Ok(()),
            false => Err(Error::memory("the blocks need more than their budget")
                .advise("raise the budget of the object's detail")),
        }
    }

    /// Gives faces without a block along those of `edges` that are not blank a blank block, as far as the budget allows.
    pub(super) fn mend_faces(&mut self, context: &Context, edges: &BTreeSet<u32>) -> Result<()> {
        let (field, topology, blank) = (&self.field, self.field.topology(), self.field.blank());
        // A face with a corner that is not blank goes by its corners.
        let is_bare = |face: &u32| {
            let corners = topology.face(*face);
            !field.is_allocated(*face) && corners.iter().all(|vertex| field.vertex(*vertex).is_blank(blank))
        };
        let mut wanted: BTreeMap<u32, Pattern> = BTreeMap::new();
        for edge in edges {
            let bare: Vec<u32> = topology.faces_along(*edge).map(|(face, _)| face).filter(is_bare).collect();
            let Some(pattern) = field.edge_pattern(*edge).filter(|_| !bare.is_empty()) else { continue };
            if field.edge(*edge).is_some_and(|values| values.iter().any(|value| !value.is_blank(blank))) {
                for face in bare {
                    let own = wanted.entry(face).or_insert(pattern);
                    *own = pattern.max(*own);
                }
            }
        }
        // Edges that were read from pages leave again.
        self.trim();
        self.report_fault()?;
        self.give_blank(context, &wanted)
    }

    /// Gives `faces` without a block one of the pattern behind each, blank inside and on edges that had none, as far as the
    /// budget allows. Fails if a page cannot be read or written.
    pub(super) fn give_blank(&mut self, context: &Context, faces: &BTreeMap<u32, Pattern>) -> Result<()> {
        if faces.is_empty() {
            return Ok(());
        }
        let topology = self.field.topology().clone();
        let bare = faces.keys().flat_map(|face| topology.edges_of(*face));
        let bare: BTreeSet<u32> = bare.filter(|edge| self.field.edge_pattern(*edge).is_none()).collect();
        for level in [2, 1, 0] {
            let pattern = self.field.pattern().coarser(level);
            let such = faces.iter().filter(|(_, own)| **own == pattern);
            let sets = TriangleSets { allocate: such.map(|(face, _)| *face).collect(), ..Default::default() };
            self.apply(context, pattern, &sets)?;
        }
        let (field, blank) = (&self.field, self.field.blank());
        let face = |face: &u32| Some((*face, vec![blank; field.face_pattern(*face)?.face_values()]));
        let edge = |edge: &u32| Some((*edge, vec![blank; field.edge_pattern(*edge)?.edge_values()]));
        let faces = faces.keys().filter_map(face).collect();
        let edges = bare.iter().filter_map(edge).collect();
        self.write(TriangleValues { faces, edges, ..Default::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::TriangleField;
    use crate::triangle::shapes::{channel, fill, random, sets};
    use half::f16;

    /// A channel of which the edge between two faces holds something and nothing else does, with these faces, and the edge.
    fn along() -> (TriangleChannel, [u32; 2], u32) {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let topology = channel.field().topology().clone();
        let inner = |edge: &u32| topology.faces_along(*edge).len() == 2;
        let edge = (0..topology.edge_count() as u32).find(inner).unwrap();
        let mut faces = topology.faces_along(edge).map(|(face, _)| face);
        let faces = [faces.next().unwrap(), faces.next().unwrap()];
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &sets(&faces)).unwrap();
        write(&mut channel, edge);
        (channel, faces, edge)
    }

    fn write(channel: &mut TriangleChannel, edge: u32) {
        let values = vec![f16::ONE; channel.field().edge_pattern(edge).unwrap().edge_values()];
        channel.write(TriangleValues { edges: vec![(edge, values)], ..Default::default() }).unwrap();
    }

    fn blocks(field: &TriangleField) -> Vec<(u32, Vec<u16>)> {
        let bits = |number: u32| {
            let block = TriangleBlock::of(field.topology(), number).unwrap();
            field.held(block).unwrap().iter().map(|value| value.to_bits()).collect()
        };
        field.blocks().into_iter().map(|number| (number, bits(number))).collect()
    }

    #[test]
    fn a_face_keeps_its_block_while_an_edge_of_it_holds_something() {
        let context = Context::serial();
        let (mut channel, faces, edge) = along();
        let bytes = channel.bytes();
        assert!(channel.reclaim(&context, &faces).unwrap().is_empty());
        assert_eq!(channel.bytes(), bytes);
        channel.write(TriangleValues { edges: vec![(edge, vec![f16::ZERO; 15])], ..Default::default() }).unwrap();
        assert_eq!(channel.reclaim(&context, &faces).unwrap(), faces);
        assert_eq!(channel.bytes(), 2 * channel.field().topology().vertex_count() as u64);
    }

    #[test]
    fn faces_along_an_edge_that_was_put_back_get_blank_blocks_and_lose_them_with_it() {
        let context = Context::serial();
        for segments in [16, 8, 4] {
            let (whole, faces, edge) = along();
            let mut whole = whole;
            if segments < 16 {
                let gone = TriangleSets { deallocate: faces.to_vec(), ..Default::default() };
                whole.apply(&context, whole.field().pattern(), &gone).unwrap();
                whole.apply(&context, Pattern::new(segments).unwrap(), &sets(&faces)).unwrap();
                write(&mut whole, edge);
            }
            let expected = blocks(whole.field());
            // As a build left it that gave one of the faces a block.
            let mut channel = whole.clone();
            let gone = TriangleSets { deallocate: vec![faces[1]], ..Default::default() };
            channel.apply(&context, channel.field().pattern(), &gone).unwrap();
            let lacking = channel.bytes();
            let topology = channel.field().topology().clone();
            let number = TriangleBlock::Edge(edge).number(&topology);
            let mut opened = channel.clone();
            opened.mend(&context).unwrap();
            assert_eq!(blocks(opened.field()), expected);
            let mut narrow = channel.clone();
            narrow.set_budget(lacking + 10);
            narrow.mend(&context).unwrap();
            assert_eq!(narrow.bytes(), lacking);
            // Put back by undo, whatever the budget says.
            narrow.mend_around(&context, &[number]).unwrap();
            assert_eq!(blocks(narrow.field()), expected);
            for block in blocks(channel.field()) {
                narrow.write_block(block.0, None).unwrap();
            }
            let put: Vec<u32> = blocks(channel.field()).into_iter().map(|(number, _)| number).collect();
            narrow.mend_around(&context, &put).unwrap();
            assert_eq!(blocks(narrow.field()), []);
        }
    }

    #[test]
    fn what_is_whole_is_left_alone() {
        let context = Context::serial();
        let mut channel = channel(16, 1 << 20);
        let all: Vec<u32> = (0..channel.field().topology().face_count() as u32).collect();
        channel.apply(&context, Pattern::new(8).unwrap(), &sets(&all)).unwrap();
        channel.apply(&context, Pattern::new(16).unwrap(), &sets(&[2, 3, 9])).unwrap();
        fill(&mut channel, random(3));
        let before = channel.field().clone();
        channel.mend(&context).unwrap();
        let numbers = channel.field().blocks();
        channel.mend_around(&context, &numbers).unwrap();
        assert_eq!(blocks(channel.field()), blocks(&before));
        assert_eq!(channel.field().changes(&before), Default::default());
    }
}
