//! Layers of a triangle mesh: how its channels are stacked, and how edits of what is seen go to the active layer.
//!
//! What an edit changed at a vertex of the tessellation goes to the layer's value there. A layer with fewer segments
//! takes what it has values for, one with more what is between. Units: object units, linear light.

use std::sync::Arc;

use relievo_core::{Context, Result};
use relievo_document::{PageStore, Settings};
use relievo_tiles::triangle::composite::blended;
use relievo_tiles::triangle::{
    Pattern, TriangleBlock, TriangleChange, TriangleChannel, TriangleDecay, TriangleField, TriangleSets, TriangleSheet,
    TriangleValues,
};
use relievo_tiles::{Layered, StoredTexel};

use super::site::{Element, values};
use crate::channels::layer_channel::{Absorb, BlockChannel, LayerChannel};

impl<T: StoredTexel> BlockChannel for TriangleChannel<T> {
    type Field = TriangleField<T>;

    fn field(&self) -> &TriangleField<T> {
        TriangleChannel::field(self)
    }

    fn budget(&self) -> u64 {
        TriangleChannel::budget(self)
    }

    fn set_budget(&mut self, budget: u64) {
        TriangleChannel::set_budget(self, budget);
    }

    fn read(&self, block: u32) -> Result<Option<Vec<u8>>> {
        TriangleChannel::read(self, block)
    }

    fn write(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.write_block(block, bytes)
    }

    fn commit(&mut self) -> Vec<u32> {
        let topology = TriangleChannel::field(self).topology().clone();
        TriangleChannel::commit(self).changed().blocks(&topology)
    }

    fn page_to(&mut self, pages: Option<&Arc<dyn PageStore>>) -> Result<()> {
        TriangleChannel::page_to(self, pages.cloned())
    }

    fn report_fault(&self) -> Result<()> {
        TriangleChannel::report_fault(self)
    }

    fn mend(&mut self, context: &Context, blocks: &[u32]) -> Result<()> {
        self.mend_around(context, blocks)
    }

    /// Blocks say their level by their length; what changes is the number of segments of the finest.
    fn reshape(&mut self, sizes: &[u32], _: &[u32]) -> Result<()> {
        sizes.first().map_or(Ok(()), |segments| self.set_segments(*segments))
    }
}

impl<T: Absorb> LayerChannel for TriangleChannel<T> {
    type Texel = T;
    type Decay = TriangleDecay<T>;

    const THROUGH_COMPOSITE: bool = T::THROUGH_COMPOSITE;

    fn sized(field: &TriangleField<T>, face_sizes: &[u32], blank: T, budget: u64) -> Result<Self> {
        let segments = face_sizes.first().copied().unwrap_or(field.pattern().segments());
        TriangleChannel::sized(field, segments, blank, budget)
    }

