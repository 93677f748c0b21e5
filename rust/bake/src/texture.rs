//! Maps as files: EXR or PNG, with a text in them that says what the numbers are.
//!
//! The text is TOML. Of a displacement it reads
//!
//! ```toml
//! kind = "displacement"
//! units = "object units"
//! space = "along the normal"
//! scale = 0.5
//! mid_level = 0.5
//! udim = 1001
//! ```
//!
//! and means that a number n of the file stands for (n − `mid_level`) · `scale` object units, as displacement nodes of
//! renderers count. Normals are stored as ½ + ½ n. Colours are linear Rec.709 in EXR and multiplied by alpha, as is the
//! custom there; in PNG they are sRGB-encoded and not multiplied.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Result};
use relievo_render::{Content, Depth, Texture, write_texture};

use crate::map::Map;
use crate::quantity::{Axes, Handedness, Meaning, Space};

/// How lengths and times become numbers of a file: a value is (number − `mid_level`) · `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// What 1 in the file stands for.
    pub scale: f32,
    /// The number of the file that stands for 0.
    pub mid_level: f32,
}

/// The formats of maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// Floats, or half floats for colours, normals and masks.
    Exr,
    /// 16 bits, or bytes for colours and masks.
    Png,
}

impl MapFormat {
    /// The format that the extension of a path names.
    ///
    /// # Errors
    /// Fails with `Unsupported` if it is neither .exr nor .png.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(Error::unsupported("the format of the picture is not known")
                .at(path.display().to_string())
                .advise("use the extension .exr or .png")),
        }
    }
}

impl Scaling {
    /// Numbers that are the values themselves.
    pub const PLAIN: Self = Self { scale: 1.0, mid_level: 0.0 };

    /// What `format` needs for values up to `largest`, positive and negative where the quantity can be: plain numbers
    /// in EXR; in PNG all of 0 to 1.
    pub fn fitting(format: MapFormat, meaning: Meaning, largest: f32) -> Self {
        let largest = if largest > 0.0 { largest } else { 1.0 };
        match (format, meaning) {
            (MapFormat::Exr, _) => Self::PLAIN,
            (_, Meaning::Displacement | Meaning::Vector(..)) => Self { scale: 2.0 * largest, mid_level: 0.5 },
            (_, Meaning::Depth | Meaning::Time) => Self { scale: largest, mid_level: 0.0 },
            _ => Self::PLAIN,
        }
    }

    /// The number of the file that stands for `value`.
    pub fn stored(&self, value: f32) -> f32 {
        (f64::from(value) / f64::from(self.scale) + f64::from(self.mid_level)) as f32
    }

    /// What a number of the file stands for.
    pub fn value(&self, stored: f32) -> f32 {
        ((f64::from(stored) - f64::from(self.mid_level)) * f64::from(self.scale)) as f32
    }

    /// Checks that both numbers can be used.
    ///
    /// # Errors
    /// Fails with `Invalid` if one is not finite, or the scale is 0.
    pub fn check(&self) -> Result<()> {
        if !self.scale.is_finite() || self.scale == 0.0 || !self.mid_level.is_finite() {
            return Err(Error::invalid(format!("a scale of {} with mid-level {}", self.scale, self.mid_level))
                .advise("use finite numbers, and a scale other than 0"));
        }
        Ok(())
    }
}

/// `path` with a number in place of `mark`, or in front of the extension.
pub fn numbered(path: &Path, mark: &str, number: impl Display) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let numbered = match (name.contains(mark), name.rsplit_once('.')) {
        (true, _) => name.replace(mark, &number.to_string()),
        (false, Some((stem, extension))) => format!("{stem}.{number}.{extension}"),
        (false, None) => format!("{name}.{number}"),
    };
    path.with_file_name(numbered)
}

/// Writes a map of what `meaning` says. Lengths and times go by `scaling`.
///
/// # Errors
/// Fails with `Unsupported` if the extension is neither .exr nor .png, with `Invalid` if the scaling cannot be used,
/// and with `NotFound` or `Io` if the file cannot be written.
pub fn write_map(context: &Context, path: &Path, map: &Map, meaning: Meaning, scaling: &Scaling) -> Result<()> {
    let format = MapFormat::of(path)?;
    scaling.check()?;
    let text = format!("{}udim = {}\n", statement(format, meaning, scaling), map.udim);
    let width = map.width as usize * map.channels;
    let row = |row: u32, out: &mut [f32]| {
        out.copy_from_slice(&map.data[row as usize * width..][..width]);
        encode(format, meaning, scaling, out);
    };
    let texture = Texture {
        width: map.width,
        height: map.height,
        channels: map.channels,
        content: content(meaning),
        text: &text,
        row: &row,
    };
    write_texture(context, path, &texture, depth(format, meaning))
}

fn content(meaning: Meaning) -> Content {
    if matches!(meaning, Meaning::Color) { Content::Color } else { Content::Data }
}

fn depth(format: MapFormat, meaning: Meaning) -> Depth {
    let coarse = matches!(meaning, Meaning::Color | Meaning::Mask | Meaning::Contact);
    match (format, meaning) {
        (MapFormat::Png, _) => {
            if coarse {
                Depth::U8
            } else {
                Depth::U16
            }
        }
        (MapFormat::Exr, Meaning::Normal(..)) => Depth::F16,
        (MapFormat::Exr, _) => {
            if coarse {
                Depth::F16
            } else {
                Depth::F32
            }
        }
    }
}

