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

use std::path::Path;

use relievo_core::{Budget, Context, Error, Result, file};

use crate::bytes::Bytes;
use crate::particles::{Channel, MOST, MOST_CHANNELS, Particles};

pub(crate) const MAGIC: [u8; 8] = *b"RLVFLUID";
/// The version that is written, and the newest that is read.
pub const VERSION: u32 = 1;
/// The extension of frames of a cache, without the dot.
pub const EXTENSION: &str = "rlvfluid";
const HEADER: usize = 44;
/// Items of a chunk.
const CHUNK: usize = 1 << 16;
/// Bytes of an index at most: all channels of 2³¹ particles.
const MOST_INDEX: u64 = 1 << 26;
/// Bytes of a state at most.
const MOST_STATE: u64 = 1 << 32;
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
/// Fails, and leaves no file, if the particles are not sound, or the system refuses.
pub fn write_frame(context: &Context, path: &Path, particles: &Particles, state: Option<&[u8]>) -> Result<()> {
    let parts = parts(context, particles, state).map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| parts.iter().try_for_each(|part| std::io::Write::write_all(out, part)))
}

/// Bytes of a frame of a cache with these particles and no state. Fails if they are not sound.
pub fn frame_bytes(context: &Context, particles: &Particles) -> Result<usize> {
    Ok(parts(context, particles, None)?.iter().map(Vec::len).sum())
}

/// A frame of a cache, as it is in a file. Fails if the particles are not sound.
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

/// A section that is read: what it is, and the packed bytes of its chunks.
struct Packed<'a> {
    kind: u8,
    name: String,
    width: usize,
    items: usize,
    chunks: Vec<&'a [u8]>,
}

/// Reads a frame of a cache. The context's memory limit bounds the file and what is made of it together.
///
/// Fails where the file is damaged or of a newer version, or needs more memory than the limit.
pub fn read_frame(context: &Context, bytes: &[u8]) -> Result<Frame> {
    let mut budget = Budget::new(context.memory_limit().saturating_sub(bytes.len() as u64));
    let mut file = Bytes(bytes);
    if file.array()? != MAGIC {
        return Err(
            Error::invalid("the file does not begin with `RLVFLUID`").advise("check that it is a frame of a cache")
        );
    }
    let version = u32::from_le_bytes(file.array()?);
    if version == 0 || version > VERSION {
        return Err(Error::unsupported(format!("it is of version {version}, and versions up to {VERSION} are known"))
            .advise("take a newer Relievo"));
    }
    let index_sum = u32::from_le_bytes(file.array()?);
    let mut length = || file.array().map(u64::from_le_bytes);
    let [index_bytes, index_length, chunk_bytes] = [length()?, length()?, length()?];
    if u32::from_le_bytes(file.array()?) != crc32fast::hash(&bytes[..HEADER - 4]) {
        return Err(damaged("the checksum of its header is wrong"));
    }
    let packed = file.take(index_bytes)?;
    if file.0.len() as u64 != chunk_bytes || index_length > MOST_INDEX {
        return Err(damaged("it is not as long as it says"));
    }
    if crc32fast::hash(packed) != index_sum {
        return Err(damaged("the checksum of its index is wrong"));
    }
    budget.charge(index_length)?;
    let index = unpack(packed, index_length as usize)?;
    let mut index = Bytes(&index);
    let time = f64::from_le_bytes(index.array()?);
    let spacing = f32::from_le_bytes(index.array()?);
    let level = text(&mut index)?;
    let count = u32::from_le_bytes(index.array()?) as usize;
    let sections = u32::from_le_bytes(index.array()?) as usize;
    if count as u64 > MOST || sections > MOST_CHANNELS + 3 {
        return Err(damaged("it has too many particles or sections"));
    }
    let mut frame = Frame { level, ..Frame::default() };
    frame.particles.time = (!time.is_nan()).then_some(time);
    frame.particles.spacing = (spacing != 0.0).then_some(spacing);
    for number in 0..sections {
        let section = Packed::read(&mut index, &mut file, count)?;
        if (section.kind == PLACES) != (number == 0) {
            return Err(damaged("its first section, and no other, is that of the places"));
        }
        section.open(context, &mut budget, &mut frame).map_err(|error| error.at(format!("section {number}")))?;
    }
    if sections == 0 || !file.0.is_empty() || !index.0.is_empty() {
        return Err(damaged("its sections are not as long as it says"));
    }
    frame.particles.check()?;
    Ok(frame)
}

