//! What inputs of edits are in a journal.
//!
//! Numbers are little-endian, reals by their bits. An input: the cut of the mesh that is edited in two numbers of four bytes;
//! what it is, 0 or 1; of a mesh that is made for a view 2 more, and then, instead of its cut, which splits and base vertices
//! it has, a bit each, compressed, after how many bytes these are (four bytes). Of handles (0) how many there are (four bytes), each with its region, translation, axis and angle, and
//! the same of anchors. Of a stroke (1) its mode (one byte), height, falloff, settings in the order of their table (eight bytes
//! each), three curves, points, and its image: none (0), in it (1), or where the input is that has it (2).

use std::sync::Arc;

use glam::DVec3;
use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Falloff, Parameter, Result};
use relievo_detail::{
    Action, Curve, PressureCurves, SculptMode, Stamp, StampChannel, StampImage, StampSettings, Stroke, StrokePoint,
    StrokeSettings,
};
use relievo_document::code::{Decoder, Encoder};
use relievo_document::record::Location;

use crate::progressive::build::cut::{Cut, Front, ViewSplits};
use crate::progressive::edit::handle::{Edit, Handle, Region};

const HANDLES: u8 = 0;
const STROKE: u8 = 1;
/// Of a mesh that is made for a view.
const VIEW: u8 = 2;
/// Where the image of a stroke is, if there is one.
const HERE: u8 = 1;
const AT: u8 = 2;
/// The level of zstd for images.
const LEVEL: i32 = 1;

/// What an edit by handles is going to be.
pub fn edit(front: &Front, edit: &Edit) -> Result<Vec<u8>> {
    let mut out = begun(front, HANDLES)?;
    put_edit(&mut out, edit);
    Ok(out.0)
}

/// What a stroke is going to be. `known` is where its image is, if that is in an input already.
pub fn stroke(front: &Front, stroke: &Stroke, action: (SculptMode, f32), known: Option<Location>) -> Result<Vec<u8>> {
    let mut out = begun(front, STROKE)?;
    put_stroke(&mut out, stroke, action)?;
    match &stroke.stamp {
        Some(stamp) => put_stamp(&mut out, stamp, known)?,
        None => out.0.push(0),
    }
    Ok(out.0)
}

fn begun(front: &Front, tag: u8) -> Result<Encoder> {
    let mut out = Encoder(Vec::new());
    match front {
        Front::Cut(cut) => {
            let (key, split) = cut.parts();
            out.u32(key);
            out.u32(split);
            out.0.push(tag);
        }
        Front::View(splits) => {
            out.u64(0);
            out.0.push(tag | VIEW);
            let bytes: Vec<u8> = splits.0.iter().flat_map(|word| word.to_le_bytes()).collect();
            put_packed(&mut out, &bytes)?;
        }
    }
    Ok(out)
}

/// The mesh that is edited, which has so many vertices at most, and whether by a stroke.
pub fn take_front(from: &mut Decoder, vertices: usize) -> Result<(Front, bool)> {
    let (cut, tag) = (Cut::of_parts((from.u32()?, from.u32()?)), from.u8()?);
    if tag > STROKE | VIEW {
        return Err(damaged());
    }
    if tag & VIEW == 0 {
        return Ok((Front::Cut(cut), tag & STROKE != 0));
    }
    let mut bytes = vec![0; 8 * vertices.div_ceil(64)];
    take_packed(from, &mut bytes)?;
    let words = bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect();
    Ok((Front::View(ViewSplits(words)), tag & STROKE != 0))
}

fn put_packed(out: &mut Encoder, bytes: &[u8]) -> Result<()> {
    let packed = zstd::bulk::compress(bytes, LEVEL)
        .map_err(|error| Error::internal(format!("an edit cannot be compressed: {error}")))?;
    out.u32(packed.len() as u32);
    out.0.extend(packed);
    Ok(())
}

fn take_packed(from: &mut Decoder, bytes: &mut [u8]) -> Result<()> {
    let length = from.u32()?;
    let packed = from.bytes(length as usize)?;
    if zstd::bulk::decompress_to_buffer(packed, bytes).ok() != Some(bytes.len()) {
        return Err(damaged());
    }
    Ok(())
}

pub fn damaged() -> Error {
    Error::invalid("the journal is damaged").advise("move it away to begin another one")
}

fn put_floats<const N: usize>(out: &mut Encoder, values: [f32; N]) {
    values.into_iter().for_each(|value| out.u32(value.to_bits()));
}

fn floats<const N: usize>(from: &mut Decoder) -> Result<[f32; N]> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = f32::from_bits(from.u32()?);
    }
    Ok(values)
}

fn real(from: &mut Decoder) -> Result<f64> {
    from.u64().map(f64::from_bits)
}

/// A number of things, each of which takes so many bytes.
fn count(from: &mut Decoder, bytes: u64) -> Result<u32> {
    let count = from.u32()?;
    from.expect(u64::from(count) * bytes)?;
    Ok(count)
}

/// Numbers of a table, each as it reads.
fn put_settings(out: &mut Encoder, table: &[Parameter], get: impl Fn(&str) -> Result<f64>) -> Result<()> {
    for parameter in table {
        out.u64(get(parameter.name)?.to_bits());
    }
    Ok(())
}

fn put_region(out: &mut Encoder, region: &Region) {
    put_floats(out, region.center);
    put_floats(out, [region.radius]);
    out.0.push(region.falloff as u8);
}

fn take_region(from: &mut Decoder) -> Result<Region> {
    let (center, [radius]) = (floats(from)?, floats(from)?);
    Ok(Region { center, radius, falloff: take_falloff(from)? })
}

fn take_falloff(from: &mut Decoder) -> Result<Falloff> {
    Ok(Falloff::NAMES.get(usize::from(from.u8()?)).ok_or_else(damaged)?.0)
}

