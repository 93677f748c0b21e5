//! The file of a document, `.relievo`, version 5, little-endian:
//!
//! - header, 44 bytes: `RLVDOC\r\n`, version (u32), CRC-32 of the packed index (u32), bytes of the index packed and
//!   unpacked (u64 each), bytes of all blocks (u64), CRC-32 of the header up to here (u32);
//! - index (zstd): writer, instruction level, time (f64, seconds), the mesh (number of faces, corners and holes, hash
//!   of its sharpness, fingerprint, sizes of faces, corners as differences, holes as differences, number of points and
//!   their coordinates, what blocks belong to: u8, 0 for tiles, 1 for triangles, edges and points, see
//!   [`crate::lattice`]), then layer by layer name, kind, default texel, number, opacity, blend mode, visibility, sizes
//!   of the tiles of every face as powers of two, a byte that says what of the following is there (1: the sizes that
//!   faces were given before edits at other levels, as powers of two; 2: the texel that is seen behind all layers of
//!   the kind), and of every block tile, bytes and CRC-32; number of [recipes](crate::recipe), and of each number and bytes
//!   (u32 each) with the bytes themselves, ascending by number;
//! - blocks (zstd each), in the order of the index, without gaps;
//! - the index and the header once more, see [`crate::copies`];
//! - the journal: any number of [records](crate::record), which are folded into what is before them on opening.
//!
//! A layer that fades has a layer of kind 5 beside it, [`Kind::Stamps`](crate::Kind::Stamps), whose head says after its
//! kind the number of the layer that fades, the kind of its texels, and for how many seconds an edit stays and then
//! fades (f32 each). Its blocks have all texels as they were when they were edited last and then all times (f32), rings
//! included, which mean nothing; so the fade goes on as if it had not been interrupted, whatever is left of it in the
//! blocks of the layer itself. On triangles they are blocks of faces, edges and vertices, as the layer has them.
//!
//! Version 4 has no recipes. Version 3 has no second copies. Version 2 has no times, no stamps, nothing in heads after the
//! sizes, and does not say what blocks belong to: always
//! tiles. Version 1 has no points, no numbers and settings of layers, and no journal. The same document always makes
//! the same bytes. Readers believe nothing: lengths are compared with the file and the memory limit before anything is
//! allocated.

use std::fmt;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;

use relievo_core::budget::Budget;
use relievo_core::{Context, Error, ErrorKind, Result, file};

use crate::code::{Decoder, Encoder};
use crate::head::Head;
use crate::layer::{Block, Layer, MAX_PACKED, Place};
use crate::pages::Source;
use crate::recipe::{MAX_RECIPE, MAX_RECIPES, Recipe};
use crate::record::failed;
use crate::replay::{self, Log};
use crate::{Document, MAX_LAYERS, Topology, copies};

pub(crate) const MAGIC: [u8; 8] = *b"RLVDOC\r\n";
/// The version that is written, and the newest that is read.
pub const VERSION: u32 = 5;
pub(crate) const HEADER: usize = 44;
/// The level of zstd for the index.
const COMPRESSION: i32 = 3;
/// Bytes of a block in the index.
const ENTRY: u64 = 12;
/// The extension of documents, without the dot.
pub const EXTENSION: &str = "relievo";

/// A part of a document that is damaged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// The layer, tile and face.
    pub place: String,
    /// What is wrong with it.
    pub what: String,
    /// Whether it is lost; false where a copy of it is whole.
    pub lost: bool,
}

impl fmt::Display for Damage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.place, self.what)
    }
}

impl Document {
    /// Writes it to `path`. The file appears under its name when it is complete.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be written, and with `Internal` if zstd fails.
    pub fn write(&self, path: &Path) -> Result<()> {
        let head = self.head()?;
        file::store(path, |out| self.write_parts(&head, out))
    }

    /// Writes the bytes of its file to `out`.
    ///
    /// # Errors
    /// `out` cannot be written.
    pub fn write_to(&self, out: &mut dyn Write) -> Result<()> {
        self.write_parts(&self.head()?, out).map_err(failed)
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// Fails with `Internal` if zstd fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.write_to(&mut bytes)?;
        Ok(bytes)
    }

