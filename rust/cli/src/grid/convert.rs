//! `relievo grid convert`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Context, Error, Result};
use relievo_openvdb::{Box3, Class, Filter, Grid, Kind, Order, Transform, write};

use super::source::{self, Making};
use super::{Bar, Limits, Output};
use crate::Outcome;

/// Converts the grids of an OpenVDB file, a mesh, or particles to an OpenVDB file. Steps are done in this order: a label,
/// a level set or fog, an offset, smoothing, resampling, the kind of values.
#[derive(clap::Args)]
#[command(
    after_help = "Example: relievo grid convert bunny.obj -o bunny.vdb --voxel 0.001 --offset 0.002 --smooth mean --to fog"
)]
pub struct Arguments {
    /// The OpenVDB file, the mesh, or the particles.
    #[arg(value_name = "FILE")]
    from: PathBuf,
    /// The OpenVDB file to write.
    #[arg(short, long, value_name = "FILE.vdb")]
    output: PathBuf,
    /// The grid to take; all of the file if it is left out.
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,
    /// Read only what is in a box of the world: x, y and z of its lowest and its highest corner.
    #[arg(long, value_name = "NUMBERS", num_args = 6, allow_hyphen_values = true)]
    bounds: Option<Vec<f64>>,
    /// Take the voxels of a label, of a grid of integers.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    label: Option<i64>,
    /// What the values are to mean: a level set becomes fog; fog, masks and labels become a level set.
    #[arg(long, value_enum)]
    to: Option<Meaning>,
    /// The density at which fog has its surface.
    #[arg(long, value_name = "DENSITY", default_value_t = 0.5)]
    value: f64,
    /// Move the surface of level sets outwards, inwards if it is negative, in world units.
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true)]
    offset: Option<f64>,
    /// Smooth level sets and fog.
    #[arg(long, value_enum, value_name = "FILTER")]
    smooth: Option<Smoothing>,
    /// Half the width of the filter in voxels.
    #[arg(long, value_name = "VOXELS", default_value_t = 1)]
    radius: u32,
    /// How often the filter is applied.
    #[arg(long, value_name = "N", default_value_t = 1)]
    iterations: u32,
    /// The kind of values: float, double, bool, mask, int32, int64, vec3s, vec3d or vec3i.
    #[arg(long, value_parser = super::kind)]
    kind: Option<Kind>,
    #[command(flatten)]
    making: Making,
    #[command(flatten)]
    written: Output,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Meaning {
    /// Distances to a surface.
    LevelSet,
    /// Densities.
    Fog,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Smoothing {
    /// The mean of a cube of voxels.
    Mean,
    /// Nearly a Gaussian.
    Gaussian,
    /// The median of a cube of voxels.
    Median,
    /// Laplacian flow, of level sets.
    Laplacian,
    /// Mean curvature flow, of level sets.
    MeanCurvature,
}

impl Smoothing {
    fn filter(self) -> Filter {
        match self {
            Self::Mean => Filter::Mean,
            Self::Gaussian => Filter::Gaussian,
            Self::Median => Filter::Median,
            Self::Laplacian => Filter::Laplacian,
            Self::MeanCurvature => Filter::MeanCurvature,
        }
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let bounds = arguments.bounds.as_deref().and_then(|at| at.as_chunks().0.try_into().ok());
    let bounds: Option<Box3> = bounds.map(|[low, high]: [[f64; 3]; 2]| [low, high]);
    let grids = source::grids(&context, &arguments.from, arguments.grid.as_deref(), bounds, &arguments.making)?;
    let named = |error: Error| error.at(arguments.from.display().to_string());
    let made = grids.into_iter().map(|grid| arguments.convert(&context, grid).map_err(named));
    let mut made: Vec<Grid> = made.collect::<Result<_>>()?;
    if arguments.written.half {
        made.iter_mut().try_for_each(|grid| grid.set_half(true))?;
    }
    let list: Vec<&Grid> = made.iter().collect();
    write(&context, &arguments.output, &list, &arguments.written.writing(), &mut Bar::new())?;
    let lines = made.iter().map(super::line).collect::<Result<String>>()?;
    crate::print(&lines)?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn convert(&self, context: &Context, grid: Grid) -> Result<Grid> {
        let mut bar = Bar::new();
        let mut grid = grid;
        if let Some(label) = self.label {
            grid = grid.label_mask(context, label, &mut bar)?;
        }
        let class = grid.info()?.class;
        match self.to {
            Some(Meaning::LevelSet) if class != Class::LevelSet => {
                grid = grid.level_set(context, self.value, self.making.band, &mut bar)?;
            }
            Some(Meaning::Fog) if class == Class::LevelSet && !self.moves() => grid = grid.fog(context, &mut bar)?,
            _ => {}
        }
        if let Some(distance) = self.offset {
            grid = grid.offset(context, distance, &mut bar)?;
        }
        if let Some(smoothing) = self.smooth {
            grid = grid.filtered(context, smoothing.filter(), self.radius, self.iterations, &mut bar)?;
        }
        // A surface is moved and smoothed before it is fog.
        if self.to == Some(Meaning::Fog) && grid.info()?.class == Class::LevelSet {
            grid = grid.fog(context, &mut bar)?;
        }
        if let Some(voxel) = self.making.voxel.filter(|_| source::is_vdb(&self.from)) {
            grid = grid.resampled(context, &Transform::uniform(voxel), Order::Linear, &mut bar)?;
        }
        match self.kind {
            Some(kind) => grid.converted(context, kind, &mut bar),
            None => Ok(grid),
        }
    }

    fn moves(&self) -> bool {
        self.offset.is_some() || self.smooth.is_some()
    }
}