    fn compose(
        &mut self,
        context: &Context,
        sheets: &[TriangleSheet<'_, T>],
        background: T,
        blocks: &[u32],
    ) -> Result<Vec<u32>> {
        TriangleChannel::compose(self, context, sheets, background, blocks)
    }

    fn recomposed(
        &self,
        context: &Context,
        sheets: &[TriangleSheet<'_, T>],
        background: T,
    ) -> Result<(Self, Vec<u32>)> {
        TriangleChannel::recomposed(self, context, sheets, background)
    }

    fn follow(&mut self, before: &Self) {
        TriangleChannel::follow(self, before);
    }

    fn is_allocated(field: &TriangleField<T>, face: u32) -> bool {
        field.is_allocated(face)
    }

    fn is_edited(field: &TriangleField<T>, before: &TriangleField<T>, face: u32) -> bool {
        field.is_edited(before, face)
    }

    fn set_expendable(&mut self, faces: &[u32]) {
        TriangleChannel::set_expendable(self, faces);
    }

    fn take_lost(&mut self) -> Vec<u32> {
        TriangleChannel::take_lost(self)
    }

    fn lose(&mut self, _: &Context, faces: &[u32]) -> Result<()> {
        self.lose_expendable(faces)
    }

    fn lose_all(&mut self, _: &Context, faces: &[u32]) -> Result<()> {
        self.lose_faces(faces)
    }

    fn forget(field: &mut TriangleField<T>, faces: &[u32]) {
        field.forget(faces);
    }

    fn absorb(
        &mut self,
        context: &Context,
        composite: [&TriangleField<T>; 2],
        (below, background): (&[TriangleSheet<'_, T>], T),
        settings: Settings,
        blocks: &[u32],
    ) -> Result<Vec<u32>> {
        let [before, now] = composite;
        let topology = now.topology().clone();
        let mut change = TriangleBlock::change(&topology, blocks.iter().copied());
        change.vertices.retain(|vertex| !before.vertex(*vertex).same(now.vertex(*vertex)));
        change.edges.retain(|edge| differs(composite, *edge));
        let refused = self.room_for(context, composite, &change)?;
        let field = TriangleChannel::field(self);
        let mut shown = change.faces_shown(&topology);
        shown.retain(|face| field.is_allocated(*face));
        let is_there = |(face, _): (u32, u32)| field.is_allocated(face);
        let mut elements = Element::of_faces(&topology, &shown);
        elements.retain(|element| match element {
            Element::Face(_) => true,
            Element::Edge(edge) => topology.faces_along(*edge).all(is_there),
            Element::Vertex(vertex) => topology.faces_around(*vertex).all(is_there),
        });
        let new = context.map(elements.len(), |index| {
            let element = elements[index];
            let pattern = element.pattern(field).unwrap_or(field.pattern());
            let mut new = values(field, element, pattern)?;
            let mut changed = false;
            for (value, (face, pattern, node)) in new.iter_mut().zip(element.knots(&topology, pattern)) {
                let [then, now] = composite.map(|field| field.texel(face, pattern, node));
                if !then.same(now) {
                    let below = || blended(below, background, face, pattern, node);
                    *value = T::take_in(*value, [then.sum(), now.sum()], below, &settings);
                    changed = true;
                }
            }
            changed.then_some((element, new))
        });
        let mut values = TriangleValues::default();
        for (element, new) in new.into_iter().flatten() {
            match element {
                Element::Face(face) => values.faces.push((face, new)),
                Element::Edge(edge) => values.edges.push((edge, new)),
                Element::Vertex(vertex) => values.vertices.extend(new.first().map(|value| (vertex, *value))),
            }
        }
        self.write(values)?;
        self.reclaim(context, &shown)?;
        Ok(refused)
    }
}

/// Whether an edge reads otherwise in the second field than in the first.
fn differs<T: Layered>(fields: [&TriangleField<T>; 2], edge: u32) -> bool {
    let element = Element::Edge(edge);
    let Some(pattern) = fields.into_iter().filter_map(|field| field.edge_pattern(edge)).max() else { return false };
    let [before, now] = fields.map(|field| values(field, element, pattern).unwrap_or_default());
    before.iter().zip(&now).any(|(before, now)| !before.same(*now))
}

/// What a layer needs to take in a change of the composite.
trait Room<T: Layered> {
    /// Allocates the faces in which it is kept. Returns the faces that the budget refused, ascending.
    fn room_for(
        &mut self,
        context: &Context,
        composite: [&TriangleField<T>; 2],
        change: &TriangleChange,
    ) -> Result<Vec<u32>>;
}

impl<T: Layered> Room<T> for TriangleChannel<T> {
    fn room_for(
        &mut self,
        context: &Context,
        composite: [&TriangleField<T>; 2],
        change: &TriangleChange,
    ) -> Result<Vec<u32>> {
        let field = self.field();
        let topology = field.topology().clone();
        let held = |face: u32| composite.iter().filter_map(|field| field.face_pattern(face)).max();
        let inside = change.faces.iter().copied().filter(|face| held(*face).is_some());
        let along = change.edges.iter().flat_map(|edge| topology.faces_along(*edge));
        let around = change.vertices.iter().flat_map(|vertex| topology.faces_around(*vertex));
        let mut faces: Vec<u32> = inside.chain(along.chain(around).map(|(face, _)| face)).collect();
        faces.sort_unstable();
        faces.dedup();
        let finest = field.pattern();
        let wanted = |face: u32| held(face).map_or(finest, |pattern| pattern.clamp(finest.coarser(2), finest));
        let mut refused = Vec::new();
        for level in [2, 1, 0] {
            let pattern: Pattern = finest.coarser(level);
            let allocate = faces.iter().copied().filter(|face| wanted(*face) == pattern).collect();
            let sets = TriangleSets { allocate, modify: faces.clone(), ..Default::default() };
            refused.extend(self.apply(context, pattern, &sets)?);
        }
        refused.sort_unstable();
        Ok(refused)
    }
}
