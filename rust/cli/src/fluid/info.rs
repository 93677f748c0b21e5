//! `relievo fluid info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Context, Error, Result, file};
use relievo_fluid::{Checkpoint, Diffuse, Emitter};
use relievo_particleio::{Format, Particles, read_frame};
use relievo_simulation::Description;
use serde_json::{Value, json};

use super::files::beside;
use crate::Outcome;
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    /// A file of particles, a folder of frames, or a description (.toml), of which it says what it begins as.
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

/// Prints what is in a file or a folder.
pub fn tell(context: &Context, path: &Path, json: bool) -> Outcome {
    let value = if path.is_dir() {
        folder(context, path)?
    } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        begun(context, path)?
    } else {
        one(context, path)?
    };
    let text = match json {
        true => format!("{value:#}\n"),
        false => format!("{}\n{}", path.display(), lines(&value)),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// What is in a file.
fn one(context: &Context, path: &Path) -> Result<Value> {
    let named = |error: Error| error.at(path.display().to_string());
    let mut head = Vec::new();
    std::io::Read::read_to_end(&mut std::io::Read::take(file::open(path)?, 256), &mut head)
        .map_err(|error| Error::io(path, &error))?;
    let format = Format::of(&head).map_err(named)?;
    if format != Some(Format::Cache) {
        let particles = super::frames::read(context, path)?;
        return Ok(described(&particles, &format.map_or("points of a mesh".into(), |format| format.to_string())));
    }
    let frame = read_frame(context, &file::load(path, context.memory_limit())?).map_err(named)?;
    let mut value = described(&frame.particles, &Format::Cache.to_string());
    value["level"] = json!(frame.level);
    if Diffuse::has_state(&frame) {
        value["goes_on"] = json!(true);
        return Ok(value);
    }
    let checkpoint = Checkpoint::of(frame).map_err(named)?;
    value["goes_on"] = json!(checkpoint.is_some());
    if let Some(Checkpoint { step, totals, .. }) = checkpoint {
        value["step"] = json!(step);
        value["steps_so_far"] = json!(totals.steps);
        value["corrections_so_far"] = json!(totals.corrections);
    }
    Ok(value)
}

/// What a description begins as, and what there is beside the fluid.
fn begun(context: &Context, path: &Path) -> Result<Value> {
    let named = |error: Error| error.at(path.display().to_string());
    let description = Description::read(path)?;
    let files = beside(path);
    let mut play = description.play(context, &files).map_err(named)?;
    let fluid = description.begin(context, &files, &mut play).map_err(named)?;
    let mut value = described(&fluid.state().particles(description.spacing()), "description");
    value["frames"] = json!(description.frames);
    value["fps"] = json!(description.fps);
    let triangles = play.movers.iter().map(|mover| mover.triangles.len());
    value["colliders"] = json!(play.movers.len());
    value["triangles_of_colliders"] = json!(triangles.sum::<usize>());
    value["bodies"] = json!(play.bodies.len());
    value["emitters"] = json!(play.sources.emitters.len());
    let rates = play.sources.emitters.iter().map(Emitter::rate);
    value["emitted_a_second"] = json!(rates.sum::<f64>().round() as u64);
    value["sinks"] = json!(play.sources.sinks.len());
    Ok(value)
}

fn described(particles: &Particles, format: &str) -> Value {
    let range = |axis: usize| {
        let values = || particles.points.iter().map(|point| point[axis]);
        [values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max)]
    };
    let ranges = [0, 1, 2].map(range);
    let bounds = (!particles.points.is_empty()).then(|| [0, 1].map(|end| ranges.map(|range| shortest(range[end]))));
    let speed = |velocity: &[f32; 3]| velocity.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>().sqrt();
    let fastest = particles.velocities().map(|all| all.iter().map(speed).fold(0.0, f64::max));
    let channels = particles.channels.iter().map(|channel| json!({ "name": channel.name, "width": channel.width }));
    json!({
        "format": format,
        "particles": particles.points.len(),
        "seconds": particles.time,
        "spacing": particles.spacing.map(shortest),
        "bounds": bounds,
        "fastest": fastest,
        "numbered": particles.numbers.is_some(),
        "channels": channels.collect::<Vec<_>>(),
    })
}

/// A number with the digits that tell it from its neighbours in 32 bits.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// What is in a folder, with its first and last frame.
fn folder(context: &Context, path: &Path) -> Result<Value> {
    let frames = super::frames::frames(path)?;
    let describe = |at: usize| -> Result<Value> {
        let (name, path) = &frames[at];
        let mut value = one(context, path)?;
        value["frame"] = json!(name);
        Ok(value)
    };
    let bytes = frames.iter().filter_map(|(_, path)| Some(path.metadata().ok()?.len()));
    Ok(json!({
        "frames": frames.len(),
        "bytes": bytes.sum::<u64>(),
        "first": describe(0)?,
        "last": describe(frames.len() - 1)?,
    }))
}

/// The values as lines of text, those of objects within behind their names.
fn lines(value: &Value) -> String {
    let Value::Object(fields) = value else { return format!("{value}\n") };
    let line = |(name, value): (&String, &Value)| match value {
        Value::Null => String::new(),
        Value::Object(_) => {
            let inner: String = lines(value).lines().map(|line| format!("  {line}\n")).collect();
            format!("  {name}:\n{inner}")
        }
        Value::Array(items) if items.iter().all(Value::is_object) && !items.is_empty() => {
            let items: Vec<_> = items
                .iter()
                .map(|item| format!("{} ({})", item["name"].as_str().unwrap_or_default(), item["width"]))
                .collect();
            format!("  {name}: {}\n", items.join(", "))
        }
        Value::String(text) => format!("  {name}: {text}\n"),
        other => format!("  {name}: {other}\n"),
    };
    fields.iter().map(line).collect()
}
