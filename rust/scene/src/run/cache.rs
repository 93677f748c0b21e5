//! The cache of baked frames: what every frame changed, compressed, with an index from which any frame opens without
//! replay.
//!
//! Imprints depend on history, so a frame is more than its poses. Each frame has one file with the blocks (tiles) it
//! changed and an index of the latest version of every block there is: the file that holds it, where, and its
//! checksum. Opening a frame reads its index and then just those blocks. A frame's file is written under a temporary
//! name and renamed, so it is whole or absent. Files say the scene they belong to by a hash and the instruction level
//! they were made at, since levels differ in the last bit.
//!
//! File, little-endian: [`Header`], index (zstd), blocks (zstd each). Readers believe nothing: lengths are checked
//! against the file and a memory limit before anything is allocated, and all parts carry CRC-32.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::{Context, Error, Result};

const MAGIC: [u8; 8] = *b"RLVCACHE";
const VERSION: u32 = 3;
const EXTENSION: &str = "rlvcache";
/// No block is larger: a tile of 256² coefficients with ring and mips takes less.
const MAX_BLOCK: u64 = 1 << 22;
/// No index is larger: forty million tiles.
const MAX_INDEX: u64 = 1 << 31;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: u32,
    level: u32,
    scene: u64,
    frame: u32,
    objects: u32,
    entries: u64,
    index_length: u64,
    blocks_length: u64,
    index_crc: u32,
    /// Of everything above.
    header_crc: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Entry {
    object: u32,
    /// The [`Layer`].
    layer: u32,
    tile: u32,
    /// The frame whose file holds the block.
    frame: u32,
    crc: u32,
    padding: u32,
    /// Bytes from the start of that file's blocks.
    offset: u64,
    length: u32,
    raw_length: u32,
}

const HEADER: usize = size_of::<Header>();
const POSE: usize = 12 * size_of::<f64>();

/// Which bake a cache belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Hash of everything that decides the imprints.
    pub scene: u64,
    /// Instruction level and whether a graphics device computes, as a number.
    pub level: u32,
}

/// What a tile is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Layer {
    /// The displacement of an object.
    Displacement = 0,
    /// The colours painted on it.
    Paint = 1,
    /// The traces that imprints left.
    Traces = 2,
    /// When which displacement was edited last.
    DisplacementStamps = 3,
    /// When which colours were edited last.
    PaintStamps = 4,
    /// The vector displacement of an object.
    Vectors = 5,
    /// The sizes of the faces of a layer, where edits at other levels changed them; the layer's number is the tile's.
    Sizes = 16,
}

impl Layer {
    const ALL: [Self; 7] = [
        Layer::Displacement,
        Layer::Paint,
        Layer::Traces,
        Layer::DisplacementStamps,
        Layer::PaintStamps,
        Layer::Vectors,
        Layer::Sizes,
    ];

    fn of(number: u32) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|layer| *layer as u32 == number)
            .ok_or_else(|| damaged("a tile belongs to an unknown layer"))
    }
}

/// Which block: object, layer, tile.
pub type Key = (u32, Layer, u32);

/// The state of one tile of one object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Index of the object in the scene.
    pub object: u32,
    /// What of the object.
    pub layer: Layer,
    /// The tile.
    pub tile: u32,
    /// What the owner of the tile wrote; empty for a tile that was given back.
    pub bytes: Vec<u8>,
}

/// Whether a frame can be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It is there.
    Baked,
    /// It was baked from another scene, or at another instruction level or on another device.
    Stale,
    /// It is not there, or damaged.
    Absent,
}

/// A folder of baked frames.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    identity: Identity,
}

/// A baked frame.
#[derive(Clone, Debug)]
pub struct Frame {
    folder: PathBuf,
    /// The frame.
    pub number: u32,
    /// Transforms of all objects.
    pub transforms: Vec<DAffine3>,
    index: BTreeMap<Key, Entry>,
}

