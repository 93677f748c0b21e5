//! Reads a grid of points: see [`super::points`] for how its values lie, and below for how Blosc packs them. Then values of
//! leaves are one after the other in pages, whose lengths come where plain attributes have nothing.

use relievo_core::{Budget, Error, Result};

use super::points::{PLACE, PLAIN, STRIDED, UNIFORM};
use super::reader::{Entry, Head, damaged, entries, metadata, text, u32};
use super::tree::Tree;
use super::{LEAF, POINTS, blosc};
use crate::bgeo::{KNOWN, NUMBER, RADIUS, TIME};
use crate::bytes::Bytes;
use crate::particles::{Channel, MAX, MAX_CHANNELS, Particles};
use crate::read::Read;

/// Values lie in pages.
const PAGED: u8 = 8;
/// Bytes before the values of an attribute that are counted with them.
const COUNTED: u64 = 6;

/// The attributes of a grid.
struct Attribute {
    name: String,
    kind: String,
    codec: String,
    leaves: Vec<Part>,
    pages: Vec<[u32; 2]>,
}

/// What a leaf has of an attribute.
struct Part {
    bytes: u64,
    form: u8,
    points: u32,
    stride: u32,
}

/// Reads the first grid of points of an OpenVDB file. `memory_limit` bounds in bytes what is allocated for it. Attributes of
/// other kinds than numbers and vectors of them are left out with a note.
///
/// # Errors
/// Fails with `Invalid` if the file is damaged or has no grid of points, with `Unsupported` if it is of another version
/// or the points have what is not read, and with `Memory` above the limit.
pub fn read_vdb_points(bytes: &[u8], memory_limit: u64) -> Result<Read> {
    let mut budget = Budget::new(memory_limit);
    let mut entries = entries(bytes)?;
    let Some(at) = entries.iter().position(|entry| entry.kind == POINTS) else {
        return Err(
            Error::invalid("the file has no grid of points").advise("particles are read from such a grid alone")
        );
    };
    let mut read = Read::default();
    for other in entries.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, entry)| entry) {
        read.notes.push(format!("the grid {:?} was left out", other.name));
    }
    let entry = entries.swap_remove(at);
    read.particles = grid(entry, &mut budget, &mut read.notes)?;
    read.particles.check()?;
    Ok(read)
}

fn grid(entry: Entry, budget: &mut Budget, notes: &mut Vec<String>) -> Result<Particles> {
    let mut bytes = entry.bytes;
    let head = Head::read(&mut bytes)?;
    let leaves = Tree::read(&mut bytes, &head, false, budget)?.leaves;
    let passes = u16::from_le_bytes(bytes.array()?);
    bytes.take(2 * leaves.len() as u64)?;
    let mut attributes = if leaves.is_empty() { Vec::new() } else { attributes(&mut bytes, leaves.len(), budget)? };
    if !leaves.is_empty() && usize::from(passes) != 4 + 2 * attributes.len() {
        return Err(damaged("it has not as many passes as attributes need"));
    }
    for attribute in &mut attributes {
        attribute.read_pages(&mut bytes, budget)?;
    }
    let mut ends: Vec<u32> = Vec::new();
    budget.reserve(&mut ends, LEAF.len() * leaves.len())?;
    for _ in &leaves {
        bytes.take(64)?;
        indices(&mut bytes, &mut ends, budget)?;
    }
    let ends: Vec<&[u32]> = ends.chunks_exact(LEAF.len()).collect();
    let counts: Vec<u32> = ends.iter().map(|ends| ends[LEAF.len() - 1]).collect();
    let all: u64 = counts.iter().map(|count| u64::from(*count)).sum();
    if all > MAX || ends.iter().any(|ends| !ends.is_sorted()) {
        return Err(damaged("points of voxels are not one after the other"));
    }
    let mut particles = Particles::default();
    let time = head.metadata(TIME).and_then(|value| value.try_into().ok());
    particles.time = time.map(f64::from_le_bytes).filter(|time| time.is_finite());
    let mut radius = None;
    for attribute in &attributes {
        let points = attribute.leaves.iter().map(|part| part.points);
        if !points.eq(counts.iter().copied()) {
            return Err(damaged("an attribute has not a value for each point").at(format!("{:?}", attribute.name)));
        }
        let values = attribute.values(&mut bytes, budget)?;
        let Some((width, values)) = values else {
            notes.push(format!("the attribute {:?} was left out: its values are no numbers", attribute.name));
            continue;
        };
        match attribute.name.as_str() {
            PLACE if width == 3 => places(&head, &leaves, &ends, &values, &mut particles, budget)?,
            // What is the same everywhere is the radius of all.
            RADIUS if width == 1 && values.windows(2).all(|pair| pair[0] == pair[1]) => {
                radius = values.first().copied()
            }
            NUMBER if width == 1 && values.iter().all(|value| *value >= 0.0 && value.fract() == 0.0) => {
                let mut numbers = Vec::new();
                budget.reserve(&mut numbers, values.len())?;
                numbers.extend(values.iter().map(|value| *value as u32));
                particles.numbers = Some(numbers);
            }
            name if particles.channels.len() < MAX_CHANNELS => {
                let known = KNOWN.iter().find(|(theirs, _, size)| name == *theirs && width == *size as usize);
                let name = known.map_or(name, |(_, ours, _)| ours).to_owned();
                let mut narrow = Vec::new();
                budget.reserve(&mut narrow, values.len())?;
                narrow.extend(values.iter().map(|value| *value as f32));
                particles.channels.push(Channel { name, width: width as u32, values: narrow });
            }
            name => notes.push(format!("the attribute {name:?} was left out: there are too many")),
        }
    }
    if particles.points.len() as u64 != all {
        return Err(damaged("points have no places"));
    }
    particles.spacing = radius.map(|radius| (2.0 * radius) as f32).filter(|spacing| *spacing > 0.0);
    Ok(particles)
}

