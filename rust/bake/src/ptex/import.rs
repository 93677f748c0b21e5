//! From a Ptex file to a channel: any type of numbers, any number of channels, any resolution.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use glam::Vec4;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Progress, Result};
use relievo_ptex::{DataType, MetaValue, Reader, Resolution};
use relievo_surface::{Surface, TileTopology};
use relievo_tiles::heap::{MAX_SIZE, MIN_SIZE};
use relievo_tiles::{Channel, ColorTexel, Displacement, Paint, Rgba8, Rgba16, VectorDisplacement};

use super::{COLOR, DEFAULT, DISPLACEMENT, KIND, VECTOR, adjacency};
use crate::prefilter::SplineTexel;
use crate::solve::{Target, solve};
use crate::{resample, restored};

/// What the texels of a file are to become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PtexKind {
    /// Scalar displacement in object units: the first number of a texel.
    Displacement,
    /// Vector displacement in object units: the first three numbers of a texel, along the tangent by u, across it and
    /// along the normal.
    Vector,
    /// Colour: grey, grey and alpha, RGB or RGB and alpha, as the number of channels says.
    Color,
}

/// How a file is read.
#[derive(Clone, Copy, Debug)]
pub struct PtexImport {
    /// What its texels are; `None` as its meta data says, or else displacement for one float and colour for all else.
    pub kind: Option<PtexKind>,
    /// Bytes that the channel may occupy.
    pub budget: u64,
    /// Whether colours become bytes whatever their numbers are in the file.
    pub eight_bits: bool,
}

/// The channel of a file.
#[derive(Debug)]
pub enum Imported {
    /// Scalar displacement.
    Displacement(Displacement),
    /// Vector displacement.
    Vector(VectorDisplacement),
    /// Colour of a file of bytes, which are sRGB-encoded.
    Rgba8(Paint<Rgba8>),
    /// Colour of a file of other numbers, which are linear.
    Rgba16(Paint<Rgba16>),
}

/// What became of the faces of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PtexReport {
    /// Faces of the file.
    pub faces: usize,
    /// Faces of one value.
    pub constant: usize,
    /// Faces that were not square and are now as wide as they were long.
    pub squared: usize,
    /// Faces that have fewer texels now: tiles have at most 256 a side, those of corners of polygons 128.
    pub reduced: usize,
    /// Faces that have more texels now: tiles have at least 8 a side.
    pub enlarged: usize,
    /// Channels of the file that were not taken.
    pub ignored: usize,
    /// Texels of colour in corners of faces that are another colour now: where other than four faces meet at a point, or
    /// faces of different sizes, each has the mean there, so that look-ups are continuous.
    pub averaged: usize,
    /// The most that a component of one of those texels changed by.
    pub largest_average: f32,
    /// The farthest that a value of the channel is from that of the file, relative to the largest; displacement alone.
    pub deviation: f32,
}

impl fmt::Display for PtexReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} faces, {} of them constant", self.faces, self.constant)?;
        let counts = [
            (self.squared, "made square"),
            (self.reduced, "reduced to the largest tiles"),
            (self.enlarged, "enlarged to the smallest tiles"),
        ];
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            write!(out, ", {count} {what}")?;
        }
        if self.ignored > 0 {
            write!(out, "; {} channels ignored", self.ignored)?;
        }
        if self.averaged > 0 {
            write!(
                out,
                "; {} texels in corners of faces are the mean of the faces at a point, by up to {:.3}",
                self.averaged, self.largest_average
            )?;
        }
        Ok(())
    }
}

/// The channel that `reader` holds for `surface`.
///
/// # Errors
/// Fails with `Invalid`, and what differs, if the faces of the file are not the tiles of the surface, it has too few
/// channels, or a texel is damaged, not finite or too large; with `Unsupported` if its faces are triangles; and with
/// `Memory` if the tiles do not fit the budget.
pub fn from_ptex<B: AsRef<[u8]> + Sync>(
    context: &Context,
    surface: &Surface,
    reader: &Reader<B>,
    options: &PtexImport,
) -> Result<(Imported, PtexReport)> {
    from_ptex_watched(context, surface, reader, options, &mut Silent)
}

