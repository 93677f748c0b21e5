//! What was edited, and how finer levels follow (Derzapf, Grund, Guthe 2014, Section 4.2).
//!
//! A progressive mesh stays as it was built; the vertices that are elsewhere have a place of their own, at every level that
//! has them. A node identifies a vertex: twice the number of the split it comes from, and 1 if it is the second of
//! that. Where a vertex is split that has moved, or one around it, the two vertices are as far from the vertices around
//! them as they were built, turned as those have turned.

use super::place::{Place, Surroundings};
use super::stars::Stars;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::{Child, Progressive};
use crate::progressive::mesh::active::ActiveMesh;
use crate::progressive::mesh::sparse::Sparse;

/// How far a vertex has moved at least, in extents of the mesh, and how far its normal has turned, that follows others. An
/// influence would otherwise go on from neighbour to neighbour, less at every level, to where no one sees it.
pub const MIN_MOVE: f32 = 1e-7;
const MIN_TURN: f32 = 1e-4;

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

    /// A node as built and as it is now.
    pub fn both(&self, whole: &Progressive, node: u32) -> [Place; 2] {
        let built = whole.node_place(node);
        [built, self.place(node).unwrap_or(built)]
    }

    /// What is around a vertex of a split as soon as that is made, for directions, with the vertex as it was built and as it
    /// is now, if it has moved. What is around the split has to be known.
    pub fn around_end(&self, whole: &Progressive, split: u32, side: usize) -> Option<(Surroundings, [Place; 2])> {
        let [own, other] = [2 * split + side as u32, 2 * split + 1 - side as u32];
        let (now, star) = (self.place(own)?, self.stars.star(split));
        let neighbours = star.ring[star.beside(side)].iter().chain([&other]);
        let neighbours: Vec<_> = neighbours.map(|node| self.both(whole, *node)).collect();
        let places = [whole.node_place(own), now];
        Some((Surroundings::for_directions(places, &neighbours), places))
    }
}

/// A node, and where it is if it has moved.
pub type Placed = (u32, Option<Place>);

/// What is needed to make splits, and to tell what is around vertices.
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
        let least = MIN_MOVE / mesh.whole.scale();
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
            self.gather([end, ends[1 - side]]);
            let around = Surroundings::new(before, &self.neighbours);
            let built = self.mesh.built(end);
            let place = around.forward(noted.map_or(built, |places| places[side]));
            self.placed.push((self.mesh.node(end), is_elsewhere(built, place, self.least).then_some(place)));
        }
    }

    /// A vertex as built and as it is now.
    fn places(&self, vertex: u32) -> [Place; 2] {
        let built = self.mesh.built(vertex);
        [built, self.moves.place(self.mesh.node(vertex)).unwrap_or(built)]
    }

    /// What is around a vertex, for its directions, with it as it was built and as it is now, if it has moved.
    pub fn around(&mut self, vertex: u32) -> Option<(Surroundings, [Place; 2])> {
        let places = self.has_moved(vertex).then(|| self.places(vertex))?;
        self.gather([vertex, NONE]);
        Some((Surroundings::for_directions(places, &self.neighbours), places))
    }

    /// Finds the neighbours of a vertex, without another one.
    fn gather(&mut self, [own, other]: [u32; 2]) {
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
    }
}

/// Whether a vertex is not where it was built.
fn is_elsewhere(built: Place, place: Place, least: f32) -> bool {
    place.point.distance_squared(built.point) > least * least
        || place.normal.distance_squared(built.normal) > MIN_TURN * MIN_TURN
}

/// What is needed to have splits follow that are made already.
pub struct Following<'a> {
    mesh: &'a ActiveMesh,
    moves: &'a Moves,
    least: f32,
    /// Vertices beside one, by their numbers.
    ring: Vec<(u32, [Place; 2])>,
    neighbours: Vec<[Place; 2]>,
    /// Where the vertices of the splits are.
    pub placed: Vec<Placed>,
}

impl<'a> Following<'a> {
    pub fn new(mesh: &'a ActiveMesh, moves: &'a Moves) -> Self {
        let least = MIN_MOVE / mesh.whole.scale();
        Self { mesh, moves, least, ring: Vec::new(), neighbours: Vec::new(), placed: Vec::new() }
    }

    /// Puts the vertices of splits where [`Refining`] puts them. What is around them has to be known.
    pub fn follow(&mut self, splits: &[u32]) {
        let (whole, moves) = (&*self.mesh.whole, self.moves);
        moves.stars.ask_ahead(splits);
        moves.places.ask_ahead(splits.iter().flat_map(|split| moves.stars.star(*split).ring.iter().copied()));
        for split in splits {
            let (star, parent, noted) = (moves.stars.star(*split), whole.parent(*split), moves.built.get(*split));
            let has_moved = |node: &u32| moves.places.get(*node).is_some();
            let nodes = [2 * split, 2 * split + 1];
            if noted.is_none() && !has_moved(&parent) && !star.ring.iter().any(has_moved) {
                self.placed.extend(nodes.into_iter().filter(has_moved).map(|node| (node, None)));
                continue;
            }
            let before = moves.both(whole, parent);
            for (side, node) in nodes.into_iter().enumerate() {
                self.ring.clear();
                let beside = star.ring[star.beside(side)].iter();
                self.ring.extend(beside.map(|node| (self.mesh.first_leaf(*node), moves.both(whole, *node))));
                // Sums are in the order of the vertices.
                self.ring.sort_unstable_by_key(|(vertex, _)| *vertex);
                self.neighbours.clear();
                self.neighbours.extend(self.ring.iter().map(|(_, places)| *places));
                let built = whole.node_place(node);
                let around = Surroundings::new(before, &self.neighbours);
                let place = around.forward(noted.map_or(built, |places| places[side]));
                self.placed.push((node, is_elsewhere(built, place, self.least).then_some(place)));
            }
        }
    }
}
