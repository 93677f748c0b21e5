//! Crowd models as files, `.rcrowd`.
//!
//! Numbers are little-endian. The head: the signature, the version, nine counts and the sum of all that (CRC-32). Then
//! chunks: the bytes it has, those it has compressed (zstd), the sum of the latter, and these. The first four chunks are
//! skeleton, hierarchy, vertices and poses; then comes one chunk a cluster, the coarsest first, so that a beginning of the
//! clusters is a whole model of fewer triangles. The hierarchy has the lengths of the chunks, so that [`Reader`] finds
//! each cluster without reading the others. Columns of numbers are split into planes of bytes. Version 2 has the offsets of
//! morph targets behind the vertices and their weights behind the poses; models without any are of version 1. Version 3 has
//! besides, for every vertex, the group that removes its place and the vertex that it goes to. Version 4 has two distances
//! more for every group.

mod check;
mod columns;
mod read;
mod write;

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use relievo_core::{Budget, Context, Error, ErrorKind, Result, file};

use self::read::{read_cluster, read_hierarchy, read_poses, read_skeleton, read_vertices};
use crate::hierarchy::{Cluster, CrowdModel};

const SIGNATURE: &[u8; 8] = b"RLVCROWD";
/// The newest version.
const NEWEST: u32 = 4;
/// Bytes of the head, with its sum.
const HEAD: usize = 8 + 4 + 9 * 4 + 4;
/// Bytes before each chunk.
const CHUNK_HEAD: usize = 12;
const LEVEL: i32 = 9;
/// Material of a cluster whose triangles differ in it.
const MIXED: u32 = u32::MAX;

/// A file that is read cluster by cluster.
#[derive(Debug)]
pub struct Reader {
    file: File,
    path: String,
    /// The model without the triangles of clusters: their lists are full of zeros.
    model: Arc<CrowdModel>,
    /// Where the chunk of every cluster begins, and its length.
    chunks: Vec<(u64, u32)>,
}

impl Reader {
    /// Opens a file and reads all but the triangles.
    ///
    /// # Errors
    /// The file is no crowd model, is damaged, of a later version, or exceeds the memory limit.
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let file = file::open(path)?;
        let length = file.metadata().map_err(|error| Error::io(path, &error))?.len();
        let mut input = std::io::BufReader::new(&file);
        let (model, chunks) = read_all_but_triangles(&mut input, length, context.memory_limit())
            .map_err(|error| error.at(name.clone()))?;
        Ok(Self { file, path: name, model: Arc::new(model), chunks })
    }

    /// Returns the model; its triangles are not read, only their number is right.
    pub fn model(&self) -> &CrowdModel {
        &self.model
    }

    /// Returns the same, for a crowd that is cut while clusters are read.
    pub fn shared(&self) -> Arc<CrowdModel> {
        Arc::clone(&self.model)
    }

    /// Reads a cluster: its triangles and their materials.
    ///
    /// # Errors
    /// There is no such cluster, or it is damaged.
    pub fn cluster(&mut self, index: u32) -> Result<(Vec<[u32; 3]>, Vec<u32>)> {
        let Some((start, _)) = self.chunks.get(index as usize) else {
            return Err(Error::invalid(format!("cluster {index} does not exist")).at(self.path.clone()));
        };
        let count = self.model.clusters[index as usize].count as usize;
        let vertices = self.model.character.points.len();
        let mut read = || {
            self.file.seek(SeekFrom::Start(*start)).map_err(|error| failed(&error))?;
            // Three indices of four bytes and a material for each triangle, and as many vertices, at most.
            let most = 64 + 28 * count as u64;
            let bytes = read_chunk(&mut self.file, &mut Budget::new(2 * most), most)?;
            read_cluster(&bytes, count, vertices)
        };
        read().map_err(|error: Error| error.at(format!("cluster {index}")).at(self.path.clone()))
    }
}

impl CrowdModel {
    /// Writes a file, which is there when it is complete.
    ///
    /// # Errors
    /// The file cannot be written, or clusters of the model are read while it is drawn.
    pub fn save(&self, path: &Path) -> Result<()> {
        self.check_triangles()?;
        file::store(path, |out| self.write(out))
    }

