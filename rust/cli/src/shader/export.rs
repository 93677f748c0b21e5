//! `relievo shader export`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;
use relievo_render::Content;
use relievo_shaderlab::{Classes, Language, Transfer, membership_function};

use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader export classes.json -o transfer.png --axes 0,1\n\
    Example: relievo shader export classes.json -o vessel.wgsl --name vessel";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Classes that `relievo shader classify` wrote.
    file: PathBuf,
    /// A 2-D transfer function as .png or .exr, or a function of all features as .wgsl or .glsl.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The features along the columns and, upwards, the rows of the image, counted from 0.
    #[arg(long, value_name = "A,B", value_parser = super::source::pixel, default_value = "0,1")]
    axes: [u32; 2],
    /// The ranges of these features, LOW,HIGH; left out, a quarter more than the examples on each side.
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, num_args = 2, allow_hyphen_values = true)]
    ranges: Vec<[f32; 2]>,
    /// Pixels of the image: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "256x256")]
    size: [u32; 2],
    /// The name of the function.
    #[arg(long, value_name = "NAME", default_value = "membership")]
    name: String,
}

fn range(text: &str) -> std::result::Result<[f32; 2], String> {
    let numbers: Vec<_> = text.split(',').map(|part| part.trim().parse::<f32>()).collect();
    match numbers.as_slice() {
        [Ok(low), Ok(high)] => Ok([*low, *high]),
        _ => Err(format!("{text:?} is not a lower and a higher number")),
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let classes = Classes::read(&arguments.file)?;
    let named = |error: Error| error.at(arguments.file.display().to_string());
    let ending = arguments.output.extension().map(|it| it.to_string_lossy().to_ascii_lowercase());
    let language = match ending.as_deref() {
        Some("wgsl") => Some(Language::Wgsl),
        Some("glsl" | "frag" | "vert" | "comp") => Some(Language::Glsl),
        _ => None,
    };
    if let Some(language) = language {
        super::source::store(
            &arguments.output,
            &membership_function(&classes, language, &arguments.name).map_err(named)?,
        )?;
        return Ok(ExitCode::SUCCESS);
    }
    let ranges = <[[f32; 2]; 2]>::try_from(arguments.ranges.as_slice()).ok();
    let axes = arguments.axes.map(|axis| axis as usize);
    let transfer = Transfer::new(&classes, axes, ranges).map_err(named)?;
    super::run::write(&arguments.output, &transfer.image(arguments.size[0], arguments.size[1])?, Content::Data)?;
    let [[a, b], [c, d]] = transfer.ranges();
    let names = arguments.axes.map(|axis| classes.features[axis as usize].as_str());
    crate::print(&format!("{}: {a} to {b}\n{}: {c} to {d}\n", names[0], names[1]))?;
    Ok(ExitCode::SUCCESS)
}
