//! Texture files: large pictures of colours or data, with a text that says what the numbers are. Rows are asked for as
//! they are written, and compressed on the threads of a context, so that nothing but the caller's own numbers is ever
//! whole in memory.
//!
//! The text is the `comments` attribute of an EXR file and the `Comment` chunk of a PNG.

use std::io::Write;
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::meta::header::Header;
use exr::prelude as file;
use half::f16;
use relievo_core::{Context, Error, ErrorKind, Result};

use crate::chromaticities::REC_709;
use crate::color::encode_srgb;
use crate::files::exr_file::{Content, failed};
use crate::files::output::replace;

/// A picture to be written.
#[derive(Clone, Copy)]
pub struct Texture<'a> {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Numbers of a pixel: 1 grey, 3 RGB, 4 RGB and alpha.
    pub channels: usize,
    /// Whether they are colours, which are linear as they are given and sRGB-encoded in PNG, alpha aside, or data.
    pub content: Content,
    /// What the numbers are; Latin-1.
    pub text: &'a str,
    /// Writes the numbers of a row, the top one first, pixel after pixel.
    pub row: &'a (dyn Fn(u32, &mut [f32]) + Sync),
}

impl std::fmt::Debug for Texture<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{} × {} pixels of {} channels, {:?}", self.width, self.height, self.channels, self.content)
    }
}

/// The numbers of a texture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Bytes, 255 for 1: PNG.
    U8,
    /// 16 bits, 65535 for 1: PNG.
    U16,
    /// Half floats: EXR.
    F16,
    /// Floats: EXR.
    F32,
}

/// Rows that are made, compressed and written together.
const BATCH: u32 = 256;

/// Writes a texture as EXR for [`Depth::F16`] and [`Depth::F32`], else as PNG. Numbers that the depth cannot hold are
/// clamped.
///
/// # Errors
/// It has no pixels or other than 1, 3 or 4 channels, the text cannot be stored, or the file cannot be written.
pub fn write_texture(context: &Context, path: &Path, texture: &Texture<'_>, depth: Depth) -> Result<()> {
    let Texture { width, height, channels, .. } = *texture;
    if width == 0 || height == 0 || width.max(height) > 1 << 20 || ![1, 3, 4].contains(&channels) {
        return Err(Error::invalid(format!("a texture cannot have {width} × {height} pixels of {channels} channels"))
            .at(path.display().to_string()));
    }
    match depth {
        Depth::U8 | Depth::U16 => write_png(context, path, texture, depth),
        Depth::F16 | Depth::F32 => write_exr(context, path, texture, depth),
    }
}