    /// Writes the header and index that [`Self::head`] returned, the blocks, and the second copies.
    pub(crate) fn write_parts(&self, (head, index): &(Vec<u8>, Vec<u8>), out: &mut dyn Write) -> std::io::Result<()> {
        out.write_all(head)?;
        out.write_all(index)?;
        self.layers.iter().flat_map(|layer| &layer.blocks).try_for_each(|block| out.write_all(&block.packed))?;
        out.write_all(index)?;
        out.write_all(head)
    }

    /// Header and packed index.
    pub(crate) fn head(&self) -> Result<(Vec<u8>, Vec<u8>)> {
        let raw = self.index();
        let index = zstd::bulk::compress(&raw, COMPRESSION)
            .map_err(|error| Error::internal(format!("the index cannot be compressed: {error}")))?;
        let blocks = self.layers.iter().flat_map(|layer| &layer.blocks).map(|block| block.packed.len() as u64).sum();
        let mut header = Encoder::default();
        header.0.extend_from_slice(&MAGIC);
        header.u32(VERSION);
        header.u32(crc32fast::hash(&index));
        header.u64(index.len() as u64);
        header.u64(raw.len() as u64);
        header.u64(blocks);
        header.u32(crc32fast::hash(&header.0));
        Ok((header.0, index))
    }

    fn index(&self) -> Vec<u8> {
        let mut out = Encoder::default();
        out.text(&self.writer);
        out.text(&self.level);
        out.u64(self.time.to_bits());
        let topology = &self.topology;
        out.u32(topology.face_count() as u32);
        out.u32(topology.corners().len() as u32);
        out.u32(topology.holes().len() as u32);
        out.u64(topology.sharpness());
        out.u64(topology.fingerprint());
        topology.face_sizes().iter().for_each(|size| out.short(*size));
        // Neighbouring corners have near numbers, in either direction.
        let mut before = 0u32;
        for corner in topology.corners() {
            let step = corner.wrapping_sub(before) as i32;
            out.short(((step << 1) ^ (step >> 31)) as u32);
            before = *corner;
        }
        let mut before = 0;
        for hole in topology.holes() {
            out.short(hole - before);
            before = *hole;
        }
        out.u32(self.points.len() as u32);
        self.points.as_flattened().iter().for_each(|number| out.u32(number.to_bits()));
        out.0.push(u8::from(topology.is_of_triangles()));
        out.u32(self.layers.len() as u32);
        for layer in &self.layers {
            layer.head.encode(&mut out);
            out.u32(layer.blocks.len() as u32);
            for block in &layer.blocks {
                out.u32(block.tile);
                out.u32(block.packed.len() as u32);
                out.u32(block.crc);
            }
        }
        out.u32(self.recipes.len() as u32);
        for recipe in &self.recipes {
            out.u32(recipe.id);
            out.u32(recipe.bytes.len() as u32);
            out.0.extend_from_slice(&recipe.bytes);
        }
        out.0
    }

    /// Reads the document at `path`, which may occupy `limit` bytes with what is made of it, with all edits of its
    /// journal. An edit that was under way when its program was killed is left out, and noted; damage to the second
    /// copies of header and index alone is noted too.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be read, with `Invalid` if it is no document or any other part
    /// of it is damaged, with `Unsupported` if its version is newer than [`VERSION`], and with `Memory` if it needs
    /// more than `limit`.
    pub fn open(path: &Path, limit: u64) -> Result<Self> {
        let open = || Ok(read(&mut file::open(path)?, limit)?.sound()?.0.with_source(path));
        let place = path.display().to_string();
        open().map_err(|error: Error| if error.place.starts_with(&place) { error } else { error.at(place) })
    }

    /// Reads a document from `bytes`, as [`Self::open`] does.
    ///
    /// # Errors
    /// Fails with `Invalid`, `Unsupported` or `Memory`, as [`Self::open`].
    pub fn parse(bytes: &[u8], limit: u64) -> Result<Self> {
        Ok(read(&mut Cursor::new(bytes), limit)?.sound()?.0)
    }

