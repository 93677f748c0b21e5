//! Reads Ptex files: headers, faces, constants, edits and meta data at once, texels face by face.
//!
//! The file is hostile until read: every size is compared with the file's length and the memory limit before anything
//! is allocated, every offset before it is followed.

use std::path::Path;

use relievo_core::{Budget, Error, Result, file};

use crate::block::{self, BlockHeader, inflate};
use crate::face::{CONSTANT_NEIGHBORHOOD, EDITED, Face, Record};
use crate::fields::{Fields, damaged, section};
use crate::format::{Borders, Format, Resolution};
use crate::header::{ExtendedHeader, Header};
use crate::meta::{self, MetaData};

/// Files by 1.3 have so many zero bytes behind the meta data, which older readers take for an empty edit.
pub(crate) const BARRIER: u64 = 8;

/// Where the texels of a face lie.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    start: u64,
    header: BlockHeader,
}

/// A Ptex file, edits applied.
#[derive(Debug)]
pub struct Reader<B> {
    bytes: B,
    format: Format,
    borders: Borders,
    records: Vec<Record>,
    constants: Vec<u8>,
    /// Blocks of every level. In level 0 they are in the order of faces, in others in that of `ranks`.
    levels: Vec<Vec<Block>>,
    /// Place of every face among those ordered by size, if there are reductions.
    ranks: Vec<u32>,
    meta: MetaData,
    edits: usize,
    /// Bytes that may still be allocated.
    left: u64,
}

impl Reader<Vec<u8>> {
    /// Opens the file at `path`. `memory_limit` bounds in bytes the file and what is made of it, texels of one face
    /// included.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file does not exist or cannot be read, with `Memory` above the limit, and
    /// as [`Self::new`] does.
    pub fn open(path: &Path, memory_limit: u64) -> Result<Self> {
        let bytes = file::load(path, memory_limit)?;
        let left = memory_limit - bytes.len() as u64;
        Self::new(bytes, left).map_err(|error| error.at(path.display().to_string()))
    }
}

impl<B: AsRef<[u8]>> Reader<B> {
    /// Reads everything of a file but its texels. `memory_limit` bounds in bytes what is allocated, now and for the
    /// texels of a face.
    ///
    /// # Errors
    /// Fails with `Invalid`, and the byte or face, if the file is damaged or cut off, with `Unsupported` if it is of
    /// another version, and with `Memory` above the limit.
    pub fn new(bytes: B, memory_limit: u64) -> Result<Self> {
        let file = bytes.as_ref();
        let mut budget = Budget::new(memory_limit);
        let header = Header::read(file)?;
        let extended = ExtendedHeader::read(file, header.extended)?;
        // Sizes are of 32 bits but one, so that sums of them fit.
        let mut at = Header::SIZE as u64 + u64::from(header.extended);
        let mut next = |size: u64| {
            let start = at;
            at = at.saturating_add(size);
            start
        };
        let face_info = next(u64::from(header.face_info));
        let constants = next(u64::from(header.constants));
        let level_info = next(u64::from(header.level_info));
        let level_data = next(header.level_data);
        let small = next(u64::from(header.meta_zipped));
        let behind = next(0);

        let mut records = read_records(file, face_info, &header, &mut budget)?;
        let size = u64::from(header.faces) * header.format.texel_size() as u64;
        let zipped = section(file, constants, u64::from(header.constants), "the constants of faces")?;
        let mut constants =
            inflate(zipped, constants, size, &mut budget).map_err(|error| error.at("the constants of faces"))?;
        let mut levels = read_levels(file, level_info, level_data, &header, &mut budget)?;
        let ranks = if levels.len() > 1 { ranks(&records, &mut budget)? } else { Vec::new() };

        let mut meta = MetaData::new();
        let zipped = section(file, small, u64::from(header.meta_zipped), "the meta data")?;
        meta::read(zipped, small, header.meta, &mut budget, &mut meta)?;
        let mut end = behind;
        if extended.large > 0 {
            let start = behind + BARRIER;
            let place = (start, extended.large_zipped, extended.large, extended.large_data);
            meta::read_large(file, place, &mut budget, &mut meta)?;
            end = start + u64::from(extended.large_zipped) + extended.large_data;
        }
        let edits = if extended.edits_at > 0 {
            // Blocks of later versions may lie in front of the edits.
            let start = extended.edits_at.max(end);
            section(file, start, extended.edits, "the edits").map(|edits| (start, edits))?
        } else {
            (end, file.get(end as usize..).unwrap_or_default())
        };
        let mut target = Edits {
            header: &header,
            records: &mut records,
            constants: &mut constants,
            full: levels.first_mut().map_or(&mut [], Vec::as_mut_slice),
            meta: &mut meta,
            budget: &mut budget,
        };
        let edits = target.apply(edits.0, edits.1)?;
        let left = budget.left();
        let (format, borders) = (header.format, extended.borders);
        Ok(Self { bytes, format, borders, records, constants, levels, ranks, meta, edits, left })
    }

