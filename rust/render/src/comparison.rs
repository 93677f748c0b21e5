//! How far two pictures are apart: FLIP for what a viewer sees, and errors of depth and normals for what is there.
//!
//! FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images") compares display colours at a
//! viewing distance; it is computed by its authors' own code. 0 is no visible difference, 1 the largest.

use std::path::Path;

use relievo_core::{Error, Result};

use crate::color::srgb_byte;
use crate::exr_file::{COLOR, DEPTH, Layer, NORMAL, read_exr};
use crate::image::Image;
use crate::png_file::read_png;

/// Pixels per degree of sight for a 4K monitor 0.7 m wide seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

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

/// Errors over pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// FLIP errors, 0 to 1.
    pub flip: Spread,
    /// The FLIP error of every pixel, one channel.
    pub flip_map: Image,
    /// Root of the mean squared difference of display colours, 0 to 1, over pixels that are not empty in both.
    pub rms: f64,
    /// Structural similarity of luminance (Wang et al. 2004, Section III.B), 1 for equal pictures.
    pub ssim: f64,
    /// Differences of depth relative to the reference's, where both have one.
    pub depth: Option<Spread>,
    /// Angles between normals in radians, where both have one.
    pub normal: Option<Spread>,
    /// Pixels where only one of the pictures has a surface, if depths could be compared.
    pub uncovered: Option<u64>,
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
        let mut depth = find(&DEPTH, "Depth", &["Z"]).or_else(|| find(&DEPTH, "Depth", &["V"]));
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

    /// Which pixels show a surface: those that have a depth, or else are opaque for more than half; `None` if the picture
    /// does not say.
    pub fn covered(&self) -> Option<Vec<bool>> {
        let by_depth = self.depth.as_ref().map(|depth| depth.data().iter().map(|depth| depth.is_finite()).collect());
        let opaque = |alpha: &Image| alpha.data().iter().map(|alpha| *alpha > 0.5).collect();
        by_depth.or_else(|| self.alpha.as_ref().map(opaque))
    }
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

/// Fails unless both pictures have the same size, which is returned.
pub(crate) fn check_sizes(reference: &Picture, test: &Picture) -> Result<[u32; 2]> {
    let size = |picture: &Picture| [picture.color.width(), picture.color.height()];
    let ([width, height], [other_width, other_height]) = (size(reference), size(test));
    if size(reference) == size(test) {
        return Ok([width, height]);
    }
    Err(Error::invalid(format!("{width}×{height} against {other_width}×{other_height} pixels"))
        .advise("compare pictures of the same size"))
}

/// Compares a picture with a reference of the same size, seen with so many pixels per degree.
///
/// # Errors
/// The sizes differ, or `pixels_per_degree` is not in 1..=1000.
pub fn compare(reference: &Picture, test: &Picture, pixels_per_degree: f32) -> Result<Comparison> {
    let [width, height] = check_sizes(reference, test)?;
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        return Err(Error::invalid(format!("{pixels_per_degree} pixels per degree")).advise("use 1 to 1000"));
    }
    if u64::from(width) * u64::from(height) > 1 << 28 {
        return Err(Error::unsupported("pictures of more than 2^28 pixels are not compared"));
    }
    let bytes = |image: &Image| -> Vec<u8> { image.data().iter().map(|value| srgb_byte(*value)).collect() };
    let (a, b) = (bytes(&reference.color), bytes(&test.color));
    let display = |bytes: &[u8]| nv_flip::FlipImageRgb8::with_data(width, height, bytes);
    let errors = nv_flip::flip(display(&a), display(&b), pixels_per_degree).to_vec();
    let flip = spread(errors.iter().map(|error| f64::from(*error)));
    let (depth, uncovered) = match (&reference.depth, &test.depth) {
        (Some(a), Some(b)) => {
            let pairs = || a.data().iter().zip(b.data());
            let both = pairs().filter(|(a, b)| a.is_finite() && b.is_finite());
            let errors = both.map(|(a, b)| (f64::from(*b) - f64::from(*a)).abs() / f64::from(a.abs()).max(1e-30));
            let uncovered = pairs().filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            (Some(spread(errors)), Some(uncovered as u64))
        }
        _ => (None, None),
    };
    let normal = match (&reference.normal, &test.normal) {
        (Some(a), Some(b)) => {
            let pairs = a.data().chunks_exact(3).zip(b.data().chunks_exact(3));
            Some(spread(pairs.filter_map(|(a, b)| angle(a, b))))
        }
        _ => None,
    };
    let flip_map = Image::from_data(width, height, 1, errors)?;
    let ssim = ssim(&a, &b, width as usize, height as usize);
    let rms = rms(&a, &b, reference.covered().zip(test.covered()));
    Ok(Comparison { flip, flip_map, rms, ssim, depth, normal, uncovered })
}

impl Comparison {
    /// The peak signal-to-noise ratio of display colours, in decibels; infinite for equal pictures.
    pub fn psnr(&self) -> f64 {
        -20.0 * self.rms.log10()
    }