    /// Knows the file that it was read from, for [`Self::page`].
    pub(crate) fn with_source(mut self, path: &Path) -> Self {
        self.source.open(path);
        self
    }

    /// It without the blocks that are damaged.
    pub(crate) fn without_damage(mut self, context: &Context) -> Self {
        let topology = &self.topology;
        for layer in &mut self.layers {
            let sound = context.map(layer.blocks.len(), |at| verify(topology, layer, at).is_none());
            let mut sound = sound.into_iter();
            layer.blocks.retain(|_| sound.next().unwrap_or_default());
        }
        self
    }
}

/// A document as it was found.
#[derive(Debug)]
pub(crate) struct Found {
    /// With all edits of its journal; damaged blocks of the base are empty.
    pub document: Document,
    pub damage: Vec<Damage>,
    /// Why the document is refused where its header or its index was read from the copy.
    pub refusal: Option<Error>,
    pub log: Log,
}

impl Found {
    /// Returns the document and its journal. A note of the document says so where only second copies are damaged.
    ///
    /// # Errors
    /// Anything else is damaged.
    pub fn sound(mut self) -> Result<(Document, Log)> {
        if let Some(refusal) = self.refusal {
            return Err(refusal);
        }
        if self.damage.iter().all(|damage| !damage.lost) {
            let note =
                |damage: &Damage| format!("{damage}; nothing is lost, and `relievo doc repair` writes them anew");
            self.document.notes.extend(self.damage.iter().map(note));
            self.document.notes.extend(self.log.note());
            return Ok((self.document, self.log));
        }
        let first = &self.damage[0];
        let more = match self.damage.len() {
            1 => String::new(),
            count => format!(", and {} more", count - 1),
        };
        Err(damaged(&format!("{}{more}", first.what)).at(&first.place))
    }
}

/// Reads what can be read of the document at `path`, verifies every block, and says what is damaged.
///
/// # Errors
/// Fails with `NotFound` or `Io` if the file cannot be read, with `Invalid` if it is no document or neither copy of its
/// header or of its index can be read, with `Unsupported` if its version is newer than [`VERSION`], and with `Memory`
/// if it needs more than the context's memory limit.
pub fn examine(context: &Context, path: &Path) -> Result<(Document, Vec<Damage>)> {
    let mut file = file::open(path)?;
    let (mut found, damage) = examined(context, &mut file).map_err(|error| error.at(path.display().to_string()))?;
    found.document.notes.extend(found.log.note());
    Ok((found.document, damage))
}

/// Reads a document and verifies every block.
pub(crate) fn examined(context: &Context, source: &mut (impl Read + Seek)) -> Result<(Found, Vec<Damage>)> {
    let mut found = read(source, context.memory_limit())?;
    let mut damage = std::mem::take(&mut found.damage);
    for layer in &found.document.layers {
        let verified = context.map(layer.blocks.len(), |at| verify(&found.document.topology, layer, at));
        damage.extend(verified.into_iter().flatten().filter(|damage| !damage.what.is_empty()));
    }
    Ok((found, damage))
}

/// What is wrong with a block; damage that says nothing if it was told when the file was read.
fn verify(topology: &Topology, layer: &Layer, at: usize) -> Option<Damage> {
    let tile = layer.blocks[at].tile;
    let told = |what: String| Some(Damage { lost: true, place: place(topology, layer.name(), tile), what });
    if layer.blocks[at].packed.is_empty() {
        return told(String::new());
    }
    let bytes = match layer.unpack(topology, at) {
        Ok(bytes) => bytes,
        Err(error) => return told(error.what),
    };
    if !layer.head.all_finite(&bytes) {
        return told("it holds numbers that are not finite".into());
    }
    None
}

pub(crate) fn place(topology: &Topology, layer: &str, tile: u32) -> String {
    format!("layer `{layer}`: {}", topology.block_name(tile))
}

pub(crate) fn damaged(what: &str) -> Error {
    Error::invalid(format!("the document is damaged: {what}"))
        .advise("see `relievo doc check` and `relievo doc repair`, or take an older copy")
}

