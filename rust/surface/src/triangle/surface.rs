//! Points and smooth normals of a triangle mesh. Triangles are flat; normals are interpolated between those of the
//! vertices, which are the means of the faces around them, each with its angle there (Max 1999, Weights for Computing
//! Vertex Normals from Facet Normals, compares the choices).

use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Error, Mesh, Result};

use super::topology::TriangleTopology;

/// A triangle mesh in one pose.
#[derive(Clone, Debug)]
pub struct TriangleSurface {
    topology: Arc<TriangleTopology>,
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// Vertices worked on at a time.
const CHUNK: usize = 1024;

impl TriangleSurface {
    /// The triangles of `mesh`; polygons are fanned and holes left out.
    ///
    /// # Errors
    /// Fails as [`TriangleTopology::of_mesh`] does.
    pub fn new(context: &Context, mesh: &Mesh) -> Result<Self> {
        let topology = Arc::new(TriangleTopology::of_mesh(mesh)?);
        let surface = Self { topology, points: Vec::new(), normals: Vec::new() };
        surface.posed(context, &mesh.points)
    }

    /// The same triangles with other points.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many points or one is not finite.
    pub fn posed(&self, context: &Context, points: &[[f32; 3]]) -> Result<Self> {
        let count = self.topology.vertex_count();
        if points.len() != count {
            return Err(Error::invalid(format!("{} points were given, the mesh has {count}", points.len())));
        }
        if let Some(index) = points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
            return Err(Error::invalid("a coordinate is not a finite number").at(format!("point {index}")));
        }
        let topology = &*self.topology;
        let normals = context.map(count.div_ceil(CHUNK), |chunk| {
            let vertices = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
            vertices.map(|vertex| vertex_normal(topology, points, vertex as u32)).collect::<Vec<_>>()
        });
        Ok(Self { topology: self.topology.clone(), points: points.to_vec(), normals: normals.concat() })
    }

    /// How the triangles meet.
    pub fn topology(&self) -> &Arc<TriangleTopology> {
        &self.topology
    }

    /// Positions of the vertices.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// Unit normals of the vertices; zero where no face around a vertex has an area.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// The volume that the triangles enclose, if they are closed; negative if they look inwards.
    pub fn volume(&self) -> f64 {
        let volume = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| DVec3::from(self.points[vertex as usize].map(f64::from)));
            a.dot(b.cross(c)) / 6.0
        };
        self.topology.faces().iter().map(volume).sum()
    }

    /// Positions of the corners of `face`. Panics if there is no such face.
    pub fn corner_points(&self, face: u32) -> [[f32; 3]; 3] {
        self.topology.face(face).map(|vertex| self.points[vertex as usize])
    }

    /// Normals of the corners of `face`. Panics if there is no such face.
    pub fn corner_normals(&self, face: u32) -> [[f32; 3]; 3] {
        self.topology.face(face).map(|vertex| self.normals[vertex as usize])
    }
}

/// The mean of the normals of the faces at a vertex by their angles.
fn vertex_normal(topology: &TriangleTopology, points: &[[f32; 3]], vertex: u32) -> [f32; 3] {
    let at = |vertex: u32| DVec3::from(points[vertex as usize].map(f64::from));
    let here = at(vertex);
    let sum: DVec3 = topology
        .faces_around(vertex)
        .map(|(face, corner)| {
            let corners = topology.face(face);
            let [a, b] = [1, 2].map(|k| at(corners[(corner as usize + k) % 3]) - here);
            let cross = a.cross(b);
            cross.normalize_or_zero() * cross.length().atan2(a.dot(b))
        })
        .sum();
    sum.normalize_or_zero().as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_cube_point_along_its_diagonals_however_it_is_cut() {
        let points: Vec<[f32; 3]> =
            (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
        let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mesh = Mesh::new(points.clone(), vec![4; 6], quads.concat());
        let context = Context::serial();
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        assert_eq!(surface.topology().face_count(), 12);
        for (point, normal) in points.iter().zip(surface.normals()) {
            for axis in 0..3 {
                assert!((normal[axis] - point[axis] / 3f32.sqrt()).abs() < 1e-6, "{point:?} {normal:?}");
            }
        }
        assert!((surface.volume() - 8.0).abs() < 1e-6);
        let moved: Vec<[f32; 3]> = points.iter().map(|[x, y, z]| [x + 1.0, 2.0 * y, *z]).collect();
        let posed = surface.posed(&context, &moved).unwrap();
        assert_eq!(posed.points(), moved);
        assert!(surface.posed(&context, &moved[1..]).is_err());
        assert!(surface.posed(&context, &[[f32::NAN; 3]; 8]).is_err());
    }

    #[test]
    fn faces_without_an_area_and_vertices_without_a_face_have_no_normal() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3], [1.0, 0.0, 0.0]];
        let mesh = Mesh::from_triangles(points, &[[0, 1, 2], [0, 1, 3], [1, 2, 5]]);
        let surface = TriangleSurface::new(&Context::serial(), &mesh).unwrap();
        assert_eq!(surface.normals()[3], [0.0, 0.0, 1.0]);
        assert_eq!((surface.normals()[2], surface.normals()[4]), ([0.0; 3], [0.0; 3]));
        assert!(surface.normals().iter().flatten().all(|value| value.is_finite()));
    }
}
