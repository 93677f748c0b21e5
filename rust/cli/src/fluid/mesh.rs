//! `relievo fluid mesh`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_fluid::{Channel, Smoothing, Surface, SurfaceFunction, level_set, smooth};
use relievo_particleio::{LevelSet, Particles};

use super::Limits;
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The particles: a frame of a cache, a classic .bgeo, a legacy .vtk, the points of a mesh file, or a folder of frames.
    particles: PathBuf,
    /// The mesh to write: .ply, .glb, .obj or .usda, or .vdb for a level set. Of a folder, the folder for the meshes, which
    /// are PLY.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Distance between particles at rest, in metres; without it, what the file says.
    #[arg(long, value_name = "METRES")]
    spacing: Option<f32>,
    /// Size of the cells by which the mesh is made, in spacings.
    #[arg(long, value_name = "SPACINGS", default_value_t = 0.5)]
    cell: f32,
    /// What the surface is of.
    #[arg(long, value_enum, default_value_t = Function::ZhuBridson)]
    function: Function,
    /// Steps by which the mesh is smoothed.
    #[arg(long, value_name = "STEPS", default_value_t = 0)]
    smooth: u32,
    /// How far a step of smoothing goes towards the mean of the neighbours, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = Smoothing::default().forwards)]
    smooth_forwards: f32,
    /// How far it then goes back, 0 to 1: a little more than forwards keeps the volume.
    #[arg(long, value_name = "SHARE", default_value_t = Smoothing::default().backwards)]
    smooth_backwards: f32,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Function {
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
    pub fn of(self, spacing: f32) -> SurfaceFunction {
        let radius = 0.5 * spacing;
        match self {
            Self::Blobs => SurfaceFunction::blobs(radius),
            Self::ZhuBridson => SurfaceFunction::zhu_bridson(radius),
            Self::Density => SurfaceFunction::density(radius),
            Self::Anisotropic => SurfaceFunction::anisotropic(radius),
        }
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let (from, to) = (&arguments.particles, &arguments.output);
    if !from.is_dir() {
        let (count, faces) = one(&context, arguments, from, to)?;
        crate::print(&format!("{count} particles, {faces} triangles\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let frames = super::frames(from)?;
    std::fs::create_dir_all(to).map_err(|error| Error::io(to, &error))?;
    let bar = super::bar(frames.len() as u64)?;
    let (mut particles, mut triangles) = (0, 0);
    for (name, path) in &frames {
        let (count, faces) = one(&context, arguments, path, &to.join(format!("{name}.ply")))?;
        (particles, triangles) = (particles + count, triangles + faces);
        bar.inc(1);
    }
    bar.finish_and_clear();
    crate::print(&format!("{} frames, {particles} particles, {triangles} triangles\n", frames.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Makes a mesh or a level set of a file of particles, and returns how many particles and triangles there are.
fn one(context: &Context, arguments: &Arguments, from: &Path, to: &Path) -> Result<(usize, usize)> {
    let named = |error: Error| error.at(from.display().to_string());
    let is = |wanted: &str| to.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
    if is("vdb") && arguments.smooth > 0 {
        return Err(Error::unsupported("a level set is not smoothed")
            .at("--smooth")
            .advise("write a mesh, or leave it out"));
    }
    let particles = super::read(context, from)?;
    let (surface, cell) = surface(context, arguments, &particles).map_err(named)?;
    // Normals are those of the surface.
    let channels = particles.channels.iter().filter(|channel| channel.name != "normal");
    let channels: Vec<Channel> =
        channels.map(|it| Channel { name: &it.name, width: it.width as usize, values: &it.values }).collect();
    let mut mesh = relievo_fluid::mesh(context, &surface, cell, &channels, &mut Silent).map_err(named)?;
    if arguments.smooth > 0 {
        let smoothing = Smoothing {
            iterations: arguments.smooth,
            forwards: arguments.smooth_forwards,
            backwards: arguments.smooth_backwards,
        };
        smooth(context, &mut mesh, smoothing, &mut Silent).map_err(|error| error.at("--smooth"))?;
    }
    match mesh.face_count() {
        _ if is("vdb") => store_level_set(context, &surface, &mesh, cell, to)?,
        // Other formats have no mesh without a face.
        0 if is("ply") => relievo_meshio::write_points_ply(to, Vec::new(), Vec::new())?,
        0 => {
            return Err(named(
                Error::invalid("there is no surface to write")
                    .advise("write PLY, which can hold a mesh without faces, or leave the frame out"),
            ));
        }
        _ => relievo_meshio::write(to, &mesh)?,
    }
    Ok((particles.points.len(), mesh.face_count()))
}

/// The surface, and the size of cells in metres.
fn surface(context: &Context, arguments: &Arguments, particles: &Particles) -> Result<(Surface, f32)> {
    let Some(spacing) = arguments.spacing.or(particles.spacing) else {
        return Err(Error::invalid("the file does not say how far particles are apart").advise("give --spacing"));
    };
    let function = arguments.function.of(spacing);
    Ok((Surface::new(context, &particles.points, function)?, arguments.cell * spacing))
}

/// Writes the level set of a surface, in voxels as large as the cells of its mesh.
fn store_level_set(context: &Context, surface: &Surface, mesh: &Mesh, cell: f32, to: &Path) -> Result<()> {
    let relievo_fluid::LevelSet { voxel, band, blocks } = level_set(context, surface, mesh, cell, &mut Silent)?;
    let is_inside = |place: [f64; 3]| {
        let place = place.map(|at| (at * f64::from(voxel)) as f32);
        surface.probe(context).sample(place).value > 0.0
    };
    relievo_particleio::write_vdb(context, to, &LevelSet { voxel, band, blocks }, &is_inside)
}
