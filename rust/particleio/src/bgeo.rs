//! Particles of Houdini's classic geometry, `.bgeo` version 5, also packed by gzip as many programs write it. The form is
//! that of Side Effects' note on Houdini 11 and of what Partio (Disney 2010) writes.
//!
//! Big-endian: `BgeoV`, the version, counts of points, primitives, groups of both, and attributes of points, vertices,
//! primitives and the whole (i32 each); what attributes points have; of each point x, y, z, w and its attributes; and,
//! where there is no primitive, attributes of the whole. `v` or `velocity` is the channel `velocity`, `Cd` `color`, `N`
//! `normal`, `id` the particles' numbers; of the whole, `time` is the time, and `pscale` half of the spacing.

use std::borrow::Cow;
use std::io::Read as _;

use relievo_core::{Budget, Error, Result};

use crate::bytes::Bytes;
use crate::particles::{Channel, MAX_CHANNELS, Particles};
use crate::read::Read;

pub(crate) const MAGIC: &[u8] = b"Bgeo";
pub(crate) const GZIP: &[u8] = &[0x1f, 0x8b];
/// What binary geometry of Houdini 12 and later begins with.
const JSON: &[u8] = b"\x7fNSJ";
pub(crate) const VERSION: i32 = 5;
pub(crate) const FLOAT: i32 = 0;
pub(crate) const INTEGER: i32 = 1;
const NAMES: i32 = 4;
pub(crate) const VECTOR: i32 = 5;
/// Names of attributes that mean a channel of ours, with its width.
pub(crate) const KNOWN: [(&str, &str, u32); 3] = [("v", "velocity", 3), ("Cd", "color", 3), ("N", "normal", 3)];
pub(crate) const NUMBER: &str = "id";
pub(crate) const TIME: &str = "time";
pub(crate) const RADIUS: &str = "pscale";
/// Bytes that are unpacked at a time.
const PIECE: usize = 1 << 16;

/// Reads a classic `.bgeo` file. `memory_limit` bounds in bytes what is allocated for it. Attributes of other kinds, or of
/// more than four numbers, are left out with a note.
///
/// # Errors
/// Fails with `Invalid` if the file ends too early, cannot be unpacked or a number is not finite, with `Unsupported` if
/// it is of another version or of Houdini's newer form, and with `Memory` above the limit.
pub fn read_bgeo(bytes: &[u8], memory_limit: u64) -> Result<Read> {
    let mut budget = Budget::new(memory_limit);
    let unpacked = unpack(bytes, &mut budget)?;
    let mut bytes = Bytes(&unpacked);
    if let Some(error) = refusal(bytes.0) {
        return Err(error);
    }
    if bytes.take(4)? != MAGIC {
        return Err(Error::invalid("the file does not begin with `Bgeo`").advise("check that it is a .bgeo file"));
    }
    let version = (bytes.array::<1>()?, i32::from_be_bytes(bytes.array()?));
    if version != (*b"V", VERSION) {
        return Err(Error::unsupported(format!("it is of version {}", version.1)).advise("save it as version 5"));
    }
    let mut count = |what: &str| {
        let count = i32::from_be_bytes(bytes.array()?);
        u32::try_from(count).map_err(|_| Error::invalid(format!("there are {count} {what}")).advise("export it again"))
    };
    let (points, primitives) = (count("points")?, count("primitives")?);
    let (_, _) = (count("groups of points")?, count("groups of primitives")?);
    let attributes = count("attributes of points")?;
    let others = [count("attributes of vertices")?, count("attributes of primitives")?];
    let whole = count("attributes of the whole")?;
    let mut read = Read::default();
    let listed = Attributes::read(&mut bytes, attributes, 4, &mut read.notes)?;
    let rows = bytes.take(u64::from(points) * 4 * listed.stride as u64)?;
    read.particles = listed.particles(rows, points as usize, &mut budget)?;
    if primitives == 0 && others == [0, 0] {
        let listed = Attributes::read(&mut bytes, whole, 0, &mut read.notes)?;
        let row = bytes.take(4 * listed.stride as u64)?;
        read.particles.time = listed.float(row, TIME).map(f64::from);
        read.particles.spacing = listed.float(row, RADIUS).map(|radius| 2.0 * radius);
    } else {
        read.notes.push("primitives, and attributes of the whole, are left out".into());
    }
    read.particles.check()?;
    Ok(read)
}

/// What is in a file that may be packed by gzip.
fn unpack<'a>(bytes: &'a [u8], budget: &mut Budget) -> Result<Cow<'a, [u8]>> {
    if !bytes.starts_with(GZIP) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut stream = flate2::read::MultiGzDecoder::new(bytes);
    let mut unpacked = Vec::new();
    let mut piece = [0; PIECE];
    loop {
        let count = stream.read(&mut piece).map_err(|error| {
            Error::invalid(format!("it cannot be unpacked: {error}"))
                .advise("it is cut off or damaged; export it again")
        })?;
        if count == 0 {
            return Ok(Cow::Owned(unpacked));
        }
        budget.reserve_more(&mut unpacked, count)?;
        unpacked.extend_from_slice(&piece[..count]);
    }
}