    /// What all texels have in common.
    pub fn format(&self) -> &Format {
        &self.format
    }

    /// What filters do at edges.
    pub fn borders(&self) -> Borders {
        self.borders
    }

    /// Number of faces.
    pub fn face_count(&self) -> u32 {
        self.records.len() as u32
    }

    /// Number of levels: the full one and its reductions.
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Number of edits that were applied.
    pub fn edit_count(&self) -> usize {
        self.edits
    }

    /// Meta data, edits applied.
    pub fn meta(&self) -> &MetaData {
        &self.meta
    }

    fn record(&self, face: u32) -> Result<&Record> {
        self.records.get(face as usize).ok_or_else(|| {
            Error::new(relievo_core::ErrorKind::NotFound, format!("there is no face {face}"))
                .advise(format!("the file has {}, counted from 0", self.records.len()))
        })
    }

    /// Resolution and neighbours of a face.
    ///
    /// # Errors
    /// Fails with `NotFound` if it does not exist.
    pub fn face(&self, face: u32) -> Result<&Face> {
        self.record(face).map(|record| &record.face)
    }

    /// The value of a face whose texels all have it.
    pub fn constant(&self, face: u32) -> Option<&[u8]> {
        self.records.get(face as usize).filter(|record| record.is_constant()).and_then(|_| self.average(face).ok())
    }

    /// The mean of a face's texels, which the file states.
    ///
    /// # Errors
    /// Fails with `NotFound` if the face does not exist.
    pub fn average(&self, face: u32) -> Result<&[u8]> {
        self.record(face)?;
        let size = self.format.texel_size();
        let start = face as usize * size;
        self.constants.get(start..start + size).ok_or_else(|| Error::internal(format!("face {face} has no constant")))
    }

    /// True if an edit gave the face its texels.
    pub fn is_edited(&self, face: u32) -> bool {
        self.records.get(face as usize).is_some_and(|record| record.has(EDITED))
    }

    /// True if the file says that the faces around a constant face have its value.
    pub fn has_constant_neighborhood(&self, face: u32) -> bool {
        self.records.get(face as usize).is_some_and(|record| record.has(CONSTANT_NEIGHBORHOOD))
    }

    /// The texels of a face: little-endian numbers of [`Format::data_type`], channels together, the row v = 0 first.
    ///
    /// A constant face is spread out; [`Reader::constant`] avoids that.
    ///
    /// # Errors
    /// Fails with `NotFound` if the face does not exist, with `Invalid` if the texels are damaged, and with `Memory` if
    /// they take more than is left of the memory limit.
    pub fn texels(&self, face: u32) -> Result<Vec<u8>> {
        self.decoded(face, 0).map_err(|error| error.at(format!("face {face}")))
    }

    fn decoded(&self, face: u32, level: usize) -> Result<Vec<u8>> {
        let record = self.record(face)?;
        let mut budget = Budget::new(self.left);
        if level == 0 && record.is_constant() {
            let size = record.face.resolution.texels() * self.format.texel_size() as u64;
            return block::spread(self.average(face)?, size, &mut budget);
        }
        let (block, resolution) = self.block(face, level)?;
        block::decode(self.bytes.as_ref(), block.start, block.header, &self.format, resolution, &mut budget)
    }

    /// Where the texels of a face in a level lie, and how many they are.
    fn block(&self, face: u32, level: usize) -> Result<(Block, Resolution)> {
        let index = if level == 0 { Some(&face) } else { self.ranks.get(face as usize) };
        let blocks = self.levels.get(level).zip(index);
        let block = blocks.and_then(|(blocks, index)| blocks.get(*index as usize));
        let times = u8::try_from(level).ok();
        let resolution = times.and_then(|times| self.record(face).ok()?.face.resolution.halved(times));
        block
            .copied()
            .zip(resolution)
            .ok_or_else(|| Error::invalid("the file has no texels of it").advise("the file is damaged: write it again"))
    }

