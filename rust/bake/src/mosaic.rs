//! Layers of documents as pictures with reductions, for hosts that look textures up by picture coordinates.
//!
//! All tiles have cells of one size, in rows: tile t is in column t mod c and row t / c of c columns, so that a place
//! (tile, u, v) is found without a table. A cell is S texels a side, the most that a tile of the layer with a block has,
//! and a gutter of S/8 around them; level k has half as many of both, down to 8 and 1. So u and v stay where they are
//! from level to level, which a gutter of one texel would not do. In the gutter is what bilinear look-up needs: the
//! ring of the tile, and that repeated outwards. Tiles without a block have one value, smaller tiles are enlarged texel
//! by texel. Within a cell u goes to the right and v down: the first row is v = 0.
//!
//! Colours are linear and multiplied by alpha. Displacements are values at the centres of texels ([`crate::prefilter`]),
//! in object units, and beside an edge as far beyond its value as the last texel is before it, so that look-up gives
//! the value of the edge from both sides. Triangles of triangle meshes have cells too (`mosaic/faces.rs`). Units: texels;
//! object units; seconds.

mod faces;

use std::ops::Range;
use std::sync::Arc;

use half::f16;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_document::{Document, Kind, Layer};
use relievo_surface::{TileTopology, TriangleTopology};
use relievo_tiles::heap::{MAX_SIZE, MIN_SIZE};
use relievo_tiles::texel::Vector;
use relievo_tiles::trace::Trace;
use relievo_tiles::{Channel, ColorTexel, Field, Rgba8, Rgba16, StoredTexel};

use self::faces::Faces;
use crate::opened::{channel, composite, is_plain};
use crate::prefilter::{self, SplineTexel};

/// Where tiles are in a mosaic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Cells in a row.
    pub columns: u32,
    /// Rows of cells.
    pub rows: u32,
    /// Texels along a tile, without the gutter.
    pub side: u32,
}

impl Cells {
    /// Cells for so many tiles of at most `side` texels, as many in a row as there are rows.
    pub fn of(tiles: u32, side: u32) -> Self {
        let columns = f64::from(tiles).sqrt().ceil().max(1.0) as u32;
        let side = side.clamp(MIN_SIZE, MAX_SIZE).next_power_of_two();
        Self { columns, rows: tiles.div_ceil(columns).max(1), side }
    }

    /// Number of levels, the full one included.
    pub fn levels(&self) -> u32 {
        self.side.ilog2() - MIN_SIZE.ilog2() + 1
    }

    /// Texels of the gutter of a level.
    pub fn gutter(&self, level: u32) -> u32 {
        self.side >> level >> 3
    }

    /// Texels along a cell of a level, gutters included.
    pub fn cell(&self, level: u32) -> u32 {
        (self.side >> level) + 2 * self.gutter(level)
    }

    /// Width and height of a level.
    pub fn size(&self, level: u32) -> [u32; 2] {
        // At most 2¹⁶ columns of 320 texels.
        [self.columns * self.cell(level), self.rows * self.cell(level)]
    }
}

/// What a mosaic is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tesserae {
    /// Linear red, green, blue, multiplied by alpha, and alpha: four half floats.
    Colors,
    /// Displacement along the normal: a float.
    Heights,
    /// Along the tangent by u, across it, and along the normal: three floats.
    Vectors,
    /// Contact, depth, and the time of the last push, −1 where nothing ever touched: three floats.
    Traces,
}

impl Tesserae {
    /// What layers of `kind` are shown as; `None` if they are not.
    pub fn of(kind: Kind) -> Option<Self> {
        match kind {
            Kind::Rgba8 | Kind::Rgba16 => Some(Self::Colors),
            Kind::Scalar => Some(Self::Heights),
            Kind::Vector => Some(Self::Vectors),
            Kind::Trace => Some(Self::Traces),
            Kind::Stamps => None,
        }
    }

    /// Numbers of a pixel.
    pub fn channels(self) -> usize {
        match self {
            Self::Colors => 4,
            Self::Heights => 1,
            Self::Vectors | Self::Traces => 3,
        }
    }

    /// Bytes of a number.
    pub fn number_size(self) -> usize {
        if self == Self::Colors { 2 } else { 4 }
    }

    /// Bytes of a pixel.
    pub fn pixel_size(self) -> usize {
        self.channels() * self.number_size()
    }
}

