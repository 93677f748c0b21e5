//! `relievo mesh tessellate`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Context, Result};
use relievo_meshio::{Patches, read_patches, write, write_bpt};
use relievo_surface::bezier::{BezierSurface, Levels, MAX_LEVEL, ParametricMap};

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The file of Bézier patches: .bpt, or a list of indices and points.
    file: PathBuf,
    /// What to write: .ply, .glb, .obj, .usda, .stl or .off for a mesh, .bpt for the patches as they are.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The level of all patches: each is divided into 2^(level + 1) − 1 quads a side.
    #[arg(short, long, value_name = "LEVEL", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LEVEL)))]
    level: u32,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let patches = read_patches(&context, &arguments.file)?;
    if arguments.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bpt")) {
        write_bpt(&arguments.output, &patches)?;
        return Ok(ExitCode::SUCCESS);
    }
    let surface = surface_of(&context, &arguments.file, &patches)?;
    let levels = Levels::uniform(&surface, arguments.level)?;
    let mesh = surface.tessellate(&context, &levels)?.mesh();
    write(&arguments.output, &mesh)?;
    let side = ParametricMap::new(arguments.level)?.segments();
    eprintln!("{} patches, {side} × {side} quads each: {} triangles", surface.count(), mesh.face_count());
    Ok(ExitCode::SUCCESS)
}

/// The surface of the patches in a file.
pub fn surface(context: &Context, path: &Path) -> Result<BezierSurface> {
    surface_of(context, path, &read_patches(context, path)?)
}

fn surface_of(context: &Context, path: &Path, patches: &Patches) -> Result<BezierSurface> {
    BezierSurface::new(context, &patches.points, Some(&patches.indices), patches.weights.as_deref())
        .map_err(|error| error.at(path.display().to_string()))
}
