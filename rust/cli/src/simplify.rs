//! `relievo simplify`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::progress::Silent;
use relievo_core::{Error, Mesh, Result};
use relievo_lod::{SimplifyOptions, Welded, simplify, weld};

use crate::Outcome;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("goal").required(true).multiple(true))]
pub struct Arguments {
    /// The mesh; its polygons are taken as triangles, and points at the same place as one.
    file: PathBuf,
    /// The mesh to write: .ply, .glb, .obj or .usda.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Triangles to be left.
    #[arg(long, value_name = "N", group = "goal", conflicts_with = "ratio")]
    faces: Option<usize>,
    /// The share of triangles to be left, from 0 to 1.
    #[arg(long, value_name = "R", group = "goal")]
    ratio: Option<f64>,
    /// The largest deviation, in units of the mesh.
    #[arg(long, value_name = "E", group = "goal")]
    error: Option<f32>,
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let options = relievo_core::ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit };
    let context = relievo_core::Context::new(&options)?;
    let mesh = relievo_meshio::read(&context, &arguments.file)?;
    let Welded { points, triangles, .. } = weld(&mesh.points, &mesh.triangles());
    let options = SimplifyOptions {
        faces: faces(arguments.faces, arguments.ratio, triangles.len())?.unwrap_or(0),
        error: arguments.error.unwrap_or(f32::INFINITY),
        ..SimplifyOptions::default()
    };
    let made = simplify(&context, &points, &triangles, &options, &mut Silent)
        .map_err(|error| error.at(arguments.file.display().to_string()))?;
    for attribute in &mesh.attributes {
        eprintln!("note: {} is left out", attribute.name);
    }
    let left = made.triangles.len();
    relievo_meshio::write(&arguments.output, &Mesh::from_triangles(made.points, &made.triangles))?;
    crate::print(&format!("{} triangles, {left} left, deviation {}\n", triangles.len(), made.error))?;
    Ok(ExitCode::SUCCESS)
}

/// The number of triangles that is asked for, if one is.
pub fn faces(faces: Option<usize>, ratio: Option<f64>, all: usize) -> Result<Option<usize>> {
    match ratio {
        Some(ratio) if (0.0..=1.0).contains(&ratio) => Ok(Some((all as f64 * ratio) as usize)),
        Some(ratio) => Err(Error::invalid(format!("{ratio} is no share")).at("--ratio").advise("use 0 to 1")),
        None => Ok(faces),
    }
}
