//! `relievo grid`

mod combine;
mod convert;
mod info;
mod mesh;
mod source;

use clap::Subcommand;
use relievo_core::{Mesh, Result};
use relievo_openvdb::{Grid, Kind, Packing, Polygons, Writing};

use crate::Outcome;
use crate::args::limits::Limits;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Lists the grids of an OpenVDB file: kinds, transforms, active voxels, memory and metadata.
    Info(info::Arguments),
    /// Converts grids, a mesh or particles to an OpenVDB file: other voxels, kinds of values, filters, fog, level sets.
    Convert(convert::Arguments),
    /// Meshes the surface of a grid: a level set, fog at a density, or a label.
    Mesh(mesh::Arguments),
    /// Combines grids or meshes: union, intersection, difference, or labels of them.
    Combine(combine::Arguments),
}

/// How values of a file are packed.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum Pack {
    /// By Blosc, quick to read.
    #[default]
    Blosc,
    /// By zlib, smaller.
    Zip,
    /// Not at all.
    None,
}

#[derive(clap::Args)]
struct Output {
    /// How values are packed.
    #[arg(long, value_enum, default_value_t)]
    pack: Pack,
    /// Write numbers with 16 bits.
    #[arg(long)]
    half: bool,
    /// Leave out places of grids, as programs do that write to a pipe.
    #[arg(long)]
    stream: bool,
}

impl Output {
    fn writing(&self) -> Writing {
        let (zip, blosc) = (matches!(self.pack, Pack::Zip), matches!(self.pack, Pack::Blosc));
        let packing = Packing { zip, blosc, active: true };
        Writing { packing, is_stream: self.stream, metadata: Vec::new() }
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Info(arguments) => info::run(arguments),
        Task::Convert(arguments) => convert::run(arguments),
        Task::Mesh(arguments) => mesh::run(arguments),
        Task::Combine(arguments) => combine::run(arguments),
    }
}

/// Parses the name of a kind of grids.
fn kind(text: &str) -> std::result::Result<Kind, String> {
    Kind::by_name(text).map_err(|error| error.to_string())
}

/// Makes a mesh of polygons.
fn mesh_of(polygons: Polygons) -> Mesh {
    let sizes = polygons.triangles.iter().map(|_| 3).chain(polygons.quads.iter().map(|_| 4)).collect();
    let mut corners = polygons.triangles.into_flattened();
    corners.extend(polygons.quads.into_flattened());
    Mesh::new(polygons.points, sizes, corners)
}

/// Returns a line about a grid that was written.
fn line(grid: &Grid) -> Result<String> {
    let info = grid.info()?;
    let kind = info.kind.map_or("", Kind::name);
    let [x, ..] = info.transform.voxel_size;
    let name = if info.name.is_empty() { "(no name)" } else { &info.name };
    Ok(format!("{name}: {kind}, {}, {} active voxels of {x}\n", info.class.name(), info.active_voxels))
}
