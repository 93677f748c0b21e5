//! `relievo-bench NAME [--json]`: measures Relievo and a peer in the same run and holds the figures against goals.
//! `cargo xtask bench` builds and runs it.

mod crowd;
mod decal;
mod deviation;
mod fluid;
mod foam;
mod gpu;
mod imprint;
mod lod;
mod measure;
mod memory;
mod native;
mod paint;
mod peers;
mod progressive;
mod report;
mod server;
mod shader;
mod shapes;
mod surface;
mod textured;
mod tissue;
mod triangles;
mod voxels;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use relievo_core::{Error, Result};
use report::Report;

#[derive(Parser)]
#[command(about = "Measures Relievo beside its peers")]
struct Arguments {
    /// Which bench: `surface`, `imprint`, `paint`, `gpu`, `lod`, `crowd`, `fluid`, `foam`, `tissue`, `decal`, `native`, `server`, `shader`, `memory` (a
    /// part of `hosts`), or `dams` and `pictures`, parts of `fluid`; or `peak`, `cage`, `creation`, `drawing`, `sticker` and `meshing`, which they run
    name: String,
    /// One JSON object per line instead of a table
    #[arg(long)]
    json: bool,
    /// Programs of peers that `lod`, `fluid`, `decal` and `native` measure beside ours, in a folder
    #[arg(long)]
    peers: Option<PathBuf>,
    /// Segments along and around the knot whose progressive mesh is built for `peak`
    #[arg(long, num_args = 2, default_values_t = [1050, 415])]
    knot: Vec<u32>,
    /// The control cage whose surface is made for `cage`
    #[arg(long, required_if_eq("name", "cage"))]
    cage: Option<String>,
    /// The row of the table of models of tissue that `creation` makes, of pictures of foam that `drawing` draws, or of decals that `sticker` lays
    #[arg(long, default_value_t = 0)]
    row: usize,
    /// The particles that `meshing` makes a mesh of, as 32-bit floats
    #[arg(long, required_if_eq("name", "meshing"))]
    particles: Option<PathBuf>,
    /// A folder of shaders that `shader` augments beside ours
    #[arg(long)]
    shaders: Option<PathBuf>,
}

fn run(arguments: &Arguments) -> Result<()> {
    let mut report = Report::new(&arguments.name, arguments.json);
    match arguments.name.as_str() {
        "surface" => surface::run(&mut report)?,
        "imprint" => imprint::run(&mut report)?,
        "paint" => paint::run(&mut report)?,
        "gpu" => gpu::run(&mut report, arguments.json)?,
        "lod" => lod::run(&mut report, arguments.peers.as_deref())?,
        "fluid" => {
            fluid::run(&mut report, arguments.peers.as_deref())?;
            fluid::render::run(&mut report)?;
        }
        "tissue" => tissue::run(&mut report)?,
        "decal" => decal::run(&mut report, arguments.peers.as_deref())?,
        "foam" => foam::run(&mut report)?,
        "native" => native::run(&mut report, arguments.peers.as_deref())?,
        "dams" => fluid::dams(&mut report, arguments.peers.as_deref())?,
        "server" => server::run(&mut report)?,
        "crowd" => crowd::run(&mut report)?,
        "memory" => memory::run(&mut report)?,
        "cage" => return memory::peak(arguments.cage.as_deref().unwrap_or_default()),
        "creation" => return tissue::peak(arguments.row),
        "drawing" => return foam::peak(arguments.row),
        "sticker" => return decal::peak(arguments.row),
        "pictures" => fluid::render::run(&mut report)?,
        "shader" => shader::run(&mut report, arguments.shaders.as_deref())?,
        "meshing" => return fluid::mesh_file(arguments.particles.as_deref().unwrap_or(Path::new(""))),
        "peak" => return lod::peak(arguments.knot[0], arguments.knot[1]),
        name => {
            return Err(Error::invalid(format!("there is no bench `{name}`"))
                .advise("use `surface`, `imprint`, `paint`, `gpu`, `lod`, `crowd`, `fluid`, `foam`, `tissue`, `decal`, `native`, `server`, `shader`, `memory`, `dams` or `pictures`"));
        }
    }
    report.finish();
    Ok(())
}

fn main() -> ExitCode {
    // Rows are read by people and scripts; processes that are started for a row inherit it.
    relievo_gpu::quiet_drivers();
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
