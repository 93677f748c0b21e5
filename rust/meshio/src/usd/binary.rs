//! Layers in binary ("crate") files: structure and values are checked before the parser sees them.
//!
//! The parser allocates what the file's counts ask for and follows its offsets, so every count is held against the
//! bytes that are there, integers are decoded once to see that they refer to something, and the tree of paths is
//! walked. What is wrong in ways that this misses makes the parser panic, which [`super::layer`] turns into an error.
//! The format is described in OpenUSD's `crateFile.cpp` and in the AOUSD Core Specification 1.0, Section 16.3.

use std::cell::RefCell;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use openusd::sdf::Value;
use openusd::usdc::CrateFile;
use relievo_core::{Error, Result};

use super::layer::fenced;
use crate::USD_MAGIC;
use crate::budget::Budget;

/// Most names of prims on a path.
const DEPTH: u32 = 128;
/// Most dictionaries inside one another.
const DICTIONARIES: u32 = 32;
/// A block of LZ4 is at most so many times as long unpacked.
const LARGEST_RATIO: u64 = 255;

/// The bytes of a file, shared by the parser and the checks.
#[derive(Clone, Debug)]
struct Bytes(Arc<Vec<u8>>);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// A binary layer.
pub(crate) struct Binary {
    bytes: Bytes,
    version: u32,
    file: RefCell<CrateFile<Cursor<Bytes>>>,
    /// Where the fields of the spec at a path begin.
    specs: HashMap<String, usize>,
}

impl Binary {
    /// Checks the structure of a file and opens it.
    pub fn open(bytes: Vec<u8>, budget: &mut Budget) -> Result<Self> {
        let version = structure(&bytes, budget)?;
        let bytes = Bytes(Arc::new(bytes));
        let mut file = fenced(|| CrateFile::open(Cursor::new(bytes.clone())))?;
        fenced(|| file.validate())?;
        let mut specs = HashMap::with_capacity(file.specs.len());
        for spec in std::mem::take(&mut file.specs) {
            let path = file.paths.get(spec.path_index).ok_or_else(|| damaged("a spec has no path"))?;
            specs.insert(path.as_str().to_owned(), spec.fieldset_index);
        }
        Ok(Self { bytes, version, file: RefCell::new(file), specs })
    }

    /// Whether something is said about what is at the path.
    pub fn has(&self, path: &str) -> bool {
        self.specs.contains_key(path)
    }

    /// A field of what is at the path. Decoding it takes at most `left` bytes.
    pub fn field(&self, path: &str, name: &str, left: u64) -> Result<Option<Value>> {
        let Some(start) = self.specs.get(path) else { return Ok(None) };
        let mut file = self.file.borrow_mut();
        let set = file.fieldsets.get(*start..).unwrap_or_default().iter().map_while(|field| *field);
        let mut fields = set.filter_map(|index| file.fields.get(index));
        let found = fields.find(|field| file.tokens.get(field.token_index).is_some_and(|token| token == name));
        let Some(rep) = found.map(|field| field.value_rep) else { return Ok(None) };
        let tables = Tables { tokens: file.tokens.len(), strings: file.strings.len(), paths: file.paths.len() };
        let mut check = Check { bytes: self.bytes.as_ref(), version: self.version, tables, left, dictionaries: 0 };
        check.value(rep.0)?;
        fenced(|| file.value(rep)).map(Some)
    }
}

fn damaged(what: &str) -> Error {
    Error::invalid(format!("the binary layer is damaged: {what}")).advise("export the file again")
}

fn version(major: u8, minor: u8) -> u32 {
    u32::from(major) << 8 | u32::from(minor)
}

