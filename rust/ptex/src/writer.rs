//! Writes Ptex files: faces in any order, compressed as they come, reductions down to four texels along the shorter
//! side, and the rest when all are there.

use std::io::Write;
use std::path::Path;

use relievo_core::{Budget, Error, Result, file};

use crate::block::{BlockHeader, constant, deflate, encode};
use crate::face::{CONSTANT, Face, Record};
use crate::format::{Borders, Format};
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
    /// Size, encoding and bytes of the full texels and of every reduction.
    blocks: Vec<(BlockHeader, Vec<u8>)>,
}

/// A Ptex file that is being made.
#[derive(Clone, Debug)]
pub struct Writer {
    format: Format,
    borders: Borders,
    entries: Vec<Option<Entry>>,
    constants: Vec<u8>,
    meta: MetaData,
}

impl Writer {
    /// A file of `faces` faces, which are all to be given. Fails if the format cannot be.
    pub fn new(format: Format, borders: Borders, faces: u32) -> Result<Self> {
        format.check()?;
        let constants = vec![0; faces as usize * format.texel_size()];
        Ok(Self { format, borders, entries: vec![None; faces as usize], constants, meta: MetaData::new() })
    }

    /// Gives a face its texels: little-endian numbers of the format's type, channels together, the row v = 0 first,
    /// colours not multiplied by alpha. A face whose texels are all the same bit by bit is stored as a constant.
    ///
    /// Fails, and leaves the face as it was, if it does not exist, names neighbours that do not, has a resolution that
    /// cannot be, or has other than as many bytes as that takes.
    pub fn set(&mut self, index: u32, face: &Face, texels: &[u8]) -> Result<()> {
        self.encode_face(index, face, texels).map_err(|error| error.at(format!("face {index}")))
    }

