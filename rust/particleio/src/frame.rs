//! A frame of a cache of particles, `.rlvfluid`, version 1, little-endian:
//!
//! - header, 44 bytes: `RLVFLUID`, version (u32), CRC-32 of the packed index (u32), bytes of the index packed and unpacked
//!   and of all chunks (u64 each), CRC-32 of the header up to here (u32);
//! - index (zstd): time (f64, seconds; not a number if unknown), spacing (f32, metres; 0 if unknown), instruction level
//!   (text: its length in a byte, UTF-8), number of particles (u32) and of sections (u32), and of each section its kind
//!   (u8: 0 places, 1 numbers, 2 a channel, 3 the state of a solver), name (text), numbers per particle (u8; of a state 1),
//!   how many items it has (u64: particles, or bytes of a state), and of each of its chunks bytes and CRC-32 (u32 each);
//! - chunks (zstd each) of 65,536 items, in the order of the index, without gaps. Numbers lie in four planes, first the
//!   lowest bytes of all.
//!
//! A state is what its solver needs to go on from this frame as if it had never stopped; readers of particles step over
//! it. The same frame always makes the same bytes. Readers believe nothing: lengths are compared with the file and the
//! memory limit before anything is allocated.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use relievo_core::{Budget, Context, Error, Result, file};

use crate::bytes::Bytes;
use crate::particles::{Channel, MAX, MAX_CHANNELS, Particles};

pub(crate) const MAGIC: [u8; 8] = *b"RLVFLUID";
/// The version that is written, and the newest that is read.
pub const VERSION: u32 = 1;
/// The extension of frames of a cache, without the dot.
pub const EXTENSION: &str = "rlvfluid";
const HEADER: usize = 44;
/// Items of a chunk.
const CHUNK: usize = 1 << 16;
/// Bytes of an index at most: all channels of 2³¹ particles.
const MAX_INDEX: u64 = 1 << 26;
/// Bytes of a state at most.
const MAX_STATE: u64 = 1 << 32;
/// The level of zstd: floats gain little by more.
const COMPRESSION: i32 = 1;

const PLACES: u8 = 0;
const NUMBERS: u8 = 1;
const CHANNEL: u8 = 2;
const STATE: u8 = 3;

/// What a frame of a cache holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The particles, in the order of the solver.
    pub particles: Particles,
    /// The instruction level it was made at.
    pub level: String,
    /// What the solver needs to go on, as its owner wrote it.
    pub state: Option<Vec<u8>>,
}

/// Items of a section, to be written.
enum Items<'a> {
    Floats(&'a [f32]),
    Numbers(&'a [u32]),
    State(&'a [u8]),
}

struct Section<'a> {
    kind: u8,
    name: &'a str,
    width: usize,
    items: Items<'a>,
}

impl Section<'_> {
    fn len(&self) -> usize {
        match self.items {
            Items::Floats(values) => values.len() / self.width,
            Items::Numbers(values) => values.len(),
            Items::State(bytes) => bytes.len(),
        }
    }

    /// The bytes of a chunk before they are packed.
    fn chunk(&self, number: usize) -> Vec<u8> {
        let items = number * CHUNK..((number + 1) * CHUNK).min(self.len());
        let words = items.start * self.width..items.end * self.width;
        match self.items {
            Items::Floats(values) => planes(values[words].iter().map(|value| value.to_bits())),
            Items::Numbers(values) => planes(values[words].iter().copied()),
            Items::State(bytes) => bytes[items].to_vec(),
        }
    }
}

/// Numbers as four planes of bytes.
fn planes(words: impl Iterator<Item = u32> + Clone) -> Vec<u8> {
    (0..4).flat_map(|plane| words.clone().map(move |word| (word >> (8 * plane)) as u8)).collect()
}

/// Writes a frame of a cache. The file appears under its name when it is complete.
///
/// # Errors
/// Fails, and leaves no file, as [`Particles::check`] does, and with `NotFound` or `Io` if the system refuses.
pub fn write_frame(context: &Context, path: &Path, particles: &Particles, state: Option<&[u8]>) -> Result<()> {
    let parts = parts(context, particles, state).map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| parts.iter().try_for_each(|part| std::io::Write::write_all(out, part)))
}

