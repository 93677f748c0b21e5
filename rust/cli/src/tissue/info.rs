//! `relievo tissue info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Context, Result};
use relievo_tissue::{SavedState, Simulation, SimulationOptions};
use serde_json::{Value, json};

use super::{Limits, is_named};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo tissue info gel.rtissue";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// A model, `.rtissue` or `.inp`, or a frame, `.rtstate`.
    path: PathBuf,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    tell(&arguments.limits.context()?, &arguments.path, arguments.json)
}

/// Prints what is in the model or frame at `path`, `for_programs` as JSON.
pub fn tell(context: &Context, path: &Path, for_programs: bool) -> Outcome {
    let value = match is_named(path, "rtstate") {
        true => frame(context, path)?,
        false => model(context, path)?,
    };
    let text = match (&value, for_programs) {
        (Value::Object(entries), false) => {
            let line = |(name, value): (&String, &Value)| format!("  {name}: {}\n", plain(value));
            format!("{}\n{}", path.display(), entries.iter().map(line).collect::<String>())
        }
        _ => format!("{value:#}\n"),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) => values.iter().map(plain).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

fn frame(context: &Context, path: &Path) -> Result<Value> {
    let SavedState { level, state, .. } = SavedState::read(context, path)?;
    let size = |row: &[f32; 4]| row[..3].iter().map(|part| part * part).sum::<f32>().sqrt();
    let most = |rows: &[[f32; 4]]| rows.iter().map(size).fold(0f32, f32::max);
    Ok(json!({
        "kind": "frame",
        "nodes": state.displacements.len(),
        "seconds": state.seconds,
        "steps": state.steps,
        "largest displacement, m": most(&state.displacements),
        "largest velocity, m/s": most(&state.velocities),
        "instruction level": level,
    }))
}

fn model(context: &Context, path: &Path) -> Result<Value> {
    let model = super::model(context, path)?;
    let material = |material: &relievo_tissue::Material| {
        format!("{} ({:.4e} Pa, {} kg/m³)", material.name, material.young(), material.density)
    };
    let mut value = json!({
        "kind": "model",
        "nodes": model.nodes.len(),
        "elements": model.elements.len(),
        "size of elements, m": model.cell,
        "materials": model.materials.iter().map(material).collect::<Vec<_>>(),
        "muscles": model.muscles.iter().map(|muscle| muscle.name.clone()).collect::<Vec<_>>(),
        "elements with fibres": (0..model.fibres.len()).filter(|element| !model.fibres.get(*element).is_empty()).count(),
        "held nodes": model.held.len(),
        "sliding nodes": model.sliding.len(),
        "sets": model.sets.iter().map(|set| format!("{} ({})", set.name, set.nodes.len())).collect::<Vec<_>>(),
        "bound surfaces": model.bindings.iter().map(|it| format!("{} ({} points)", it.name, it.anchors.len())).collect::<Vec<_>>(),
    });
    let simulation = Simulation::new(model, &SimulationOptions::default())?;
    value["stable step, s"] = json!(simulation.steps().stable);
    Ok(value)
}