impl Cache {
    /// The cache in `folder`, which is made if it is missing.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the folder cannot be made.
    pub fn new(folder: &Path, identity: Identity) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
        Ok(Self { folder: folder.to_path_buf(), identity })
    }

    fn path(folder: &Path, frame: u32) -> PathBuf {
        folder.join(format!("frame-{frame:06}.{EXTENSION}"))
    }

    /// Whether `frame` can be opened, from its header alone.
    pub fn state(&self, frame: u32) -> State {
        let header = File::open(Self::path(&self.folder, frame))
            .map_err(|_| ())
            .and_then(|mut file| read_header(&mut file, frame).map_err(|_| ()));
        match header {
            Ok(header) if header.scene == self.identity.scene && header.level == self.identity.level => State::Baked,
            Ok(_) => State::Stale,
            Err(()) => State::Absent,
        }
    }

    /// Takes the frames `first` to `last` as they are if all were baked from its scene by the same instruction level and
    /// device, whichever that was.
    pub fn adopt(&mut self, first: u32, last: u32) {
        let header = |frame: u32| read_header(&mut File::open(Self::path(&self.folder, frame)).ok()?, frame).ok();
        let Some(level) = header(first).map(|header| header.level) else { return };
        let scene = self.identity.scene;
        if (first..=last).all(|it| header(it).is_some_and(|header| (header.scene, header.level) == (scene, level))) {
            self.identity.level = level;
        }
    }

    /// Removes all frames from `first` on, as a new bake makes them worthless.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the folder cannot be read or a file cannot be removed; others may be removed
    /// then.
    pub fn truncate(&self, first: u32) -> Result<()> {
        let entries = std::fs::read_dir(&self.folder).map_err(|error| Error::io(&self.folder, &error))?;
        for entry in entries {
            let path = entry.map_err(|error| Error::io(&self.folder, &error))?.path();
            let number = path.file_name().and_then(|name| name.to_str()).and_then(|name| {
                name.strip_prefix("frame-")?.strip_suffix(EXTENSION)?.strip_suffix('.')?.parse::<u32>().ok()
            });
            if number.is_some_and(|number| number >= first) {
                std::fs::remove_file(&path).map_err(|error| Error::io(&path, &error))?;
            }
        }
        Ok(())
    }

    /// Writes `frame`: `changed` blocks are stored, all others are where `before` has them.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be written, and with `Internal` if a block has more than 4 MiB.
    pub fn write(
        &self,
        context: &Context,
        frame: u32,
        transforms: &[DAffine3],
        before: Option<&Frame>,
        changed: &[Block],
    ) -> Result<Frame> {
        let path = Self::path(&self.folder, frame);
        let packed = context.map(changed.len(), |at| zstd::bulk::compress(&changed[at].bytes, 1));
        let mut index = before.map_or_else(BTreeMap::new, |before| before.index.clone());
        let mut blocks = Vec::new();
        for (block, packed) in changed.iter().zip(packed) {
            if block.bytes.is_empty() {
                index.remove(&(block.object, block.layer, block.tile));
                continue;
            }
            let packed = packed.map_err(|error| Error::io(&path, &error))?;
            if block.bytes.len() as u64 > MAX_BLOCK || packed.len() as u64 > u64::from(u32::MAX) {
                return Err(Error::internal(format!("a tile of {} bytes does not fit the cache", block.bytes.len())));
            }
            let entry = Entry {
                object: block.object,
                layer: block.layer as u32,
                tile: block.tile,
                frame,
                crc: crc32fast::hash(&packed),
                padding: 0,
                offset: blocks.len() as u64,
                length: packed.len() as u32,
                raw_length: block.bytes.len() as u32,
            };
            blocks.extend_from_slice(&packed);
            index.insert((block.object, block.layer, block.tile), entry);
        }
        let mut raw = Vec::with_capacity(transforms.len() * POSE + index.len() * size_of::<Entry>());
        for transform in transforms {
            raw.extend_from_slice(bytemuck::bytes_of(&transform.to_cols_array()));
        }
        for entry in index.values() {
            raw.extend_from_slice(bytemuck::bytes_of(entry));
        }
        let packed = zstd::bulk::compress(&raw, 1).map_err(|error| Error::io(&path, &error))?;
        let mut header = Header {
            magic: MAGIC,
            version: VERSION,
            level: self.identity.level,
            scene: self.identity.scene,
            frame,
            objects: transforms.len() as u32,
            entries: index.len() as u64,
            index_length: packed.len() as u64,
            blocks_length: blocks.len() as u64,
            index_crc: crc32fast::hash(&packed),
            header_crc: 0,
        };
        header.header_crc = header_crc(&header);
        relievo_core::file::store(&path, |file| {
            file.write_all(bytemuck::bytes_of(&header))?;
            file.write_all(&packed)?;
            file.write_all(&blocks)
        })?;
        Ok(Frame { folder: self.folder.clone(), number: frame, transforms: transforms.to_vec(), index })
    }

    /// Opens `frame`.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if it is missing or cannot be read, with `Invalid` if it is damaged or stale, with
    /// `Unsupported` if its file has another version, and with `Memory` if its index exceeds the context's memory
    /// limit.
    pub fn open(&self, context: &Context, frame: u32) -> Result<Frame> {
        let path = Self::path(&self.folder, frame);
        let open = || -> Result<Frame> {
            let mut file = File::open(&path).map_err(|error| Error::io(&path, &error))?;
            let header = read_header(&mut file, frame)?;
            if header.scene != self.identity.scene {
                return Err(Error::invalid("the frame was baked from another version of the scene")
                    .advise("bake again from frame 0"));
            }
            if header.level != self.identity.level {
                return Err(Error::invalid("the frame was baked at another instruction level or on another device")
                    .advise("set RELIEVO_SIMD as it was, or bake again from frame 0"));
            }
            let poses = u64::from(header.objects) * POSE as u64;
            let raw_length = header
                .entries
                .checked_mul(size_of::<Entry>() as u64)
                .and_then(|bytes| bytes.checked_add(poses))
                .filter(|bytes| *bytes <= MAX_INDEX)
                .ok_or_else(|| damaged("its index claims an impossible size"))?;
            if raw_length > context.memory_limit() {
                return Err(Error::memory("its index exceeds the memory limit").advise("raise --memory-limit"));
            }
            let packed = read_exactly(&mut file, header.index_length)?;
            if crc32fast::hash(&packed) != header.index_crc {
                return Err(damaged("the checksum of its index is wrong"));
            }
            let raw = unpack(&packed, raw_length)?;
            let (poses, entries) = raw.split_at(poses as usize);
            let transforms = poses
                .chunks_exact(POSE)
                .map(|pose| DAffine3::from_cols_array(&bytemuck::pod_read_unaligned(pose)))
                .collect();
            let index = entries
                .chunks_exact(size_of::<Entry>())
                .map(bytemuck::pod_read_unaligned::<Entry>)
                .map(|entry| Ok(((entry.object, Layer::of(entry.layer)?, entry.tile), entry)))
                .collect::<Result<_>>()?;
            Ok(Frame { folder: self.folder.clone(), number: frame, transforms, index })
        };
        open().map_err(|error| error.at(path.display().to_string()))
    }
}

