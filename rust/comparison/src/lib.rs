//! Compares two pictures: FLIP and structural similarity for what a viewer sees, and errors of depth and normals.
//!
//! FLIP (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images") compares display colours at a
//! viewing distance; it is computed by its authors' own code. 0 is no visible difference, 1 the largest.
//!
//! That code brings stb_image, miniz and TinyEXR. It is in a crate of its own so that the C library does not link them.

use relievo_core::{Error, Result};
use relievo_render::color::{decode_srgb, srgb_byte};
use relievo_render::{Image, Picture, angle, check_sizes};

/// Pixels per degree of sight for a 4K monitor 0.7 m wide seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

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
    ///
    /// # Errors
    /// Fails with `Invalid`, as [`Image::from_data`] does, only if the colours are not as many as the pixels.
    pub fn error_picture(&self) -> Result<Image> {
        let (width, height) = (self.flip_map.width(), self.flip_map.height());
        let errors = nv_flip::FlipImageFloat::with_data(width, height, self.flip_map.data());
        let bytes = errors.apply_color_lut(&nv_flip::magma_lut()).to_vec();
        let data = bytes.iter().map(|byte| decode_srgb(f32::from(*byte) / 255.0)).collect();
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