/// What of a document a mosaic shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// What its pixels are.
    pub kind: Tesserae,
    /// Indices of layers, from the lowest; several are seen together.
    pub layers: Vec<usize>,
    /// Whether it is one layer as it is, whatever its opacity and blend mode.
    pub is_alone: bool,
    /// Where tiles are.
    pub cells: Cells,
}

/// What a document can show: of every kind what its layers come to, and then each of them if that is not the same;
/// colours come first. Layers of a kind that are kept in different formats are shown one by one.
///
/// # Errors
/// Fails with `Invalid` if the document has no layers that are pictures.
pub fn shown(document: &Document) -> Result<Vec<Shown>> {
    let topology = document.topology();
    let tiles = tile_count(document);
    let side = |layer: &Layer| {
        if topology.is_of_triangles() {
            return faces::segments(layer).unwrap_or(MIN_SIZE);
        }
        let of_tile = |tile: u32| {
            let (face, is_part) = topology.face_of(tile)?;
            let size = *layer.face_sizes().get(face as usize)?;
            Some(if is_part { (size / 2).max(MIN_SIZE) } else { size })
        };
        layer.blocks().iter().filter_map(|block| of_tile(block.tile())).max().unwrap_or(MIN_SIZE)
    };
    let mut all = Vec::new();
    for kind in [Tesserae::Colors, Tesserae::Heights, Tesserae::Vectors, Tesserae::Traces] {
        let layers: Vec<(usize, &Layer)> = document
            .layers()
            .iter()
            .enumerate()
            .filter(|(_, layer)| Tesserae::of(layer.kind()) == Some(kind))
            .collect();
        let Some((_, first)) = layers.first() else { continue };
        let same = layers.iter().all(|(_, layer)| layer.kind() == first.kind());
        let mixes = matches!(kind, Tesserae::Colors | Tesserae::Heights);
        let plain = layers.len() == 1 && is_plain(first);
        if mixes && same && !plain {
            let side = layers.iter().map(|(_, layer)| side(layer)).max().unwrap_or(MIN_SIZE);
            let indices = layers.iter().map(|(index, _)| *index).collect();
            all.push(Shown { kind, layers: indices, is_alone: false, cells: Cells::of(tiles, side) });
        }
        for (index, layer) in layers {
            all.push(Shown { kind, layers: vec![index], is_alone: true, cells: Cells::of(tiles, side(layer)) });
        }
    }
    match all.len() {
        0 => {
            Err(Error::invalid("the document has no layers that are pictures")
                .advise("paint or sculpt something first"))
        }
        _ => Ok(all),
    }
}

/// How the tiles, or the triangles, of a document's mesh meet.
#[derive(Clone, Debug)]
pub enum Meeting {
    /// Of a Catmull-Clark surface.
    Tiles(Arc<TileTopology>),
    /// Of a triangle mesh.
    Triangles(Arc<TriangleTopology>),
}

/// The tiles of a document's mesh; of a triangle mesh the triangles.
pub fn tile_count(document: &Document) -> u32 {
    let topology = document.topology();
    if topology.is_of_triangles() { topology.face_count() as u32 } else { topology.tile_count() }
}

/// How the tiles of a document's mesh meet.
///
/// # Errors
/// Fails with `Invalid` if the mesh does not pass [`Mesh::check`], or is of triangles and the document does not have
/// its points.
pub fn meeting(document: &Document) -> Result<Meeting> {
    let topology = document.topology();
    if topology.is_of_triangles() {
        let mesh = document.mesh().ok_or_else(crate::transfer::without_points)?;
        return Ok(Meeting::Triangles(Arc::new(TriangleTopology::of_mesh(&mesh)?)));
    }
    let mut points = document.points().to_vec();
    if points.is_empty() {
        let corners = topology.corners();
        let count = corners.iter().max().map_or(0, |last| *last as usize + 1);
        // Of points that no face has a mesh may have as many as it likes, but not in a file without them.
        if count > corners.len() {
            return Err(Error::invalid("the faces of the document name points that they do not have"));
        }
        points = vec![[0.0; 3]; count];
    }
    let mut mesh = Mesh::new(points, topology.face_sizes().to_vec(), topology.corners().to_vec());
    mesh.holes = topology.holes().to_vec();
    mesh.check()?;
    Ok(Meeting::Tiles(Arc::new(TileTopology::new(&mesh)?)))
}

