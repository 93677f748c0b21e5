//! Images of colour in PNG and EXR files, as stickers and brushes take them.

use std::path::Path;

use relievo_core::{Error, Result};

use crate::files::exr_file::{Layer, Samples, read_exr};
use crate::files::png_file::read_png;
use crate::image::Image;

/// Channels that make an image, the first that are all there.
const SETS: [&[&str]; 5] = [&["R", "G", "B", "A"], &["R", "G", "B"], &["Y", "A"], &["Y"], &["A"]];

/// Reads an EXR file, by the ending of its name, or a PNG file into scene-linear Rec.709: one channel for grey, two for grey
/// and alpha, three or four for colour. Alpha is not premultiplied: colours of EXR files, which are, are divided by it where
/// it is above 0.
///
/// Of an EXR file the first layer is read: `R`, `G`, `B` and `A`; `Y` and `A`; or else its first channel.
///
/// # Errors
/// The file is missing, damaged, has no channels of colours, or would take more than `memory_limit` bytes.
pub fn read_image(path: &Path, memory_limit: u64) -> Result<Image> {
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
        return read_png(path, memory_limit);
    }
    let place = |error: Error| error.at(path.display().to_string());
    let layer = read_exr(path, memory_limit)?.into_iter().next();
    colors(layer, memory_limit).map_err(place)
}

fn colors(layer: Option<Layer>, memory_limit: u64) -> Result<Image> {
    let missing = || {
        Error::invalid("the EXR has no channels of colours")
            .advise("give its first layer the channels R, G and B, or Y")
    };
    let layer = layer.ok_or_else(missing)?;
    let only = layer.channels.first().map(|channel| [channel.name.as_str()]);
    let is_there = |names: &&[&str]| names.iter().all(|name| layer.channel(name).is_some());
    let names = SETS.into_iter().find(is_there).or(only.as_ref().map(|only| &only[..])).ok_or_else(missing)?;
    // The layer, its channels as floats, and the image.
    let held: u64 = layer.channels.iter().map(|channel| bytes(&channel.samples)).sum();
    let made = 8 * names.len() as u64 * u64::from(layer.width) * u64::from(layer.height);
    if held.saturating_add(made) > memory_limit {
        return Err(
            Error::memory("the picture does not fit the memory limit").advise("make it smaller or the limit larger")
        );
    }
    let mut image = layer.image(names).ok_or_else(missing)?;
    if names.len() > 1 && names.last() == Some(&"A") {
        for pixel in image.data_mut().chunks_exact_mut(names.len()) {
            if let [colors @ .., alpha] = pixel
                && *alpha > 0.0
            {
                colors.iter_mut().for_each(|color| *color /= *alpha);
            }
        }
    }
    Ok(image)
}

fn bytes(samples: &Samples) -> u64 {
    let size = match samples {
        Samples::F16(_) => 2,
        Samples::F32(_) | Samples::U32(_) => 4,
    };
    size * samples.len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::exr_file::{Channel, Content, write_exr};
    use crate::files::png_file::write_png;
    use half::f16;

    fn layer(channels: &[(&str, [f32; 2])]) -> Layer {
        let half = |values: [f32; 2]| Samples::F16(values.map(f16::from_f32).to_vec());
        let channels = channels.iter().map(|(name, values)| Channel { name: (*name).into(), samples: half(*values) });
        Layer { name: None, width: 2, height: 1, channels: channels.collect(), attributes: Vec::new() }
    }

    #[test]
    fn both_kinds_of_files_are_linear_with_alpha_that_is_not_premultiplied() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.EXR"));
        let image = Image::from_data(2, 1, 4, vec![0.5, 0.25, 1.0, 0.5, 0.0, 1.0, 0.0, 1.0]).unwrap();
        write_png(&png, &image).unwrap();
        let premultiplied = [("R", [0.25, 0.0]), ("G", [0.125, 1.0]), ("B", [0.5, 0.0]), ("A", [0.5, 1.0])];
        write_exr(&exr, &[layer(&premultiplied)], Content::Color).unwrap();
        let (png, exr) = (read_image(&png, u64::MAX).unwrap(), read_image(&exr, u64::MAX).unwrap());
        assert_eq!((exr.width(), exr.height(), exr.channels()), (2, 1, 4));
        for ((png, exr), wanted) in png.data().iter().zip(exr.data()).zip(image.data()) {
            assert!((png - wanted).abs() < 0.005 && (exr - wanted).abs() < 1e-3, "{png} {exr} {wanted}");
        }
    }

    #[test]
    fn channels_are_chosen_and_sizes_checked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let read = |channels: &[(&str, [f32; 2])], limit: u64| {
            write_exr(&path, &[layer(channels)], Content::Data).unwrap();
            read_image(&path, limit)
        };
        // Nothing is known of a pixel without alpha, and its colour stays.
        let hollow = read(&[("Y", [0.5, 2.0]), ("A", [0.0, 0.5])], u64::MAX).unwrap();
        assert_eq!((hollow.channels(), hollow.data()), (2, &[0.5, 0.0, 4.0, 0.5][..]));
        assert_eq!(read(&[("Z", [3.0, 0.5])], u64::MAX).unwrap().data(), [3.0, 0.5]);
        // Four bytes of halves, eight of floats, and eight of the image.
        assert!(read(&[("Y", [0.5, 2.0])], 20).is_ok());
        let said = read(&[("Y", [0.5, 2.0])], 19).unwrap_err().to_string();
        assert!(said.contains("memory limit") && said.contains("a.exr"), "{said}");
    }
}
