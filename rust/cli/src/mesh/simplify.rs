//! `relievo mesh simplify`

mod scene;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Error, Mesh, Result};
use relievo_lod::{AttributeOptions, SimplifiedMesh, SimplifyOptions, simplify_mesh};

use crate::Outcome;
use crate::bar::Bar;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("goal").required(true).multiple(true))]
pub struct Arguments {
    /// The mesh; its polygons are taken as triangles, and points at the same place as one. All meshes of a glTF file or a
    /// USD stage become one, at rest. Skins, animations, morph targets, nodes, names and textures are not written; a note on
    /// standard error counts what the file has of each.
    file: PathBuf,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off. Several levels are as many files, numbered from 1 before the
    /// extension: less-1.glb, less-2.glb.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Triangles to be left. This and the other goals take several values, separated by commas, one for each level; every
    /// level is made of the mesh that is given, so that its deviation is from that.
    #[arg(long, value_name = "N", group = "goal", conflicts_with = "ratio", value_delimiter = ',')]
    faces: Vec<usize>,
    /// The share of triangles to be left, from 0 to 1.
    #[arg(long, value_name = "R", group = "goal", value_delimiter = ',')]
    ratio: Vec<f64>,
    /// The largest distance between the surfaces before and after, either way, in units of the mesh. It is measured and
    /// never exceeded, which takes longer than the estimate of --error-estimate.
    #[arg(long, value_name = "E", group = "goal", value_delimiter = ',')]
    error: Vec<f32>,
    /// As --error, as a share of the diagonal of the mesh's box.
    #[arg(long, value_name = "R", group = "goal", conflicts_with = "error", value_delimiter = ',')]
    error_relative: Vec<f32>,
    /// The largest estimated deviation, in units of the mesh. It is fast to find; the distance may be several times as
    /// much.
    #[arg(
        long,
        value_name = "E",
        group = "goal",
        conflicts_with_all = ["error", "error_relative"],
        value_delimiter = ','
    )]
    error_estimate: Vec<f32>,
    /// Keep the vertices of open edges where they are.
    #[arg(long)]
    lock_border: bool,
    #[command(flatten)]
    attributes: Attributes,
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

/// What becomes of attributes.
#[derive(clap::Args)]
pub struct Attributes {
    /// How large a part of the diagonal of the mesh's box a difference of 1 of an attribute counts as; normals have
    /// 0.0005, colours 0.002, uv 0.02, others 0. May be repeated.
    #[arg(long, value_name = "NAME=WEIGHT", value_parser = weight)]
    weight: Vec<(String, f32)>,
    /// Leave an attribute out. May be repeated.
    #[arg(long, value_name = "NAME")]
    without: Vec<String>,
}

impl Attributes {
    pub fn options(&self) -> AttributeOptions {
        AttributeOptions { weights: self.weight.clone(), left_out: self.without.clone() }
    }
}

/// Why more triangles are left than were asked for.
pub const SEAMS: &str = "seams may keep triangles; --without NAME leaves an attribute and its seams out";

impl Arguments {
    /// Returns how many levels are asked for. Fails if lists of goals have different lengths above 1.
    fn level_count(&self) -> Result<usize> {
        let lists = [
            ("--faces", self.faces.len()),
            ("--ratio", self.ratio.len()),
            ("--error", self.error.len()),
            ("--error-relative", self.error_relative.len()),
            ("--error-estimate", self.error_estimate.len()),
        ];
        let count = lists.iter().map(|(_, length)| *length).max().unwrap_or(1);
        match lists.iter().find(|(_, length)| (2..count).contains(length)) {
            Some((option, length)) => Err(Error::invalid(format!("it has {length} values for {count} levels"))
                .at(*option)
                .advise("give one value for each level, or one for all of them")),
            None => Ok(count),
        }
    }

    /// Returns what a level is simplified to. Fails if a goal is out of its range.
    fn goal(&self, level: usize, mesh: &Mesh, triangles: usize) -> Result<SimplifyOptions> {
        let bound = bound(value(&self.error, level), value(&self.error_relative, level), &mesh.points)?;
        Ok(SimplifyOptions {
            target_triangles: faces(value(&self.faces, level), value(&self.ratio, level), triangles)?.unwrap_or(0),
            max_error: value(&self.error_estimate, level).unwrap_or(f32::INFINITY),
            bound: bound.unwrap_or(f32::INFINITY),
            is_border_locked: self.lock_border,
            ..SimplifyOptions::default()
        })
    }
}

