//! The patch: the part of the surface under a sticker, as a disk of its own with positions in the plane of the image.
//!
//! A vertex of the surface may occur several times, so that a sticker can overlap itself. Additions and removals keep the
//! patch a topological disk: a face is added along one, two or three consecutive boundary edges, and removed where its
//! edges on the boundary are connected.

use relievo_core::{Error, Result};

use crate::edges::{Edges, target};
use crate::map::energy::Vec2;
use crate::map::gradual::{push, reserve};
use crate::surface::{NONE, Surface, next, previous};

/// A disk of faces.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// The vertex of the surface that each vertex lies at.
    pub vertices: Vec<u32>,
    /// Positions in the plane.
    pub positions: Vec<Vec2>,
    /// Vertices of the faces, in the order of the corners of the surface's triangles.
    pub faces: Vec<[u32; 3]>,
    /// The triangle of the surface that each face lies at.
    pub triangles: Vec<u32>,
    /// The boundary, counter-clockwise: by vertex, the next and the previous vertex, or [`NONE`] inside.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The half-edge of the surface from each boundary vertex to the next one, within the patch.
    halves: Vec<u32>,
    /// The first vertex at each vertex of the surface, and after each vertex the next one there, or [`NONE`].
    first: Vec<u32>,
    others: Vec<u32>,
}

/// What a patch was, before faces were added to it.
#[derive(Debug)]
pub struct Mark {
    faces: usize,
    positions: Vec<Vec2>,
    /// The vertices of the boundary, with the next and the previous one and the half-edge of the surface.
    boundary: Vec<[u32; 4]>,
}

/// How a face beyond a boundary edge can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// It brings a new vertex.
    New,
    /// It closes the gap at the start of the edge, with the vertex before.
    Start(u32),
    /// It closes the gap at the end of the edge, with the vertex after.
    End(u32),
    /// It would make a surface without boundary, or join two copies of a vertex.
    Blocked,
}

impl Patch {
    /// Makes a patch of faces that form a disk.
    ///
    /// # Errors
    /// They do not.
    pub fn new(vertices: Vec<u32>, positions: Vec<Vec2>, faces: Vec<[u32; 3]>, triangles: Vec<u32>) -> Result<Self> {
        let count = vertices.len();
        let mut patch = Self {
            next: vec![NONE; count],
            previous: vec![NONE; count],
            halves: vec![NONE; count],
            vertices,
            positions,
            faces,
            triangles,
            first: Vec::new(),
            others: Vec::with_capacity(count),
        };
        let refuse = || Error::invalid("the faces under the pins do not form a disk").at("seed of the decal");
        let edges = patch.edges();
        let mut boundary = 0;
        for from in 0..count as u32 {
            let leaving = edges.of(from);
            for (index, half) in leaving.iter().enumerate() {
                let to = target(&patch.faces, *half);
                if leaving[..index].iter().any(|other| target(&patch.faces, *other) == to) {
                    return Err(refuse());
                }
                if edges.of(to).iter().any(|other| target(&patch.faces, *other) == from) {
                    continue;
                }
                if patch.next[from as usize] != NONE || patch.previous[to as usize] != NONE {
                    return Err(refuse());
                }
                boundary += 1;
                patch.next[from as usize] = to;
                patch.previous[to as usize] = from;
                patch.halves[from as usize] = 3 * patch.triangles[*half as usize / 3] + half % 3;
            }
        }
        drop(edges);
        let euler = count as i64 - (3 * patch.faces.len() as i64 + boundary) / 2 + patch.faces.len() as i64;
        if euler != 1 || patch.boundary().len() as i64 != boundary {
            return Err(refuse());
        }
        for vertex in 0..count {
            patch.enlist(patch.vertices[vertex]);
        }
        Ok(patch)
    }

    /// Half-edges of the patch by the vertex that they leave.
    fn edges(&self) -> Edges {
        Edges::new(&self.faces, self.vertices.len(), |_| false, |from, _| from)
    }

