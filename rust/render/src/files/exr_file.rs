//! OpenEXR files: layers of named channels, with attributes. Colour is written as Rec.709 and says so; colour of other
//! chromaticities is converted when it is read. Data channels are stored and read as they are.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::{self as file, ReadChannels as _, ReadLayers as _, WritableImage as _};
use glam::{DMat3, DVec3};
use half::f16;
use relievo_core::{Error, ErrorKind, Result};

use crate::chromaticities::{Chromaticities, REC_709};
use crate::files::output::replace;
use crate::frame::Frame;
use crate::image::Image;

/// The numbers of a channel, row after row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Half floats.
    F16(Vec<f16>),
    /// Floats.
    F32(Vec<f32>),
    /// Unsigned integers.
    U32(Vec<u32>),
}

impl Samples {
    pub(crate) fn len(&self) -> usize {
        match self {
            Samples::F16(values) => values.len(),
            Samples::F32(values) => values.len(),
            Samples::U32(values) => values.len(),
        }
    }

    /// The numbers as floats.
    pub fn to_f32(&self) -> Vec<f32> {
        match self {
            Samples::F16(values) => values.iter().map(|value| value.to_f32()).collect(),
            Samples::F32(values) => values.clone(),
            Samples::U32(values) => values.iter().map(|value| *value as f32).collect(),
        }
    }
}

/// A named channel: `R`, `G`, `B` and `A` for colour, `Z` for depth, `name.X` for parts of a vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, not empty.
    pub name: String,
    /// Its numbers.
    pub samples: Samples,
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Text.
    Text(String),
    /// A whole number.
    I32(i32),
    /// A float.
    F32(f32),
    /// A pair of whole numbers.
    I32x2([i32; 2]),
    /// A vector.
    F32x3([f32; 3]),
}

/// A picture of any channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Its name; only the single layer of a file may have none.
    pub name: Option<String>,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Its channels, with different names.
    pub channels: Vec<Channel>,
    /// What else is to be known of it, by name.
    pub attributes: Vec<(String, Value)>,
}

/// Whether an EXR file states that its colours are Rec.709.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Colour, scene-linear Rec.709.
    Color,
    /// Data, which is not a colour.
    Data,
}

/// No more than this is decoded, whatever the memory limit: a few bytes can claim any number of pixels.
const MAX_BYTES: u64 = 4 << 30;

/// Writes layers to an EXR file, compressed without loss.
///
/// # Errors
/// A name is empty, used twice or not storable, a channel has not as many numbers as its layer has pixels, or the
/// file cannot be written.
pub fn write_exr(path: &Path, layers: &[Layer], content: Content) -> Result<()> {
    let place = |error: Error| error.at(path.display().to_string());
    let Some(first) = layers.first() else {
        return Err(place(Error::invalid("an EXR file needs a layer")));
    };
    let bounds = file::IntegerBounds::from_dimensions((first.width as usize, first.height as usize));
    let mut attributes = file::ImageAttributes::new(bounds);
    if content == Content::Color {
        let [red, green, blue, white] =
            [REC_709.red, REC_709.green, REC_709.blue, REC_709.white].map(|[x, y]| file::Vec2(x, y));
        attributes.chromaticities = Some(exr::meta::attribute::Chromaticities { red, green, blue, white });
    }
    let mut encoded_layers = file::Layers::new();
    for (index, layer) in layers.iter().enumerate() {
        let twin = layers[..index].iter().any(|other| other.name == layer.name);
        if twin || (layers.len() > 1 && layer.name.is_none()) {
            return Err(place(Error::invalid("the layers of an EXR file need different names")));
        }
        let layer = encoded(layer).map_err(|error| place(error.at(format!("layer {index}"))))?;
        encoded_layers.push(layer);
    }
    let image = file::Image::from_layers(attributes, encoded_layers);
    replace(path, |writer| image.write().non_parallel().to_buffered(writer).map_err(failed))
}

