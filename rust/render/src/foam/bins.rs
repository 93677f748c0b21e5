//! Splatting on the processor: particles of a chunk go into bins by the tiles of the picture that they touch, and every tile
//! draws its own in parallel.

use relievo_core::Context;
use relievo_core::simd::prefetch;

use super::FoamParticle;
use super::depth::{Nearest, Sprite};
use super::layers::Surfaces;
use super::projection::{FoamView, Projection};
use super::scenery::Depths;
use super::settings::FoamSettings;
use super::thickness::{Thickness, of_sum};

/// Side of a tile in pixels.
const SIDE: u32 = 64;
/// Pixels of a tile.
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Particles whose bins are in memory at a time, and those of a task.
const CHUNK: usize = 1 << 18;
const CHUNK_LEN: usize = 1 << 13;
/// How many entries of a bin before it is drawn a particle is asked from memory.
const AHEAD: usize = 8;
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
struct Tile<'a> {
    left: u32,
    top: u32,
    pixels: &'a mut [Pixel],
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
    /// Those of all tiles, one after the other: one block of memory, which goes back to the system as a whole.
    pixels: Vec<Pixel>,
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
        let tiles = columns as usize * view.height.div_ceil(SIDE) as usize;
        Self { columns, pixels: vec![Pixel::default(); tiles * PIXELS] }
    }

    /// Draws particles with a share of their thickness.
    pub fn draw(&mut self, context: &Context, with: Drawing<'_>, particles: &[FoamParticle], share: f32) {
        for chunk in particles.chunks(CHUNK) {
            let bins = context.map(chunk.len().div_ceil(CHUNK_LEN), |part| {
                let first = part * CHUNK_LEN;
                self.bins(with, &chunk[first..chunk.len().min(first + CHUNK_LEN)], first)
            });
            let tiles = (0..).zip(self.pixels.chunks_exact_mut(PIXELS)).map(|(number, pixels)| Tile {
                left: number % self.columns * SIDE,
                top: number / self.columns * SIDE,
                pixels,
            });
            context.for_each_mut(&mut tiles.collect::<Vec<_>>(), |number, tile| {
                for bin in &bins {
                    let from = bin.partition_point(|entry| entry >> 32 < number as u64);
                    let ahead = bin.iter().skip(from + AHEAD).chain(std::iter::repeat(&0));
                    let own = bin[from..].iter().take_while(|entry| **entry >> 32 == number as u64);
                    for (entry, next) in own.zip(ahead) {
                        prefetch(chunk, *next as u32 as usize);
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
            // What is too old to be seen is left out where it is drawn, so that lifetimes are looked at once.
            let Some(sprite) = Sprite::unfaded(with.projection, with.settings, particle) else { continue };
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
    pub fn finish(self, context: &Context, view: &FoamView) -> (Surfaces, Vec<f32>) {
        let (width, pixels) = (view.width as usize, view.pixels());
        let mut surfaces =
            Surfaces { depth: vec![0.0; pixels], search: vec![0.0; pixels], disc: vec![[0.0; 2]; pixels] };
        let mut thickness = vec![0.0; pixels];
        let Surfaces { depth, search, disc } = &mut surfaces;
        let lists = depth.chunks_mut(width).zip(search.chunks_mut(width));
        let lists = lists.zip(disc.chunks_mut(width)).zip(thickness.chunks_mut(width));
        context.for_each_mut(&mut lists.collect::<Vec<_>>(), |y, (((depth, search), disc), thickness)| {
            let first = y / SIDE as usize * self.columns as usize;
            for (x, thickness) in thickness.iter_mut().enumerate() {
                let tile = &self.pixels[(first + x / SIDE as usize) * PIXELS..][..PIXELS];
                let pixel = &tile[y % SIDE as usize * SIDE as usize + x % SIDE as usize];
                depth[x] = pixel.nearest.depth;
                search[x] = pixel.nearest.search;
                disc[x] = [pixel.nearest.u, pixel.nearest.v];
                *thickness = of_sum(pixel.thickness);
            }
        });
        (surfaces, thickness)
    }
}

impl Drawing<'_> {
    #[inline]
    fn sprite(&self, particle: &FoamParticle) -> Option<Sprite> {
        Sprite::new(self.projection, self.settings, self.thickness, particle)
    }
}

impl Tile<'_> {
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