fn put_edit(out: &mut Encoder, edit: &Edit) {
    out.u32(edit.handles.len() as u32);
    for handle in &edit.handles {
        put_region(out, &handle.region);
        put_floats(out, handle.translation);
        put_floats(out, handle.axis);
        put_floats(out, [handle.angle]);
    }
    out.u32(edit.anchors.len() as u32);
    edit.anchors.iter().for_each(|anchor| put_region(out, anchor));
}

pub fn take_edit(from: &mut Decoder) -> Result<Edit> {
    let handle = |from: &mut Decoder| -> Result<Handle> {
        let (region, translation, axis, [angle]) = (take_region(from)?, floats(from)?, floats(from)?, floats(from)?);
        Ok(Handle { region, translation, axis, angle })
    };
    let handles = (0..count(from, 45)?).map(|_| handle(from)).collect::<Result<_>>()?;
    let anchors = (0..count(from, 17)?).map(|_| take_region(from)).collect::<Result<_>>()?;
    Ok(Edit { handles, anchors })
}

fn put_stroke(out: &mut Encoder, stroke: &Stroke, (mode, height): (SculptMode, f32)) -> Result<()> {
    out.0.push(mode as u8);
    put_floats(out, [height]);
    out.0.push(stroke.falloff as u8);
    put_settings(out, StrokeSettings::PARAMETERS, |name| stroke.settings.get(name))?;
    for curve in [&stroke.curves.size, &stroke.curves.strength, &stroke.curves.angle] {
        out.u32(curve.points().len() as u32);
        curve.points().as_flattened().iter().for_each(|value| out.u64(value.to_bits()));
    }
    out.u32(stroke.points.len() as u32);
    for point in &stroke.points {
        point.position.to_array().into_iter().for_each(|value| out.u64(value.to_bits()));
        out.u64(point.pressure.to_bits());
        out.0.push(u8::from(point.time.is_some()));
        out.u64(point.time.unwrap_or(0.0).to_bits());
    }
    Ok(())
}

/// A stroke without its image.
pub fn take_stroke(from: &mut Decoder) -> Result<Stroke> {
    let mode = SculptMode::NAMES.get(usize::from(from.u8()?)).ok_or_else(damaged)?.0;
    let ([height], falloff) = (floats(from)?, take_falloff(from)?);
    let mut settings = StrokeSettings::default();
    for parameter in StrokeSettings::PARAMETERS {
        settings.set(parameter.name, real(from)?)?;
    }
    let curve = |from: &mut Decoder| -> Result<Curve> {
        let points = (0..count(from, 16)?).map(|_| Ok([real(from)?, real(from)?])).collect::<Result<Vec<_>>>()?;
        if points.is_empty() { Ok(Curve::default()) } else { Curve::new(points) }
    };
    let curves = PressureCurves { size: curve(from)?, strength: curve(from)?, angle: curve(from)? };
    let point = |from: &mut Decoder| -> Result<StrokePoint> {
        let position = DVec3::new(real(from)?, real(from)?, real(from)?);
        let (pressure, has_time, time) = (real(from)?, from.u8()?, real(from)?);
        Ok(StrokePoint { position, pressure, time: (has_time != 0).then_some(time) })
    };
    let points = (0..count(from, 41)?).map(|_| point(from)).collect::<Result<_>>()?;
    Ok(Stroke { curves, ..Stroke::new(points, settings, falloff, Action::Sculpt { mode, height }) })
}

/// Where the image of a stroke is.
pub enum Image {
    /// In its input.
    Here(Arc<StampImage>),
    /// In the input at this place.
    At(Location),
}

fn put_stamp(out: &mut Encoder, stamp: &Stamp, known: Option<Location>) -> Result<()> {
    out.0.push(if known.is_some() { AT } else { HERE });
    out.0.push(stamp.channel() as u8);
    put_settings(out, StampSettings::PARAMETERS, |name| stamp.settings().get(name))?;
    if let Some(location) = known {
        out.u64(location.offset);
        out.u64(location.length);
        out.u32(location.crc);
        return Ok(());
    }
    let ([width, height], pixels) = stamp.image().pixels();
    let mut raw = Encoder(Vec::with_capacity(16 * pixels.len()));
    pixels.iter().for_each(|pixel| put_floats(&mut raw, *pixel));
    out.u32(width);
    out.u32(height);
    put_packed(out, &raw.0)
}

/// How the image of a stroke lies, and where it is.
pub fn take_stamp(context: &Context, from: &mut Decoder) -> Result<Option<(StampSettings, StampChannel, Image)>> {
    let place = from.u8()?;
    if place == 0 {
        return Ok(None);
    }
    let channel = StampChannel::NAMES.get(usize::from(from.u8()?)).ok_or_else(damaged)?.0;
    let mut settings = StampSettings::default();
    for parameter in StampSettings::PARAMETERS {
        settings.set(parameter.name, real(from)?)?;
    }
    if place == AT {
        let location = Location { offset: from.u64()?, length: from.u64()?, crc: from.u32()? };
        return Ok(Some((settings, channel, Image::At(location))));
    }
    let size = [from.u32()?, from.u32()?];
    StampImage::check_size(size[0], size[1], 4)?;
    let bytes = 16 * size[0] as usize * size[1] as usize;
    let mut raw = Budget::new(context.memory_limit()).filled(bytes, 0u8)?;
    take_packed(from, &mut raw)?;
    let mut raw = Decoder(&raw);
    let pixels = (0..bytes / 16).map(|_| floats(&mut raw)).collect::<Result<Vec<_>>>()?;
    Ok(Some((settings, channel, Image::Here(StampImage::of_pixels(size, pixels)?))))
}
