//! The mesh a document belongs to: its faces, by which tiles are numbered, and hashes of them and of its sharpness.
//!
//! Faces and corners are kept whole, so that a mesh that does not fit can be told what differs and where. Points are
//! not: a mesh that moved is the same mesh.

use std::fmt;

use relievo_core::budget::Budget;
use relievo_core::mesh::INFINITE_SHARPNESS;
use relievo_core::{Error, Mesh, Result};

use crate::lattice::{Element, Lattice};

/// Faces and corners of a mesh, its holes, and a hash of its sharpness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    face_sizes: Vec<u32>,
    corners: Vec<u32>,
    /// Ascending.
    holes: Vec<u32>,
    sharpness: u64,
    /// The first tile of every face, and at the end the number of tiles.
    tiles: Vec<u32>,
    lattice: Lattice,
}

/// What differs between the mesh of a document and another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Faces of the document and of the mesh.
    pub faces: [usize; 2],
    /// Corners of the document and of the mesh.
    pub corners: [usize; 2],
    /// Of the faces that both have, those whose corners differ.
    pub differing: usize,
    /// The first of those, with its corners in the document and in the mesh.
    pub first: Option<(usize, [Vec<u32>; 2])>,
    /// Whether other faces are holes.
    pub holes: bool,
}

impl Topology {
    /// That of `mesh`.
    ///
    /// # Errors
    /// Fails with `Invalid` if its sizes and corners do not agree or a hole is no face, with `Unsupported` if it has
    /// more tiles than 32 bits count, and with `Memory` if the system has no memory for them.
    pub fn of(mesh: &Mesh) -> Result<Self> {
        let mut holes = mesh.holes.clone();
        holes.sort_unstable();
        holes.dedup();
        Self::new(mesh.face_sizes.clone(), mesh.corners.clone(), holes, sharpness(mesh))
    }

    /// That of the triangles of `mesh`, whose blocks are those of a triangle mesh; polygons are fanned, holes left out.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or has more than 2³⁰ points, with `Unsupported`
    /// if there are 2³⁰ triangles or more, and with `Memory` if the system has no memory for their edges.
    pub fn of_triangles(mesh: &Mesh) -> Result<Self> {
        mesh.check()?;
        let triangles = mesh.triangles();
        let topology = Self::new(vec![3; triangles.len()], triangles.into_flattened(), Vec::new(), 0)?;
        topology.into_triangles(mesh.points.len(), &mut Budget::new(u64::MAX))
    }

    /// The same with blocks of a triangle mesh. Fails if there are other faces than triangles or a corner is no point.
    pub(crate) fn into_triangles(mut self, points: usize, budget: &mut Budget) -> Result<Self> {
        if !self.holes.is_empty() {
            return Err(Error::invalid("triangles of its mesh are holes"));
        }
        self.lattice = Lattice::of_triangles(&self.face_sizes, &self.corners, points, budget)?;
        Ok(self)
    }

    pub(crate) fn new(face_sizes: Vec<u32>, corners: Vec<u32>, holes: Vec<u32>, sharpness: u64) -> Result<Self> {
        let count: u64 = face_sizes.iter().map(|size| u64::from(*size)).sum();
        if count != corners.len() as u64 {
            return Err(Error::invalid(format!("its faces have {count} corners and {} are listed", corners.len())));
        }
        if holes.windows(2).any(|pair| pair[0] >= pair[1])
            || holes.last().is_some_and(|face| *face as usize >= face_sizes.len())
        {
            return Err(Error::invalid("its holes are not faces in order"));
        }
        let mut tiles = Vec::new();
        tiles
            .try_reserve_exact(face_sizes.len() + 1)
            .map_err(|_| Error::memory("the system has no memory for the faces of the document"))?;
        let mut total = 0u32;
        tiles.push(total);
        for size in &face_sizes {
            total = total
                .checked_add(if *size == 4 { 1 } else { *size })
                .ok_or_else(|| Error::unsupported("the mesh has more than 4294967295 tiles"))?;
            tiles.push(total);
        }
        Ok(Self { face_sizes, corners, holes, sharpness, tiles, lattice: Lattice::Tiles })
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.face_sizes.len()
    }

    /// Number of corners of every face.
    pub fn face_sizes(&self) -> &[u32] {
        &self.face_sizes
    }

    /// Point of every corner, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Faces that are holes, ascending.
    pub fn holes(&self) -> &[u32] {
        &self.holes
    }

    /// What blocks belong to.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Whether blocks are those of a triangle mesh.
    pub fn is_of_triangles(&self) -> bool {
        self.lattice != Lattice::Tiles
    }