fn encoded(layer: &Layer) -> Result<file::Layer<file::AnyChannels<file::FlatSamples>>> {
    let pixels = u64::from(layer.width) * u64::from(layer.height);
    if pixels == 0 || layer.channels.is_empty() || layer.width.max(layer.height) > i32::MAX as u32 {
        return Err(Error::invalid("it has no pixels, no channels or too many of them"));
    }
    let mut channels = file::SmallVec::new();
    for (index, channel) in layer.channels.iter().enumerate() {
        if channel.samples.len() as u64 != pixels {
            return Err(Error::invalid(format!(
                "channel `{}` has {} numbers for {pixels} pixels",
                channel.name,
                channel.samples.len()
            )));
        }
        if layer.channels[..index].iter().any(|other| other.name == channel.name) {
            return Err(Error::invalid(format!("channel `{}` is there twice", channel.name)));
        }
        let samples = match &channel.samples {
            Samples::F16(values) => file::FlatSamples::F16(values.clone()),
            Samples::F32(values) => file::FlatSamples::F32(values.clone()),
            Samples::U32(values) => file::FlatSamples::U32(values.clone()),
        };
        channels.push(file::AnyChannel::new(text(&channel.name)?, samples));
    }
    let mut attributes = match &layer.name {
        Some(name) => file::LayerAttributes::named(text(name)?),
        None => file::LayerAttributes::default(),
    };
    attributes.software_name = Some("Relievo".into());
    for (name, value) in &layer.attributes {
        let value = match value {
            Value::Text(value) => file::AttributeValue::Text(text(value)?),
            Value::I32(value) => file::AttributeValue::I32(*value),
            Value::F32(value) => file::AttributeValue::F32(*value),
            Value::I32x2([x, y]) => file::AttributeValue::IntVec2(file::Vec2(*x, *y)),
            Value::F32x3([x, y, z]) => file::AttributeValue::FloatVec3((*x, *y, *z)),
        };
        attributes.other.insert(text(name)?, value);
    }
    let size = (layer.width as usize, layer.height as usize);
    let encoding = file::Encoding {
        compression: file::Compression::ZIP16,
        blocks: file::Blocks::ScanLines,
        line_order: file::LineOrder::Increasing,
    };
    Ok(file::Layer::new(size, attributes, encoding, file::AnyChannels::sort(channels)))
}

fn text(name: &str) -> Result<file::Text> {
    match file::Text::new_or_none(name) {
        Some(text) if !name.is_empty() && name.len() < 256 => Ok(text),
        _ => Err(Error::invalid(format!("`{name}` cannot be stored in an EXR file"))
            .advise("use up to 255 Latin-1 characters")),
    }
}

pub(crate) fn failed(error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(error) => Error::new(ErrorKind::Io, error.to_string()),
        exr::error::Error::NotSupported(what) => Error::unsupported(format!("the EXR uses what is not read: {what}")),
        other => Error::invalid(format!("the EXR cannot be read: {other}")),
    }
}

/// Reads the layers of an EXR file, at their largest resolution; deep layers are refused. If it states chromaticities
/// other than Rec.709's, every triple of channels whose names end in `R`, `G` and `B` is converted to linear Rec.709,
/// as floats; all other channels are as in the file.
///
/// # Errors
/// The file is missing, damaged, states chromaticities that cannot be, or would take more than `memory_limit` bytes.
pub fn read_exr(path: &Path, memory_limit: u64) -> Result<Vec<Layer>> {
    let place = |error: Error| error.at(path.display().to_string());
    let opened = File::open(path).map_err(|error| Error::io(path, &error))?;
    decode_exr(BufReader::new(opened), memory_limit).map_err(place)
}

/// As [`read_exr`], from an open file or bytes in memory.
///
/// # Errors
/// Fails with `Invalid` if the bytes are damaged or state chromaticities that cannot be, with `Unsupported` if they use
/// what is not read, with `Memory` if they take more than `memory_limit` bytes, and with `Io` if reading fails.
pub fn decode_exr(mut reader: impl std::io::BufRead + std::io::Seek, memory_limit: u64) -> Result<Vec<Layer>> {
    let meta = exr::meta::MetaData::read_from_buffered(&mut reader, false).map_err(failed)?;
    let mut bytes = 0u64;
    for header in &meta.headers {
        let pixels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        let per_pixel: u64 =
            header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample() as u64).sum();
        bytes = bytes.saturating_add(pixels.saturating_mul(per_pixel));
    }
    // Once as the file's samples and once as ours, which are floats where colours are converted.
    if bytes.saturating_mul(3) > memory_limit.min(MAX_BYTES) {
        return Err(Error::memory(format!("the EXR has {bytes} bytes of pixels, more than the memory limit allows"))
            .advise("make it smaller or the limit larger"));
    }
    reader.rewind().map_err(|error| Error::new(ErrorKind::Io, error.to_string()))?;
    let read = file::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = read.non_parallel().from_buffered(reader).map_err(failed)?;
    let to_rec_709 = match image.attributes.chromaticities {
        Some(exr::meta::attribute::Chromaticities { red, green, blue, white }) => {
            let [red, green, blue, white] = [red, green, blue, white].map(|place| [place.0, place.1]);
            Chromaticities { red, green, blue, white }.to_rec_709()?
        }
        None => None,
    };
    let mut layers = image.layer_data.into_iter().map(decoded).collect::<Result<Vec<_>>>()?;
    if let Some(matrix) = to_rec_709 {
        layers.iter_mut().for_each(|layer| convert_colors(layer, matrix));
    }
    Ok(layers)
}

