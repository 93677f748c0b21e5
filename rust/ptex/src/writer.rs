//! Writes Ptex files: faces in any order, compressed as they come, reductions down to four texels along the shorter
//! side, and the rest when all are there.

use std::io::Write;
use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Budget, Context, Error, Progress, Result, file};

use crate::block::{BlockHeader, constant, deflate, encode};
use crate::face::{CONSTANT, Face, Record};
use crate::format::{Borders, Format, Resolution};
use crate::header::{ExtendedHeader, Header};
use crate::meta::{self, MetaData, MetaValue};
use crate::neighborhood;
use crate::reader::{BARRIER, ranks};
use crate::reduction::{halve, mean, premultiply};

/// log2 of the texels along the shorter side of the smallest reduction.
const SMALLEST: u8 = 2;

/// What was written of a face.
#[derive(Clone, Debug)]
struct Entry {
    record: Record,
    /// The mean of the texels.
    value: Vec<u8>,
    /// Size, encoding and bytes of the full texels and of every reduction.
    blocks: Vec<(BlockHeader, Vec<u8>)>,
}

impl Entry {
    fn constant(face: &Face, value: &[u8]) -> Self {
        Self { record: Record { face: *face, flags: CONSTANT }, value: value.to_vec(), blocks: Vec::new() }
    }
}

/// A Ptex file that is being made.
#[derive(Clone, Debug)]
pub struct Writer {
    format: Format,
    borders: Borders,
    entries: Vec<Option<Entry>>,
    meta: MetaData,
}

impl Writer {
    /// A file of `faces` faces, which are all to be given.
    ///
    /// # Errors
    /// Fails as [`Format::check`] does.
    pub fn new(format: Format, borders: Borders, faces: u32) -> Result<Self> {
        format.check()?;
        Ok(Self { format, borders, entries: vec![None; faces as usize], meta: MetaData::new() })
    }

    /// Gives a face its texels: little-endian numbers of the format's type, channels together, the row v = 0 first,
    /// colours not multiplied by alpha. A face whose texels are all the same bit by bit is stored as a constant.
    ///
    /// # Errors
    /// Fails with `Invalid`, and leaves the face as it was, if it does not exist, names neighbours that do not, or has
    /// other than as many bytes as its resolution takes, and as [`Resolution::check`] does.
    pub fn set(&mut self, index: u32, face: &Face, texels: &[u8]) -> Result<()> {
        let entry = self.encode(index, face, texels).map_err(|error| error.at(format!("face {index}")))?;
        self.put(index, entry);
        Ok(())
    }

    /// Gives every face what `face` makes of its number, on the threads of the context: a face and its texels, as for
    /// [`Writer::set`].
    ///
    /// # Errors
    /// Returns the error of `face` or of [`Writer::set`] at the first face that has one, and leaves all faces as they
    /// were.
    pub fn set_all(&mut self, context: &Context, face: impl Fn(u32) -> Result<(Face, Vec<u8>)> + Sync) -> Result<()> {
        self.set_all_watched(context, &mut Silent, face)
    }

    /// As [`Writer::set_all`], telling `progress`.
    ///
    /// # Errors
    /// Fails as [`Writer::set_all`] does, and with `Cancelled` if `progress` asks to stop.
    pub fn set_all_watched(
        &mut self,
        context: &Context,
        progress: &mut dyn Progress,
        face: impl Fn(u32) -> Result<(Face, Vec<u8>)> + Sync,
    ) -> Result<()> {
        let entries = context.map_watched(self.entries.len(), progress, ("ptex.write", [0.0, 1.0]), |index| {
            let index = index as u32;
            let entry = face(index).and_then(|(face, texels)| self.encode(index, &face, &texels));
            entry.map_err(|error| error.at(format!("face {index}")))
        })?;
        let entries = entries.into_iter().collect::<Result<Vec<_>>>()?;
        (0u32..).zip(entries).for_each(|(index, entry)| self.put(index, entry));
        Ok(())
    }

    /// Gives all texels of a face one value, as [`Writer::set`] does.
    ///
    /// # Errors
    /// Fails with `Invalid` if the face or a neighbour does not exist, or `value` is not as long as a texel.
    pub fn set_constant(&mut self, index: u32, face: &Face, value: &[u8]) -> Result<()> {
        let named = |error: Error| error.at(format!("face {index}"));
        self.check(index, face, self.format.texel_size() as u64, value.len()).map_err(named)?;
        self.put(index, Entry::constant(face, value));
        Ok(())
    }

