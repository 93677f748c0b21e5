//! The triangles of a mesh with their neighbours.
//!
//! A half-edge is numbered `3 face + corner` and runs from that corner to the next one. Edges of more than two faces and
//! edges of faces that disagree in orientation are boundary. Each vertex has one fan of faces: where a point of the mesh
//! has several, it becomes several vertices.

use relievo_core::{Error, Mesh, Result};

use crate::edges::Edges;

/// Stands for an element that does not exist.
pub const NONE: u32 = u32::MAX;

/// A point of space.
pub type Vec3 = [f64; 3];

/// Triangles of vertices, each with one fan of faces.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Positions of vertices.
    pub points: Vec<Vec3>,
    /// Vertices of triangles.
    pub triangles: Vec<[u32; 3]>,
    /// The face of the mesh that each triangle is a part of.
    pub sources: Vec<u32>,
    /// Faces of the mesh that are holes, ascending: their triangles have no neighbours.
    pub holes: Vec<u32>,
    /// The opposite half-edge of each half-edge, or [`NONE`] on the boundary.
    pub mates: Vec<u32>,
    /// A half-edge that leaves each vertex, on the boundary the first one counter-clockwise; [`NONE`] without faces.
    pub leaving: Vec<u32>,
}

/// Returns the faces of a mesh that are holes, ascending.
pub fn holes(mesh: &Mesh) -> Vec<u32> {
    let mut holes = mesh.holes.clone();
    holes.sort_unstable();
    holes
}

/// Returns the half-edge after this one in its face.
pub fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// Returns the half-edge before this one in its face.
pub fn previous(half: u32) -> u32 {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}

impl Surface {
    /// Makes the surface of a triangle mesh; triangle and face have the same number.
    ///
    /// # Errors
    /// The mesh is unusable ([`Mesh::check`]) or has faces of more than three corners.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        mesh.check()?;
        if let Some(face) = mesh.face_sizes.iter().position(|size| *size != 3) {
            return Err(Error::unsupported(format!("it has {} corners", mesh.face_sizes[face]))
                .at(format!("face {face}"))
                .advise("triangulate the mesh, or tessellate its surface"));
        }
        if mesh.corners.len() >= (u32::MAX / 4) as usize {
            return Err(Error::memory("the mesh has more than 357 million triangles").advise("take a part of it"));
        }
        let points = mesh.points.iter().map(|point| point.map(f64::from)).collect();
        let sources: Vec<u32> = (0..mesh.face_count() as u32).collect();
        Ok(Self::from_triangles(points, mesh.corners.as_chunks().0.to_vec(), sources, holes(mesh)))
    }

    /// Makes a surface of triangles; those of faces that are holes, which ascend, have no neighbours.
    pub fn from_triangles(points: Vec<Vec3>, triangles: Vec<[u32; 3]>, sources: Vec<u32>, holes: Vec<u32>) -> Self {
        let mut surface = Self { points, triangles, sources, holes, mates: Vec::new(), leaving: Vec::new() };
        surface.join_edges();
        surface.split_vertices();
        surface
    }

    fn join_edges(&mut self) {
        self.mates = vec![NONE; 3 * self.triangles.len()];
        let is_left_out = |face: usize| self.is_hole(face as u32);
        // Edges by the end with the smaller number; those with one other end are one edge.
        let edges = Edges::new(&self.triangles, self.points.len(), is_left_out, u32::min);
        let mut list: Vec<(u32, u32)> = Vec::new();
        for vertex in 0..self.points.len() as u32 {
            list.clear();
            list.extend(edges.of(vertex).iter().map(|half| (self.origin(*half).max(self.target(*half)), *half)));
            list.sort_unstable();
            for edge in list.chunk_by(|a, b| a.0 == b.0) {
                if let [(_, first), (_, second)] = edge
                    && self.origin(*first) != self.origin(*second)
                {
                    self.mates[*first as usize] = *second;
                    self.mates[*second as usize] = *first;
                }
            }
        }
    }

    /// Gives each fan of faces a vertex of its own and finds its first half-edge.
    fn split_vertices(&mut self) {
        self.leaving = vec![NONE; self.points.len()];
        let mut is_seen = vec![false; self.mates.len()];
        for corner in 0..self.mates.len() as u32 {
            if is_seen[corner as usize] {
                continue;
            }
            // Clockwise to the boundary, or once around.
            let mut first = corner;
            while let Some(half) = self.clockwise(first) {
                first = half;
                if first == corner {
                    break;
                }
            }
            let mut vertex = self.origin(first);
            if self.leaving[vertex as usize] != NONE {
                self.points.push(self.points[vertex as usize]);
                self.leaving.push(NONE);
                vertex = self.points.len() as u32 - 1;
            }
            self.leaving[vertex as usize] = first;
            let mut half = first;
            loop {
                is_seen[half as usize] = true;
                self.triangles[half as usize / 3][half as usize % 3] = vertex;
                match self.counter_clockwise(half) {
                    Some(other) if other != first => half = other,
                    _ => break,
                }
            }
        }
    }

    /// Returns whether a triangle is a part of a face that is a hole.
    pub fn is_hole(&self, triangle: u32) -> bool {
        self.holes.binary_search(&self.sources[triangle as usize]).is_ok()
    }

    /// Returns the vertex that a half-edge leaves.
    pub fn origin(&self, half: u32) -> u32 {
        self.triangles[half as usize / 3][half as usize % 3]
    }

    /// Returns the vertex that a half-edge leads to.
    pub fn target(&self, half: u32) -> u32 {
        self.origin(next(half))
    }

    /// Returns the opposite half-edge.
    pub fn mate(&self, half: u32) -> Option<u32> {
        Some(self.mates[half as usize]).filter(|mate| *mate != NONE)
    }

    /// Returns the next half-edge that leaves the same vertex, counter-clockwise.
    pub fn counter_clockwise(&self, half: u32) -> Option<u32> {
        self.mate(previous(half))
    }

    /// Returns the next half-edge that leaves the same vertex, clockwise.
    pub fn clockwise(&self, half: u32) -> Option<u32> {
        self.mate(half).map(next)
    }

    /// Returns the half-edges that leave a vertex within its faces, counter-clockwise from the first.
    pub fn fan(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let first = self.leaving[vertex as usize];
        let start = (first != NONE).then_some(first);
        std::iter::successors(start, move |half| self.counter_clockwise(*half).filter(|half| *half != first))
    }

    /// Returns whether the faces around a vertex leave a gap.
    pub fn is_boundary(&self, vertex: u32) -> bool {
        let first = self.leaving[vertex as usize];
        first == NONE || self.mates[first as usize] == NONE
    }

    /// Returns the positions of the corners of a triangle.
    pub fn corners(&self, face: u32) -> [Vec3; 3] {
        self.triangles[face as usize].map(|vertex| self.points[vertex as usize])
    }

    /// Returns the distance of two vertices.
    pub fn distance(&self, a: u32, b: u32) -> f64 {
        length(minus(self.points[a as usize], self.points[b as usize]))
    }

    /// Returns the area of a triangle.
    pub fn area(&self, face: u32) -> f64 {
        let [a, b, c] = self.corners(face);
        0.5 * length(cross(minus(b, a), minus(c, a)))
    }
}