/// As [`from_ptex`], telling `progress` of every few faces.
///
/// # Errors
/// Fails as [`from_ptex`] does, and with `Cancelled` if `progress` asks to stop.
pub fn from_ptex_watched<B: AsRef<[u8]> + Sync>(
    context: &Context,
    surface: &Surface,
    reader: &Reader<B>,
    options: &PtexImport,
    progress: &mut dyn Progress,
) -> Result<(Imported, PtexReport)> {
    let topology = surface.topology();
    adjacency::check(topology, reader)?;
    let format = reader.format();
    let kind = options.kind.or_else(|| stated(reader)).unwrap_or(match (format.channels, format.data_type) {
        (1, DataType::F16 | DataType::F32) => PtexKind::Displacement,
        _ => PtexKind::Color,
    });
    let mut report = PtexReport { faces: topology.tile_count(), ..PtexReport::default() };
    let imported = match (kind, format.data_type) {
        (PtexKind::Displacement, _) => {
            report.ignored = usize::from(format.channels) - 1;
            let source = Source { topology, reader, context };
            let made = Displacement::new(topology.clone(), &restored::options(source.face_sizes()?, options.budget))?;
            Imported::Displacement(displacement(&source, made, &mut report, progress)?)
        }
        (PtexKind::Vector, _) => {
            if format.channels < 3 {
                return Err(Error::invalid(format!("it has {} channels, and vectors have three", format.channels))
                    .advise("import it as another kind"));
            }
            report.ignored = usize::from(format.channels) - 3;
            let source = Source { topology, reader, context };
            let made = VectorDisplacement::on(surface, &restored::options(source.face_sizes()?, options.budget))?;
            Imported::Vector(displacement(&source, made, &mut report, progress)?)
        }
        (PtexKind::Color, data_type) => {
            report.ignored = usize::from(format.channels).saturating_sub(4);
            let source = Source { topology, reader, context };
            match data_type {
                _ if data_type == DataType::U8 || options.eight_bits => {
                    Imported::Rgba8(paint(&source, options.budget, &mut report, progress)?)
                }
                _ => Imported::Rgba16(paint(&source, options.budget, &mut report, progress)?),
            }
        }
    };
    Ok((imported, report))
}

/// What the file says its texels are.
fn stated<B: AsRef<[u8]>>(reader: &Reader<B>) -> Option<PtexKind> {
    match reader.meta().get(KIND)? {
        MetaValue::Text(text) if text == DISPLACEMENT => Some(PtexKind::Displacement),
        MetaValue::Text(text) if text == VECTOR => Some(PtexKind::Vector),
        MetaValue::Text(text) if text == COLOR => Some(PtexKind::Color),
        _ => None,
    }
}

/// A file and the tiles it is for.
struct Source<'a, B> {
    context: &'a Context,
    topology: &'a Arc<TileTopology>,
    reader: &'a Reader<B>,
}

