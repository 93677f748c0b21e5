//! What grids are made of: a grid of a file, a mesh, or particles.

use std::path::Path;

use relievo_core::{Context, Error, Result};
use relievo_openvdb::{Box3, Grid, Survey, Transform, read};

use super::Bar;

/// How a mesh or particles become a level set.
#[derive(clap::Args)]
pub struct Making {
    /// The edge of a voxel. Of a mesh or particles: left out, a 128th of the longest edge of its box. Of a grid: left out,
    /// as it is.
    #[arg(long, value_name = "SIZE")]
    pub voxel: Option<f64>,
    /// Half the width of the band of distances, in voxels.
    #[arg(long, value_name = "VOXELS", default_value_t = 3.0)]
    pub band: f32,
    /// The radius of particles; left out, their spacing.
    #[arg(long, value_name = "SIZE")]
    pub particle_radius: Option<f32>,
}

/// Voxels along the longest edge of a box, where no size is asked for.
const VOXELS: f64 = 128.0;

pub fn is_vdb(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vdb"))
}

fn is_particles(path: &Path) -> bool {
    let known = |extension: &std::ffi::OsStr| {
        ["rlvfluid", "bgeo", "vtk"].iter().any(|known| extension.eq_ignore_ascii_case(known))
    };
    path.extension().is_some_and(known)
}

/// Reads the grids of a file, or makes a level set of a mesh or particles.
pub fn grids(
    context: &Context,
    path: &Path,
    name: Option<&str>,
    bounds: Option<Box3>,
    making: &Making,
) -> Result<Vec<Grid>> {
    if !is_vdb(path) {
        if name.is_some() || bounds.is_some() {
            let error = Error::invalid("a mesh and particles have no grids to choose from");
            return Err(error.at(path.display().to_string()).advise("leave --grid and --bounds out"));
        }
        return Ok(vec![level_set(context, path, making)?]);
    }
    if let Some(name) = name {
        return Ok(vec![read(context, path, Some(name), bounds, &mut Bar::new())?]);
    }
    let survey = Survey::of_file(path, context.memory_limit())?;
    survey.find(None).map_err(|error| error.at(path.display().to_string()))?;
    let mut grids = Vec::new();
    for grid in &survey.grids {
        if survey.find(Some(&grid.name)).is_err() {
            eprintln!("note: {}: grid {} ({}) is left out", path.display(), grid.name, grid.tree);
            continue;
        }
        grids.push(read(context, path, Some(&grid.name), bounds, &mut Bar::new())?);
    }
    Ok(grids)
}

/// Makes a level set of a mesh or particles.
fn level_set(context: &Context, path: &Path, making: &Making) -> Result<Grid> {
    let named = |error: Error| error.at(path.display().to_string());
    let mut grid = if is_particles(path) {
        let particles = relievo_particleio::read(context, path)?.particles;
        let radius = making
            .particle_radius
            .or(particles.spacing)
            .ok_or_else(|| named(Error::invalid("the particles state no spacing").advise("give --particle-radius")))?;
        let voxel = making.voxel.unwrap_or(f64::from(radius) / 3.0);
        let radii = vec![radius; particles.points.len()];
        Grid::of_spheres(context, &particles.points, &radii, voxel, making.band, &mut Bar::new()).map_err(named)?
    } else {
        let mesh = relievo_meshio::read(context, path)?;
        let (low, high) = mesh.bounds().ok_or_else(|| named(Error::invalid("the mesh has no points")))?;
        let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
        let transform = Transform::uniform(making.voxel.unwrap_or(longest / VOXELS));
        let band = [making.band; 2];
        Grid::of_mesh(context, &mesh.points, &mesh.triangles(), &transform, band, &mut Bar::new()).map_err(named)?
    };
    grid.set_name(&path.file_stem().unwrap_or_default().to_string_lossy())?;
    Ok(grid)
}
