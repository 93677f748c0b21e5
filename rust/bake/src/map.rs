//! Bakes: pictures of a surface's numbers on its texture coordinates.
//!
//! A picture is made in bands of rows, and a band in windows; each window finds the places of its samples
//! ([`crate::raster`]) in the chunks of the layout that reach into it ([`crate::layout`]), evaluates what is baked
//! there, and averages the samples of a pixel. Bands do not know of each other, so results do not depend on threads.
//! Where several tiles lie on one pixel, the lowest has it.

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Progress, Result};
use relievo_surface::{Place, Surface};

use crate::gutter::Gutter;
use crate::layout::{Chunk, Layout};
use crate::quantity::Quantity;
use crate::raster::{Mapping, NONE, Window};

/// How bakes are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Pixels along s and t.
    pub size: [u32; 2],
    /// Whether to make a picture of each UDIM tile that something lies on, or only of 0 ≤ s, t < 1.
    pub udim: bool,
    /// Pixels of the gutter around islands.
    pub gutter: u32,
    /// Samples along the sides of a pixel, 1 to 8.
    pub samples: u32,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self { size: [2048; 2], udim: false, gutter: 16, samples: 1 }
    }
}

/// The largest picture, along a side.
pub const MAX_PIXELS: u32 = 32_768;
/// The widest gutter.
pub const WIDEST_GUTTER: u32 = 1024;
/// The most samples along the sides of a pixel.
pub const MAX_SAMPLES: u32 = 8;
/// The most pictures of a bake.
pub const MAX_PICTURES: usize = 1000;

/// A picture of raw numbers, the row of the largest t first.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Its UDIM number, 1001 + k + 10 l; 1001 for the only picture.
    pub udim: u32,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Numbers of a pixel.
    pub channels: usize,
    /// The numbers, pixel after pixel, row after row.
    pub data: Vec<f32>,
    /// Which pixels lie on the surface; those of the gutter do not.
    pub covered: Vec<bool>,
}

/// What a bake did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BakeReport {
    /// UDIM numbers of the pictures.
    pub pictures: Vec<u32>,
    /// Pixels that lie on the surface.
    pub covered: u64,
    /// Pixels of the gutter.
    pub gutter: u64,
    /// Pixels on which several tiles lie; the lowest has them.
    pub overlapping: u64,
    /// Tiles without an extent in the texture coordinates.
    pub flat: usize,
    /// UDIM tiles that something lies on and that have no picture: all but the first where pictures of UDIM tiles were
    /// not asked for, and those without a number.
    pub outside: usize,
}

impl BakeReport {
    /// Fails if no picture was made.
    pub(crate) fn found_some(self, options: &BakeOptions) -> Result<Self> {
        if !self.pictures.is_empty() {
            return Ok(self);
        }
        let advice = match options.udim {
            false if self.outside > 0 => "move them there, or ask for pictures of UDIM tiles",
            _ => "unwrap the mesh first",
        };
        Err(Error::invalid("no texture coordinates lie on the picture").advise(advice))
    }
}

impl std::fmt::Display for BakeReport {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let pictures = self.pictures.len();
        write!(out, "{pictures} {}", if pictures == 1 { "picture" } else { "pictures" })?;
        write!(out, ", {} pixels covered, {} in the gutter", self.covered, self.gutter)?;
        if self.overlapping > 0 {
            write!(out, "; several faces lie on {} pixels, the first has them", self.overlapping)?;
        }
        if self.flat > 0 {
            write!(out, "; {} tiles have no area in the texture coordinates", self.flat)?;
        }
        if self.outside > 0 {
            write!(out, "; {} squares of texture coordinates have no picture", self.outside)?;
        }
        Ok(())
    }
}

/// Rows of a band, columns of a window.
const ROWS: u32 = 64;
const COLUMNS: u32 = 256;
/// Bands between two words on the progress.
const BANDS: usize = 8;

/// The numbers of a band, what is covered of it, and the pixels on which tiles overlap.
type Band<'a> = ((&'a mut [f32], &'a mut [bool]), Result<u64>);

/// Bakes `quantity` on the texture coordinates `limit` of its surface, and calls `each` for every picture, by number.
///
/// # Errors
/// Fails with `Invalid` if the options are out of range, the texture coordinates cannot be used or are of another
/// surface, or nothing lies on a picture; with `Memory` if the picture does not fit the context's memory limit; and as
/// `each` does.
pub fn bake(
    context: &Context,
    limit: &Surface,
    quantity: &Quantity<'_>,
    options: &BakeOptions,
    each: impl FnMut(Map) -> Result<()>,
) -> Result<BakeReport> {
    bake_watched(context, limit, quantity, options, &mut Silent, each)
}