/// Bytes of a frame of a cache with these particles and no state.
///
/// # Errors
/// Fails as [`Particles::check`] does, and with `Internal` if zstd fails.
pub fn frame_bytes(context: &Context, particles: &Particles) -> Result<usize> {
    Ok(parts(context, particles, None)?.iter().map(Vec::len).sum())
}

/// Returns the bytes that a file of a frame has.
///
/// # Errors
/// Fails as [`Particles::check`] does, and with `Internal` if zstd fails.
pub fn encode_frame(context: &Context, particles: &Particles, state: Option<&[u8]>) -> Result<Vec<u8>> {
    Ok(parts(context, particles, state)?.concat())
}

/// The parts of a file, in order.
fn parts(context: &Context, particles: &Particles, state: Option<&[u8]>) -> Result<Vec<Vec<u8>>> {
    particles.check()?;
    let places = Items::Floats(particles.points.as_flattened());
    let mut sections = vec![Section { kind: PLACES, name: "", width: 3, items: places }];
    let numbers = particles.numbers.iter();
    sections.extend(numbers.map(|it| Section { kind: NUMBERS, name: "", width: 1, items: Items::Numbers(it) }));
    sections.extend(particles.channels.iter().map(|Channel { name, width, values }| Section {
        kind: CHANNEL,
        name,
        width: *width as usize,
        items: Items::Floats(values),
    }));
    sections.extend(state.map(|it| Section { kind: STATE, name: "", width: 1, items: Items::State(it) }));
    let chunks = sections.iter().enumerate();
    let chunks: Vec<_> =
        chunks.flat_map(|(at, it)| (0..it.len().div_ceil(CHUNK)).map(move |chunk| (at, chunk))).collect();
    let packed = context.map(chunks.len(), |at| {
        let (section, chunk) = chunks[at];
        zstd::bulk::compress(&sections[section].chunk(chunk), COMPRESSION)
    });
    let refused = |error: std::io::Error| Error::internal(format!("zstd: {error}"));
    let mut packed = packed.into_iter().collect::<std::io::Result<Vec<_>>>().map_err(refused)?;
    let index = index(context, particles, &sections, &packed);
    let packed_index = zstd::bulk::compress(&index, COMPRESSION).map_err(refused)?;
    let mut header = MAGIC.to_vec();
    header.extend(VERSION.to_le_bytes());
    header.extend(crc32fast::hash(&packed_index).to_le_bytes());
    let bytes = packed.iter().map(Vec::len).sum();
    header.extend([packed_index.len(), index.len(), bytes].iter().flat_map(|length| (*length as u64).to_le_bytes()));
    header.extend(crc32fast::hash(&header).to_le_bytes());
    packed.splice(0..0, [header, packed_index]);
    Ok(packed)
}

fn index(context: &Context, particles: &Particles, sections: &[Section], packed: &[Vec<u8>]) -> Vec<u8> {
    let mut out = Vec::new();
    let text = |out: &mut Vec<u8>, text: &str| {
        out.push(text.len() as u8);
        out.extend_from_slice(text.as_bytes());
    };
    out.extend(particles.time.unwrap_or(f64::NAN).to_le_bytes());
    out.extend(particles.spacing.unwrap_or_default().to_le_bytes());
    text(&mut out, context.level().name());
    out.extend((particles.points.len() as u32).to_le_bytes());
    out.extend((sections.len() as u32).to_le_bytes());
    let mut packed = packed.iter();
    for section in sections {
        out.push(section.kind);
        text(&mut out, section.name);
        out.push(section.width as u8);
        out.extend((section.len() as u64).to_le_bytes());
        for chunk in packed.by_ref().take(section.len().div_ceil(CHUNK)) {
            out.extend([chunk.len() as u32, crc32fast::hash(chunk)].iter().flat_map(|number| number.to_le_bytes()));
        }
    }
    out
}

/// What a header says.
struct Header {
    /// CRC-32 of the packed index.
    index_sum: u32,
    /// Bytes of the index packed and unpacked.
    index_bytes: u64,
    index_length: u64,
    /// Bytes of all chunks.
    chunk_bytes: u64,
}

