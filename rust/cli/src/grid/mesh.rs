//! `relievo grid mesh`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, Result};
use relievo_openvdb::{Class, Grid, Kind, read};

use super::{Bar, Limits, mesh_of};
use crate::Outcome;

/// Meshes the surface of a grid: where a level set is 0, fog has a density, or a mask, a bool or a label ends.
#[derive(clap::Args)]
#[command(after_help = "Example: relievo grid mesh bunny.vdb -o bunny.ply --adaptivity 0.1")]
pub struct Arguments {
    /// The OpenVDB file.
    #[arg(value_name = "FILE.vdb")]
    from: PathBuf,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The grid; the first that can be read if it is left out.
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,
    /// The value at the surface; left out, 0 of level sets and 0.5 of others.
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    value: Option<f64>,
    /// How much polygons may grow where the surface is flat: 0 for quads of one size, up to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    adaptivity: f64,
    /// The label to mesh, of a grid of integers.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    label: Option<i64>,
    #[command(flatten)]
    limits: Limits,
}

/// Half the width of the band that is made of masks, in voxels.
const BAND: f32 = 3.0;

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let named = |error: Error| error.at(arguments.from.display().to_string());
    let grid = read(&context, &arguments.from, arguments.grid.as_deref(), None, &mut Bar::new())?;
    let surface = || -> Result<Grid> {
        let mask = match arguments.label {
            Some(label) => grid.label_mask(&context, label, &mut Bar::new())?,
            None => grid,
        };
        match mask.kind()? {
            Kind::Bool | Kind::Mask => mask.level_set(&context, 0.0, BAND, &mut Bar::new()),
            _ => Ok(mask),
        }
    };
    let surface = surface().map_err(named)?;
    let level = if surface.info()?.class == Class::LevelSet { 0.0 } else { 0.5 };
    let value = arguments.value.unwrap_or(level);
    let polygons = surface.polygons(&context, value, arguments.adaptivity, &mut Bar::new()).map_err(named)?;
    let (triangles, quads) = (polygons.triangles.len(), polygons.quads.len());
    if triangles + quads == 0 {
        let error = Error::invalid(format!("the grid has no surface at {value}"));
        return Err(named(
            error.advise("take another --value or --label; a mesh with holes has no inside: repair it first"),
        )
        .into());
    }
    relievo_meshio::write(&arguments.output, &mesh_of(polygons))?;
    crate::print(&format!("{quads} quads, {triangles} triangles\n"))?;
    Ok(ExitCode::SUCCESS)
}