/// Reads numbers from a place in a file.
#[derive(Clone, Copy)]
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], at: u64) -> Result<Self> {
        let at = usize::try_from(at).ok().filter(|at| *at <= bytes.len());
        Ok(Self { bytes, at: at.ok_or_else(|| damaged("an offset is behind its end"))? })
    }

    fn take(&mut self, count: u64) -> Result<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let count = usize::try_from(count).ok().filter(|count| *count <= rest.len());
        let count = count.ok_or_else(|| damaged("it ends too early"))?;
        self.at += count;
        Ok(&rest[..count])
    }

    fn word<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut word = [0; N];
        word.copy_from_slice(self.take(N as u64)?);
        Ok(word)
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.word()?))
    }

    fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.word()?))
    }

    /// A packed block, which may become at most `most` bytes.
    fn packed(&mut self, most: u64) -> Result<Packed<'a>> {
        let length = self.u64()?;
        match self.take(length)?.split_first() {
            Some((0, block)) => Ok(Packed { block, most }),
            Some(_) => Err(Error::unsupported("the binary layer is packed in several blocks")
                .advise("convert it to .usda with usdcat")),
            None => Err(damaged("a packed block is empty")),
        }
    }

    /// A packed list of `count` integers of 4 or 8 bytes.
    fn integers(&mut self, count: u64, size: u64) -> Result<Packed<'a>> {
        // What the parser allocates for any size.
        let room = count.checked_mul(5).and_then(|bytes| bytes.checked_add(16));
        let packed = self.packed(room.ok_or_else(|| damaged("a list is too long"))?.saturating_mul(size / 4))?;
        // Two bits for every integer at least, so that its length is bounded by that of the block.
        if count / 4 > packed.longest() {
            return Err(damaged("a list is longer than its bytes can say"));
        }
        Ok(packed)
    }
}

/// A packed block of bytes.
struct Packed<'a> {
    block: &'a [u8],
    most: u64,
}

impl Packed<'_> {
    /// Bytes that it can become at most.
    fn longest(&self) -> u64 {
        (self.block.len() as u64).saturating_mul(LARGEST_RATIO).saturating_add(16).min(self.most)
    }

    fn unpack(&self, budget: &mut Budget) -> Result<Vec<u8>> {
        let length = usize::try_from(self.longest()).map_err(|_| damaged("a block is too long"))?;
        let mut bytes = budget.filled(length, 0)?;
        let used = lz4_flex::block::decompress_into(self.block, &mut bytes);
        bytes.truncate(used.map_err(|_| damaged("a block cannot be unpacked"))?);
        Ok(bytes)
    }

    /// The integers in it (OpenUSD's `integerCoding.cpp`): the most frequent difference, two bits for each one that say
    /// how its difference to the one before is written, the differences.
    fn decode(&self, count: u64, size: usize, budget: &mut Budget) -> Result<Vec<i64>> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = self.unpack(budget)?;
        let mut values = Vec::new();
        budget.reserve(&mut values, usize::try_from(count).map_err(|_| damaged("a list is too long"))?)?;
        let short = || damaged("a list ends too early");
        let number = |bytes: &[u8]| {
            let mut word = [if bytes.last().is_some_and(|last| *last >= 128) { 255 } else { 0 }; 8];
            word[..bytes.len()].copy_from_slice(bytes);
            i64::from_le_bytes(word)
        };
        let common = number(bytes.get(..size).ok_or_else(short)?);
        let codes = bytes.get(size..).and_then(|rest| rest.get(..count.div_ceil(4) as usize)).ok_or_else(short)?;
        let mut rest = &bytes[size + codes.len()..];
        let mut value = 0i64;
        for index in 0..4 * codes.len() {
            let length = match codes[index / 4] >> (2 * (index % 4)) & 3 {
                0 => 0,
                code => size >> (3 - code),
            };
            // The last byte may speak of more than there are, which the parser reads as well.
            let (word, after) = rest.split_at_checked(length).ok_or_else(short)?;
            rest = after;
            value = value.wrapping_add(if length == 0 { common } else { number(word) });
            if index < count as usize {
                values.push(value);
            }
        }
        Ok(values)
    }
}

