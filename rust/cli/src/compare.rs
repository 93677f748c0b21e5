//! `relievo compare`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_comparison::{Comparison, compare};
use relievo_core::{Error, Result};
use relievo_render::{GeometryDifference, Picture, Row, compare_geometry, contact_sheet, write_png};
use serde_json::{Map, Value};

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The picture to compare with, PNG or EXR, and the pictures to judge; with --row as many for every row.
    #[arg(required = true, num_args = 2.., value_name = "PICTURE")]
    pictures: Vec<PathBuf>,
    /// What a row of pictures shows; once for every row, whose first picture is what the others are compared with.
    #[arg(long = "row", value_name = "LABEL")]
    rows: Vec<String>,
    /// Write all pictures beside each other, and what differs amplified, to this PNG file.
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
    /// What the pictures of a row are called in the sheet; left out, as the files of the first row.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    names: Vec<String>,
    /// Width of the sheet in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 1200, value_parser = clap::value_parser!(u32).range(64..=16384))]
    width: u32,
    /// Extent of the scene, which differences of depth are shares of; left out, how far the reference's depths are apart.
    #[arg(long, value_name = "LENGTH")]
    extent: Option<f64>,
    /// Write the FLIP error of every pixel, in colours, to this PNG file; of the first picture to judge.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// End with exit code 3 if the mean FLIP error is larger.
    #[arg(long, value_name = "ERROR")]
    max_error: Option<f64>,
    /// End with exit code 3 if more pixels are covered by one picture alone, as a share of those covered.
    #[arg(long, value_name = "SHARE")]
    max_silhouette: Option<f64>,
    /// End with exit code 3 if more than a thousandth of the depths inside differ by more, as a share of the extent.
    #[arg(long, value_name = "SHARE")]
    max_depth: Option<f64>,
    /// End with exit code 3 if half of the normals inside differ by more.
    #[arg(long, value_name = "DEGREES")]
    max_normal: Option<f64>,
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

/// A fact of a comparison.
type Fact = (&'static str, f64);

pub fn run(arguments: &Arguments) -> Outcome {
    let limit = if arguments.memory_limit == 0 { u64::MAX } else { arguments.memory_limit };
    let count = arguments.rows.len().max(1);
    let columns = arguments.pictures.len() / count;
    if columns < 2 || columns * count != arguments.pictures.len() {
        let pictures = arguments.pictures.len();
        return Err(Error::invalid(format!("{pictures} pictures are not two or more for each of {count} rows"))
            .advise("name as many pictures for every row")
            .into());
    }
    let mut rows = Vec::with_capacity(count);
    let mut results = Vec::new();
    let mut is_too_far = false;
    for (index, paths) in arguments.pictures.chunks(columns).enumerate() {
        let pictures: Vec<Picture> = paths.iter().map(|path| Picture::read(path, limit)).collect::<Result<_>>()?;
        let label = arguments.rows.get(index).cloned().unwrap_or_default();
        for (test, path) in pictures.iter().zip(paths).skip(1) {
            let place = |error: Error| error.at(path.display().to_string());
            let found = compare(&pictures[0], test, arguments.pixels_per_degree).map_err(place)?;
            let geometry = compare_geometry(&pictures[0], test, arguments.extent).map_err(place)?;
            is_too_far |= exceeds(arguments, &found, geometry.as_ref());
            if let Some(path) = arguments.map.as_ref().filter(|_| results.is_empty()) {
                write_png(path, &found.error_picture()?)?;
            }
            results.push((label.clone(), path.display().to_string(), facts(&found, geometry.as_ref())));
        }
        rows.push(Row { label, pictures });
    }
    if let Some(path) = &arguments.sheet {
        let name = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let files = arguments.pictures[..columns].iter().map(name);
        let names: Vec<String> = if arguments.names.is_empty() { files.collect() } else { arguments.names.clone() };
        write_png(path, &contact_sheet(&names, &rows, arguments.width)?)?;
    }
    crate::print(&if arguments.json { json(&results) } else { text(&results) })?;
    Ok(if is_too_far { ExitCode::from(3) } else { ExitCode::SUCCESS })
}

/// Whether the pictures differ by more than is allowed. What could not be compared is too far from any limit.
fn exceeds(arguments: &Arguments, found: &Comparison, geometry: Option<&GeometryDifference>) -> bool {
    let depth = geometry.and_then(|geometry| geometry.depth).map(|depth| depth.p999);
    let normal = geometry.and_then(|geometry| geometry.normal).map(|normal| normal.median.to_degrees());
    [
        (arguments.max_error, Some(found.flip.mean)),
        (arguments.max_silhouette, geometry.map(GeometryDifference::silhouette)),
        (arguments.max_depth, depth),
        (arguments.max_normal, normal),
    ]
    .into_iter()
    .filter_map(|(most, found)| Some((most?, found)))
    .any(|(most, found)| found.is_none_or(|found| found > most))
}

fn facts(found: &Comparison, geometry: Option<&GeometryDifference>) -> Vec<Fact> {
    let mut facts = vec![("flip mean", found.flip.mean), ("flip max", found.flip.max), ("ssim", found.ssim)];
    facts.extend([("rms", found.rms), ("psnr", found.psnr())]);
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
    let Some(geometry) = geometry else { return facts };
    facts.extend([
        ("covered pixels", geometry.covered as f64),
        ("silhouette", geometry.silhouette()),
        ("inside pixels", geometry.inside as f64),
        ("extent", geometry.extent),
    ]);
    if let Some(depth) = geometry.depth {
        facts.extend([("inside depth median", depth.median), ("inside depth p95", depth.p95)]);
        facts.extend([("inside depth p999", depth.p999), ("inside depth max", depth.max)]);
    }
    if let Some(normal) = geometry.normal {
        facts.extend([
            ("inside normal median degrees", normal.median.to_degrees()),
            ("inside normal p95 degrees", normal.p95.to_degrees()),
            ("inside normal p999 degrees", normal.p999.to_degrees()),
            ("inside normal max degrees", normal.max.to_degrees()),
        ]);
    }
    facts
}

/// The facts of one picture as they are, of several below their names.
fn text(results: &[(String, String, Vec<Fact>)]) -> String {
    let lines =
        |facts: &[Fact]| -> String { facts.iter().map(|(key, value)| format!("{key:28} {value:.6}\n")).collect() };
    match results {
        [(.., facts)] => lines(facts),
        _ => {
            let title = |row: &str| if row.is_empty() { String::new() } else { format!("{row}: ") };
            let part =
                |(row, file, facts): &(String, String, Vec<Fact>)| format!("{}{file}\n{}\n", title(row), lines(facts));
            results.iter().map(part).collect()
        }
    }
}

/// An object for one picture, a list of them for several.
fn json(results: &[(String, String, Vec<Fact>)]) -> String {
    let object = |(row, file, facts): &(String, String, Vec<Fact>)| {
        // JSON has no infinity, which is the ratio to no noise.
        let facts = facts.iter().map(|(key, value)| (key.replace(' ', "_"), Value::from(*value)));
        let names = [("row", row), ("file", file)].map(|(key, name)| (key.into(), Value::from(name.as_str())));
        Value::Object(names.into_iter().chain(facts).collect::<Map<_, _>>())
    };
    let value = match results {
        [result] => object(result),
        _ => results.iter().map(object).collect(),
    };
    format!("{value:#}\n")
}