    /// The FLIP errors in colours from black over purple and orange to white.
    pub fn error_picture(&self) -> Result<Image> {
        let (width, height) = (self.flip_map.width(), self.flip_map.height());
        let errors = nv_flip::FlipImageFloat::with_data(width, height, self.flip_map.data());
        let bytes = errors.apply_color_lut(&nv_flip::magma_lut()).to_vec();
        let data = bytes.iter().map(|byte| crate::color::decode_srgb(f32::from(*byte) / 255.0)).collect();
        Image::from_data(width, height, 3, data)
    }
}

/// The root of the mean squared difference of bytes, as a share of their range; where both pictures say that nothing is,
/// pixels do not count.
fn rms(a: &[u8], b: &[u8], covered: Option<(Vec<bool>, Vec<bool>)>) -> f64 {
    let counts = |pixel: usize| covered.as_ref().is_none_or(|(a, b)| a[pixel] || b[pixel]);
    let (mut sum, mut count) = (0.0, 0u64);
    for (_, (a, b)) in a.iter().zip(b).enumerate().filter(|(at, _)| counts(at / 3)) {
        sum += ((f64::from(*a) - f64::from(*b)) / 255.0).powi(2);
        count += 1;
    }
    (sum / count.max(1) as f64).sqrt()
}

fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let (mut sum, mut max, mut count) = (0.0, 0.0f64, 0u64);
    for value in values {
        sum += value;
        max = max.max(value);
        count += 1;
    }
    Spread { mean: sum / count.max(1) as f64, max }
}

/// The angle between two vectors, from the lengths of their difference and sum, which is exact for small angles too;
/// `None` if either is zero.
pub(crate) fn angle(a: &[f32], b: &[f32]) -> Option<f64> {
    let wide = |v: &[f32]| glam::DVec3::from_slice(&[f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]);
    let (a, b) = (wide(a).try_normalize()?, wide(b).try_normalize()?);
    Some(2.0 * (a - b).length().atan2((a + b).length()))
}

