//! How the triangles of a mesh meet: edges with the sides of faces along them, vertices with the corners around them.
//!
//! An edge is a pair of vertices, whichever and however many faces it has: one at a boundary, three and more where the
//! mesh is not a manifold. It runs from the vertex with the lower number to the other, and so has a direction of its
//! own that both neighbours know. Nothing assumes that faces are wound alike. Everything is in the order of faces and
//! vertices, so that it is the same on every run.

use std::ops::Range;

use relievo_core::{Error, Mesh, Result};

/// A side of a triangle, from corner `side` to the next, and the edge it lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleSide {
    /// The edge.
    pub edge: u32,
    /// Whether the side runs against the edge's own direction.
    pub reversed: bool,
}

/// The connectivity of a triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleTopology {
    faces: Vec<[u32; 3]>,
    /// Twice the edge of every side, plus 1 where it is reversed.
    sides: Vec<[u32; 3]>,
    /// From the lower vertex to the higher.
    edges: Vec<[u32; 2]>,
    /// `3 · face + side` of the sides along every edge.
    along: Lists,
    /// `3 · face + corner` of the corners at every vertex.
    around: Lists,
    /// The polygon of the mesh that each triangle is a part of, where not all are triangles of it in order.
    polygons: Option<Vec<u32>>,
}

/// Lists of numbers, one after the other.
#[derive(Clone, Debug, PartialEq)]
struct Lists {
    offsets: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn range(&self, list: u32) -> Range<usize> {
        self.offsets[list as usize] as usize..self.offsets[list as usize + 1] as usize
    }

    fn of(&self, list: u32) -> &[u32] {
        &self.items[self.range(list)]
    }
}

impl TriangleTopology {
    /// The triangles of `mesh`. Polygons are fanned from their first corner; holes are left out.
    ///
    /// # Errors
    /// Fails as [`Mesh::check`] does, and with `Invalid` if all faces are holes or there would be 2³⁰ triangles or
    /// more.
    pub fn of_mesh(mesh: &Mesh) -> Result<Self> {
        mesh.check()?;
        let triangles = mesh.triangles();
        if triangles.is_empty() {
            return Err(Error::invalid("all faces of the mesh are holes").advise("give it a face that is none"));
        }
        if triangles.len() >= 1 << 30 {
            return Err(Error::invalid("the mesh has 2^30 triangles or more").advise("split it"));
        }
        let plain = triangles.len() == mesh.face_count() && mesh.holes.is_empty();
        let polygons = (!plain).then(|| {
            let mut holes = mesh.holes.clone();
            holes.sort_unstable();
            let shown = (0..).zip(&mesh.face_sizes).filter(|(face, _)| holes.binary_search(face).is_err());
            shown.flat_map(|(face, size)| std::iter::repeat_n(face, *size as usize - 2)).collect()
        });
        let mut topology = Self::of_triangles(mesh.points.len(), triangles);
        topology.polygons = polygons;
        Ok(topology)
    }

    /// Vertices of triangles exist and do not repeat.
    fn of_triangles(vertex_count: usize, faces: Vec<[u32; 3]>) -> Self {
        // Sorted by the vertices of the edge, then by side.
        let mut keys: Vec<(u64, u32)> = (0u32..)
            .zip(&faces)
            .flat_map(|(face, corners)| {
                (0..3).map(move |side| {
                    let [a, b] = [corners[side], corners[(side + 1) % 3]];
                    (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), 3 * face + side as u32)
                })
            })
            .collect();
        keys.sort_unstable();
        let mut edges = Vec::with_capacity(keys.len() / 2 + 1);
        let mut along =
            Lists { offsets: Vec::with_capacity(keys.len() / 2 + 2), items: Vec::with_capacity(keys.len()) };
        let mut sides = vec![[0; 3]; faces.len()];
        for (at, (key, item)) in keys.iter().enumerate() {
            if at == 0 || keys[at - 1].0 != *key {
                along.offsets.push(at as u32);
                edges.push([(key >> 32) as u32, *key as u32]);
            }
            let (face, side) = ((item / 3) as usize, (item % 3) as usize);
            let reversed = faces[face][side] > faces[face][(side + 1) % 3];
            sides[face][side] = 2 * (edges.len() as u32 - 1) + u32::from(reversed);
            along.items.push(*item);
        }
        along.offsets.push(keys.len() as u32);
        let mut offsets = vec![0u32; vertex_count + 1];
        for corner in faces.as_flattened() {
            offsets[*corner as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            offsets[vertex + 1] += offsets[vertex];
        }
        let mut next = offsets.clone();
        let mut items = vec![0; 3 * faces.len()];
        for (item, corner) in (0..).zip(faces.as_flattened()) {
            items[next[*corner as usize] as usize] = item;
            next[*corner as usize] += 1;
        }
        Self { faces, sides, edges, along, around: Lists { offsets, items }, polygons: None }
    }

    /// Number of triangles.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Number of vertices, those without a face among them.
    pub fn vertex_count(&self) -> usize {
        self.around.offsets.len() - 1
    }

