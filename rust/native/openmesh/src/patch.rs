//! A triangle patch whose connectivity OpenMesh keeps.

use std::fmt;

use cxx::UniquePtr;
use relievo_core::{Error, Result};

use crate::bridge::ffi;
use crate::{library, manifold};

/// Stands for a vertex that does not exist.
pub const NONE: u32 = u32::MAX;

/// An edge with its two vertices and the vertices opposite to it, left and right of the direction from the first vertex
/// to the second; [`NONE`] on the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchEdge {
    /// The two vertices.
    pub ends: [u32; 2],
    /// The third vertices of the triangles on both sides.
    pub opposite: [u32; 2],
}

/// The points and triangles of a patch, numbered without gaps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compact {
    /// Positions of the vertices that a face uses.
    pub points: Vec<[f32; 3]>,
    /// Triangles of these points.
    pub triangles: Vec<[u32; 3]>,
    /// The number in the patch of each point.
    pub old_vertices: Vec<u32>,
    /// The number in the patch of each triangle.
    pub old_faces: Vec<u32>,
}

/// An oriented triangle manifold with or without boundary. Vertices and faces keep their numbers; new ones follow after
/// the last. Edges are given by their two vertices.
pub struct Patch(UniquePtr<ffi::Patch>);

impl fmt::Debug for Patch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Patch").field("vertices", &self.vertex_count()).field("faces", &self.face_count()).finish()
    }
}

/// Turns an exception of C++ into an error.
fn refused(exception: &cxx::Exception) -> Error {
    Error::invalid(exception.what()).at("patch")
}