/// Mean structural similarity of luma in windows of eleven pixels with a Gaussian weight of deviation 1.5, which are
/// cut off at the border of the picture.
fn ssim(a: &[u8], b: &[u8], width: usize, height: usize) -> f64 {
    const RADIUS: usize = 5;
    const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
    const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);
    let luma = |bytes: &[u8]| -> Vec<f64> {
        let of = |p: &[u8]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
        bytes.chunks_exact(3).map(of).collect()
    };
    let (a, b) = (luma(a), luma(b));
    let kernel: [f64; 2 * RADIUS + 1] = std::array::from_fn(|at| {
        let distance = at as f64 - RADIUS as f64;
        (-distance * distance / (2.0 * 1.5 * 1.5)).exp()
    });
    let blur = |values: &[f64]| -> Vec<f64> {
        let pass = |values: &[f64], step: usize, place: &dyn Fn(usize) -> usize, length: usize| -> Vec<f64> {
            let at_one = |at: usize| {
                let here = place(at);
                let (low, high) = (here.saturating_sub(RADIUS), (here + RADIUS).min(length - 1));
                let (mut sum, mut weights) = (0.0, 0.0);
                for other in low..=high {
                    let weight = kernel[other + RADIUS - here];
                    sum += weight * values[at + other * step - here * step];
                    weights += weight;
                }
                sum / weights
            };
            (0..values.len()).map(at_one).collect()
        };
        pass(&pass(values, 1, &|at| at % width, width), width, &|at| at / width, height)
    };
    let product = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let (mean_a, mean_b) = (blur(&a), blur(&b));
    let (aa, bb, ab) = (blur(&product(&a, &a)), blur(&product(&b, &b)), blur(&product(&a, &b)));
    let total: f64 = (0..a.len())
        .map(|at| {
            let (ma, mb) = (mean_a[at], mean_b[at]);
            let (va, vb, cov) = (aa[at] - ma * ma, bb[at] - mb * mb, ab[at] - ma * mb);
            (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
        })
        .sum();
    total / a.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(change: impl Fn(u32, u32) -> f32) -> Picture {
        let (width, height) = (48, 32);
        let mut color = Image::new(width, height, 3).unwrap();
        let mut depth = Image::new(width, height, 1).unwrap();
        let mut normal = Image::new(width, height, 3).unwrap();
        for y in 0..height {
            for x in 0..width {
                let value = 0.3 + 0.2 * (x as f32 * 0.4).sin() + 0.1 * (y as f32 * 0.7).cos() + change(x, y);
                color.set_color(x, y, [value, 0.5 * value, 0.2]);
                let tilt = 0.25 + change(x, y);
                normal.set_color(x, y, [tilt.sin(), 0.0, tilt.cos()]);
                depth.data_mut()[(y * width + x) as usize] = 4.0 * (1.0 + change(x, y));
            }
        }
        Picture { color, alpha: None, depth: Some(depth), normal: Some(normal) }
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let picture = picture(|_, _| 0.0);
        let found = compare(&picture, &picture, PIXELS_PER_DEGREE).unwrap();
        let none = Spread::default();
        assert_eq!((found.flip, found.depth, found.normal), (none, Some(none), Some(none)));
        assert_eq!(found.uncovered, Some(0));
        assert!((found.ssim - 1.0).abs() < 1e-12 && found.rms == 0.0 && found.psnr() == f64::INFINITY);
        assert!(found.flip_map.data().iter().all(|error| *error == 0.0));
    }

    #[test]
    fn errors_are_those_that_were_made() {
        let reference = picture(|_, _| 0.0);
        let mut test = picture(|x, y| if (x, y) == (5, 6) { 0.1 } else { 0.0 });
        test.depth.as_mut().unwrap().data_mut()[0] = f32::INFINITY;
        let found = compare(&reference, &test, PIXELS_PER_DEGREE).unwrap();
        let (depth, normal) = (found.depth.unwrap(), found.normal.unwrap());
        assert!((depth.max - 0.1).abs() < 1e-6 && (depth.mean - 0.1 / (48.0 * 32.0 - 1.0)).abs() < 1e-6);
        assert!((normal.max - 0.1).abs() < 1e-6, "{normal:?}");
        assert_eq!(found.uncovered, Some(1));
        assert!(found.flip.max > 0.05 && found.flip.mean > 0.0 && found.flip.mean < 0.05, "{:?}", found.flip);
        let peak = found.flip_map.data().iter().position(|error| f64::from(*error) == found.flip.max).unwrap();
        let (x, y) = (peak % 48, peak / 48);
        assert!(x.abs_diff(5) < 3 && y.abs_diff(6) < 3, "the largest error is near the pixel that changed");
        assert!(found.ssim < 1.0 && found.ssim > 0.9);
        assert_eq!(found.error_picture().unwrap().channels(), 3);
    }

    #[test]
    fn larger_changes_are_seen_as_larger() {
        let reference = picture(|_, _| 0.0);
        let errors = [0.01f32, 0.05, 0.2].map(|size| {
            let noise = move |x: u32, y: u32| if (x * 7 + y * 13) % 5 < 2 { size } else { -size };
            let found = compare(&reference, &picture(noise), PIXELS_PER_DEGREE).unwrap();
            (found.flip.mean, 1.0 - found.ssim)
        });
        assert!(errors.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1), "{errors:?}");
    }

    #[test]
    fn pictures_are_read_from_png_and_exr_and_other_files_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let picture = picture(|_, _| 0.0);
        crate::write_png(&path("a.png"), &picture.color).unwrap();
        let mut layer =
            crate::Layer { name: None, width: 48, height: 32, channels: Vec::new(), attributes: Vec::new() };
        layer.add(&COLOR, &picture.color);
        layer.add(&DEPTH, picture.depth.as_ref().unwrap());
        layer.add(&NORMAL, picture.normal.as_ref().unwrap());
        crate::write_exr(&path("a.exr"), &[layer], crate::Content::Color).unwrap();
        assert_eq!(Picture::read(&path("a.exr"), u64::MAX).unwrap(), picture);
        let png = Picture::read(&path("a.png"), u64::MAX).unwrap();
        let found = compare(&picture, &png, PIXELS_PER_DEGREE).unwrap();
        assert_eq!((found.flip.max, found.depth), (0.0, None));
        std::fs::write(path("a.txt"), "not a picture").unwrap();
        std::fs::write(path("empty.png"), "").unwrap();
        for name in ["a.txt", "empty.png", "none.exr"] {
            assert!(Picture::read(&path(name), u64::MAX).unwrap_err().to_string().contains(name));
        }
    }

    #[test]
    fn names_of_passes_and_opacity_say_what_is_covered() {
        let picture = picture(|_, _| 0.0);
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

    #[test]
    fn the_root_of_squares_is_over_what_is_covered() {
        let (a, b) = ([0, 0, 0, 255, 255, 255], [51, 51, 51, 255, 255, 255]);
        assert!((rms(&a, &b, None) - 0.2 / 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((rms(&a, &b, Some((vec![true, false], vec![false; 2]))) - 0.2).abs() < 1e-12);
        assert_eq!(rms(&a, &b, Some((vec![false; 2], vec![false; 2]))), 0.0);
    }

    #[test]
    fn sizes_and_distances_that_cannot_be_used_are_refused() {
        let picture = picture(|_, _| 0.0);
        let small = Picture { color: Image::new(4, 4, 3).unwrap(), alpha: None, depth: None, normal: None };
        assert!(compare(&picture, &small, PIXELS_PER_DEGREE).unwrap_err().to_string().contains("4×4"));
        assert!(compare(&small, &small, f32::NAN).is_err());
        assert_eq!(compare(&small, &small, 67.0).unwrap().flip.max, 0.0);
        let dot = Picture { color: Image::new(1, 1, 3).unwrap(), alpha: None, depth: None, normal: None };
        assert_eq!(compare(&dot, &dot, 67.0).unwrap().flip.max, 0.0);
    }
}