/// Checks everything that the parser reads when it opens a file. Returns the version of the format.
fn structure(bytes: &[u8], budget: &mut Budget) -> Result<u32> {
    let mut header = Reader::new(bytes, 0)?;
    if header.take(8)? != USD_MAGIC {
        return Err(damaged("it does not begin as one"));
    }
    let [major, minor, patch, ..] = header.word::<8>()?;
    let version = version(major, minor);
    if major != 0 || !(4..=12).contains(&minor) {
        return Err(Error::unsupported(format!("the binary layer is of version {major}.{minor}.{patch}"))
            .advise("versions 0.4 to 0.12 are read; convert it with usdcat"));
    }
    let mut toc = Reader::new(bytes, header.u64()?)?;
    let count = toc.u64()?;
    if count >= 64 {
        return Err(damaged("it has too many sections"));
    }
    let mut sections: HashMap<&[u8], u64> = HashMap::new();
    for _ in 0..count {
        let name = toc.take(16)?.split(|byte| *byte == 0).next().unwrap_or_default();
        let start = toc.u64()?;
        toc.u64()?;
        sections.entry(name).or_insert(start);
    }
    let section = |name: &str| {
        let start = sections.get(name.as_bytes()).ok_or_else(|| damaged(&format!("it has no section {name}")))?;
        Reader::new(bytes, *start)
    };
    // What is unpacked here is dropped again, and then allocated by the parser: twice is enough for both.
    let mut scratch = Budget::new(budget.left() / 2);

    let mut tokens = section("TOKENS")?;
    let (count, length) = (tokens.u64()?, tokens.u64()?);
    let block = tokens.packed(length)?;
    if block.longest() < length {
        return Err(damaged("its names are longer than their block"));
    }
    scratch.charge(length.saturating_add(count.saturating_mul(32)))?;
    let text = block.unpack(&mut scratch)?;
    let names: Vec<&[u8]> = match text.split_last() {
        Some((0, rest)) => rest.split(|byte| *byte == 0).collect(),
        None => Vec::new(),
        Some(_) => return Err(damaged("its names do not end")),
    };
    if names.len() as u64 != count {
        return Err(damaged("it has another number of names than it says"));
    }

    let mut strings = section("STRINGS")?;
    let count = strings.u64()?;
    for word in strings.take(count.saturating_mul(4))?.as_chunks().0 {
        if u32::from_le_bytes(*word) as usize >= names.len() {
            return Err(damaged("a string has no name"));
        }
    }

    let mut fields = section("FIELDS")?;
    let count = fields.u64()?;
    scratch.charge(count.saturating_mul(16))?;
    refer(&fields.integers(count, 4)?.decode(count, 4, &mut scratch)?, names.len(), "a field has no name")?;
    if fields.packed(count.saturating_mul(8))?.longest() < count.saturating_mul(8) {
        return Err(damaged("it has fewer values than fields"));
    }
    let field_count = count as usize;

    let mut sets = section("FIELDSETS")?;
    let count = sets.u64()?;
    scratch.charge(count.saturating_mul(16))?;
    let list = sets.integers(count, 4)?.decode(count, 4, &mut scratch)?;
    let list: Vec<i64> = list.into_iter().filter(|index| *index as u32 != u32::MAX).collect();
    refer(&list, field_count, "a set of fields has one that is not there")?;

    let mut paths = section("PATHS")?;
    let (path_count, count) = (paths.u64()?, paths.u64()?);
    if path_count > bytes.len() as u64 * LARGEST_RATIO || count > path_count {
        return Err(damaged("it has too many paths"));
    }
    scratch.charge(path_count.saturating_mul(32))?;
    let mut integers = || paths.integers(count, 4)?.decode(count, 4, &mut scratch);
    let (places, elements, jumps) = (integers()?, integers()?, integers()?);
    refer(&places, path_count as usize, "a path has no place")?;
    let elements = elements.iter().map(|element| (*element as i32).unsigned_abs() as usize);
    // The root's is of no account.
    let lengths = elements.enumerate().map(|(index, element)| match names.get(element) {
        Some(name) => Ok(name.len() as u64 + 1),
        None if index == 0 => Ok(1),
        None => Err(damaged("a path has no name")),
    });
    walk(&jumps, &lengths.collect::<Result<Vec<u64>>>()?, &mut scratch)?;

    let mut specs = section("SPECS")?;
    let count = specs.u64()?;
    scratch.charge(count.saturating_mul(96))?;
    for _ in 0..3 {
        specs.integers(count, 4)?.decode(count, 4, &mut scratch)?;
    }
    budget.charge(budget.left() / 2 - scratch.left())?;
    Ok(version)
}

