//! `relievo crowd refit`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_crowd::{BuildSettings, CrowdModel};
use serde_json::json;

use crate::Outcome;
use crate::args::limits::Limits;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo crowd refit robot.rcrowd sculpted.glb -o sculpted.rcrowd";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The crowd model whose clusters stay.
    file: PathBuf,
    /// The file that it was built from, sculpted or with other clips, with the same triangles.
    model: PathBuf,
    /// The crowd model to write.
    #[arg(short, long, value_name = "FILE.rcrowd")]
    output: PathBuf,
    /// A clip, by name or by number from 0. May be repeated; left out, all clips of the file.
    #[arg(long = "clip", value_name = "NAME")]
    clips: Vec<String>,
    /// Poses that are sampled for each second of a clip.
    #[arg(long, value_name = "RATE", default_value_t = BuildSettings::default().pose_rate)]
    pose_rate: f32,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let before = CrowdModel::load(&context, &arguments.file)?;
    let source = relievo_meshio::read_model(&context, &arguments.model)?;
    for note in &source.notes {
        eprintln!("note: {note}");
    }
    let clips = super::build::clips_of(&source, &arguments.clips)?;
    let settings = BuildSettings { pose_rate: arguments.pose_rate, ..BuildSettings::default() };
    let place = arguments.model.display().to_string();
    let (model, found) =
        before.refit(&context, &source, &clips, &settings, &mut Bar::new()).map_err(|error| error.at(place))?;
    model.save(&arguments.output)?;
    let output = arguments.output.display().to_string();
    let text = if arguments.json {
        let mut value = super::info::machine_readable(&model);
        value["output"] = json!(output);
        value["grown_groups"] = json!(found.grown);
        value["growth"] = json!(found.growth);
        value["rebuild_due"] = json!(found.is_rebuild_due());
        format!("{value:#}\n")
    } else {
        let advice = if found.is_rebuild_due() { ": build it anew for fewer" } else { "" };
        format!(
            "{output}\nlarger errors          {} of {} groups\ntriangles of cuts      {:.2} times as many at most{advice}\n",
            found.grown,
            model.groups.len(),
            found.growth
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
