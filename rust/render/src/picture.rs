//! Pictures read from files for a comparison: colour, opacity, depth and normals.

use std::path::Path;

use relievo_core::{Error, Result};

use crate::files::exr_file::{COLOR, DEPTH, Layer, NORMAL, read_exr};
use crate::files::png_file::read_png;
use crate::image::Image;

/// What two pictures are compared by.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Scene-linear Rec.709 colour, three channels.
    pub color: Image,
    /// Opacity, if the file has it.
    pub alpha: Option<Image>,
    /// Depth, infinite where nothing is, if the file has it.
    pub depth: Option<Image>,
    /// Normals, zero where nothing is, if the file has them.
    pub normal: Option<Image>,
}

impl Picture {
    /// Reads a PNG, or an EXR with `R G B` and perhaps `A`, `Z` and `normal.X normal.Y normal.Z`, told apart by their
    /// first bytes. The names that Blender gives to its passes of colour, depth and normals will do too.
    ///
    /// # Errors
    /// The file is missing, damaged, neither of both, has no colour, or would take more than `memory_limit` bytes.
    pub fn read(path: &Path, memory_limit: u64) -> Result<Self> {
        let place = |error: Error| error.at(path.display().to_string());
        let mut start = [0; 4];
        {
            use std::io::Read;
            let mut opened = std::fs::File::open(path).map_err(|error| Error::io(path, &error))?;
            opened.read_exact(&mut start).map_err(|error| Error::io(path, &error))?;
        }
        match start {
            [0x89, b'P', b'N', b'G'] => {
                let image = read_png(path, memory_limit)?;
                Ok(Self { color: opaque(&image)?, alpha: alpha(&image)?, depth: None, normal: None })
            }
            [0x76, 0x2F, 0x31, 0x01] => {
                let layers = read_exr(path, memory_limit)?;
                Self::of_layers(&layers).map_err(place)
            }
            _ => Err(place(Error::unsupported("the file is neither a PNG nor an EXR"))),
        }
    }

    /// Reads the depths of an EXR file, which needs no colour; `None` if it has none.
    ///
    /// # Errors
    /// The file is missing, damaged, or would take more than `memory_limit` bytes.
    pub fn read_depth(path: &Path, memory_limit: u64) -> Result<Option<Image>> {
        Ok(depth_of(&read_exr(path, memory_limit)?))
    }

    /// The picture that layers of an EXR file have together.
    fn of_layers(layers: &[Layer]) -> Result<Self> {
        let first = layers.first().ok_or_else(|| Error::invalid("the EXR has no layer"))?;
        let find = |names: &[&str], pass: &str, parts: &[&str]| {
            first.image(names).or_else(|| layers.iter().find_map(|layer| pass_image(layer, pass, parts)))
        };
        let color = find(&COLOR, "Combined", &["R", "G", "B"]).or_else(|| first.image(&["Y", "Y", "Y"]));
        let color = color
            .ok_or_else(|| Error::invalid("the EXR has no colour").advise("give it the channels R, G and B, or Y"))?;
        let alpha = find(&["A"], "Combined", &["A"]);
        let mut depth = depth_of(layers);
        let normal = find(&NORMAL, "Normal", &["X", "Y", "Z"]);
        let size = |image: &Image| (image.width(), image.height());
        if [&alpha, &depth, &normal].into_iter().flatten().any(|image| size(image) != size(&color)) {
            return Err(Error::unsupported("the layers of the EXR differ in size"));
        }
        if let Some(depth) = &mut depth {
            // Some renderers have a large number where nothing is, or any.
            let opacities = alpha.iter().flat_map(|alpha| alpha.data().iter().copied()).chain(std::iter::repeat(1.0));
            for (depth, opacity) in depth.data_mut().iter_mut().zip(opacities) {
                if *depth >= FARTHEST || opacity <= 0.5 {
                    *depth = f32::INFINITY;
                }
            }
        }
        Ok(Self { color, alpha, depth, normal })
    }

    /// Which pixels show a surface: pixels that have a depth, or else are opaque for more than half; `None` if the
    /// picture does not say.
    pub fn covered(&self) -> Option<Vec<bool>> {
        let by_depth = self.depth.as_ref().map(|depth| depth.data().iter().map(|depth| depth.is_finite()).collect());
        let opaque = |alpha: &Image| alpha.data().iter().map(|alpha| *alpha > 0.5).collect();
        by_depth.or_else(|| self.alpha.as_ref().map(opaque))
    }
}

/// The depths of layers of an EXR file, as they are there.
fn depth_of(layers: &[Layer]) -> Option<Image> {
    let own = layers.first().and_then(|first| first.image(&DEPTH));
    let pass = |part: &str| layers.iter().find_map(|layer| pass_image(layer, "Depth", &[part]));
    own.or_else(|| pass("Z")).or_else(|| pass("V"))
}

/// The depth from which on nothing is seen: what Blender writes there.
const FARTHEST: f32 = 1e10;

