//! The tiles of a channel as pictures: all in one atlas with a table of where they are, or one picture each.
//!
//! A cell of the atlas is a tile with a gutter of one texel: of colours the ring, of displacement, whose values at the
//! centres of texels it has ([`crate::prefilter`]), the values at the border once more. Cells of one size stand in
//! rows, larger ones first, tiles ascending within a size. Within a cell u goes to the right and v down: the first row
//! is v = 0. Tiles without a block are left out.
//!
//! The table is a TOML file beside the picture, called as it is with `.toml` after its name:
//!
//! ```toml
//! version = 1
//! picture = "tiles.exr"
//! kind = "displacement"
//! units = "object units"
//! scale = 1.0
//! mid_level = 0.0
//! default = [0.0]
//! face_sizes = [64, 64, 32]
//! columns = ["tile", "face", "corner", "x", "y", "size"]
//! tiles = [
//!     [7, 5, 1, 1, 1, 64],
//! ]
//! ```
//!
//! `x` and `y` are the first texel of the tile in the picture, from the left and the top; `face_sizes` has texels along
//! the edges of every face of the mesh; `default` is what other tiles read as: a number as in the file, or a linear
//! colour.

use std::path::{Path, PathBuf};

use half::f16;
use relievo_core::{Context, Error, Result, file};
use relievo_render::{Content, Depth, Texture, write_texture};
use relievo_tiles::heap::MAX_SIZE;
use relievo_tiles::texel::Vector;
use relievo_tiles::{ColorTexel, Field, Rgba8, Rgba16, Texel};

use crate::prefilter::{self, SplineTexel};
use crate::texture::{MapFormat, Scaling};

/// A texel that pictures hold.
pub trait PictureTexel: Texel {
    /// Numbers of a texel.
    const CHANNELS: usize;
    /// What it is, in tables.
    const KIND: &'static str;
    /// Whether it is a colour.
    const CONTENT: Content;

    /// The numbers of a block of `size`² texels and the gutter around them.
    fn numbers(block: &[Self], size: usize) -> Vec<f32>;

    /// The numbers of one texel.
    fn number(self) -> Vec<f32>;
}

/// The values at the centres of texels, those at the border once more around them.
fn smooth<T: SplineTexel>(block: &[T], size: usize) -> Vec<f32> {
    let values = prefilter::values(block, size);
    let inside = |k: usize| k.clamp(1, size) - 1;
    let rows = (0..size + 2).map(inside);
    let texels = rows.flat_map(|j| (0..size + 2).map(inside).map(move |i| j * size + i));
    texels.flat_map(|at| &values[at * T::NUMBERS..(at + 1) * T::NUMBERS]).copied().collect()
}

fn number<T: SplineTexel>(texel: T) -> Vec<f32> {
    let mut numbers = Vec::new();
    texel.append(&mut numbers);
    numbers
}

impl PictureTexel for f16 {
    const CHANNELS: usize = 1;
    const KIND: &'static str = "displacement";
    const CONTENT: Content = Content::Data;

    fn numbers(block: &[Self], size: usize) -> Vec<f32> {
        smooth(block, size)
    }

    fn number(self) -> Vec<f32> {
        number(self)
    }
}

impl PictureTexel for Vector {
    const CHANNELS: usize = 3;
    const KIND: &'static str = "vector displacement";
    const CONTENT: Content = Content::Data;

    fn numbers(block: &[Self], size: usize) -> Vec<f32> {
        smooth(block, size)
    }

    fn number(self) -> Vec<f32> {
        number(self)
    }
}

fn colors<T: ColorTexel>(block: &[T]) -> Vec<f32> {
    block.iter().flat_map(|texel| texel.color().to_array()).collect()
}

macro_rules! color_pictures {
    ($($texel:ty),*) => {$(
        impl PictureTexel for $texel {
            const CHANNELS: usize = 4;
            const KIND: &'static str = "color";
            const CONTENT: Content = Content::Color;

            fn numbers(block: &[Self], _: usize) -> Vec<f32> {
                colors(block)
            }

            fn number(self) -> Vec<f32> {
                colors(&[self])
            }
        }
    )*};
}

color_pictures!(Rgba8, Rgba16);

/// A tile of an atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The tile.
    pub tile: u32,
    /// Its first texel, from the left and the top.
    pub x: u32,
    /// See `x`.
    pub y: u32,
    /// Texels along its sides.
    pub size: u32,
}

/// Where tiles are in an atlas.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Atlas {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Larger tiles first, then by tile.
    pub cells: Vec<Cell>,
}

/// The largest atlas, along a side.
const MAX_PIXELS: u64 = 32_768;

