//! A channel from the pictures of its tiles: what [`crate::atlas`] writes, read back.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::Vec4;
use relievo_core::{Context, Error, Result, file};
use relievo_render::color::encode_srgb;
use relievo_render::{Image, read_exr, read_png};
use relievo_surface::{Surface, TileTopology};
use relievo_tiles::{Channel, ColorTexel, Displacement, Paint, Rgba8, Rgba16, Texel, VectorDisplacement};
use serde::Deserialize;

use crate::atlas::{Cell, PictureTexel};
use crate::prefilter::SplineTexel;
use crate::ptex::Imported;
use crate::restored;
use crate::solve::{Target, solve};
use crate::texture::{MapFormat, Scaling};

/// The table of an atlas.
#[derive(Debug, Deserialize)]
struct Table {
    version: u32,
    picture: String,
    kind: String,
    scale: Option<f32>,
    mid_level: Option<f32>,
    default: Vec<f32>,
    face_sizes: Vec<u32>,
    tiles: Vec<[u32; 6]>,
}

/// No table is larger.
const MAX_TABLE: u64 = 256 << 20;

/// The channel of the atlas with the table at `path`, for `surface`, which may occupy `budget` bytes.
/// Colours from PNG become bytes, those from EXR half floats.
///
/// # Errors
/// Fails with `NotFound` or `Io` if a file does not exist or cannot be read; with `Invalid`, and what differs, if the
/// table is none, the tiles are not those of the mesh, a cell is not in the picture or a number is not finite; with
/// `Unsupported` for another version or kind; and with `Memory` if a file exceeds the context's memory limit or the
/// tiles the budget.
pub fn from_atlas(context: &Context, surface: &Surface, path: &Path, budget: u64) -> Result<Imported> {
    let topology = surface.topology();
    let named = |error: Error| error.at(path.display().to_string());
    let bytes = file::load(path, context.memory_limit().min(MAX_TABLE))?;
    let text = String::from_utf8(bytes).map_err(|_| named(Error::invalid("it is no text")))?;
    let table: Table = toml::from_str(&text).map_err(|error| {
        let advice = "give the table that was written beside an atlas";
        named(Error::invalid(format!("it is not the table of an atlas: {}", error.message())).advise(advice))
    })?;
    let cells = table.cells(topology).map_err(named)?;
    if Path::new(&table.picture).file_name() != Some(table.picture.as_ref()) {
        return Err(named(
            Error::invalid(format!("the picture is called {:?}", table.picture)).advise("name a file beside the table"),
        ));
    }
    let picture = path.with_file_name(&table.picture);
    let format = MapFormat::of(&picture)?;
    let scaling = Scaling { scale: table.scale.unwrap_or(1.0), mid_level: table.mid_level.unwrap_or(0.0) };
    scaling.check().map_err(named)?;
    let source = Source { context, topology, table: &table, cells };
    let made = match (table.kind.as_str(), format) {
        ("displacement", _) => {
            let image = read(context, &picture, format, &["Y"])?;
            let made = Displacement::new(topology.clone(), &restored::options(table.face_sizes.clone(), budget))?;
            source.displacement(made, &image, format, &scaling).map(Imported::Displacement)
        }
        ("vector displacement", _) => {
            let image = read(context, &picture, format, &COLORS[..3])?;
            let made = VectorDisplacement::on(surface, &restored::options(table.face_sizes.clone(), budget))?;
            source.displacement(made, &image, format, &scaling).map(Imported::Vector)
        }
        ("color", MapFormat::Exr) => {
            source.paint::<Rgba16>(&read(context, &picture, format, &COLORS)?, budget).map(Imported::Rgba16)
        }
        ("color", MapFormat::Png) => {
            source.paint::<Rgba8>(&read(context, &picture, format, &COLORS)?, budget).map(Imported::Rgba8)
        }
        (kind, _) => Err(Error::unsupported(format!("an atlas of {kind:?} is not read"))),
    };
    made.map_err(named)
}

const COLORS: [&str; 4] = ["R", "G", "B", "A"];

/// The picture with these channels.
fn read(context: &Context, path: &Path, format: MapFormat, channels: &[&str]) -> Result<Image> {
    let limit = context.memory_limit();
    let image = match format {
        MapFormat::Png => Some(read_png(path, limit)?),
        MapFormat::Exr => read_exr(path, limit)?.first().and_then(|layer| layer.image(channels)),
    };
    image.filter(|image| image.channels() as usize == channels.len()).ok_or_else(|| {
        Error::invalid(format!("the picture has not {} channels", channels.len()))
            .at(path.display().to_string())
            .advise("keep the channels that it was written with")
    })
}