impl<B: AsRef<[u8]> + Sync> Source<'_, B> {
    /// Texels along an edge of every face of the mesh: those of its longest tile, within what tiles may have.
    fn face_sizes(&self) -> Result<Vec<u32>> {
        let mut sizes = Vec::with_capacity(self.topology.face_count());
        for face in 0..self.topology.face_count() as u32 {
            let mut size = MIN_SIZE;
            for tile in self.topology.tiles_of(face) {
                let Resolution { u, v } = self.reader.face(tile)?.resolution;
                let own = 1u32 << u.max(v).min(Resolution::LARGEST);
                size = size.max(own << u32::from(self.topology.is_sub(tile)));
            }
            sizes.push(size.min(MAX_SIZE));
        }
        Ok(sizes)
    }

    fn count(&self, size_of: impl Fn(u32) -> u32, report: &mut PtexReport) -> Result<()> {
        for tile in (0..report.faces as u32).filter(|tile| !self.topology.is_hole(*tile)) {
            if self.reader.constant(tile).is_some() {
                report.constant += 1;
                continue;
            }
            let Resolution { u, v } = self.reader.face(tile)?.resolution;
            let (size, longest) = (size_of(tile), 1 << u.max(v));
            report.squared += usize::from(u != v);
            report.reduced += usize::from(size < longest);
            report.enlarged += usize::from(size > longest);
        }
        Ok(())
    }

    /// The numbers of a tile as `size` × `size` texels. Fails if one is not finite.
    fn values(&self, tile: u32, size: usize) -> Result<Vec<f32>> {
        let format = self.reader.format();
        let values = match self.reader.constant(tile) {
            Some(value) => format.data_type.decode(value).repeat(size * size),
            None => {
                let resolution = self.reader.face(tile)?.resolution;
                let values = format.data_type.decode(&self.reader.texels(tile)?);
                let (width, height) = (resolution.width(), resolution.height());
                if (width, height) == (size, size) {
                    values
                } else {
                    resample::square(&values, width, height, usize::from(format.channels), size)
                }
            }
        };
        if values.iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid("a texel is not a finite number")
                .at(format!("face {tile}"))
                .advise("repair the file in the program that wrote it"));
        }
        Ok(values)
    }

    /// As [`Self::values`] of colours as `T` keeps them.
    fn colors<T: ColorTexel>(&self, tile: u32, size: usize) -> Result<Vec<T>> {
        let channels = usize::from(self.reader.format().channels);
        let encoded = self.reader.format().data_type == DataType::U8;
        // The mean of what is encoded is not the encoded mean; bytes that stay are not to be rounded twice.
        let resolution = self.reader.face(tile)?.resolution;
        let whole = (resolution.width(), resolution.height()) == (size, size) || self.reader.constant(tile).is_some();
        let bytes = match self.reader.constant(tile) {
            _ if !encoded => return Ok(self.values(tile, size)?.chunks_exact(channels).map(of_numbers).collect()),
            Some(value) => value.repeat(size * size),
            None => self.reader.texels(tile)?,
        };
        let texels = bytes.chunks_exact(channels).map(|texel| Rgba8(of_bytes(texel)));
        if whole {
            return Ok(texels.map(|texel| T::of_color(texel.color())).collect());
        }
        let linear: Vec<f32> = texels.flat_map(|texel| texel.color().to_array()).collect();
        let square = resample::square(&linear, resolution.width(), resolution.height(), 4, size);
        Ok(square.chunks_exact(4).map(|color| T::of_color(Vec4::from_slice(color))).collect())
    }

    /// The tiles that hold something but `blank`, which is the value of a constant face.
    fn written(&self, blank: &[u8]) -> Vec<u32> {
        let tiles = 0..self.topology.tile_count() as u32;
        tiles.filter(|tile| !self.topology.is_hole(*tile) && self.reader.constant(*tile) != Some(blank)).collect()
    }

    /// What tiles without a block read as: what the file says, or the value that most constant faces have, of several
    /// the least.
    fn blank(&self) -> Option<Vec<u8>> {
        let format = self.reader.format();
        match self.reader.meta().get(DEFAULT) {
            Some(MetaValue::F32(values)) if values.len() == usize::from(format.channels) => {
                return Some(format.data_type.encode(values));
            }
            _ => {}
        }
        let mut counts = BTreeMap::new();
        for value in (0..self.topology.tile_count() as u32).filter_map(|tile| self.reader.constant(tile)) {
            *counts.entry(value).or_insert(0usize) += 1;
        }
        counts.into_iter().max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(a.0))).map(|(value, _)| value.to_vec())
    }
}

/// A texel of bytes as RGBA.
fn of_bytes(texel: &[u8]) -> [u8; 4] {
    match *texel {
        [grey] => [grey, grey, grey, 255],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    }
}

/// A texel of linear numbers as RGBA.
fn of_numbers<T: ColorTexel>(texel: &[f32]) -> T {
    T::of_color(match *texel {
        [grey] => Vec4::new(grey, grey, grey, 1.0),
        [grey, alpha] => Vec4::new(grey, grey, grey, alpha),
        [r, g, b] => Vec4::new(r, g, b, 1.0),
        [r, g, b, a, ..] => Vec4::new(r, g, b, a),
        [] => Vec4::ZERO,
    })
}

