//! Layers of a triangle mesh put on each other: the composite is a channel of its own, with a value at every vertex
//! where one of the layers has one, as fine there as the finest of them.
//!
//! Values are blended as those of tiles are, see [`crate::layers::composite`]. A layer is read where the composite has its
//! values, as [`TriangleField::value`] says: patterns of fewer segments are subsets, so that a coarser layer is linear
//! between its own. Units: object units, linear light.

use relievo_core::{Context, Result};
use relievo_document::Settings;

use super::block::TriangleBlock;
use super::change::{TriangleChange, TriangleSets, TriangleValues};
use super::channel::{TriangleChannel, TriangleOptions};
use super::field::{TriangleClass, TriangleField};
use super::pattern::{Node, Pattern, Slot};
use crate::layers::composite::{Layered, Sheet};
use crate::store::heap::Class;

/// A layer of a composite.
pub type TriangleSheet<'a, T> = Sheet<'a, TriangleField<T>>;

/// What `sheets`, from the lowest, come to over `background` at a vertex of a pattern laid over `face`.
pub fn blended<T: Layered>(
    sheets: &[TriangleSheet<'_, T>],
    background: T,
    face: u32,
    pattern: Pattern,
    node: Node,
) -> T::Sum {
    over(sheets, background, |sheet| sheet.field.texel(face, pattern, node))
}

/// What `sheets` come to where they have what `read` says.
fn over<T: Layered>(
    sheets: &[TriangleSheet<'_, T>],
    background: T,
    read: impl Fn(&TriangleSheet<'_, T>) -> T,
) -> T::Sum {
    let seen = sheets.iter().enumerate().filter(|(_, sheet)| sheet.settings.visible);
    seen.fold(background.sum(), |below, (index, sheet)| {
        let value = read(sheet).sum();
        // The lowest, where it is seen as a whole, is taken as it is.
        if index == 0 && sheet.settings == Settings::of(T::KIND) {
            value
        } else {
            T::blend(below, value, &sheet.settings)
        }
    })
}

impl<T: Layered> TriangleChannel<T> {
    /// A channel over the mesh of `field` with `segments` an edge, without blocks, that pages as that of `field` does.
    ///
    /// # Errors
    /// Fails as [`TriangleChannel::blank`] does, or if the store of pages fails.
    #[inline(never)]
    pub fn sized(field: &TriangleField<T>, segments: u32, blank: T, budget: u64) -> Result<Self> {
        let mut channel = Self::blank(field.topology().clone(), blank, &TriangleOptions { segments, budget })?;
        channel.page_to(field.pager.as_ref().map(|pager| pager.store.clone()))?;
        Ok(channel)
    }

    /// Makes `blocks` of a composite, and what is read from them, what `sheets`, from the lowest, come to over
    /// `background`. Faces are allocated where a sheet that is seen has them, and given back where none has. Returns
    /// faces that the budget refused.
    ///
    /// Faces for which a sheet has more segments than the composite get no block.
    ///
    /// # Errors
    /// Fails if a blended number is not finite, or a page cannot be read or written.
    #[inline(never)]
    pub fn compose(
        &mut self,
        context: &Context,
        sheets: &[TriangleSheet<'_, T>],
        background: T,
        blocks: &[u32],
    ) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let faces = TriangleBlock::change(&topology, blocks.iter().copied()).faces_shown(&topology);
        if self.page_store().is_none() {
            return self.compose_at_once(context, sheets, background, &faces);
        }
        // A part that has room with all its edges.
        let [face, edge] = [true, false].map(|face| TriangleClass { face, pattern: self.field.pattern() }.values());
        let part = self.blocks.heap.budget() / 4 / ((face + 3 * edge) * size_of::<T>()) as u64;
        let part = usize::try_from(part).unwrap_or(usize::MAX).max(1);
        let mut refused = Vec::new();
        for faces in faces.chunks(part) {
            refused.extend(self.compose_at_once(context, sheets, background, faces)?);
        }
        Ok(refused)
    }

    fn compose_at_once(
        &mut self,
        context: &Context,
        sheets: &[TriangleSheet<'_, T>],
        background: T,
        faces: &[u32],
    ) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let seen: Vec<&TriangleField<T>> =
            sheets.iter().filter(|sheet| sheet.settings.visible).map(|sheet| sheet.field).collect();
        let coarsest = self.field.pattern().coarser(2);
        let of_face = |face: u32| seen.iter().filter_map(|field| field.face_pattern(face)).max();
        let wanted = |face: u32| of_face(face).map(|pattern| pattern.max(coarsest));
        let unfit = |face: &u32| wanted(*face) != self.field.face_pattern(*face);
        let changing: Vec<u32> = faces.iter().copied().filter(unfit).collect();
        self.blocks.revision += 1;
        self.deallocate(&changing);
        let mut refused = Vec::new();
        for level in [2, 1, 0] {
            let pattern = self.field.pattern().coarser(level);
            let allocate = changing.iter().copied().filter(|face| wanted(*face) == Some(pattern)).collect();
            refused.extend(self.apply(context, pattern, &TriangleSets { allocate, ..Default::default() })?);
        }
        refused.sort_unstable();
        let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
        edges.sort_unstable();
        edges.dedup();
        // An edge may be finer than its faces, because a finer one was there.
        let other = edges.iter().filter_map(|edge| {
            let own = self.field.edge_pattern(*edge)?;
            let along = topology.faces_along(*edge).filter_map(|(face, _)| self.field.face_pattern(face)).max();
            let finest = seen.iter().filter_map(|field| field.edge_pattern(*edge)).max().max(along)?;
            (own != finest.max(coarsest)).then_some((*edge, finest.max(coarsest)))
        });
        let other: Vec<(u32, Pattern)> = other.collect();
        self.set_edges(context, &other);

        let field = &self.field;
        let value = |face: u32, pattern: Pattern, slot: Slot| {
            T::of_sum(blended(sheets, background, face, pattern, pattern.at_slot(slot)))
        };
        let filled: Vec<u32> = faces.iter().copied().filter(|face| field.is_allocated(*face)).collect();
        let of_faces = context.map(filled.len(), |index| {
            let face = filled[index];
            let pattern = field.face_pattern(face)?;
            let inside = 0..pattern.face_values() as u32;
            Some((face, inside.map(|index| value(face, pattern, Slot::Inside(index))).collect::<Vec<T>>()))
        });
        // What lies beside a face that the budget refused would drag it along.
        let lacks = |edge: u32| {
            let mut along = topology.faces_along(edge);
            along.any(|(face, _)| !field.is_allocated(face) && wanted(face).is_some())
        };
        let of_edges = context.map(edges.len(), |index| {
            let edge = edges[index];
            let pattern = field.edge_pattern(edge)?;
            if lacks(edge) {
                return Some((edge, vec![field.blank(); pattern.edge_values()]));
            }
            let (face, side) = topology.faces_along(edge).next()?;
            let (segments, reversed) = (pattern.segments(), topology.side(face, side).reversed);
            let step = |step: u32| if reversed { segments - step } else { step };
            let values = (1..segments).map(|at| value(face, pattern, Slot::Side(side, step(at))));
            Some((edge, values.collect::<Vec<T>>()))
        });
        let mut vertices: Vec<u32> = faces.iter().flat_map(|face| topology.face(*face)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        // So would a vertex that moved without all its faces.
        let whole =
            |vertex: &u32| topology.faces_around(*vertex).all(|(face, _)| refused.binary_search(&face).is_err());
        let vertices = vertices.into_iter().filter(whole);
        let vertices =
            vertices.map(|vertex| (vertex, T::of_sum(over(sheets, background, |sheet| sheet.field.vertex(vertex)))));
        let values = TriangleValues {
            vertices: vertices.collect(),
            faces: of_faces.into_iter().flatten().collect(),
            edges: of_edges.into_iter().flatten().collect(),
        };
        self.write(values)?;
        Ok(refused)
    }

    /// A composite of `sheets` over `background` in place of this one: as fine everywhere as the finest of them.
    /// Readers that follow this channel follow it on. Returns faces that the budget refused too.
    ///
    /// # Errors
    /// Fails if the budget does not hold the vertices, a blended number is not finite, or a page cannot be read or
    /// written.
    #[inline(never)]
    pub fn recomposed(
        &self,
        context: &Context,
        sheets: &[TriangleSheet<'_, T>],
        background: T,
    ) -> Result<(Self, Vec<u32>)> {
        let finest = sheets.iter().map(|sheet| sheet.field.pattern().segments()).max();
        let segments = finest.unwrap_or(self.field.pattern().segments());
        let blank = T::of_sum(over(sheets, background, |sheet| sheet.field.blank()));
        let mut fresh = Self::sized(&self.field, segments, blank, self.budget())?;
        let seen = sheets.iter().filter(|sheet| sheet.settings.visible);
        let mut blocks: Vec<u32> = seen.flat_map(|sheet| sheet.field.blocks()).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let refused = fresh.compose(context, sheets, background, &blocks)?;
        fresh.follow(self);
        Ok((fresh, refused))
    }

    /// Takes the place of `before`: what differs counts as changed.
    #[inline(never)]
    pub fn follow(&mut self, before: &Self) {
        self.blocks.revision = self.blocks.revision.max(before.blocks.revision) + 1;
        let topology = self.field.topology().clone();
        let all = !self.field.blank().same(before.field.blank());
        let mut blocks = [self.field.blocks(), before.field.blocks(), before.changed.blocks(&topology)].concat();
        if all {
            blocks = (0..TriangleBlock::count(&topology)).collect();
        }
        let TriangleChange { faces, edges, mut vertices } = TriangleBlock::change(&topology, blocks);
        if !all {
            vertices.retain(|vertex| !self.field.vertex(*vertex).same(before.field.vertex(*vertex)));
            vertices.extend(&before.changed.vertices);
            // Each once, or channels that follow each other in turn double their lists.
            vertices.sort_unstable();
            vertices.dedup();
        }
        let of_faces = faces.iter().copied().map(TriangleBlock::Face);
        for block in of_faces.chain(edges.iter().copied().map(TriangleBlock::Edge)) {
            if self.field.block(block).is_some()
                && let Some(Some(entry)) = self.field.block_mut(block)
            {
                entry.version = self.blocks.revision;
            }
        }
        self.changed.faces.extend(faces);
        self.changed.edges.extend(edges);
        self.changed.vertices.extend(vertices);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::shapes::{channel, fill, random, sets};
    use crate::triangle::{TriangleSets, TriangleValues};
    use half::f16;
    use relievo_document::Kind;

    #[test]
    fn what_lies_beside_a_face_that_the_budget_refuses_stays_blank() {
        let context = Context::serial();
        let mut layer = channel(16, 1 << 20);
        let topology = layer.field().topology().clone();
        let pattern = layer.field().pattern();
        let shared = topology.edges_of(0).into_iter().find(|edge| topology.edges_of(1).contains(edge)).unwrap();
        layer.apply(&context, pattern, &sets(&[0, 1])).unwrap();
        let edges = topology.edges_of(0).map(|edge| (edge, vec![f16::ONE; pattern.edge_values()])).to_vec();
        let faces = vec![(0, vec![f16::ONE; pattern.face_values()])];
        let mut values = TriangleValues { faces, edges, vertices: vec![] };
        values.edges.sort_by_key(|(edge, _)| *edge);
        layer.write(values).unwrap();
        let seen = Settings::of(Kind::Scalar);
        for (room, refused) in [(169 + 45, vec![1]), (2 * 169 + 75, vec![])] {
            let mut composite = channel(16, 1 << 20);
            let vertices = composite.bytes();
            composite.set_budget(vertices + 2 * room);
            let sheets = [TriangleSheet { field: layer.field(), settings: seen }];
            let blocks = layer.blocks();
            assert_eq!(composite.compose(&context, &sheets, f16::ZERO, &blocks).unwrap(), refused);
            let field = composite.field();
            for edge in topology.edges_of(0) {
                let expected = if edge == shared && !refused.is_empty() { f16::ZERO } else { f16::ONE };
                assert!(field.edge(edge).unwrap().iter().all(|value| *value == expected), "{edge}");
            }
            assert_eq!(field.face(0), layer.field().face(0));
        }
    }

    #[test]
    fn what_changed_is_found_vertex_by_vertex() {
        let context = Context::serial();
        let mut channel = channel(8, 1 << 20);
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &sets(&[0, 4])).unwrap();
        fill(&mut channel, random(7));
        let before = channel.clone();
        let topology = before.field().topology().clone();
        assert_eq!(channel.field().changes(before.field()), TriangleChange::default());
        let edge = topology.edges_of(4)[0];
        let values = TriangleValues {
            faces: vec![(4, vec![f16::ONE; pattern.face_values()])],
            edges: vec![(edge, vec![f16::ONE; pattern.edge_values()])],
            vertices: vec![(3, f16::ONE), (9, f16::NEG_ONE)],
        };
        channel.write(values).unwrap();
        let expected = TriangleChange { faces: vec![4], edges: vec![edge], vertices: vec![3, 9] };
        assert_eq!(channel.field().changes(before.field()), expected);
        // Of all faces those at these vertices and along this edge.
        let shown = expected.faces_shown(&topology);
        assert!(shown.contains(&4) && shown.len() < topology.face_count(), "{shown:?}");
        // A channel that takes the place of another counts no other vertices either.
        let mut fresh = channel.clone();
        fresh.commit();
        fresh.follow(&before);
        let mut wanted: Vec<u32> = [3, 9].into_iter().chain(before.changed.vertices.iter().copied()).collect();
        wanted.sort_unstable();
        wanted.dedup();
        assert_eq!(fresh.commit().changed().vertices, wanted);
        let gone = TriangleSets { deallocate: vec![0], ..Default::default() };
        channel.apply(&context, pattern, &gone).unwrap();
        assert_eq!(channel.field().changes(before.field()).faces, [0, 4]);
    }
}