    /// Returns the boundary vertices in order; those of the first loop where there are several.
    pub fn boundary(&self) -> Vec<u32> {
        let Some(first) = self.next.iter().position(|next| *next != NONE) else {
            return Vec::new();
        };
        let mut boundary = vec![first as u32];
        let mut vertex = self.next[first];
        while vertex != NONE && vertex != first as u32 && boundary.len() <= self.next.len() {
            boundary.push(vertex);
            vertex = self.next[vertex as usize];
        }
        boundary
    }

    /// Returns whether a vertex lies on the boundary.
    pub fn is_boundary(&self, vertex: u32) -> bool {
        self.next[vertex as usize] != NONE
    }

    /// Returns the vertex after a boundary vertex.
    pub fn after(&self, vertex: u32) -> u32 {
        self.next[vertex as usize]
    }

    /// Returns the copies of a vertex of the surface.
    pub fn copies(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let after = |copy: &u32| Some(self.others[*copy as usize]).filter(|copy| *copy != NONE);
        let first = self.first.get(vertex as usize).copied().filter(|copy| *copy != NONE);
        std::iter::successors(first, after)
    }

    /// Lists the next vertex among the copies of a vertex of the surface, as the last one.
    fn enlist(&mut self, place: u32) {
        let vertex = self.others.len() as u32;
        push(&mut self.others, NONE);
        if self.first.len() <= place as usize {
            reserve(&mut self.first, place as usize + 1);
            self.first.resize(place as usize + 1, NONE);
        }
        match self.copies(place).last() {
            Some(copy) => self.others[copy as usize] = vertex,
            None => self.first[place as usize] = vertex,
        }
    }

    /// Removes the last vertex from the copies of a vertex of the surface.
    fn delist(&mut self, place: u32) {
        let vertex = self.others.len() as u32 - 1;
        let before = self.copies(place).find(|copy| self.others[*copy as usize] == vertex);
        match before {
            Some(copy) => self.others[copy as usize] = NONE,
            None => self.first[place as usize] = NONE,
        }
        self.others.pop();
    }

