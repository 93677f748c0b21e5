//! `relievo fluid convert`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;

use super::sim::FrameFormat;
use crate::Outcome;
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    /// A file of particles, or a folder of frames.
    from: PathBuf,
    /// The file to write: .rlvfluid, .bgeo, .vtk, .ply or .vdb. Of a folder, the folder for the frames.
    to: PathBuf,
    /// The format of the frames of a folder.
    #[arg(long, value_enum)]
    format: Option<FrameFormat>,
    #[command(flatten)]
    surface: super::surface::Options,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let Arguments { from, to, format, surface, .. } = arguments;
    let mut pairs = vec![(from.clone(), to.clone())];
    if from.is_dir() {
        let Some(format) = format else {
            return Err(Error::invalid("the format of the frames is not said").advise("give --format").into());
        };
        std::fs::create_dir_all(to).map_err(|error| Error::io(to, &error))?;
        let name = |name: &str| to.join(format!("{name}.{}", format.format().extension()));
        pairs = super::frames::frames(from)?.into_iter().map(|(stem, path)| (path, name(&stem))).collect();
    }
    let bar = super::frames::bar(pairs.len() as u64)?;
    let mut count = 0;
    for (from, to) in &pairs {
        let mut particles = super::frames::read(&context, from)?;
        count += particles.points.len();
        particles.spacing = surface.given_spacing().or(particles.spacing);
        if surface.is_selective() {
            let all = particles.points.len();
            let selection =
                surface.select(&context, particles).map_err(|error| error.at(from.display().to_string()))?;
            let share = selection.share.trim_end_matches(", ");
            bar.suspend(|| crate::print(&format!("{}: {all} particles, {share}\n", from.display())))?;
            particles = selection.marked();
        }
        particles.sort();
        relievo_particleio::write(&context, to, &particles)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    crate::print(&format!("{} files, {count} particles\n", pairs.len()))?;
    Ok(ExitCode::SUCCESS)
}