/// Colours of a file.
fn paint<T: ColorTexel, B: AsRef<[u8]> + Sync>(
    source: &Source<'_, B>,
    budget: u64,
    report: &mut PtexReport,
    progress: &mut dyn Progress,
) -> Result<Paint<T>> {
    let Source { context, topology, reader } = source;
    let (blank, tiles) = match source.blank() {
        Some(value) if reader.format().data_type == DataType::U8 => {
            (Rgba8(of_bytes(&value)).color(), source.written(&value))
        }
        Some(value) => {
            let texel: T = of_numbers(&reader.format().data_type.decode(&value));
            (texel.color(), source.written(&value))
        }
        None => (Vec4::ONE, source.written(&[])),
    };
    let mut paint = Paint::<T>::of_color((*topology).clone(), blank, &restored::options(source.face_sizes()?, budget))?;
    source.count(|tile| paint.field().size(tile), report)?;
    restored::allocate(&mut paint, &tiles)?;
    let field = paint.field().clone();
    let batches = tiles.len().div_ceil(BATCH);
    let mut corners: Vec<[Vec4; 4]> = Vec::with_capacity(tiles.len());
    for (batch, tiles) in tiles.chunks(BATCH).enumerate() {
        progress.step(batch as f32 / batches as f32, "ptex.read")?;
        let read =
            context.map(tiles.len(), |index| source.colors::<T>(tiles[index], field.size(tiles[index]) as usize));
        let read = read.into_iter().collect::<Result<Vec<_>>>()?;
        restored::fill(context, &mut paint, tiles, &read)?;
        corners.extend(tiles.iter().zip(&read).map(|(tile, texels)| corner_colors(texels, field.size(*tile), 0)));
    }
    restored::settle(context, &mut paint, &tiles)?;
    for (tile, before) in tiles.iter().zip(corners) {
        let Some(block) = paint.field().block(*tile) else { continue };
        for (before, after) in before.iter().zip(corner_colors(block, field.size(*tile), 1)) {
            let change = (*before - after).abs().max_element();
            report.averaged += usize::from(change > 0.0);
            report.largest_average = report.largest_average.max(change);
        }
    }
    Ok(paint)
}

/// Returns the colours in the corners of a tile of `size` texels a side, around which there are `ring` more.
fn corner_colors<T: ColorTexel>(texels: &[T], size: u32, ring: usize) -> [Vec4; 4] {
    let (size, stride) = (size as usize, size as usize + 2 * ring);
    let ends = [ring, ring + size - 1];
    [0, 1, 2, 3].map(|corner| texels[ends[corner / 2] * stride + ends[corner % 2]].color())
}

/// Tiles whose texels are held at a time.
const BATCH: usize = 256;

/// Gives `channel` the values of the file.
fn displacement<T: SplineTexel, B: AsRef<[u8]> + Sync>(
    source: &Source<'_, B>,
    mut channel: Channel<T>,
    report: &mut PtexReport,
    progress: &mut dyn Progress,
) -> Result<Channel<T>> {
    let Source { context, topology, reader } = source;
    let format = reader.format();
    source.count(|tile| channel.field().size(tile), report)?;
    let zero = |tile: &u32| {
        let value = reader.constant(*tile).map(|value| format.data_type.decode(value));
        value.is_some_and(|value| value.iter().take(T::NUMBERS).all(|number| *number == 0.0))
    };
    let tiles: Vec<u32> = (0..report.faces as u32).filter(|tile| !topology.is_hole(*tile) && !zero(tile)).collect();
    restored::allocate(&mut channel, &tiles)?;
    let field = channel.field();
    let read = context.map_watched(tiles.len(), progress, ("ptex.read", [0.0, 0.5]), |index| {
        let tile = tiles[index];
        let values = source.values(tile, field.size(tile) as usize)?;
        let texels = values.chunks_exact(usize::from(format.channels));
        let taken: Vec<f32> = texels.flat_map(|texel| &texel[..T::NUMBERS]).copied().collect();
        match taken.iter().copied().find(|value| value.abs() > LARGEST) {
            Some(value) => Err(Error::invalid(format!("a displacement of {value} is larger than tiles can hold"))
                .at(format!("face {tile}"))
                .advise(format!("use numbers up to {LARGEST}, or other units"))),
            None => Ok(taken),
        }
    })?;
    progress.step(0.5, "ptex.solve")?;
    let read = read.into_iter().collect::<Result<Vec<_>>>()?;
    // Half of what the numbers of the file are apart.
    let step = match format.data_type {
        DataType::U8 => 0.5 / 255.0,
        DataType::U16 => 0.5 / 65535.0,
        DataType::F16 | DataType::F32 => 0.0,
    };
    let target = Target { values: tiles.into_iter().zip(read).collect(), step };
    report.deviation = solve(context, &mut channel, target)?;
    Ok(channel)
}

/// The largest displacement: within half floats.
const LARGEST: f32 = 60_000.0;

impl Imported {
    /// Bytes of its blocks.
    pub fn bytes(&self) -> u64 {
        match self {
            Imported::Displacement(channel) => channel.bytes(),
            Imported::Vector(channel) => channel.bytes(),
            Imported::Rgba8(channel) => channel.bytes(),
            Imported::Rgba16(channel) => channel.bytes(),
        }
    }
}
