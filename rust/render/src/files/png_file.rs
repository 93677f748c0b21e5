//! PNG files: eight bits per channel, sRGB-encoded. Alpha is not encoded and not premultiplied.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use relievo_core::{Error, Result};

use crate::color::{decode_srgb, srgb_byte};
use crate::files::output::replace;
use crate::image::Image;

/// Writes a picture of scene-linear colour as PNG. One channel becomes grey, two grey and alpha.
///
/// # Errors
/// Fails with `NotFound` or `Io` if the file cannot be written.
pub fn write_png(path: &Path, image: &Image) -> Result<()> {
    let kind = match image.channels() {
        1 => png::ColorType::Grayscale,
        2 => png::ColorType::GrayscaleAlpha,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    };
    let channels = image.channels() as usize;
    let has_alpha = channels.is_multiple_of(2);
    let bytes: Vec<u8> = image
        .data()
        .iter()
        .enumerate()
        .map(|(at, value)| match has_alpha && at % channels == channels - 1 {
            true => (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8,
            false => srgb_byte(*value),
        })
        .collect();
    replace(path, |file| {
        let mut encoder = png::Encoder::new(file, image.width(), image.height());
        encoder.set_color(kind);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Fast);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&bytes)?;
            writer.finish()
        });
        written.map_err(|error| Error::new(relievo_core::ErrorKind::Io, error.to_string()))
    })
}

/// Reads a PNG of any kind into scene-linear colour: one channel for grey, three or four for colour.
///
/// # Errors
/// The file is missing, damaged, or would take more than `memory_limit` bytes.
pub fn read_png(path: &Path, memory_limit: u64) -> Result<Image> {
    let file = File::open(path).map_err(|error| Error::io(path, &error))?;
    let place = || path.display().to_string();
    decode_png(BufReader::new(file), memory_limit).map_err(|error| error.at(place()))
}

/// As [`read_png`], from an open file or bytes in memory.
///
/// # Errors
/// Fails with `Invalid` if the bytes are damaged or cannot be read, and with `Memory` if the picture takes more than
/// `memory_limit` bytes.
pub fn decode_png(file: impl std::io::BufRead + std::io::Seek, memory_limit: u64) -> Result<Image> {
    let damaged = |error: png::DecodingError| match error {
        png::DecodingError::LimitsExceeded => too_large(),
        other => Error::invalid(format!("the PNG cannot be read: {other}")),
    };
    let limit = usize::try_from(memory_limit).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(file, png::Limits { bytes: limit });
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = reader.info().size();
    let (kind, depth) = reader.output_color_type();
    let channels = kind.samples() as u32;
    let count = u64::from(width) * u64::from(height) * u64::from(channels);
    let bytes = reader.output_buffer_size().ok_or_else(too_large)?;
    if count.saturating_mul(4).saturating_add(bytes as u64) > memory_limit {
        return Err(too_large());
    }
    let mut raw = vec![0; bytes];
    let info = reader.next_frame(&mut raw).map_err(damaged)?;
    raw.truncate(info.buffer_size());
    let values: Vec<f32> = match depth {
        png::BitDepth::Sixteen => {
            raw.chunks_exact(2).map(|pair| f32::from(u16::from_be_bytes([pair[0], pair[1]])) / 65_535.0).collect()
        }
        _ => raw.iter().map(|byte| f32::from(*byte) / 255.0).collect(),
    };
    let mut image = Image::from_data(width, height, channels, values)?;
    let colors = if channels.is_multiple_of(2) { channels as usize - 1 } else { channels as usize };
    for pixel in image.data_mut().chunks_exact_mut(channels as usize) {
        for value in &mut pixel[..colors] {
            *value = decode_srgb(*value);
        }
    }
    Ok(image)
}

fn too_large() -> Error {
    Error::memory("the picture does not fit the memory limit").advise("make it smaller or the limit larger")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn ramp(channels: u32) -> Image {
        let count = 16 * 5 * channels;
        let data = (0..count).map(|at| decode_srgb((at % 256) as f32 / 255.0)).collect();
        Image::from_data(16, 5, channels, data).unwrap()
    }

    #[test]
    fn colours_survive_to_the_byte() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for channels in [1, 3] {
            let image = ramp(channels);
            write_png(&path, &image).unwrap();
            let again = read_png(&path, u64::MAX).unwrap();
            assert_eq!((again.width(), again.height(), again.channels()), (16, 5, channels));
            for (a, b) in again.data().iter().zip(image.data()) {
                assert_eq!(srgb_byte(*a), srgb_byte(*b));
            }
        }
        let alpha = Image::from_data(1, 1, 4, vec![0.5, 2.0, -1.0, 0.5]).unwrap();
        write_png(&path, &alpha).unwrap();
        let again = read_png(&path, u64::MAX).unwrap();
        assert!((again.data()[3] - 0.5).abs() < 0.003 && again.data()[1] == 1.0 && again.data()[2] == 0.0);
    }

    #[test]
    fn truncated_changed_and_too_large_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png(&path, &ramp(3)).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in 0..bytes.len() - 12 {
            assert!(decode_png(Cursor::new(&bytes[..length]), u64::MAX).is_err(), "{length} of {}", bytes.len());
        }
        assert_eq!(read_png(&path, 100).unwrap_err().kind, relievo_core::ErrorKind::Memory);
        let mut wide = bytes.clone();
        wide[16..20].copy_from_slice(&0x7FFF_FFFFu32.to_be_bytes());
        assert!(decode_png(Cursor::new(wide), 1 << 30).is_err());
        assert!(read_png(&folder.path().join("none.png"), 1).unwrap_err().to_string().contains("none.png"));
    }
}