/// The texels behind a mosaic.
#[derive(Debug)]
enum Texels {
    Bytes(Channel<Rgba8>),
    Halves(Channel<Rgba16>),
    Heights(Channel<f16>),
    Vectors(Channel<Vector>),
    Traces(Channel<Trace>),
    Faces(Box<dyn Faces>),
}

/// A picture of layers, of which any part of any level can be read. It does not change.
#[derive(Debug)]
pub struct Mosaic {
    shown: Shown,
    texels: Texels,
}

impl Mosaic {
    /// Unpacks the layers.
    ///
    /// # Errors
    /// Fails with `Invalid` if a layer is damaged or of another mesh, with `Memory` if the layers do not fit the memory
    /// limit, with `Unsupported` for times of edits, and with `Internal` if `shown` names no layer of the document.
    pub fn new(context: &Context, document: &Document, meeting: &Meeting, shown: &Shown) -> Result<Self> {
        let layers: Vec<&Layer> = shown.layers.iter().filter_map(|index| document.layers().get(*index)).collect();
        let Some(first) = layers.first() else {
            return Err(Error::internal("a picture has layers"));
        };
        let alone = shown.is_alone;
        let topology = match meeting {
            Meeting::Tiles(topology) => topology,
            Meeting::Triangles(topology) => {
                let texels = Texels::Faces(faces::unpacked(context, document, topology, &layers, alone)?);
                return Ok(Self { shown: shown.clone(), texels });
            }
        };
        let texels = match first.kind() {
            Kind::Rgba8 => Texels::Bytes(composite(context, document, topology, &layers, alone)?),
            Kind::Rgba16 => Texels::Halves(composite(context, document, topology, &layers, alone)?),
            Kind::Scalar => Texels::Heights(composite(context, document, topology, &layers, alone)?),
            Kind::Vector => Texels::Vectors(channel(context, document, topology, first)?),
            Kind::Trace => Texels::Traces(channel(context, document, topology, first)?),
            Kind::Stamps => return Err(Error::unsupported("times of edits are no picture")),
        };
        Ok(Self { shown: shown.clone(), texels })
    }

    /// The pixels of `columns` by `rows` of a level, row by row: little-endian numbers as [`Tesserae`] says. Cells
    /// without a tile are zero.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such level or the picture is smaller.
    pub fn read(&self, level: u32, columns: Range<u32>, rows: Range<u32>) -> Result<Vec<u8>> {
        let cells = &self.shown.cells;
        if level >= cells.levels() {
            return Err(
                Error::invalid(format!("there is no level {level}")).advise(format!("use 0 to {}", cells.levels() - 1))
            );
        }
        let [width, height] = cells.size(level);
        if columns.start > columns.end || rows.start > rows.end || columns.end > width || rows.end > height {
            return Err(Error::invalid(format!("{columns:?} by {rows:?} is outside the picture"))
                .advise(format!("level {level} has {width} by {height} pixels")));
        }
        match &self.texels {
            Texels::Bytes(paint) => Ok(self.assemble(level, columns, rows, |tile| colors(paint.field(), tile))),
            Texels::Halves(paint) => Ok(self.assemble(level, columns, rows, |tile| colors(paint.field(), tile))),
            Texels::Heights(heights) => {
                Ok(self.assemble(level, columns, rows, |tile| planes(heights.field(), tile, smooth::<f16>)))
            }
            Texels::Vectors(vectors) => {
                Ok(self.assemble(level, columns, rows, |tile| planes(vectors.field(), tile, smooth::<Vector>)))
            }
            Texels::Traces(traces) => {
                Ok(self.assemble(level, columns, rows, |tile| planes(traces.field(), tile, marks)))
            }
            Texels::Faces(values) => {
                let shown = if self.shown.kind == Tesserae::Traces { faces::marks } else { faces::plain };
                Ok(self.assemble(level, columns, rows, |tile| faces::cell(values.as_ref(), tile, cells.side, shown)))
            }
        }
    }

