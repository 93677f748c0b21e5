//! `relievo foam info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Context, Error, Result};
use relievo_render::foam::FoamSettings;
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    /// A frame of foam, or a folder of frames.
    #[arg(required_unless_present = "settings")]
    path: Option<PathBuf>,
    /// Lists the settings of `--set` in place of a frame.
    #[arg(long)]
    settings: bool,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let text = match &arguments.path {
        Some(path) if !arguments.settings => frames(&context, path, arguments.json)?,
        _ => settings(arguments.json),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the settings with their values, ranges, units and help.
fn settings(json: bool) -> String {
    let table = FoamSettings::PARAMETERS;
    if json {
        let rows: Vec<Value> = table
            .iter()
            .map(|it| {
                json!({ "name": it.name, "default": it.default, "min": it.min, "max": it.max, "unit": it.unit, "help": it.help })
            })
            .collect();
        return format!("{:#}\n", Value::from(rows));
    }
    let line = |it: &relievo_core::Parameter| {
        format!("{:<18}{:>8} {:<3} {} to {}: {}\n", it.name, it.default, it.unit, it.min, it.max, it.help)
    };
    table.iter().map(line).collect()
}

/// Returns how many particles of each type frames have.
fn frames(context: &Context, path: &Path, json: bool) -> Result<String> {
    let files = match path.is_dir() {
        true => crate::fluid::frames(path)?,
        false => vec![(path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), path.to_owned())],
    };
    let mut rows = Vec::new();
    for (name, path) in &files {
        let particles = crate::fluid::read(context, path)?;
        let types = particles.channel("type").filter(|channel| channel.width == 1).ok_or_else(|| {
            Error::invalid("the particles have no channel `type`")
                .at(path.display().to_string())
                .advise("use frames of `relievo foam generate`")
        })?;
        let count = |kind: f32| types.values.iter().filter(|value| **value == kind).count();
        let [spray, foam, bubbles] = [0.0, 1.0, 2.0].map(count);
        rows.push((name, particles.time, particles.points.len(), [spray, foam, bubbles]));
    }
    if json {
        let rows: Vec<Value> = rows
            .iter()
            .map(|(name, time, all, [spray, foam, bubbles])| {
                json!({ "frame": name, "time": time, "particles": all, "spray": spray, "foam": foam, "bubbles": bubbles })
            })
            .collect();
        return Ok(format!("{:#}\n", Value::from(rows)));
    }
    let head = format!("{:<10}{:>12}{:>12}{:>12}{:>12}\n", "frame", "particles", "spray", "foam", "bubbles");
    let line = |(name, _, all, [spray, foam, bubbles]): &(&String, Option<f64>, usize, [usize; 3])| {
        format!("{name:<10}{all:>12}{spray:>12}{foam:>12}{bubbles:>12}\n")
    };
    Ok(head + &rows.iter().map(line).collect::<String>())
}
