//! Crowd models as files, `.rcrowd`.
//!
//! Numbers are little-endian. The head: the signature, the version, nine counts and the sum of all that (CRC-32). Then
//! chunks: the bytes it has, those it has compressed (zstd), the sum of the latter, and these. The first four chunks are
//! skeleton, hierarchy, vertices and poses; then comes one chunk a cluster, the coarsest first, so that a beginning of the
//! clusters is a whole model of fewer triangles. The hierarchy has the lengths of the chunks, so that [`Reader`] finds
//! each cluster without reading the others. Columns of numbers are split into planes of bytes. Version 2 has the offsets of
//! morph targets behind the vertices and their weights behind the poses; models without any are of version 1. Version 3 has
//! besides, for every vertex, the group that removes its place and the vertex that it goes to.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Attribute, Budget, Context, Domain, Error, Result, Values, file};

use crate::character::{Bone, Character, Influence};
use crate::clip::{Clip, MOST_POSES, Pose};
use crate::geomorph::Collapse;
use crate::hierarchy::{Cluster, CrowdModel, Group, NONE, Report};
use crate::morph::{MOST_MORPHS, MorphOffset, Morphs};

const SIGNATURE: &[u8; 8] = b"RLVCROWD";
/// The newest version.
const NEWEST: u32 = 3;
/// Bytes of the head, with its sum.
const HEAD: usize = 8 + 4 + 9 * 4 + 4;
/// Bytes before each chunk.
const CHUNK_HEAD: usize = 12;
const LEVEL: i32 = 9;
/// Material of a cluster whose triangles differ in it.
const MIXED: u32 = u32::MAX;
/// Bytes of a name at most.
const MOST_NAME: usize = 1 << 12;

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
            self.file.seek(SeekFrom::Start(*start)).map_err(|error| cut_off(&error))?;
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
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
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
            (true, _) => NEWEST,
            (false, 0) => 1,
            (false, _) => 2,
        }
    }

    fn skeleton_bytes(&self) -> Vec<u8> {
        let character = &self.character;
        let mut out = Columns::default();
        out.number(character.material_names.len() as u32);
        character.material_names.iter().for_each(|name| out.text(name));
        for bone in &character.bones {
            out.text(&bone.name);
            out.number(bone.node);
            bone.inverse_bind.to_cols_array().iter().for_each(|value| out.0.extend(value.to_le_bytes()));
        }
        out.numbers(&character.parents.iter().map(|parent| parent.unwrap_or(NONE)).collect::<Vec<_>>());
        for clip in &self.clips {
            out.text(&clip.name);
            out.number(clip.rate.to_bits());
            out.number(clip.poses.len() as u32);
        }
        for attribute in &character.attributes {
            out.text(&attribute.name);
            out.number(attribute.width);
        }
        let Report { poses, representatives, measured, exceeded } = self.report;
        out.number(poses);
        out.number(representatives);
        out.0.extend([measured, exceeded].iter().flat_map(|count| count.to_le_bytes()));
        out.floats(self.low.into_iter().chain(self.high));
        if self.file_version() > 1 {
            out.number(character.morphs.count);
            out.number(character.morphs.offsets.len() as u32);
        }
        out.0
    }

    fn hierarchy_bytes(&self, lengths: &[u32]) -> Vec<u8> {
        let mut out = Columns::default();
        let column = |value: fn(&Cluster) -> u32| self.clusters.iter().map(value).collect::<Vec<_>>();
        out.numbers(&column(|cluster| cluster.count));
        out.numbers(&column(|cluster| cluster.made_by));
        out.numbers(&column(|cluster| cluster.used_by));
        out.numbers(&column(|cluster| cluster.deformation.to_bits()));
        out.numbers(&column(|cluster| cluster.depth));
        out.floats(self.groups.iter().map(|group| group.error));
        for axis in 0..3 {
            out.floats(self.groups.iter().map(|group| group.low[axis]));
            out.floats(self.groups.iter().map(|group| group.high[axis]));
        }
        out.numbers(&self.groups.iter().map(|group| group.depth).collect::<Vec<_>>());
        out.numbers(lengths);
        out.0
    }

    fn vertex_bytes(&self) -> Vec<u8> {
        let character = &self.character;
        let mut out = Columns::default();
        (0..3).for_each(|axis| out.floats(character.points.iter().map(|point| point[axis])));
        for slot in 0..4 {
            out.numbers(&character.influences.iter().map(|it| u32::from(it.bones[slot])).collect::<Vec<_>>());
            out.floats(character.influences.iter().map(|influence| influence.weights[slot]));
        }
        for attribute in &character.attributes {
            let (Values::F32(values), width) = (&attribute.values, attribute.width as usize) else { continue };
            (0..width).for_each(|at| out.floats(values.iter().skip(at).step_by(width).copied()));
        }
        if character.morphs.count > 0 {
            let Morphs { starts, offsets, .. } = &character.morphs;
            out.numbers(&starts.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>());
            out.numbers(&offsets.iter().map(|it| it.morph).collect::<Vec<_>>());
            (0..3).for_each(|axis| out.floats(offsets.iter().map(|it| it.offset[axis])));
        }
        if self.has_collapses() {
            out.numbers(&self.collapses.iter().map(|it| it.group).collect::<Vec<_>>());
            // Vertices go to near ones, most of which have near numbers.
            let step = |(vertex, it): (u32, &Collapse)| it.target.wrapping_sub(vertex);
            out.numbers(&(0..).zip(&self.collapses).map(step).map(folded).collect::<Vec<_>>());
        }
        out.0
    }

    fn pose_bytes(&self) -> Vec<u8> {
        let mut out = Columns::default();
        let poses = || self.clips.iter().flat_map(|clip| &clip.poses);
        for (row, column) in (0..3).flat_map(|row| (0..4).map(move |column| (row, column))) {
            out.floats(poses().flat_map(|pose| pose.bones.iter().map(move |bone| bone[row][column])));
        }
        out.floats(poses().flat_map(|pose| pose.weights.iter().copied()));
        out.0
    }

    fn cluster_bytes(&self, index: u32) -> Vec<u8> {
        let Cluster { first, count, .. } = self.clusters[index as usize];
        let triangles = self.triangles(index);
        let materials = &self.character.materials[first as usize..(first + count) as usize];
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut out = Columns::default();
        let common = materials.first().copied().filter(|one| materials.iter().all(|other| other == one));
        out.number(vertices.len() as u32);
        out.number(common.unwrap_or(MIXED));
        let before = std::iter::once(0).chain(vertices.iter().copied());
        out.numbers(&vertices.iter().zip(before).map(|(vertex, before)| vertex - before).collect::<Vec<_>>());
        let local = |vertex: &u32| vertices.binary_search(vertex).unwrap_or_default() as u32;
        let indices: Vec<u32> = triangles.iter().flatten().map(local).collect();
        out.planes(&indices, index_bytes(vertices.len()));
        if common.is_none() {
            out.numbers(materials);
        }
        out.0
    }
}