/// The document in `source`.
pub(crate) fn read(source: &mut (impl Read + Seek), limit: u64) -> Result<Found> {
    let length = replay::length(source)?;
    source.rewind().map_err(failed)?;
    let mut budget = Budget::new(limit);
    let mut bytes = Vec::new();
    source.take(HEADER as u64).read_to_end(&mut bytes).map_err(failed)?;
    let (mut damage, mut refusal) = (Vec::new(), None);
    let header = match Header::parse(&bytes) {
        Ok(header) => header,
        Err(error) => {
            let Some((copy, header)) = copies::find_header(source)? else { return Err(error) };
            damage.push(Damage { place: "header".into(), what: error.what.clone(), lost: false });
            refusal = Some(error);
            bytes = copy;
            source.seek(SeekFrom::Start(HEADER as u64)).map_err(failed)?;
            header
        }
    };
    let base = header.base();
    let present = base.min(length);
    let index = usize::try_from(header.index_length).unwrap_or(usize::MAX);
    if header.index_length > present - HEADER as u64 {
        return Err(damaged("it ends in its index"));
    }
    let first = take(source, HEADER as u64, index, &mut budget)?;
    let blocks_start = (HEADER + index) as u64;
    let blocks_end = header.blocks_end();
    // Nothing follows blocks that are cut off.
    let after = present.saturating_sub(blocks_end).min((index + HEADER) as u64) as usize;
    let copies = take(source, blocks_end.min(present), after, &mut budget)?;
    let copy = copies.get(..index).unwrap_or_default();
    let packed = match crc32fast::hash(&first) == header.index_crc {
        true => first.as_slice(),
        false => {
            let error = damaged("the checksum of its index is wrong");
            if header.copy_at().is_none() || crc32fast::hash(copy) != header.index_crc {
                return Err(error);
            }
            damage.push(Damage { place: "index".into(), what: "its checksum is wrong".into(), lost: false });
            refusal.get_or_insert(error);
            copy
        }
    };
    if header.copy_at().is_some() && copies != [packed, bytes.as_slice()].concat() {
        let what = "they are not as the first ones".into();
        damage.push(Damage { place: "copies of the header and the index".into(), what, lost: false });
    }
    let mut raw = budget.filled(usize::try_from(header.raw_length).unwrap_or(usize::MAX), 0u8)?;
    let unpacked = zstd::bulk::decompress_to_buffer(packed, raw.as_mut_slice());
    if unpacked.ok() != Some(raw.len()) {
        return Err(damaged("its index does not unpack to its size"));
    }
    let (document, lengths) = read_index(&raw, header.version, &mut budget)?;
    source.seek(SeekFrom::Start(blocks_start)).map_err(failed)?;
    let held = blocks_end.min(present) - blocks_start;
    // Blocks that are larger than the buffer are read past it.
    let mut blocks = BufReader::with_capacity(1 << 16, &mut *source);
    let (mut document, lost) =
        fill(document, &lengths, &mut blocks, (blocks_start, held), header.blocks_length, &mut budget)?;
    if length < base && lost.is_empty() {
        // A journal that followed the copies is missing too.
        refusal.get_or_insert_with(|| damaged("it ends in the copies of its header and index"));
    }
    damage.splice(0..0, lost);
    document.source = Source::of(&bytes);
    let mut log = Log::default();
    if header.version > 1 {
        log = replay::fold(&mut document, source, base, &mut budget, &mut damage)?;
    } else if length > base {
        let what = format!("{} bytes follow that are none of its", length - base);
        damage.push(Damage { lost: true, place: "after the last block".into(), what });
    }
    Ok(Found { document, damage, refusal, log })
}