impl Header {
    /// Reads the beginning of a file. Fails if it is not that of a frame, damaged or of a newer version.
    fn read(bytes: &[u8]) -> Result<Self> {
        let mut file = Bytes(bytes);
        if file.array()? != MAGIC {
            return Err(
                Error::invalid("the file does not begin with `RLVFLUID`").advise("check that it is a frame of a cache")
            );
        }
        let version = u32::from_le_bytes(file.array()?);
        if version == 0 || version > VERSION {
            return Err(Error::unsupported(format!(
                "it is of version {version}, and versions up to {VERSION} are known"
            ))
            .advise("take a newer Relievo"));
        }
        let index_sum = u32::from_le_bytes(file.array()?);
        let mut length = || file.array().map(u64::from_le_bytes);
        let [index_bytes, index_length, chunk_bytes] = [length()?, length()?, length()?];
        if u32::from_le_bytes(file.array()?) != crc32fast::hash(&bytes[..HEADER - 4]) {
            return Err(damaged("the checksum of its header is wrong"));
        }
        if index_length > MAX_INDEX {
            return Err(damaged("it is not as long as it says"));
        }
        Ok(Self { index_sum, index_bytes, index_length, chunk_bytes })
    }
}

/// Where a chunk lies behind the index, and its CRC-32.
#[derive(Clone, Copy, Debug)]
struct Slot {
    start: u64,
    length: u32,
    sum: u32,
}

/// A section of a file: what it is, and its chunks.
#[derive(Debug)]
struct Entry {
    kind: u8,
    name: String,
    width: usize,
    items: usize,
    slots: Vec<Slot>,
}

/// The index of a file.
#[derive(Debug)]
struct Index {
    time: Option<f64>,
    spacing: Option<f32>,
    level: String,
    count: usize,
    entries: Vec<Entry>,
}

impl Index {
    /// Reads a packed index. Fails if it is damaged, or its chunks do not lie one after the other as the header says.
    fn read(packed: &[u8], header: &Header) -> Result<Self> {
        if crc32fast::hash(packed) != header.index_sum {
            return Err(damaged("the checksum of its index is wrong"));
        }
        let index = unpack(packed, header.index_length as usize)?;
        let mut index = Bytes(&index);
        let time = f64::from_le_bytes(index.array()?);
        let spacing = f32::from_le_bytes(index.array()?);
        let level = text(&mut index)?;
        let count = u32::from_le_bytes(index.array()?) as usize;
        let sections = u32::from_le_bytes(index.array()?) as usize;
        if count as u64 > MAX || sections > MAX_CHANNELS + 3 {
            return Err(damaged("it has too many particles or sections"));
        }
        let (mut entries, mut end) = (Vec::new(), 0);
        for number in 0..sections {
            let entry = Entry::read(&mut index, &mut end, count)?;
            if (entry.kind == PLACES) != (number == 0) {
                return Err(damaged("its first section, and no other, is that of the places"));
            }
            entries.push(entry);
        }
        if sections == 0 || end != header.chunk_bytes || !index.0.is_empty() {
            return Err(damaged("its sections are not as long as it says"));
        }
        let (time, spacing) = ((!time.is_nan()).then_some(time), (spacing != 0.0).then_some(spacing));
        Ok(Self { time, spacing, level, count, entries })
    }
}

impl Entry {
    /// Reads the next section of an index, whose first chunk begins at `end`, which moves behind the last one.
    fn read(index: &mut Bytes, end: &mut u64, count: usize) -> Result<Self> {
        let [kind] = index.array()?;
        let name = text(index)?;
        let [width] = index.array()?;
        let items = u64::from_le_bytes(index.array()?);
        let fits = match kind {
            PLACES => width == 3 && items == count as u64,
            NUMBERS => width == 1 && items == count as u64,
            CHANNEL => (1..=4).contains(&width) && items == count as u64,
            STATE => width == 1 && items <= MAX_STATE,
            _ => return Err(damaged("a section is of an unknown kind")),
        };
        let chunks = items.div_ceil(CHUNK as u64);
        if !fits || chunks.saturating_mul(8) > index.0.len() as u64 {
            return Err(damaged("a section has a size that cannot be"));
        }
        let mut slot = || {
            let [length, sum] = [index.array()?, index.array()?].map(u32::from_le_bytes);
            let start = *end;
            *end += u64::from(length);
            Ok(Slot { start, length, sum })
        };
        let slots = (0..chunks).map(|_| slot()).collect::<Result<_>>()?;
        Ok(Self { kind, name, width: width.into(), items: items as usize, slots })
    }