    /// The texels that the file holds of a face in a level of reductions: half as many along u and v per level,
    /// colours multiplied by alpha. `None` for constant, edited and small faces, which have none.
    ///
    /// # Errors
    /// Fails with `NotFound` if the face does not exist, with `Invalid` if the texels are damaged, and with `Memory` if
    /// they take more than is left of the memory limit.
    pub fn reduction(&self, face: u32, level: usize) -> Result<Option<Vec<u8>>> {
        if !self.has_reduction(self.record(face)?, face, level) {
            return Ok(None);
        }
        self.decoded(face, level).map(Some).map_err(|error| error.at(format!("face {face}, level {level}")))
    }

    fn has_reduction(&self, record: &Record, face: u32, level: usize) -> bool {
        let rank = self.ranks.get(face as usize).copied().unwrap_or(u32::MAX) as usize;
        let stored = self.levels.get(level).is_some_and(|blocks| rank < blocks.len());
        level > 0 && stored && !record.is_constant() && !record.has(EDITED)
    }

    /// How many levels of reductions the file holds of a face: 0 for faces that have none, or do not exist.
    pub fn reduction_count(&self, face: u32) -> usize {
        let Ok(record) = self.record(face) else { return 0 };
        let there = |level: &usize| self.has_reduction(record, face, *level) && self.block(face, *level).is_ok();
        (1..self.level_count()).take_while(there).count()
    }

    /// Decompresses all that is stored of faces and reductions once, in a time that the length of the file bounds.
    ///
    /// # Errors
    /// Fails with `Invalid` at the first that is damaged, and with `Memory` if one takes more than is left of the
    /// memory limit.
    pub fn check(&self) -> Result<()> {
        for (face, record) in (0u32..).zip(&self.records).filter(|(_, record)| !record.is_constant()) {
            let last = (1..self.level_count()).take_while(|level| self.has_reduction(record, face, *level)).last();
            for level in 0..=last.unwrap_or(0) {
                let sound = self.block(face, level).and_then(|(block, resolution)| {
                    let mut budget = Budget::new(self.left);
                    block::check(self.bytes.as_ref(), block.start, block.header, &self.format, resolution, &mut budget)
                });
                sound.map_err(|error| error.at(format!("face {face}, level {level}")))?;
            }
        }
        Ok(())
    }

    pub(crate) fn file_length(&self) -> usize {
        self.bytes.as_ref().len()
    }
}

fn read_records(file: &[u8], start: u64, header: &Header, budget: &mut Budget) -> Result<Vec<Record>> {
    let zipped = section(file, start, u64::from(header.face_info), "the list of faces")?;
    let size = u64::from(header.faces) * Record::SIZE as u64;
    let mut scratch = Budget::new(budget.left());
    let bytes = inflate(zipped, start, size, &mut scratch).map_err(|error| error.at("the list of faces"))?;
    let mut records = Vec::new();
    budget.reserve(&mut records, header.faces as usize)?;
    let mut fields = Fields::new(&bytes, 0);
    for face in 0..header.faces {
        let record = Record::read(&mut fields, header.format.mesh, header.faces);
        records.push(record.map_err(|error| error.at(format!("face {face}")))?);
    }
    Ok(records)
}