    /// Number of blocks that a layer can have.
    pub fn block_count(&self) -> u32 {
        if self.is_of_triangles() { self.lattice.block_count() } else { self.tile_count() }
    }

    /// What people call a block.
    pub fn block_name(&self, block: u32) -> String {
        match self.lattice.element(block) {
            Some(Element::Triangle(face)) => format!("triangle {face}"),
            Some(Element::Edge(edge)) => format!("edge {edge}"),
            Some(Element::Points(first)) => format!("points from {first} on"),
            None => {
                let face = self.face_of(block).map_or(0, |(face, _)| face);
                format!("tile {block} of face {face}")
            }
        }
    }

    /// Number of tiles: one per quad, n per face of n corners.
    pub fn tile_count(&self) -> u32 {
        self.tiles.last().copied().unwrap_or(0)
    }

    /// The face of `tile`, and whether it is one of the several of its face; `None` if there is no such tile.
    pub fn face_of(&self, tile: u32) -> Option<(u32, bool)> {
        if tile >= self.tile_count() {
            return None;
        }
        let face = self.tiles.partition_point(|first| *first <= tile) - 1;
        Some((face as u32, self.face_sizes[face] != 4))
    }

    /// A hash of faces, corners and holes: equal for equal meshes, in every version.
    pub fn fingerprint(&self) -> u64 {
        let counts = [self.face_sizes.len() as u32, self.corners.len() as u32, self.holes.len() as u32];
        hash([&counts[..], &self.face_sizes, &self.corners, &self.holes].into_iter().flatten().copied())
    }

    /// The hash of creases and sharp points, see [`sharpness`].
    pub fn sharpness(&self) -> u64 {
        self.sharpness
    }

    /// What differs in `mesh`; `None` if its faces, corners and holes are the same.
    pub fn difference(&self, mesh: &Mesh) -> Option<Difference> {
        let mut holes = mesh.holes.clone();
        holes.sort_unstable();
        holes.dedup();
        let holes = holes != self.holes;
        if !holes && mesh.face_sizes == self.face_sizes && mesh.corners == self.corners {
            return None;
        }
        let (mut differing, mut first) = (0, None);
        for (face, [there, here]) in faces(self, mesh).enumerate() {
            if there != here {
                differing += 1;
                first.get_or_insert_with(|| (face, [there.to_vec(), here.to_vec()]));
            }
        }
        let faces = [self.face_sizes.len(), mesh.face_sizes.len()];
        Some(Difference { faces, corners: [self.corners.len(), mesh.corners.len()], differing, first, holes })
    }
}

/// The corners of the faces that both meshes have.
fn faces<'a>(document: &'a Topology, mesh: &'a Mesh) -> impl Iterator<Item = [&'a [u32]; 2]> {
    let (mut there, mut here) = (document.corners.as_slice(), mesh.corners.as_slice());
    document.face_sizes.iter().zip(&mesh.face_sizes).map(move |(a, b)| {
        let (face_a, rest_a) = there.split_at((*a as usize).min(there.len()));
        let (face_b, rest_b) = here.split_at((*b as usize).min(here.len()));
        (there, here) = (rest_a, rest_b);
        [face_a, face_b]
    })
}

/// A hash of the creases and sharp points of a mesh that sharpen anything, in whatever order they are listed.
pub fn sharpness(mesh: &Mesh) -> u64 {
    let kept = |sharpness: f32| (sharpness > 0.0).then(|| sharpness.min(INFINITE_SHARPNESS).to_bits());
    let creases = mesh.creases.iter().filter_map(|crease| {
        let [a, b] = crease.points;
        Some([a.min(b), a.max(b), kept(crease.sharpness)?])
    });
    // No edge has the same point twice, so that points cannot be taken for edges.
    let points = mesh.sharp_points.iter().filter_map(|(point, sharpness)| Some([*point, *point, kept(*sharpness)?]));
    let mut all: Vec<[u32; 3]> = creases.chain(points).collect();
    all.sort_unstable();
    hash(all.into_iter().flatten())
}

/// FNV-1a over the bytes of `numbers`.
fn hash(numbers: impl Iterator<Item = u32>) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    numbers.flat_map(u32::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, step)
}

impl fmt::Display for Difference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [faces, corners] = [self.faces, self.corners];
        if faces[0] != faces[1] || corners[0] != corners[1] {
            write!(
                out,
                "it has {} faces and {} corners, this one {} and {}; ",
                faces[0], corners[0], faces[1], corners[1]
            )?;
        }
        match &self.first {
            None if faces[0] == faces[1] => {
                write!(out, "all {} faces are the same, but other ones are holes", faces[0])
            }
            None => write!(out, "the first {} faces are the same", faces[0].min(faces[1])),
            Some((face, [there, here])) => {
                let (count, of) = (self.differing, faces[0].min(faces[1]));
                write!(out, "{count} of {of} faces differ, the first is face {face} with the points ")?;
                write!(out, "{} there and {} here", listed(there), listed(here))
            }
        }
    }
}

