//! `relievo fluid`

mod description;
mod entries;
mod play;
mod render;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Subcommand, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Error, Result, Values};
use relievo_fluid::{Channel, Fluid, Surface, SurfaceFunction};

use self::description::Description;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Simulates a fluid of particles and writes its frames.
    Sim(Sim),
    /// Makes a mesh of the surface of particles.
    Mesh(Meshing),
    /// Renders the surface of particles.
    Render(render::Rendering),
}

#[derive(clap::Args)]
struct Sim {
    /// What is simulated: a list of blocks of fluid and a basin, in TOML.
    description: PathBuf,
    /// The folder for the frames: `0000.ply` is what the fluid begins as.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    #[command(flatten)]
    limits: Limits,
}

#[derive(clap::Args)]
struct Meshing {
    /// The particles: the points of a mesh file, with their attribute `velocity` if they have one.
    particles: PathBuf,
    /// The mesh to write: .ply, .glb, .obj or .usda.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Distance between particles at rest, in metres.
    #[arg(long, value_name = "METRES")]
    spacing: f32,
    /// Size of the cells by which the mesh is made, in spacings.
    #[arg(long, value_name = "SPACINGS", default_value_t = 0.5)]
    cell: f32,
    /// What the surface is of.
    #[arg(long, value_enum, default_value_t = Function::ZhuBridson)]
    function: Function,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, ValueEnum)]
enum Function {
    /// Blobs (Blinn 1982).
    Blobs,
    /// The distance from a mean of places (Zhu, Bridson 2005).
    ZhuBridson,
    /// The density of particles.
    Density,
    /// Kernels that are flat where particles are (Yu, Turk 2013).
    Anisotropic,
}

impl Function {
    /// The function of particles that lie this far apart at rest, in metres.
    fn of(self, spacing: f32) -> SurfaceFunction {
        let radius = 0.5 * spacing;
        match self {
            Self::Blobs => SurfaceFunction::blobs(radius),
            Self::ZhuBridson => SurfaceFunction::zhu_bridson(radius),
            Self::Density => SurfaceFunction::density(radius),
            Self::Anisotropic => SurfaceFunction::anisotropic(radius),
        }
    }
}

#[derive(clap::Args)]
struct Limits {
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

impl Limits {
    fn context(&self) -> Result<Context> {
        Context::new(&ContextOptions { threads: self.threads, memory_limit: self.memory_limit })
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Sim(arguments) => sim(arguments),
        Task::Mesh(arguments) => mesh(arguments),
        Task::Render(arguments) => render::run(arguments),
    }
}

fn sim(arguments: &Sim) -> Outcome {
    let context = arguments.limits.context()?;
    let description = Description::read(&arguments.description)?;
    let named = |error: Error| error.at(arguments.description.display().to_string());
    let mut play = description.play(&context).map_err(named)?;
    let mut fluid = description.begin(&context, &mut play).map_err(named)?;
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    store(&frame(folder, 0), &fluid)?;
    let style = ProgressStyle::with_template("{bar:30} frame {pos} of {len}, {eta} left, {msg}");
    let bar = ProgressBar::new(u64::from(description.frames));
    bar.set_style(style.map_err(|error| Error::internal(error.to_string()))?);
    let (mut steps, mut corrections, mut most) = (0u64, 0u64, 0.0f32);
    for number in 1..=description.frames {
        let seconds = (1.0 / description.fps) as f32;
        let time = f64::from(number - 1) / description.fps;
        play.advance(&context, &mut fluid, time, seconds, |_, done| {
            (steps, corrections) = (steps + 1, corrections + u64::from(done.corrections));
            most = most.max(done.excess.most);
            Ok(())
        })?;
        store(&frame(folder, number), &fluid)?;
        bar.set_message(format!("{steps} steps"));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let (count, frames) = (fluid.len(), description.frames);
    let report = format!(
        "{count} particles {} m apart, {frames} frames in {steps} steps with {corrections} corrections, at most {:.2} % too dense\n",
        description.spacing(),
        100.0 * most
    );
    crate::print(&report)?;
    Ok(ExitCode::SUCCESS)
}

/// The file of a frame.
fn frame(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("{number:04}.ply"))
}

/// Writes particles in the order of their numbers, with their velocities.
fn store(path: &Path, fluid: &Fluid) -> Result<()> {
    let mut order: Vec<usize> = (0..fluid.len()).collect();
    order.sort_unstable_by_key(|at| fluid.numbers()[*at]);
    let points = order.iter().map(|at| fluid.places()[*at].truncate().into()).collect();
    let velocities: Vec<[f32; 3]> = order.iter().map(|at| fluid.velocities()[*at].truncate().into()).collect();
    let velocity = Attribute {
        name: "velocity".into(),
        domain: Domain::Point,
        width: 3,
        values: Values::F32(velocities.into_flattened()),
        indices: None,
    };
    relievo_meshio::write_points_ply(path, points, vec![velocity])
}

fn mesh(arguments: &Meshing) -> Outcome {
    let context = arguments.limits.context()?;
    let path = &arguments.particles;
    let particles = relievo_meshio::read(&context, path)?;
    let function = arguments.function.of(arguments.spacing);
    let velocity = particles.attribute("velocity").filter(|attribute| attribute.domain == Domain::Point);
    let channels: Vec<Channel> = velocity
        .and_then(|attribute| match &attribute.values {
            Values::F32(values) => Some(Channel { name: "velocity", width: attribute.width as usize, values }),
            Values::U32(_) => None,
        })
        .into_iter()
        .collect();
    let named = |error: Error| error.at(path.display().to_string());
    let surface = Surface::new(&context, &particles.points, function).map_err(named)?;
    let cell = arguments.cell * arguments.spacing;
    let mesh = relievo_fluid::mesh(&context, &surface, cell, &channels, &mut Silent).map_err(named)?;
    relievo_meshio::write(&arguments.output, &mesh)?;
    let (count, faces) = (particles.points.len(), mesh.face_count());
    crate::print(&format!("{count} particles, {faces} triangles\n"))?;
    Ok(ExitCode::SUCCESS)
}