    /// Returns the positions of the corners of a face.
    pub fn corners(&self, face: u32) -> [Vec2; 3] {
        self.faces[face as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Returns what [`Self::revert`] needs to take back faces that are added and vertices that move from now on.
    pub fn mark(&self) -> Mark {
        let links = |vertex: u32| {
            let at = vertex as usize;
            [vertex, self.next[at], self.previous[at], self.halves[at]]
        };
        let boundary = (0..self.vertices.len() as u32).filter(|vertex| self.is_boundary(*vertex)).map(links).collect();
        Mark { faces: self.faces.len(), positions: self.positions.clone(), boundary }
    }

    /// Makes the patch again what it was when it was marked. Between, faces were added only.
    pub fn revert(&mut self, mark: Mark) {
        let Mark { faces, positions, boundary } = mark;
        while self.vertices.len() > positions.len() {
            if let Some(place) = self.vertices.pop() {
                self.delist(place);
            }
        }
        self.faces.truncate(faces);
        self.triangles.truncate(faces);
        for list in [&mut self.next, &mut self.previous, &mut self.halves] {
            list.truncate(positions.len());
            list.fill(NONE);
        }
        for [vertex, next, previous, half] in boundary {
            let at = vertex as usize;
            (self.next[at], self.previous[at], self.halves[at]) = (next, previous, half);
        }
        self.positions = positions;
    }

    /// Gives memory back that was set aside for faces to be added.
    pub fn shrink(&mut self) {
        self.faces.shrink_to_fit();
        self.triangles.shrink_to_fit();
        self.positions.shrink_to_fit();
        for list in [
            &mut self.vertices,
            &mut self.next,
            &mut self.previous,
            &mut self.halves,
            &mut self.first,
            &mut self.others,
        ] {
            list.shrink_to_fit();
        }
    }

    /// Returns the half-edge of the surface beyond the boundary edge that starts at a vertex, if there is a face.
    pub fn beyond(&self, surface: &Surface, from: u32) -> Option<u32> {
        let half = self.halves[from as usize];
        (half != NONE).then(|| surface.mate(half)).flatten()
    }

    /// Returns how the face beyond the edge that starts at a boundary vertex can be added. `half` is its half-edge.
    pub fn joint(&self, surface: &Surface, from: u32, half: u32) -> Joint {
        let to = self.next[from as usize];
        let before = self.previous[from as usize];
        let closes_start = surface.mates[self.halves[before as usize] as usize] == next(half);
        let closes_end = surface.mates[self.halves[to as usize] as usize] == previous(half);
        match (closes_start, closes_end) {
            (false, false) => Joint::New,
            (true, false) if before != self.next[to as usize] => Joint::Start(before),
            (false, true) if before != self.next[to as usize] => Joint::End(self.next[to as usize]),
            _ => Joint::Blocked,
        }
    }

    /// Adds the face beyond the edge that starts at a boundary vertex; returns the new vertex of [`Joint::New`].
    pub fn add(&mut self, surface: &Surface, from: u32, half: u32, joint: Joint, position: Vec2) -> Option<u32> {
        let to = self.next[from as usize];
        let place = surface.origin(previous(half));
        let mut made = None;
        let third = match joint {
            Joint::Blocked => return None,
            Joint::New => {
                let vertex = self.vertices.len() as u32;
                push(&mut self.vertices, place);
                push(&mut self.positions, position);
                push(&mut self.next, to);
                push(&mut self.previous, from);
                push(&mut self.halves, previous(half));
                self.enlist(place);
                self.link(from, vertex, next(half));
                self.previous[to as usize] = vertex;
                made = Some(vertex);
                vertex
            }
            Joint::End(after) => {
                self.release(to);
                self.link(from, after, next(half));
                after
            }
            Joint::Start(before) => {
                self.release(from);
                self.link(before, to, previous(half));
                before
            }
        };
        // The half-edge beyond runs from the end of the boundary edge to its start.
        let mut face = [0; 3];
        for (corner, vertex) in [(half, to), (next(half), from), (previous(half), third)] {
            face[corner as usize % 3] = vertex;
        }
        push(&mut self.faces, face);
        push(&mut self.triangles, half / 3);
        made
    }

    fn link(&mut self, from: u32, to: u32, half: u32) {
        self.next[from as usize] = to;
        self.previous[to as usize] = from;
        self.halves[from as usize] = half;
    }

    fn release(&mut self, vertex: u32) {
        self.next[vertex as usize] = NONE;
        self.previous[vertex as usize] = NONE;
        self.halves[vertex as usize] = NONE;
    }

    /// Removes faces from the boundary inwards as long as they are not wanted and the patch stays a disk. Renumbers
    /// vertices and faces; returns the old number of each vertex.
    pub fn peel(&mut self, surface: &Surface, is_wanted: &dyn Fn(&Self, usize) -> bool) -> Vec<u32> {
        let edges = self.edges();
        let mut is_removed = vec![false; self.faces.len()];
        let mut queue: Vec<u32> = self.boundary();
        queue.reverse();
        while let Some(from) = queue.pop() {
            let to = self.next[from as usize];
            if to == NONE {
                continue;
            }
            let half = edges.of(from).iter().copied().find(|half| target(&self.faces, *half) == to);
            let Some(half) = half.filter(|half| !is_removed[*half as usize / 3]) else {
                continue;
            };
            let face = half as usize / 3;
            if is_wanted(self, face) {
                continue;
            }
            let third = self.faces[face][previous(half) as usize % 3];
            let triangle = 3 * self.triangles[face];
            let (second, last) = (triangle + next(half) % 3, triangle + previous(half) % 3);
            let mate = |half: u32| surface.mates[half as usize];
            if self.next[to as usize] == third && self.next[third as usize] == from {
                // The last face stays.
                continue;
            } else if self.next[to as usize] == third {
                self.release(to);
                self.link(from, third, mate(last));
                queue.push(from);
            } else if self.next[third as usize] == from {
                self.release(from);
                self.link(third, to, mate(second));
                queue.push(third);
            } else if self.next[third as usize] == NONE {
                self.link(from, third, mate(last));
                self.link(third, to, mate(second));
                queue.extend([third, from]);
            } else {
                continue;
            }
            is_removed[face] = true;
        }
        self.compact(&is_removed)
    }

    /// Returns the patch with its seams closed from their inner ends on, and the new number of each vertex; none without seams.
    /// A closed seam has the positions of the vertices that `is_fixed` names, or those halfway between both sides.
    ///
    /// # Errors
    /// The faces do not form a disk any more.
    pub fn zipped(&self, surface: &Surface, is_fixed: &[bool]) -> Result<Option<(Self, Vec<u32>)>> {
        let (mut after, mut before) = (self.next.clone(), self.previous.clone());
        let mut positions = self.positions.clone();
        let mut number: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let mut halves = self.halves.clone();
        let mut count = 0;
        let mut queue = self.boundary();
        while let Some(root) = queue.pop() {
            let (first, last) = (before[root as usize], after[root as usize]);
            if last == NONE || first == last || after[last as usize] == first {
                continue;
            }
            let is_seam = surface.mate(halves[first as usize]) == Some(halves[root as usize]);
            if !is_seam || (is_fixed[first as usize] && is_fixed[last as usize]) {
                continue;
            }
            let (gone, kept) = if is_fixed[first as usize] { (last, first) } else { (first, last) };
            if !is_fixed[kept as usize] {
                let other = positions[gone as usize];
                let position = &mut positions[kept as usize];
                *position = [0, 1].map(|axis| 0.5 * (position[axis] + other[axis]));
            }
            let (from, to) = (before[first as usize], after[last as usize]);
            let half = halves[last as usize];
            for vertex in [root, first, last] {
                (after[vertex as usize], before[vertex as usize], halves[vertex as usize]) = (NONE, NONE, NONE);
            }
            (after[from as usize], before[kept as usize]) = (kept, from);
            (after[kept as usize], before[to as usize]) = (to, kept);
            halves[kept as usize] = half;
            number[gone as usize] = kept;
            count += 1;
            queue.push(kept);
        }
        if count == 0 {
            return Ok(None);
        }
        let kept: Vec<u32> = (0..number.len() as u32).filter(|vertex| number[*vertex as usize] == *vertex).collect();
        let mut place = vec![NONE; number.len()];
        kept.iter().zip(0..).for_each(|(vertex, at)| place[*vertex as usize] = at);
        for vertex in 0..number.len() {
            let mut end = number[vertex];
            while number[end as usize] != end {
                end = number[end as usize];
            }
            number[vertex] = end;
        }
        let number: Vec<u32> = number.into_iter().map(|vertex| place[vertex as usize]).collect();
        let faces = self.faces.iter().map(|face| face.map(|vertex| number[vertex as usize])).collect();
        let vertices = kept.iter().map(|vertex| self.vertices[*vertex as usize]).collect();
        let positions = kept.iter().map(|vertex| positions[*vertex as usize]).collect();
        Ok(Some((Self::new(vertices, positions, faces, self.triangles.clone())?, number)))
    }

    fn compact(&mut self, is_removed: &[bool]) -> Vec<u32> {
        let mut number = vec![NONE; self.vertices.len()];
        let (mut old, mut kept) = (Vec::new(), Self::default());
        let count = is_removed.iter().filter(|is_removed| !**is_removed).count();
        kept.faces.reserve_exact(count);
        kept.triangles.reserve_exact(count);
        for (face, vertices) in self.faces.iter().enumerate().filter(|(face, _)| !is_removed[*face]) {
            let vertices = vertices.map(|vertex| {
                let number = &mut number[vertex as usize];
                if *number == NONE {
                    *number = old.len() as u32;
                    old.push(vertex);
                }
                *number
            });
            kept.faces.push(vertices);
            kept.triangles.push(self.triangles[face]);
        }
        let renumbered = |vertex: u32| if vertex == NONE { NONE } else { number[vertex as usize] };
        kept.positions.reserve_exact(old.len());
        for list in [&mut kept.vertices, &mut kept.next, &mut kept.previous, &mut kept.halves, &mut kept.others] {
            list.reserve_exact(old.len());
        }
        for before in &old {
            let before = *before as usize;
            kept.vertices.push(self.vertices[before]);
            kept.positions.push(self.positions[before]);
            kept.next.push(renumbered(self.next[before]));
            kept.previous.push(renumbered(self.previous[before]));
            kept.halves.push(self.halves[before]);
            kept.enlist(self.vertices[before]);
        }
        kept.shrink();
        *self = kept;
        old
    }
}
