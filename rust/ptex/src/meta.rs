//! Meta data: what programs store beside the texels, by name.

use std::collections::BTreeMap;

use relievo_core::{Budget, Error, Result};

use crate::block::{deflate, inflate};
use crate::fields::{Fields, damaged, section};

/// A value of meta data.
#[derive(Clone, Debug, PartialEq)]
pub enum MetaValue {
    /// A text. In files it ends with a zero byte; bytes that are not UTF-8 are replaced on reading.
    Text(String),
    /// Signed bytes.
    I8(Vec<i8>),
    /// Signed 16-bit numbers.
    I16(Vec<i16>),
    /// Signed 32-bit numbers.
    I32(Vec<i32>),
    /// Floats.
    F32(Vec<f32>),
    /// Double floats.
    F64(Vec<f64>),
}

/// All meta data of a file, by key.
pub type MetaData = BTreeMap<String, MetaValue>;

impl MetaValue {
    /// Name of the type, as users know it.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Text(_) => "string",
            Self::I8(_) => "int8",
            Self::I16(_) => "int16",
            Self::I32(_) => "int32",
            Self::F32(_) => "float",
            Self::F64(_) => "double",
        }
    }

    /// Numbers, or bytes of a text.
    pub fn len(&self) -> usize {
        match self {
            Self::Text(text) => text.len(),
            Self::I8(values) => values.len(),
            Self::I16(values) => values.len(),
            Self::I32(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    /// True if it has no numbers or bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn code(&self) -> u8 {
        match self {
            Self::Text(_) => 0,
            Self::I8(_) => 1,
            Self::I16(_) => 2,
            Self::I32(_) => 3,
            Self::F32(_) => 4,
            Self::F64(_) => 5,
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Text(text) => text.bytes().chain([0]).collect(),
            Self::I8(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::I16(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::I32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    fn read(code: u8, bytes: &[u8], offset: u64) -> Result<Self> {
        let size = match code {
            0 | 1 => 1,
            2 => 2,
            3 | 4 => 4,
            5 => 8,
            other => return Err(damaged(format!("there is no type {other} of meta data"), offset)),
        };
        if !bytes.len().is_multiple_of(size) {
            return Err(damaged(format!("{} bytes are no numbers of {size} bytes", bytes.len()), offset));
        }
        fn numbers<const N: usize, T>(bytes: &[u8], from: impl Fn([u8; N]) -> T) -> Vec<T> {
            bytes.as_chunks().0.iter().map(|number| from(*number)).collect()
        }
        Ok(match code {
            0 => Self::Text(text(bytes)),
            1 => Self::I8(numbers(bytes, i8::from_le_bytes)),
            2 => Self::I16(numbers(bytes, i16::from_le_bytes)),
            3 => Self::I32(numbers(bytes, i32::from_le_bytes)),
            4 => Self::F32(numbers(bytes, f32::from_le_bytes)),
            _ => Self::F64(numbers(bytes, f64::from_le_bytes)),
        })
    }
}

/// The text in front of the first zero byte.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// Bytes that an entry occupies in memory beside its value, at most.
const ENTRY: u64 = 256;

/// Name, type and size of an entry.
struct Entry {
    key: String,
    code: u8,
    size: u32,
    offset: u64,
}

impl Entry {
    fn read(fields: &mut Fields, budget: &mut Budget) -> Result<Self> {
        let offset = fields.offset();
        let length = fields.u8()?;
        if length == 0 {
            return Err(damaged("meta data has no key", offset));
        }
        let key = text(fields.take(usize::from(length))?);
        let (code, size) = (fields.u8()?, fields.u32()?);
        // Replaced bytes of a text take three times as many.
        budget.charge(ENTRY + 4 * u64::from(length) + if code == 0 { 3 } else { 1 } * u64::from(size))?;
        Ok(Self { key, code, size, offset })
    }

    fn write(key: &str, value: &MetaValue, size: usize, out: &mut Vec<u8>) -> Result<()> {
        let length = u8::try_from(key.len() + 1).ok().filter(|_| !key.is_empty() && !key.contains('\0'));
        let length = length.ok_or_else(|| {
            Error::invalid(format!("{key:?} cannot be a key of meta data"))
                .advise("use 1 to 254 bytes, none of them zero")
        })?;
        let size = u32::try_from(size).map_err(|_| {
            Error::unsupported("a value of meta data takes more than 4 GiB").at(key).advise("store less")
        })?;
        out.push(length);
        out.extend(key.bytes().chain([0]));
        out.push(value.code());
        out.extend(size.to_le_bytes());
        Ok(())
    }
}

/// Reads entries from `zipped`, which lies at `offset` and has `size` bytes when decompressed. A key that is there
/// already gets its new value.
pub(crate) fn read(zipped: &[u8], offset: u64, size: u32, budget: &mut Budget, meta: &mut MetaData) -> Result<()> {
    let bytes = inflate(zipped, offset, u64::from(size), budget)?;
    let within = |error: Error| error.at(format!("meta data at byte {offset}, decompressed"));
    let mut fields = Fields::new(&bytes, 0);
    while !fields.is_empty() {
        let entry = Entry::read(&mut fields, budget).map_err(within)?;
        let value = fields.take(entry.size as usize).and_then(|value| MetaValue::read(entry.code, value, entry.offset));
        meta.insert(entry.key, value.map_err(within)?);
    }
    Ok(())
}

/// Reads entries with values of their own: `zipped` at `offset` names them, and their values follow in the file, in
/// `data` bytes.
pub(crate) fn read_large(
    file: &[u8],
    (offset, zipped, size, data): (u64, u32, u32, u64),
    budget: &mut Budget,
    meta: &mut MetaData,
) -> Result<()> {
    let bytes = inflate(section(file, offset, u64::from(zipped), "large meta data")?, offset, u64::from(size), budget)?;
    let within = |error: Error| error.at(format!("large meta data at byte {offset}, decompressed"));
    let mut fields = Fields::new(&bytes, 0);
    let start = offset + u64::from(zipped);
    let mut values = Fields::new(section(file, start, data, "large meta data")?, start);
    while !fields.is_empty() {
        let entry = Entry::read(&mut fields, budget).map_err(within)?;
        let zipped = fields.u32().map_err(within)?;
        let at = values.offset();
        // The decompressed bytes are let go when the value is made.
        let mut scratch = Budget::new(budget.left());
        let bytes = inflate(values.take(zipped as usize)?, at, u64::from(entry.size), &mut scratch)?;
        meta.insert(entry.key, MetaValue::read(entry.code, &bytes, at)?);
    }
    Ok(())
}

/// Values above so many bytes are stored apart, so that readers can leave them out.
const LARGE: usize = 1024;

/// Blocks of meta data as they are stored.
#[derive(Debug, Default)]
pub(crate) struct Stored {
    /// Small entries, compressed, and their bytes before.
    pub small: (Vec<u8>, u32),
    /// Names of the large entries, compressed, and their bytes before.
    pub large: (Vec<u8>, u32),
    /// Their values.
    pub values: Vec<u8>,
}

/// Makes the blocks of `meta`.
pub(crate) fn write(meta: &MetaData) -> Result<Stored> {
    let (mut small, mut large, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (key, value) in meta {
        let bytes = value.bytes();
        if bytes.len() > LARGE {
            Entry::write(key, value, bytes.len(), &mut large)?;
            let zipped = deflate(&bytes)?;
            large.extend((zipped.len() as u32).to_le_bytes());
            values.extend(zipped);
        } else {
            Entry::write(key, value, bytes.len(), &mut small)?;
            small.extend(bytes);
        }
    }
    let zip = |bytes: Vec<u8>| {
        let size = u32::try_from(bytes.len())
            .map_err(|_| Error::unsupported("there is too much meta data").advise("store less"))?;
        Ok((if bytes.is_empty() { Vec::new() } else { deflate(&bytes)? }, size))
    };
    Ok(Stored { small: zip(small)?, large: zip(large)?, values })
}
