//! `relievo shader augment`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_shaderlab::Augmented;
use relievo_shaderlab::instrument::{EXAMPLES_HEAD, LOG_HEAD};
use serde_json::{Value, json};

use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader augment volume.wgsl -o augmented.wgsl --layout layout.json";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The shader: .wgsl, .frag, .vert, .comp or .glsl.
    file: PathBuf,
    /// The augmented shader to write: .wgsl, or the ending of the shader.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write the bindings of the two buffers and the features as JSON.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let shader = sound!(super::source::read(&arguments.file)?);
    let augmented = sound!(shader.augment());
    let is_wgsl = arguments.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("wgsl"));
    let text = if is_wgsl { sound!(augmented.wgsl(&shader)) } else { augmented.text.clone() };
    super::source::store(&arguments.output, &text)?;
    if let Some(file) = &arguments.layout {
        super::source::store(file, &format!("{:#}\n", layout(&augmented)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns what a host needs to know of an augmented shader.
pub fn layout(augmented: &Augmented) -> Value {
    let features: Vec<_> = augmented
        .features
        .iter()
        .map(|it| json!({ "name": it.name, "expression": it.expression, "description": it.description }))
        .collect();
    json!({
        "features": features,
        "accumulation": augmented.accumulation.name(),
        "uses_confidence": augmented.uses_confidence,
        "places": augmented.sites.len(),
        "examples": { "group": augmented.group, "binding": augmented.binding, "head_words": EXAMPLES_HEAD },
        "log": { "group": augmented.group, "binding": augmented.binding + 1, "head_words": LOG_HEAD },
    })
}
