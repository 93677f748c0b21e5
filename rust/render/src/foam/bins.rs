//! Splatting: particles come in chunks, go into bins by the tiles of the picture that they touch, and every tile draws its
//! own in parallel.

use relievo_core::{Context, Error, Progress, Result};

use super::depth::{Nearest, Sprite};
use super::environment::Environment;
use super::irradiance::irradiance;
use super::layers::{FoamLayers, Shading, Surfaces};
use super::occlusion::occlusion;
use super::projection::{FoamView, Projection};
use super::scenery::{Depths, Scenery};
use super::settings::FoamSettings;
use super::thickness::{Thickness, of_sum};
use super::{FoamParticle, intensity};

/// Side of a tile in pixels.
const SIDE: u32 = 64;
/// Particles whose bins are in memory at a time, and those of a task.
const CHUNK: usize = 1 << 18;
const PART: usize = 1 << 13;
/// Bytes of a particle's entries in bins, and of a pixel beside its tile, at most; see `docs/limits.md`.
const BIN_BYTES: u64 = 16;
const PIXEL_BYTES: u64 = 32;

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

/// A picture of foam to which particles are added.
#[derive(Debug)]
pub struct Foam {
    settings: FoamSettings,
    view: FoamView,
    projection: Projection,
    thickness: Thickness,
    depths: Depths,
    columns: u32,
    tiles: Vec<Tile>,
    particles: u64,
}

