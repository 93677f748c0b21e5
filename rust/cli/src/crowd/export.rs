//! `relievo crowd export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;
use relievo_crowd::{CrowdModel, MOST_LEVELS, clip_index};

use crate::Outcome;
use crate::args::limits::Limits;

const EXAMPLE: &str = "\
Examples: relievo crowd export robot.rcrowd -o far.glb --error-relative 0.01 --time 0.5
          relievo crowd export robot.rcrowd -o levels.glb --levels 4";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The crowd model.
    file: PathBuf,
    /// The mesh to write: .glb, .ply, .obj or .usda.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The largest distance from the input's surface in every pose, in units of the model; 0 for the input.
    #[arg(long, value_name = "E", default_value_t = 0.0, conflicts_with = "error_relative")]
    error: f32,
    /// As --error, as a share of the model's diagonal over all poses.
    #[arg(long, value_name = "SHARE")]
    error_relative: Option<f32>,
    /// Write up to N levels of detail into one .glb instead, by the extension MSFT_lod: skinned, with all clips. Each has at
    /// most a fourth of the triangles of the one before.
    #[arg(long, value_name = "N", conflicts_with_all = ["error", "error_relative", "clip", "time"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LEVELS)))]
    levels: Option<u32>,
    /// Error that may be seen, in pixels of a screen of 1920x1080, where a coarser level replaces a finer one.
    #[arg(long, value_name = "PIXELS", default_value_t = 0.5, requires = "levels")]
    pixels: f64,
    /// The clip, by name or by number from 0.
    #[arg(long, value_name = "NAME", default_value = "0")]
    clip: String,
    /// The time in the clip whose pose is written.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    time: f64,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let model = CrowdModel::load(&context, &arguments.file)?;
    if let Some(count) = arguments.levels {
        return write_levels(&model, arguments, count);
    }
    let error = arguments.error_relative.map_or(arguments.error, |share| share * model.size());
    if !(error >= 0.0 && arguments.time.is_finite()) {
        return Err(Error::invalid("the error or the time is out of range")
            .advise("give an error of 0 or more")
            .into());
    }
    let clusters = if error == 0.0 { model.input_clusters() } else { model.cut(error) };
    let clip = &model.clips[clip_index(&model, &arguments.clip)? as usize];
    let pose = &clip.poses[clip.pose_at(arguments.time)];
    let mesh = model.mesh(&context, &clusters, pose)?;
    let triangles = mesh.face_count();
    relievo_meshio::write(&arguments.output, &mesh)?;
    crate::print(&format!("{}\n{triangles} of {} triangles\n", arguments.output.display(), model.input_triangles))?;
    Ok(ExitCode::SUCCESS)
}

fn write_levels(model: &CrowdModel, arguments: &Arguments, count: u32) -> Outcome {
    let path = &arguments.output;
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        return Err(Error::unsupported("levels of detail are written as GLB")
            .at(path.display().to_string())
            .advise("use the extension .glb, or write one level after the other by --error")
            .into());
    }
    let exported = model.save_levels(path, count, arguments.pixels)?;
    if exported.sheared > 0 {
        eprintln!("note: {} bones are sheared, which glTF cannot say: their scale is the nearest", exported.sheared);
    }
    if model.character.morphs.count > 0 {
        eprintln!("note: morph targets keep the weights of the first pose");
    }
    let level = |(number, (error, triangles)): (usize, &(f32, u64))| {
        format!("level {number}: {triangles} triangles, error {error:.6}\n")
    };
    let text: String = exported.levels.iter().enumerate().map(level).collect();
    crate::print(&format!("{}\n{text}", path.display()))?;
    Ok(ExitCode::SUCCESS)
}
