//! `relievo decal texture`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_bake::Gutter;
use relievo_core::Error;
use relievo_decal::{Artwork, Pixels, charts, paint_texture, triangulated};
use relievo_render::{Image, read_png, write_png};
use serde_json::json;

use super::common::{Common, Depths};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo decal texture spot.obj -o painted.png --texture spot.png --image logo.png --width 0.3 \
    --pin 128,128@0.3,0.4,0.2";

/// The colour of a new texture, linear.
const GREY: f32 = 0.5;

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// The texture to write: .png.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The texture of the mesh to paint over, a PNG file; left out, a new grey one.
    #[arg(long, value_name = "FILE")]
    texture: Option<PathBuf>,
    /// The size of a new texture in pixels, WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "1024x1024", conflicts_with = "texture")]
    texture_size: [u32; 2],
    /// Pixels around islands of the texture that continue what is painted, so that filters find no background.
    #[arg(long, value_name = "PIXELS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=256))]
    gutter: u32,
    /// How much of the sticker is seen, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    opacity: f32,
    #[command(flatten)]
    depths: Depths,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    let context = common.limits.context()?;
    let mut texture = match &arguments.texture {
        Some(file) => read_png(file, context.memory_limit())?,
        None => {
            let [width, height] = arguments.texture_size;
            let mut image = Image::new(width, height, 3)?;
            image.data_mut().fill(GREY);
            image
        }
    };
    let mesh = triangulated(&relievo_meshio::read(&context, &common.file)?);
    // Without texture coordinates nothing needs to be laid.
    charts(&mesh, [texture.width(), texture.height()]).map_err(|error| error.at(common.place()))?;
    let laid = common.lay_on(context, mesh)?;
    let Some(image) = &laid.image else {
        return Err(Error::invalid("there is no image to paint").advise("give --image").into());
    };
    let artwork = Artwork::new(&laid.sticker, image)?;
    let depths = &arguments.depths.depths;
    let pixels =
        paint_texture(&laid.context, &laid.mesh, &laid.decal, &artwork, depths, arguments.opacity, &mut texture)?;
    let gutter = surround(&mut texture, &pixels, arguments.gutter);
    write_png(&arguments.output, &texture)?;
    common.draw(&laid, depths)?;
    let painted = pixels.painted.iter().filter(|is_painted| **is_painted).count();
    let output = arguments.output.display().to_string();
    let text = if common.json {
        let mut value = super::common::machine_readable(common, &laid);
        value["output"] = json!(output);
        value["pixels"] = json!(painted);
        value["gutter"] = json!(gutter);
        format!("{value:#}\n")
    } else {
        format!(
            "{output}\n{}pixels                 {painted}, and {gutter} of the gutter\n",
            super::common::described(&laid.decal.quality)
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Copies painted pixels into the gutter around what the charts cover. Returns how many pixels of the gutter changed.
fn surround(texture: &mut Image, pixels: &Pixels, distance: u32) -> usize {
    let channels = texture.channels() as usize;
    let gutter = Gutter::new(&pixels.covered, texture.width() as usize, distance);
    let data = texture.data_mut();
    let mut changed = 0;
    for (pixel, source) in gutter.copies.into_iter().map(|(pixel, source)| (pixel as usize, source as usize)) {
        if pixels.painted[source] {
            data.copy_within(channels * source..channels * (source + 1), channels * pixel);
            changed += 1;
        }
    }
    changed
}
