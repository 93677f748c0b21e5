//! Images of brushes of a scene, read from PNG and EXR files or made from a pattern.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_detail::{Stamp, StampImage};
use relievo_render::color::encode_srgb;
use relievo_render::{Image, read_image};

use crate::format::description::{StampEntry, StampSource};
use crate::state::paths::Paths;

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
                let checksum = crate::state::checksum::checksum(&path)?;
                let limit = context.memory_limit();
                let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
                let image = read_image(&path, limit)?;
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

/// A pattern: white, with alpha where it is, or vectors.
fn make_pattern(pattern: &str) -> Result<Arc<StampImage>> {
    if let Some(shape) = shape_of(pattern) {
        return make_vectors(shape);
    }
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
        "rings" => r < 1.0 && ((4.0 * r) as u32).is_multiple_of(2),
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

/// Where a shape of vectors puts the places of the unit disc around the middle: from the radius and the direction.
type Shape = fn(f32, [f32; 2]) -> [f32; 3];

fn shape_of(pattern: &str) -> Option<Shape> {
    match pattern {
        "mushroom" => Some(mushroom),
        "horn" => Some(horn),
        _ => None,
    }
}

/// An image of the way from each place to where the shape puts it, in radii: as [`StampSettings`] take numbers by
/// default, a half is none and one is one radius.
fn make_vectors(shape: Shape) -> Result<Arc<StampImage>> {
    let mut data = Vec::with_capacity((3 * SIZE * SIZE) as usize);
    let at = |pixel: u32| (pixel as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
    for k in 0..SIZE * SIZE {
        let (x, y) = (at(k % SIZE), -at(k / SIZE));
        let r = x.hypot(y);
        let to = if r < 1.0 { shape(r, [x / r, y / r]) } else { [x, y, 0.0] };
        data.extend([to[0] - x, to[1] - y, to[2]].map(|way| 0.5 + 0.5 * way));
    }
    StampImage::new(SIZE, SIZE, 3, &data)
}

/// A stalk with a cap over it: round, by its outline from the rim to the top.
fn mushroom(r: f32, [x, y]: [f32; 2]) -> [f32; 3] {
    const OUTLINE: [[f32; 2]; 12] = [
        [1.0, 0.0],
        [0.75, 0.0],
        [0.42, 0.03],
        [0.27, 0.16],
        [0.23, 0.42],
        [0.23, 0.68],
        [0.3, 0.78],
        [0.58, 0.72],
        [0.74, 0.76],
        [0.68, 0.97],
        [0.4, 1.16],
        [0.0, 1.22],
    ];
    let [wide, high] = outline(&OUTLINE, r);
    [wide * x, wide * y, high]
}

/// A horn that bends over to the right: round across a spine that is an arc of a circle.
fn horn(r: f32, [x, y]: [f32; 2]) -> [f32; 3] {
    /// Radius, and how far along the spine.
    const OUTLINE: [[f32; 2]; 9] = [
        [1.0, 0.0],
        [0.7, 0.0],
        [0.42, 0.1],
        [0.33, 0.35],
        [0.29, 0.75],
        [0.23, 1.15],
        [0.16, 1.5],
        [0.08, 1.78],
        [0.0, 1.85],
    ];
    /// How much it bends, radians a radius.
    const BEND: f32 = 1.3;
    let [wide, along] = outline(&OUTLINE, r);
    let (sine, cosine) = (BEND * along).sin_cos();
    [(1.0 - cosine) / BEND + wide * x * cosine, wide * y, sine / BEND - wide * x * sine]
}

/// A point of an outline at a radius from 1, its first point, to 0, its last, which is on the axis. Radii are even
/// along the outline's length; between its points it is a cubic (Catmull and Rom 1974).
fn outline(points: &[[f32; 2]], r: f32) -> [f32; 2] {
    let length = |pair: &[[f32; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let total: f32 = points.windows(2).map(length).sum();
    let mut left = (1.0 - r) * total;
    for (at, pair) in points.windows(2).enumerate() {
        let own = length(pair);
        if left > own && at + 2 < points.len() {
            left -= own;
            continue;
        }
        let [b, c] = [pair[0], pair[1]];
        // Before the rim it goes straight on, behind the axis it is its mirror image.
        let a = at.checked_sub(1).map_or([2.0 * b[0] - c[0], b[1]], |before| points[before]);
        let d = points.get(at + 2).copied().unwrap_or([-b[0], b[1]]);
        let t = (left / own).clamp(0.0, 1.0);
        return [0, 1].map(|axis| {
            let (a, b, c, d) = (a[axis], b[axis], c[axis], d[axis]);
            let (quadratic, cubic) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * b - a - 3.0 * c + d);
            b + 0.5 * t * (c - a + t * (quadratic + t * cubic))
        });
    }
    [0.0; 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::schema::PATTERNS;
    use relievo_detail::{StampChannel, StampSettings};

    #[test]
    fn every_pattern_covers_a_part_of_its_box() {
        for pattern in PATTERNS.into_iter().filter(|pattern| shape_of(pattern).is_none()) {
            let stamp =
                Stamp::new(make_pattern(pattern).unwrap(), StampSettings::default(), StampChannel::Red).unwrap();
            let mean = stamp.sample([0.0, 0.0], 2.0)[3];
            assert!((0.15..0.6).contains(&mean), "{pattern}: {mean}");
        }
        let at = |x: f32, y: f32| is_in("star", x, y);
        assert!(at(0.0, 0.0) && at(0.0, 0.9) && !at(0.0, -0.6) && at(0.85, 0.28) && !at(0.5, 0.6));
    }

    #[test]
    fn shapes_go_on_from_the_surface_and_hang_over() {
        for pattern in ["mushroom", "horn"] {
            let shape = shape_of(pattern).unwrap();
            let along = |k: usize| shape(1.0 - (k as f32 + 0.5) / 400.0, [1.0, 0.0]);
            let first = along(0);
            assert!((first[0] - 1.0).abs() < 0.02 && first[2].abs() < 0.01, "{pattern} {first:?}");
            let mut hangs = false;
            for k in 1..400 {
                let (a, b) = (along(k - 1), along(k));
                let step = (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f32>().sqrt();
                // Even along the outline, so that no part of it gets few texels.
                assert!(step < 0.02, "{pattern} {k} {step}");
                hangs |= b[0] > a[0] + 1e-4 && b[2] > 0.5;
            }
            assert!(hangs, "{pattern}");
            let top = [0.0, 1.0, 2.0].map(|turn: f32| shape(1e-4, [turn.cos(), turn.sin()]));
            assert!(top.iter().all(|p| (0..3).all(|axis| (p[axis] - top[0][axis]).abs() < 1e-2)));
        }
        let image = make_pattern("mushroom").unwrap();
        let stamp = Stamp::new(image, StampSettings::default(), StampChannel::Blue).unwrap();
        let [r, g, b, alpha] = stamp.sample([0.0, 0.0], 0.0);
        assert!((r - 0.5).abs() < 0.02 && (g - 0.5).abs() < 0.02 && (b - 1.11).abs() < 0.02 && alpha == 1.0);
    }
}