impl Atlas {
    /// Packs tiles of these sizes.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no tile, and with `Unsupported` if the picture would be too large.
    pub fn pack(tiles: impl Iterator<Item = (u32, u32)>) -> Result<Self> {
        let mut cells: Vec<Cell> = tiles.map(|(tile, size)| Cell { tile, x: 0, y: 0, size }).collect();
        cells.sort_by_key(|cell| (std::cmp::Reverse(cell.size), cell.tile));
        let Some(largest) = cells.first() else {
            return Err(Error::invalid("no tile has a block").advise("there is nothing to write"));
        };
        let side = |cell: &Cell| u64::from(cell.size) + 2;
        let area: u64 = cells.iter().map(|cell| side(cell).pow(2)).sum();
        let width = (area as f64).sqrt().ceil() as u64;
        let width = width.next_multiple_of(side(largest));
        let (mut x, mut y, mut row) = (0, 0, side(largest));
        for cell in &mut cells {
            if x + side(cell) > width || side(cell) != row {
                (x, y, row) = (0, y + row, side(cell));
            }
            (cell.x, cell.y) = (x as u32 + 1, y as u32 + 1);
            x += side(cell);
        }
        let height = y + row;
        if width.max(height) > MAX_PIXELS {
            return Err(Error::unsupported(format!("an atlas of the tiles has {width} by {height} pixels"))
                .advise(format!("write Ptex, or tiles one by one; a picture has at most {MAX_PIXELS} a side")));
        }
        Ok(Self { width: width as u32, height: height as u32, cells })
    }

    /// The table, without what the numbers are.
    fn table<T: PictureTexel>(&self, field: &Field<T>, scaling: &Scaling) -> String {
        let topology = field.topology();
        let sizes = (0..topology.face_count() as u32).map(|face| {
            let tile = topology.tiles_of(face).start;
            if topology.is_sub(tile) { (2 * field.size(tile)).min(MAX_SIZE) } else { field.size(tile) }
        });
        let sizes: Vec<String> = sizes.map(|size| size.to_string()).collect();
        let blank: Vec<f32> = field.blank().number().iter().map(|value| scaling.stored(*value)).collect();
        let mut text = format!("default = {blank:?}\nface_sizes = [{}]\n", sizes.join(", "));
        text += "columns = [\"tile\", \"face\", \"corner\", \"x\", \"y\", \"size\"]\ntiles = [\n";
        for Cell { tile, x, y, size } in &self.cells {
            let (face, corner) = (topology.face(*tile), topology.sub_corner(*tile));
            text += &format!("    [{tile}, {face}, {corner}, {x}, {y}, {size}],\n");
        }
        text + "]\n"
    }
}

/// The table of the atlas at `path`.
pub fn table_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

fn depth<T: PictureTexel>(format: MapFormat) -> Depth {
    match (format, T::CONTENT) {
        (MapFormat::Exr, Content::Color) => Depth::F16,
        (MapFormat::Exr, Content::Data) => Depth::F32,
        (MapFormat::Png, Content::Color) => Depth::U8,
        (MapFormat::Png, Content::Data) => Depth::U16,
    }
}

fn statement<T: PictureTexel>(format: MapFormat, scaling: &Scaling) -> String {
    let kind = T::KIND;
    match (T::CONTENT, format) {
        (Content::Data, _) => {
            let Scaling { scale, mid_level } = scaling;
            format!("kind = \"{kind}\"\nunits = \"object units\"\nscale = {scale:?}\nmid_level = {mid_level:?}\n")
        }
        (_, MapFormat::Exr) => {
            format!("kind = \"{kind}\"\ncolor_space = \"linear Rec.709\"\nalpha = \"unassociated\"\n")
        }
        (_, MapFormat::Png) => format!("kind = \"{kind}\"\ncolor_space = \"sRGB\"\nalpha = \"unassociated\"\n"),
    }
}

/// The numbers of tiles, with their gutters, as a file has them. Fails if they do not fit the memory limit.
fn numbers<T: PictureTexel>(
    context: &Context,
    field: &Field<T>,
    cells: &[Cell],
    scaling: &Scaling,
) -> Result<Vec<Vec<f32>>> {
    let bytes: u64 = cells.iter().map(|cell| (u64::from(cell.size) + 2).pow(2) * 4 * T::CHANNELS as u64).sum();
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("the tiles take {bytes} bytes, more than the memory limit"))
            .advise("raise the limit, or write Ptex"));
    }
    Ok(context.map(cells.len(), |index| {
        let Cell { tile, size, .. } = cells[index];
        let mut numbers = T::numbers(field.block(tile).unwrap_or(&[]), size as usize);
        if T::CONTENT == Content::Data {
            numbers.iter_mut().for_each(|number| *number = scaling.stored(*number));
        }
        numbers
    }))
}

