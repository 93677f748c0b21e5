//! `relievo tissue build`

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use relievo_core::Error;
use relievo_scene::tissue::{Recipe, is_named};

use super::Limits;
use crate::Outcome;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo tissue build examples/tissue/gel.toml -o gel.rtissue";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// What the model is made of, in TOML (see `docs/tissue.md`), or a model, `.rtissue` or `.inp`.
    description: PathBuf,
    /// The model: `.rtissue`, or `.inp` for Abaqus and CalculiX.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Leaves out the layers of the skin and the epidermis, to see what they do.
    #[arg(long)]
    without_layers: bool,
    #[command(flatten)]
    limits: Limits,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let path = &arguments.description;
    let is_inp = is_named(&arguments.output, "inp");
    if !is_inp && !is_named(&arguments.output, "rtissue") {
        return Err(Error::unsupported("the format to write is not known")
            .at(arguments.output.display().to_string())
            .advise("use the extension .rtissue or .inp")
            .into());
    }
    let context = arguments.limits.context()?;
    let begin = Instant::now();
    let model = if is_named(path, "rtissue") || is_named(path, "inp") {
        super::model(&context, path)?
    } else {
        let mut recipe = Recipe::read(path)?;
        if arguments.without_layers {
            recipe.remove_layers();
        }
        let (model, report) = recipe.build(&context, &mut Bar::new())?;
        let [x, y, z] = report.voxels;
        crate::print(&format!("{x} × {y} × {z} voxels, {:.4e} m³ inside\n", report.volume))?;
        model
    };
    if is_inp {
        let left_out = [
            ("fibres", model.fibres.items.len()),
            ("sliding nodes", model.sliding.len()),
            ("bound surfaces", model.bindings.len()),
        ];
        for (what, count) in left_out.into_iter().filter(|(_, count)| *count > 0) {
            eprintln!("note: {}: {count} {what} have no counterpart and are left out", arguments.output.display());
        }
        model.write_inp(&arguments.output)?;
    } else {
        model.write(&arguments.output)?;
    }
    let seconds = begin.elapsed().as_secs_f64();
    let (elements, nodes) = (model.elements.len(), model.nodes.len());
    crate::print(&format!("{}: {elements} elements, {nodes} nodes in {seconds:.2} s\n", arguments.output.display()))?;
    Ok(ExitCode::SUCCESS)
}
