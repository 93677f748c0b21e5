//! How files of progressive meshes are read, part by part: [`file`](mod@super::file) says what they are.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Result, file};

use super::file::{ATTRIBUTED, CHUNK, COLUMNS, Faces, HAS_FACE, HEAD, IS_AT, IS_LEAF, SIGNATURE, VERSION, Vertices};
use super::format::{Reader, damaged};
use super::packing::{Lattice, Normal};
use super::wedge_columns::{self, Columns, Told};
use crate::progressive::build::hierarchy::{AT, LEAF, Progressive};
use crate::progressive::build::recording::Key;
use crate::progressive::mesh::active::ActiveMesh;

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

/// Bytes of the head of a chunk.
const CHUNK_HEAD: usize = 12;

/// What the head of a chunk tells: its bytes, those it has packed, and their sum. It may have `most` bytes.
fn chunk_head(head: &[u8], budget: &Budget, most: usize) -> Result<[usize; 3]> {
    let [raw, packed, sum] = [0, 4, 8].map(|at| word(head, at) as usize);
    if raw > most || packed > most + most / 128 + 1024 {
        return Err(damaged("a chunk is larger than what it has to hold"));
    }
    // Both go before the next chunk comes.
    Budget::new(budget.left()).charge((raw + packed) as u64)?;
    Ok([raw, packed, sum])
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// The bytes of the next chunk, at most `most`.
fn chunk(source: &mut impl Read, budget: &Budget, most: usize) -> Result<Vec<u8>> {
    let ended = |_| damaged("the file ends too early");
    let mut head = [0; CHUNK_HEAD];
    source.read_exact(&mut head).map_err(ended)?;
    let [raw, packed, sum] = chunk_head(&head, budget, most)?;
    let mut bytes = Vec::new();
    source.take(packed as u64).read_to_end(&mut bytes).map_err(ended)?;
    if bytes.len() != packed {
        return Err(damaged("the file ends too early"));
    }
    if crc32fast::hash(&bytes) as usize != sum {
        return Err(damaged("a chunk has another sum than it tells"));
    }
    let raw_bytes = zstd::bulk::decompress(&bytes, raw).map_err(|_| damaged("a chunk cannot be unpacked"))?;
    if raw_bytes.len() != raw { Err(damaged("a chunk has other bytes than it tells")) } else { Ok(raw_bytes) }
}

/// What the head of a file tells.
struct Head {
    has_attributes: bool,
    counts: Counts,
    lattice: Lattice,
}

impl Head {
    fn read(source: &mut impl Read) -> Result<Self> {
        let mut head = [0; HEAD];
        source
            .read_exact(&mut head)
            .map_err(|_| Error::invalid("it is no progressive mesh, or its beginning is missing"))?;
        let (told, sum) = head.split_at(HEAD - 4);
        if &told[..8] != SIGNATURE {
            return Err(Error::invalid("it is no progressive mesh").advise("build one of a mesh first"));
        }
        let version = word(told, 8);
        if version != VERSION && version != ATTRIBUTED {
            return Err(Error::unsupported(format!("version {version} of the format is not known"))
                .advise("use the program that wrote it, or a newer one of this"));
        }
        if crc32fast::hash(told).to_le_bytes() != sum {
            return Err(damaged("the head has another sum than it tells"));
        }
        let counts = Counts::new(std::array::from_fn(|index| word(told, 12 + 4 * index)))?;
        let vector = |at: usize| Vec3::from_array([0, 4, 8].map(|axis| f32::from_bits(word(told, at + axis))));
        let lattice = Lattice::from_parts(vector(32), vector(44));
        let lattice = lattice.ok_or_else(|| damaged("the lattice of places is not finite"))?;
        Ok(Self { has_attributes: version == ATTRIBUTED, counts, lattice })
    }
}

/// A file that is read part by part: its head, its attributes if it has any, its base, then chunks of splits.
pub struct Reading {
    budget: Budget,
    head: Option<Head>,
    /// Of attributes that the file announces, until their base comes.
    told: Option<Told>,
    loading: Option<Loading>,
    /// Bytes of a split that the file announces, at most.
    of_split: usize,
    /// Splits that are not read yet.
    left: usize,
}

impl Reading {
    pub fn new(context: &Context) -> Self {
        let budget = Budget::new(context.memory_limit());
        Self { budget, head: None, told: None, loading: None, of_split: 4 * COLUMNS, left: 0 }
    }

    /// How many bytes a part has, of which those are here that are known; where they are too few to tell, how many do.
    pub fn needs(&self, known: &[u8]) -> Result<usize> {
        if self.head.is_none() {
            return Ok(HEAD);
        }
        match known.get(..CHUNK_HEAD) {
            None => Ok(CHUNK_HEAD),
            Some(head) => Ok(CHUNK_HEAD + chunk_head(head, &self.budget, self.most())?[1]),
        }
    }

    /// Bytes that the next chunk may have.
    fn most(&self) -> usize {
        let Some(head) = &self.head else { return 0 };
        let counts = &head.counts;
        match (&self.loading, &self.told) {
            (Some(_), _) => self.of_split * self.left.min(CHUNK),
            (None, None) if head.has_attributes => wedge_columns::MAX,
            (None, told) => {
                let more = told.as_ref().map_or(0, |told| told.bytes(told.base, counts.base_faces));
                4 * (COLUMNS * counts.base_vertices + 4 * counts.base_faces) + more
            }
        }
    }

    /// Reads the next part into a mesh, which is made with the base.
    pub fn part(&mut self, source: &mut impl Read, mesh: &mut Option<Progressive>) -> Result<()> {
        let most = self.most();
        let Some(head) = &self.head else {
            self.head = Some(Head::read(source)?);
            return Ok(());
        };
        if let Some(mesh) = mesh {
            return self.splits(source, mesh);
        }
        if head.has_attributes && self.told.is_none() {
            self.told = Some(Told::read(&chunk(source, &self.budget, most)?, head.counts.splits)?);
            return Ok(());
        }
        let counts = &head.counts;
        self.of_split += self.told.as_ref().map_or(0, |told| told.bytes(2, 2));
        let mut made = Progressive::empty(counts.vertices, counts.triangles, head.lattice, &mut self.budget)?;
        let mut loading = Loading::new(counts, &mut self.budget)?;
        let bytes = chunk(source, &self.budget, most)?;
        loading.base(&bytes, counts, self.told.take(), &mut made, &mut self.budget)?;
        self.left = counts.splits;
        made.set_floor(loading.last, self.left);
        (self.loading, *mesh) = (Some(loading), Some(made));
        Ok(())
    }

    /// Reads the next splits into the mesh.
    pub fn splits(&mut self, source: &mut impl Read, mesh: &mut Progressive) -> Result<()> {
        let most = self.most();
        let Some(loading) = &mut self.loading else { return Err(Error::internal("splits come after the base")) };
        let count = self.left.min(CHUNK);
        loading.splits(&chunk(source, &self.budget, most)?, count, mesh)?;
        self.left -= count;
        mesh.set_floor(loading.last, self.left);
        Ok(())
    }

    /// The splits that were read last.
    pub fn last_splits(&self) -> &[u32] {
        self.loading.as_ref().map_or(&[], |loading| &loading.splits)
    }

    /// Whether all is read.
    pub fn is_complete(&self) -> bool {
        self.loading.is_some() && self.left == 0
    }

    /// Triangles that splits have brought.
    pub fn triangles(&self) -> usize {
        self.loading.as_ref().map_or(0, |loading| loading.triangles)
    }
}

impl Progressive {
    /// Opens a file. `faces` is how fine a mesh is wanted: what comes after is not read.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is damaged or of a newer version, or the mesh needs more than `context`'s
    /// memory.
    pub fn open(context: &Context, path: &Path, faces: usize) -> Result<Self> {
        let mut source = std::io::BufReader::new(file::open(path)?);
        Self::read(context, &mut source, faces).map_err(|error| error.at(path.display().to_string()))
    }

    /// As [`Self::open`], from any source.
    ///
    /// # Errors
    /// Fails if what the source gives ends too early, is damaged or of a newer version, or the mesh needs more than
    /// `context`'s memory.
    pub fn read(context: &Context, source: &mut impl Read, faces: usize) -> Result<Self> {
        let (mut reading, mut made) = (Reading::new(context), None);
        while !reading.is_complete() && !is_enough(&reading, &made, faces) {
            reading.part(source, &mut made)?;
        }
        drop(reading);
        let mesh = Arc::new(made.ok_or_else(|| damaged("the file ends too early"))?);
        if !ActiveMesh::new(&mesh).is_sound(context) {
            return Err(unsound());
        }
        Arc::into_inner(mesh).ok_or_else(|| Error::internal("a mesh that is read is used already"))
    }
}

fn is_enough(reading: &Reading, made: &Option<Progressive>, faces: usize) -> bool {
    made.as_ref().is_some_and(|mesh| mesh.base_faces().len() + reading.triangles() >= faces)
}

/// Why a mesh is refused whose splits are in another order than they tell.
pub fn unsound() -> Error {
    damaged("splits do not come after those they stand on")
}

/// What is known of a mesh while it is read.
struct Loading {
    /// The range of leaves of every vertex that may be split, by its split; empty for splits that no vertex tells of.
    ranges: Vec<[u32; 2]>,
    /// Vertices and triangles of the input that are there.
    seen_vertices: Vec<bool>,
    seen_faces: Vec<bool>,
    /// Triangles that splits have brought.
    triangles: usize,
    last: (Key, u32),
    /// Those of the last chunk.
    splits: Vec<u32>,
}

impl Loading {
    fn new(counts: &Counts, budget: &mut Budget) -> Result<Self> {
        Ok(Self {
            ranges: budget.filled(counts.vertices, [0; 2])?,
            seen_vertices: budget.filled(counts.vertices, false)?,
            seen_faces: budget.filled(counts.triangles, false)?,
            triangles: 0,
            last: (Key(u32::MAX), u32::MAX),
            splits: Vec::new(),
        })
    }

    fn base(
        &mut self,
        bytes: &[u8],
        counts: &Counts,
        told: Option<Told>,
        mesh: &mut Progressive,
        budget: &mut Budget,
    ) -> Result<()> {
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
            let child = self.vertex(mesh, &vertices, &mut next, *tag, [*leaf, end], 2 * leaf)?;
            mesh.splits[*leaf as usize].children[0] = child;
        }
        mesh.base_vertices = leaves;
        let places = mesh.base_places(counts.base_faces);
        for (index, place) in places.iter().enumerate() {
            self.face(mesh, &faces, index, *place, 0)?;
        }
        mesh.base_faces = places;
        if let Some(told) = told {
            let columns = Columns::read(&mut from, told.widths, [0, told.base], counts.base_faces)?;
            mesh.wedges = Some(Arc::new(wedge_columns::Loading::base(told, &columns, mesh, budget)?.trees));
        }
        Ok(())
    }

    fn splits(&mut self, bytes: &[u8], count: usize, mesh: &mut Progressive) -> Result<()> {
        // Shared by no one but meshes in use, which keep theirs.
        let mut wedges = mesh.wedges.take().map(|trees| wedge_columns::Loading { trees: Arc::unwrap_or_clone(trees) });
        let mut from = Reader(bytes);
        let (numbers, tags) = (from.column(count)?, from.column(count)?);
        let (keys, parents) = (from.column(count)?, from.column(count)?);
        let sides = tags.iter().flat_map(|tag| [*tag, tag >> 1]);
        let vertices = Vertices::read(&mut from, sides.clone())?;
        let face_count = sides.filter(|tag| tag & HAS_FACE != 0).count();
        let faces = Faces::read(&mut from, face_count)?;
        let parts = tags.iter().map(|tag| wedge_columns::count(*tag)).sum();
        let columns = match &wedges {
            Some(wedges) => Some(Columns::read(&mut from, wedges.trees.widths, [parts; 2], face_count)?),
            None => None,
        };
        let (mut next, mut face, mut part) = (Next::default(), 0, 0);
        self.splits.clone_from(&numbers);
        for (((split, tag), key), parent) in numbers.into_iter().zip(tags).zip(keys).zip(parents) {
            let key = Key(key);
            let [start, end] = self.ranges.get(split as usize).copied().unwrap_or_default();
            if split <= start || split >= end || mesh.splits[split as usize].key != Key::default() {
                return Err(damaged("a split has no vertex it could split"));
            }
            let node = parent.wrapping_add(2 * split);
            if key.depth() == 0 || (key, split) >= self.last || mesh.parent(split) != node {
                return Err(damaged("splits are out of order"));
            }
            let above = mesh.splits[node as usize / 2].key;
            if above != Key::default() && above.depth() <= key.depth() {
                return Err(damaged("a split is no less deep than the one it stands on"));
            }
            self.last = (key, split);
            mesh.splits[split as usize].key = key;
            for (side, range) in (0..).zip([[start, split], [split, end]]) {
                let child = self.vertex(mesh, &vertices, &mut next, tag >> side, range, 2 * split + side)?;
                mesh.splits[split as usize].children[side as usize] = child;
                if tag >> side & HAS_FACE != 0 {
                    self.face(mesh, &faces, face, 2 * split + side, split)?;
                    if let Some((wedges, columns)) = wedges.as_mut().zip(columns.as_ref()) {
                        wedges.face(columns, face, 2 * split + side, mesh)?;
                    }
                    face += 1;
                    self.triangles += 1;
                }
            }
            if let Some((wedges, columns)) = wedges.as_mut().zip(columns.as_ref()) {
                wedges.split(columns, &mut part, tag, split)?;
            }
        }
        mesh.wedges = wedges.map(|wedges| Arc::new(wedges.finished()));
        Ok(())
    }

    /// Takes the next vertex in, which stands for a range of leaves. Returns what it is.
    fn vertex(
        &mut self,
        mesh: &mut Progressive,
        columns: &Vertices,
        next: &mut Next,
        tag: u32,
        [start, end]: [u32; 2],
        node: u32,
    ) -> Result<u32> {
        let from = node / 2;
        let (told, normal) = (columns.children[next.vertex], Normal(columns.normals[next.vertex]));
        next.vertex += 1;
        if tag & IS_LEAF != 0 {
            let is_new = self.seen_vertices.get_mut(told as usize).is_some_and(|seen| !std::mem::replace(seen, true));
            if end - start != 1 || !is_new {
                return Err(damaged("a vertex of the finest mesh is out of place"));
            }
            mesh.normals[start as usize] = normal;
            point(mesh, columns, next, start)?;
            return Ok(LEAF | told);
        }
        let split = told.wrapping_add(from);
        if split <= start || split >= end {
            return Err(damaged("a split is not where its vertex is"));
        }
        let packed = if tag & IS_AT != 0 {
            let leaf = columns.leaves_at[next.at].wrapping_add(from);
            next.at += 1;
            if leaf as usize >= mesh.points.len() {
                return Err(damaged("a vertex stays at one that is not there"));
            }
            point(mesh, columns, next, leaf)?;
            AT | u64::from(leaf)
        } else {
            next.inner += 1;
            let [low, high] = [0, 1].map(|half| u64::from(columns.inner_points[half][next.inner - 1]));
            (low | high << 32) & !AT
        };
        mesh.inner_points[split as usize] = packed;
        mesh.inner_normals[split as usize] = normal;
        mesh.splits[split as usize].parent = node;
        self.ranges[split as usize] = [start, end];
        Ok(split)
    }

    fn face(&mut self, mesh: &mut Progressive, columns: &Faces, index: usize, place: u32, from: u32) -> Result<()> {
        let [a, b, c, id] = [0, 1, 2, 3].map(|column| columns.0[column][index]);
        let leaves = [a, b, c].map(|leaf| leaf.wrapping_add(from));
        let is_new = self.seen_faces.get_mut(id as usize).is_some_and(|seen| !std::mem::replace(seen, true));
        if !is_new || leaves.iter().any(|leaf| *leaf as usize >= mesh.points.len()) {
            return Err(damaged("a triangle is out of place"));
        }
        mesh.set_face(place, leaves, id);
        Ok(())
    }
}

fn point(mesh: &mut Progressive, columns: &Vertices, next: &mut Next, leaf: u32) -> Result<()> {
    let point = [0, 1, 2].map(|axis| f32::from_bits(columns.leaf_points[axis][next.point]));
    next.point += 1;
    if !point.iter().all(|value| value.is_finite()) {
        return Err(damaged("a place is not finite"));
    }
    mesh.points[leaf as usize] = point;
    Ok(())
}

/// The next places of columns.
#[derive(Default)]
struct Next {
    vertex: usize,
    point: usize,
    inner: usize,
    at: usize,
}