    /// Returns a chunk of the section from its packed bytes. Fails if these are damaged.
    fn unpack(&self, number: usize, packed: &[u8]) -> Result<Vec<u8>> {
        if crc32fast::hash(packed) != self.slots[number].sum {
            return Err(damaged("the checksum of a chunk is wrong"));
        }
        let items = CHUNK.min(self.items - number * CHUNK);
        unpack(packed, if self.kind == STATE { items } else { 4 * self.width * items })
    }
}

/// Returns the number at a place of a chunk that was unpacked.
fn word(bytes: &[u8], at: usize) -> u32 {
    let count = bytes.len() / 4;
    u32::from_le_bytes([0, 1, 2, 3].map(|plane| bytes[plane * count + at]))
}

/// A section that is read, and the packed bytes of its chunks.
struct Packed<'a> {
    entry: Entry,
    chunks: Vec<&'a [u8]>,
}

/// Reads a frame of a cache. The context's memory limit bounds the file and what is made of it together.
///
/// # Errors
/// Fails with `Invalid` if the file is damaged, with `Unsupported` if it is of a newer version, and with `Memory` if it
/// needs more memory than the limit.
pub fn read_frame(context: &Context, bytes: &[u8]) -> Result<Frame> {
    let mut budget = Budget::new(context.memory_limit().saturating_sub(bytes.len() as u64));
    let header = Header::read(bytes)?;
    let mut file = Bytes(&bytes[HEADER..]);
    let packed = file.take(header.index_bytes)?;
    if file.0.len() as u64 != header.chunk_bytes {
        return Err(damaged("it is not as long as it says"));
    }
    budget.charge(header.index_length)?;
    let Index { time, spacing, level, entries, .. } = Index::read(packed, &header)?;
    let mut frame = Frame { level, ..Frame::default() };
    (frame.particles.time, frame.particles.spacing) = (time, spacing);
    for (number, entry) in entries.into_iter().enumerate() {
        let chunks = entry.slots.iter().map(|slot| file.take(slot.length.into())).collect::<Result<_>>()?;
        let packed = Packed { entry, chunks };
        packed.open(context, &mut budget, &mut frame).map_err(|error| error.at(format!("section {number}")))?;
    }
    frame.particles.check()?;
    Ok(frame)
}

impl Packed<'_> {
    fn chunk(&self, number: usize) -> Result<Vec<u8>> {
        self.entry.unpack(number, self.chunks[number])
    }

    /// Adds what is in it to the frame.
    fn open(self, context: &Context, budget: &mut Budget, frame: &mut Frame) -> Result<()> {
        let mut repeated = false;
        match self.entry.kind {
            STATE => {
                let mut state = Vec::new();
                budget.reserve(&mut state, self.entry.items)?;
                for number in 0..self.chunks.len() {
                    state.extend(self.chunk(number)?);
                }
                repeated = frame.state.replace(state).is_some();
            }
            NUMBERS => repeated = frame.particles.numbers.replace(self.words(context, budget, |word| word)?).is_some(),
            CHANNEL => {
                let values = self.words(context, budget, f32::from_bits)?;
                let (name, width) = (self.entry.name, self.entry.width as u32);
                frame.particles.channels.push(Channel { name, width, values });
            }
            _ => {
                let values = self.words(context, budget, f32::from_bits)?;
                budget.reserve(&mut frame.particles.points, self.entry.items)?;
                frame.particles.points.extend_from_slice(values.as_chunks().0);
            }
        }
        if repeated { Err(damaged("it is there twice")) } else { Ok(()) }
    }

    /// The numbers of all chunks.
    fn words<T>(&self, context: &Context, budget: &mut Budget, number: impl Fn(u32) -> T) -> Result<Vec<T>> {
        let mut all = Vec::new();
        budget.reserve(&mut all, self.entry.width * self.entry.items)?;
        let some = 4 * context.threads();
        // What is unpacked at a time is little beside all.
        for first in (0..self.chunks.len()).step_by(some) {
            for chunk in context.map(some.min(self.chunks.len() - first), |at| self.chunk(first + at)) {
                let bytes = chunk?;
                all.extend((0..bytes.len() / 4).map(|at| number(word(&bytes, at))));
            }
        }
        Ok(all)
    }
}

/// A frame of a cache in a file, read chunk by chunk: in memory are its index and what is asked for.
#[derive(Debug)]
pub struct FrameStream {
    file: File,
    path: PathBuf,
    index: Index,
    /// Bytes of the file before the chunks.
    behind: u64,
}

