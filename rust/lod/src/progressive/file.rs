//! Progressive meshes as files: the base mesh, then the splits from the coarsest on in chunks, each compressed and with
//! its sum, so that a beginning of a file is a coarser mesh.
//!
//! Numbers are little-endian. The head: the signature, the version, how many vertices, triangles, base vertices, base
//! triangles and splits there are, three numbers of four bytes each for origin and step of the lattice that places of
//! split vertices are on, and the sum of all that (CRC-32). Every chunk: the bytes it has, those it has compressed (zstd),
//! and the sum of the latter. The base comes first, then [`CHUNK`] splits a chunk. A chunk has columns of numbers of four
//! bytes, each column as its four planes of bytes. Numbers of splits, vertices and leaves are differences to that of the
//! split. Version 2 has attributes, in what `wedge_columns` adds; meshes without any are of version 1.

use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Result, file};

use super::active::ActiveMesh;
use super::hierarchy::{AT, LEAF, Progressive};
use super::packing::{Lattice, Normal};
use super::recording::Key;
use super::wedge_columns::{self, Columns, Told};
use crate::connectivity::NONE;

const SIGNATURE: &[u8; 8] = b"RLVPROG\n";
const VERSION: u32 = 1;
/// The version of meshes with attributes.
const ATTRIBUTED: u32 = 2;
/// Bytes of the head, with its sum.
const HEAD: usize = 8 + 6 * 4 + 6 * 4 + 4;
/// Splits of a chunk.
const CHUNK: usize = 1 << 14;
/// Columns of a chunk at most: the split, its tag, key and parent, and of two sides the child, a place of four numbers, a
/// normal, three leaves and a number.
const COLUMNS: usize = 4 + 2 * (1 + 4 + 1 + 4);
const LEVEL: i32 = 5;

/// Tags of a split, for the first side; those of the second are one bit higher.
const IS_LEAF: u32 = 1;
const IS_AT: u32 = 4;
const HAS_FACE: u32 = 16;

/// Columns that are written.
#[derive(Default)]
pub(super) struct Writer(Vec<u8>);

