//! Attributes of a mesh on their way to triangles that lie in its faces: interpolated for corners and points, copied
//! for faces.

use relievo_core::{Attribute, Domain, Mesh, Values};

use super::topology::TriangleTopology;

/// Triangles in the faces of a triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pieces {
    /// Places: a face of the mesh and the barycentric coordinates in it.
    pub places: Vec<(u32, [f32; 3])>,
    /// Per corner of every triangle the place it is at.
    pub corners: Vec<u32>,
    /// Per point a place where it is; `None` for a point of the mesh, which keeps its number.
    pub points: Vec<Option<u32>>,
}

impl Pieces {
    /// The attributes of `mesh`, whose triangles are those of `topology`, but not the ones called `except`.
    /// Integers, and the weights that belong to joints, are those of the nearest corner.
    pub fn carry(&self, mesh: &Mesh, topology: &TriangleTopology, except: &[&str]) -> Vec<Attribute> {
        let offsets = mesh.face_offsets();
        // The corners of the mesh that the corners of each of its triangles are.
        let mut fans = Vec::with_capacity(topology.face_count());
        let mut last = (u32::MAX, 0);
        for face in 0..topology.face_count() as u32 {
            let polygon = topology.polygon(face);
            last = if last.0 == polygon { (polygon, last.1 + 1) } else { (polygon, 0) };
            let first = offsets.get(polygon as usize).copied().unwrap_or(0) as usize;
            fans.push([first, first + last.1 + 1, first + last.1 + 2]);
        }
        let kept = mesh.attributes.iter().filter(|attribute| !except.contains(&attribute.name.as_str()));
        kept.map(|attribute| self.attribute(mesh, topology, &fans, attribute)).collect()
    }

    fn attribute(&self, mesh: &Mesh, topology: &TriangleTopology, fans: &[[usize; 3]], from: &Attribute) -> Attribute {
        let width = from.width as usize;
        let value = |corner: usize| match (from.domain, &from.indices) {
            (Domain::Corner, Some(indices)) => indices[corner] as usize,
            (Domain::Corner, None) => corner,
            _ => mesh.corners[corner] as usize,
        };
        // What is copied from one value, and what is between three.
        let place = |place: u32| {
            let (face, at) = self.places[place as usize];
            let corner = (1..3).fold(0, |best, corner| if at[corner] > at[best] { corner } else { best });
            (value(fans[face as usize][corner]), Some((face, at)))
        };
        let list: Vec<(usize, Option<(u32, [f32; 3])>)> = match from.domain {
            Domain::Point => {
                let points = self.points.iter().enumerate();
                points.map(|(point, at)| at.map_or((point, None), place)).collect()
            }
            Domain::Corner => (0..self.places.len() as u32).map(place).collect(),
            Domain::Face => {
                let faces = self.corners.chunks_exact(3).map(|corners| self.places[corners[0] as usize].0);
                faces.map(|face| (topology.polygon(face) as usize, None)).collect()
            }
        };
        let copied = from.name == "weights";
        let values = match &from.values {
            Values::U32(values) => {
                Values::U32(list.iter().flat_map(|(nearest, _)| &values[nearest * width..][..width]).copied().collect())
            }
            Values::F32(values) => {
                let mut out = Vec::with_capacity(list.len() * width);
                for (nearest, between) in list {
                    match between.filter(|_| !copied) {
                        Some((face, at)) => {
                            let corners = fans[face as usize].map(value);
                            let mean =
                                |axis: usize| (0..3).map(|k| values[corners[k] * width + axis] * at[k]).sum::<f32>();
                            out.extend((0..width).map(mean));
                        }
                        None => out.extend_from_slice(&values[nearest * width..][..width]),
                    }
                }
                Values::F32(out)
            }
        };
        let indices = (from.domain == Domain::Corner).then(|| self.corners.clone());
        Attribute { name: from.name.clone(), domain: from.domain, width: from.width, values, indices }
    }
}
