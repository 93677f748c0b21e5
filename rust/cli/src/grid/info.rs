//! `relievo grid info`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Result;
use relievo_openvdb::{GridInfo, Survey};
use serde_json::{Value, json};

use crate::Outcome;

/// Lists the grids of an OpenVDB file without reading the values of their leaves. The OpenVDB module is not needed.
#[derive(clap::Args)]
#[command(after_help = "Example: relievo grid info smoke.vdb --json")]
pub struct Arguments {
    /// The file.
    #[arg(value_name = "FILE.vdb")]
    file: PathBuf,
    /// The name of the grid; all grids if it is left out.
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    /// Bytes that the list may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let limit = if arguments.memory_limit == 0 { u64::MAX } else { arguments.memory_limit };
    let mut survey = Survey::of_file(&arguments.file, limit)?;
    if let Some(name) = &arguments.grid {
        survey.find_any(name).map_err(|error| error.at(arguments.file.display().to_string()))?;
        survey.grids.retain(|grid| grid.name == *name);
    }
    let text = match arguments.json {
        true => format!("{:#}\n", machine_readable(&survey)),
        false => readable(&survey, arguments)?,
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn machine_readable(survey: &Survey) -> Value {
    let metadata = |list: &[relievo_openvdb::Entry]| -> Value {
        list.iter().map(|entry| json!({ "name": entry.name, "type": entry.kind, "value": entry.value })).collect()
    };
    let grid = |grid: &GridInfo| {
        json!({
            "name": grid.name,
            "kind": grid.kind.map(relievo_openvdb::Kind::name),
            "tree": grid.tree,
            "class": grid.class.name(),
            "half": grid.is_half,
            "instance_of": grid.instance_of,
            "voxel_size": grid.transform.voxel_size,
            "matrix": grid.transform.rows,
            "frustum": !grid.transform.is_linear,
            "active_voxels": grid.active_voxels,
            "leaves": grid.leaf_count,
            "bounds": grid.bounds,
            "memory_bytes": grid.memory_bytes,
            "metadata": metadata(&grid.metadata),
        })
    };
    json!({
        "file_version": survey.version,
        "library_version": survey.library,
        "stream": survey.is_stream,
        "metadata": metadata(&survey.metadata),
        "grids": survey.grids.iter().map(grid).collect::<Vec<_>>(),
    })
}

fn readable(survey: &Survey, arguments: &Arguments) -> Result<String> {
    let [major, minor] = survey.library;
    let form = if survey.is_stream { "a stream" } else { "a file" };
    let mut text = format!(
        "{}\n  {form} of version {}, written by OpenVDB {major}.{minor}\n",
        arguments.file.display(),
        survey.version
    );
    for entry in &survey.metadata {
        text.push_str(&format!("  {}: {}\n", entry.name, entry.value));
    }
    for grid in &survey.grids {
        let kind = grid.kind.map_or(grid.tree.as_str(), |kind| kind.name());
        let half = if grid.is_half { " with 16 bits" } else { "" };
        text.push_str(&format!("grid {:?}: {kind}{half}, {}\n", grid.name, grid.class.name()));
        if let Some(parent) = &grid.instance_of {
            text.push_str(&format!("  shares the tree of {parent:?}\n"));
        } else {
            let bounds = match grid.bounds {
                Some([low, high]) => format!(" from {low:?} to {high:?}"),
                None => String::new(),
            };
            text.push_str(&format!("  {} active voxels in {} leaves{bounds}\n", grid.active_voxels, grid.leaf_count));
            let mebibytes = grid.memory_bytes as f64 / f64::from(1 << 20);
            text.push_str(&format!("  at most {mebibytes:.1} MiB in memory\n"));
        }
        let map = if grid.transform.is_linear { "voxels of" } else { "a frustum, in its middle voxels of" };
        text.push_str(&format!("  {map} {:?}\n", grid.transform.voxel_size));
        for entry in grid.metadata.iter().filter(|entry| entry.name != "name" && entry.name != "class") {
            text.push_str(&format!("  {}: {}\n", entry.name, entry.value));
        }
    }
    Ok(text)
}