    /// The vertices of all triangles.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The vertices of `face`. Panics if there is no such face.
    pub fn face(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize]
    }

    /// A side of `face`, 0 to 2. Panics if there is no such face.
    pub fn side(&self, face: u32, side: u32) -> TriangleSide {
        let side = self.sides[face as usize][side as usize % 3];
        TriangleSide { edge: side >> 1, reversed: side & 1 != 0 }
    }

    /// The edges along the sides of `face`. Panics if there is no such face.
    pub fn edges_of(&self, face: u32) -> [u32; 3] {
        self.sides[face as usize].map(|side| side >> 1)
    }

    /// The ends of `edge`, in its own direction. Panics if there is no such edge.
    pub fn edge(&self, edge: u32) -> [u32; 2] {
        self.edges[edge as usize]
    }

    /// Faces along `edge`, and which of their sides, ascending. Panics if there is no such edge.
    pub fn faces_along(&self, edge: u32) -> impl ExactSizeIterator<Item = (u32, u32)> + '_ {
        self.along.of(edge).iter().map(|item| (item / 3, item % 3))
    }

    /// Faces at `vertex`, and which of their corners, ascending. Panics if there is no such vertex.
    pub fn faces_around(&self, vertex: u32) -> impl ExactSizeIterator<Item = (u32, u32)> + '_ {
        self.around.of(vertex).iter().map(|item| (item / 3, item % 3))
    }

    /// The face of the mesh that `face` is a part of. Panics if there is no such face.
    pub fn polygon(&self, face: u32) -> u32 {
        self.polygons.as_ref().map_or(face, |polygons| polygons[face as usize])
    }

    /// Edges with a single face.
    pub fn boundary_count(&self) -> usize {
        self.along.offsets.windows(2).filter(|pair| pair[1] - pair[0] == 1).count()
    }

    /// Edges with three faces and more.
    pub fn branching_count(&self) -> usize {
        self.along.offsets.windows(2).filter(|pair| pair[1] - pair[0] > 2).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_the_edge_between_them() {
        let mesh = Mesh::from_triangles(vec![[0.0; 3]; 5], &[[0, 1, 2], [2, 1, 3]]);
        let topology = TriangleTopology::of_mesh(&mesh).unwrap();
        assert_eq!((topology.face_count(), topology.edge_count(), topology.vertex_count()), (2, 5, 5));
        let shared = topology.side(0, 1);
        assert_eq!((topology.edge(shared.edge), shared.reversed), ([1, 2], false));
        assert_eq!(topology.side(1, 0), TriangleSide { reversed: true, ..shared });
        assert_eq!(topology.faces_along(shared.edge).collect::<Vec<_>>(), [(0, 1), (1, 0)]);
        assert_eq!(topology.faces_around(1).collect::<Vec<_>>(), [(0, 1), (1, 1)]);
        assert_eq!(topology.faces_around(4).len(), 0);
        assert_eq!((topology.boundary_count(), topology.branching_count()), (4, 0));
    }

    #[test]
    fn sides_edges_and_corners_agree_however_faces_are_wound() {
        // Three faces along one edge, one of them wound the other way, and two fans that meet at a vertex only.
        let faces = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [4, 5, 6]];
        let topology = TriangleTopology::of_mesh(&Mesh::from_triangles(vec![[0.0; 3]; 7], &faces)).unwrap();
        assert_eq!(topology.branching_count(), 1);
        for face in 0..4 {
            for side in 0..3 {
                let TriangleSide { edge, reversed } = topology.side(face, side);
                let mut ends = [faces[face as usize][side as usize], faces[face as usize][(side as usize + 1) % 3]];
                if reversed {
                    ends.reverse();
                }
                assert_eq!(topology.edge(edge), ends);
                assert!(topology.faces_along(edge).any(|at| at == (face, side)));
                assert!(topology.faces_around(faces[face as usize][side as usize]).any(|at| at == (face, side)));
            }
        }
        let along: usize = (0..topology.edge_count() as u32).map(|edge| topology.faces_along(edge).len()).sum();
        let around: usize = (0..7).map(|vertex| topology.faces_around(vertex).len()).sum();
        assert_eq!((along, around), (12, 12));
    }

    #[test]
    fn polygons_are_fanned_and_holes_left_out() {
        let mut mesh = Mesh::new(vec![[0.0; 3]; 6], vec![3, 4, 3], vec![0, 1, 2, 2, 1, 3, 4, 3, 4, 5]);
        mesh.holes.push(0);
        let topology = TriangleTopology::of_mesh(&mesh).unwrap();
        assert_eq!(topology.faces(), [[2, 1, 3], [2, 3, 4], [3, 4, 5]]);
        assert_eq!([0, 1, 2].map(|face| topology.polygon(face)), [1, 1, 2]);
        mesh.holes = vec![0, 1, 2];
        assert!(TriangleTopology::of_mesh(&mesh).is_err());
        mesh.holes.clear();
        mesh.points[0][0] = f32::NAN;
        assert!(TriangleTopology::of_mesh(&mesh).is_err());
    }
}
