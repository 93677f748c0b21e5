//! `relievo foam composite`: foam over a finished picture of any renderer.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::ValueEnum;
use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_render::foam::{FoamView, Lens, Scenery};
use relievo_render::{Camera, Image, Lights, Picture};

use super::picture::{Options, summary};
use super::source::Source;
use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::args::limits::Limits;
use crate::args::numbers::vector;

#[derive(clap::Args)]
pub struct Arguments {
    /// The frame of foam.
    foam: PathBuf,
    /// The picture to lay it over: .exr or .png.
    #[arg(long, value_name = "FILE")]
    picture: PathBuf,
    /// What the depths in the picture are of, where it has some.
    #[arg(long, value_enum, default_value_t = DepthOf::Fluid)]
    depth: DepthOf,
    /// An EXR file with the depths of solids.
    #[arg(long, value_name = "FILE")]
    solids: Option<PathBuf>,
    /// An EXR file with the depths of the fluid's surface.
    #[arg(long, value_name = "FILE")]
    fluid: Option<PathBuf>,
    /// Where the camera is.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    eye: DVec3,
    /// Where it looks.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    target: DVec3,
    /// The direction that is up in the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, default_value = "0,0,1")]
    up: DVec3,
    /// Its vertical field of view.
    #[arg(long, value_name = "DEGREES", default_value_t = 35.0)]
    fov: f64,
    /// Metres that the picture of an orthographic camera is high.
    #[arg(long, value_name = "METRES")]
    orthographic: Option<f64>,
    #[command(flatten)]
    options: Options,
    /// What draws the foam.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    limits: Limits,
}

/// What depths are of.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DepthOf {
    /// The surface of the fluid, within which foam fades.
    Fluid,
    /// Solids, which hide foam.
    Solids,
}

pub fn run(arguments: &Arguments) -> Outcome {
    arguments.options.check()?;
    let context = arguments.limits.context()?;
    let mut foam = Source::open(&context, &arguments.foam)?;
    let picture = Picture::read(&arguments.picture, context.memory_limit())?;
    let scenery = arguments.scenery(&context, picture.depth)?;
    let Arguments { eye, target, up, fov, orthographic, .. } = *arguments;
    let view = FoamView {
        camera: Camera::look_at(eye, target, up, fov.to_radians())?,
        lens: orthographic.map_or(Lens::Perspective, Lens::Orthographic),
        width: picture.color.width(),
        height: picture.color.height(),
    };
    let device = arguments.adapter.open(arguments.device, context.memory_limit())?;
    let start = Instant::now();
    let executors = (&context, device.as_ref());
    let layers = arguments.options.layers(executors, &mut foam, view, &scenery, &Lights::default())?;
    arguments.options.write(&context, arguments.options.output(), &picture.color, &layers)?;
    crate::print(&summary(&foam, &layers, start.elapsed().as_secs_f64()))?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    /// Returns the depths of the files, and those of the picture where a file does not replace them.
    fn scenery(&self, context: &Context, own: Option<Image>) -> Result<Scenery> {
        let read = |path: &PathBuf| {
            let picture = Picture::read_depth(path, context.memory_limit())?;
            picture.ok_or_else(|| {
                Error::invalid("the file has no depths")
                    .at(path.display().to_string())
                    .advise("give it the channel Z, or Blender's pass of depth")
            })
        };
        let mut scenery = Scenery {
            solids: self.solids.as_ref().map(read).transpose()?,
            fluid: self.fluid.as_ref().map(read).transpose()?,
        };
        let place = match self.depth {
            DepthOf::Fluid => &mut scenery.fluid,
            DepthOf::Solids => &mut scenery.solids,
        };
        if place.is_none() {
            *place = own;
        }
        Ok(scenery)
    }
}
