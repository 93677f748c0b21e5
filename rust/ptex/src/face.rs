//! Faces: their resolutions and their neighbours, as they stand in a file.

use relievo_core::{Error, Result};

use crate::fields::Fields;
use crate::format::{MeshType, Resolution};

/// What lies beyond an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Neighbor {
    /// The face. Where two sub-faces share the edge, the first of them counter-clockwise.
    pub face: u32,
    /// Its edge that is this one.
    pub edge: u8,
}

/// A face and its place among the others.
///
/// Edge 0 is v = 0, 1 is u = 1, 2 is v = 1, 3 is u = 0. Triangles have edges 0 to 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Face {
    /// Texels along u and v.
    pub resolution: Resolution,
    /// What lies beyond every edge; `None` at the border of the mesh.
    pub neighbors: [Option<Neighbor>; 4],
    /// The face is a corner of a polygon that is no quad.
    pub subface: bool,
}

/// All texels have one value, which stands among the constants.
pub(crate) const CONSTANT: u8 = 1;
/// Texels come from an edit. Never stored.
pub(crate) const EDITED: u8 = 2;
/// So do the texels around it, and it is the same value.
pub(crate) const CONSTANT_NEIGHBORHOOD: u8 = 4;
const SUBFACE: u8 = 8;
const BORDER: u32 = u32::MAX;

/// A face as it stands in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Record {
    pub face: Face,
    pub flags: u8,
}

impl Record {
    pub const SIZE: usize = 20;

    pub fn has(&self, flag: u8) -> bool {
        self.flags & flag != 0
    }

    /// True if the value among the constants says all.
    pub fn is_constant(&self) -> bool {
        self.has(CONSTANT) || self.face.resolution == Resolution::default()
    }

    /// What orders the faces of reductions: larger first. Constant faces count as two texels wide.
    pub fn rank(&self) -> u8 {
        if self.has(CONSTANT) { 1 } else { self.face.resolution.least() }
    }

    pub fn write(&self, out: &mut Vec<u8>) {
        let neighbors = self.face.neighbors;
        let edge = |index: usize| neighbors[index].map_or(0, |neighbor| (neighbor.edge & 3) << (2 * index));
        let flags = self.flags & !EDITED & !SUBFACE | if self.face.subface { SUBFACE } else { 0 };
        out.extend([self.face.resolution.u, self.face.resolution.v, (0..4).map(edge).sum(), flags]);
        for neighbor in neighbors {
            out.extend(neighbor.map_or(BORDER, |neighbor| neighbor.face).to_le_bytes());
        }
    }

    /// Reads and checks the record of a face among `count`.
    pub fn read(fields: &mut Fields, mesh: MeshType, count: u32) -> Result<Self> {
        let resolution = Resolution::new(fields.u8()?, fields.u8()?);
        let (edges, flags) = (fields.u8()?, fields.u8()?);
        let mut neighbors = [None; 4];
        for (index, neighbor) in neighbors.iter_mut().enumerate() {
            let face = fields.u32()?;
            // The fourth edge of triangles says nothing.
            if face != BORDER && (mesh == MeshType::Quad || index < 3) {
                *neighbor = Some(Neighbor { face, edge: edges >> (2 * index) & 3 });
            }
        }
        let face = Face { resolution, neighbors, subface: flags & SUBFACE != 0 };
        face.check(mesh, count)?;
        Ok(Self { face, flags: flags & (CONSTANT | CONSTANT_NEIGHBORHOOD) })
    }
}

impl Face {
    /// A face of 2^u by 2^v texels without neighbours.
    pub fn new(u: u8, v: u8) -> Self {
        Self { resolution: Resolution::new(u, v), ..Self::default() }
    }

    /// Checks that resolution and neighbours are possible in a mesh of `count` faces.
    ///
    /// # Errors
    /// Fails with `Invalid` if a neighbour is no edge of the mesh, and as [`Resolution::check`] does.
    pub fn check(&self, mesh: MeshType, count: u32) -> Result<()> {
        self.resolution.check(mesh)?;
        let edges = if mesh == MeshType::Triangle { 3 } else { 4 };
        for (edge, neighbor) in self.neighbors.iter().enumerate() {
            let Some(neighbor) = neighbor else { continue };
            if neighbor.face >= count || neighbor.edge >= edges || edge >= usize::from(edges) {
                return Err(Error::invalid(format!(
                    "the neighbour of edge {edge} is edge {} of face {}, which does not exist",
                    neighbor.edge, neighbor.face
                ))
                .advise(format!("name one of {count} faces of {edges} edges, or none")));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_has_the_documented_bytes() {
        let at = |face, edge| Some(Neighbor { face, edge });
        let face = Face {
            resolution: Resolution::new(5, 3),
            neighbors: [at(1, 2), None, at(7, 3), at(258, 1)],
            subface: true,
        };
        let mut bytes = Vec::new();
        Record { face, flags: CONSTANT | EDITED }.write(&mut bytes);
        let expected = [5, 3, 0b01_11_00_10, 0b1001, 1, 0, 0, 0, 255, 255, 255, 255, 7, 0, 0, 0, 2, 1, 0, 0];
        assert_eq!(bytes, expected);
        let back = Record::read(&mut Fields::new(&bytes, 0), MeshType::Quad, 259).unwrap();
        assert_eq!(back, Record { face, flags: CONSTANT });
        assert!(Record::read(&mut Fields::new(&bytes, 0), MeshType::Quad, 258).is_err());
        bytes[0] = 3;
        bytes[2] = 2;
        // A triangle's fourth neighbour is not looked at.
        let triangle = Record::read(&mut Fields::new(&bytes, 0), MeshType::Triangle, 8).unwrap();
        assert_eq!(triangle.face.neighbors, [at(1, 2), None, at(7, 0), None]);
        bytes[2] = 3;
        assert!(Record::read(&mut Fields::new(&bytes, 0), MeshType::Triangle, 8).is_err());
        assert!(Record::read(&mut Fields::new(&bytes[..19], 0), MeshType::Quad, 259).is_err());
    }
}