/// What the header says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Header {
    version: u32,
    index_crc: u32,
    index_length: u64,
    raw_length: u64,
    blocks_length: u64,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        if !bytes.starts_with(&MAGIC) {
            return Err(Error::invalid("it does not begin as a document does").advise("name a file that relievo wrote"));
        }
        let ends = || damaged("it ends in its header");
        let mut header = Decoder(&bytes[MAGIC.len()..]);
        let version = header.u32().map_err(|_| ends())?;
        if version > VERSION {
            return Err(Error::unsupported(format!("the document has format version {version}"))
                .advise(format!("this build reads versions up to {VERSION}: take a newer relievo")));
        }
        if bytes.len() != HEADER {
            return Err(ends());
        }
        let (index_crc, index_length, raw_length) = (header.u32()?, header.u64()?, header.u64()?);
        let (blocks_length, header_crc) = (header.u64()?, header.u32()?);
        if version == 0 || crc32fast::hash(&bytes[..HEADER - size_of::<u32>()]) != header_crc {
            return Err(damaged("the checksum of its header is wrong"));
        }
        Ok(Self { version, index_crc, index_length, raw_length, blocks_length })
    }

    /// Where the blocks end.
    fn blocks_end(&self) -> u64 {
        (HEADER as u64).saturating_add(self.index_length).saturating_add(self.blocks_length)
    }

    /// Where the second copy of the header is, if the version has one.
    pub fn copy_at(&self) -> Option<u64> {
        (self.version > 3).then(|| self.blocks_end().saturating_add(self.index_length))
    }

    /// Where the journal begins.
    fn base(&self) -> u64 {
        self.copy_at().map_or(self.blocks_end(), |copy| copy.saturating_add(HEADER as u64))
    }
}

/// The document whose index is `raw`, without the bytes of its blocks, and their lengths.
fn read_index(raw: &[u8], version: u32, budget: &mut Budget) -> Result<(Document, Vec<u32>)> {
    let mut index = Decoder(raw);
    let (writer, level) = (index.text()?, index.text()?);
    let time = if version > 2 { f64::from_bits(index.u64()?) } else { 0.0 };
    if !time.is_finite() || time.abs() > f64::from(f32::MAX) {
        return Err(damaged("its time is none"));
    }
    let mut topology = read_topology(&mut index, budget)?;
    let faces = topology.face_count();
    let points = if version > 1 { read_points(&mut index, budget)? } else { Vec::new() };
    if version > 2 {
        match index.u8()? {
            0 => {}
            1 => topology = topology.into_triangles(points.len(), budget).map_err(unfit)?,
            _ => return Err(damaged("its blocks belong to what is not known")),
        }
    }
    let count = index.u32()? as usize;
    if count > MAX_LAYERS {
        return Err(damaged("it claims too many layers"));
    }
    let mut document = Document {
        writer,
        level,
        version,
        time,
        notes: Vec::new(),
        topology,
        points,
        layers: Vec::new(),
        recipes: Vec::new(),
        source: Default::default(),
    };
    let mut lengths = Vec::new();
    for _ in 0..count {
        let id = document.free_id();
        let head = Head::decode(&mut index, version, id, faces, budget)?;
        let count = index.u32()?;
        index.expect(u64::from(count) * ENTRY)?;
        let mut blocks = Vec::new();
        budget.reserve(&mut blocks, count as usize)?;
        budget.reserve(&mut lengths, count as usize)?;
        for _ in 0..count {
            let (tile, length, crc) = (index.u32()?, index.u32()?, index.u32()?);
            if length > MAX_PACKED || length == 0 {
                return Err(damaged(&format!("tile {tile} of layer `{}` claims an impossible size", head.name)));
            }
            blocks.push(Block { tile, crc, packed: Vec::new(), place: Place::default() });
            lengths.push(length);
        }
        let layer = Layer { head, blocks };
        document.add(layer).map_err(|error| damaged(&error.what).at(error.place))?;
    }
    if version > 4 {
        document.recipes = read_recipes(&mut index, budget)?;
    }
    if !index.0.is_empty() {
        return Err(damaged("its index is longer than it says"));
    }
    Ok((document, lengths))
}

/// An error of what was read, as damage; memory is none.
fn unfit(error: Error) -> Error {
    if error.kind == ErrorKind::Memory { error } else { damaged(&error.what) }
}

fn read_recipes(index: &mut Decoder, budget: &mut Budget) -> Result<Vec<Recipe>> {
    let count = index.u32()? as usize;
    index.expect(2 * count as u64 * size_of::<u32>() as u64)?;
    if count > MAX_RECIPES {
        return Err(damaged("it claims too many recipes"));
    }
    let mut recipes: Vec<Recipe> = Vec::new();
    budget.reserve(&mut recipes, count)?;
    for _ in 0..count {
        let (id, length) = (index.u32()?, index.u32()? as usize);
        let bytes = index.bytes(length)?;
        if length > MAX_RECIPE || recipes.last().is_some_and(|last| last.id >= id) {
            return Err(damaged(&format!("its recipe {id} is too long or out of order")));
        }
        budget.charge(length as u64)?;
        recipes.push(Recipe { id, bytes: bytes.to_vec() });
    }
    Ok(recipes)
}

