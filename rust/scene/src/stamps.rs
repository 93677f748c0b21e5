//! `[stamps.NAME]` of a scene file: images of brushes, read from PNG and EXR files or made from a pattern.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_detail::{Stamp, StampChannel, StampImage, StampSettings};
use relievo_render::color::encode_srgb;
use relievo_render::{Image, read_exr, read_png};

use crate::description::{StampEntry, StampSource};
use crate::diagnostic::Diagnostic;
use crate::paths::Paths;
use crate::reader::{Name, Reader, Table};
use crate::strokes::named;

pub(crate) fn read_stamp(reader: &mut Reader, name: &Name, table: Table) -> Option<StampEntry> {
    let channel = named(&StampChannel::NAMES, reader.choice(table, "channel"));
    let mut settings = StampSettings::default();
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    let (image, pattern) = (reader.text(table, "image"), reader.choice(table, "pattern"));
    let source = match (image, pattern) {
        (Some(file), None) => StampSource::File(file),
        (None, Some(pattern)) => StampSource::Pattern(pattern),
        (Some(file), Some(_)) => {
            reader.fault(
                Diagnostic::new(table.span_of("pattern"), "a stamp cannot be a file and a pattern")
                    .relate(file.span, "it is this file")
                    .advise("keep one of them"),
            );
            return None;
        }
        (None, None) => {
            reader.fault(
                Diagnostic::new(name.span.clone(), "the stamp has no image").advise("give it `image` or `pattern`"),
            );
            return None;
        }
    };
    Some(StampEntry { name: name.clone(), source, channel, settings })
}

/// A stamp of a scene as brushes use it, and a number for what its pixels are.
#[derive(Debug)]
pub(crate) struct Loaded {
    /// Colours, linear.
    pub paint: Stamp,
    /// Heights, the numbers of the file as they are.
    pub sculpt: Stamp,
    /// CRC-32 of the file; 0 for patterns.
    pub checksum: u32,
}

impl Loaded {
    /// Reads or makes the image of `entry`. Fails if the file cannot be read or is no usable image.
    pub fn new(context: &Context, paths: &Paths, entry: &StampEntry) -> Result<Self> {
        let stamp = |image| Stamp::new(image, entry.settings, entry.channel);
        match &entry.source {
            StampSource::Pattern(pattern) => {
                let image = make_pattern(pattern)?;
                Ok(Self { paint: stamp(image.clone())?, sculpt: stamp(image)?, checksum: 0 })
            }
            StampSource::File(file) => {
                let path = paths.resolve(&file.text)?;
                let checksum = crate::assets::checksum(&path)?;
                let limit = context.memory_limit();
                let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
                let image = if is_exr { exr(&path, limit)? } else { read_png(&path, limit)? };
                let place = |error: Error| error.at(path.display().to_string());
                let make = |image: &Image| {
                    let (width, height, channels) = (image.width(), image.height(), image.channels());
                    StampImage::new(width, height, channels, image.data()).map_err(place)
                };
                let paint = make(&image)?;
                let sculpt = if is_exr { paint.clone() } else { make(&encoded(image))? };
                Ok(Self { paint: stamp(paint)?, sculpt: stamp(sculpt)?, checksum })
            }
        }
    }
}

/// The first layer of an EXR file: its colours, with alpha if it has it, or the only channel it has.
fn exr(path: &std::path::Path, limit: u64) -> Result<Image> {
    let layers = read_exr(path, limit)?;
    let sets: [&[&str]; 5] = [&["R", "G", "B", "A"], &["R", "G", "B"], &["Y", "A"], &["Y"], &["A"]];
    let found = layers.first().and_then(|layer| {
        let only = layer.channels.first().map(|channel| channel.name.as_str());
        let only: Vec<&str> = only.into_iter().collect();
        sets.iter().find_map(|names| layer.image(names)).or_else(|| layer.image(&only))
    });
    found.ok_or_else(|| {
        Error::invalid("the EXR has no channels of a stamp")
            .at(path.display().to_string())
            .advise("give its first layer the channels R, G and B, or Y")
    })
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

/// Pixels along a pattern.
const SIZE: u32 = 256;
/// Samples along a pixel of a pattern.
const SAMPLES: u32 = 4;

/// A pattern: white, with alpha where it is.
fn make_pattern(pattern: &str) -> Result<Arc<StampImage>> {
    let mut data = Vec::with_capacity((4 * SIZE * SIZE) as usize);
    for k in 0..SIZE * SIZE {
        let mut covered = 0;
        for sample in 0..SAMPLES * SAMPLES {
            let at =
                |pixel: u32, part: u32| (pixel as f32 + (part as f32 + 0.5) / SAMPLES as f32) / SIZE as f32 * 2.0 - 1.0;
            covered += u32::from(is_in(pattern, at(k % SIZE, sample % SAMPLES), -at(k / SIZE, sample / SAMPLES)));
        }
        data.extend([1.0, 1.0, 1.0, covered as f32 / (SAMPLES * SAMPLES) as f32]);
    }
    StampImage::new(SIZE, SIZE, 4, &data)
}

/// Whether a place from −1 to 1 is in the pattern.
fn is_in(pattern: &str, x: f32, y: f32) -> bool {
    let r = x.hypot(y);
    match pattern {
        "checker" => (x < 0.0) == (y < 0.0),
        "stripes" => (4.0 * y).rem_euclid(2.0) < 1.0,
        "rings" => r < 1.0 && (4.0 * r) as u32 % 2 == 0,
        "star" => {
            // Five points: between a point and the notch beside it the edge is straight.
            let turn = std::f32::consts::TAU / 5.0;
            let angle = (x.atan2(y).rem_euclid(turn) - 0.5 * turn).abs();
            let (tip, notch) = (0.95f32, 0.38f32);
            let (a, b) = ([tip * (0.5 * turn).cos(), tip * (0.5 * turn).sin()], [notch, 0.0]);
            let p = [r * angle.cos(), r * angle.sin()];
            (a[0] - b[0]) * (p[1] - b[1]) - (a[1] - b[1]) * (p[0] - b[0]) > 0.0
        }
        _ => {
            // The sole of a shoe, toes to the right: a ball, a heel, and ribs across both.
            let inside = |center: f32, half: f32, width: f32| ((x - center) / half).powi(2) + (y / width).powi(2) < 1.0;
            (inside(0.35, 0.6, 0.45) || inside(-0.65, 0.3, 0.34)) && (9.0 * x).rem_euclid(1.0) < 0.62
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::PATTERNS;

    #[test]
    fn every_pattern_covers_a_part_of_its_box() {
        for pattern in PATTERNS {
            let stamp =
                Stamp::new(make_pattern(pattern).unwrap(), StampSettings::default(), StampChannel::Red).unwrap();
            let mean = stamp.sample([0.0, 0.0], 2.0)[3];
            assert!((0.15..0.6).contains(&mean), "{pattern}: {mean}");
        }
        let at = |x: f32, y: f32| is_in("star", x, y);
        assert!(at(0.0, 0.0) && at(0.0, 0.9) && !at(0.0, -0.6) && at(0.85, 0.28) && !at(0.5, 0.6));
    }
}