/// Returns the value of a level in a list of one for each level, or of one for all.
fn value<T: Copy>(list: &[T], level: usize) -> Option<T> {
    list.get(level).or(list.first()).copied()
}

/// Returns the file of a level: the path with the level's number, from 1, before the extension.
fn level_path(path: &Path, level: usize) -> PathBuf {
    let mut name = OsString::from(path.file_stem().unwrap_or_default());
    name.push(format!("-{}", level + 1));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

pub fn run(arguments: &Arguments) -> Outcome {
    let options = relievo_core::ContextOptions { threads: arguments.threads, memory_limit: arguments.memory_limit };
    let context = relievo_core::Context::new(&options)?;
    let model = relievo_meshio::read_model(&context, &arguments.file)?;
    scene::left_out(&model, scene::texture_count(&context, &arguments.file)?)
        .iter()
        .for_each(|parts| eprintln!("note: {parts} left out"));
    let mesh = model.into_merged_mesh(&context).map_err(|error| error.at(arguments.file.display().to_string()))?;
    let before = mesh.triangles().len();
    let attributes = arguments.attributes.options();
    let count = arguments.level_count()?;
    let goals = (0..count).map(|level| arguments.goal(level, &mesh, before)).collect::<Result<Vec<_>>>()?;
    for (level, options) in goals.iter().enumerate() {
        let SimplifiedMesh { mesh: made, error, left_out } =
            simplify_mesh(&context, &mesh, options, &attributes, &mut Bar::new()).map_err(|error| {
                super::advice::offered(error, &mesh, &arguments.file).at(arguments.file.display().to_string())
            })?;
        let is_first = level == 0;
        left_out.iter().filter(|_| is_first).for_each(|name| eprintln!("note: {name} is left out"));
        let (path, label) = if count == 1 {
            (arguments.output.clone(), String::new())
        } else {
            let path = level_path(&arguments.output, level);
            let label = format!("{}: ", path.display());
            (path, label)
        };
        relievo_meshio::write(&path, &made)?;
        let left = made.face_count();
        if is_first && left > options.target_triangles.max(1) && options.max_error.min(options.bound) == f32::INFINITY {
            if !made.attributes.is_empty() {
                eprintln!("note: {SEAMS}");
            }
            super::advice::note_non_manifold(&mesh, &arguments.file);
        }
        let deviation = if options.bound < f32::INFINITY { "distance at most" } else { "estimated deviation" };
        crate::print(&format!("{label}{before} triangles, {left} left, {deviation} {error}\n"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the largest distance that is asked for, if one is: a length, or a share of the diagonal of the points' box.
pub fn bound(length: Option<f32>, share: Option<f32>, points: &[[f32; 3]]) -> Result<Option<f32>> {
    for (option, value) in [("--error", length), ("--error-relative", share)] {
        if let Some(value) = value.filter(|value| value.is_nan() || *value < 0.0) {
            return Err(Error::invalid(format!("{value} is negative or no number")).at(option).advise("use 0 or more"));
        }
    }
    let diagonal = || {
        let ranges = [0, 1, 2].map(|axis| {
            let values = || points.iter().map(|point| point[axis]);
            values().fold(f32::MIN, f32::max) - values().fold(f32::MAX, f32::min)
        });
        ranges.into_iter().fold(0.0, f32::hypot)
    };
    Ok(length.or_else(|| share.map(|share| share * diagonal())))
}

/// An attribute and its weight.
fn weight(text: &str) -> std::result::Result<(String, f32), String> {
    let (name, weight) = text.rsplit_once('=').ok_or("use NAME=WEIGHT")?;
    let weight = weight.parse().map_err(|_| format!("`{weight}` is no number"))?;
    Ok((name.to_owned(), weight))
}

/// The number of triangles that is asked for, if one is.
pub fn faces(faces: Option<usize>, ratio: Option<f64>, all: usize) -> Result<Option<usize>> {
    match ratio {
        Some(ratio) if (0.0..=1.0).contains(&ratio) => Ok(Some((all as f64 * ratio) as usize)),
        Some(ratio) => Err(Error::invalid(format!("{ratio} is no share")).at("--ratio").advise("use 0 to 1")),
        None => Ok(faces),
    }
}
