//! `relievo shader values`

use std::fmt::Write;
use std::process::ExitCode;

use relievo_core::Result;
use relievo_shaderlab::{Setting, Shader, Source, Textures, Value, Variable};
use serde_json::json;

use super::opened::{Begun, Options};
use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader values volume.toml --pixel 310,220";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// The pixel, from the upper left corner.
    #[arg(long, value_name = "X,Y", value_parser = super::source::pixel)]
    pixel: [u32; 2],
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let Begun { project, inputs, size, device } = arguments.options.begin()?;
    let shader = sound!(Shader::new(Source::read(&project.shader)?));
    let vertex = sound!(project.vertex.as_deref().map(super::source::read).transpose()?.transpose());
    let (vertex, entry) = (vertex.as_ref(), project.entry.as_deref());
    let setting = Setting { device: &device, vertex, entry, size, inputs: &inputs };
    let values = shader.values(&setting, &mut Textures::default(), arguments.pixel)?;
    let text = if arguments.json { machine_readable(&shader, &values) } else { described(&shader, &values) };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn described(shader: &Shader, values: &[Result<Value>]) -> String {
    let numbers = |list: &[f32]| list.iter().map(|value| format!("{value:.6}")).collect::<Vec<_>>().join(", ");
    let mut out = String::new();
    for (variable, value) in shader.variables().iter().zip(values) {
        let name = variable.label.as_ref().unwrap_or(&variable.name);
        let _ = write!(out, "line {:<5} {name:<16} ", shader.line(variable));
        let _ = match value {
            Ok(Value { taken: 1, mean, .. }) => writeln!(out, "{}", numbers(mean)),
            Ok(Value { taken, mean, low, high }) => {
                let (mean, low, high) = (numbers(mean), numbers(low), numbers(high));
                writeln!(out, "{mean}, the mean of {taken} from {low} to {high}")
            }
            Err(error) => writeln!(out, "none: {}", error.what),
        };
    }
    out
}

fn machine_readable(shader: &Shader, values: &[Result<Value>]) -> String {
    let value = |(variable, value): (&Variable, &Result<Value>)| {
        let (name, line) = (&variable.name, shader.line(variable));
        match value {
            Ok(Value { taken, mean, low, high }) => {
                json!({ "name": name, "line": line, "taken": taken, "mean": mean, "low": low, "high": high })
            }
            Err(error) => json!({ "name": name, "line": line, "refused": error.what }),
        }
    };
    let list: Vec<_> = shader.variables().iter().zip(values).map(value).collect();
    format!("{:#}\n", json!(list))
}
