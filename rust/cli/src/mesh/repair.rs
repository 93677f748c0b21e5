//! `relievo mesh repair`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_repair::{RepairSettings, Repaired, Report};
use serde_json::{Value, json};

use super::report::{self, Common};
use crate::Outcome;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo mesh repair scan.stl -o scan.ply --tolerance 0.01 --hole-edges 200";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off. It may be the one that is read.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Leave holes of more edges open; 0 fills holes of any size.
    #[arg(long, value_name = "N", default_value_t = 0)]
    hole_edges: u32,
    /// Leave a hole open if its filling were larger than this share of the area of its component.
    #[arg(long, value_name = "SHARE", default_value_t = RepairSettings::default().hole_area)]
    hole_area: f32,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    let (context, mesh) = common.read()?;
    let settings =
        RepairSettings { hole_edges: arguments.hole_edges, hole_area: arguments.hole_area, ..common.settings() };
    let Repaired { mesh, report, .. } = relievo_repair::repair(&context, &mesh, &settings, &mut Bar::new())
        .map_err(|error| error.at(common.place()))?;
    relievo_meshio::write(&arguments.output, &mesh)?;
    let text = match common.json {
        true => format!("{:#}\n", machine_readable(arguments, &report)),
        false => format!(
            "{}\n{}\n{}{}\n{}\n",
            common.place(),
            report::described(&report.before),
            report::defects(&report),
            arguments.output.display(),
            changes(&report)
        ),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// What a repair changed, and the mesh that it made.
fn changes(report: &Report) -> String {
    let mut lines = vec![report::described(&report.after)];
    let mut line = |count: usize, text: String| {
        if count > 0 {
            lines.push(text);
        }
    };
    line(report.turned_faces, format!("{} faces turned over", report.turned_faces));
    line(report.split_points, format!("{} points added where edges and points were split", report.split_points));
    line(
        report.filled_holes,
        format!(
            "{} holes filled with {} faces and {} new points",
            report.filled_holes, report.filling_faces, report.filling_points
        ),
    );
    line(
        report.open_holes.count,
        format!("{} holes left open, at edges {}", report.open_holes.count, report.open_holes),
    );
    line(
        report.seam_attributes.len(),
        format!("{} differ at welded points and are now on corners", report.seam_attributes.join(", ")),
    );
    lines.join("\n")
}

fn machine_readable(arguments: &Arguments, report: &Report) -> Value {
    let mut value = report::machine_readable(&arguments.common.file, report);
    value["output"] = json!(arguments.output.display().to_string());
    value["turned_faces"] = json!(report.turned_faces);
    value["split_points"] = json!(report.split_points);
    value["filled_holes"] = json!(report.filled_holes);
    value["open_holes"] = report::finding_value(&report.open_holes);
    value["filling_points"] = json!(report.filling_points);
    value["filling_faces"] = json!(report.filling_faces);
    value["seam_attributes"] = json!(report.seam_attributes);
    value["repaired"] = report::topology_value(&report.after);
    value
}