impl Writer {
    pub(super) fn column(&mut self, values: &[u32]) {
        for plane in 0..4 {
            self.0.extend(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
    }

    /// The bytes of a chunk.
    fn chunk(self) -> std::io::Result<Vec<u8>> {
        let packed = zstd::bulk::compress(&self.0, LEVEL)?;
        let head = [self.0.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
        Ok(head.into_iter().flat_map(u32::to_le_bytes).chain(packed).collect())
    }
}

/// Columns that are read.
pub(super) struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    pub(super) fn column(&mut self, count: usize) -> Result<Vec<u32>> {
        let (bytes, rest) = self.0.split_at_checked(4 * count).ok_or_else(|| damaged("a chunk is too short"))?;
        self.0 = rest;
        let byte = |plane: usize, index: usize| u32::from(bytes[plane * count + index]) << (8 * plane);
        Ok((0..count).map(|index| byte(0, index) | byte(1, index) | byte(2, index) | byte(3, index)).collect())
    }
}

pub(super) fn damaged(what: &str) -> Error {
    Error::invalid(what).advise("the file is damaged: build it again")
}

/// What vertices are, where and with what normals, by columns.
#[derive(Default)]
struct Vertices {
    children: Vec<u32>,
    leaf_points: [Vec<u32>; 3],
    inner_points: [Vec<u32>; 2],
    leaves_at: Vec<u32>,
    normals: Vec<u32>,
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
    fn read(from: &mut Reader, tags: impl Iterator<Item = u32> + Clone) -> Result<Self> {
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
struct Faces([Vec<u32>; 4]);

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

    fn read(from: &mut Reader, count: usize) -> Result<Self> {
        Ok(Self([from.column(count)?, from.column(count)?, from.column(count)?, from.column(count)?]))
    }
}

impl Progressive {
    /// Writes a file, which is there when it is complete.
    pub fn save(&self, context: &Context, path: &Path) -> Result<()> {
        file::store(path, |out| self.write(context, out))
    }

    /// Writes the mesh.
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

    /// Opens a file. `faces` is how fine a mesh is wanted: what comes after is not read. Fails if the file is damaged or
    /// of a newer version, or the mesh needs more than `context`'s memory.
    pub fn open(context: &Context, path: &Path, faces: usize) -> Result<Self> {
        let mut source = std::io::BufReader::new(file::open(path)?);
        Self::read(context, &mut source, faces).map_err(|error| error.at(path.display().to_string()))
    }

    /// As [`Self::open`], from any source.
    pub fn read(context: &Context, source: &mut impl Read, faces: usize) -> Result<Self> {
        let mut head = [0; HEAD];
        source
            .read_exact(&mut head)
            .map_err(|_| Error::invalid("it is no progressive mesh, or its beginning is missing"))?;
        let (told, sum) = head.split_at(HEAD - 4);
        if &told[..8] != SIGNATURE {
            return Err(Error::invalid("it is no progressive mesh").advise("build one of a mesh first"));
        }
        let word = |at: usize| u32::from_le_bytes([told[at], told[at + 1], told[at + 2], told[at + 3]]);
        let version = word(8);
        if version != VERSION && version != ATTRIBUTED {
            return Err(Error::unsupported(format!("version {} of the format is not known", word(8)))
                .advise("use the program that wrote it, or a newer one of this"));
        }
        if crc32fast::hash(told).to_le_bytes() != sum {
            return Err(damaged("the head has another sum than it tells"));
        }
        let counts = Counts::new(std::array::from_fn(|index| word(12 + 4 * index)))?;
        let vector = |at: usize| Vec3::from_array([0, 4, 8].map(|axis| f32::from_bits(word(at + axis))));
        let lattice = Lattice::from_parts(vector(32), vector(44));
        let lattice = lattice.ok_or_else(|| damaged("the lattice of places is not finite"))?;
        let mut budget = Budget::new(context.memory_limit());
        let told = match version {
            ATTRIBUTED => Some(Told::read(&chunk(source, &mut budget, wedge_columns::MOST)?, counts.splits)?),
            _ => None,
        };
        let more = |wedges: usize, faces: usize| told.as_ref().map_or(0, |told| told.bytes(wedges, faces));
        let of_base = base_bytes(&counts) + more(told.as_ref().map_or(0, |told| told.base), counts.base_faces);
        let of_split = 4 * COLUMNS + more(2, 2);
        let mut loading = Loading::new(&counts, lattice, &mut budget)?;
        let bytes = chunk(source, &mut budget, of_base)?;
        loading.base(&bytes, &counts, told, &mut budget)?;
        drop(bytes);
        let mut left = counts.splits;
        while left > 0 && loading.mesh.base_faces().len() + loading.triangles < faces {
            let count = left.min(CHUNK);
            loading.splits(&chunk(source, &mut budget, of_split * count)?, count)?;
            left -= count;
        }
        loading.finish(context)
    }
}

/// What a file has.
struct Counts {
    vertices: usize,
    triangles: usize,
    base_vertices: usize,
    base_faces: usize,
    splits: usize,
}

impl Counts {
    fn new(told: [u32; 5]) -> Result<Self> {
        let [vertices, triangles, base_vertices, base_faces, splits] = told.map(|count| count as usize);
        let is_whole = vertices < 1 << 30
            && triangles < 1 << 30
            && base_vertices.checked_add(splits) == Some(vertices)
            && base_faces <= triangles
            && triangles - base_faces <= 2 * splits;
        if !is_whole {
            return Err(damaged("the head tells numbers that do not fit each other"));
        }
        Ok(Self { vertices, triangles, base_vertices, base_faces, splits })
    }
}

/// Bytes that the chunk of the base may have.
fn base_bytes(counts: &Counts) -> usize {
    4 * (COLUMNS * counts.base_vertices + 4 * counts.base_faces)
}

/// The bytes of the next chunk, at most `most`.
fn chunk(source: &mut impl Read, budget: &mut Budget, most: usize) -> Result<Vec<u8>> {
    let ended = |_| damaged("the file ends too early");
    let mut head = [0; 12];
    source.read_exact(&mut head).map_err(ended)?;
    let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (raw, packed) = (word(0) as usize, word(4) as usize);
    if raw > most || packed > most + most / 128 + 1024 {
        return Err(damaged("a chunk is larger than what it has to hold"));
    }
    // Both go before the next chunk comes.
    Budget::new(budget.left()).charge((raw + packed) as u64)?;
    let mut bytes = Vec::new();
    source.take(packed as u64).read_to_end(&mut bytes).map_err(ended)?;
    if bytes.len() != packed {
        return Err(damaged("the file ends too early"));
    }
    if crc32fast::hash(&bytes) != word(8) {
        return Err(damaged("a chunk has another sum than it tells"));
    }
    let raw_bytes = zstd::bulk::decompress(&bytes, raw).map_err(|_| damaged("a chunk cannot be unpacked"))?;
    if raw_bytes.len() != raw { Err(damaged("a chunk has other bytes than it tells")) } else { Ok(raw_bytes) }
}

/// A mesh that is read.
struct Loading {
    mesh: Progressive,
    /// The range of leaves of every vertex that may be split, by its split; empty for those that no vertex tells of.
    ranges: Vec<[u32; 2]>,
    /// Vertices and triangles of the input that are there.
    seen_vertices: Vec<bool>,
    seen_faces: Vec<bool>,
    /// Triangles that splits have brought.
    triangles: usize,
    last: (Key, u32),
    wedges: Option<wedge_columns::Loading>,
}

impl Loading {
    fn new(counts: &Counts, lattice: Lattice, budget: &mut Budget) -> Result<Self> {
        Ok(Self {
            mesh: Progressive::empty(counts.vertices, counts.triangles, lattice, budget)?,
            ranges: budget.filled(counts.vertices, [0; 2])?,
            seen_vertices: budget.filled(counts.vertices, false)?,
            seen_faces: budget.filled(counts.triangles, false)?,
            triangles: 0,
            last: (Key(u32::MAX), u32::MAX),
            wedges: None,
        })
    }

    fn base(&mut self, bytes: &[u8], counts: &Counts, told: Option<Told>, budget: &mut Budget) -> Result<()> {
        let mut from = Reader(bytes);
        let leaves = from.column(counts.base_vertices)?;
        let tags = from.column(counts.base_vertices)?;
        let vertices = Vertices::read(&mut from, tags.iter().copied())?;
        let faces = Faces::read(&mut from, counts.base_faces)?;
        let ends = leaves.iter().skip(1).copied().chain([counts.vertices as u32]);
        let mut next = Next::default();
        if leaves.first() != Some(&0) {
            return Err(damaged("the base does not begin at the first leaf"));
        }
        for ((leaf, end), tag) in leaves.iter().zip(ends).zip(&tags) {
            if *leaf >= end || end as usize > counts.vertices {
                return Err(damaged("base vertices are out of order"));
            }
            let child = self.vertex(&vertices, &mut next, *tag, [*leaf, end], *leaf, 2 * leaf)?;
            self.mesh.splits[*leaf as usize].children[0] = child;
        }
        self.mesh.base_vertices = leaves;
        let places = self.mesh.base_places(counts.base_faces);
        for (index, place) in places.iter().enumerate() {
            self.face(&faces, index, *place, 0)?;
        }
        self.mesh.base_faces = places;
        if let Some(told) = told {
            let columns = Columns::read(&mut from, told.widths, [0, told.base], counts.base_faces)?;
            self.wedges = Some(wedge_columns::Loading::base(told, &columns, &self.mesh, budget)?);
        }
        Ok(())
    }

    fn splits(&mut self, bytes: &[u8], count: usize) -> Result<()> {
        let mut from = Reader(bytes);
        let (numbers, tags) = (from.column(count)?, from.column(count)?);
        let (keys, parents) = (from.column(count)?, from.column(count)?);
        let sides = tags.iter().flat_map(|tag| [*tag, tag >> 1]);
        let vertices = Vertices::read(&mut from, sides.clone())?;
        let face_count = sides.filter(|tag| tag & HAS_FACE != 0).count();
        let faces = Faces::read(&mut from, face_count)?;
        let parts = tags.iter().map(|tag| wedge_columns::count(*tag)).sum();
        let columns = match &self.wedges {
            Some(wedges) => Some(Columns::read(&mut from, wedges.trees.widths, [parts; 2], face_count)?),
            None => None,
        };
        let (mut next, mut face, mut part) = (Next::default(), 0, 0);
        for (((split, tag), key), parent) in numbers.into_iter().zip(tags).zip(keys).zip(parents) {
            let key = Key(key);
            let [start, end] = self.ranges.get(split as usize).copied().unwrap_or_default();
            if split <= start || split >= end || self.mesh.splits[split as usize].key != Key::default() {
                return Err(damaged("a split has no vertex it could split"));
            }
            let node = parent.wrapping_add(2 * split);
            if key.depth() == 0 || (key, split) >= self.last || self.mesh.parent(split) != node {
                return Err(damaged("splits are out of order"));
            }
            let above = self.mesh.splits[node as usize / 2].key;
            if above != Key::default() && above.depth() <= key.depth() {
                return Err(damaged("a split is no less deep than the one it stands on"));
            }
            self.last = (key, split);
            self.mesh.splits[split as usize].key = key;
            for (side, range) in (0..).zip([[start, split], [split, end]]) {
                let child = self.vertex(&vertices, &mut next, tag >> side, range, split, 2 * split + side)?;
                self.mesh.splits[split as usize].children[side as usize] = child;
                if tag >> side & HAS_FACE != 0 {
                    self.face(&faces, face, 2 * split + side, split)?;
                    if let Some((wedges, columns)) = self.wedges.as_mut().zip(columns.as_ref()) {
                        wedges.face(columns, face, 2 * split + side, &self.mesh)?;
                    }
                    face += 1;
                    self.triangles += 1;
                }
            }
            if let Some((wedges, columns)) = self.wedges.as_mut().zip(columns.as_ref()) {
                wedges.split(columns, &mut part, tag, split)?;
            }
        }
        Ok(())
    }

    /// Takes the next vertex in, which stands for a range of leaves. Returns what it is.
    fn vertex(
        &mut self,
        columns: &Vertices,
        next: &mut Next,
        tag: u32,
        [start, end]: [u32; 2],
        from: u32,
        node: u32,
    ) -> Result<u32> {
        let (told, normal) = (columns.children[next.vertex], Normal(columns.normals[next.vertex]));
        next.vertex += 1;
        if tag & IS_LEAF != 0 {
            let is_new = self.seen_vertices.get_mut(told as usize).is_some_and(|seen| !std::mem::replace(seen, true));
            if end - start != 1 || !is_new {
                return Err(damaged("a vertex of the finest mesh is out of place"));
            }
            self.mesh.normals[start as usize] = normal;
            self.point(columns, next, start)?;
            return Ok(LEAF | told);
        }
        let split = told.wrapping_add(from);
        if split <= start || split >= end {
            return Err(damaged("a split is not where its vertex is"));
        }
        let packed = if tag & IS_AT != 0 {
            let leaf = columns.leaves_at[next.at].wrapping_add(from);
            next.at += 1;
            if leaf as usize >= self.mesh.points.len() {
                return Err(damaged("a vertex stays at one that is not there"));
            }
            self.point(columns, next, leaf)?;
            AT | u64::from(leaf)
        } else {
            next.inner += 1;
            let [low, high] = [0, 1].map(|half| u64::from(columns.inner_points[half][next.inner - 1]));
            (low | high << 32) & !AT
        };
        self.mesh.inner_points[split as usize] = packed;
        self.mesh.inner_normals[split as usize] = normal;
        self.mesh.splits[split as usize].parent = node;
        self.ranges[split as usize] = [start, end];
        Ok(split)
    }

    fn point(&mut self, columns: &Vertices, next: &mut Next, leaf: u32) -> Result<()> {
        let point = [0, 1, 2].map(|axis| f32::from_bits(columns.leaf_points[axis][next.point]));
        next.point += 1;
        if !point.iter().all(|value| value.is_finite()) {
            return Err(damaged("a place is not finite"));
        }
        self.mesh.points[leaf as usize] = point;
        Ok(())
    }

    fn face(&mut self, columns: &Faces, index: usize, place: u32, from: u32) -> Result<()> {
        let [a, b, c, id] = [0, 1, 2, 3].map(|column| columns.0[column][index]);
        let leaves = [a, b, c].map(|leaf| leaf.wrapping_add(from));
        let is_new = self.seen_faces.get_mut(id as usize).is_some_and(|seen| !std::mem::replace(seen, true));
        if !is_new || leaves.iter().any(|leaf| *leaf as usize >= self.mesh.points.len()) {
            return Err(damaged("a triangle is out of place"));
        }
        self.mesh.set_face(place, leaves, id);
        Ok(())
    }

    fn finish(self, context: &Context) -> Result<Progressive> {
        let mut mesh = self.mesh;
        mesh.wedges = self.wedges.map(|wedges| Arc::new(wedges.trees));
        let mesh = Arc::new(mesh);
        if !ActiveMesh::new(&mesh).is_sound(context) {
            return Err(damaged("splits do not come after those they stand on"));
        }
        Arc::into_inner(mesh).ok_or_else(|| Error::internal("a mesh that is read is used already"))
    }
}

/// The next places of columns.
#[derive(Default)]
struct Next {
    vertex: usize,
    point: usize,
    inner: usize,
    at: usize,
}