fn write_png(context: &Context, path: &Path, texture: &Texture<'_>, depth: Depth) -> Result<()> {
    let Texture { width, height, channels, .. } = *texture;
    let wrong = |error: png::EncodingError| Error::new(ErrorKind::Io, error.to_string());
    replace(path, |file| {
        let mut encoder = png::Encoder::new(file, width, height);
        encoder.set_color(match channels {
            1 => png::ColorType::Grayscale,
            3 => png::ColorType::Rgb,
            _ => png::ColorType::Rgba,
        });
        encoder.set_depth(if depth == Depth::U8 { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
        if texture.content == Content::Color {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        encoder.set_compression(png::Compression::Fast);
        encoder.add_text_chunk("Software".into(), "Relievo".into()).map_err(wrong)?;
        encoder.add_text_chunk("Comment".into(), texture.text.into()).map_err(wrong)?;
        let mut writer = encoder.write_header().map_err(wrong)?;
        let mut stream = writer.stream_writer_with_size(1 << 20).map_err(wrong)?;
        let sent = |result: std::io::Result<()>| result.map_err(|error| Error::io(path, &error));
        for first in (0..height).step_by(BATCH as usize) {
            let rows = context.map(BATCH.min(height - first) as usize, |row| {
                let mut numbers = vec![0.0; width as usize * channels];
                (texture.row)(first + row as u32, &mut numbers);
                png_row(&numbers, texture, depth)
            });
            rows.iter().try_for_each(|row| sent(stream.write_all(row)))?;
        }
        stream.finish().map_err(wrong)?;
        writer.finish().map_err(wrong)
    })
}

/// The bytes of a row.
fn png_row(numbers: &[f32], texture: &Texture<'_>, depth: Depth) -> Vec<u8> {
    let encoded = |(index, number): (usize, &f32)| {
        let alpha = texture.channels == 4 && index % 4 == 3;
        let color = texture.content == Content::Color && !alpha;
        // A maximum with what is not a number is the other.
        let value = number.max(0.0).min(1.0);
        if color { encode_srgb(value) } else { value }
    };
    let values = numbers.iter().enumerate().map(encoded);
    match depth {
        Depth::U8 => values.map(|value| (value * 255.0 + 0.5) as u8).collect(),
        _ => values.flat_map(|value| ((value * 65_535.0 + 0.5) as u16).to_be_bytes()).collect(),
    }
}

fn write_exr(context: &Context, path: &Path, texture: &Texture<'_>, depth: Depth) -> Result<()> {
    let names: &[&str] = match texture.channels {
        1 => &["Y"],
        3 => &["B", "G", "R"],
        _ => &["A", "B", "G", "R"],
    };
    let header = header(texture, names, depth)?;
    let headers = std::slice::from_ref(&header);
    let blocks: Vec<_> = exr::block::enumerate_ordered_header_block_indices(headers).collect();
    let write = |writer: &mut std::io::BufWriter<std::fs::File>| {
        let headers = headers.iter().cloned().collect();
        exr::block::write(writer, headers, true, |meta, out| {
            for batch in blocks.chunks(BATCH as usize / header.compression.scan_lines_per_block()) {
                let packed = context.map(batch.len(), |at| {
                    let (number, index) = batch[at];
                    let data = block(texture, names, depth, index.pixel_position.y(), index.pixel_size.y());
                    UncompressedBlock { index, data }.compress_to_chunk(&meta.headers).map(|chunk| (number, chunk))
                });
                for chunk in packed {
                    let (number, chunk) = chunk?;
                    out.write_chunk(number, chunk)?;
                }
            }
            Ok(())
        })
    };
    replace(path, |file| write(file).map_err(failed))
}

fn header(texture: &Texture<'_>, names: &[&str], depth: Depth) -> Result<Header> {
    let sample_type = if depth == Depth::F16 { file::SampleType::F16 } else { file::SampleType::F32 };
    let name = |text: &str| {
        file::Text::new_or_none(text).ok_or_else(|| Error::invalid("a text of an EXR file is not Latin-1"))
    };
    let mut channels = file::SmallVec::new();
    for channel in names {
        let quantize_linearly = *channel == "A";
        let sampling = file::Vec2(1, 1);
        channels.push(file::ChannelDescription { name: name(channel)?, sample_type, quantize_linearly, sampling });
    }
    let size = file::Vec2(texture.width as usize, texture.height as usize);
    let mut shared = file::ImageAttributes::with_size(size);
    if texture.content == Content::Color {
        let [red, green, blue, white] =
            [REC_709.red, REC_709.green, REC_709.blue, REC_709.white].map(|[x, y]| file::Vec2(x, y));
        shared.chromaticities = Some(exr::meta::attribute::Chromaticities { red, green, blue, white });
    }
    let own = file::LayerAttributes {
        software_name: Some("Relievo".into()),
        comments: Some(name(texture.text)?),
        ..Default::default()
    };
    let mut header = Header::new(name("")?, size, channels)
        .with_encoding(file::Compression::ZIP16, exr::meta::BlockDescription::ScanLines, file::LineOrder::Increasing)
        .with_attributes(own)
        .with_shared_attributes(shared);
    header.own_attributes.layer_name = None;
    Ok(header)
}

/// The numbers of `count` rows: of each row channel after channel.
fn block(texture: &Texture<'_>, names: &[&str], depth: Depth, first: usize, count: usize) -> Vec<u8> {
    let (width, channels) = (texture.width as usize, texture.channels);
    let mut numbers = vec![0.0; width * channels];
    let mut bytes = Vec::with_capacity(count * width * channels * if depth == Depth::F16 { 2 } else { 4 });
    for row in first..first + count {
        (texture.row)(row as u32, &mut numbers);
        // Channels are in the order of the alphabet, which is the reverse of ours but for alpha.
        for name in names {
            let channel = match *name {
                "G" => 1,
                "B" => 2,
                "A" => 3,
                _ => 0,
            };
            let values = numbers.iter().skip(channel).step_by(channels);
            match depth {
                Depth::F16 => {
                    bytes.extend(values.flat_map(|value| f16::from_f32(value.clamp(-65504.0, 65504.0)).to_ne_bytes()))
                }
                _ => bytes.extend(values.flat_map(|value| value.to_ne_bytes())),
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Samples, Value, read_exr, read_png};

    #[test]
    fn numbers_and_text_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let context = Context::serial();
        let value = |x: u32, y: u32, channel: usize| (x + 7 * y) as f32 / 300.0 + 0.125 * channel as f32;
        for channels in [1, 3, 4] {
            let row = |y: u32, numbers: &mut [f32]| {
                for (index, number) in numbers.iter_mut().enumerate() {
                    *number = value((index / channels) as u32, y, index % channels);
                }
            };
            let texture = Texture {
                width: 21,
                height: 37,
                channels,
                content: if channels == 4 { Content::Color } else { Content::Data },
                text: "kind = \"height\"\nscale = 2",
                row: &row,
            };
            for depth in [Depth::F16, Depth::F32] {
                let path = folder.path().join("a.exr");
                write_texture(&context, &path, &texture, depth).unwrap();
                let layer = read_exr(&path, u64::MAX).unwrap().remove(0);
                assert_eq!(layer.attributes, [("comments".to_string(), Value::Text(texture.text.into()))]);
                let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B", "A"][..channels] };
                assert_eq!(layer.channels.len(), channels);
                for (channel, name) in names.iter().enumerate() {
                    let samples = layer.channel(name).unwrap();
                    assert_eq!(matches!(samples, Samples::F16(_)), depth == Depth::F16);
                    for (index, found) in samples.to_f32().into_iter().enumerate() {
                        let expected = value(index as u32 % 21, index as u32 / 21, channel);
                        assert!((found - expected).abs() < 1e-3, "{name} {index}: {found} {expected}");
                    }
                }
            }
            for depth in [Depth::U8, Depth::U16] {
                let path = folder.path().join("a.png");
                write_texture(&context, &path, &texture, depth).unwrap();
                let bytes = std::fs::read(&path).unwrap();
                assert!(bytes.windows(8).any(|w| w == b"Comment\0") && bytes.windows(9).any(|w| w == b"scale = 2"));
                let image = read_png(&path, u64::MAX).unwrap();
                for y in 0..37 {
                    for x in 0..21 {
                        for (channel, found) in image.pixel(x, y).iter().enumerate() {
                            let mut expected = value(x, y, channel).min(1.0);
                            if channels != 4 {
                                // Data is not encoded, and read as if it were.
                                expected = crate::color::decode_srgb(expected);
                            }
                            let near = if depth == Depth::U8 { 0.006 } else { 1e-4 };
                            assert!((found - expected).abs() < near, "({x}, {y}): {found} {expected}");
                        }
                    }
                }
            }
        }
        let texture = Texture {
            width: 0,
            height: 1,
            channels: 1,
            content: Content::Data,
            text: "",
            row: &|_: u32, _: &mut [f32]| {},
        };
        assert!(write_texture(&context, &folder.path().join("b.exr"), &texture, Depth::F32).is_err());
    }
}
