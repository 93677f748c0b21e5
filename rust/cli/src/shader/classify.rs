//! `relievo shader classify`

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;
use relievo_shaderlab::{Augmented, Class, Classes, Diagnosis, Explanation, Log, Project};
use serde_json::{Value, json};

use super::opened::Options;
use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader classify volume.toml --positive 310,220 --negative 200,90 -o classes.json \
    --why 330,240";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// The file of classes to write: .json.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Append the pixels of these options to the project.
    #[arg(long)]
    save: bool,
    /// Explain the membership of a pixel. May be repeated.
    #[arg(long, value_name = "X,Y", value_parser = super::source::pixel)]
    why: Vec<[u32; 2]>,
    /// Print JSON for programs, with all vectors of the pixels that are explained.
    #[arg(long)]
    json: bool,
}

/// A pixel that is explained.
struct Reason {
    pixel: [u32; 2],
    log: Log,
    explanation: Explanation,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let options = &arguments.options;
    if arguments.save && !options.is_project() {
        return Err(Error::invalid("the file is no project").at("--save").advise("name a project, .toml").into());
    }
    let opened = sound!(options.open()?);
    let (Some(augmented), Some(classes)) = (&opened.augmented, &opened.classes) else {
        let error = Error::invalid("the shader takes no vector");
        return Err(error.advise("mark a vector with `relievo shader mark`").into());
    };
    let plain = Classes::of(augmented);
    let mut reasons = Vec::with_capacity(arguments.why.len());
    for pixel in &arguments.why {
        let log = opened.runner.classify(&plain, *pixel)?;
        let explanation = Explanation::of(classes, &log.vector);
        reasons.push(Reason { pixel: *pixel, log, explanation });
    }
    // The vectors of explained pixels show how features correlate where there are few examples.
    let width = classes.features.len().max(1);
    let context: Vec<Vec<f32>> =
        reasons.iter().flat_map(|reason| reason.log.vectors.chunks_exact(width).map(<[f32]>::to_vec)).collect();
    let diagnosis = Diagnosis::of(classes, &context);
    if let Some(file) = &arguments.output {
        classes.write(file)?;
    }
    if arguments.save {
        Project::append(&options.file, &options.classified())?;
    }
    let text = match arguments.json {
        true => format!("{:#}\n", machine_readable(augmented, classes, &diagnosis, &reasons)),
        false => described(augmented, classes, &diagnosis, &reasons),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn class(class: Class) -> &'static str {
    match class {
        Class::Positive => "positive",
        Class::Negative => "negative",
    }
}

fn described(augmented: &Augmented, classes: &Classes, diagnosis: &Diagnosis, reasons: &[Reason]) -> String {
    let mut out = String::new();
    let names: Vec<_> = augmented.features.iter().map(|feature| feature.name.as_str()).collect();
    let vector = |vector: &[f32]| vector.iter().map(|value| format!("{value:.5}")).collect::<Vec<_>>().join("; ");
    let _ = writeln!(out, "features         {}", names.join("; "));
    for example in &classes.examples {
        let [x, y] = example.pixel;
        let _ = writeln!(out, "{} {x}, {y}: {}", class(example.class), vector(&example.vector));
    }
    match diagnosis.error {
        Some(error) => {
            let _ = writeln!(out, "leave-one-out    {:.1} % of the examples in the wrong class", 100.0 * error);
        }
        None if classes.examples.is_empty() => {}
        None => out.push_str("leave-one-out    needs two examples of each class\n"),
    }
    for (name, error) in names.iter().zip(&diagnosis.errors_without) {
        let _ = writeln!(out, "  without {name}: {:.1} %", 100.0 * error);
    }
    for pair in &diagnosis.correlations {
        let [a, b] = pair.features.map(|feature| names[feature]);
        let _ = writeln!(out, "correlated       {a} and {b}: {:.3}", pair.coefficient);
    }
    if let Some(feature) = diagnosis.redundant {
        let _ = writeln!(out, "can be left out  {}", names[feature]);
    }
    for Reason { pixel: [x, y], log, explanation } in reasons {
        let _ = writeln!(
            out,
            "pixel {x}, {y}: membership {:.4}, {} vectors, {}",
            explanation.membership,
            log.taken,
            vector(&log.vector)
        );
        for neighbour in explanation.neighbours.iter().take(3) {
            let example = &classes.examples[neighbour.example];
            let [x, y] = example.pixel;
            let share = 100.0 * neighbour.share;
            let _ = writeln!(
                out,
                "  {} {x}, {y} at distance {:.5}, {share:.1} % of the weight",
                class(example.class),
                neighbour.distance
            );
        }
        if let Some(feature) = explanation.deciding {
            let _ = writeln!(out, "  decided by {}", names[feature]);
        }
    }
    out
}

fn machine_readable(augmented: &Augmented, classes: &Classes, diagnosis: &Diagnosis, reasons: &[Reason]) -> Value {
    let names: Vec<_> = augmented.features.iter().map(|feature| feature.name.as_str()).collect();
    let correlations: Vec<_> = diagnosis
        .correlations
        .iter()
        .map(|pair| json!({ "features": pair.features, "coefficient": pair.coefficient }))
        .collect();
    let reasons: Vec<_> = reasons
        .iter()
        .map(|Reason { pixel, log, explanation }| {
            let neighbours: Vec<_> = explanation
                .neighbours
                .iter()
                .map(|it| json!({ "example": it.example, "distance": it.distance, "share": it.share }))
                .collect();
            json!({
                "pixel": pixel,
                "membership": explanation.membership,
                "vector": log.vector,
                "deciding": explanation.deciding,
                "neighbours": neighbours,
                "taken": log.taken,
                "weights": log.weights,
                "vectors": log.vectors,
            })
        })
        .collect();
    json!({
        "names": names,
        "classes": classes,
        "error": diagnosis.error,
        "errors_without": diagnosis.errors_without,
        "correlations": correlations,
        "redundant": diagnosis.redundant,
        "pixels": reasons,
    })
}
