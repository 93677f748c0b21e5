//! `relievo crowd info`

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::Context;
use relievo_crowd::{CrowdModel, Level, Reader, Spread};
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::limits::Limits;

const EXAMPLE: &str = "Example: relievo crowd info robot.rcrowd";

/// Errors whose cuts are listed, as shares of the model's diagonal.
const SHARES: [f32; 5] = [0.0001, 0.001, 0.003, 0.01, 0.03];

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The crowd model.
    file: PathBuf,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    tell(&arguments.limits.context()?, &arguments.file, arguments.json)
}

/// Prints what is in the model at `path`, `for_programs` as JSON.
pub fn tell(context: &Context, path: &Path, for_programs: bool) -> Outcome {
    let reader = Reader::open(context, path)?;
    let model = reader.model();
    let text = if for_programs { format!("{:#}\n", machine_readable(model)) } else { described(model) };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns what is in a model, one number a line.
pub fn described(model: &CrowdModel) -> String {
    let report = &model.report;
    let depth = model.groups.iter().map(|group| group.depth).max().unwrap_or_default();
    let exceeded = 100.0 * report.exceeded as f64 / report.measured.max(1) as f64;
    let mut text = format!(
        "triangles              {}\nvertices               {}\nbones                  {}\nclips                  {}\n\
         poses                  {}, of which {} are representative\nclusters               {}\ngroups                 {}\n\
         levels                 {}\nerrors beyond          {exceeded:.1} % of {} distances, widened to hold\n",
        model.input_triangles,
        model.character.points.len(),
        model.character.bones.len(),
        model.clips.iter().map(|clip| clip.name.as_str()).collect::<Vec<_>>().join(", "),
        report.poses,
        report.representatives,
        model.clusters.len(),
        model.groups.len(),
        depth + 1,
        report.measured,
    );
    for share in SHARES {
        let triangles = model.triangle_count(&model.cut(share * model.size()));
        // Writing to a string does not fail.
        let _ = writeln!(text, "at {:5.2} % error        {triangles} triangles", 100.0 * share);
    }
    let levels = model.level_distances();
    if levels.is_empty() {
        text += "levels' distances      none: the file is of an older version, or nothing was simplified\n";
        return text;
    }
    text += "what simplifications add over the representative poses (chosen) and over all, in % of the size\n\
             level  groups  triangles   chosen: median     largest      all: median     largest  groups exceeding\n";
    let share = |distance: f32| 100.0 * distance / model.size().max(f32::MIN_POSITIVE);
    for Level { depth, groups, triangles, chosen, all, exceeding } in levels {
        let part = 100.0 * f64::from(exceeding) / f64::from(groups.max(1));
        let _ = writeln!(
            text,
            "{depth:5}  {groups:6}  {triangles:9}  {:15.5}  {:10.5}  {:15.5}  {:10.5}  {part:14.1} %",
            share(chosen.median),
            share(chosen.largest),
            share(all.median),
            share(all.largest),
        );
    }
    text
}

/// Returns what is in a model for programs.
pub fn machine_readable(model: &CrowdModel) -> Value {
    let cut = |share: &f32| {
        let error = share * model.size();
        json!({ "error": error, "triangles": model.triangle_count(&model.cut(error)) })
    };
    let clip = |clip: &relievo_crowd::Clip| json!({ "name": clip.name, "rate": clip.rate, "poses": clip.poses.len() });
    let spread = |it: Spread| json!({ "median": it.median, "largest": it.largest });
    let level = |it: &Level| {
        json!({
            "depth": it.depth,
            "groups": it.groups,
            "triangles": it.triangles,
            "chosen": spread(it.chosen),
            "all": spread(it.all),
            "exceeding": it.exceeding,
        })
    };
    json!({
        "triangles": model.input_triangles,
        "vertices": model.character.points.len(),
        "bones": model.character.bones.len(),
        "clips": model.clips.iter().map(clip).collect::<Vec<_>>(),
        "poses": model.report.poses,
        "representatives": model.report.representatives,
        "clusters": model.clusters.len(),
        "groups": model.groups.len(),
        "distances": model.report.measured,
        "exceeded": model.report.exceeded,
        "levels": model.level_distances().iter().map(level).collect::<Vec<_>>(),
        "low": model.low,
        "high": model.high,
        "cuts": SHARES.iter().map(cut).collect::<Vec<_>>(),
    })
}
