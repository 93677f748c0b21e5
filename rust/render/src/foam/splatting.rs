//! A picture of foam to which particles are added, in chunks: by the processor, or by a graphics device.

use relievo_core::{Context, Error, Progress, Result};
use relievo_gpu::Device;

use super::bins::{Drawing, Tiles};
use super::device::Splats;
use super::environment::Environment;
use super::irradiance::irradiance;
use super::layers::{FoamLayers, Shading};
use super::occlusion::occlusion;
use super::projection::{FoamView, Projection};
use super::scenery::{Depths, Scenery};
use super::settings::FoamSettings;
use super::thickness::Thickness;
use super::{FoamParticle, intensity};

/// Particles that are moved at a time.
const CHUNK: usize = 1 << 18;
/// Bytes of a pixel beside its tile, at most, and of one that a device draws; see `docs/limits.md`.
const PIXEL_BYTES: u64 = 32;
const DEVICE_PIXEL_BYTES: u64 = 112;

/// A picture of foam to which particles are added.
#[derive(Debug)]
pub struct Foam {
    settings: FoamSettings,
    view: FoamView,
    projection: Projection,
    executor: Executor,
    particles: u64,
}

/// What draws.
#[derive(Debug)]
enum Executor {
    Processor { tiles: Tiles, depths: Depths, thickness: Thickness },
    Device(Box<Splats>),
}

impl Foam {
    /// Makes a picture without foam.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting or the view is out of range or the depths have another size than the view, and
    /// with `Memory` if the picture does not fit the memory limit of the context.
    pub fn new(context: &Context, settings: FoamSettings, view: FoamView, scenery: &Scenery) -> Result<Self> {
        Self::on(context, None, settings, view, scenery)
    }

    /// Makes a picture without foam that a graphics device draws, where there is one. It is that of the processor but
    /// for the last bits of numbers.
    ///
    /// # Errors
    /// Fails as [`Self::new`] does, with `Memory` if the device has no memory, and with `Device` if it was lost.
    pub fn on(
        context: &Context,
        device: Option<&Device>,
        settings: FoamSettings,
        view: FoamView,
        scenery: &Scenery,
    ) -> Result<Self> {
        settings.check()?;
        view.check()?;
        let pixels = view.pixels() as u64;
        let bytes = match device {
            Some(_) => DEVICE_PIXEL_BYTES * pixels,
            None => Tiles::bytes(&view) + PIXEL_BYTES * pixels,
        };
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("foam of {} × {} pixels needs {bytes} bytes", view.width, view.height))
                .advise("make the picture smaller or the memory limit larger"));
        }
        let (depths, thickness) = (scenery.depths(&view)?, Thickness::new(&settings));
        let executor = match device {
            Some(device) => Executor::Device(Box::new(Splats::new(device, &settings, &view, &thickness, &depths)?)),
            None => Executor::Processor { tiles: Tiles::new(&view), depths, thickness },
        };
        Ok(Self { settings, view, projection: Projection::new(&view), executor, particles: 0 })
    }

    /// Returns the number of particles that were added.
    pub fn particles(&self) -> u64 {
        self.particles
    }

    /// Adds particles: a part of a frame, in any order.
    ///
    /// # Errors
    /// Fails with `Invalid`, and adds none, if a number is not finite, and with `Memory` or `Device` if a device has no
    /// memory or was lost.
    pub fn add(&mut self, context: &Context, particles: &[FoamParticle]) -> Result<()> {
        check(particles)?;
        self.draw(context, particles, 1.0)?;
        self.particles += particles.len() as u64;
        Ok(())
    }

    /// Adds particles that move by velocities in m/s, one a particle, while the shutter of the settings is open: from
    /// their places on, each at several places that share its thickness.
    ///
    /// # Errors
    /// Fails with `Invalid`, and adds none, if a number is not finite, or there are not as many velocities as
    /// particles, and with `Memory` or `Device` if a device has no memory or was lost.
    pub fn add_moving(&mut self, context: &Context, particles: &[FoamParticle], velocities: &[[f32; 3]]) -> Result<()> {
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
                self.draw(context, &moved, 1.0 / shutter_samples as f32)?;
            }
        }
        self.particles += particles.len() as u64;
        Ok(())
    }

    /// Draws particles with a share of their thickness.
    fn draw(&mut self, context: &Context, particles: &[FoamParticle], share: f32) -> Result<()> {
        let Self { settings, view, projection, executor, .. } = self;
        match executor {
            Executor::Processor { tiles, depths, thickness } => {
                let with = Drawing { settings, view, projection, thickness, depths };
                tiles.draw(context, with, particles, share);
                Ok(())
            }
            Executor::Device(splats) => splats.draw(context, projection, particles, share),
        }
    }

    /// Returns the layers of all particles that were added, lit by an environment.
    ///
    /// # Errors
    /// Fails with `Cancelled` if `progress` asks to stop, and with `Memory` or `Device` if a device has no memory or
    /// was lost.
    pub fn finish(
        self,
        context: &Context,
        environment: &Environment,
        progress: &mut dyn Progress,
    ) -> Result<FoamLayers> {
        let Self { settings, view, projection, executor, .. } = self;
        let (tiles, depths) = match executor {
            Executor::Processor { tiles, depths, .. } => (tiles, depths),
            Executor::Device(splats) => return splats.finish(context, (settings, view), environment, progress),
        };
        let (surfaces, thickness) = tiles.finish(context, &view);
        let mut intensities = Vec::new();
        let of_pixel = |pixel: usize| intensity(thickness[pixel], settings.rho_mod, settings.rho_exp);
        context.map_into(thickness.len(), &mut intensities, of_pixel);
        let intensity = intensities;
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
        let device = None;
        Ok(FoamLayers { settings, view, projection, surfaces, thickness, intensity, occlusion, irradiance, device })
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