    /// Stores meta data. Keys that begin with `Ptex` are those of the format's own list.
    pub fn set_meta(&mut self, key: impl Into<String>, value: MetaValue) {
        self.meta.insert(key.into(), value);
    }

    fn check(&self, index: u32, face: &Face, expected: u64, bytes: usize) -> Result<()> {
        if index as usize >= self.entries.len() {
            return Err(
                Error::invalid(format!("the file has {} faces", self.entries.len())).advise("number them from 0")
            );
        }
        face.check(self.format.mesh, self.entries.len() as u32)?;
        if bytes as u64 != expected {
            return Err(Error::invalid(format!("its texels take {expected} bytes, but there are {bytes}"))
                .advise("give every texel of its resolution once"));
        }
        Ok(())
    }

    fn encode(&self, index: u32, face: &Face, texels: &[u8]) -> Result<Entry> {
        let (format, resolution) = (&self.format, face.resolution);
        resolution.check(format.mesh)?;
        self.check(index, face, resolution.texels() * format.texel_size() as u64, texels.len())?;
        if let Some(value) = constant(std::iter::once(texels), format.texel_size()) {
            return Ok(Entry::constant(face, value));
        }
        let mut blocks = vec![encode(texels, format, resolution)?];
        let mut multiplied;
        let mut premultiplied = texels;
        if format.alpha.is_some() {
            multiplied = texels.to_vec();
            premultiply(&mut multiplied, format);
            premultiplied = &multiplied;
        }
        let value = mean(premultiplied, format);
        let smaller = |texels: &[u8], resolution: Resolution| {
            (resolution.least() > SMALLEST).then(|| halve(texels, format, resolution)).flatten()
        };
        let mut reduction = smaller(premultiplied, resolution);
        while let Some((resolution, texels)) = reduction {
            blocks.push(encode(&texels, format, resolution)?);
            reduction = smaller(&texels, resolution);
        }
        Ok(Entry { record: Record { face: *face, flags: 0 }, value, blocks })
    }

    fn put(&mut self, index: u32, entry: Entry) {
        self.entries[index as usize] = Some(entry);
    }

    /// Writes the file to `path`. It appears under its name when it is complete.
    ///
    /// # Errors
    /// Fails as [`Self::bytes`] does, and with `NotFound` or `Io` if the system refuses.
    pub fn write(&self, path: &Path) -> Result<()> {
        let parts = self.parts().map_err(|error| error.at(path.display().to_string()))?;
        file::store(path, |out| parts.pieces().try_for_each(|piece| out.write_all(piece)))
    }

