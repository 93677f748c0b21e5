//! What the blocks of a document belong to: tiles, or the elements of a triangle mesh, by number.
//!
//! On a triangle mesh the numbers are first those of the triangles, then those of the edges, pairs of points in
//! ascending order, then points 256 by 256. A pattern of T segments an edge keeps T − 1 values on an edge and
//! ⌊(3T/2)(T/2 − 1) + 1⌋ in a triangle (Schäfer et al. 2015, Local Painting and Deformation of Meshes on the GPU,
//! Section 6); a block has the values of T, T/2 or T/4, the points have one each.

use relievo_core::budget::Budget;
use relievo_core::{Error, Result};

/// Points that share a block.
const POINTS: u32 = 256;
/// Segments of an edge at the finest.
const SEGMENTS: [u32; 4] = [8, 16, 32, 64];
/// How many times the segments of a block may be halved.
const LEVELS: u32 = 2;

/// What blocks belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lattice {
    /// The tiles of a Catmull-Clark surface.
    Tiles,
    /// The triangles, edges and points of a mesh.
    Triangles {
        /// Number of triangles.
        faces: u32,
        /// Number of edges.
        edges: u32,
        /// Number of points.
        points: u32,
    },
}

/// What a block of a triangle mesh belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A triangle.
    Triangle(u32),
    /// An edge.
    Edge(u32),
    /// Points from this one on.
    Points(u32),
}

impl Lattice {
    /// That of triangles between `points` points. Fails if there are others than triangles, or a corner is no point.
    pub(crate) fn of_triangles(
        face_sizes: &[u32],
        corners: &[u32],
        points: usize,
        budget: &mut Budget,
    ) -> Result<Self> {
        if face_sizes.iter().any(|size| *size != 3) || corners.len() != 3 * face_sizes.len() {
            return Err(Error::invalid("not all of its faces are triangles"));
        }
        if points > 1 << 30 || corners.iter().any(|corner| *corner as usize >= points) {
            return Err(Error::invalid("a corner of its mesh is no point of it"));
        }
        if face_sizes.len() >= 1 << 30 {
            return Err(Error::unsupported("the mesh has 2^30 triangles or more"));
        }
        let mut edges = Vec::new();
        budget.reserve(&mut edges, corners.len())?;
        for [a, b, c] in corners.as_chunks().0 {
            edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [*a.min(b), *a.max(b)]));
        }
        edges.sort_unstable();
        edges.dedup();
        Ok(Self::Triangles { faces: face_sizes.len() as u32, edges: edges.len() as u32, points: points as u32 })
    }

    /// What the block of a triangle mesh belongs to; `None` if there is none with that number, or blocks are those of
    /// tiles.
    pub fn element(self, block: u32) -> Option<Element> {
        let Self::Triangles { faces, edges, points } = self else { return None };
        if block < faces {
            return Some(Element::Triangle(block));
        }
        let rest = block - faces;
        if rest < edges {
            return Some(Element::Edge(rest));
        }
        let first = (rest - edges).checked_mul(POINTS)?;
        (first < points).then_some(Element::Points(first))
    }

    /// Number of blocks of a triangle mesh; 0 where blocks are those of tiles.
    pub fn block_count(self) -> u32 {
        match self {
            Self::Tiles => 0,
            Self::Triangles { faces, edges, points } => faces + edges + points.div_ceil(POINTS),
        }
    }

    /// The numbers of values that a block of a triangle mesh may have, the most first, where faces have `segments`
    /// segments an edge.
    pub(crate) fn values(self, block: u32, segments: u32) -> Vec<u64> {
        let levels = (0..=LEVELS).map(|level| u64::from(segments >> level)).filter(|segments| *segments >= 2);
        match (self, self.element(block)) {
            (_, Some(Element::Triangle(_))) => levels.map(|t| 3 * t / 2 * (t / 2 - 1) + 1).collect(),
            (_, Some(Element::Edge(_))) => levels.map(|t| t - 1).collect(),
            (Self::Triangles { points, .. }, Some(Element::Points(first))) => {
                vec![u64::from((points - first).min(POINTS))]
            }
            _ => Vec::new(),
        }
    }

    /// Fails if blocks are those of a triangle mesh and its faces cannot have `segments` segments an edge, or not all
    /// the same.
    pub(crate) fn check(self, segments: &[u32]) -> Result<()> {
        let Some(first) = segments.first().filter(|_| self != Self::Tiles) else { return Ok(()) };
        if !SEGMENTS.contains(first) || segments.iter().any(|other| other != first) {
            return Err(Error::invalid("its triangles have an impossible number of segments")
                .advise("give all of them 8, 16, 32 or 64"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_triangles_are_counted_and_have_the_values_of_the_pattern() {
        let corners = [0, 1, 2, 2, 1, 3, 0, 2, 4];
        let of = |points| Lattice::of_triangles(&[3; 3], &corners, points, &mut Budget::new(1 << 20));
        let lattice = of(600).unwrap();
        assert_eq!(lattice, Lattice::Triangles { faces: 3, edges: 7, points: 600 });
        assert_eq!(lattice.block_count(), 13);
        let elements: Vec<_> = (0..14).map(|block| lattice.element(block)).collect();
        assert_eq!(elements[2..4], [Some(Element::Triangle(2)), Some(Element::Edge(0))]);
        assert_eq!(
            elements[9..],
            [
                Some(Element::Edge(6)),
                Some(Element::Points(0)),
                Some(Element::Points(256)),
                Some(Element::Points(512)),
                None
            ]
        );
        assert_eq!(lattice.element(u32::MAX), None);
        assert_eq!(lattice.values(0, 16), [169, 37, 7]);
        assert_eq!(lattice.values(5, 64), [63, 31, 15]);
        assert_eq!([10, 11, 12, 13].map(|block| lattice.values(block, 8)), [vec![256], vec![256], vec![88], vec![]]);
        assert!(of(4).is_err());
        assert!(Lattice::of_triangles(&[3; 3], &corners, 600, &mut Budget::new(10)).is_err());
        assert!(Lattice::of_triangles(&[4, 5], &corners, 600, &mut Budget::new(1 << 20)).is_err());
        lattice.check(&[16; 3]).unwrap();
        assert!(lattice.check(&[16, 16, 32]).is_err() && lattice.check(&[128; 3]).is_err());
    }
}