/// What attributes there are, and what each leaf has of them.
fn attributes(bytes: &mut Bytes, leaves: usize, budget: &mut Budget) -> Result<Vec<Attribute>> {
    let mut list: Vec<Attribute> = Vec::new();
    let mut is_shared = false;
    for leaf in 0..leaves {
        if leaf == 0 || !is_shared {
            let [header] = bytes.array()?;
            if leaf > 0 || header > 3 {
                return Err(
                    Error::unsupported("its leaves have attributes of their own").advise("give all points the same")
                );
            }
            is_shared = header & 1 == 1;
            list = descriptor(bytes)?;
            if header & 2 == 2 {
                let skipped = u64::from_le_bytes(bytes.array()?);
                bytes.take(skipped)?;
            }
        }
        for attribute in &mut list {
            let length = u64::from_le_bytes(bytes.array()?);
            let [_, form] = bytes.array()?;
            let points = u32(bytes)?;
            let stride = if form & STRIDED == 0 { 1 } else { u32(bytes)? };
            let length = length.checked_sub(COUNTED).filter(|_| form < 16);
            let length = length.ok_or_else(|| damaged("an attribute has a form that is not known"))?;
            budget.push(&mut attribute.leaves, Part { bytes: length, form, points, stride })?;
        }
    }
    Ok(list)
}

fn descriptor(bytes: &mut Bytes) -> Result<Vec<Attribute>> {
    let count = u64::from_le_bytes(bytes.array()?);
    if count > MAX_CHANNELS as u64 {
        return Err(Error::unsupported(format!("points have {count} attributes")).advise("remove some"));
    }
    let kinds: Vec<(String, String)> = (0..count).map(|_| Ok((text(bytes)?, text(bytes)?))).collect::<Result<_>>()?;
    let attribute =
        |(kind, codec)| Attribute { name: String::new(), kind, codec, leaves: Vec::new(), pages: Vec::new() };
    let mut list: Vec<Attribute> = kinds.into_iter().map(attribute).collect();
    for _ in 0..count {
        let name = text(bytes)?;
        let number = usize::try_from(u64::from_le_bytes(bytes.array()?)).ok();
        match number.and_then(|number| list.get_mut(number)) {
            Some(attribute) => attribute.name = name,
            None => return Err(damaged("a name is of no attribute")),
        }
    }
    let groups = u64::from_le_bytes(bytes.array()?);
    for _ in 0..groups {
        text(bytes)?;
        bytes.take(8)?;
    }
    metadata(bytes)?;
    Ok(list)
}