    /// Writes the model. Equal models give equal bytes.
    ///
    /// # Errors
    /// `out` refuses bytes.
    pub fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        let character = &self.character;
        let counts = [
            character.points.len(),
            self.input_triangles as usize,
            character.triangles.len(),
            self.clusters.len(),
            self.groups.len(),
            character.bones.len(),
            character.parents.len(),
            self.clips.len(),
            character.attributes.len(),
        ];
        let mut head = SIGNATURE.to_vec();
        head.extend(self.file_version().to_le_bytes());
        head.extend(counts.into_iter().flat_map(|count| (count as u32).to_le_bytes()));
        head.extend(crc32fast::hash(&head).to_le_bytes());
        out.write_all(&head)?;
        let clusters: Vec<Vec<u8>> = (0..self.clusters.len() as u32)
            .rev()
            .map(|cluster| packed(&self.cluster_bytes(cluster)))
            .collect::<std::io::Result<_>>()?;
        let lengths: Vec<u32> = clusters.iter().map(|chunk| chunk.len() as u32).collect();
        for bytes in [self.skeleton_bytes(), self.hierarchy_bytes(&lengths), self.vertex_bytes(), self.pose_bytes()] {
            out.write_all(&packed(&bytes)?)?;
        }
        clusters.iter().try_for_each(|chunk| out.write_all(chunk))
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn load(context: &Context, path: &Path) -> Result<Self> {
        let bytes = file::load(path, context.memory_limit())?;
        Self::from_bytes(&bytes, context.memory_limit()).map_err(|error| error.at(path.display().to_string()))
    }

    /// Reads a model from the bytes of a file, which may occupy `memory_limit` bytes.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn from_bytes(bytes: &[u8], memory_limit: u64) -> Result<Self> {
        let mut input = std::io::Cursor::new(bytes);
        let (mut model, chunks) = read_all_but_triangles(&mut input, bytes.len() as u64, memory_limit)?;
        let vertices = model.character.points.len();
        for index in (0..model.clusters.len()).rev() {
            let Cluster { first, count, .. } = model.clusters[index];
            let place = |error: Error| error.at(format!("cluster {index}"));
            let (start, length) = chunks[index];
            let most = 64 + 28 * u64::from(count);
            let mut chunk = &bytes[start as usize..start as usize + length as usize];
            let raw = read_chunk(&mut chunk, &mut Budget::new(2 * most), most).map_err(place)?;
            let (triangles, materials) = read_cluster(&raw, count as usize, vertices).map_err(place)?;
            let range = first as usize..(first + count) as usize;
            model.character.triangles[range.clone()].copy_from_slice(&triangles);
            model.character.materials[range].copy_from_slice(&materials);
        }
        Ok(model)
    }

    /// Returns the version of the file, the oldest that has all of the model.
    fn file_version(&self) -> u32 {
        match (self.has_collapses(), self.character.morphs.count) {
            (true, _) if self.distances.len() == self.groups.len() => NEWEST,
            (true, _) => 3,
            (false, 0) => 1,
            (false, _) => 2,
        }
    }
}

/// Returns a chunk: its head and the compressed bytes.
fn packed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let packed = zstd::bulk::compress(bytes, LEVEL)?;
    let head = [bytes.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
    Ok(head.into_iter().flat_map(u32::to_le_bytes).chain(packed).collect())
}
fn damaged(what: &str) -> Error {
    Error::invalid(what).advise("the file is damaged: build it again")
}

fn failed(error: &std::io::Error) -> Error {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => damaged("the file ends too early"),
        _ => Error::new(ErrorKind::Io, error.to_string()),
    }
}

/// The counts of the head.
struct Counts {
    vertices: usize,
    input_triangles: u32,
    triangles: usize,
    clusters: usize,
    groups: usize,
    bones: usize,
    nodes: usize,
    clips: usize,
    attributes: usize,
    version: u32,
}