/// Reads where the blocks of all levels are. Blocks lie one behind the other.
fn read_levels(file: &[u8], info: u64, data: u64, header: &Header, budget: &mut Budget) -> Result<Vec<Vec<Block>>> {
    let mut fields = Fields::new(section(file, info, u64::from(header.level_info), "the list of levels")?, info);
    section(file, data, header.level_data, "the texels of all levels")?;
    let mut levels = Vec::new();
    budget.reserve(&mut levels, usize::from(header.levels))?;
    let (mut start, end) = (data, data + header.level_data);
    for level in 0..header.levels {
        let within = |error: Error| error.at(format!("level {level}"));
        let at = fields.offset();
        let (size, zipped, faces) = (fields.u64()?, fields.u32()?, fields.u32()?);
        if faces > header.faces || (level == 0 && faces != header.faces) {
            return Err(within(damaged(format!("it has {faces} faces of {}", header.faces), at)));
        }
        if size > end - start {
            return Err(within(damaged(format!("it has {size} bytes, but {} are left", end - start), at)));
        }
        let list = section(file, start, u64::from(zipped).min(size), "the sizes of faces").map_err(within)?;
        let mut scratch = Budget::new(budget.left());
        let sizes = inflate(list, start, 4 * u64::from(faces), &mut scratch).map_err(within)?;
        let mut blocks = Vec::new();
        budget.reserve(&mut blocks, faces as usize)?;
        let mut block = start + list.len() as u64;
        start += size;
        for bytes in sizes.as_chunks().0 {
            let header = BlockHeader(u32::from_le_bytes(*bytes));
            blocks.push(Block { start: block, header });
            block += header.size();
        }
        if block > start {
            return Err(within(damaged(format!("its faces end at byte {block}, behind it"), start)));
        }
        levels.push(blocks);
    }
    Ok(levels)
}

/// The place of every face among all, larger ones first, in the order of the file among equal ones.
pub(crate) fn ranks(records: &[Record], budget: &mut Budget) -> Result<Vec<u32>> {
    let mut starts = [0u32; 256];
    for record in records {
        starts[usize::from(record.rank())] += 1;
    }
    let mut start = 0;
    for count in starts.iter_mut().rev() {
        (*count, start) = (start, start + *count);
    }
    let mut ranks = Vec::new();
    budget.reserve(&mut ranks, records.len())?;
    for record in records {
        let place = &mut starts[usize::from(record.rank())];
        ranks.push(*place);
        *place += 1;
    }
    Ok(ranks)
}

/// What edits change.
struct Edits<'a> {
    header: &'a Header,
    records: &'a mut [Record],
    constants: &'a mut [u8],
    full: &'a mut [Block],
    meta: &'a mut MetaData,
    budget: &'a mut Budget,
}

/// Kinds of edits, as files hold them. The published description counts them from 1, all programs from 0.
const EDIT_FACE: u8 = 0;
const EDIT_META: u8 = 1;

impl Edits<'_> {
    /// Applies the edits in `bytes`, which lie at `start`, one after the other. Returns their number.
    fn apply(&mut self, start: u64, bytes: &[u8]) -> Result<usize> {
        let mut fields = Fields::new(bytes, start);
        let mut count = 0;
        while !fields.is_empty() {
            let at = fields.offset();
            let (kind, size) = (fields.u8()?, fields.u32()?);
            if size == 0 {
                break;
            }
            let offset = fields.offset();
            let edit = fields.take(size as usize)?;
            let edit = Fields::new(edit, offset);
            match kind {
                EDIT_FACE => self.face(edit),
                EDIT_META => self.meta(edit),
                // Later versions may have more kinds.
                _ => Ok(()),
            }
            .map_err(|error| error.at(format!("edit at byte {at}")))?;
            count += 1;
        }
        Ok(count)
    }

    fn face(&mut self, mut fields: Fields) -> Result<()> {
        let at = fields.offset();
        let face = fields.u32()?;
        let mut record = Record::read(&mut fields, self.header.format.mesh, self.header.faces)
            .map_err(|error| error.at(format!("face {face}")))?;
        let header = BlockHeader(fields.u32()?);
        let size = self.header.format.texel_size();
        let value = fields.take(size)?;
        let start = fields.offset();
        let (place, target) = (self.records.get_mut(face as usize), face as usize * size);
        let (Some(place), Some(constant)) = (place, self.constants.get_mut(target..target + size)) else {
            return Err(damaged(format!("it is of face {face} of {}", self.header.faces), at));
        };
        if !record.is_constant() {
            fields.take(header.size() as usize)?;
            let block = self.full.get_mut(face as usize);
            *block.ok_or_else(|| damaged("the file has no level for its texels", at))? = Block { start, header };
        }
        constant.copy_from_slice(value);
        record.flags |= EDITED;
        *place = record;
        Ok(())
    }

    fn meta(&mut self, mut fields: Fields) -> Result<()> {
        let (zipped, size) = (fields.u32()?, fields.u32()?);
        let start = fields.offset();
        meta::read(fields.take(zipped as usize)?, start, size, self.budget, self.meta)
    }
}
