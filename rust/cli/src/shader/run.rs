//! `relievo shader run`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use relievo_core::{Error, Result};
use relievo_render::{Channel, Content, Image, Layer, Samples, write_exr, write_png};

use super::opened::Options;
use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader run bilateral.frag -o edges.png --input photo=photo.png --set radius=6 \
    --set threshold=0.3 --positive 210,90 --negative 40,40 --mask mask.png";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// The picture to write: .png or .exr.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The mask to write: the membership of each pixel in the positive class, .png or .exr.
    #[arg(long, value_name = "FILE", required_unless_present = "output")]
    mask: Option<PathBuf>,
    /// Mark the classified pixels in the picture: green circles for positive ones, red ones for negative ones.
    #[arg(long)]
    circles: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let opened = sound!(arguments.options.open()?);
    if let Some(file) = &arguments.output {
        let mut image = opened.runner.picture(opened.classes.as_ref())?;
        if arguments.circles {
            for example in opened.classes.iter().flat_map(|classes| &classes.examples) {
                let color = if example.class.value() > 0.0 { [0.0, 0.8, 0.1] } else { [1.0, 0.05, 0.05] };
                circle(&mut image, example.pixel, color);
            }
        }
        write(file, &image, Content::Color)?;
    }
    if let Some(file) = &arguments.mask {
        let Some(classes) = &opened.classes else {
            let error = Error::invalid("the shader takes no vector").at("--mask");
            return Err(error.advise("mark a vector with `relievo shader mark`").into());
        };
        write(file, &opened.runner.mask(classes)?, Content::Data)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Draws a circle around a pixel.
fn circle(image: &mut Image, [x, y]: [u32; 2], color: [f32; 3]) {
    let radius = (image.width().min(image.height()) as f32 / 60.0).max(4.0);
    let reach = radius as i64 + 2;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let distance = ((dx * dx + dy * dy) as f32).sqrt();
            if (distance - radius).abs() <= (radius / 5.0).max(1.0)
                && let (Ok(column), Ok(row)) = (u32::try_from(i64::from(x) + dx), u32::try_from(i64::from(y) + dy))
            {
                image.set_color(column, row, color);
                // A circle is seen where the picture is transparent, too.
                if image.channels() == 4 && column < image.width() && row < image.height() {
                    let index = row as usize * image.width() as usize + column as usize;
                    image.data_mut()[4 * index + 3] = 1.0;
                }
            }
        }
    }
}

/// Writes an image by the ending of the file's name. Numbers of data are written to PNG without the encoding of colours.
pub fn write(file: &Path, image: &Image, content: Content) -> Result<()> {
    let ending = file.extension().map(|it| it.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("png") if content == Content::Data => {
            let mut encoded = image.clone();
            encoded.data_mut().iter_mut().for_each(|value| *value = relievo_render::color::decode_srgb(*value));
            write_png(file, &encoded)
        }
        Some("png") => write_png(file, image),
        Some("exr") => {
            let names: &[&str] = match image.channels() {
                1 => &["Y"],
                2 => &["Y", "A"],
                3 => &["R", "G", "B"],
                _ => &["R", "G", "B", "A"],
            };
            let channels = names.iter().enumerate().map(|(at, name)| Channel {
                name: (*name).to_owned(),
                samples: Samples::F32(image.data().iter().skip(at).step_by(names.len()).copied().collect()),
            });
            let layer = Layer {
                name: None,
                width: image.width(),
                height: image.height(),
                channels: channels.collect(),
                attributes: Vec::new(),
            };
            write_exr(file, &[layer], content)
        }
        _ => Err(Error::unsupported("the ending of the file is neither .png nor .exr").at(file.display().to_string())),
    }
}