    /// The pixels, where `sampler` knows the texels of a tile.
    fn assemble<S: Sampler>(
        &self,
        level: u32,
        columns: Range<u32>,
        rows: Range<u32>,
        sampler: impl Fn(u32) -> Option<S>,
    ) -> Vec<u8> {
        let (cells, kind) = (&self.shown.cells, self.shown.kind);
        let (cell, gutter, side) = (cells.cell(level), cells.gutter(level), cells.side >> level);
        let pixel = kind.pixel_size();
        let width = columns.len() * pixel;
        let mut out = vec![0; rows.len() * width];
        for row in rows.start / cell..rows.end.div_ceil(cell) {
            for column in columns.start / cell..columns.end.div_ceil(cell) {
                let tile = u64::from(row) * u64::from(cells.columns) + u64::from(column);
                let Some(mut texels) = u32::try_from(tile).ok().and_then(&sampler) else { continue };
                texels.come_to(side);
                let inside =
                    |cell_first: u32, range: &Range<u32>| range.start.max(cell_first)..range.end.min(cell_first + cell);
                for y in inside(row * cell, &rows) {
                    for x in inside(column * cell, &columns) {
                        let at = |pixel: u32, first: u32| i64::from(pixel - first) - i64::from(gutter);
                        let value = texels.texel(at(x, column * cell), at(y, row * cell), side);
                        let start = (y - rows.start) as usize * width + (x - columns.start) as usize * pixel;
                        encode(kind, value, &mut out[start..start + pixel]);
                    }
                }
            }
        }
        out
    }
}

fn encode(kind: Tesserae, value: [f32; 4], out: &mut [u8]) {
    if kind == Tesserae::Colors {
        for (out, value) in out.as_chunks_mut().0.iter_mut().zip(value) {
            *out = f16::from_f32(value).to_le_bytes();
        }
    } else {
        for (out, value) in out.as_chunks_mut().0.iter_mut().zip(value) {
            *out = value.to_le_bytes();
        }
    }
}

/// The texels of a tile.
trait Sampler {
    /// Chooses the level that has `side` texels, or the next smaller one there is.
    fn come_to(&mut self, side: u32);

    /// The texel at (i, j) of `side` by `side`; those outside are of the gutter.
    fn texel(&self, i: i64, j: i64, side: u32) -> [f32; 4];
}

/// Where in a block of `size`² texels with a ring the texel (i, j) of `side`² is.
fn inside(i: i64, side: u32, size: u32) -> i64 {
    let shift = side.max(size).ilog2() - size.ilog2();
    (i >> shift).clamp(-1, i64::from(size))
}

/// Colours of a tile.
struct Colored<'a, T> {
    field: &'a Field<T>,
    tile: u32,
    /// The block of the chosen level and its texels a side; none if the tile has no block.
    level: Option<(&'a [T], u32)>,
}

/// `None` if there is no such tile.
fn colors<T: ColorTexel>(field: &Field<T>, tile: u32) -> Option<Colored<'_, T>> {
    ((tile as usize) < field.tile_count()).then_some(Colored { field, tile, level: None })
}

impl<T: ColorTexel> Sampler for Colored<'_, T> {
    fn come_to(&mut self, side: u32) {
        let size = self.field.size(self.tile);
        let level = (size / side).max(1).ilog2();
        self.level = self.field.level(self.tile, level).map(|block| (block, size >> level));
    }

    fn texel(&self, i: i64, j: i64, side: u32) -> [f32; 4] {
        let Some((block, size)) = self.level else { return self.field.blank().color().to_array() };
        let (i, j) = (inside(i, side, size) + 1, inside(j, side, size) + 1);
        let at = j as usize * (size as usize + 2) + i as usize;
        block.get(at).copied().unwrap_or(self.field.blank()).color().to_array()
    }
}

/// Data of a tile: values at the centres of texels and at the middles of their sides on the tile's edges.
struct Plane {
    size: usize,
    /// Row by row; none if the tile has no block.
    values: Vec<[f32; 3]>,
    /// Along v = 0, u = 1, v = 1 and u = 0, with growing parameters.
    edges: [Vec<[f32; 3]>; 4],
    /// What is shown of a value.
    shown: fn([f32; 3]) -> [f32; 3],
}

/// `None` if there is no such tile.
fn planes<T: StoredTexel>(field: &Field<T>, tile: u32, make: impl Fn(&[T], usize) -> Plane) -> Option<Plane> {
    if tile as usize >= field.tile_count() {
        return None;
    }
    let size = field.size(tile) as usize;
    let block = field.block(tile).filter(|block| block.len() == (size + 2) * (size + 2));
    Some(block.map_or_else(
        || make(&vec![T::zeroed(); (MIN_SIZE as usize + 2).pow(2)], MIN_SIZE as usize),
        |block| make(block, size),
    ))
}