impl<'a> Packed<'a> {
    fn read(index: &mut Bytes, file: &mut Bytes<'a>, count: usize) -> Result<Self> {
        let [kind] = index.array()?;
        let name = text(index)?;
        let [width] = index.array()?;
        let items = u64::from_le_bytes(index.array()?);
        let fits = match kind {
            PLACES => width == 3 && items == count as u64,
            NUMBERS => width == 1 && items == count as u64,
            CHANNEL => (1..=4).contains(&width) && items == count as u64,
            STATE => width == 1 && items <= MOST_STATE,
            _ => return Err(damaged("a section is of an unknown kind")),
        };
        let chunks = items.div_ceil(CHUNK as u64);
        if !fits || chunks.saturating_mul(8) > index.0.len() as u64 {
            return Err(damaged("a section has a size that cannot be"));
        }
        let mut chunk = || {
            let [length, sum] = [index.array()?, index.array()?].map(u32::from_le_bytes);
            let packed = file.take(length.into())?;
            match crc32fast::hash(packed) == sum {
                true => Ok(packed),
                false => Err(damaged("the checksum of a chunk is wrong")),
            }
        };
        let chunks = (0..chunks).map(|_| chunk()).collect::<Result<_>>()?;
        Ok(Self { kind, name, width: width.into(), items: items as usize, chunks })
    }

    /// Unpacks a chunk.
    fn chunk(&self, number: usize) -> Result<Vec<u8>> {
        let items = CHUNK.min(self.items - number * CHUNK);
        let length = if self.kind == STATE { items } else { 4 * self.width * items };
        unpack(self.chunks[number], length)
    }

    /// Adds what is in it to the frame.
    fn open(self, context: &Context, budget: &mut Budget, frame: &mut Frame) -> Result<()> {
        let mut repeated = false;
        match self.kind {
            STATE => {
                let mut state = Vec::new();
                budget.reserve(&mut state, self.items)?;
                for number in 0..self.chunks.len() {
                    state.extend(self.chunk(number)?);
                }
                repeated = frame.state.replace(state).is_some();
            }
            NUMBERS => repeated = frame.particles.numbers.replace(self.words(context, budget, |word| word)?).is_some(),
            CHANNEL => {
                let values = self.words(context, budget, f32::from_bits)?;
                frame.particles.channels.push(Channel { name: self.name, width: self.width as u32, values });
            }
            _ => {
                let values = self.words(context, budget, f32::from_bits)?;
                budget.reserve(&mut frame.particles.points, self.items)?;
                frame.particles.points.extend_from_slice(values.as_chunks().0);
            }
        }
        if repeated { Err(damaged("it is there twice")) } else { Ok(()) }
    }

    /// The numbers of all chunks.
    fn words<T>(&self, context: &Context, budget: &mut Budget, number: impl Fn(u32) -> T) -> Result<Vec<T>> {
        let mut all = Vec::new();
        budget.reserve(&mut all, self.width * self.items)?;
        let some = 4 * context.threads();
        // What is unpacked at a time is little beside all.
        for first in (0..self.chunks.len()).step_by(some) {
            for chunk in context.map(some.min(self.chunks.len() - first), |at| self.chunk(first + at)) {
                let bytes = chunk?;
                let count = bytes.len() / 4;
                let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|plane| bytes[plane * count + at]));
                all.extend((0..count).map(|at| number(word(at))));
            }
        }
        Ok(all)
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
