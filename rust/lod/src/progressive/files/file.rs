//! Progressive meshes as files: the base mesh, then the splits from the coarsest on in chunks, each compressed and with
//! its sum, so that a beginning of a file is a coarser mesh.
//!
//! Numbers are little-endian. The head: the signature, the version, how many vertices, triangles, base vertices, base
//! triangles and splits there are, three numbers of four bytes each for origin and step of the lattice that places of
//! split vertices are on, and the sum of all that (CRC-32). Every chunk: the bytes it has, those it has compressed (zstd),
//! and the sum of the latter. The base comes first, then [`CHUNK`] splits a chunk. A chunk has columns of numbers of four
//! bytes, each column as its four planes of bytes. Numbers of splits, vertices and leaves are differences to that of the
//! split. Version 2 has attributes, in what `wedge_columns` adds; meshes without any are of version 1. How files are read:
//! `reading`, and as they arrive: [`arrival`](super::arrival).

use std::io::Write;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use super::format::{Reader, Writer};
use super::wedge_columns::Columns;
use crate::connectivity::NONE;
use crate::progressive::build::cut::Cut;
use crate::progressive::build::hierarchy::{AT, LEAF, Progressive};
use crate::progressive::build::recording::Key;

pub(super) const SIGNATURE: &[u8; 8] = b"RLVPROG\n";
pub(super) const VERSION: u32 = 1;
/// The version of meshes with attributes.
pub(super) const ATTRIBUTED: u32 = 2;
/// Bytes of the head, with its sum.
pub(crate) const HEAD: usize = 8 + 6 * 4 + 6 * 4 + 4;
/// Splits of a chunk.
pub(super) const CHUNK: usize = 1 << 14;
/// Columns of a chunk at most: the split, its tag, key and parent, and of two sides the child, a place of four numbers, a
/// normal, three leaves and a number.
pub(super) const COLUMNS: usize = 4 + 2 * (1 + 4 + 1 + 4);

/// Tags of a split, for the first side; those of the second are one bit higher.
pub(super) const IS_LEAF: u32 = 1;
pub(super) const IS_AT: u32 = 4;
pub(super) const HAS_FACE: u32 = 16;

/// What vertices are, where and with what normals, by columns.
#[derive(Default)]
pub(super) struct Vertices {
    pub(crate) children: Vec<u32>,
    pub(super) leaf_points: [Vec<u32>; 3],
    pub(crate) inner_points: [Vec<u32>; 2],
    pub(super) leaves_at: Vec<u32>,
    pub(crate) normals: Vec<u32>,
}

impl Vertices {
    /// Adds a vertex; `leaf` is its first. Returns its tag.
    fn add(&mut self, mesh: &Progressive, child: u32, leaf: u32, from: u32) -> u32 {
        if child & LEAF != 0 {
            self.children.push(child & !LEAF);
            self.add_point(mesh, leaf);
            self.normals.push(mesh.normals[leaf as usize].0);
            return IS_LEAF;
        }
        self.children.push(child.wrapping_sub(from));
        self.normals.push(mesh.inner_normals[child as usize].0);
        let packed = mesh.inner_points[child as usize];
        if packed & AT != 0 {
            let at = (packed & !AT) as u32;
            self.leaves_at.push(at.wrapping_sub(from));
            self.add_point(mesh, at);
            return IS_AT;
        }
        self.inner_points[0].push(packed as u32);
        self.inner_points[1].push((packed >> 32) as u32);
        0
    }

    fn add_point(&mut self, mesh: &Progressive, leaf: u32) {
        for (column, value) in self.leaf_points.iter_mut().zip(mesh.points[leaf as usize]) {
            column.push(value.to_bits());
        }
    }

    fn write(&self, out: &mut Writer) {
        let columns = [&self.children].into_iter().chain(&self.leaf_points).chain(&self.inner_points);
        columns.chain([&self.leaves_at, &self.normals]).for_each(|column| out.column(column));
    }

    /// Of vertices with these tags.
    pub(crate) fn read(from: &mut Reader, tags: impl Iterator<Item = u32> + Clone) -> Result<Self> {
        let all = tags.clone().count();
        let leaves = tags.clone().filter(|tag| tag & IS_LEAF != 0).count();
        let at = tags.filter(|tag| tag & (IS_LEAF | IS_AT) == IS_AT).count();
        let mut columns = |count: usize| from.column(count);
        Ok(Self {
            children: columns(all)?,
            leaf_points: [columns(leaves + at)?, columns(leaves + at)?, columns(leaves + at)?],
            inner_points: [columns(all - leaves - at)?, columns(all - leaves - at)?],
            leaves_at: columns(at)?,
            normals: columns(all)?,
        })
    }
}

/// Triangles by columns: their leaves, and their numbers.
#[derive(Default)]
pub(super) struct Faces(pub(crate) [Vec<u32>; 4]);

impl Faces {
    fn add(&mut self, mesh: &Progressive, face: u32, from: u32) {
        let leaves = mesh.faces[face as usize].map(|leaf| leaf.wrapping_sub(from));
        for (column, value) in self.0.iter_mut().zip(leaves.into_iter().chain([mesh.face_id(face)])) {
            column.push(value);
        }
    }