/// An attribute, and where in a row its numbers are.
struct Attribute {
    name: String,
    kind: i32,
    width: usize,
    offset: usize,
}

/// Attributes of rows of so many numbers.
struct Attributes {
    list: Vec<Attribute>,
    stride: usize,
}

impl Attributes {
    /// Reads which attributes rows have beside their first `stride` numbers.
    fn read(bytes: &mut Bytes, count: u32, mut stride: usize, notes: &mut Vec<String>) -> Result<Self> {
        if count as usize > MAX_CHANNELS {
            return Err(Error::unsupported(format!("there are {count} attributes"))
                .advise(format!("use at most {MAX_CHANNELS}")));
        }
        let mut list = Vec::new();
        for _ in 0..count {
            let length = u16::from_be_bytes(bytes.array()?);
            let name = String::from_utf8_lossy(bytes.take(length.into())?).into_owned();
            let width = usize::from(u16::from_be_bytes(bytes.array()?));
            let kind = i32::from_be_bytes(bytes.array()?);
            match kind {
                FLOAT | INTEGER | VECTOR => drop(bytes.take(4 * width as u64)?),
                NAMES => {
                    for _ in 0..u32::from_be_bytes(bytes.array()?) {
                        let length = u16::from_be_bytes(bytes.array()?);
                        bytes.take(length.into())?;
                    }
                }
                other => {
                    return Err(Error::unsupported(format!("its kind {other} is not known"))
                        .at(format!("attribute {name:?}"))
                        .advise("leave it out of the export"));
                }
            }
            let offset = stride;
            stride += width;
            let is_taken = list.iter().any(|other: &Attribute| other.name == name);
            match () {
                () if is_taken => notes.push(format!("a second attribute {name:?} is left out")),
                () if kind == NAMES => notes.push(format!("the attribute {name:?} of texts is left out")),
                () if !(1..=4).contains(&width) || name.is_empty() || name.len() > 255 => {
                    notes.push(format!("the attribute {name:?} of {width} numbers is left out"));
                }
                () => list.push(Attribute { name, kind, width, offset }),
            }
        }
        Ok(Self { list, stride })
    }

    /// The particles of rows.
    fn particles(&self, rows: &[u8], count: usize, budget: &mut Budget) -> Result<Particles> {
        let rows = || rows.chunks_exact(4 * self.stride);
        let mut particles = Particles::default();
        budget.reserve(&mut particles.points, count)?;
        particles.points.extend(rows().map(|row| [0, 1, 2].map(|axis| f32::from_bits(word(row, axis)))));
        for attribute in &self.list {
            let Attribute { ref name, kind, width, offset } = *attribute;
            if name == NUMBER && kind == INTEGER && width == 1 {
                let mut numbers = Vec::new();
                budget.reserve(&mut numbers, count)?;
                numbers.extend(rows().map(|row| word(row, offset)));
                particles.numbers = Some(numbers);
                continue;
            }
            let known = KNOWN.iter().find(|(theirs, _, known)| theirs == name && *known as usize == width);
            let name = known.map_or(name.as_str(), |(_, ours, _)| ours).to_owned();
            if particles.channel(&name).is_some() {
                continue;
            }
            let mut values = Vec::new();
            budget.reserve(&mut values, count * width)?;
            let numbers = rows().flat_map(|row| (offset..offset + width).map(move |at| word(row, at)));
            match kind {
                INTEGER => values.extend(numbers.map(|number| number as i32 as f32)),
                _ => values.extend(numbers.map(f32::from_bits)),
            }
            particles.channels.push(Channel { name, width: width as u32, values });
        }
        Ok(particles)
    }

    /// The number called `name` of a row.
    fn float(&self, row: &[u8], name: &str) -> Option<f32> {
        let found = |attribute: &&Attribute| attribute.name == name && attribute.kind == FLOAT && attribute.width == 1;
        self.list.iter().find(found).map(|attribute| f32::from_bits(word(row, attribute.offset)))
    }
}

/// Number `at` of a row that has it.
fn word(row: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&row[4 * at..4 * at + 4]);
    u32::from_be_bytes(word)
}

/// Why a file that begins so is none of ours, where it is of a form that is known by name.
pub(crate) fn refusal(head: &[u8]) -> Option<Error> {
    let classic = "save it as .bgeo of the classic form (.bhclassic), or as PLY";
    if head.starts_with(JSON) {
        return Some(Error::unsupported("it is geometry of Houdini 12 or later, in binary JSON").advise(classic));
    }
    if head.starts_with(b"PGEOMETRY") {
        return Some(Error::unsupported("it is classic geometry of Houdini as text").advise(classic));
    }
    if head.starts_with(b"scf1") {
        return Some(Error::unsupported("it is geometry of Houdini packed by Blosc").advise(classic));
    }
    let text = head.trim_ascii_start();
    let is_json = text.strip_prefix(b"[").is_some_and(|rest| rest.trim_ascii_start().starts_with(b"\"fileversion\""));
    is_json.then(|| Error::unsupported("it is geometry of Houdini 12 or later, in JSON").advise(classic))
}