/// Applies `matrix` to the colours of a layer. Pixels with a number that is not finite stay as they are.
fn convert_colors(layer: &mut Layer, matrix: DMat3) {
    let reds: Vec<usize> = (0..layer.channels.len())
        .filter(|red| layer.channels[*red].name.rsplit('.').next() == Some(COLOR[0]))
        .collect();
    for red in reds {
        let prefix = layer.channels[red].name.strip_suffix(COLOR[0]).unwrap_or_default();
        let named = |last: &str| {
            let name = format!("{prefix}{last}");
            layer.channels.iter().position(|channel| channel.name == name)
        };
        let (Some(green), Some(blue)) = (named(COLOR[1]), named(COLOR[2])) else { continue };
        let parts = [red, green, blue];
        // Integers are numbers of things, not light.
        if parts.iter().any(|part| matches!(layer.channels[*part].samples, Samples::U32(_))) {
            continue;
        }
        let mut values = parts.map(|part| layer.channels[part].samples.to_f32());
        for pixel in 0..values[0].len() {
            let color = DVec3::from(std::array::from_fn(|part| f64::from(values[part][pixel])));
            if color.is_finite() {
                let converted = (matrix * color).to_array();
                converted.iter().enumerate().for_each(|(part, value)| values[part][pixel] = *value as f32);
            }
        }
        for (part, values) in parts.into_iter().zip(values) {
            layer.channels[part].samples = Samples::F32(values);
        }
    }
}

fn decoded(layer: file::Layer<file::AnyChannels<file::FlatSamples>>) -> Result<Layer> {
    let (width, height) = (layer.size.width(), layer.size.height());
    let mut channels = Vec::with_capacity(layer.channel_data.list.len());
    for channel in layer.channel_data.list {
        let samples = match channel.sample_data {
            file::FlatSamples::F16(values) => Samples::F16(values),
            file::FlatSamples::F32(values) => Samples::F32(values),
            file::FlatSamples::U32(values) => Samples::U32(values),
        };
        if samples.len() != width * height {
            return Err(Error::unsupported(format!("channel `{}` is subsampled", channel.name)));
        }
        channels.push(Channel { name: channel.name.to_string(), samples });
    }
    let mut attributes: Vec<(String, Value)> = layer
        .attributes
        .other
        .into_iter()
        .filter_map(|(name, value)| {
            let value = match value {
                file::AttributeValue::Text(value) => Value::Text(value.to_string()),
                file::AttributeValue::I32(value) => Value::I32(value),
                file::AttributeValue::F32(value) => Value::F32(value),
                file::AttributeValue::IntVec2(file::Vec2(x, y)) => Value::I32x2([x, y]),
                file::AttributeValue::FloatVec3((x, y, z)) => Value::F32x3([x, y, z]),
                _ => return None,
            };
            Some((name.to_string(), value))
        })
        .collect();
    if let Some(comments) = layer.attributes.comments {
        attributes.push(("comments".into(), Value::Text(comments.to_string())));
    }
    attributes.sort_by(|a, b| a.0.cmp(&b.0));
    let name = layer.attributes.layer_name.map(|name| name.to_string());
    Ok(Layer { name, width: width as u32, height: height as u32, channels, attributes })
}

impl Layer {
    /// The numbers of a channel.
    pub fn channel(&self, name: &str) -> Option<&Samples> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| &channel.samples)
    }

    /// The channels of the given names as a picture, `None` unless all are there.
    pub fn image(&self, names: &[&str]) -> Option<Image> {
        let parts: Vec<Vec<f32>> =
            names.iter().map(|name| self.channel(name).map(Samples::to_f32)).collect::<Option<_>>()?;
        let count = self.width as usize * self.height as usize;
        let data = (0..count).flat_map(|at| parts.iter().map(move |part| part[at])).collect();
        Image::from_data(self.width, self.height, names.len() as u32, data).ok()
    }

    /// Adds the channels of a picture under the given names, one per channel.
    pub fn add(&mut self, names: &[&str], image: &Image) {
        let width = image.channels() as usize;
        for (at, name) in names.iter().enumerate().take(width) {
            let values = image.data().iter().skip(at).step_by(width).copied().collect();
            self.channels.push(Channel { name: (*name).into(), samples: Samples::F32(values) });
        }
    }
}