/// Returns a difference such that small ones of either sign are small numbers.
fn folded(difference: u32) -> u32 {
    (difference << 1) ^ if difference >> 31 == 1 { u32::MAX } else { 0 }
}

/// Returns the difference that [`folded`] turned into a number.
fn unfolded(number: u32) -> u32 {
    (number >> 1) ^ if number & 1 == 1 { u32::MAX } else { 0 }
}

/// Returns how many bytes an index below `count` has.
fn index_bytes(count: usize) -> usize {
    match count {
        0..=0x100 => 1,
        0x101..=0x1_0000 => 2,
        _ => 4,
    }
}

/// Returns a chunk: its head and the compressed bytes.
fn packed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let packed = zstd::bulk::compress(bytes, LEVEL)?;
    let head = [bytes.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
    Ok(head.into_iter().flat_map(u32::to_le_bytes).chain(packed).collect())
}

/// Bytes of columns that are written.
#[derive(Default)]
struct Columns(Vec<u8>);

impl Columns {
    fn planes(&mut self, values: &[u32], bytes: usize) {
        for plane in 0..bytes {
            self.0.extend(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
    }

    fn numbers(&mut self, values: &[u32]) {
        self.planes(values, 4);
    }

    fn number(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    fn floats(&mut self, values: impl Iterator<Item = f32>) {
        self.numbers(&values.map(f32::to_bits).collect::<Vec<_>>());
    }

    /// Writes a name, cut to what readers accept.
    fn text(&mut self, text: &str) {
        let mut end = text.len().min(MOST_NAME);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.number(end as u32);
        self.0.extend(&text.as_bytes()[..end]);
    }
}

/// Bytes of columns that are read.
struct Rows<'a>(&'a [u8]);

impl<'a> Rows<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or_else(|| damaged("a chunk is too short"))?;
        self.0 = rest;
        Ok(bytes)
    }

