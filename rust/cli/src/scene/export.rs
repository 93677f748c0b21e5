//! `relievo scene export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Context, ContextOptions, Error};
use relievo_scene::description::When;
use relievo_scene::showing::Showing;
use relievo_scene::stepper::RunOptions;

use super::folder::folder_of;
use crate::Outcome;
use crate::args::numbers::{frames, pixels};
use crate::args::viewpoint::Axis;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Writes frames of a scene as scenes for POV-Ray 3.7: camera, light, and displaced surfaces as geometry. A file of
    /// Bézier patches becomes a scene by itself.
    Pov(Frames),
    /// Writes frames of a scene as Python scripts that make them in Blender 3.4 and later, with their arrays beside them.
    Blender(Frames),
}

#[derive(clap::Args)]
struct Frames {
    /// The scene file, or for POV-Ray a file of Bézier patches.
    scene: PathBuf,
    /// Folder for everything that is written, with the cache of frames; left out, one named after the scene.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// First and last frame, both included; left out, the last one alone.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<(u32, u32)>,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
    /// Also read files below this folder.
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    /// The axis that points up, of Bézier patches.
    #[arg(long, value_enum, default_value = "z")]
    up: Axis,
    /// Pixels of a picture of Bézier patches: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = pixels, default_value = "640x480")]
    size: [u32; 2],
}

/// Writes the scene as its first frame would be called, for what includes it by that name.
fn patches(context: &Context, arguments: &Frames) -> Outcome {
    let surface = crate::mesh::tessellate::surface(context, &arguments.scene)?;
    let showing = Showing::new(surface.total_bounds(), arguments.up.into(), arguments.size)?;
    let folder = arguments.out.clone().unwrap_or_else(|| folder_of(&arguments.scene));
    std::fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, &error))?;
    let path = folder.join("scene-000000.pov");
    relievo_scene::povray::write_patches(&path, &surface, &showing)?;
    crate::print(&format!("{}\n", path.display()))?;
    Ok(ExitCode::SUCCESS)
}

pub fn run(arguments: &Arguments) -> Outcome {
    let (arguments, povray, blender) = match &arguments.what {
        What::Pov(arguments) => (arguments, When::Every, When::Never),
        What::Blender(arguments) => (arguments, When::Never, When::Every),
    };
    let context = Context::new(&ContextOptions { threads: 0, memory_limit: arguments.memory_limit })?;
    if povray == When::Every && relievo_meshio::holds_patches(&arguments.scene)? {
        return patches(&context, arguments);
    }
    let mut scene = relievo_scene::file::read_file(&arguments.scene)?;
    let output = &mut scene.output;
    (output.picture_frames, output.mesh, output.tiles) = (When::Never, When::Never, When::Never);
    (output.documents, output.povray, output.blender) = (When::Never, povray, blender);
    let last = output.frames - 1;
    let options = RunOptions {
        out: arguments.out.clone().unwrap_or_else(|| folder_of(&arguments.scene)),
        frames: Some(arguments.frames.unwrap_or((last, last))),
        allowed: arguments.allow_path.clone(),
        rebake: false,
        device: None,
    };
    let summary = relievo_scene::stepper::run_baked(&context, scene, &options, &mut Bar::new())?;
    for note in &summary.notes {
        eprintln!("note: {note}");
    }
    let files: Vec<String> = summary.files.iter().map(|file| format!("{}\n", file.display())).collect();
    crate::print(&files.concat())?;
    Ok(ExitCode::SUCCESS)
}