impl FrameStream {
    /// Opens a frame.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file does not exist or cannot be read, with `Invalid` if it is damaged,
    /// with `Unsupported` if it is of a newer version, and with `Memory` if its index does not fit the memory limit.
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let failed = |error: std::io::Error| Error::io(path, &error);
        let mut file = file::open(path)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut head = Vec::new();
        (&mut file).take(HEADER as u64).read_to_end(&mut head).map_err(failed)?;
        let header = Header::read(&head).map_err(named)?;
        let behind = (HEADER as u64).saturating_add(header.index_bytes);
        if behind.checked_add(header.chunk_bytes) != Some(length) {
            return Err(named(damaged("it is not as long as it says")));
        }
        Budget::new(context.memory_limit()).charge(header.index_bytes + header.index_length).map_err(named)?;
        let mut packed = Vec::new();
        (&mut file).take(header.index_bytes).read_to_end(&mut packed).map_err(failed)?;
        let index = Index::read(&packed, &header).map_err(named)?;
        Ok(Self { file, path: path.to_owned(), index, behind })
    }

    /// Returns the number of particles.
    pub fn count(&self) -> usize {
        self.index.count
    }

    /// Returns the distance between particles at rest in metres, where it is known.
    pub fn spacing(&self) -> Option<f32> {
        self.index.spacing
    }

    /// Returns the number of chunks.
    pub fn chunks(&self) -> usize {
        self.index.count.div_ceil(CHUNK)
    }

    /// Returns the particles of a chunk with their numbers and the channels of these names, where the frame has them.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such chunk or it is damaged, and with `Io` if the file cannot be read.
    pub fn read(&mut self, chunk: usize, channels: &[&str]) -> Result<Particles> {
        let named = |error: Error| error.at(self.path.display().to_string());
        if chunk >= self.chunks() {
            return Err(named(Error::invalid(format!("there is no chunk {chunk}"))));
        }
        let Index { time, spacing, .. } = self.index;
        let mut particles = Particles { time, spacing, ..Particles::default() };
        for entry in &self.index.entries {
            let is_wanted = entry.kind != STATE && (entry.kind != CHANNEL || channels.contains(&entry.name.as_str()));
            if !is_wanted {
                continue;
            }
            let slot = entry.slots[chunk];
            // A chunk that does not shrink grows by little, so one that is much longer is none.
            let length = 4 * entry.width * CHUNK;
            if slot.length as usize > length + length / 64 + 1024 {
                return Err(named(damaged("a chunk is too long")));
            }
            let failed = |error: std::io::Error| Error::io(&self.path, &error);
            self.file.seek(SeekFrom::Start(self.behind + slot.start)).map_err(failed)?;
            let mut packed = vec![0; slot.length as usize];
            self.file.read_exact(&mut packed).map_err(failed)?;
            let bytes = entry.unpack(chunk, &packed).map_err(named)?;
            let words = (0..bytes.len() / 4).map(|at| word(&bytes, at));
            let floats = |words: &mut dyn Iterator<Item = u32>| words.map(f32::from_bits).collect::<Vec<_>>();
            match entry.kind {
                PLACES => particles.points = floats(&mut { words }).as_chunks().0.to_vec(),
                NUMBERS => particles.numbers = Some(words.collect()),
                _ => particles.channels.push(Channel {
                    name: entry.name.clone(),
                    width: entry.width as u32,
                    values: floats(&mut { words }),
                }),
            }
        }
        particles.check().map_err(named)?;
        Ok(particles)
    }
}

fn text(index: &mut Bytes) -> Result<String> {
    let [length] = index.array()?;
    let bytes = index.take(length.into())?;
    String::from_utf8(bytes.to_vec()).map_err(|_| damaged("a text is not UTF-8"))
}

fn unpack(packed: &[u8], length: usize) -> Result<Vec<u8>> {
    let unpacked = zstd::bulk::decompress(packed, length).map_err(|_| damaged("a part of it cannot be unpacked"))?;
    if unpacked.len() == length { Ok(unpacked) } else { Err(damaged("a part of it is too short")) }
}

fn damaged(what: &str) -> Error {
    Error::invalid(format!("the frame is damaged: {what}")).advise("delete it and simulate again from the frame before")
}