    fn planes(&mut self, count: usize, width: usize) -> Result<Vec<u32>> {
        let length = count.checked_mul(width).ok_or_else(|| damaged("a count is too large"))?;
        let bytes = self.take(length)?;
        let value = |index: usize| (0..width).map(|plane| u32::from(bytes[plane * count + index]) << (8 * plane)).sum();
        Ok((0..count).map(value).collect())
    }

    fn numbers(&mut self, count: usize) -> Result<Vec<u32>> {
        self.planes(count, 4)
    }

    fn floats(&mut self, count: usize) -> Result<Vec<f32>> {
        let values: Vec<f32> = self.numbers(count)?.into_iter().map(f32::from_bits).collect();
        if values.iter().all(|value| value.is_finite()) { Ok(values) } else { Err(damaged("a number is not finite")) }
    }

    fn number(&mut self) -> Result<u32> {
        Ok(self.numbers(1)?[0])
    }

    fn long(&mut self) -> Result<u64> {
        let bytes = self.take(8)?;
        Ok(bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte)))
    }

    fn text(&mut self) -> Result<String> {
        let length = self.number()? as usize;
        if length > MOST_NAME {
            return Err(damaged("a name is too long"));
        }
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| damaged("a name is no text"))
    }

    fn end(&self) -> Result<()> {
        if self.0.is_empty() { Ok(()) } else { Err(damaged("a chunk is too long")) }
    }
}

fn damaged(what: &str) -> Error {
    Error::invalid(what).advise("the file is damaged: build it again")
}