/// As [`bake`], telling `progress` of every few bands of a picture.
///
/// # Errors
/// Fails as [`bake`] does, and with `Cancelled` if `progress` asks to stop; pictures that `each` was called for are
/// done.
pub fn bake_watched(
    context: &Context,
    limit: &Surface,
    quantity: &Quantity<'_>,
    options: &BakeOptions,
    progress: &mut dyn Progress,
    mut each: impl FnMut(Map) -> Result<()>,
) -> Result<BakeReport> {
    check(context, quantity.channels(), options)?;
    quantity.check(limit)?;
    let topology = limit.topology();
    let samples = options.size.map(|size| size * options.samples);
    let layout = Layout::new(context, limit, samples, |tile| topology.is_hole(tile))?;
    let found = layout.pictures();
    let pictures = chosen(&found, options)?;
    let mut report = BakeReport { flat: layout.flat, outside: found.len() - pictures.len(), ..BakeReport::default() };
    let part = 1.0 / pictures.len().max(1) as f32;
    for (number, [k, l]) in pictures.into_iter().enumerate() {
        let mut map = Map {
            udim: (1001 + k + 10 * l) as u32,
            width: options.size[0],
            height: options.size[1],
            channels: quantity.channels(),
            data: Vec::new(),
            covered: Vec::new(),
        };
        let span = [number as f32 * part, (number + 1) as f32 * part];
        report.overlapping += map.fill(context, &layout, [k, l], quantity, options, (progress, span))?;
        let covered = map.covered.iter().filter(|covered| **covered).count();
        if covered == 0 {
            continue;
        }
        report.gutter += map.surround(options.gutter);
        report.covered += covered as u64;
        report.pictures.push(map.udim);
        each(map)?;
    }
    report.found_some(options)
}

/// Returns the squares that get a picture, as [column, row], of the squares that something lies on, as (row, column).
pub(crate) fn chosen<'a>(
    found: impl IntoIterator<Item = &'a (i32, i32)>,
    options: &BakeOptions,
) -> Result<Vec<[i32; 2]>> {
    let wanted = |(l, k): &(i32, i32)| match options.udim {
        true => (0..10).contains(k) && (0..900).contains(l),
        false => (*l, *k) == (0, 0),
    };
    let pictures: Vec<[i32; 2]> = found.into_iter().filter(|at| wanted(at)).map(|(l, k)| [*k, *l]).collect();
    if pictures.len() > MAX_PICTURES {
        return Err(Error::invalid(format!("the texture coordinates lie on {} pictures", pictures.len()))
            .advise(format!("scale them to at most {MAX_PICTURES}")));
    }
    Ok(pictures)
}

pub(crate) fn check(context: &Context, channels: usize, options: &BakeOptions) -> Result<()> {
    if options.size.iter().any(|size| !(1..=MAX_PIXELS).contains(size)) {
        let [width, height] = options.size;
        return Err(Error::invalid(format!("a bake cannot have {width} by {height} pixels"))
            .advise(format!("use 1 to {MAX_PIXELS} a side")));
    }
    if !(1..=MAX_SAMPLES).contains(&options.samples) || options.gutter > WIDEST_GUTTER {
        return Err(Error::invalid(format!("{} samples, a gutter of {}", options.samples, options.gutter))
            .advise(format!("use 1 to {MAX_SAMPLES} samples and at most {WIDEST_GUTTER} pixels")));
    }
    let pixels = u64::from(options.size[0]) * u64::from(options.size[1]);
    // Once as numbers, once as a file has them, and what is known of each pixel.
    let bytes = pixels * (8 * channels as u64 + 2);
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("the picture takes {bytes} bytes, more than the memory limit"))
            .advise("bake a smaller one or raise the limit"));
    }
    Ok(())
}

impl Map {
    /// The numbers of a pixel.
    pub fn pixel(&self, x: u32, y: u32) -> &[f32] {
        let start = (y as usize * self.width as usize + x as usize) * self.channels;
        self.data.get(start..start + self.channels).unwrap_or_default()
    }