impl Frame {
    /// Which blocks there are, in order.
    pub fn blocks(&self) -> impl Iterator<Item = Key> + '_ {
        self.index.keys().copied()
    }

    /// Reads all blocks, in order.
    ///
    /// # Errors
    /// Fails as [`Self::read_since`].
    pub fn read(&self, context: &Context) -> Result<Vec<Block>> {
        self.read_since(context, None)
    }

    /// Reads the blocks that are not as in the frame `since`, in order. Blocks that are gone are empty.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a file of this or an earlier frame cannot be read, with `Invalid` if it is
    /// damaged, with `Unsupported` if it has another version, and with `Memory` if the blocks exceed the context's
    /// memory limit.
    pub fn read_since(&self, context: &Context, since: Option<&Frame>) -> Result<Vec<Block>> {
        let before = |key: &Key| since.and_then(|frame| frame.index.get(key));
        let same = |entry: &Entry, other: &Entry| entry.frame == other.frame && entry.offset == other.offset;
        let mut files: BTreeMap<u32, Vec<Entry>> = BTreeMap::new();
        let mut total = 0_u64;
        for (key, entry) in &self.index {
            if before(key).is_some_and(|other| same(entry, other)) {
                continue;
            }
            files.entry(entry.frame).or_default().push(*entry);
            total = total.saturating_add(u64::from(entry.raw_length));
        }
        if total > context.memory_limit() {
            return Err(Error::memory(format!("the tiles of frame {} take {total} bytes", self.number))
                .advise("raise --memory-limit"));
        }
        let files: Vec<(u32, Vec<Entry>)> = files.into_iter().collect();
        let read = context.map(files.len(), |at| {
            let (frame, entries) = &files[at];
            let path = Cache::path(&self.folder, *frame);
            read_blocks(&path, *frame, entries).map_err(|error| error.at(path.display().to_string()))
        });
        let mut blocks = Vec::with_capacity(self.index.len());
        for list in read {
            blocks.extend(list?);
        }
        let gone = since.into_iter().flat_map(Frame::blocks).filter(|key| !self.index.contains_key(key));
        blocks.extend(gone.map(|(object, layer, tile)| Block { object, layer, tile, bytes: Vec::new() }));
        blocks.sort_by_key(|block| (block.object, block.layer, block.tile));
        Ok(blocks)
    }
}