    fn write(&self, out: &mut Writer) {
        self.0.iter().for_each(|column| out.column(column));
    }

    pub(crate) fn read(from: &mut Reader, count: usize) -> Result<Self> {
        Ok(Self([from.column(count)?, from.column(count)?, from.column(count)?, from.column(count)?]))
    }
}

impl Progressive {
    /// Writes a file, which is there when it is complete.
    ///
    /// # Errors
    /// Fails if not all of the mesh was read, or the file cannot be written.
    pub fn save(&self, context: &Context, path: &Path) -> Result<()> {
        self.check_whole()?;
        file::store(path, |out| self.write(context, out))
    }

    /// The bytes of the file that [`Self::save`] writes.
    ///
    /// # Errors
    /// Fails if not all of the mesh was read, or a part of it cannot be compressed.
    pub fn to_bytes(&self, context: &Context) -> Result<Vec<u8>> {
        self.check_whole()?;
        let mut bytes = Vec::new();
        self.write(context, &mut bytes).map_err(|error| Error::internal(error.to_string()))?;
        Ok(bytes)
    }

    fn check_whole(&self) -> Result<()> {
        match self.floor == Cut::FINEST {
            true => Ok(()),
            false => Err(Error::invalid("not all of it was read").advise("copy the file it is read from")),
        }
    }

    /// Writes the mesh.
    ///
    /// # Errors
    /// Fails with the error of `out`, or if a part of the mesh cannot be compressed.
    pub fn write(&self, context: &Context, out: &mut impl Write) -> std::io::Result<()> {
        let mut splits: Vec<(Key, u32)> = self.splits().map(|(split, key, _)| (key, split)).collect();
        splits.sort_unstable_by_key(|split| std::cmp::Reverse(*split));
        let (base, faces) = (self.base_vertices(), self.base_faces());
        let version = if self.wedges.is_some() { ATTRIBUTED } else { VERSION };
        let counts =
            [version, self.points.len() as u32, self.triangle_count() as u32, base.len() as u32, faces.len() as u32];
        let (origin, step) = self.lattice.parts();
        let mut head: Vec<u8> = SIGNATURE.to_vec();
        head.extend(counts.into_iter().chain([splits.len() as u32]).flat_map(u32::to_le_bytes));
        head.extend([origin, step].into_iter().flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes));
        head.extend(crc32fast::hash(&head).to_le_bytes());
        out.write_all(&head)?;
        if let Some(wedges) = &self.wedges {
            out.write_all(&Writer(wedges.head()).chunk()?)?;
        }
        out.write_all(&self.base_chunk()?)?;
        for part in splits.chunks(CHUNK * 4 * context.threads()) {
            let chunks = context.map(part.len().div_ceil(CHUNK), |chunk| {
                self.split_chunk(&part[chunk * CHUNK..part.len().min((chunk + 1) * CHUNK)])
            });
            for chunk in chunks {
                out.write_all(&chunk?)?;
            }
        }
        Ok(())
    }

    fn base_chunk(&self) -> std::io::Result<Vec<u8>> {
        let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
        let tag = |leaf: &u32| vertices.add(self, self.splits[*leaf as usize].children[0], *leaf, *leaf);
        let tags: Vec<u32> = self.base_vertices().iter().map(tag).collect();
        self.base_faces().iter().for_each(|face| faces.add(self, *face, 0));
        let mut out = Writer::default();
        out.column(self.base_vertices());
        out.column(&tags);
        vertices.write(&mut out);
        faces.write(&mut out);
        if let Some(trees) = &self.wedges {
            let mut columns = Columns::new(trees);
            trees.base.iter().for_each(|wedge| columns.add_base(trees, *wedge));
            self.base_faces().iter().for_each(|face| columns.add_face(trees, self, *face));
            columns.write(&mut out);
        }
        out.chunk()
    }

    fn split_chunk(&self, splits: &[(Key, u32)]) -> std::io::Result<Vec<u8>> {
        let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
        let (mut numbers, mut tags, mut keys, mut parents) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut wedges = self.wedges.as_ref().map(|trees| (trees, Columns::new(trees)));
        for (key, split) in splits {
            let mut all = 0;
            for side in 0..2 {
                let child = self.splits[*split as usize].children[side as usize];
                // The first vertex begins where the one that is split does, which only matters where it is a leaf.
                let leaf = if side == 0 { split - 1 } else { *split };
                all |= vertices.add(self, child, leaf, *split) << side;
                if self.faces[(2 * split + side) as usize][0] != NONE {
                    faces.add(self, 2 * split + side, *split);
                    all |= HAS_FACE << side;
                    if let Some((trees, columns)) = &mut wedges {
                        columns.add_face(trees, self, 2 * split + side);
                    }
                }
            }
            if let Some((trees, columns)) = &mut wedges {
                all |= columns.add_split(trees, *split);
            }
            numbers.push(*split);
            tags.push(all);
            keys.push(key.0);
            parents.push(self.parent(*split).wrapping_sub(2 * split));
        }
        let mut out = Writer::default();
        [numbers, tags, keys, parents].iter().for_each(|column| out.column(column));
        vertices.write(&mut out);
        faces.write(&mut out);
        if let Some((_, columns)) = wedges {
            columns.write(&mut out);
        }
        out.chunk()
    }
}
