//! Writes particles as a grid of points: each lies in a leaf of 8³ voxels, as far from the middle of its voxel as it says, and
//! points of a leaf are in the order of their voxels.
//!
//! Values of leaves come in passes: how long indices are; what attributes there are, once, and of each leaf how many
//! values of each; the indices, of each voxel where its points end; and attribute after attribute, leaf after leaf.

use std::io::Write;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use super::{FARTHEST, Head, LEAF, POINTS, encode, text, topology};
use crate::bgeo::{KNOWN, NUMBER, RADIUS, TIME};
use crate::particles::{Channel, Particles};

/// Metres between voxels, in spacings of particles: some eight of them lie in a voxel then.
const VOXEL: f64 = 2.0;
/// The place of a point in its voxel.
pub(super) const PLACE: &str = "P";
/// Numbers are one for all of a leaf.
pub(super) const UNIFORM: u8 = 2;
/// A value has more than one number.
pub(super) const STRIDED: u8 = 1;
/// An array of constant stride.
const CONSTANT_STRIDE: u8 = 8;
/// Instead of the length of indices: they are not packed.
pub(super) const PLAIN: u16 = u16::MAX;

/// Points of a leaf: the number of its first in the order of the file, and of each voxel where its points end.
struct Leaf {
    first: usize,
    ends: Vec<u32>,
}

/// What an attribute has of each point.
enum Values<'a> {
    Places(Vec<[f32; 3]>),
    Floats(&'a [f32], usize),
    Numbers(&'a [u32]),
    Radius(f32),
}

struct Attribute<'a> {
    name: &'a str,
    values: Values<'a>,
}

/// Writes particles as OpenVDB's points: places to 2⁻²⁵ voxels of two spacings, `v` for the channel `velocity`, `Cd` for
/// `color`, `N` for `normal`, `id` for numbers, `pscale` for half of the spacing, others by their names; the time is in the
/// metadata of the grid.
///
/// # Errors
/// Fails, and leaves no file: as [`Particles::check`] does, with `Unsupported` if a particle is farther than 2³⁰ voxels
/// from 0, a number has more than 31 bits or two channels have one name there, and with `NotFound` or `Io` if the
/// system refuses.
pub fn write_vdb_points(context: &Context, path: &Path, particles: &Particles) -> Result<()> {
    let bytes = write(context, particles).map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| out.write_all(&bytes))
}

fn write(context: &Context, particles: &Particles) -> Result<Vec<u8>> {
    particles.check()?;
    if let Some(number) = particles.numbers.iter().flatten().find(|number| i32::try_from(**number).is_err()) {
        let error = Error::unsupported(format!("particle {number} has a number of more than 31 bits"));
        return Err(error.advise("write a cache or VTK"));
    }
    let voxel = voxel(particles);
    let at = |place: &[f32; 3]| place.map(|at| (f64::from(at) / voxel).round());
    if particles.points.iter().any(|place| at(place).iter().any(|at| at.abs() >= f64::from(FARTHEST))) {
        return Err(Error::unsupported("particles are more than 2³⁰ voxels from 0").advise("move them nearer"));
    }
    let voxels: Vec<[i32; 3]> = particles.points.iter().map(|place| at(place).map(|at| at as i32)).collect();
    let key = |point: &usize| (LEAF.around(voxels[*point]), LEAF.child(voxels[*point]));
    let mut sorted: Vec<usize> = (0..voxels.len()).collect();
    sorted.sort_by_key(key);
    let mut leaves: Vec<Leaf> = Vec::new();
    let mut masks: Vec<([i32; 3], [u8; 64])> = Vec::new();
    for (number, point) in sorted.iter().enumerate() {
        let (origin, child) = key(point);
        if masks.last().is_none_or(|(last, _)| *last != origin) {
            masks.push((origin, [0; 64]));
            leaves.push(Leaf { first: number, ends: vec![0; LEAF.len()] });
        }
        if let (Some((_, mask)), Some(leaf)) = (masks.last_mut(), leaves.last_mut()) {
            mask[child / 8] |= 1 << (child % 8);
            leaf.ends[child] += 1;
        }
    }
    for ends in leaves.iter_mut().map(|leaf| &mut leaf.ends) {
        (1..ends.len()).for_each(|child| ends[child] += ends[child - 1]);
    }
    let (topology, order) = topology(context, &masks, 0.0, &|_| false);
    let within = |point: &usize| {
        let (place, voxel_at) = (particles.points[*point], voxels[*point]);
        [0, 1, 2].map(|axis| (f64::from(place[axis]) / voxel - f64::from(voxel_at[axis])) as f32)
    };
    let places = Values::Places(sorted.iter().map(within).collect());
    let attributes = attributes(particles, places)?;
    let buffers = buffers(&attributes, &sorted, &leaves, &masks, &order);
    let mut metadata = vec![("creator", "string", b"Relievo".to_vec()), ("name", "string", b"particles".to_vec())];
    metadata.extend(particles.time.map(|time| (TIME, "double", time.to_le_bytes().to_vec())));
    let head = Head { name: "particles", kind: POINTS, metadata: &metadata, voxel };
    Ok(encode(&head, &topology, &buffers))
}