/// Fails with `what` if a number is not the index of one of `count` things.
fn refer(list: &[i64], count: usize, what: &str) -> Result<()> {
    if list.iter().all(|index| (*index as u32 as usize) < count) { Ok(()) } else { Err(damaged(what)) }
}

/// Follows the tree of paths as the parser does and counts their letters. Every entry may be reached once, so that
/// neither time nor memory grows beyond them.
fn walk(jumps: &[i64], lengths: &[u64], budget: &mut Budget) -> Result<()> {
    let mut reached = budget.filled(jumps.len(), false)?;
    let mut pending = vec![(0usize, 0u64, 0u32)];
    if jumps.is_empty() {
        return Ok(());
    }
    while let Some((mut index, mut above, mut depth)) = pending.pop() {
        loop {
            match reached.get_mut(index) {
                Some(reached) if !*reached => *reached = true,
                Some(_) => return Err(damaged("a path is reached twice")),
                None => return Err(damaged("a path leads nowhere")),
            }
            if depth > DEPTH {
                return Err(
                    Error::unsupported(format!("more than {DEPTH} prims are nested")).advise("flatten the stage")
                );
            }
            let length = above + lengths[index];
            // Twice: as a path and as the key it is found by.
            budget.charge(2 * length + 64)?;
            let jump = jumps[index] as i32;
            let (child, sibling) = (jump > 0 || jump == -1, jump >= 0);
            if child {
                if sibling {
                    pending.push((index.saturating_add(jump as usize), above, depth));
                }
                (above, depth) = (length, depth + 1);
            }
            if !child && !sibling {
                break;
            }
            index += 1;
        }
    }
    Ok(())
}

/// How many entries the tables have that values refer to.
struct Tables {
    tokens: usize,
    strings: usize,
    paths: usize,
}

/// Checks values before they are decoded.
struct Check<'a> {
    bytes: &'a [u8],
    version: u32,
    tables: Tables,
    /// Bytes that decoding may still take.
    left: u64,
    dictionaries: u32,
}

impl<'a> Check<'a> {
    /// Counts what is allocated.
    fn charge(&mut self, count: u64, size: u64) -> Result<()> {
        let bytes = count.checked_mul(size).filter(|bytes| *bytes <= self.left);
        let bytes = bytes.ok_or_else(|| {
            Error::memory("reading it needs more than the memory limit").advise("raise the memory limit")
        })?;
        self.left -= bytes;
        Ok(())
    }

    fn index(&self, index: u64, count: usize) -> Result<()> {
        if index < count as u64 { Ok(()) } else { Err(damaged("a value refers to what is not there")) }
    }

    /// Indices in a counted list, each of which becomes `size` bytes.
    fn list(&mut self, reader: &mut Reader, count: usize, size: u64) -> Result<()> {
        let length = reader.u64()?;
        let bytes = reader.take(length.saturating_mul(4))?;
        self.charge(length, size)?;
        bytes.as_chunks().0.iter().try_for_each(|word| self.index(u64::from(u32::from_le_bytes(*word)), count))
    }