fn read_points(index: &mut Decoder, budget: &mut Budget) -> Result<Vec<[f32; 3]>> {
    let count = index.u32()?;
    index.expect(u64::from(count) * size_of::<[f32; 3]>() as u64)?;
    let mut points = Vec::new();
    budget.reserve(&mut points, count as usize)?;
    for _ in 0..count {
        points.push([index.u32()?, index.u32()?, index.u32()?].map(f32::from_bits));
    }
    Ok(points)
}

fn read_topology(index: &mut Decoder, budget: &mut Budget) -> Result<Topology> {
    let [faces, corners, holes] = [index.u32()?, index.u32()?, index.u32()?].map(|count| count as usize);
    let (sharpness, fingerprint) = (index.u64()?, index.u64()?);
    index.expect([faces, corners, holes].map(|count| count as u64).iter().sum())?;
    let (mut sizes, mut points, mut closed) = (Vec::new(), Vec::new(), Vec::new());
    budget.reserve(&mut sizes, faces)?;
    budget.reserve(&mut points, corners)?;
    budget.reserve(&mut closed, holes)?;
    // The first tile of every face.
    budget.charge((faces as u64 + 1) * size_of::<u32>() as u64)?;
    for _ in 0..faces {
        sizes.push(index.short()?);
    }
    let mut before = 0u32;
    for _ in 0..corners {
        let step = index.short()?;
        before = before.wrapping_add((step >> 1) ^ (step & 1).wrapping_neg());
        points.push(before);
    }
    let mut before = 0u32;
    for _ in 0..holes {
        before = before.checked_add(index.short()?).ok_or_else(|| damaged("a hole is no face"))?;
        closed.push(before);
    }
    let topology = Topology::new(sizes, points, closed, sharpness).map_err(|error| damaged(&error.what))?;
    if topology.fingerprint() != fingerprint {
        return Err(damaged("its mesh is not that of its fingerprint"));
    }
    Ok(topology)
}

/// Reads `count` bytes at `start`, which the source has.
fn take(source: &mut (impl Read + Seek), start: u64, count: usize, budget: &mut Budget) -> Result<Vec<u8>> {
    source.seek(SeekFrom::Start(start)).map_err(failed)?;
    let mut bytes = Vec::new();
    budget.reserve(&mut bytes, count)?;
    source.take(count as u64).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Gives the blocks of `document` their bytes, of which `source` has `held` from `start` on.
fn fill(
    mut document: Document,
    lengths: &[u32],
    source: &mut impl Read,
    (start, held): (u64, u64),
    claimed: u64,
    budget: &mut Budget,
) -> Result<(Document, Vec<Damage>)> {
    let total: u64 = lengths.iter().map(|length| u64::from(*length)).sum();
    if total != claimed {
        return Err(damaged("its blocks are not as long as its header says"));
    }
    let mut damage = Vec::new();
    let (mut lengths, mut at, end) = (lengths.iter(), start, start + held);
    let topology = &document.topology;
    for layer in &mut document.layers {
        let name = layer.head.name.as_str();
        for block in &mut layer.blocks {
            let length = lengths.next().map_or(0, |length| u64::from(*length));
            block.place = Place(Some(at));
            at += length;
            let what = if at > end {
                "the file ends before the end of the block"
            } else {
                budget.reserve(&mut block.packed, length as usize)?;
                source.take(length).read_to_end(&mut block.packed).map_err(failed)?;
                if crc32fast::hash(&block.packed) == block.crc {
                    continue;
                }
                block.packed = Vec::new();
                "the checksum of the block is wrong"
            };
            damage.push(Damage { lost: true, place: place(topology, name, block.tile), what: what.into() });
        }
    }
    Ok((document, damage))
}
