//! `relievo crowd export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, Progress};
use relievo_crowd::{CrowdModel, LevelSettings, MAX_LEVELS, clip_index};
use serde_json::json;

use crate::Outcome;
use crate::args::limits::Limits;
use crate::bar::Bar;

const EXAMPLE: &str = "\
Examples: relievo crowd export robot.rcrowd -o far.glb --error-relative 0.01 --time 0.5
          relievo crowd export robot.rcrowd -o levels.glb --levels 4
          relievo crowd export robot.rcrowd -o robot.glb --levels 4 --separate";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The crowd model.
    file: PathBuf,
    /// The mesh to write: .glb, .ply, .obj or .usda.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The largest distance from the input's surface in every pose, in units of the model; 0 for the input.
    #[arg(long, value_name = "E", default_value_t = 0.0, conflicts_with = "error_relative")]
    error: f32,
    /// As --error, as a share of the model's diagonal over all poses.
    #[arg(long, value_name = "SHARE")]
    error_relative: Option<f32>,
    /// Write up to N levels of detail into one .glb instead, by the extension MSFT_lod: skinned, with all clips. Each has at
    /// most a fourth of the triangles of the one before.
    #[arg(long, value_name = "N", conflicts_with_all = ["error", "error_relative", "clip", "time"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LEVELS)))]
    levels: Option<u32>,
    /// Error that may be seen, in pixels of a screen of 1920x1080, where a coarser level replaces a finer one.
    #[arg(long, value_name = "PIXELS", default_value_t = 0.5, requires = "levels")]
    pixels: f64,
    /// Write each level into a .glb of its own, without MSFT_lod: of robot.glb robot_LOD0.glb, robot_LOD1.glb and so on.
    #[arg(long, requires = "levels", conflicts_with = "pixels")]
    separate: bool,
    /// The clip, by name or by number from 0.
    #[arg(long, value_name = "NAME", default_value = "0")]
    clip: String,
    /// The time in the clip whose pose is written.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    time: f64,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let mut bar = Bar::new();
    bar.step(0.0, "read")?;
    let model = CrowdModel::load(&context, &arguments.file)?;
    if let Some(count) = arguments.levels {
        return write_levels(&model, arguments, count, bar);
    }
    let error = arguments.error_relative.map_or(arguments.error, |share| share * model.size());
    if !(error >= 0.0 && arguments.time.is_finite()) {
        return Err(Error::invalid("the error or the time is out of range")
            .advise("give an error of 0 or more")
            .into());
    }
    bar.step(0.3, "cut")?;
    let clusters = if error == 0.0 { model.input_clusters() } else { model.cut(error) };
    let clip = &model.clips[clip_index(&model, &arguments.clip)? as usize];
    let pose = &clip.poses[clip.pose_at(arguments.time)];
    let mesh = model.mesh(&context, &clusters, pose)?;
    let (triangles, input) = (mesh.face_count(), model.input_triangles);
    bar.step(0.6, "write")?;
    relievo_meshio::write(&arguments.output, &mesh)?;
    let output = arguments.output.display().to_string();
    let text = if arguments.json {
        let value = json!({
            "output": output, "triangles": triangles, "input_triangles": input, "error": error, "clip": clip.name,
        });
        format!("{value:#}\n")
    } else {
        format!("{output}\n{triangles} of {input} triangles\n")
    };
    drop(bar);
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn write_levels(model: &CrowdModel, arguments: &Arguments, count: u32, mut bar: Bar) -> Outcome {
    let path = &arguments.output;
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        return Err(Error::unsupported("levels of detail are written as GLB")
            .at(path.display().to_string())
            .advise("use the extension .glb, or write one level after the other by --error")
            .into());
    }
    let settings = LevelSettings { count, pixels: arguments.pixels, is_separate: arguments.separate };
    let exported = model.save_levels(path, &settings, &mut bar)?;
    drop(bar);
    if exported.sheared > 0 {
        eprintln!("note: {} bones are sheared, which glTF cannot say: their scale is the nearest", exported.sheared);
    }
    if model.character.morphs.count > 0 {
        eprintln!("note: morph targets keep the weights of the first pose");
    }
    let file =
        |level: usize| exported.files.get(level).or(exported.files.first()).map(|path| path.display().to_string());
    let levels = exported.levels.iter().enumerate();
    let text = if arguments.json {
        let levels = levels.map(
            |(level, (error, triangles))| json!({ "output": file(level), "error": error, "triangles": triangles }),
        );
        let value = json!({
            "levels": levels.collect::<Vec<_>>(), "input_triangles": model.input_triangles,
            "sheared_bones": exported.sheared,
        });
        format!("{value:#}\n")
    } else {
        let files: String = exported.files.iter().map(|path| format!("{}\n", path.display())).collect();
        let level = |(level, (error, triangles)): (usize, &(f32, u64))| {
            format!("level {level}: {triangles} triangles, error {error:.6}\n")
        };
        files + &levels.map(level).collect::<String>()
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