    /// Checks the value that is represented by `rep`: eight bits of flags, eight of its type, 48 of where it is.
    fn value(&mut self, rep: u64) -> Result<()> {
        let (array, inlined, packed) = (rep >> 63 & 1 == 1, rep >> 62 & 1 == 1, rep >> 61 & 1 == 1);
        let (kind, payload) = (rep >> 48 & 0xff, rep & ((1 << 48) - 1));
        let mut reader = Reader::new(self.bytes, if inlined { 0 } else { payload })?;
        let unlike = || damaged("a value is not of its type");
        if array && kind <= 30 && !matches!(kind, 10 | 12) {
            return self.array(kind, payload, packed);
        }
        if array && !matches!(kind, 10 | 12 | 56) || packed || inlined && (31..=41).contains(&kind) && kind != 31 {
            return Err(unlike());
        }
        match kind {
            // Numbers, and enumerations of 4 bytes, whose inline forms need no check.
            1..=9 | 13..=30 | 42..=44 | 56 if !array => {
                if inlined {
                    Ok(())
                } else {
                    reader.take(1).map(drop)
                }
            }
            56 => self.array(9, payload, packed),
            10 if array => self.list(&mut reader, self.tables.strings, 64),
            12 if array => self.list(&mut reader, self.tables.strings, 64),
            10 | 12 if inlined => {
                let count = if kind == 10 { self.tables.strings } else { self.tables.tokens };
                self.index(payload & 0xffff_ffff, count)
            }
            10 | 12 => {
                let index = reader.u32()?;
                self.index(index.into(), self.tables.strings)
            }
            11 if inlined => self.index(payload & 0xffff_ffff, self.tables.tokens),
            11 => {
                let index = reader.u64()?;
                self.index(index, self.tables.tokens)
            }
            31 if inlined => Ok(()),
            31 => self.dictionary(reader),
            32 => self.operations(reader, |check, reader| check.list(reader, check.tables.tokens, 64)),
            33 => self.operations(reader, |check, reader| check.list(reader, check.tables.strings, 64)),
            34 => self.operations(reader, |check, reader| check.list(reader, check.tables.paths, 64)),
            35 => self.operations(reader, |check, reader| check.arcs(reader, true)),
            55 if !inlined => self.operations(reader, |check, reader| check.arcs(reader, false)),
            40 => self.list(&mut reader, self.tables.paths, 64),
            41 => self.list(&mut reader, self.tables.tokens, 64),
            45 if !inlined => {
                let count = reader.u64()?;
                self.charge(count, 128)?;
                (0..2 * count).try_for_each(|_| {
                    let index = reader.u32()?;
                    self.index(index.into(), self.tables.strings)
                })
            }
            46 if !inlined => self.samples(reader),
            47 if !inlined => self.arc(&mut reader, false),
            48 if !inlined => self.array(9, payload, packed),
            49 if !inlined => {
                let count = reader.u64()?;
                reader.take(count.saturating_mul(16))?;
                self.charge(count, 16)
            }
            50 if !inlined => self.list(&mut reader, self.tables.strings, 64),
            51 | 52 => Ok(()),
            _ => Err(Error::unsupported(format!("the binary layer has a value of kind {kind}"))),
        }
    }

    /// An array of numbers or tokens.
    fn array(&mut self, kind: u64, payload: u64, packed: bool) -> Result<()> {
        let size = match kind {
            1 | 2 => 1,
            7 => 2,
            3 | 4 | 8 | 11 | 21 => 4,
            5 | 6 | 9 | 18 | 20 | 22 | 29 => 8,
            25 => 6,
            24 | 26 => 12,
            17 | 19 | 28 | 30 => 16,
            23 => 24,
            13 | 16 | 27 => 32,
            14 => 72,
            15 => 128,
            _ => return Err(damaged("an array is of no type")),
        };
        if payload == 0 {
            return Ok(());
        }
        let mut reader = Reader::new(self.bytes, payload)?;
        if self.version < version(0, 5) {
            reader.u32()?;
        }
        let count = if self.version < version(0, 7) { reader.u32()?.into() } else { reader.u64()? };
        // Twice, since some are copied; and the list and the block that packed integers pass through.
        self.charge(count, 2 * size + if packed { 16 } else { 0 })?;
        let integers = matches!(kind, 3..=6) && self.version >= version(0, 5);
        let floats = matches!(kind, 7..=9) && self.version >= version(0, 6);
        if packed && !integers && !floats {
            return Err(damaged("an array of its type is never packed"));
        }
        if !packed || count < 4 {
            let bytes = reader.take(count.saturating_mul(size))?;
            if kind == 11 {
                self.charge(count, 64)?;
                let words = bytes.as_chunks().0.iter();
                return words
                    .map(|word| u32::from_le_bytes(*word))
                    .try_for_each(|token| self.index(token.into(), self.tables.tokens));
            }
            return Ok(());
        }
        if integers {
            return self.packed_integers(&mut reader, count, size as usize, None);
        }
        match reader.word::<1>()? {
            [b'i'] => self.packed_integers(&mut reader, count, 4, None),
            [b't'] => {
                let table = reader.u32()?;
                reader.take(u64::from(table) * size)?;
                self.packed_integers(&mut reader, count, 4, Some(table as usize))
            }
            _ => Err(damaged("an array is packed in a way that is not known")),
        }
    }