/// Channel names of colour, normals and albedo in the files of frames.
pub(crate) const COLOR: [&str; 3] = ["R", "G", "B"];
pub(crate) const NORMAL: [&str; 3] = ["normal.X", "normal.Y", "normal.Z"];
pub(crate) const ALBEDO: [&str; 3] = ["albedo.R", "albedo.G", "albedo.B"];
pub(crate) const DEPTH: [&str; 1] = ["Z"];

impl Frame {
    /// Writes all of the frame to an EXR file: `R G B`, `Z`, `normal.X Y Z`, `albedo.R G B` as floats, and `object` as
    /// unsigned integers.
    ///
    /// # Errors
    /// Fails with `Invalid` if the pictures of the frame differ in size, and with `NotFound` or `Io` if the file cannot
    /// be written.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let (width, height) = (self.color.width(), self.color.height());
        let mut layer = Layer { name: None, width, height, channels: Vec::new(), attributes: Vec::new() };
        layer.add(&COLOR, &self.color);
        layer.add(&DEPTH, &self.depth);
        layer.add(&NORMAL, &self.normal);
        layer.add(&ALBEDO, &self.albedo);
        layer.channels.push(Channel { name: "object".into(), samples: Samples::U32(self.object.clone()) });
        write_exr(path, &[layer], Content::Color)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn tiles() -> Vec<Layer> {
        let layer = |name: &str, side: u32| Layer {
            name: Some(name.into()),
            width: side,
            height: side,
            channels: vec![
                Channel {
                    name: "displacement".into(),
                    samples: Samples::F16((0..side * side).map(|at| f16::from_f32(at as f32 / 7.0 - 3.0)).collect()),
                },
                Channel { name: "tile".into(), samples: Samples::U32(vec![side; (side * side) as usize]) },
            ],
            attributes: vec![
                ("face".into(), Value::I32(12)),
                ("origin".into(), Value::F32x3([1.0, 2.0, 3.0])),
                ("place".into(), Value::I32x2([-3, 7])),
                ("scale".into(), Value::F32(0.1)),
                ("surface".into(), Value::Text("terrain".into())),
            ],
        };
        vec![layer("tile.3", 8), layer("tile.9", 16)]
    }

