//! The image of the brush, as strokes of paint and of displacement use it.

use std::path::Path;

use relievo_core::{Context, Error, Result};
use relievo_detail::{Stamp, StampChannel, StampImage, StampSettings};
use relievo_render::color::encode_srgb;
use relievo_render::{Image, read_image};

/// An image that a brush paints or sculpts with.
#[derive(Clone, Debug, PartialEq)]
pub struct BrushStamp {
    /// The name of its file.
    pub name: String,
    /// Colours, linear.
    pub(crate) paint: Stamp,
    /// Heights, the numbers of the file as they are.
    pub(crate) sculpt: Stamp,
}

impl BrushStamp {
    /// Reads a PNG or EXR file.
    ///
    /// # Errors
    /// The file cannot be read, is damaged or too large.
    pub(crate) fn read(context: &Context, path: &Path) -> Result<Self> {
        let image = read_image(path, context.memory_limit())?;
        let make = |image: &Image| {
            let (width, height, channels) = (image.width(), image.height(), image.channels());
            let made = StampImage::new(width, height, channels, image.data());
            let stamp = made.and_then(|made| Stamp::new(made, StampSettings::default(), StampChannel::Red));
            stamp.map_err(|error: Error| error.at(path.display().to_string()))
        };
        let paint = make(&image)?;
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let sculpt = if is_exr { paint.clone() } else { make(&encoded(image))? };
        Ok(Self { name: name_of(path), paint, sculpt })
    }
}

/// The name of a file without its folder.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The numbers of a PNG file, of which the reader made linear colours.
fn encoded(mut image: Image) -> Image {
    let channels = image.channels() as usize;
    let colors = if channels.is_multiple_of(2) { channels - 1 } else { channels };
    for pixel in image.data_mut().chunks_exact_mut(channels) {
        pixel[..colors].iter_mut().for_each(|value| *value = encode_srgb(*value));
    }
    image
}