    fn packed_integers(&mut self, reader: &mut Reader, count: u64, size: usize, table: Option<usize>) -> Result<()> {
        let packed = reader.integers(count, size as u64)?;
        if size == 8 {
            // The parser makes room for integers of 4 bytes only, and says so where longer ones do not fit.
            return Ok(());
        }
        let values = packed.decode(count, size, &mut Budget::new(self.left))?;
        table.map_or(Ok(()), |table| refer(&values, table, "an array refers to what is not there"))
    }

    /// What each of the lists of a list operation holds.
    fn operations(
        &mut self,
        mut reader: Reader<'a>,
        mut list: impl FnMut(&mut Self, &mut Reader<'a>) -> Result<()>,
    ) -> Result<()> {
        let [flags] = reader.word::<1>()?;
        (1..=6).filter(|bit| flags >> bit & 1 == 1).try_for_each(|_| list(self, &mut reader))
    }

    fn arcs(&mut self, reader: &mut Reader<'a>, is_reference: bool) -> Result<()> {
        let count = reader.u64()?;
        self.charge(count, 256)?;
        (0..count).try_for_each(|_| self.arc(reader, is_reference))
    }

    /// A reference or a payload.
    fn arc(&mut self, reader: &mut Reader<'a>, is_reference: bool) -> Result<()> {
        let (asset, path) = (reader.u32()?, reader.u32()?);
        self.index(asset.into(), self.tables.strings)?;
        self.index(path.into(), self.tables.paths)?;
        if is_reference || self.version >= version(0, 8) {
            reader.take(16)?;
        }
        if is_reference { self.entries(reader) } else { Ok(()) }
    }

    fn dictionary(&mut self, mut reader: Reader<'a>) -> Result<()> {
        self.entries(&mut reader)
    }

    /// The entries of a dictionary.
    fn entries(&mut self, reader: &mut Reader<'a>) -> Result<()> {
        if self.dictionaries == DICTIONARIES {
            return Err(damaged("its dictionaries nest too deeply"));
        }
        self.dictionaries += 1;
        let count = reader.u64()?;
        self.charge(count, 256)?;
        for _ in 0..count {
            let key = reader.u32()?;
            self.index(key.into(), self.tables.strings)?;
            *reader = self.jump(*reader)?;
            let rep = reader.u64()?;
            self.value(rep)?;
        }
        self.dictionaries -= 1;
        Ok(())
    }

    /// Where an offset leads that counts from its own place.
    fn jump(&self, mut reader: Reader) -> Result<Reader<'a>> {
        let from = reader.at as i64;
        let offset = i64::from_le_bytes(reader.word()?);
        let to = from.checked_add(offset).and_then(|to| u64::try_from(to).ok());
        Reader::new(self.bytes, to.ok_or_else(|| damaged("an offset is before its start"))?)
    }

    /// Values over time.
    fn samples(&mut self, reader: Reader<'a>) -> Result<()> {
        let mut reader = self.jump(reader)?;
        let times = reader.u64()?;
        if !matches!((times >> 48 & 0xff, times >> 63), (48, _) | (9, 1)) {
            return Err(damaged("samples have no times"));
        }
        let bytes = self.bytes;
        let values = self.jump(reader)?.at as u64;
        self.value(times)?;
        let mut reader = Reader::new(bytes, values)?;
        let count = reader.u64()?;
        let reps = reader.take(count.saturating_mul(8))?;
        self.charge(count, 128)?;
        for rep in reps.as_chunks().0 {
            let rep = u64::from_le_bytes(*rep);
            if matches!(rep >> 48 & 0xff, 31 | 46) {
                return Err(damaged("a sample holds samples"));
            }
            self.value(rep)?;
        }
        Ok(())
    }
}
