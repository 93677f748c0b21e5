//! `relievo fluid mesh`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_fluid::{Smoothing, Surface, level_set, smooth};
use relievo_particleio::LevelSet;

use crate::Outcome;
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    /// The particles: a frame of a cache, a classic .bgeo, a legacy .vtk, a .vdb, the points of a mesh file, or a folder of frames.
    #[arg(value_name = "PARTICLES")]
    from: PathBuf,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off, or .vdb for a level set. Of a folder, the folder for the meshes, which
    /// are PLY.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Of a folder, the first and the last frame, both included; left out, all.
    #[arg(long, value_name = "A..B", value_parser = crate::args::numbers::frames)]
    frames: Option<(u32, u32)>,
    /// Size of the cells by which the mesh is made, in spacings.
    #[arg(long, value_name = "SPACINGS", default_value_t = 0.5)]
    cell: f32,
    #[command(flatten)]
    surface: super::surface::Options,
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

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let (from, to) = (&arguments.from, &arguments.output);
    if !from.is_dir() {
        super::frames::needs_folder(from, arguments.frames)?;
        let (count, faces, share) = one(&context, arguments, from, to)?;
        crate::print(&format!("{count} particles, {share}{faces} triangles\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let frames = super::frames::chunk(from, arguments.frames)?;
    std::fs::create_dir_all(to).map_err(|error| Error::io(to, &error))?;
    let bar = super::frames::bar(frames.len() as u64)?;
    let (mut particles, mut triangles) = (0, 0);
    for (name, path) in &frames {
        let (count, faces, share) = one(&context, arguments, path, &to.join(format!("{name}.ply")))?;
        if !share.is_empty() {
            bar.suspend(|| {
                crate::print(&format!("{}: {count} particles, {share}{faces} triangles\n", path.display()))
            })?;
        }
        (particles, triangles) = (particles + count, triangles + faces);
        bar.inc(1);
    }
    bar.finish_and_clear();
    crate::print(&format!("{} frames, {particles} particles, {triangles} triangles\n", frames.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Makes a mesh or a level set of a file of particles, and returns how many particles and triangles there are, and what
/// to say of the particles that were taken.
fn one(context: &Context, arguments: &Arguments, from: &Path, to: &Path) -> Result<(usize, usize, String)> {
    let named = |error: Error| error.at(from.display().to_string());
    let is = |wanted: &str| to.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
    if is("vdb") && arguments.smooth > 0 {
        return Err(Error::unsupported("a level set is not smoothed")
            .at("--smooth")
            .advise("write a mesh, or leave it out"));
    }
    let all = super::frames::read(context, from)?;
    let count = all.points.len();
    let options = &arguments.surface;
    let spacing = options.spacing(&all).map_err(named)?;
    let selection = options.select(context, all).map_err(named)?;
    if is("vdb") && !selection.blind.is_empty() {
        return Err(Error::unsupported("a level set has no blind particles")
            .at("--particles")
            .advise("write a mesh, or take the file with all particles"));
    }
    let surface = options.surface(context, &selection.particles).map_err(named)?;
    let cell = arguments.cell * spacing;
    let mut mesh = selection.mesh(context, &surface, cell).map_err(named)?;
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
    Ok((count, mesh.face_count(), selection.share))
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