/// Values of a spline.
fn smooth<T: SplineTexel>(block: &[T], size: usize) -> Plane {
    let three = |numbers: &[f32]| [0, 1, 2].map(|axis| numbers.get(axis).copied().unwrap_or(0.0));
    let values = prefilter::values(block, size).chunks_exact(T::NUMBERS).map(three).collect();
    let stride = size + 2;
    let number = |i: usize, j: usize| {
        let mut numbers = Vec::with_capacity(T::NUMBERS);
        block[j * stride + i].append(&mut numbers);
        three(&numbers)
    };
    let ends = |k: usize, near: usize, far: usize, is_row: bool| {
        // Half of both rows beside the edge, and an eighth, three quarters and an eighth along it.
        let at = |along: usize, across: usize| if is_row { number(along, across) } else { number(across, along) };
        let weights = [0.125, 0.75, 0.125];
        [0, 1, 2].map(|axis| {
            let pair = |along: usize| 0.5 * (at(along, near)[axis] + at(along, far)[axis]);
            (0..3).map(|step| weights[step] * pair(k + step)).sum()
        })
    };
    let edge = |near: usize, far: usize, is_row: bool| (0..size).map(|k| ends(k, near, far, is_row)).collect();
    let edges = [edge(0, 1, true), edge(size + 1, size, false), edge(size + 1, size, true), edge(0, 1, false)];
    Plane { size, values, edges, shown: |value| value }
}

/// Traces, whose texels are interpolated as they are.
fn marks(block: &[Trace], size: usize) -> Plane {
    let stride = size + 2;
    let number = |i: usize, j: usize| {
        let Trace { contact, depth, moment } = block[j * stride + i];
        [contact.to_f32(), depth.to_f32(), moment]
    };
    let mean = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis]));
    let values = (1..=size).flat_map(|j| (1..=size).map(move |i| (i, j))).map(|(i, j)| number(i, j)).collect();
    let along_u = |near, far| (1..=size).map(|k| mean(number(k, near), number(k, far))).collect();
    let along_v = |near, far| (1..=size).map(|k| mean(number(near, k), number(far, k))).collect();
    let edges = [along_u(0, 1), along_v(size + 1, size), along_u(size + 1, size), along_v(0, 1)];
    let shown = |[contact, depth, moment]: [f32; 3]| {
        let time = if contact > 0.0 { moment / contact } else { -1.0 };
        [contact.clamp(0.0, 1.0), depth, time]
    };
    Plane { size, values, edges, shown }
}

impl Plane {
    /// As many means of two by two values.
    fn halve(&mut self) {
        let half = self.size / 2;
        let mean = |values: &[[f32; 3]]| {
            [0, 1, 2].map(|axis| values.iter().map(|value| value[axis]).sum::<f32>() / values.len() as f32)
        };
        let at = |i: usize, j: usize| self.values[j * self.size + i];
        let four = |i: usize, j: usize| mean(&[at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        let values = (0..half).flat_map(|j| (0..half).map(move |i| (2 * i, 2 * j))).map(|(i, j)| four(i, j)).collect();
        self.values = values;
        self.edges = self.edges.each_ref().map(|edge| edge.chunks_exact(2).map(mean).collect());
        self.size = half;
    }

    fn at(&self, i: usize, j: usize) -> [f32; 3] {
        self.values[j * self.size + i]
    }

    /// The value at (i, j), each from −1 to the size.
    fn ringed(&self, i: i64, j: i64) -> [f32; 3] {
        let last = self.size as i64 - 1;
        let (near_i, near_j) = (i.clamp(0, last) as usize, j.clamp(0, last) as usize);
        let value = self.at(near_i, near_j);
        let beyond = |edge: &[[f32; 3]], k: usize| [0, 1, 2].map(|axis| 2.0 * (edge[k][axis] - value[axis]));
        let across = match i {
            i if i < 0 => beyond(&self.edges[3], near_j),
            i if i > last => beyond(&self.edges[1], near_j),
            _ => [0.0; 3],
        };
        let along = match j {
            j if j < 0 => beyond(&self.edges[0], near_i),
            j if j > last => beyond(&self.edges[2], near_i),
            _ => [0.0; 3],
        };
        [0, 1, 2].map(|axis| value[axis] + across[axis] + along[axis])
    }
}

impl Sampler for Plane {
    fn come_to(&mut self, side: u32) {
        while self.size > side as usize {
            self.halve();
        }
    }

    fn texel(&self, i: i64, j: i64, side: u32) -> [f32; 4] {
        let size = self.size as u32;
        let [a, b, c] = (self.shown)(self.ringed(inside(i, side, size), inside(j, side, size)));
        [a, b, c, 0.0]
    }
}