    #[test]
    fn layers_of_halves_floats_and_integers_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles.exr");
        write_exr(&path, &tiles(), Content::Data).unwrap();
        assert_eq!(read_exr(&path, u64::MAX).unwrap(), tiles());
        let meta = exr::meta::MetaData::read_from_file(&path, false).unwrap();
        assert_eq!(meta.headers[0].shared_attributes.chromaticities, None);
        write_exr(&path, &tiles(), Content::Color).unwrap();
        let meta = exr::meta::MetaData::read_from_file(&path, false).unwrap();
        assert_eq!(meta.headers[0].shared_attributes.chromaticities.unwrap().white, file::Vec2(0.3127, 0.3290));
    }

    /// A file of colours and data that states these chromaticities.
    fn stated(chromaticities: Chromaticities) -> Vec<u8> {
        let channel = |name: &str, samples| file::AnyChannel::new(name, samples);
        let half = |value: f32| file::FlatSamples::F16(vec![f16::from_f32(value), f16::from_f32(1.0)]);
        let channels = file::SmallVec::from_vec(vec![
            channel("R", half(1.0)),
            channel("G", half(0.0)),
            channel("B", half(0.0)),
            channel("Z", half(0.5)),
            channel("R.depth", half(0.25)),
            channel("albedo.R", file::FlatSamples::F32(vec![0.0, f32::INFINITY])),
            channel("albedo.G", file::FlatSamples::F32(vec![1.0, 1.0])),
            channel("albedo.B", file::FlatSamples::F32(vec![0.0, 1.0])),
            channel("lone.R", half(3.0)),
        ]);
        let mut image = file::Image::from_channels((2, 1), file::AnyChannels::sort(channels));
        let [red, green, blue, white] =
            [chromaticities.red, chromaticities.green, chromaticities.blue, chromaticities.white]
                .map(|[x, y]| file::Vec2(x, y));
        image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities { red, green, blue, white });
        let mut bytes = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn colours_of_other_chromaticities_become_rec_709_and_data_stays() {
        let rec_2020 = Chromaticities { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], ..REC_709 };
        let read = decode_exr(Cursor::new(stated(rec_2020)), u64::MAX).unwrap();
        let expect = |name: &str, first: f32, second: f32| {
            let values = read[0].channel(name).unwrap().to_f32();
            assert!((values[0] - first).abs() < 1e-4, "{name}: {values:?}");
            assert!(values[1] == second || (values[1] - second).abs() < 1e-4, "{name}: {values:?}");
        };
        // Columns of the matrix of Rec. ITU-R BT.2087; white stays white.
        for (name, value) in [("R", 1.6605), ("G", -0.1246), ("B", -0.0182)] {
            expect(name, value, 1.0);
        }
        expect("albedo.R", -0.5876, f32::INFINITY);
        expect("albedo.G", 1.1329, 1.0);
        for (name, value) in [("Z", 0.5), ("R.depth", 0.25)] {
            expect(name, value, 1.0);
        }
        assert_eq!(read[0].channel("lone.R").unwrap().to_f32(), [3.0, 1.0]);
        assert!(matches!(read[0].channel("Z").unwrap(), Samples::F16(_)));
        let same = decode_exr(Cursor::new(stated(REC_709)), u64::MAX).unwrap();
        assert_eq!(same[0].channel("R").unwrap(), &Samples::F16(vec![f16::ONE; 2]));
        let flat = Chromaticities { green: REC_709.red, ..REC_709 };
        let error = decode_exr(Cursor::new(stated(flat)), u64::MAX).unwrap_err();
        assert!(error.to_string().contains("chromaticities"), "{error}");
    }

    #[test]
    fn infinite_and_undefined_numbers_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.exr");
        let samples = Samples::F32(vec![f32::INFINITY, -0.0, 1e-40, f32::MAX]);
        let channels = vec![Channel { name: "Z".into(), samples }];
        let layer = Layer { name: None, width: 4, height: 1, channels, attributes: Vec::new() };
        write_exr(&path, std::slice::from_ref(&layer), Content::Data).unwrap();
        assert_eq!(read_exr(&path, u64::MAX).unwrap(), [layer]);
    }

    #[test]
    fn layers_that_cannot_be_stored_are_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.exr");
        let spoil: [fn(&mut Vec<Layer>); 6] = [
            |layers| layers.clear(),
            |layers| layers[1].name = None,
            |layers| layers[1].name = layers[0].name.clone(),
            |layers| layers[0].channels[1].samples = Samples::U32(vec![0; 3]),
            |layers| layers[0].channels[1].name = "displacement".into(),
            |layers| layers[1].channels[0].name = "\u{4e2d}".into(),
        ];
        for (case, spoil) in spoil.into_iter().enumerate() {
            let mut layers = tiles();
            spoil(&mut layers);
            let error = write_exr(&path, &layers, Content::Data).unwrap_err();
            assert!(error.to_string().contains("bad.exr"), "case {case}: {error}");
            assert!(!path.exists());
        }
    }

    #[test]
    fn truncated_and_too_large_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles.exr");
        write_exr(&path, &tiles(), Content::Data).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(3) {
            assert!(decode_exr(Cursor::new(&bytes[..length]), u64::MAX).is_err(), "{length} of {}", bytes.len());
        }
        assert_eq!(read_exr(&path, 1000).unwrap_err().kind, ErrorKind::Memory);
        // A data window of 2³¹ pixels a side must be refused before room is made for it.
        let window =
            bytes.windows(10).position(|part| part == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
        let mut wide = bytes.clone();
        wide[window + 8..window + 16].copy_from_slice(&[0xFF, 0xFF, 0xFF, 0x3F, 0xFF, 0xFF, 0xFF, 0x3F]);
        assert!(decode_exr(Cursor::new(wide), u64::MAX).is_err());
    }

    #[test]
    fn any_changed_byte_gives_an_error_or_a_picture_but_no_panic() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles.exr");
        write_exr(&path, &tiles(), Content::Data).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xFF] {
                let mut changed = bytes.clone();
                changed[at] ^= flip;
                let _ = decode_exr(Cursor::new(changed), 1 << 26);
            }
        }
    }
}