fn read_head(input: &mut impl Read) -> Result<Counts> {
    let mut head = [0; HEAD];
    input.read_exact(&mut head).map_err(|error| failed(&error))?;
    if &head[..8] != SIGNATURE {
        return Err(
            Error::invalid("it is no crowd model").advise("build one: `relievo crowd build`, or rlv_crowd_model_build")
        );
    }
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let version = number(8);
    if !(1..=NEWEST).contains(&version) {
        return Err(Error::unsupported(format!("the file is of version {version}, this program reads up to {NEWEST}"))
            .advise("use a newer Relievo, or build the file again"));
    }
    if number(HEAD - 4) != crc32fast::hash(&head[..HEAD - 4]) {
        return Err(damaged("the head is wrong"));
    }
    let count = |at: usize| number(12 + 4 * at) as usize;
    Ok(Counts {
        vertices: count(0),
        input_triangles: number(16),
        triangles: count(2),
        clusters: count(3),
        groups: count(4),
        bones: count(5),
        nodes: count(6),
        clips: count(7),
        attributes: count(8),
        version,
    })
}

/// Reads a chunk of at most `most` bytes. Memory grows with what is read, not with what the chunk claims.
fn read_chunk(input: &mut impl Read, budget: &mut Budget, most: u64) -> Result<Vec<u8>> {
    let mut head = [0; CHUNK_HEAD];
    input.read_exact(&mut head).map_err(|error| failed(&error))?;
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (raw, length, sum) = (u64::from(number(0)), u64::from(number(4)), number(8));
    if raw > most || length > most + most / 128 + 1024 {
        return Err(damaged("a chunk is longer than its counts allow"));
    }
    budget.charge(raw + length)?;
    let mut packed = Vec::new();
    input.take(length).read_to_end(&mut packed).map_err(|error| failed(&error))?;
    if packed.len() as u64 != length {
        return Err(damaged("the file ends too early"));
    }
    if crc32fast::hash(&packed) != sum {
        return Err(damaged("the sum of a chunk is wrong"));
    }
    let mut bytes = Vec::new();
    let wrong = |error| damaged(&format!("a chunk cannot be unpacked: {error}"));
    let decoder = zstd::stream::read::Decoder::new(packed.as_slice()).map_err(wrong)?;
    decoder.take(raw + 1).read_to_end(&mut bytes).map_err(wrong)?;
    if bytes.len() as u64 != raw {
        return Err(damaged("the length of a chunk is wrong"));
    }
    Ok(bytes)
}

/// The model without triangles, and where the chunk of each cluster is.
type Beginning = (CrowdModel, Vec<(u64, u32)>);

fn read_all_but_triangles(input: &mut (impl Read + Seek), length: u64, memory_limit: u64) -> Result<Beginning> {
    // As with other files: a small one that becomes gigabytes is an attack.
    let mut budget = Budget::new(memory_limit.min((1 << 30) + 256 * length));
    let counts = read_head(input)?;
    let most = budget.left();
    let mut chunk = |name: &str| read_chunk(input, &mut budget, most).map_err(|error| error.at(name.to_owned()));
    let (skeleton, hierarchy) = (chunk("skeleton")?, chunk("hierarchy")?);
    let (vertices, poses) = (chunk("vertices")?, chunk("poses")?);
    let mut model = CrowdModel { input_triangles: counts.input_triangles, ..CrowdModel::default() };
    let (frames, offsets) = read_skeleton(&skeleton, &counts, &mut model).map_err(|error| error.at("skeleton"))?;
    let lengths = read_hierarchy(&hierarchy, &counts, &mut model).map_err(|error| error.at("hierarchy"))?;
    budget.charge(if offsets > 0 { 4 * counts.vertices as u64 } else { 0 })?;
    budget.charge(if counts.version > 2 { 8 * counts.vertices as u64 } else { 0 })?;
    read_vertices(&vertices, (&counts, offsets), &mut model).map_err(|error| error.at("vertices"))?;
    read_poses(&poses, &frames, &mut model).map_err(|error| error.at("poses"))?;
    budget.charge(16 * counts.triangles as u64)?;
    // The clusters vouch for the number of triangles.
    model.character.triangles = vec![[0; 3]; counts.triangles];
    model.character.materials = vec![0; counts.triangles];
    model.check()?;
    let mut at = input.stream_position().map_err(|error| failed(&error))?;
    let mut chunks = vec![(0, 0); counts.clusters];
    for (cluster, bytes) in (0..counts.clusters).rev().zip(lengths) {
        chunks[cluster] = (at, bytes);
        at += u64::from(bytes);
    }
    if at != length {
        return Err(damaged("the file has another length than its clusters"));
    }
    Ok((model, chunks))
}
