//! What `relievo fluid sim` simulates.

use std::path::Path;

use glam::Vec3;
use relievo_core::{Context, Error, Result, file};
use relievo_fluid::{Excess, Fluid, FluidOptions, KernelSet, TimeStep, basin, block};
use serde::Deserialize;

/// Bytes of a description at most.
const LONGEST: u64 = 1 << 20;

/// A fluid, what it begins as, and how many frames of it there are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Frames after the first, which is what the fluid begins as.
    pub frames: u32,
    #[serde(default = "fps")]
    pub fps: f64,
    #[serde(default)]
    fluid: Options,
    basin: Option<Box>,
    #[serde(default)]
    block: Vec<Block>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Options {
    spacing: f32,
    density: f32,
    viscosity: f32,
    friction: f32,
    cohesion: f32,
    gravity: [f32; 3],
    kernels: String,
    excess: [f32; 2],
    corrections: [u32; 2],
    time_step: Option<f32>,
    courant: f32,
    longest_step: f32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Box {
    low: [f32; 3],
    high: [f32; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Block {
    low: [f32; 3],
    high: [f32; 3],
    #[serde(default)]
    velocity: [f32; 3],
}

impl Default for Options {
    fn default() -> Self {
        let FluidOptions { spacing, density, viscosity, friction, cohesion, gravity, excess, corrections, .. } =
            FluidOptions::default();
        let excess = [excess.most, excess.mean];
        let TimeStep::Courant { number, most } = FluidOptions::default().time_step else { unreachable!() };
        Self {
            spacing,
            density,
            viscosity,
            friction,
            cohesion,
            gravity: gravity.into(),
            kernels: "wendland".into(),
            excess,
            corrections,
            time_step: None,
            courant: number,
            longest_step: most,
        }
    }
}

fn fps() -> f64 {
    24.0
}

impl Description {
    /// Reads a description. Fails if it cannot be read, has unknown keys, or no frames that could be simulated.
    pub fn read(path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, LONGEST)?;
        let text = std::str::from_utf8(&bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
        let read: Self = toml::from_str(text).map_err(|error| named(Error::invalid(error.to_string())))?;
        if !(read.fps > 1e-3 && read.fps < 1e6) {
            return Err(named(Error::invalid(format!("{} frames a second cannot be", read.fps)).at("fps")));
        }
        Ok(read)
    }

    /// The spacing of particles.
    pub fn spacing(&self) -> f32 {
        self.fluid.spacing
    }

    /// The fluid as it begins.
    pub fn begin(&self, context: &Context) -> Result<Fluid> {
        let options = &self.fluid;
        let kernels = match options.kernels.as_str() {
            "wendland" => KernelSet::Wendland,
            "mueller" => KernelSet::Mueller,
            other => {
                let error = Error::invalid(format!("there are no kernels {other:?}")).at("fluid.kernels");
                return Err(error.advise("use wendland or mueller"));
            }
        };
        let [most, mean] = options.excess;
        let courant = TimeStep::Courant { number: options.courant, most: options.longest_step };
        let mut fluid = Fluid::new(FluidOptions {
            spacing: options.spacing,
            density: options.density,
            viscosity: options.viscosity,
            friction: options.friction,
            cohesion: options.cohesion,
            gravity: options.gravity.into(),
            kernels,
            excess: Excess { most, mean },
            corrections: options.corrections,
            time_step: options.time_step.map_or(courant, TimeStep::Fixed),
        })?;
        for (number, Block { low, high, velocity }) in self.block.iter().enumerate() {
            let named = |error: Error| error.at(format!("block {number}"));
            let places = block(Vec3::from(*low), Vec3::from(*high), options.spacing).map_err(named)?;
            fluid.add(&places, Vec3::from(*velocity)).map_err(named)?;
        }
        if let Some(Box { low, high }) = &self.basin {
            let places = basin(Vec3::from(*low), Vec3::from(*high), options.spacing);
            fluid.set_walls(context, &places.map_err(|error| error.at("basin"))?)?;
        }
        Ok(fluid)
    }
}