fn damaged(what: &str) -> Error {
    Error::invalid(format!("the cached frame is damaged: {what}")).advise("delete it and bake again")
}

fn header_crc(header: &Header) -> u32 {
    let bytes = bytemuck::bytes_of(header);
    crc32fast::hash(&bytes[..HEADER - size_of::<u32>()])
}

fn read_header(file: &mut File, frame: u32) -> Result<Header> {
    let mut bytes = [0; HEADER];
    file.read_exact(&mut bytes).map_err(|_| damaged("it ends in its header"))?;
    let header: Header = bytemuck::pod_read_unaligned(&bytes);
    if header.magic != MAGIC {
        return Err(damaged("it does not begin as a cached frame does"));
    }
    if header.version != VERSION {
        return Err(Error::unsupported(format!("the cached frame has version {}", header.version))
            .advise(format!("bake again; this build reads version {VERSION}")));
    }
    if header.header_crc != header_crc(&header) || header.frame != frame {
        return Err(damaged("its header is wrong"));
    }
    Ok(header)
}

/// `length` bytes from where `file` is, if it is that long.
fn read_exactly(file: &mut File, length: u64) -> Result<Vec<u8>> {
    let size = file.metadata().map_or(0, |metadata| metadata.len());
    if length > size {
        return Err(damaged("it is shorter than its header says"));
    }
    let mut bytes = vec![0; length as usize];
    file.read_exact(&mut bytes).map_err(|_| damaged("it is shorter than its header says"))?;
    Ok(bytes)
}

fn unpack(packed: &[u8], length: u64) -> Result<Vec<u8>> {
    match zstd::bulk::decompress(packed, length as usize) {
        Ok(bytes) if bytes.len() as u64 == length => Ok(bytes),
        _ => Err(damaged("a part does not unpack to its size")),
    }
}

