//! The header of a PLY file: its encoding and what rows of which properties follow.

use relievo_core::{Error, Result};

use crate::budget::Budget;
use crate::text::{Words, at_line, shown};

/// How the numbers behind the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a binary number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether it is an unsigned whole number.
    pub fn is_unsigned(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }
}

/// A named column of an element's rows.
#[derive(Clone, Debug)]
pub(crate) struct Property {
    pub name: String,
    /// For lists, the type of their length.
    pub length: Option<Kind>,
    /// The type of the number, or of the items of the list.
    pub kind: Kind,
}

/// A table of rows.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub name: String,
    pub rows: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that a row takes: in text a digit and a separator per number.
    pub fn row_bytes(&self, encoding: Encoding) -> u64 {
        let property = |property: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => property.length.unwrap_or(property.kind).size() as u64,
        };
        self.properties.iter().map(property).sum()
    }
}

/// What a header says.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Header {
    /// Reads the header; `words` is left behind it.
    pub fn read(words: &mut Words, budget: &mut Budget) -> Result<Self> {
        if words.next_in_line() != Some(b"ply") {
            return Err(
                at_line(Error::invalid("the file does not begin with `ply`"), 1).advise("check that it is a PLY file")
            );
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let more = words.next_line();
            let line = words.line();
            let keyword = words.next_in_line();
            if !more && keyword.is_none() {
                return Err(at_line(Error::invalid("the header has no `end_header`"), line)
                    .advise("the file is cut off; export it again"));
            }
            let mut word = || words.next_in_line().unwrap_or_default();
            match keyword {
                None | Some(b"comment" | b"obj_info") => {}
                Some(b"format") => {
                    encoding = Some(match word() {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::Little,
                        b"binary_big_endian" => Encoding::Big,
                        other => {
                            let what = format!("the format {} is not known", shown(other));
                            return Err(at_line(Error::unsupported(what), line)
                                .advise("use ascii, binary_little_endian or binary_big_endian"));
                        }
                    });
                }
                Some(b"element") => {
                    let name = word();
                    let count = word();
                    let rows = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                    let Some(rows) = rows.filter(|_| !name.is_empty()) else {
                        let what = format!("the element {} has no count: {}", shown(name), shown(count));
                        return Err(at_line(Error::invalid(what), line).advise("write `element NAME COUNT`"));
                    };
                    budget.charge(2 * name.len() as u64 + 256)?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    elements.push(Element { name, rows, properties: Vec::new() });
                }
                Some(b"property") => {
                    let first = word();
                    let (length, item) =
                        if first == b"list" { (Some(Kind::named(word())), word()) } else { (None, first) };
                    let name = word();
                    let kind = Kind::named(item);
                    let length = match length {
                        None => Some(None),
                        Some(None | Some(Kind::F32 | Kind::F64)) => None,
                        Some(known) => Some(known),
                    };
                    let (Some(kind), Some(length), false) = (kind, length, name.is_empty()) else {
                        return Err(at_line(Error::invalid("the property cannot be understood"), line)
                            .advise("write `property TYPE NAME` or `property list TYPE TYPE NAME`"));
                    };
                    let Some(element) = elements.last_mut() else {
                        return Err(at_line(Error::invalid("a property stands before any element"), line)
                            .advise("move it behind its element"));
                    };
                    budget.charge(2 * name.len() as u64 + 256)?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    element.properties.push(Property { name, length, kind });
                }
                Some(b"end_header") => {
                    words.next_line();
                    let encoding = encoding.ok_or_else(|| {
                        at_line(Error::invalid("the header has no `format`"), line).advise("add `format ascii 1.0`")
                    })?;
                    return Ok(Self { encoding, elements });
                }
                Some(other) => {
                    let what = format!("the header line {} is not known", shown(other));
                    return Err(at_line(Error::invalid(what), line).advise("check that it is a PLY file"));
                }
            }
        }
    }
}