impl Foam {
    /// Makes a picture without foam. Fails if a setting is out of range, the depths have another size than the view, or
    /// the picture does not fit the memory limit of the context.
    pub fn new(context: &Context, settings: FoamSettings, view: FoamView, scenery: &Scenery) -> Result<Self> {
        settings.check()?;
        view.check()?;
        let columns = view.width.div_ceil(SIDE);
        let count = columns * view.height.div_ceil(SIDE);
        let tile_bytes = u64::from(SIDE * SIDE) * size_of::<Pixel>() as u64;
        let bytes = u64::from(count) * tile_bytes + PIXEL_BYTES * view.pixels() as u64 + BIN_BYTES * CHUNK as u64;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("foam of {} × {} pixels needs {bytes} bytes", view.width, view.height))
                .advise("make the picture smaller or the memory limit larger"));
        }
        let depths = scenery.depths(&view)?;
        let tile = |number: u32| Tile {
            left: number % columns * SIDE,
            top: number / columns * SIDE,
            pixels: vec![Pixel::default(); (SIDE * SIDE) as usize],
        };
        let tiles = (0..count).map(tile).collect();
        let (projection, thickness) = (Projection::new(&view), Thickness::new(&settings));
        Ok(Self { settings, view, projection, thickness, depths, columns, tiles, particles: 0 })
    }

    /// Returns the number of particles that were added.
    pub fn particles(&self) -> u64 {
        self.particles
    }

    /// Adds particles: a part of a frame, in any order. Fails, and adds none, if a number is not finite.
    pub fn add(&mut self, context: &Context, particles: &[FoamParticle]) -> Result<()> {
        check(particles)?;
        self.draw(context, particles, 1.0);
        self.particles += particles.len() as u64;
        Ok(())
    }

    /// Adds particles that move by velocities in m/s, one a particle, while the shutter of the settings is open: from their
    /// places on, each at several places that share its thickness. Fails, and adds none, if a number is not finite, or there
    /// are not as many velocities as particles.
    pub fn add_moving(
        &mut self,
        context: &Context,
        particles: &[FoamParticle],
        velocities: &[[f32; 3]],
    ) -> Result<()> {
        check(particles)?;
        if velocities.len() != particles.len() || !velocities.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(Error::invalid("the velocities of particles of foam are not finite, or not as many as those")
                .at("velocities"));
        }
        let FoamSettings { shutter, shutter_samples, .. } = self.settings;
        if shutter == 0.0 {
            return self.add(context, particles);
        }
        for (part, velocities) in particles.chunks(CHUNK).zip(velocities.chunks(CHUNK)) {
            for sample in 0..shutter_samples {
                let moved = context.map(part.len(), |at| {
                    let (particle, velocity) = (part[at], velocities[at]);
                    // Particles are not all at the same place of their ways, so that no copies of the foam are seen.
                    let shift = particle.id.wrapping_mul(0x9e37_79b9) as f32 / 4_294_967_296.0;
                    let time = shutter * (sample as f32 + shift) / shutter_samples as f32;
                    let position = std::array::from_fn(|axis| particle.position[axis] + time * velocity[axis]);
                    FoamParticle { position, ..particle }
                });
                self.draw(context, &moved, 1.0 / shutter_samples as f32);
            }
        }
        self.particles += particles.len() as u64;
        Ok(())
    }

    /// Draws particles with a share of their thickness.
    fn draw(&mut self, context: &Context, particles: &[FoamParticle], share: f32) {
        for chunk in particles.chunks(CHUNK) {
            let bins = context.map(chunk.len().div_ceil(PART), |part| {
                let first = part * PART;
                self.bins(&chunk[first..chunk.len().min(first + PART)], first)
            });
            let Self { settings, view, projection, thickness, depths, tiles, .. } = self;
            let (size, width) = ([view.width, view.height], view.width as usize);
            context.for_each_mut(tiles, |number, tile| {
                for bin in &bins {
                    let from = bin.partition_point(|entry| entry >> 32 < number as u64);
                    for entry in bin[from..].iter().take_while(|entry| **entry >> 32 == number as u64) {
                        let particle = &chunk[*entry as u32 as usize];
                        if let Some(mut sprite) = Sprite::new(projection, settings, thickness, particle) {
                            sprite.share *= share;
                            tile.draw(&sprite, size, depths, width, thickness);
                        }
                    }
                }
            });
        }
    }

    /// Returns an entry for each tile that a particle touches, in order: the number of the tile above that of the particle.
    fn bins(&self, particles: &[FoamParticle], first: usize) -> Vec<u64> {
        let mut bins = Vec::with_capacity(particles.len());
        for (particle, number) in particles.iter().zip(first as u64..) {
            let Some(sprite) = Sprite::new(&self.projection, &self.settings, &self.thickness, particle) else {
                continue;
            };
            let [left, right] = Sprite::span(sprite.middle.x, sprite.drawn, self.view.width);
            let [top, bottom] = Sprite::span(sprite.middle.y, sprite.drawn, self.view.height);
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

    /// Returns the layers of all particles that were added, lit by an environment. Fails if `progress` asks to stop.
    pub fn finish(
        self,
        context: &Context,
        environment: &Environment,
        progress: &mut dyn Progress,
    ) -> Result<FoamLayers> {
        let Self { settings, view, projection, depths, columns, tiles, .. } = self;
        let pixel = |x: u32, y: u32| {
            let tile = &tiles[(y / SIDE * columns + x / SIDE) as usize];
            &tile.pixels[(y % SIDE * SIDE + x % SIDE) as usize]
        };
        let places = || (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
        let surfaces = Surfaces {
            depth: places().map(|(x, y)| pixel(x, y).nearest.depth).collect(),
            search: places().map(|(x, y)| pixel(x, y).nearest.search).collect(),
            disc: places().map(|(x, y)| [pixel(x, y).nearest.u, pixel(x, y).nearest.v]).collect(),
        };
        let thickness: Vec<f32> = places().map(|(x, y)| of_sum(pixel(x, y).thickness)).collect();
        drop(tiles);
        let intensity = thickness.iter().map(|thickness| intensity(*thickness, settings.rho_mod, settings.rho_exp));
        let intensity: Vec<f32> = intensity.collect();
        let of = Shading {
            settings: &settings,
            view: &view,
            projection: &projection,
            depths: &depths,
            surfaces: &surfaces,
            intensity: &intensity,
        };
        let occlusion = occlusion(context, &of, progress)?;
        let irradiance = irradiance(context, &of, environment);
        Ok(FoamLayers { settings, view, projection, surfaces, thickness, intensity, occlusion, irradiance })
    }
}

/// Checks that all numbers of particles are finite.
fn check(particles: &[FoamParticle]) -> Result<()> {
    let is_sound = |it: &FoamParticle| it.life.is_finite() && it.position.iter().all(|value| value.is_finite());
    match particles.iter().position(|particle| !is_sound(particle)) {
        Some(at) => Err(Error::invalid("a particle of foam is not finite").at(format!("particle {at}"))),
        None => Ok(()),
    }
}

impl Tile {
    /// Draws a sprite into the tile of a picture.
    fn draw(&mut self, sprite: &Sprite, size: [u32; 2], depths: &Depths, width: usize, thickness: &Thickness) {
        let clip = |middle: f32, low: u32, size: u32| {
            let [first, end] = Sprite::span(middle, sprite.drawn, size.min(low + SIDE));
            first.max(low)..end
        };
        let columns = clip(sprite.middle.x, self.left, size[0]);
        for y in clip(sprite.middle.y, self.top, size[1]) {
            for x in columns.clone() {
                let Some(fragment) = sprite.fragment(x, y) else { continue };
                let at = y as usize * width + x as usize;
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
