//! Splatting on the processor: particles of a chunk go into bins by the tiles of the picture that they touch, and every tile
//! draws its own in parallel.

use relievo_core::Context;

use super::FoamParticle;
use super::depth::{Nearest, Sprite};
use super::layers::Surfaces;
use super::projection::{FoamView, Projection};
use super::scenery::Depths;
use super::settings::FoamSettings;
use super::thickness::{Thickness, of_sum};

/// Side of a tile in pixels.
const SIDE: u32 = 64;
/// Particles whose bins are in memory at a time, and those of a task.
const CHUNK: usize = 1 << 18;
const PART: usize = 1 << 13;
/// Bytes of a particle's entries in bins at most; see `docs/limits.md`.
const BIN_BYTES: u64 = 16;

/// A pixel while particles are added.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    nearest: Nearest,
    thickness: u64,
}

/// Pixels of a tile, row after row; a tile at the border has those beyond it too.
#[derive(Debug)]
struct Tile {
    left: u32,
    top: u32,
    pixels: Vec<Pixel>,
}

/// What particles are drawn with.
#[derive(Clone, Copy)]
pub struct Drawing<'a> {
    pub settings: &'a FoamSettings,
    pub view: &'a FoamView,
    pub projection: &'a Projection,
    pub thickness: &'a Thickness,
    pub depths: &'a Depths,
}

/// The tiles of a picture, to which particles are added.
#[derive(Debug)]
pub struct Tiles {
    columns: u32,
    tiles: Vec<Tile>,
}

impl Tiles {
    /// Returns the bytes of the tiles of a view, with the bins of a chunk.
    pub fn bytes(view: &FoamView) -> u64 {
        let count = u64::from(view.width.div_ceil(SIDE)) * u64::from(view.height.div_ceil(SIDE));
        count * u64::from(SIDE * SIDE) * size_of::<Pixel>() as u64 + BIN_BYTES * CHUNK as u64
    }

    /// Makes empty tiles.
    pub fn new(view: &FoamView) -> Self {
        let columns = view.width.div_ceil(SIDE);
        let tile = |number: u32| Tile {
            left: number % columns * SIDE,
            top: number / columns * SIDE,
            pixels: vec![Pixel::default(); (SIDE * SIDE) as usize],
        };
        Self { columns, tiles: (0..columns * view.height.div_ceil(SIDE)).map(tile).collect() }
    }

    /// Draws particles with a share of their thickness.
    pub fn draw(&mut self, context: &Context, with: Drawing<'_>, particles: &[FoamParticle], share: f32) {
        for chunk in particles.chunks(CHUNK) {
            let bins = context.map(chunk.len().div_ceil(PART), |part| {
                let first = part * PART;
                self.bins(with, &chunk[first..chunk.len().min(first + PART)], first)
            });
            context.for_each_mut(&mut self.tiles, |number, tile| {
                for bin in &bins {
                    let from = bin.partition_point(|entry| entry >> 32 < number as u64);
                    for entry in bin[from..].iter().take_while(|entry| **entry >> 32 == number as u64) {
                        let particle = &chunk[*entry as u32 as usize];
                        if let Some(mut sprite) = with.sprite(particle) {
                            sprite.share *= share;
                            tile.draw(&sprite, with);
                        }
                    }
                }
            });
        }
    }

    /// Returns an entry for each tile that a particle touches, in order: the number of the tile above that of the particle.
    fn bins(&self, with: Drawing<'_>, particles: &[FoamParticle], first: usize) -> Vec<u64> {
        let mut bins = Vec::with_capacity(particles.len());
        for (particle, number) in particles.iter().zip(first as u64..) {
            let Some(sprite) = with.sprite(particle) else { continue };
            let [left, right] = Sprite::span(sprite.middle.x, sprite.drawn, with.view.width);
            let [top, bottom] = Sprite::span(sprite.middle.y, sprite.drawn, with.view.height);
            if left >= right || top >= bottom {
                continue;
            }
            for row in top / SIDE..=(bottom - 1) / SIDE {
                for column in left / SIDE..=(right - 1) / SIDE {
                    bins.push(u64::from(row * self.columns + column) << 32 | number);
                }
            }
        }
        bins.sort_unstable();
        bins
    }

    /// Returns the nearest fragments and the thickness of all pixels of a view.
    pub fn finish(self, view: &FoamView) -> (Surfaces, Vec<f32>) {
        let pixel = |x: u32, y: u32| {
            let tile = &self.tiles[(y / SIDE * self.columns + x / SIDE) as usize];
            &tile.pixels[(y % SIDE * SIDE + x % SIDE) as usize]
        };
        let places = || (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
        let surfaces = Surfaces {
            depth: places().map(|(x, y)| pixel(x, y).nearest.depth).collect(),
            search: places().map(|(x, y)| pixel(x, y).nearest.search).collect(),
            disc: places().map(|(x, y)| [pixel(x, y).nearest.u, pixel(x, y).nearest.v]).collect(),
        };
        (surfaces, places().map(|(x, y)| of_sum(pixel(x, y).thickness)).collect())
    }
}

impl Drawing<'_> {
    #[inline]
    fn sprite(&self, particle: &FoamParticle) -> Option<Sprite> {
        Sprite::new(self.projection, self.settings, self.thickness, particle)
    }
}

impl Tile {
    /// Draws a sprite into the tile of a picture.
    fn draw(&mut self, sprite: &Sprite, with: Drawing<'_>) {
        let Drawing { view, depths, thickness, .. } = with;
        let clip = |middle: f32, low: u32, size: u32| {
            let [first, end] = Sprite::span(middle, sprite.drawn, size.min(low + SIDE));
            first.max(low)..end
        };
        let columns = clip(sprite.middle.x, self.left, view.width);
        for y in clip(sprite.middle.y, self.top, view.height) {
            for x in columns.clone() {
                let Some(fragment) = sprite.fragment(x, y) else { continue };
                let at = y as usize * view.width as usize + x as usize;
                if fragment.depth > depths.solids[at] {
                    continue;
                }
                let pixel = &mut self.pixels[((y - self.top) * SIDE + x - self.left) as usize];
                pixel.nearest.take(sprite, &fragment);
                pixel.thickness += thickness.of_fragment(sprite, &fragment, depths.fluid[at]);
            }
        }
    }
}