impl Table {
    /// Its tiles, checked against the mesh but not the picture.
    fn cells(&self, topology: &TileTopology) -> Result<Vec<Cell>> {
        let advice = "give the mesh that the atlas was made for, with its faces in the same order";
        if self.version != 1 {
            return Err(Error::unsupported(format!("the table has version {}", self.version))
                .advise("read it with a newer Relievo"));
        }
        let (faces, expected) = (self.face_sizes.len(), topology.face_count());
        if faces != expected {
            return Err(Error::invalid(format!("it is for {faces} faces, and the mesh has {expected}")).advise(advice));
        }
        let mut cells = Vec::with_capacity(self.tiles.len());
        for [tile, face, corner, x, y, size] in self.tiles.iter().copied() {
            let exists = (tile as usize) < topology.tile_count();
            if !exists || (topology.face(tile), topology.sub_corner(tile)) != (face, corner) || topology.is_hole(tile) {
                let what = format!("the mesh has no tile {tile} that is corner {corner} of face {face}");
                return Err(Error::invalid(what).advise(advice));
            }
            cells.push(Cell { tile, x, y, size });
        }
        cells.sort_by_key(|cell| cell.tile);
        match cells.windows(2).find(|pair| pair[0].tile == pair[1].tile) {
            Some(pair) => Err(Error::invalid("it is listed twice").at(format!("tile {}", pair[0].tile))),
            None => Ok(cells),
        }
    }
}

/// A table, and the mesh it is for.
struct Source<'a> {
    context: &'a Context,
    topology: &'a Arc<TileTopology>,
    table: &'a Table,
    /// By tile.
    cells: Vec<Cell>,
}

impl Source<'_> {
    fn tiles(&self) -> Vec<u32> {
        self.cells.iter().map(|cell| cell.tile).collect()
    }

    /// Fails unless every cell is in the picture and as large as its tile.
    fn check<T: Texel>(&self, channel: &Channel<T>, image: &Image) -> Result<()> {
        for Cell { tile, x, y, size } in self.cells.iter().copied() {
            let place = || format!("tile {tile}");
            let expected = channel.field().size(tile);
            if size != expected {
                return Err(Error::invalid(format!("it has {size} texels a side and not {expected}")).at(place()));
            }
            let inside = |first: u32, length: u32| first.checked_add(size).is_some_and(|end| end <= length);
            if !inside(x, image.width()) || !inside(y, image.height()) {
                return Err(Error::invalid(format!("({x}, {y}) and {size} texels are outside the picture")).at(place()));
            }
        }
        Ok(())
    }

    /// The numbers of a cell, row by row.
    fn values(&self, image: &Image, index: usize) -> Result<Vec<f32>> {
        let Cell { tile, x, y, size } = self.cells[index];
        let channels = image.channels() as usize;
        let rows = (y..y + size).map(|y| (y as usize * image.width() as usize + x as usize) * channels);
        let values: Vec<f32> =
            rows.flat_map(|start| &image.data()[start..start + size as usize * channels]).copied().collect();
        if values.iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid("a texel is not a finite number").at(format!("tile {tile}")));
        }
        Ok(values)
    }

    fn displacement<T: SplineTexel>(
        &self,
        mut made: Channel<T>,
        image: &Image,
        format: MapFormat,
        scaling: &Scaling,
    ) -> Result<Channel<T>> {
        self.check(&made, image)?;
        restored::allocate(&mut made, &self.tiles())?;
        let read = self.context.map(self.cells.len(), |index| -> Result<_> {
            let mut values = self.values(image, index)?;
            for value in &mut values {
                // Data in a PNG is read as if it were colour.
                let stored = if format == MapFormat::Png { encode_srgb(*value) } else { *value };
                *value = scaling.value(stored).clamp(-LARGEST, LARGEST);
            }
            Ok((self.cells[index].tile, values))
        });
        let values: BTreeMap<u32, Vec<f32>> = read.into_iter().collect::<Result<_>>()?;
        let step = if format == MapFormat::Png { 0.5 / 65535.0 * scaling.scale.abs() } else { 0.0 };
        solve(self.context, &mut made, Target { values, step })?;
        Ok(made)
    }

    fn paint<T: ColorTexel + PictureTexel>(&self, image: &Image, budget: u64) -> Result<Paint<T>> {
        let [r, g, b, a] = self.table.default[..] else {
            return Err(Error::invalid("the default of colours is not four numbers"));
        };
        let options = restored::options(self.table.face_sizes.clone(), budget);
        let mut made = Paint::<T>::of_color(self.topology.clone(), Vec4::new(r, g, b, a), &options)?;
        self.check(&made, image)?;
        let tiles = self.tiles();
        restored::allocate(&mut made, &tiles)?;
        let read = self.context.map(self.cells.len(), |index| -> Result<Vec<T>> {
            let values = self.values(image, index)?;
            Ok(values.chunks_exact(4).map(|color| T::of_color(Vec4::from_slice(color))).collect())
        });
        restored::fill(self.context, &mut made, &tiles, &read.into_iter().collect::<Result<Vec<_>>>()?)?;
        restored::settle(self.context, &mut made, &tiles)?;
        Ok(made)
    }
}

/// The largest displacement: within half floats.
const LARGEST: f32 = 60_000.0;