fn cut_off(error: &std::io::Error) -> Error {
    damaged(&format!("the file ends early ({error})"))
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
    input.read_exact(&mut head).map_err(|error| cut_off(&error))?;
    if &head[..8] != SIGNATURE {
        return Err(Error::invalid("it is no crowd model").advise("build one by `relievo crowd build`"));
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
    input.read_exact(&mut head).map_err(|error| cut_off(&error))?;
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (raw, length, sum) = (u64::from(number(0)), u64::from(number(4)), number(8));
    if raw > most || length > most + most / 128 + 1024 {
        return Err(damaged("a chunk is longer than its counts allow"));
    }
    budget.charge(raw + length)?;
    let mut packed = Vec::new();
    input.take(length).read_to_end(&mut packed).map_err(|error| cut_off(&error))?;
    if packed.len() as u64 != length {
        return Err(damaged("the file ends early"));
    }
    if crc32fast::hash(&packed) != sum {
        return Err(damaged("the sum of a chunk is wrong"));
    }
    let mut bytes = Vec::new();
    let decoder = zstd::stream::read::Decoder::new(packed.as_slice()).map_err(|error| cut_off(&error))?;
    decoder.take(raw + 1).read_to_end(&mut bytes).map_err(|error| damaged(&format!("a chunk is wrong ({error})")))?;
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
    let mut at = input.stream_position().map_err(|error| cut_off(&error))?;
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

/// Returns the number of poses of each clip, and the number of offsets of morph targets.
fn read_skeleton(bytes: &[u8], counts: &Counts, model: &mut CrowdModel) -> Result<(Vec<usize>, usize)> {
    let mut rows = Rows(bytes);
    let character = &mut model.character;
    for _ in 0..rows.number()? {
        character.material_names.push(rows.text()?);
    }
    for _ in 0..counts.bones {
        let (name, node) = (rows.text()?, rows.number()?);
        let mut values = [0.0; 12];
        for value in &mut values {
            *value = f64::from_bits(rows.long()?);
        }
        let column = |at: usize| DVec3::new(values[at], values[at + 1], values[at + 2]);
        let linear = DMat3::from_cols(column(0), column(3), column(6));
        character.bones.push(Bone { name, node, inverse_bind: DAffine3::from_mat3_translation(linear, column(9)) });
    }
    character.parents =
        rows.numbers(counts.nodes)?.into_iter().map(|parent| Some(parent).filter(|it| *it != NONE)).collect();
    let mut frames = Vec::new();
    for _ in 0..counts.clips {
        let (name, rate, poses) = (rows.text()?, rows.floats(1)?[0], rows.number()? as usize);
        if !(rate > 0.0) || poses == 0 || poses > MOST_POSES {
            return Err(damaged("a clip has no rate or no poses"));
        }
        model.clips.push(Clip { name, rate, poses: Vec::new() });
        frames.push(poses);
    }
    for _ in 0..counts.attributes {
        let (name, width) = (rows.text()?, rows.number()?);
        if !(1..=4).contains(&width) {
            return Err(damaged("an attribute has no width"));
        }
        let values = Values::F32(Vec::new());
        character.attributes.push(Attribute { name, domain: Domain::Point, width, values, indices: None });
    }
    let (poses, representatives) = (rows.number()?, rows.number()?);
    model.report = Report { poses, representatives, measured: rows.long()?, exceeded: rows.long()? };
    let bounds = rows.floats(6)?;
    (model.low, model.high) = ([bounds[0], bounds[1], bounds[2]], [bounds[3], bounds[4], bounds[5]]);
    let mut offsets = 0;
    if counts.version > 1 {
        (model.character.morphs.count, offsets) = (rows.number()?, rows.number()? as usize);
        let least = if counts.version == 2 { 1 } else { 0 };
        if !(least..=MOST_MORPHS).contains(&(model.character.morphs.count as usize)) {
            return Err(damaged("the number of morph targets is wrong"));
        }
    }
    rows.end()?;
    Ok((frames, offsets))
}

/// Returns the lengths of the chunks of clusters, the coarsest first.
fn read_hierarchy(bytes: &[u8], counts: &Counts, model: &mut CrowdModel) -> Result<Vec<u32>> {
    let mut rows = Rows(bytes);
    let clusters = counts.clusters;
    let (sizes, made_by, used_by) = (rows.numbers(clusters)?, rows.numbers(clusters)?, rows.numbers(clusters)?);
    let (deformation, depth) = (rows.floats(clusters)?, rows.numbers(clusters)?);
    let mut first: u32 = 0;
    for index in 0..clusters {
        let count = sizes[index];
        model.clusters.push(Cluster {
            first,
            count,
            made_by: made_by[index],
            used_by: used_by[index],
            deformation: deformation[index],
            depth: depth[index],
        });
        first = first.checked_add(count).ok_or_else(|| damaged("there are too many triangles"))?;
    }
    if first as usize != counts.triangles {
        return Err(damaged("the clusters have another number of triangles than the file"));
    }
    let errors = rows.floats(counts.groups)?;
    let mut bounds = Vec::new();
    for _ in 0..6 {
        bounds.push(rows.floats(counts.groups)?);
    }
    let depth = rows.numbers(counts.groups)?;
    for (index, error) in errors.into_iter().enumerate() {
        let low = [bounds[0][index], bounds[2][index], bounds[4][index]];
        let high = [bounds[1][index], bounds[3][index], bounds[5][index]];
        model.groups.push(Group { error, low, high, depth: depth[index] });
    }
    let lengths = rows.numbers(clusters)?;
    rows.end()?;
    Ok(lengths)
}

fn read_vertices(bytes: &[u8], (counts, offsets): (&Counts, usize), model: &mut CrowdModel) -> Result<()> {
    let mut rows = Rows(bytes);
    let count = counts.vertices;
    let axes = [rows.floats(count)?, rows.floats(count)?, rows.floats(count)?];
    let character = &mut model.character;
    character.points = (0..count).map(|index| [axes[0][index], axes[1][index], axes[2][index]]).collect();
    character.influences = vec![Influence::default(); count];
    for slot in 0..4 {
        let (bones, weights) = (rows.numbers(count)?, rows.floats(count)?);
        for (influence, (bone, weight)) in character.influences.iter_mut().zip(bones.into_iter().zip(weights)) {
            influence.bones[slot] = u16::try_from(bone).map_err(|_| damaged("a bone does not exist"))?;
            influence.weights[slot] = weight;
        }
    }
    for attribute in &mut character.attributes {
        let width = attribute.width as usize;
        let mut values = vec![0.0; count * width];
        for at in 0..width {
            let column = rows.floats(count)?;
            values.iter_mut().skip(at).step_by(width).zip(column).for_each(|(to, from)| *to = from);
        }
        attribute.values = Values::F32(values);
    }
    if character.morphs.count > 0 {
        let morphs = &mut character.morphs;
        let mut sum = 0u32;
        morphs.starts.push(0);
        for own in rows.numbers(count)? {
            sum = sum.checked_add(own).ok_or_else(|| damaged("there are too many offsets"))?;
            morphs.starts.push(sum);
        }
        let targets = rows.numbers(offsets)?;
        let axes = [rows.floats(offsets)?, rows.floats(offsets)?, rows.floats(offsets)?];
        let offset = |(at, morph): (usize, u32)| MorphOffset { morph, offset: [axes[0][at], axes[1][at], axes[2][at]] };
        morphs.offsets = targets.into_iter().enumerate().map(offset).collect();
    }
    if counts.version > 2 {
        let (groups, targets) = (rows.numbers(count)?, rows.numbers(count)?);
        let targets = (0..).zip(targets).map(|(vertex, number): (u32, u32)| vertex.wrapping_add(unfolded(number)));
        model.collapses = groups.into_iter().zip(targets).map(|(group, target)| Collapse { group, target }).collect();
    }
    rows.end()
}

fn read_poses(bytes: &[u8], frames: &[usize], model: &mut CrowdModel) -> Result<()> {
    let mut rows = Rows(bytes);
    let bones = model.character.bones.len();
    let poses: usize = frames.iter().sum();
    let total = poses.checked_mul(bones).ok_or_else(|| damaged("there are too many poses"))?;
    let mut columns = Vec::new();
    for _ in 0..12 {
        columns.push(rows.floats(total)?);
    }
    let morphs = model.character.morphs.count as usize;
    let weights = rows.floats(poses.checked_mul(morphs).ok_or_else(|| damaged("there are too many weights"))?)?;
    let matrix = |at: usize| std::array::from_fn(|row| std::array::from_fn(|column| columns[4 * row + column][at]));
    let mut made = (0..poses).map(|pose| Pose {
        bones: (0..bones).map(|bone| matrix(pose * bones + bone)).collect(),
        weights: weights[pose * morphs..(pose + 1) * morphs].to_vec(),
    });
    for (clip, count) in model.clips.iter_mut().zip(frames) {
        clip.poses = made.by_ref().take(*count).collect();
    }
    rows.end()
}

fn read_cluster(bytes: &[u8], count: usize, vertex_count: usize) -> Result<(Vec<[u32; 3]>, Vec<u32>)> {
    let mut rows = Rows(bytes);
    let (used, common) = (rows.number()? as usize, rows.number()?);
    let mut vertices = rows.numbers(used)?;
    let mut sum: u32 = 0;
    for vertex in &mut vertices {
        sum = sum.checked_add(*vertex).ok_or_else(|| damaged("a vertex does not exist"))?;
        *vertex = sum;
    }
    if sum as usize >= vertex_count {
        return Err(damaged("a vertex does not exist"));
    }
    let indices = rows.planes(3 * count, index_bytes(used))?;
    let vertex = |index: u32| vertices.get(index as usize).copied().ok_or_else(|| damaged("a vertex does not exist"));
    let triangle = |corners: &[u32; 3]| Ok([vertex(corners[0])?, vertex(corners[1])?, vertex(corners[2])?]);
    let triangles = indices.as_chunks::<3>().0.iter().map(triangle).collect::<Result<Vec<_>>>()?;
    let materials = if common == MIXED { rows.numbers(count)? } else { vec![common; count] };
    rows.end()?;
    Ok((triangles, materials))
}

impl CrowdModel {
    /// Checks that all parts fit together and that errors and boxes grow upwards, on which cuts without cracks rest.
    ///
    /// # Errors
    /// Says what does not fit.
    pub fn check(&self) -> Result<()> {
        self.character.check()?;
        let input: u64 = self.clusters.iter().filter(|it| it.made_by == NONE).map(|it| u64::from(it.count)).sum();
        if input != u64::from(self.input_triangles) {
            return Err(damaged("the clusters of the input have another number of triangles"));
        }
        if self.clips.is_empty() {
            return Err(damaged("there is no clip"));
        }
        let fits = |pose: &Pose| {
            let character = &self.character;
            pose.bones.len() == character.bones.len() && pose.weights.len() == character.morphs.count as usize
        };
        if !self.clips.iter().all(|clip| clip.rate > 0.0 && !clip.poses.is_empty() && clip.poses.iter().all(fits)) {
            return Err(damaged("a clip does not fit the bones"));
        }
        // Targets are removed later, so that a vertex that goes on comes to an end.
        let goes_on = |found: &Collapse| {
            let target = self.collapses.get(found.target as usize);
            let is_known = (found.group as usize) < self.groups.len();
            found.group == NONE || (is_known && target.is_some_and(|target| target.group > found.group))
        };
        if !(self.collapses.is_empty() || self.has_collapses()) || !self.collapses.iter().all(goes_on) {
            return Err(damaged("a vertex goes nowhere when it is removed"));
        }
        let nested = |inner: ([f32; 3], [f32; 3]), low: [f32; 3], high: [f32; 3]| {
            (0..3).all(|axis| low[axis] <= inner.0[axis] && inner.1[axis] <= high[axis])
        };
        for (index, cluster) in self.clusters.iter().enumerate() {
            let group = |number: u32| self.groups.get(number as usize);
            let (made, used) = (group(cluster.made_by), group(cluster.used_by));
            let missing = |number: u32, group: Option<&Group>| number != NONE && group.is_none();
            if missing(cluster.made_by, made) || missing(cluster.used_by, used) || cluster.count == 0 {
                return Err(damaged("it has no triangles, or its group does not exist").at(format!("cluster {index}")));
            }
            let (Some(below), Some(above)) = (made, used) else { continue };
            let grows = below.error <= above.error && nested((below.low, below.high), above.low, above.high);
            if cluster.made_by >= cluster.used_by || !grows {
                return Err(damaged("errors or boxes do not grow upwards").at(format!("cluster {index}")));
            }
        }
        Ok(())
    }
}

impl Character {
    /// Returns the bytes of a vertex in memory: place, influences and attributes.
    pub fn vertex_size(&self) -> usize {
        let widths: u32 = self.attributes.iter().map(|attribute| attribute.width).sum();
        12 + size_of::<Influence>() + 4 * widths as usize
    }
}
