//! `relievo decal mesh`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Error;
use relievo_scene::overlap::lifted;
use serde_json::json;

use super::common::{Common, Depths};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo decal mesh head.ply -o logo.glb --image logo.png --pin 20,30@-0.2,1.1,0.8 \
    --pin 236,30@0.2,1.1,0.8 --pin 128,220@0,0.7,0.9 --offset 0.001 --picture logo.png";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// How far the decal lies above the surface, in units of the mesh. Where the sticker overlaps itself, each part lies this
    /// far above the one below it.
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_hyphen_values = true)]
    offset: f64,
    #[command(flatten)]
    depths: Depths,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    if !arguments.offset.is_finite() {
        return Err(Error::invalid("the offset is not finite").at("--offset").advise("give a length").into());
    }
    let laid = common.lay()?;
    let mesh = lifted(&laid.decal, &arguments.depths.depths, arguments.offset)?;
    relievo_meshio::write(&arguments.output, &mesh)?;
    common.draw(&laid, &arguments.depths.depths)?;
    let quality = &laid.decal.quality;
    let output = arguments.output.display().to_string();
    let text = if common.json {
        let mut value = super::common::machine_readable(common, &laid);
        value["output"] = json!(output);
        format!("{value:#}\n")
    } else {
        format!("{output}\n{}", super::common::described(quality))
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