/// Returns `a - b`.
pub fn minus(a: Vec3, b: Vec3) -> Vec3 {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Returns the point at a share of the way from `a` to `b`.
pub fn between(a: Vec3, b: Vec3, share: f64) -> Vec3 {
    std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]))
}

/// Returns the scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the length of a vector.
pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(points: usize, triangles: &[[u32; 3]]) -> Surface {
        let points = (0..points).map(|index| [index as f64, (index * index) as f64, 0.0]).collect();
        Surface::from_triangles(points, triangles.to_vec(), (0..triangles.len() as u32).collect(), Vec::new())
    }

    #[test]
    fn fans_run_counter_clockwise_and_end_at_the_boundary() {
        let closed = surface(4, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]);
        let around: Vec<u32> = closed.fan(0).map(|half| closed.target(half)).collect();
        assert_eq!(around, [1, 2, 3]);
        assert!((0..4).all(|vertex| !closed.is_boundary(vertex)));
        let open = surface(4, &[[0, 2, 3], [0, 1, 2]]);
        let around: Vec<u32> = open.fan(0).map(|half| open.target(half)).collect();
        assert_eq!(around, [1, 2]);
        assert!(open.is_boundary(0));
    }

    #[test]
    fn edges_of_three_faces_and_bow_ties_come_apart() {
        let book = surface(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!(book.mates.iter().all(|mate| *mate == NONE));
        let tie = surface(5, &[[0, 1, 2], [0, 3, 4]]);
        assert_eq!(tie.points.len(), 6);
        assert_ne!(tie.triangles[0][0], tie.triangles[1][0]);
        assert_eq!(tie.points[tie.triangles[1][0] as usize], tie.points[0]);
    }
}
