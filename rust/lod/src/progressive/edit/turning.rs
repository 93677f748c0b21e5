//! Wedges of a mesh whose vertices have moved, with their directions turned ([`directions`](super::directions)).

use std::sync::Arc;

use relievo_core::Context;

use super::moves::{Moves, Refining};
use super::place::Surroundings;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::build::wedges::WedgeTrees;
use crate::progressive::mesh::active::ActiveMesh;

/// What is needed to tell what wedges of a mesh have.
pub struct Turning<'a> {
    mesh: &'a ActiveMesh,
    /// If there may be directions that have turned.
    around: Option<Refining<'a>>,
    values: Vec<f32>,
}

impl<'a> Turning<'a> {
    pub fn new(mesh: &'a ActiveMesh) -> Self {
        let around = mesh.moves.as_ref().filter(|_| mesh.has_directions()).map(|moves| Refining::new(mesh, moves));
        Self { mesh, around, values: Vec::new() }
    }

    /// What a wedge has, if it is there.
    pub fn values_of(&mut self, wedge: u32) -> Option<&[f32]> {
        let (trees, there) = (self.mesh.whole.wedges.as_ref()?, self.mesh.wedges.as_ref()?);
        self.mesh.is_wedge(wedge).then(|| self.values(trees, wedge, there.first_from(wedge + 1)))
    }

    /// What a wedge has that is there, after which `following` is next.
    pub fn values<'b>(&'b mut self, trees: &'b WedgeTrees, wedge: u32, following: Option<u32>) -> &'b [f32] {
        let values = trees.values(&self.mesh.whole, wedge, following);
        let Some(around) = &mut self.around else { return values };
        let vertex = self.mesh.there.last_up_to(trees.home(&self.mesh.whole, wedge));
        let Some((around, places)) = vertex.and_then(|vertex| around.around(vertex)) else { return values };
        self.values.clear();
        self.values.extend_from_slice(values);
        trees.directions.turn(&around, places, &mut self.values);
        &self.values
    }
}

impl ActiveMesh {
    /// Whether wedges have directions.
    pub(super) fn has_directions(&self) -> bool {
        self.whole.wedges.as_ref().is_some_and(|trees| !trees.directions.is_empty())
    }

    /// Wedges whose directions may be others since something changed at vertices: those of all vertices around.
    pub(crate) fn turned_by(&self, changed: impl Iterator<Item = u32>) -> Vec<u32> {
        if self.moves.is_none() || !self.has_directions() {
            return Vec::new();
        }
        let mut around: Vec<u32> = changed.flat_map(|vertex| self.spokes(vertex).flatten().chain([vertex])).collect();
        around.sort_unstable();
        around.dedup();
        let faces = around.into_iter().flat_map(|vertex| self.faces_at(vertex));
        faces.filter_map(|face| self.wedges_of(face)).flat_map(|(wedges, _)| wedges).collect()
    }

    /// The wedges of the progressive mesh that has the edits of this one, which is the finest, at all levels. Where a wedge
    /// goes on through several levels as it is, it has what it has at the finest of them.
    pub(crate) fn settled_wedges(&mut self, context: &Context) -> Option<Arc<WedgeTrees>> {
        let trees = self.whole.wedges.clone()?;
        if !self.has_directions() {
            return Some(trees);
        }
        let Some(mut moves) = self.moves.take() else { return Some(trees) };
        moves.stars.complete(context, self);
        let mut made = WedgeTrees::clone(&trees);
        for (split, owner) in (0..).zip(&trees.owners).filter(|(_, owner)| **owner != NONE) {
            for side in 0..2 {
                if let Some((around, places)) = moves.around_end(&self.whole, *owner, side) {
                    trees.directions.turn(&around, places, made.values_mut(split, side));
                }
            }
        }
        trees.turn_base(&self.whole, &moves, &mut made);
        self.moves = Some(moves);
        // What the finest mesh has.
        let (mut turning, mut list) = (Turning::new(self), self.wedges().peekable());
        while let Some(wedge) = list.next() {
            let following = list.peek().copied();
            let (split, side) = trees.source(&self.whole, wedge, following);
            made.values_mut(split, side).copy_from_slice(turning.values(&trees, wedge, following));
        }
        Some(Arc::new(made))
    }
}

impl WedgeTrees {
    /// Turns the directions of base wedges.
    fn turn_base(&self, mesh: &Progressive, moves: &Moves, made: &mut Self) {
        let first = |list: &[u32], leaf: u32| list[list.partition_point(|first| *first <= leaf).saturating_sub(1)];
        // Of every vertex those beside it, then its wedges.
        let mut pairs = Vec::new();
        for face in &mesh.base_faces {
            let ends = mesh.faces[*face as usize].map(|leaf| first(&mesh.base_vertices, leaf));
            let wedges = self.corners[*face as usize].map(|leaf| first(&self.base, leaf));
            for side in 0..3 {
                let beside =
                    [1, 2].map(|step| ends[(side + step) % 3]).into_iter().filter(|other| *other != ends[side]);
                pairs.extend(beside.map(|other| (ends[side], false, other)));
                pairs.push((ends[side], true, wedges[side]));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        for group in pairs.chunk_by(|one, other| one.0 == other.0) {
            let (beside, wedges) = group.split_at(group.partition_point(|(_, is_wedge, _)| !is_wedge));
            let Some(now) = moves.place(2 * group[0].0) else { continue };
            let neighbours: Vec<_> = beside.iter().map(|(.., other)| moves.both(mesh, 2 * other)).collect();
            let places = [mesh.node_place(2 * group[0].0), now];
            let around = Surroundings::for_directions(places, &neighbours);
            for (.., wedge) in wedges {
                self.directions.turn(&around, places, made.values_mut(*wedge, 1));
            }
        }
    }
}