    /// Gives all texels of a face one value, as [`Writer::set`] does.
    pub fn set_constant(&mut self, index: u32, face: &Face, value: &[u8]) -> Result<()> {
        self.store_constant(index, face, value).map_err(|error| error.at(format!("face {index}")))
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

    fn store_constant(&mut self, index: u32, face: &Face, value: &[u8]) -> Result<()> {
        self.check(index, face, self.format.texel_size() as u64, value.len())?;
        let record = Record { face: *face, flags: CONSTANT };
        self.put(index, Entry { record, blocks: Vec::new() }, value);
        Ok(())
    }

    fn encode_face(&mut self, index: u32, face: &Face, texels: &[u8]) -> Result<()> {
        face.resolution.check(self.format.mesh)?;
        let texel = self.format.texel_size();
        self.check(index, face, face.resolution.texels() * texel as u64, texels.len())?;
        if let Some(value) = constant(std::iter::once(texels), texel) {
            return self.store_constant(index, face, value);
        }
        let mut blocks = vec![encode(texels, &self.format, face.resolution)?];
        let mut multiplied;
        let mut premultiplied = texels;
        if self.format.alpha.is_some() {
            multiplied = texels.to_vec();
            premultiply(&mut multiplied, &self.format);
            premultiplied = &multiplied;
        }
        let average = mean(premultiplied, &self.format);
        let mut smaller =
            (face.resolution.least() > SMALLEST).then(|| halve(premultiplied, &self.format, face.resolution)).flatten();
        while let Some((resolution, texels)) = smaller {
            blocks.push(encode(&texels, &self.format, resolution)?);
            smaller = (resolution.least() > SMALLEST).then(|| halve(&texels, &self.format, resolution)).flatten();
        }
        self.put(index, Entry { record: Record { face: *face, flags: 0 }, blocks }, &average);
        Ok(())
    }

    fn put(&mut self, index: u32, entry: Entry, value: &[u8]) {
        let start = index as usize * value.len();
        self.constants[start..start + value.len()].copy_from_slice(value);
        self.entries[index as usize] = Some(entry);
    }

    /// Writes the file to `path`. It appears under its name when it is complete.
    ///
    /// Fails if a face was not given, and if the system refuses.
    pub fn write(self, path: &Path) -> Result<()> {
        let bytes = self.into_bytes().map_err(|error| error.at(path.display().to_string()))?;
        file::store(path, |out| out.write_all(&bytes))
    }

    /// The bytes of the file: the same for the same faces and meta data, in whatever order they were given.
    pub fn into_bytes(self) -> Result<Vec<u8>> {
        let Self { format, borders, entries, constants, meta } = self;
        let count = entries.len() as u32;
        let missing = entries.iter().position(Option::is_none);
        if let Some(face) = missing {
            return Err(Error::invalid("its texels are missing").at(format!("face {face}")).advise("give every face"));
        }
        let entries: Vec<Entry> = entries.into_iter().flatten().collect();
        let mut records: Vec<Record> = entries.iter().map(|entry| entry.record).collect();
        let texel = format.texel_size();
        neighborhood::flag(&mut records, format.mesh, borders, |face| &constants[face as usize * texel..][..texel]);

        let mut face_info = Vec::new();
        records.iter().for_each(|record| record.write(&mut face_info));
        let face_info = deflate(&face_info)?;
        let constants = deflate(&constants)?;
        let (level_info, level_data) = write_levels(&entries, &records)?;
        let meta = meta::write(&meta)?;
        let size = |bytes: &[u8], what: &str| {
            u32::try_from(bytes.len())
                .map_err(|_| Error::unsupported(format!("{what} take more than 4 GiB")).advise("use fewer"))
        };
        let header = Header {
            format,
            levels: (level_info.len() / LEVEL_INFO) as u16,
            faces: count,
            extended: ExtendedHeader::SIZE as u32,
            face_info: size(&face_info, "faces")?,
            constants: size(&constants, "constants of faces")?,
            level_info: size(&level_info, "levels")?,
            level_data: level_data.len() as u64,
            meta_zipped: size(&meta.small.0, "meta data")?,
            meta: meta.small.1,
        };
        let before = Header::SIZE + ExtendedHeader::SIZE + face_info.len() + constants.len() + level_info.len();
        let behind = meta.small.0.len() + BARRIER as usize + meta.large.0.len() + meta.values.len();
        let length = before + level_data.len() + behind;
        let extended = ExtendedHeader {
            borders,
            large_zipped: size(&meta.large.0, "names of large meta data")?,
            large: meta.large.1,
            large_data: meta.values.len() as u64,
            edits: 0,
            edits_at: length as u64,
        };
        let mut out = Vec::with_capacity(length);
        header.write(&mut out);
        extended.write(&mut out);
        out.extend(face_info);
        out.extend(constants);
        out.extend(level_info);
        out.extend(level_data);
        out.extend(meta.small.0);
        out.extend([0; BARRIER as usize]);
        out.extend(meta.large.0);
        out.extend(meta.values);
        Ok(out)
    }
}

/// Bytes of the description of a level.
const LEVEL_INFO: usize = 16;

/// Descriptions and blocks of all levels.
fn write_levels(entries: &[Entry], records: &[Record]) -> Result<(Vec<u8>, Vec<u8>)> {
    let ranks = ranks(records, &mut Budget::new(u64::MAX))?;
    let mut ordered = vec![0; ranks.len()];
    for (face, rank) in ranks.iter().enumerate() {
        ordered[*rank as usize] = face;
    }
    let levels = entries.iter().map(|entry| entry.blocks.len()).max().unwrap_or(1).max(1);
    let (mut info, mut data) = (Vec::new(), Vec::new());
    for level in 0..levels {
        let faces: Vec<&Entry> = if level == 0 {
            entries.iter().collect()
        } else {
            // Larger faces come first, so that those with a block in this level do.
            let stored = |entry: &&Entry| entry.blocks.len() > level;
            ordered.iter().map(|face| &entries[*face]).take_while(stored).collect()
        };
        let header = |entry: &&Entry| entry.blocks.get(level).map_or(0, |(header, _)| header.0).to_le_bytes();
        let headers = deflate(&faces.iter().flat_map(header).collect::<Vec<u8>>())?;
        let start = data.len();
        data.extend(&headers);
        faces.iter().filter_map(|entry| entry.blocks.get(level)).for_each(|(_, block)| data.extend(block));
        info.extend(((data.len() - start) as u64).to_le_bytes());
        info.extend((headers.len() as u32).to_le_bytes());
        info.extend((faces.len() as u32).to_le_bytes());
    }
    Ok((info, data))
}