    /// The bytes of the file: the same for the same faces and meta data, in whatever order they were given.
    ///
    /// # Errors
    /// Fails with `Invalid` if a face was not given, and with `Unsupported` if a part exceeds the 4 GiB of the format.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        Ok(self.parts()?.pieces().collect::<Vec<_>>().concat())
    }

    /// All that is in front of the texels and behind them.
    fn parts(&self) -> Result<Parts<'_>> {
        let missing = self.entries.iter().position(Option::is_none);
        if let Some(face) = missing {
            return Err(Error::invalid("its texels are missing").at(format!("face {face}")).advise("give every face"));
        }
        let entries: Vec<&Entry> = self.entries.iter().flatten().collect();
        let mut records: Vec<Record> = entries.iter().map(|entry| entry.record).collect();
        let value = |face: u32| entries[face as usize].value.as_slice();
        neighborhood::flag(&mut records, self.format.mesh, self.borders, value);

        let mut face_info = Vec::new();
        records.iter().for_each(|record| record.write(&mut face_info));
        let face_info = deflate(&face_info)?;
        let constants = deflate(&entries.iter().flat_map(|entry| &entry.value).copied().collect::<Vec<u8>>())?;
        let levels = levels(&entries, &records)?;
        let level_info: Vec<u8> = levels.iter().flat_map(Level::info).collect();
        let level_data = levels.iter().map(Level::size).sum();
        let meta = meta::write(&self.meta)?;
        let size = |bytes: &[u8], what: &str| {
            u32::try_from(bytes.len())
                .map_err(|_| Error::unsupported(format!("{what} take more than 4 GiB")).advise("use fewer"))
        };
        let header = Header {
            format: self.format,
            levels: levels.len() as u16,
            faces: entries.len() as u32,
            extended: ExtendedHeader::SIZE as u32,
            face_info: size(&face_info, "faces")?,
            constants: size(&constants, "constants of faces")?,
            level_info: size(&level_info, "levels")?,
            level_data,
            meta_zipped: size(&meta.small.0, "meta data")?,
            meta: meta.small.1,
        };
        let before = Header::SIZE + ExtendedHeader::SIZE + face_info.len() + constants.len() + level_info.len();
        let behind = meta.small.0.len() + BARRIER as usize + meta.large.0.len() + meta.values.len();
        let extended = ExtendedHeader {
            borders: self.borders,
            large_zipped: size(&meta.large.0, "names of large meta data")?,
            large: meta.large.1,
            large_data: meta.values.len() as u64,
            edits: 0,
            edits_at: (before + behind) as u64 + level_data,
        };
        let mut front = Vec::with_capacity(before);
        header.write(&mut front);
        extended.write(&mut front);
        front.extend(face_info);
        front.extend(constants);
        front.extend(level_info);
        let mut back = meta.small.0;
        back.extend([0; BARRIER as usize]);
        back.extend(meta.large.0);
        back.extend(meta.values);
        Ok(Parts { front, levels, back })
    }
}

/// A file in the order of its bytes.
struct Parts<'a> {
    front: Vec<u8>,
    levels: Vec<Level<'a>>,
    back: Vec<u8>,
}

impl Parts<'_> {
    fn pieces(&self) -> impl Iterator<Item = &[u8]> {
        let levels = self.levels.iter().flat_map(Level::pieces);
        std::iter::once(self.front.as_slice()).chain(levels).chain([self.back.as_slice()])
    }
}

/// The texels of faces in one resolution.
struct Level<'a> {
    /// Sizes and encodings of the blocks, compressed.
    headers: Vec<u8>,
    /// What is stored of every face in the level; nothing of constant ones.
    blocks: Vec<Option<&'a (BlockHeader, Vec<u8>)>>,
}

impl<'a> Level<'a> {
    fn new(blocks: Vec<Option<&'a (BlockHeader, Vec<u8>)>>) -> Result<Self> {
        let header = |block: &Option<&(BlockHeader, Vec<u8>)>| block.map_or(0, |(header, _)| header.0).to_le_bytes();
        Ok(Self { headers: deflate(&blocks.iter().flat_map(header).collect::<Vec<u8>>())?, blocks })
    }

    fn pieces(&self) -> impl Iterator<Item = &[u8]> {
        let blocks = self.blocks.iter().flatten().map(|(_, bytes)| bytes.as_slice());
        std::iter::once(self.headers.as_slice()).chain(blocks)
    }

    /// Bytes in the file.
    fn size(&self) -> u64 {
        self.pieces().map(|piece| piece.len() as u64).sum()
    }

    /// Its description in the list of levels.
    fn info(&self) -> Vec<u8> {
        let mut info = self.size().to_le_bytes().to_vec();
        info.extend((self.headers.len() as u32).to_le_bytes());
        info.extend((self.blocks.len() as u32).to_le_bytes());
        info
    }
}

/// All levels: the full one in the order of faces, reductions with larger faces first.
fn levels<'a>(entries: &[&'a Entry], records: &[Record]) -> Result<Vec<Level<'a>>> {
    let ranks = ranks(records, &mut Budget::new(u64::MAX))?;
    let mut ordered = vec![0; ranks.len()];
    for (face, rank) in ranks.iter().enumerate() {
        ordered[*rank as usize] = face;
    }
    let mut levels = vec![Level::new(entries.iter().map(|entry| entry.blocks.first()).collect())?];
    loop {
        // The faces that have a block in this level are the first, since larger ones have more.
        let blocks = ordered.iter().map(|face| entries[*face].blocks.get(levels.len()));
        let blocks: Vec<_> = blocks.take_while(Option::is_some).collect();
        if blocks.is_empty() {
            return Ok(levels);
        }
        levels.push(Level::new(blocks)?);
    }
}