fn read_blocks(path: &Path, frame: u32, entries: &[Entry]) -> Result<Vec<Block>> {
    let mut file = File::open(path).map_err(|error| Error::io(path, &error))?;
    let header = read_header(&mut file, frame)?;
    let start = (HEADER as u64).checked_add(header.index_length).ok_or_else(|| damaged("its header is wrong"))?;
    file.seek(SeekFrom::Start(start)).map_err(|error| Error::io(path, &error))?;
    let bytes = read_exactly(&mut file, header.blocks_length)?;
    entries
        .iter()
        .map(|entry| {
            let from = usize::try_from(entry.offset).unwrap_or(usize::MAX);
            let packed = bytes
                .get(from..)
                .and_then(|rest| rest.get(..entry.length as usize))
                .ok_or_else(|| damaged("a tile lies outside it"))?;
            if crc32fast::hash(packed) != entry.crc {
                return Err(damaged("the checksum of a tile is wrong"));
            }
            if u64::from(entry.raw_length) > MAX_BLOCK {
                return Err(damaged("a tile claims an impossible size"));
            }
            let bytes = unpack(packed, u64::from(entry.raw_length))?;
            Ok(Block { object: entry.object, layer: Layer::of(entry.layer)?, tile: entry.tile, bytes })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: Identity = Identity { scene: 77, level: 1 };

    fn block(object: u32, tile: u32, value: u8) -> Block {
        Block {
            object,
            layer: Layer::Displacement,
            tile,
            bytes: (0..5000).map(|at| value.wrapping_mul(at as u8)).collect(),
        }
    }

    fn baked(folder: &Path) -> (Context, Cache) {
        let context = Context::serial();
        let cache = Cache::new(folder, IDENTITY).unwrap();
        let pose = |x: f64| [DAffine3::from_translation(glam::DVec3::X * x), DAffine3::IDENTITY];
        let first = cache.write(&context, 0, &pose(0.0), None, &[block(0, 3, 1), block(1, 9, 2)]).unwrap();
        let second = cache.write(&context, 1, &pose(1.0), Some(&first), &[block(0, 3, 3), block(0, 7, 4)]).unwrap();
        let gone = Block { object: 0, layer: Layer::Displacement, tile: 7, bytes: Vec::new() };
        cache.write(&context, 2, &pose(2.0), Some(&second), &[gone]).unwrap();
        (context, cache)
    }

    #[test]
    fn every_frame_opens_with_the_latest_blocks_it_had() {
        let folder = tempfile::tempdir().unwrap();
        let (context, cache) = baked(folder.path());
        let read = |frame: u32| cache.open(&context, frame).unwrap().read(&context).unwrap();
        assert_eq!(read(2), [block(0, 3, 3), block(1, 9, 2)]);
        assert_eq!(read(1), [block(0, 3, 3), block(0, 7, 4), block(1, 9, 2)]);
        assert_eq!(read(0), [block(0, 3, 1), block(1, 9, 2)]);
        let (from, to) = (cache.open(&context, 1).unwrap(), cache.open(&context, 2).unwrap());
        let gone = |tile: u32| Block { object: 0, layer: Layer::Displacement, tile, bytes: Vec::new() };
        assert_eq!(to.read_since(&context, Some(&from)).unwrap(), [gone(7)]);
        assert_eq!(from.read_since(&context, Some(&to)).unwrap(), [block(0, 7, 4)]);
        assert_eq!(cache.open(&context, 2).unwrap().transforms[0].translation.x, 2.0);
        assert_eq!(cache.state(2), State::Baked);
        assert_eq!(cache.state(3), State::Absent);
        cache.truncate(1).unwrap();
        assert_eq!((cache.state(0), cache.state(1)), (State::Baked, State::Absent));
    }

    #[test]
    fn another_scene_or_level_makes_it_stale() {
        let folder = tempfile::tempdir().unwrap();
        let (context, _) = baked(folder.path());
        for identity in [Identity { scene: 78, ..IDENTITY }, Identity { level: 2, ..IDENTITY }] {
            let cache = Cache::new(folder.path(), identity).unwrap();
            assert_eq!(cache.state(1), State::Stale);
            assert!(cache.open(&context, 1).unwrap_err().to_string().contains("another"));
        }
    }

    #[test]
    fn every_damaged_byte_and_every_cut_is_an_error_never_wrong_data() {
        let folder = tempfile::tempdir().unwrap();
        let (context, cache) = baked(folder.path());
        let path = Cache::path(folder.path(), 1);
        let good = std::fs::read(&path).unwrap();
        let expected = cache.open(&context, 1).unwrap().read(&context).unwrap();
        let check = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            if let Ok(read) = cache.open(&context, 1).and_then(|frame| frame.read(&context)) {
                assert_eq!(read, expected);
            }
        };
        for at in 0..good.len() {
            let mut bytes = good.clone();
            bytes[at] ^= 0x41;
            check(&bytes);
            if at % 7 == 0 {
                check(&good[..at]);
            }
        }
        check(&[]);
    }

    #[test]
    fn a_header_that_claims_the_world_allocates_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let (context, cache) = baked(folder.path());
        let path = Cache::path(folder.path(), 1);
        let good = std::fs::read(&path).unwrap();
        type Spoil = fn(&mut Header);
        let spoils: [Spoil; 4] = [
            |header| header.entries = u64::MAX / 2,
            |header| header.index_length = u64::MAX,
            |header| header.blocks_length = u64::MAX,
            |header| header.objects = u32::MAX,
        ];
        for spoil in spoils {
            let mut header: Header = bytemuck::pod_read_unaligned(&good[..HEADER]);
            spoil(&mut header);
            header.header_crc = header_crc(&header);
            let mut bytes = good.clone();
            bytes[..HEADER].copy_from_slice(bytemuck::bytes_of(&header));
            std::fs::write(&path, bytes).unwrap();
            assert!(cache.open(&context, 1).and_then(|frame| frame.read(&context)).is_err());
        }
    }
}