/// Points of a face, a few of them.
fn listed(points: &[u32]) -> String {
    const SHOWN: usize = 8;
    let mut text: Vec<String> = points.iter().take(SHOWN).map(u32::to_string).collect();
    if points.len() > SHOWN {
        text.push(format!("… ({} in all)", points.len()));
    }
    text.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::mesh::Crease;

    fn mesh() -> Mesh {
        Mesh::new(vec![[0.0; 3]; 9], vec![4, 4, 3, 3], vec![0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 3, 7, 6])
    }

    #[test]
    fn tiles_are_numbered_as_those_of_surfaces() {
        let topology = Topology::of(&mesh()).unwrap();
        assert_eq!(topology.tile_count(), 8);
        let faces: Vec<_> = (0..9).map(|tile| topology.face_of(tile)).collect();
        assert_eq!(faces[..3], [Some((0, false)), Some((1, false)), Some((2, true))]);
        assert_eq!(faces[4..], [Some((2, true)), Some((3, true)), Some((3, true)), Some((3, true)), None]);
    }

    #[test]
    fn fingerprints_stay_and_tell_meshes_apart() {
        let one = Topology::of(&mesh()).unwrap();
        let mut moved = mesh();
        moved.points[3] = [9.0; 3];
        moved.creases.push(Crease { points: [0, 1], sharpness: 2.0 });
        assert_eq!(one.fingerprint(), Topology::of(&moved).unwrap().fingerprint());
        // Documents hold it, so that it must never change.
        assert_eq!(format!("{:016x}", one.fingerprint()), "d9e561e5b5a80599");
        let changes: [fn(&mut Mesh); 4] = [
            |mesh| mesh.corners.swap(0, 1),
            |mesh| mesh.face_sizes.swap(1, 2),
            |mesh| mesh.holes.push(2),
            |mesh| {
                mesh.face_sizes.pop();
                mesh.corners.truncate(11);
            },
        ];
        for change in changes {
            let mut other = mesh();
            change(&mut other);
            assert_ne!(Topology::of(&other).unwrap().fingerprint(), one.fingerprint());
            assert!(one.difference(&other).is_some());
        }
    }

    #[test]
    fn sharpness_does_not_depend_on_how_it_is_listed() {
        let crease = |a: u32, b: u32, sharpness: f32| Crease { points: [a, b], sharpness };
        let with =
            |creases: Vec<Crease>, sharp_points: Vec<(u32, f32)>| sharpness(&Mesh { creases, sharp_points, ..mesh() });
        let one = with(vec![crease(0, 1, 2.0), crease(4, 1, 12.0)], vec![(3, 1.0)]);
        assert_eq!(one, with(vec![crease(1, 4, 10.0), crease(1, 0, 2.0), crease(2, 5, 0.0)], vec![(3, 1.0)]));
        assert_ne!(one, with(vec![crease(1, 4, 10.0), crease(1, 0, 2.5)], vec![(3, 1.0)]));
        assert_ne!(with(vec![], vec![(3, 1.0)]), with(vec![], vec![]));
    }

    #[test]
    fn differences_say_how_many_and_where() {
        let topology = Topology::of(&mesh()).unwrap();
        assert_eq!(topology.difference(&mesh()), None);
        let text = |change: &dyn Fn(&mut Mesh)| {
            let mut other = mesh();
            change(&mut other);
            topology.difference(&other).unwrap().to_string()
        };
        assert_eq!(
            text(&|mesh| mesh.corners[4..8].rotate_left(1)),
            "1 of 4 faces differ, the first is face 1 with the points 1 2 5 4 there and 2 5 4 1 here"
        );
        assert_eq!(
            text(&|mesh| {
                mesh.face_sizes.push(3);
                mesh.corners.extend([4, 5, 8]);
            }),
            "it has 4 faces and 14 corners, this one 5 and 17; the first 4 faces are the same"
        );
        assert_eq!(
            text(&|mesh| {
                mesh.face_sizes = vec![10, 4];
            }),
            "it has 4 faces and 14 corners, this one 2 and 14; 2 of 2 faces differ, the first is face 0 with the \
             points 0 1 4 3 there and 0 1 4 3 1 2 5 4 … (10 in all) here"
        );
        assert_eq!(text(&|mesh| mesh.holes.push(3)), "all 4 faces are the same, but other ones are holes");
    }
}
