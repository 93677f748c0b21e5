//! `relievo crowd build`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_crowd::{BuildSettings, CrowdModel};
use serde_json::json;

use crate::Outcome;
use crate::args::limits::Limits;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo crowd build robot.glb -o robot.rcrowd --clip Robot_Walking";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The character or static model: glTF, GLB, USD, OBJ, PLY, STL or OFF.
    model: PathBuf,
    /// The crowd model to write.
    #[arg(short, long, value_name = "FILE.rcrowd")]
    output: PathBuf,
    /// A clip, by name or by number from 0. May be repeated; left out, all clips of the file.
    #[arg(long = "clip", value_name = "NAME")]
    clips: Vec<String>,
    /// Distance of poses that are taken as alike, as a share of the model's diagonal.
    #[arg(long, value_name = "SHARE", default_value_t = BuildSettings::default().pose_distance)]
    pose_distance: f32,
    /// Poses that are sampled for each second of a clip.
    #[arg(long, value_name = "RATE", default_value_t = BuildSettings::default().pose_rate)]
    pose_rate: f32,
    /// Triangles of a cluster at most.
    #[arg(long, value_name = "N", default_value_t = BuildSettings::default().cluster_triangles)]
    cluster_triangles: u32,
    /// Clusters that are simplified together at most, from 4 up.
    #[arg(long, value_name = "N", default_value_t = BuildSettings::default().group_clusters)]
    group_clusters: u32,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

/// Returns the animations of a file by their names or numbers, or all without any.
pub fn clips_of(source: &relievo_meshio::Model, names: &[String]) -> relievo_core::Result<Vec<usize>> {
    match names {
        [] => Ok((0..source.animations.len()).collect()),
        names => names.iter().map(|name| source.animation(name)).collect(),
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let source = relievo_meshio::read_model(&context, &arguments.model)?;
    for note in &source.notes {
        eprintln!("note: {note}");
    }
    let clips = clips_of(&source, &arguments.clips)?;
    let settings = BuildSettings {
        pose_distance: arguments.pose_distance,
        cluster_triangles: arguments.cluster_triangles,
        group_clusters: arguments.group_clusters,
        pose_rate: arguments.pose_rate,
    };
    let place = arguments.model.display().to_string();
    let model =
        CrowdModel::build(&context, &source, &clips, &settings, &mut Bar::new()).map_err(|error| error.at(place))?;
    model.save(&arguments.output)?;
    let output = arguments.output.display().to_string();
    let text = if arguments.json {
        let mut value = super::info::machine_readable(&model);
        value["output"] = json!(output);
        format!("{value:#}\n")
    } else {
        format!("{output}\n{}", super::info::described(&model))
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