/// Raw numbers as a file has them.
fn encode(format: MapFormat, meaning: Meaning, scaling: &Scaling, numbers: &mut [f32]) {
    match meaning {
        Meaning::Displacement | Meaning::Vector(..) | Meaning::Depth | Meaning::Time => {
            numbers.iter_mut().for_each(|number| *number = scaling.stored(*number));
        }
        Meaning::Normal(..) => numbers.iter_mut().for_each(|number| *number = 0.5 + 0.5 * *number),
        Meaning::Color if format == MapFormat::Exr => {
            for [r, g, b, a] in numbers.as_chunks_mut::<4>().0 {
                (*r, *g, *b) = (*r * *a, *g * *a, *b * *a);
            }
        }
        Meaning::Color | Meaning::Mask | Meaning::Contact => {}
    }
}

/// What the numbers are, as TOML.
fn statement(format: MapFormat, meaning: Meaning, scaling: &Scaling) -> String {
    let Scaling { scale, mid_level } = scaling;
    let lengths = format!("units = \"object units\"\nscale = {scale:?}\nmid_level = {mid_level:?}\n");
    match meaning {
        Meaning::Displacement => {
            format!("kind = \"displacement\"\nspace = \"along the normal\"\n{lengths}")
        }
        Meaning::Vector(Space::Object, _) => {
            format!("kind = \"vector displacement\"\nspace = \"object\"\naxes = \"x, y, z\"\n{lengths}")
        }
        Meaning::Vector(Space::Tangent, axes) => {
            let axes = match axes {
                Axes::Tbn => "tangent, bitangent, normal",
                Axes::Tnb => "tangent, normal, bitangent",
            };
            format!("kind = \"vector displacement\"\nspace = \"tangent\"\naxes = \"{axes}\"\n{lengths}")
        }
        Meaning::Normal(space, handedness) => {
            let how = match (space, handedness) {
                (Space::Object, _) => "space = \"object\"\n".to_string(),
                (_, Handedness::OpenGl) => "space = \"tangent\"\nhandedness = \"OpenGL, +Y\"\n".to_string(),
                (_, Handedness::DirectX) => "space = \"tangent\"\nhandedness = \"DirectX, -Y\"\n".to_string(),
            };
            format!("kind = \"normal\"\n{how}encoding = \"0.5 + 0.5 n\"\n")
        }
        Meaning::Color => {
            let (space, alpha) = match format {
                MapFormat::Exr => ("linear Rec.709", "associated"),
                MapFormat::Png => ("sRGB", "unassociated"),
            };
            format!("kind = \"color\"\ncolor_space = \"{space}\"\nalpha = \"{alpha}\"\n")
        }
        Meaning::Mask => "kind = \"mask\"\nof = \"alpha of colours\"\n".into(),
        Meaning::Contact => "kind = \"mask\"\nof = \"contact\"\n".into(),
        Meaning::Depth => format!("kind = \"depth of contact\"\n{lengths}"),
        Meaning::Time => {
            let numbers = format!("scale = {scale:?}\nmid_level = {mid_level:?}\n");
            format!("kind = \"time of contact\"\nunits = \"seconds, -1 where there was none\"\n{numbers}")
        }
    }
}

#[cfg(test)]
mod tests {
    use relievo_core::Mesh;
    use relievo_render::{Value, read_exr, read_png};
    use relievo_surface::TileTopology;
    use relievo_tiles::{ChannelOptions, Displacement};

    use super::*;
    use crate::quantity::Quantity;

    #[test]
    fn numbers_stand_where_the_name_says_or_before_the_extension() {
        let path = |text: &str| PathBuf::from(text);
        assert_eq!(numbered(&path("a/b.c.exr"), "<UDIM>", 1012), path("a/b.c.1012.exr"));
        assert_eq!(numbered(&path("a/b_<UDIM>.png"), "<UDIM>", 1001), path("a/b_1001.png"));
        assert_eq!(numbered(&path("map"), "<UDIM>", 1001), path("map.1001"));
    }

    #[test]
    fn files_say_how_their_numbers_are_to_be_read() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(points, vec![4], vec![0, 1, 2, 3]);
        let topology = std::sync::Arc::new(TileTopology::new(&mesh).unwrap());
        let made = Displacement::new(topology, &ChannelOptions::default()).unwrap();
        let quantity = Quantity::Displacement(made.field()).meaning();
        let data = vec![-2.0, 0.0, 0.5, 2.0];
        let map = Map { udim: 1012, width: 2, height: 2, channels: 1, data, covered: vec![true; 4] };
        let folder = tempfile::tempdir().unwrap();
        let context = Context::serial();
        let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.PNG"));
        let plain = Scaling::fitting(MapFormat::Exr, quantity, 2.0);
        write_map(&context, &exr, &map, quantity, &plain).unwrap();
        let layer = read_exr(&exr, u64::MAX).unwrap().remove(0);
        assert_eq!(layer.channel("Y").unwrap().to_f32(), map.data);
        let Value::Text(text) = &layer.attributes[0].1 else { panic!("{layer:?}") };
        assert!(text.contains("scale = 1.0\nmid_level = 0.0\nudim = 1012"), "{text}");

        let scaling = Scaling::fitting(MapFormat::Png, quantity, 2.0);
        assert_eq!(scaling, Scaling { scale: 4.0, mid_level: 0.5 });
        write_map(&context, &png, &map, quantity, &scaling).unwrap();
        let image = read_png(&png, u64::MAX).unwrap();
        for (linear, value) in image.data().iter().zip(&map.data) {
            // The reader takes data for colours.
            let number = relievo_render::color::encode_srgb(*linear);
            assert!(((number - 0.5) * 4.0 - value).abs() < 1e-3, "{number} {value}");
        }
        assert!(write_map(&context, &png, &map, quantity, &Scaling { scale: 0.0, ..scaling }).is_err());
        assert!(write_map(&context, &folder.path().join("a.jpg"), &map, quantity, &scaling).is_err());
    }
}
