//! What was edited, and how finer levels follow (Derzapf, Grund, Guthe 2014, Section 4.2).
//!
//! A progressive mesh stays as it was built; the vertices that are elsewhere have a place of their own, at every level that
//! has them. A vertex is told by its node: twice the number of the split it comes from, and 1 if it is the second of that.
//! Where a vertex is split that has moved, or one around it, the two vertices are as far from the vertices around them as
//! they were built, turned as those have turned.

use super::active::ActiveMesh;
use super::hierarchy::Child;
use super::place::{Place, Surroundings};
use super::sparse::Sparse;
use super::stars::Stars;

/// How far a vertex has moved at least, in extents of the mesh, and how far its normal has turned, that follows others. An
/// influence would otherwise go on from neighbour to neighbour, less at every level, to where no one sees it.
pub const LEAST_MOVE: f32 = 1e-7;
const LEAST_TURN: f32 = 1e-4;

/// What was edited.
pub struct Moves {
    /// Of nodes that have moved.
    pub places: Sparse<Place>,
    /// Of splits near an edit of their level or a finer one, where their two vertices would have been built.
    pub built: Sparse<[Place; 2]>,
    pub stars: Stars,
}

impl Moves {
    pub fn new(vertices: usize) -> Self {
        Self { places: Sparse::new(2 * vertices), built: Sparse::new(vertices), stars: Stars::new(vertices) }
    }

    /// Where a node is, if it has moved.
    #[inline(always)]
    pub fn place(&self, node: u32) -> Option<Place> {
        self.places.get(node).copied()
    }
}

/// A node, and where it is if it has moved.
pub type Placed = (u32, Option<Place>);

/// What is needed to make splits.
pub struct Refining<'a> {
    mesh: &'a ActiveMesh,
    moves: &'a Moves,
    least: f32,
    ring: Vec<u32>,
    neighbours: Vec<[Place; 2]>,
    /// Where the vertices of the splits are.
    pub placed: Vec<Placed>,
}

impl<'a> Refining<'a> {
    pub fn new(mesh: &'a ActiveMesh, moves: &'a Moves) -> Self {
        let least = LEAST_MOVE / mesh.whole.scale();
        Self { mesh, moves, least, ring: Vec::new(), neighbours: Vec::new(), placed: Vec::new() }
    }

    fn has_moved(&self, vertex: u32) -> bool {
        self.moves.places.get(self.mesh.node(vertex)).is_some()
    }

    /// A vertex that is to be split, as built and as it is now, if that or one around has moved. What its two vertices were
    /// before is forgotten.
    pub fn before(&mut self, vertex: u32) -> Option<[Place; 2]> {
        let Some(Child::Split(split)) = self.mesh.child(vertex) else { return None };
        let is_near = self.has_moved(vertex)
            || self.mesh.spokes(vertex).flatten().any(|other| self.has_moved(other))
            || self.moves.built.get(split).is_some();
        if is_near {
            return Some(self.places(vertex));
        }
        let nodes = [2 * split, 2 * split + 1].into_iter();
        self.placed.extend(nodes.filter(|node| self.moves.places.get(*node).is_some()).map(|node| (node, None)));
        None
    }

    /// Puts the two vertices of a split where they belong.
    pub fn split(&mut self, before: [Place; 2], ends: [u32; 2]) {
        let noted = self.moves.built.get(ends[1]).copied();
        for (side, end) in ends.into_iter().enumerate() {
            let around = self.surroundings(ends, side, before);
            let built = self.mesh.built(end);
            let place = around.forward(noted.map_or(built, |places| places[side]));
            let is_elsewhere = place.point.distance_squared(built.point) > self.least * self.least
                || place.normal.distance_squared(built.normal) > LEAST_TURN * LEAST_TURN;
            self.placed.push((self.mesh.node(end), is_elsewhere.then_some(place)));
        }
    }

    /// A vertex as built and as it is now.
    fn places(&self, vertex: u32) -> [Place; 2] {
        let built = self.mesh.built(vertex);
        [built, self.moves.place(self.mesh.node(vertex)).unwrap_or(built)]
    }

    /// What is around one of the two vertices of a split, without the other.
    fn surroundings(&mut self, ends: [u32; 2], side: usize, vertex: [Place; 2]) -> Surroundings {
        let [own, other] = [ends[side], ends[1 - side]];
        self.ring.clear();
        for [after, before] in self.mesh.spokes(own) {
            if after != before && after != own && before != own {
                self.ring.extend([after, before].into_iter().filter(|vertex| *vertex != other));
            }
        }
        self.ring.sort_unstable();
        self.ring.dedup();
        let mut neighbours = std::mem::take(&mut self.neighbours);
        neighbours.clear();
        neighbours.extend(self.ring.iter().map(|vertex| self.places(*vertex)));
        self.neighbours = neighbours;
        Surroundings::new(vertex, &self.neighbours)
    }
}