/// Of each voxel of a leaf where its points end.
fn indices(bytes: &mut Bytes, ends: &mut Vec<u32>, budget: &mut Budget) -> Result<()> {
    let length = u16::from_le_bytes(bytes.array()?);
    let unpacked;
    let plain = if length == PLAIN {
        bytes.take(4 * LEAF.len() as u64)?
    } else {
        unpacked = blosc::unpack(bytes.take(length.into())?, 4 * LEAF.len(), budget)?;
        &unpacked
    };
    ends.extend(plain.as_chunks().0.iter().map(|end| u32::from_le_bytes(*end)));
    Ok(())
}

/// Adds where points are: as far from the middles of their voxels as they say.
fn places(
    head: &Head,
    leaves: &[([i32; 3], [u8; 64])],
    ends: &[&[u32]],
    values: &[f64],
    particles: &mut Particles,
    budget: &mut Budget,
) -> Result<()> {
    budget.reserve(&mut particles.points, values.len() / 3)?;
    let mut within = values.as_chunks::<3>().0.iter();
    for ((origin, _), ends) in leaves.iter().zip(ends) {
        let mut begin = 0;
        for (child, end) in ends.iter().enumerate() {
            let voxel = LEAF.origin(*origin, child);
            for place in within.by_ref().take((end - begin) as usize) {
                let at = [0, 1, 2].map(|axis| f64::from(voxel[axis]) + place[axis]);
                particles.points.push([0, 1, 2].map(|axis| {
                    let [x, y, z, origin] = &head.transform;
                    (at[0] * x[axis] + at[1] * y[axis] + at[2] * z[axis] + origin[axis]) as f32
                }));
            }
            begin = *end;
        }
    }
    Ok(())
}

impl Attribute {
    /// Reads the lengths of pages, packed and unpacked.
    fn read_pages(&mut self, bytes: &mut Bytes, budget: &mut Budget) -> Result<()> {
        let mut left = 0;
        for part in self.leaves.iter().filter(|part| part.form & PAGED != 0) {
            if left == 0 {
                let packed = i32::from_le_bytes(bytes.array()?);
                let unpacked = if packed > 0 { i32::from_le_bytes(bytes.array()?) } else { packed.saturating_neg() };
                left = u64::try_from(unpacked).map_err(|_| damaged("a page has no length"))?;
                budget.push(&mut self.pages, [packed.max(0) as u32, left as u32])?;
            }
            left = left.checked_sub(part.bytes).ok_or_else(|| damaged("values are in two pages"))?;
        }
        Ok(())
    }

    /// The type of a number of a value, how many bytes it has in the file, and how many there are; `None` for what is no
    /// number.
    fn layout(&self) -> Option<(Number, usize)> {
        let (number, count) = match self.kind.as_str() {
            "float" => (Number::Float, 1),
            "double" => (Number::Double, 1),
            "int32" => (Number::Int32, 1),
            "int64" => (Number::Int64, 1),
            "int16" => (Number::Int16, 1),
            "int8" | "bool" => (Number::Int8, 1),
            "vec3s" => (Number::Float, 3),
            "vec3d" => (Number::Double, 3),
            "vec3i" => (Number::Int32, 3),
            "quats" => (Number::Float, 4),
            "quatd" => (Number::Double, 4),
            _ => return None,
        };
        let number = match (self.codec.as_str(), number) {
            ("null", number) => number,
            ("trnc", Number::Float) => Number::Half,
            ("trnc", Number::Double) => Number::Float,
            ("trnc", Number::Int32) => Number::Int16,
            ("fxpt8", Number::Float | Number::Double) => Number::Fixed8(0.5),
            ("fxpt16", Number::Float | Number::Double) => Number::Fixed16(0.5),
            ("ufxpt8", Number::Float | Number::Double) => Number::Fixed8(0.0),
            ("ufxpt16", Number::Float | Number::Double) => Number::Fixed16(0.0),
            _ => return None,
        };
        Some((number, count))
    }