impl Patch {
    /// Makes a patch of triangles.
    ///
    /// # Errors
    /// Names the faces at which the triangles are no oriented manifold, refuses coordinates that are not finite, and
    /// fails where OpenMesh is not installed.
    pub fn new(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self> {
        library::open()?;
        manifold::check(points, triangles)?;
        let mut patch = ffi::new_patch().map_err(|error| refused(&error))?;
        patch.pin_mut().add_vertices(points.as_flattened()).map_err(|error| refused(&error))?;
        let mut made = Vec::with_capacity(triangles.len());
        patch.pin_mut().add_faces(triangles.as_flattened(), &mut made).map_err(|error| refused(&error))?;
        Ok(Self(patch))
    }

    /// Copies the patch, so that a caller can return to it.
    ///
    /// # Errors
    /// Fails with `Invalid`, the kind of all exceptions of OpenMesh, if memory for the copy runs out.
    pub fn try_clone(&self) -> Result<Self> {
        self.0.copy().map(Self).map_err(|error| refused(&error))
    }

    /// Returns the number of vertices, removed ones included: numbers are below it.
    pub fn vertex_count(&self) -> usize {
        self.0.vertex_count()
    }

    /// Returns the number of faces, removed ones included: numbers are below it.
    pub fn face_count(&self) -> usize {
        self.0.face_count()
    }

    /// Adds triangles of existing vertices and returns their numbers. Puts back what [`Self::remove_faces`] removed.
    ///
    /// # Errors
    /// A vertex does not exist, or an edge has two faces already. Triangles before the refused one have been added.
    pub fn add_faces(&mut self, triangles: &[[u32; 3]]) -> Result<Vec<u32>> {
        let mut made = Vec::with_capacity(triangles.len());
        self.0.pin_mut().add_faces(triangles.as_flattened(), &mut made).map_err(|error| refused(&error))?;
        Ok(made)
    }

    /// Returns the positions of vertices.
    ///
    /// # Errors
    /// Fails with `Invalid` if a vertex does not exist.
    pub fn points(&self, vertices: &[u32]) -> Result<Vec<[f32; 3]>> {
        let mut out = vec![[0.0; 3]; vertices.len()];
        self.0.points(vertices, out.as_flattened_mut()).map_err(|error| refused(&error))?;
        Ok(out)
    }

    /// Moves vertices.
    ///
    /// # Errors
    /// Fails with `Invalid` if a vertex does not exist, or there are not as many points as vertices.
    pub fn set_points(&mut self, vertices: &[u32], points: &[[f32; 3]]) -> Result<()> {
        same_count(vertices.len(), points.len())?;
        self.0.pin_mut().set_points(vertices, points.as_flattened()).map_err(|error| refused(&error))
    }

    /// Returns every edge with the vertices around it.
    ///
    /// # Errors
    /// Fails only on an exception of OpenMesh; no case is known.
    pub fn edges(&self) -> Result<Vec<PatchEdge>> {
        // One call fills a slice: a call for each number took longer than all else that `relievo-repair` does.
        let mut numbers = vec![0; 4 * self.0.edge_slots()];
        let count = self.0.edges(&mut numbers).map_err(|error| refused(&error))?;
        let edges = &numbers.as_chunks::<4>().0[..count];
        Ok(edges.iter().map(|[a, b, left, right]| PatchEdge { ends: [*a, *b], opposite: [*left, *right] }).collect())
    }

    /// Splits edges in turn at new vertices and returns those. Each new vertex is joined to the vertices opposite to its
    /// edge: where consecutive edges share a face, their new vertices are joined by an edge, so that a path of crossed
    /// edges becomes a path of edges.
    ///
    /// # Errors
    /// An edge does not exist. Edges before it have been split.
    pub fn split_edges(&mut self, edges: &[[u32; 2]], points: &[[f32; 3]]) -> Result<Vec<u32>> {
        same_count(edges.len(), points.len())?;
        let mut made = Vec::with_capacity(edges.len());
        let split = self.0.pin_mut().split_edges(edges.as_flattened(), points.as_flattened(), &mut made);
        split.map_err(|error| refused(&error))?;
        Ok(made)
    }

    /// Splits faces into three at new vertices and returns those.
    ///
    /// # Errors
    /// A face does not exist. Faces before it have been split.
    pub fn split_faces(&mut self, faces: &[u32], points: &[[f32; 3]]) -> Result<Vec<u32>> {
        same_count(faces.len(), points.len())?;
        let mut made = Vec::with_capacity(faces.len());
        let split = self.0.pin_mut().split_faces(faces, points.as_flattened(), &mut made);
        split.map_err(|error| refused(&error))?;
        Ok(made)
    }

    /// Flips edges in turn. Returns which were flipped: an edge that does not exist, lies on the boundary or would become
    /// an edge that exists already stays.
    ///
    /// # Errors
    /// A vertex does not exist.
    pub fn flip_edges(&mut self, edges: &[[u32; 2]]) -> Result<Vec<bool>> {
        let mut done = vec![0; edges.len()];
        self.0.pin_mut().flip_edges(edges.as_flattened(), &mut done).map_err(|error| refused(&error))?;
        Ok(done.iter().map(|done| *done == 1).collect())
    }

    /// Collapses edges in turn, each first vertex into the second. Returns which were collapsed: an edge that is gone or
    /// fails the link condition (Dey, Edelsbrunner, Guha, Nekhayev 1999) stays.
    ///
    /// # Errors
    /// Fails only on an exception of OpenMesh; edges and vertices that do not exist are no error.
    pub fn collapse_edges(&mut self, edges: &[[u32; 2]]) -> Result<Vec<bool>> {
        let mut done = vec![0; edges.len()];
        self.0.pin_mut().collapse_edges(edges.as_flattened(), &mut done).map_err(|error| refused(&error))?;
        Ok(done.iter().map(|done| *done == 1).collect())
    }

    /// Removes faces; their vertices stay.
    ///
    /// # Errors
    /// A face does not exist. Faces before it have been removed.
    pub fn remove_faces(&mut self, faces: &[u32]) -> Result<()> {
        self.0.pin_mut().remove_faces(faces).map_err(|error| refused(&error))
    }

    /// Returns the loops of the boundary, each as its vertices in order with the surface on the right.
    ///
    /// # Errors
    /// Fails with `Invalid` if memory for the marks of half-edges runs out.
    pub fn boundary_loops(&self) -> Result<Vec<Vec<u32>>> {
        let (mut sizes, mut vertices) = (Vec::new(), Vec::new());
        self.0.boundary_loops(&mut sizes, &mut vertices).map_err(|error| refused(&error))?;
        let mut rest = vertices.as_slice();
        let loops = sizes.iter().map(|size| {
            let (one, tail) = rest.split_at(*size as usize);
            rest = tail;
            one.to_vec()
        });
        Ok(loops.collect())
    }

    /// Returns the number of parts that share no edge.
    ///
    /// # Errors
    /// Fails with `Invalid` if memory for the marks of faces runs out.
    pub fn components(&self) -> Result<usize> {
        self.0.components().map_err(|error| refused(&error))
    }

    /// Returns the Euler number: vertices less edges plus faces.
    ///
    /// # Errors
    /// Fails only on an exception of OpenMesh; no case is known.
    pub fn euler_number(&self) -> Result<i64> {
        self.0.euler_number().map_err(|error| refused(&error))
    }

    /// Returns whether the patch is a topological disk: one part with one boundary loop and Euler number 1.
    ///
    /// # Errors
    /// Fails as [`Self::components`] and [`Self::boundary_loops`] do.
    pub fn is_disk(&self) -> Result<bool> {
        Ok(self.components()? == 1 && self.euler_number()? == 1 && self.boundary_loops()?.len() == 1)
    }

    /// Returns points and triangles without gaps, with their numbers in the patch.
    ///
    /// # Errors
    /// Fails with `Invalid` if memory for the numbers of vertices runs out.
    pub fn read(&self) -> Result<Compact> {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        let mut compact = Compact::default();
        let Compact { old_vertices, old_faces, .. } = &mut compact;
        let read = self.0.read(&mut points, &mut triangles, old_vertices, old_faces);
        read.map_err(|error| refused(&error))?;
        compact.points = points.as_chunks().0.to_vec();
        compact.triangles = triangles.as_chunks().0.to_vec();
        Ok(compact)
    }
}

fn same_count(elements: usize, points: usize) -> Result<()> {
    if elements == points {
        return Ok(());
    }
    Err(Error::invalid(format!("there are {points} points for {elements} elements")).advise("give one point for each"))
}