/// Edge of a voxel in metres.
fn voxel(particles: &Particles) -> f64 {
    if let Some(spacing) = particles.spacing {
        return VOXEL * f64::from(spacing);
    }
    let ends = |pick: fn(f32, f32) -> f32, from: f32| {
        particles.points.iter().fold([from; 3], |all, place| [0, 1, 2].map(|axis| pick(all[axis], place[axis])))
    };
    let (low, high) = (ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY));
    let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
    // As for a cube that is full of them.
    let voxel = VOXEL * longest / (particles.points.len() as f64).cbrt();
    if voxel > 0.0 { voxel.max(1e-6 * longest) } else { 1.0 }
}

fn attributes<'a>(particles: &'a Particles, places: Values<'a>) -> Result<Vec<Attribute<'a>>> {
    let mut list = vec![Attribute { name: PLACE, values: places }];
    let numbers = particles.numbers.as_deref();
    list.extend(numbers.map(|numbers| Attribute { name: NUMBER, values: Values::Numbers(numbers) }));
    list.extend(particles.channels.iter().map(|Channel { name, width, values }| {
        let known = KNOWN.iter().find(|(_, ours, size)| name == ours && width == size);
        Attribute { name: known.map_or(name, |(theirs, ..)| theirs), values: Values::Floats(values, *width as usize) }
    }));
    list.extend(particles.spacing.map(|it| Attribute { name: RADIUS, values: Values::Radius(0.5 * it) }));
    match (0..list.len()).find(|at| list[..*at].iter().any(|other| other.name == list[*at].name)) {
        Some(at) => {
            Err(Error::unsupported(format!("two attributes would be {:?}", list[at].name)).advise("rename one"))
        }
        None => Ok(list),
    }
}

impl Attribute<'_> {
    fn kind(&self) -> &'static str {
        match self.values {
            Values::Places(_) | Values::Floats(_, 3) => "vec3s",
            Values::Numbers(_) => "int32",
            Values::Floats(..) | Values::Radius(_) => "float",
        }
    }

    /// Floats of a value, where its type does not say so.
    fn stride(&self) -> u32 {
        match self.values {
            Values::Floats(_, width) if width != 3 => width as u32,
            _ => 1,
        }
    }

    /// How many values of so many points there are, as OpenVDB tells it.
    fn describe(&self, count: usize, out: &mut Vec<u8>) {
        let number = match self.kind() {
            "vec3s" => 12,
            _ => 4,
        };
        let is_uniform = matches!(self.values, Values::Radius(_));
        let stride = self.stride();
        let bytes = number * if is_uniform { 1 } else { count * stride as usize };
        // The flags and the number of points are counted too.
        out.extend((bytes as u64 + 6).to_le_bytes());
        let uniform = if is_uniform { UNIFORM } else { 0 };
        out.extend([CONSTANT_STRIDE, uniform | if stride > 1 { STRIDED } else { 0 }]);
        out.extend((count as u32).to_le_bytes());
        if stride > 1 {
            out.extend(stride.to_le_bytes());
        }
    }

    /// The values of points that are `from` to `to` in the order of the file.
    fn values(&self, sorted: &[usize], (from, to): (usize, usize), out: &mut Vec<u8>) {
        let points = &sorted[from..to];
        match &self.values {
            Values::Radius(radius) => out.extend(radius.to_le_bytes()),
            Values::Places(places) => {
                out.push(0);
                out.extend(places[from..to].as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            }
            Values::Floats(values, width) => {
                out.push(0);
                let values = points.iter().flat_map(|point| &values[point * width..][..*width]);
                out.extend(values.flat_map(|value| value.to_le_bytes()));
            }
            Values::Numbers(numbers) => {
                out.push(0);
                out.extend(points.iter().flat_map(|point| numbers[*point].to_le_bytes()));
            }
        }
    }
}

fn buffers(
    attributes: &[Attribute],
    sorted: &[usize],
    leaves: &[Leaf],
    masks: &[([i32; 3], [u8; 64])],
    order: &[usize],
) -> Vec<u8> {
    let count = |leaf: usize| leaves[leaf].ends[LEAF.len() - 1] as usize;
    let mut out = ((4 + 2 * attributes.len()) as u16).to_le_bytes().to_vec();
    out.extend(order.iter().flat_map(|_| PLAIN.to_le_bytes()));
    for (number, leaf) in order.iter().enumerate() {
        if number == 0 {
            // What follows is of all leaves.
            out.push(1);
            descriptor(attributes, &mut out);
        }
        attributes.iter().for_each(|attribute| attribute.describe(count(*leaf), &mut out));
    }
    for leaf in order {
        out.extend(masks[*leaf].1);
        out.extend(PLAIN.to_le_bytes());
        out.extend(leaves[*leaf].ends.iter().flat_map(|end| end.to_le_bytes()));
    }
    for attribute in attributes {
        for leaf in order {
            let first = leaves[*leaf].first;
            attribute.values(sorted, (first, first + count(*leaf)), &mut out);
        }
    }
    out
}

/// Types and codecs of attributes, their names with their numbers, and no groups and no metadata.
fn descriptor(attributes: &[Attribute], out: &mut Vec<u8>) {
    out.extend((attributes.len() as u64).to_le_bytes());
    for attribute in attributes {
        text(out, attribute.kind());
        text(out, "null");
    }
    let mut named: Vec<(&str, u64)> = attributes.iter().map(|attribute| attribute.name).zip(0..).collect();
    named.sort_unstable();
    for (name, number) in named {
        text(out, name);
        out.extend(number.to_le_bytes());
    }
    out.extend(0u64.to_le_bytes());
    out.extend(0u32.to_le_bytes());
}