/// The picture of channels that are called `View.Pass.Part`, of whatever view.
fn pass_image(layer: &Layer, pass: &str, parts: &[&str]) -> Option<Image> {
    let end = format!("{pass}.{}", parts.first()?);
    let fits = |name: &str| name.strip_suffix(end.as_str()).is_some_and(|view| view.is_empty() || view.ends_with('.'));
    let found = &layer.channels.iter().find(|channel| fits(&channel.name))?.name;
    let start = found.strip_suffix(parts.first()?)?;
    let names: Vec<String> = parts.iter().map(|part| format!("{start}{part}")).collect();
    layer.image(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// A picture as three channels: grey is repeated, and what is transparent is seen over black.
fn opaque(image: &Image) -> Result<Image> {
    let channels = image.channels() as usize;
    let data = image.data().chunks_exact(channels).flat_map(|pixel| match *pixel {
        [r, g, b] => [r, g, b],
        [r, g, b, a] => [r * a, g * a, b * a],
        [grey, a] => [grey * a; 3],
        _ => [pixel.first().copied().unwrap_or(0.0); 3],
    });
    Image::from_data(image.width(), image.height(), 3, data.collect())
}

/// The opacity of a picture, if it has one.
fn alpha(image: &Image) -> Result<Option<Image>> {
    let channels = image.channels() as usize;
    if !channels.is_multiple_of(2) {
        return Ok(None);
    }
    let data = image.data().iter().skip(channels - 1).step_by(channels).copied().collect();
    Image::from_data(image.width(), image.height(), 1, data).map(Some)
}

/// Returns the width and height that two pictures share.
///
/// # Errors
/// The sizes differ.
pub fn check_sizes(reference: &Picture, test: &Picture) -> Result<[u32; 2]> {
    let size = |picture: &Picture| [picture.color.width(), picture.color.height()];
    let ([width, height], [other_width, other_height]) = (size(reference), size(test));
    if size(reference) == size(test) {
        return Ok([width, height]);
    }
    Err(Error::invalid(format!("{width}×{height} against {other_width}×{other_height} pixels"))
        .advise("compare pictures of the same size"))
}

/// Returns the angle between two vectors in radians, or `None` if either is zero.
///
/// It is computed from the lengths of their difference and sum, which is exact for small angles too.
pub fn angle(a: &[f32], b: &[f32]) -> Option<f64> {
    let wide = |v: &[f32]| glam::DVec3::from_slice(&[f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]);
    let (a, b) = (wide(a).try_normalize()?, wide(b).try_normalize()?);
    Some(2.0 * (a - b).length().atan2((a + b).length()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb_byte;

    fn picture() -> Picture {
        let (width, height) = (48, 32);
        let mut color = Image::new(width, height, 3).unwrap();
        let mut depth = Image::new(width, height, 1).unwrap();
        let mut normal = Image::new(width, height, 3).unwrap();
        for y in 0..height {
            for x in 0..width {
                let value = 0.3 + 0.2 * (x as f32 * 0.4).sin() + 0.1 * (y as f32 * 0.7).cos();
                color.set_color(x, y, [value, 0.5 * value, 0.2]);
                normal.set_color(x, y, [0.6, 0.0, 0.8]);
                depth.data_mut()[(y * width + x) as usize] = 4.0;
            }
        }
        Picture { color, alpha: None, depth: Some(depth), normal: Some(normal) }
    }

    #[test]
    fn pictures_are_read_from_png_and_exr_and_other_files_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let picture = picture();
        crate::write_png(&path("a.png"), &picture.color).unwrap();
        let mut layer =
            crate::Layer { name: None, width: 48, height: 32, channels: Vec::new(), attributes: Vec::new() };
        layer.add(&COLOR, &picture.color);
        layer.add(&DEPTH, picture.depth.as_ref().unwrap());
        layer.add(&NORMAL, picture.normal.as_ref().unwrap());
        crate::write_exr(&path("a.exr"), &[layer], crate::Content::Color).unwrap();
        assert_eq!(Picture::read(&path("a.exr"), u64::MAX).unwrap(), picture);
        let png = Picture::read(&path("a.png"), u64::MAX).unwrap();
        let bytes = |image: &Image| image.data().iter().map(|value| srgb_byte(*value)).collect::<Vec<_>>();
        assert_eq!((bytes(&png.color), png.depth), (bytes(&picture.color), None));
        std::fs::write(path("a.txt"), "not a picture").unwrap();
        std::fs::write(path("empty.png"), "").unwrap();
        for name in ["a.txt", "empty.png", "none.exr"] {
            assert!(Picture::read(&path(name), u64::MAX).unwrap_err().to_string().contains(name));
        }
    }

    #[test]
    fn names_of_passes_and_opacity_say_what_is_covered() {
        let picture = picture();
        let mut depth = picture.depth.clone().unwrap();
        depth.data_mut()[..2].copy_from_slice(&[1e10, 3.0]);
        let mut alpha = Image::from_data(48, 32, 1, vec![1.0; 48 * 32]).unwrap();
        alpha.data_mut()[1] = 0.0;
        let layer = |name: &str, parts: &[&str], images: &[&Image]| {
            let mut layer =
                Layer { name: Some(name.into()), width: 48, height: 32, channels: Vec::new(), attributes: Vec::new() };
            let mut parts = parts.iter();
            for image in images {
                let names: Vec<String> =
                    parts.by_ref().take(image.channels() as usize).map(|part| format!("{name}.{part}")).collect();
                layer.add(&names.iter().map(String::as_str).collect::<Vec<_>>(), image);
            }
            layer
        };
        let layers = [
            layer("View.Combined", &["R", "G", "B", "A"], &[&picture.color, &alpha]),
            layer("View.Depth", &["Z"], &[&depth]),
            layer("View.Normal", &["X", "Y", "Z"], &[picture.normal.as_ref().unwrap()]),
        ];
        let read = Picture::of_layers(&layers).unwrap();
        assert_eq!((&read.color, &read.normal), (&picture.color, &picture.normal));
        let covered = read.covered().unwrap();
        assert!(!covered[0] && !covered[1] && covered[2..].iter().all(|covered| *covered));
        assert_eq!(Picture { depth: None, ..read }.covered().unwrap()[..2], [true, false]);
        let odd = [layers[0].clone(), Layer { width: 32, height: 48, ..layers[1].clone() }];
        assert!(Picture::of_layers(&odd).is_err());
    }
}
