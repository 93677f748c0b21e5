//! The image of a sticker, filtered without colours from beyond the outline.
//!
//! Pixels outside of the outline have no weight, so that the pixels inside alone make the colour at the outline. Smaller
//! copies of the image, each of half the pixels, serve where many pixels fall on one texel (Williams 1983).

pub(crate) mod contour;
pub(crate) mod outline;

use relievo_core::{Error, Result};
use relievo_render::Image;

use crate::decal::Sticker;
use crate::map::energy::Vec2;

/// The most bytes of an image with its smaller copies.
const MAX: u64 = 4 << 30;

/// Colours of pixels, premultiplied by alpha, with the share of the pixel that lies within the outline.
#[derive(Clone, Debug)]
struct Level {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 5]>,
}

/// The image of a sticker: scene-linear Rec.709 with alpha.
#[derive(Clone, Debug)]
pub struct Artwork {
    sticker: Sticker,
    levels: Vec<Level>,
}

impl Artwork {
    /// Makes the artwork of a sticker from its image, of 1 to 4 channels. The alpha of an image without one is 1.
    ///
    /// # Errors
    /// The image has other pixels than the sticker, a number that is not finite, or would take more than 4 GiB.
    pub fn new(sticker: &Sticker, image: &Image) -> Result<Self> {
        let size = [image.width(), image.height()];
        if size.map(f64::from) != sticker.size {
            let [width, height] = sticker.size;
            return Err(Error::invalid(format!(
                "it has {} x {} pixels, the sticker {width} x {height}",
                size[0], size[1]
            ))
            .at("image")
            .advise("give the image that the sticker was cut out of"));
        }
        if u64::from(size[0]) * u64::from(size[1]) * (size_of::<[f32; 5]>() as u64) * 4 / 3 > MAX {
            return Err(Error::memory("it takes more than 4 GiB with its filtered copies")
                .at("image")
                .advise("make the image smaller"));
        }
        if image.data().iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid("a pixel is not finite").at("image").advise("replace the pixel by a number"));
        }
        let (width, height) = (size[0] as usize, size[1] as usize);
        let mut pixels = Vec::with_capacity(width * height);
        for row in 0..size[1] {
            // Rows of an image run downwards, those of the plane upwards.
            let y = size[1] - 1 - row;
            for x in 0..size[0] {
                let center = sticker.place([f64::from(x) + 0.5, f64::from(row) + 0.5]);
                if !sticker.outline.contains(center) {
                    pixels.push([0.0; 5]);
                    continue;
                }
                let [red, green, blue] = image.color(x, y);
                let alpha = match *image.pixel(x, y) {
                    [_, _, _, alpha] | [_, alpha] => alpha.clamp(0.0, 1.0),
                    _ => 1.0,
                };
                pixels.push([red * alpha, green * alpha, blue * alpha, alpha, 1.0]);
            }
        }
        let mut levels = vec![Level { width, height, pixels }];
        while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
            levels.push(last.halved());
        }
        Ok(Self { sticker: sticker.clone(), levels })
    }

    /// Returns the sticker.
    pub fn sticker(&self) -> &Sticker {
        &self.sticker
    }

    /// Returns colour and alpha, premultiplied, at a place of the image, 0 to 1 from left to right and from bottom to top,
    /// as the mean over about `footprint` pixels in each direction. Transparent outside of the outline.
    pub fn color(&self, uv: Vec2, footprint: f64) -> [f32; 4] {
        if !self.sticker.covers(uv) {
            return [0.0; 4];
        }
        let level = footprint.max(1.0).log2().round() as usize;
        self.levels[level.min(self.levels.len() - 1)].color(uv)
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let columns = [2 * x, (2 * x + 1).min(self.width - 1)];
                let rows = [2 * y, (2 * y + 1).min(self.height - 1)];
                let mut sum = [0.0; 5];
                for pixel in rows.into_iter().flat_map(|row| columns.map(|column| row * self.width + column)) {
                    for (sum, value) in sum.iter_mut().zip(self.pixels[pixel]) {
                        *sum += 0.25 * value;
                    }
                }
                pixels.push(sum);
            }
        }
        Self { width, height, pixels }
    }

    /// The colour between the four nearest pixels, of those with a weight.
    fn color(&self, [u, v]: Vec2) -> [f32; 4] {
        let cell = |share: f64, count: usize| {
            let at = (share * count as f64 - 0.5).clamp(0.0, count as f64 - 1.0);
            let first = at.floor() as usize;
            (first, (first + 1).min(count - 1), (at - at.floor()) as f32)
        };
        let ((left, right, s), (below, above, t)) = (cell(u, self.width), cell(v, self.height));
        let corners = [
            (below, left, (1.0 - s) * (1.0 - t)),
            (below, right, s * (1.0 - t)),
            (above, left, (1.0 - s) * t),
            (above, right, s * t),
        ];
        let mut sum = [0.0_f32; 5];
        for (row, column, share) in corners {
            for (sum, value) in sum.iter_mut().zip(self.pixels[row * self.width + column]) {
                *sum += share * value;
            }
        }
        let [red, green, blue, alpha, weight] = sum;
        if weight > 0.0 { [red, green, blue, alpha].map(|value| value / weight) } else { [0.0; 4] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_from_beyond_the_outline_do_not_bleed_in() {
        // The left half is red, the right half, beyond the outline, green.
        let mut image = Image::new(64, 64, 3).expect("an image");
        for y in 0..64 {
            for x in 0..64 {
                image.set_color(x, y, if x < 32 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
            }
        }
        let sticker = Sticker::new([64, 64], vec![[0.0, 0.0], [32.0, 0.0], [32.0, 64.0], [0.0, 64.0]]).expect("simple");
        let artwork = Artwork::new(&sticker, &image).expect("artwork");
        for footprint in [1.0, 4.0, 64.0] {
            assert_eq!(artwork.color([0.499, 0.5], footprint), [1.0, 0.0, 0.0, 1.0]);
            assert_eq!(artwork.color([0.501, 0.5], footprint), [0.0; 4]);
        }
    }
}