/// Writes the tiles of a channel as one picture, .exr or .png, and the table beside it. Returns where they are.
///
/// # Errors
/// Fails with `Invalid` if no tile has a block or the scaling cannot be used, with `Unsupported` if the extension is
/// another or the picture would be too large, with `Memory` if it does not fit the context's memory limit, and with
/// `NotFound` or `Io` if a file cannot be written.
pub fn write_atlas<T: PictureTexel>(
    context: &Context,
    path: &Path,
    field: &Field<T>,
    scaling: &Scaling,
) -> Result<Atlas> {
    let format = MapFormat::of(path)?;
    scaling.check()?;
    let named = |error: Error| error.at(path.display().to_string());
    let atlas = Atlas::pack(field.allocated().map(|tile| (tile, field.size(tile)))).map_err(named)?;
    let numbers = numbers(context, field, &atlas.cells, scaling).map_err(named)?;
    // The first cell of every row of cells.
    let mut rows: Vec<usize> = Vec::new();
    for (index, cell) in atlas.cells.iter().enumerate() {
        if cell.x == 1 {
            rows.push(index);
        }
    }
    let row = |y: u32, out: &mut [f32]| {
        out.fill(0.0);
        let at = rows.partition_point(|first| atlas.cells[*first].y <= y + 1).saturating_sub(1);
        let end = rows.get(at + 1).copied().unwrap_or(atlas.cells.len());
        for (cell, numbers) in atlas.cells[rows[at]..end].iter().zip(&numbers[rows[at]..end]) {
            let side = cell.size as usize + 2;
            let (from, to) = ((y + 1 - cell.y) as usize * side, cell.x as usize - 1);
            let own = &numbers[from * T::CHANNELS..(from + side) * T::CHANNELS];
            out[to * T::CHANNELS..(to + side) * T::CHANNELS].copy_from_slice(own);
        }
    };
    let statement = statement::<T>(format, scaling);
    let texture = Texture {
        width: atlas.width,
        height: atlas.height,
        channels: T::CHANNELS,
        content: T::CONTENT,
        text: &statement,
        row: &row,
    };
    write_texture(context, path, &texture, depth::<T>(format))?;
    let name = path.file_name().map(|name| name.to_string_lossy().replace(['"', '\\', '\n'], "_")).unwrap_or_default();
    let table = format!("version = 1\npicture = \"{name}\"\n{statement}{}", atlas.table(field, scaling));
    file::store(&table_of(path), |out| std::io::Write::write_all(out, table.as_bytes()))?;
    Ok(atlas)
}

/// Writes every tile that has a block as a picture of its own, without a gutter, to the path that `name` makes of its
/// number. Returns the files in the order written.
///
/// # Errors
/// Fails with `Invalid` if no tile has a block or the scaling cannot be used, with `Unsupported` if an extension is
/// neither .exr nor .png, with `Memory` if a tile does not fit the context's memory limit, and with `NotFound` or `Io`
/// if a file cannot be written; the files before it are there.
pub fn write_tiles<T: PictureTexel>(
    context: &Context,
    field: &Field<T>,
    scaling: &Scaling,
    name: impl Fn(u32) -> PathBuf,
) -> Result<Vec<PathBuf>> {
    scaling.check()?;
    let cells: Vec<Cell> = field.allocated().map(|tile| Cell { tile, x: 1, y: 1, size: field.size(tile) }).collect();
    if cells.is_empty() {
        return Err(Error::invalid("no tile has a block").advise("there is nothing to write"));
    }
    let topology = field.topology();
    let mut written = Vec::with_capacity(cells.len());
    for cell in &cells {
        let path = name(cell.tile);
        let format = MapFormat::of(&path)?;
        let numbers = numbers(context, field, std::slice::from_ref(cell), scaling)?.remove(0);
        let (face, corner) = (topology.face(cell.tile), topology.sub_corner(cell.tile));
        let text =
            format!("{}tile = {}\nface = {face}\ncorner = {corner}\n", statement::<T>(format, scaling), cell.tile);
        let side = cell.size as usize + 2;
        let row = |y: u32, out: &mut [f32]| {
            let from = ((y as usize + 1) * side + 1) * T::CHANNELS;
            out.copy_from_slice(&numbers[from..from + out.len()]);
        };
        let texture = Texture {
            width: cell.size,
            height: cell.size,
            channels: T::CHANNELS,
            content: T::CONTENT,
            text: &text,
            row: &row,
        };
        write_texture(context, &path, &texture, depth::<T>(format))?;
        written.push(path);
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_apart_in_a_picture_that_is_nearly_square() {
        let sizes = [8, 256, 16, 16, 64, 8, 32, 128, 8, 8, 64];
        let atlas = Atlas::pack((0..330).map(|tile| (tile, sizes[tile as usize % 11]))).unwrap();
        let boxes: Vec<[u32; 4]> = atlas
            .cells
            .iter()
            .map(|cell| [cell.x - 1, cell.y - 1, cell.x + cell.size + 1, cell.y + cell.size + 1])
            .collect();
        for (index, a) in boxes.iter().enumerate() {
            assert!(a[2] <= atlas.width && a[3] <= atlas.height);
            for b in &boxes[..index] {
                assert!(a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1], "{a:?} {b:?}");
            }
        }
        let area: u64 = atlas.cells.iter().map(|cell| u64::from(cell.size + 2).pow(2)).sum();
        assert!(u64::from(atlas.width) * u64::from(atlas.height) < area * 3 / 2);
        assert!(atlas.width.abs_diff(atlas.height) < atlas.width / 2);
        assert!(Atlas::pack(std::iter::empty()).is_err());
        assert!(Atlas::pack((0..100_000).map(|tile| (tile, 256))).is_err());
    }
}
