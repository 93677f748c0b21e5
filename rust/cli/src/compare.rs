//! `relievo compare`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_render::{Picture, compare, write_png};

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The picture to compare with, PNG or EXR.
    reference: PathBuf,
    /// The picture to judge.
    test: PathBuf,
    /// Write the FLIP error of every pixel, in colours, to this PNG file.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// End with exit code 3 if the mean FLIP error is larger.
    #[arg(long, value_name = "ERROR")]
    max_error: Option<f64>,
    /// Pixels per degree of the viewer's field of view, for FLIP.
    #[arg(long, value_name = "PIXELS", default_value_t = 67.0)]
    pixels_per_degree: f32,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    /// Bytes that a picture may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let limit = if arguments.memory_limit == 0 { u64::MAX } else { arguments.memory_limit };
    let reference = Picture::read(&arguments.reference, limit)?;
    let test = Picture::read(&arguments.test, limit)?;
    let found = compare(&reference, &test, arguments.pixels_per_degree)?;
    if let Some(path) = &arguments.map {
        write_png(path, &found.error_picture()?)?;
    }
    let mut facts = vec![("flip mean", found.flip.mean), ("flip max", found.flip.max), ("ssim", found.ssim)];
    if let Some(depth) = &found.depth {
        facts.extend([("depth mean", depth.mean), ("depth max", depth.max)]);
    }
    if let Some(normal) = &found.normal {
        facts.extend([
            ("normal mean degrees", normal.mean.to_degrees()),
            ("normal max degrees", normal.max.to_degrees()),
        ]);
    }
    if let Some(uncovered) = found.uncovered {
        facts.push(("uncovered pixels", uncovered as f64));
    }
    let text = if arguments.json {
        let map: serde_json::Map<String, serde_json::Value> =
            facts.iter().map(|(key, value)| (key.replace(' ', "_"), (*value).into())).collect();
        format!("{:#}\n", serde_json::Value::Object(map))
    } else {
        facts.iter().map(|(key, value)| format!("{key:20} {value:.6}\n")).collect()
    };
    crate::print(&text)?;
    let too_large = arguments.max_error.is_some_and(|most| found.flip.mean > most);
    Ok(if too_large { ExitCode::from(3) } else { ExitCode::SUCCESS })
}
