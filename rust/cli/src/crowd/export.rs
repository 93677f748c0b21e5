//! `relievo crowd export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;
use relievo_crowd::{CrowdModel, clip_index};

use crate::Outcome;
use crate::limits::Limits;

const EXAMPLE: &str = "Example: relievo crowd export robot.rcrowd -o far.glb --error-relative 0.01 --time 0.5";

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