    /// Bakes the picture of one UDIM tile. Returns the pixels on which tiles overlap.
    fn fill(
        &mut self,
        context: &Context,
        layout: &Layout<'_>,
        tile: [i32; 2],
        quantity: &Quantity<'_>,
        options: &BakeOptions,
        (progress, [from, to]): (&mut dyn Progress, [f32; 2]),
    ) -> Result<u64> {
        let (width, height, channels) = (self.width as usize, self.height as usize, self.channels);
        self.data = quantity.meaning().background().repeat(width * height);
        self.covered = vec![false; width * height];
        let mapping = Mapping::new(layout.samples, tile);
        let windows = self.width.div_ceil(COLUMNS) as usize;
        let bins = bins(layout, &mapping, windows, self.height.div_ceil(ROWS) as usize, options.samples);
        let data = self.data.chunks_mut(ROWS as usize * width * channels);
        let covered = self.covered.chunks_mut(ROWS as usize * width);
        let mut bands: Vec<Band<'_>> = data.zip(covered).map(|band| (band, Ok(0))).collect();
        let (full_width, full_height) = (self.width, self.height);
        let work = |index: usize, ((data, covered), result): &mut Band<'_>| {
            let first = index as u32 * ROWS;
            let rows = first..(first + ROWS).min(full_height);
            let mut overlapping = Ok(0);
            for (window, chunks) in bins[index * windows..(index + 1) * windows].iter().enumerate() {
                let first = window as u32 * COLUMNS;
                let columns = first..(first + COLUMNS).min(full_width);
                if chunks.is_empty() || overlapping.is_err() {
                    continue;
                }
                let times = options.samples;
                let scaled = |range: &std::ops::Range<u32>| range.start * times..range.end * times;
                let mut samples = Window::new(scaled(&columns), scaled(&rows));
                let entered = chunks
                    .iter()
                    .try_for_each(|chunk| samples.enter(context, layout, &mapping, &layout.chunks[*chunk as usize]));
                let made = entered.and_then(|()| {
                    resolve(context, layout.limit, quantity, times, &samples, |x, y, value| {
                        let pixel = y * width + columns.start as usize + x;
                        data[pixel * channels..(pixel + 1) * channels].copy_from_slice(value);
                        covered[pixel] = true;
                    })
                });
                overlapping = overlapping.and_then(|sum: u64| made.map(|more| sum + more));
            }
            *result = overlapping;
        };
        let count = bands.len();
        for (index, some) in bands.chunks_mut(BANDS).enumerate() {
            let first = index * BANDS;
            progress.step(from + (to - from) * first as f32 / count as f32, "bake")?;
            context.for_each_mut(some, |index, band| work(first + index, band));
        }
        bands.into_iter().map(|(_, result)| result).sum()
    }

    /// Fills the gutter. Returns its pixels.
    pub(crate) fn surround(&mut self, distance: u32) -> u64 {
        let gutter = Gutter::new(&self.covered, self.width as usize, distance);
        for (pixel, source) in &gutter.copies {
            let source = *source as usize * self.channels;
            self.data.copy_within(source..source + self.channels, *pixel as usize * self.channels);
        }
        gutter.copies.len() as u64
    }
}

/// The chunks that may reach into every window, in their order.
fn bins(layout: &Layout<'_>, mapping: &Mapping, columns: usize, rows: usize, times: u32) -> Vec<Vec<u32>> {
    let mut bins = vec![Vec::new(); columns * rows];
    let sides = [(f64::from(COLUMNS * times), columns), (f64::from(ROWS * times), rows)];
    for (index, chunk) in (0u32..).zip(&layout.chunks) {
        let [columns_of, rows_of] = reach(chunk, mapping, sides);
        for row in rows_of {
            columns_of.clone().for_each(|column| bins[row * columns + column].push(index));
        }
    }
    bins
}

/// Between its corners and along the border a chunk may bulge by so much, in samples.
const BULGE: f64 = 2.5;

/// The columns and rows of windows, of these sides and counts, that a chunk may reach into.
fn reach(chunk: &Chunk, mapping: &Mapping, sides: [(f64, usize); 2]) -> [std::ops::Range<usize>; 2] {
    let (a, b) = (mapping.apply(chunk.low), mapping.apply(chunk.high));
    [0, 1].map(|axis| {
        let (side, count) = sides[axis];
        let (low, high) = (a[axis].min(b[axis]) - BULGE, a[axis].max(b[axis]) + BULGE);
        let window = |x: f64| (x / side).floor().clamp(-1.0, count as f64);
        let (first, last) = (window(low), window(high));
        if last < 0.0 || first >= count as f64 { 0..0 } else { first.max(0.0) as usize..(last as usize + 1).min(count) }
    })
}

/// Evaluates the samples of a window and gives `put` the column, the row and the numbers of every pixel that something
/// lies on. Returns how many pixels tiles overlap on.
fn resolve(
    context: &Context,
    limit: &Surface,
    quantity: &Quantity<'_>,
    times: u32,
    window: &Window,
    mut put: impl FnMut(usize, usize, &[f32]),
) -> Result<u64> {
    let (channels, times) = (quantity.channels(), times as usize);
    let width = window.columns.len();
    let (columns, rows) = (width / times, window.rows.len() / times);
    // Pixel by pixel, so that the samples of each follow one another.
    let mut pixels = Vec::with_capacity(columns * rows);
    let mut places = Vec::with_capacity(columns * rows);
    let mut overlapping = 0;
    for y in 0..rows {
        for x in 0..columns {
            let before = places.len();
            let mut overlaps = false;
            for sample in 0..times * times {
                let index = (y * times + sample / times) * width + x * times + sample % times;
                overlaps |= window.overlapping[index];
                if window.tiles[index] != NONE {
                    let [u, v] = window.parameters[index];
                    places.push(Place::new(window.tiles[index], u, v));
                }
            }
            overlapping += u64::from(overlaps);
            if places.len() > before {
                pixels.push((x, y, places.len() - before));
            }
        }
    }
    let mut values = Vec::with_capacity(places.len() * channels);
    quantity.evaluate(context, limit, &places, &mut values)?;
    let mut rest = &values[..];
    for (x, y, count) in pixels {
        let (own, after) = rest.split_at(count * channels);
        rest = after;
        let mut mean = [0.0; 4];
        for (channel, mean) in mean[..channels].iter_mut().enumerate() {
            *mean = own.iter().skip(channel).step_by(channels).sum::<f32>() / count as f32;
        }
        if count > 1 {
            quantity.settle(&mut mean[..channels]);
        }
        put(x, y, &mean[..channels]);
    }
    Ok(overlapping)
}