    /// Numbers of all points, and how many a point has; `None`, and they are passed over, if they are no numbers.
    fn values(&self, bytes: &mut Bytes, budget: &mut Budget) -> Result<Option<(usize, Vec<f64>)>> {
        let layout = self.layout();
        let stride = self.leaves.first().map_or(1, |part| part.stride) as usize;
        let width = layout.map_or(0, |(_, count)| count.saturating_mul(stride));
        let is_known = (1..=4).contains(&width) && self.leaves.iter().all(|part| part.stride as usize == stride);
        let mut out = Vec::new();
        if is_known {
            let points: usize = self.leaves.iter().map(|part| part.points as usize).sum();
            budget.reserve(&mut out, width.saturating_mul(points))?;
        }
        let mut pages = self.pages.iter();
        let mut page = Vec::new();
        let mut at = 0;
        for part in &self.leaves {
            let is_uniform = part.form & UNIFORM != 0;
            let unpacked;
            let plain: &[u8] = if part.form & PAGED != 0 {
                if at == page.len() {
                    let [packed, length] = *pages.next().ok_or_else(|| damaged("a page is not there"))?;
                    page = match packed {
                        0 => bytes.take(length.into())?.to_vec(),
                        _ => blosc::unpack(bytes.take(packed.into())?, length as usize, budget)?,
                    };
                    at = 0;
                }
                let end = usize::try_from(part.bytes).ok().and_then(|length| at.checked_add(length));
                let range = end.and_then(|end| page.get(at..end)).ok_or_else(|| damaged("a page is too short"))?;
                at += range.len();
                range
            } else {
                let is_packed = !is_uniform && bytes.array::<1>()? == [1];
                let taken = bytes.take(part.bytes)?;
                match layout.filter(|_| is_packed && is_known) {
                    Some((number, _)) => {
                        let length = (part.points as usize).saturating_mul(width * number.size());
                        unpacked = blosc::unpack(taken, length, budget)?;
                        &unpacked
                    }
                    None => taken,
                }
            };
            let Some((number, _)) = layout.filter(|_| is_known) else { continue };
            let count = if is_uniform { width / stride } else { part.points as usize * width };
            if plain.len() != count * number.size() {
                return Err(damaged("an attribute is not as long as it should be").at(format!("{:?}", self.name)));
            }
            let numbers = plain.chunks_exact(number.size()).map(|bytes| number.value(bytes));
            match is_uniform {
                true => out.extend(numbers.cycle().take(part.points as usize * width)),
                false => out.extend(numbers),
            }
        }
        Ok(is_known.then_some((width, out)))
    }
}

/// How a number is kept.
#[derive(Clone, Copy)]
enum Number {
    Half,
    Float,
    Double,
    Int8,
    Int16,
    Int32,
    Int64,
    /// Of a range of 1, less so much.
    Fixed8(f64),
    Fixed16(f64),
}

impl Number {
    fn size(self) -> usize {
        match self {
            Self::Int8 | Self::Fixed8(_) => 1,
            Self::Half | Self::Int16 | Self::Fixed16(_) => 2,
            Self::Float | Self::Int32 => 4,
            Self::Double | Self::Int64 => 8,
        }
    }

    /// The number of as many bytes as its size.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut all = [0; 8];
        all[..bytes.len()].copy_from_slice(bytes);
        let [a, b, c, d, ..] = all;
        match self {
            Self::Half => half::f16::from_le_bytes([a, b]).to_f64(),
            Self::Float => f32::from_le_bytes([a, b, c, d]).into(),
            Self::Double => f64::from_le_bytes(all),
            Self::Int8 => i8::from_le_bytes([a]).into(),
            Self::Int16 => i16::from_le_bytes([a, b]).into(),
            Self::Int32 => i32::from_le_bytes([a, b, c, d]).into(),
            Self::Int64 => i64::from_le_bytes(all) as f64,
            Self::Fixed8(less) => f64::from(a) / 255.0 - less,
            Self::Fixed16(less) => f64::from(u16::from_le_bytes([a, b])) / 65_535.0 - less,
        }
    }
}
