//! `relievo server fetch`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_client::SurfaceForm;
use relievo_core::progress::Silent;
use relievo_core::{Error, file};
use relievo_particleio::Format;

use super::connection::Connection;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo server fetch dam -o frames --frames 0..24";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The name of the scene.
    scene: String,
    /// The folder for the frames: files as `relievo fluid sim` writes them, `0000.rlvfluid` the first.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Fetches meshes of the surface, made at the server, as PLY files.
    #[arg(long, conflicts_with = "level_set")]
    mesh: bool,
    /// Fetches level sets of the surface, made at the server, as OpenVDB files.
    #[arg(long)]
    level_set: bool,
    /// How the surface is made, in TOML: `cell` in spacings, `function`, `smooth`.
    #[arg(long, value_name = "TEXT", default_value = "")]
    settings: String,
    /// First and last frame, both included; left out, all. Frames that are not computed yet are waited for.
    #[arg(long, value_name = "A..B", value_parser = crate::args::numbers::frames)]
    frames: Option<(u32, u32)>,
    #[command(flatten)]
    connection: Connection,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let Arguments { scene, output, frames, connection, mesh, level_set, settings } = arguments;
    let form = match (mesh, level_set) {
        (true, _) => Some((SurfaceForm::Mesh, "ply")),
        (_, true) => Some((SurfaceForm::LevelSet, "vdb")),
        _ => None,
    };
    let mut client = connection.client()?;
    let last = client.status(scene)?.frames - 1;
    let (first, last) = frames.map_or((0, last), |(first, last)| (first.into(), last.into()));
    std::fs::create_dir_all(output).map_err(|error| Error::io(output, &error))?;
    let bar = crate::fluid::bar(last + 1 - first)?;
    let mut bytes = 0;
    for frame in first..=last {
        client.wait(scene, frame, &mut Silent)?;
        let path = relievo_particleio::path(output, frame, 1, Format::Cache);
        let path = form.map_or(path.clone(), |(_, extension)| path.with_extension(extension));
        let mut failure = None;
        file::store(&path, |out| {
            let write = |part: &[u8]| std::io::Write::write_all(out, part);
            let fetched = match form {
                None => client.file(scene, frame, &mut Silent, write),
                Some((form, _)) => client.surface((scene, frame), (form, settings), &mut Silent, write),
            };
            fetched.map(|count| bytes += count).map_err(|error| {
                let text = error.to_string();
                failure = Some(error);
                std::io::Error::other(text)
            })
        })
        .map_err(|error| failure.unwrap_or(error))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    crate::print(&format!("{} frames, {:.1} MB\n", last + 1 - first, bytes as f64 / 1e6))?;
    Ok(ExitCode::SUCCESS)
}
