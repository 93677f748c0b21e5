//! An image as the function of a brush: paint, or a height.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3: the
//! brush function can be a texture of colours or a displacement map. The image lies across the box, its right along the
//! first axis and its top along the second. It is filtered by how far the places of the surface are apart in it:
//! between the two reductions (Williams 1983, Pyramidal Parametrics) whose texels are as large, so that nothing is
//! aliased. Colours are linear Rec.709 with alpha; other channels are numbers as they are.

use std::sync::Arc;

use relievo_core::parameter::Switch;
use relievo_core::{Error, Result};

use crate::channels::knots::PerKnot;
use crate::paint::mode::Colors;
use crate::paint::weights::Weights;

relievo_core::parameters! {
    /// How an image lies in the brush's box, and what its numbers mean as heights.
    pub struct StampSettings {
        /// By how much the image is turned, from the first axis of the box to the second.
        angle: f32 = 0.0, -1000.0..=1000.0, "rad";
        /// How often the image is repeated across the box; once leaves what is beside it as it is.
        repeat: f32 = 1.0, 1.0..=1000.0, "";
        /// Whether the image is mirrored, left to right.
        mirror: Switch = Switch::OFF, 0..=1, "";
        /// Whether every other repeat is mirrored, so that repeats meet without a seam.
        alternate: Switch = Switch::OFF, 0..=1, "";
        /// The number that means no height.
        mid: f32 = 0.5, -60000.0..=60000.0, "";
        /// How many heights one more than that is.
        scale: f32 = 2.0, -60000.0..=60000.0, "";
    }
}

/// Which number of a pixel is the height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum StampChannel {
    /// The first, red or grey.
    #[default]
    Red = 0,
    /// The second.
    Green = 1,
    /// The third.
    Blue = 2,
    /// The fourth; it is then not how much of the edit the place gets.
    Alpha = 3,
}

impl StampChannel {
    /// All channels and their names in scene files.
    pub const NAMES: [(StampChannel, &'static str); 4] = [
        (StampChannel::Red, "red"),
        (StampChannel::Green, "green"),
        (StampChannel::Blue, "blue"),
        (StampChannel::Alpha, "alpha"),
    ];
}

/// Most pixels along a side.
const MAX_SIDE: u32 = 16384;
/// Most pixels.
const MAX_PIXELS: u64 = 1 << 26;

/// An image and its reductions by two, colours multiplied by alpha.
#[derive(Debug, PartialEq)]
pub struct StampImage {
    levels: Vec<Reduction>,
}

#[derive(Debug, PartialEq)]
struct Reduction {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 4]>,
}

impl StampImage {
    /// An image of `width` × `height` pixels, row by row from the top, of `channels` numbers each: 1 is grey, 2 grey
    /// and alpha, 3 red, green and blue, 4 those and alpha.
    ///
    /// # Errors
    /// Fails as [`Self::check_size`], and with `Invalid` if `data` is not as long as the size says, a number is not
    /// finite or beyond a million, or an alpha is not within 0 to 1.
    pub fn new(width: u32, height: u32, channels: u32, data: &[f32]) -> Result<Arc<Self>> {
        let fault = |what: String, remedy: &str| Err(Error::invalid(what).at("stamp").advise(remedy));
        Self::check_size(width, height, channels)?;
        let count = u64::from(width) * u64::from(height);
        if data.len() as u64 != count * u64::from(channels) {
            return fault(
                format!("{} numbers are not {channels} for each of {count} pixels", data.len()),
                "give 1 to 4 numbers for each pixel",
            );
        }
        if let Some(at) = data.iter().position(|value| !value.is_finite() || value.abs() > 1e6) {
            let pixel = at as u64 / u64::from(channels);
            let (x, y) = (pixel % u64::from(width), pixel / u64::from(width));
            return fault(
                format!("pixel ({x}, {y}) has the number {}", data[at]),
                "replace what is not a number, infinite or above a million",
            );
        }
        let pixels = data.chunks_exact(channels as usize).map(|pixel| match *pixel {
            [grey] => [grey, grey, grey, 1.0],
            [grey, alpha] => [grey, grey, grey, alpha],
            [r, g, b] => [r, g, b, 1.0],
            [r, g, b, alpha, ..] => [r, g, b, alpha],
            [] => [0.0; 4],
        });
        let pixels: Vec<[f32; 4]> = pixels.collect();
        if let Some(at) = pixels.iter().position(|pixel| !(0.0..=1.0).contains(&pixel[3])) {
            let (x, y) = (at as u64 % u64::from(width), at as u64 / u64::from(width));
            return fault(format!("pixel ({x}, {y}) has the alpha {}", pixels[at][3]), "use 0 to 1");
        }
        Ok(Self::reduced(width, height, pixels.into_iter().map(|[r, g, b, a]| [r * a, g * a, b * a, a]).collect()))
    }

    /// An image of pixels as [`Self::pixels`] gives them.
    ///
    /// # Errors
    /// Fails as [`Self::new`].
    pub fn of_pixels([width, height]: [u32; 2], pixels: Vec<[f32; 4]>) -> Result<Arc<Self>> {
        Self::check_size(width, height, 4)?;
        let is_sound =
            |pixel: &[f32; 4]| pixel.iter().all(|value| value.abs() <= 1e6) && (0.0..=1.0).contains(&pixel[3]);
        if pixels.len() as u64 != u64::from(width) * u64::from(height) || !pixels.iter().all(is_sound) {
            return Err(Error::invalid("its image is damaged").at("stamp"));
        }
        Ok(Self::reduced(width, height, pixels))
    }

    /// Pixels along the sides, and the pixels row by row from the top: colours multiplied by alpha, and alpha.
    pub fn pixels(&self) -> ([u32; 2], &[[f32; 4]]) {
        (self.size(), &self.levels[0].pixels)
    }

    fn reduced(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Arc<Self> {
        let mut levels = vec![Reduction { width: width as usize, height: height as usize, pixels }];
        while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
            levels.push(last.halved());
        }
        Arc::new(Self { levels })
    }

    /// Checks that an image may have `width` × `height` pixels of `channels` numbers each.
    ///
    /// # Errors
    /// Fails with `Invalid` if a side is not 1 to 16384 pixels, there are over 2²⁶ pixels, or a pixel does not have 1
    /// to 4 numbers.
    pub fn check_size(width: u32, height: u32, channels: u32) -> Result<()> {
        let fault = |what: String, remedy: &str| Err(Error::invalid(what).at("stamp").advise(remedy));
        let count = u64::from(width) * u64::from(height);
        if count == 0 || width.max(height) > MAX_SIDE || count > MAX_PIXELS {
            return fault(
                format!("its image is {width} × {height} pixels"),
                "use 1 to 16384 pixels a side and at most 67108864 in all",
            );
        }
        if !(1..=4).contains(&channels) {
            return fault(format!("its pixels have {channels} numbers"), "give 1 to 4 numbers for each pixel");
        }
        Ok(())
    }

    /// Pixels along the sides.
    pub fn size(&self) -> [u32; 2] {
        self.levels.first().map_or([0; 2], |level| [level.width as u32, level.height as u32])
    }
}

impl Reduction {
    /// Half as large, rounded up: the mean over the area of each pixel.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let (columns, rows) = (spans(self.width, width), spans(self.height, height));
        let mut pixels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0; 4];
                for (y, down) in row {
                    for (x, across) in column {
                        let pixel = self.pixels[y * self.width + x];
                        (0..4).for_each(|channel| sum[channel] += down * across * pixel[channel]);
                    }
                }
                pixels.push(sum);
            }
        }
        Self { width, height, pixels }
    }

    /// Bilinear at a place whose unit is a pixel; `address` says which pixel a whole number means, if one, and whether
    /// it is mirrored. In a mirrored pixel of `vectors` the first number counts the other way across, the second down.
    fn sample(
        &self,
        x: f32,
        y: f32,
        address: impl Fn(i32, usize) -> Option<(usize, bool)>,
        vectors: Option<f32>,
    ) -> [f32; 4] {
        let (x, y) = (x - 0.5, y - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let (s, t) = (x - i, y - j);
        let mut sum = [0.0; 4];
        for (dj, down) in [(0, 1.0 - t), (1, t)] {
            for (di, across) in [(0, 1.0 - s), (1, s)] {
                let place = address(i as i32 + di, self.width).zip(address(j as i32 + dj, self.height));
                let Some(((i, mirrored), (j, upturned))) = place else { continue };
                let Some(mut pixel) = self.pixels.get(j * self.width + i).copied() else { continue };
                if let Some(mid) = vectors {
                    for (channel, turned) in [mirrored, upturned].into_iter().enumerate() {
                        if turned {
                            pixel[channel] = 2.0 * mid * pixel[3] - pixel[channel];
                        }
                    }
                }
                (0..4).for_each(|channel| sum[channel] += down * across * pixel[channel]);
            }
        }
        sum
    }
}

/// The pixels of `old` that each of `new` covers, and the share of each.
fn spans(old: usize, new: usize) -> Vec<Vec<(usize, f32)>> {
    let scale = old as f64 / new as f64;
    let covered = |at: usize| {
        let (low, high) = (at as f64 * scale, (at + 1) as f64 * scale);
        let pixels = low as usize..(high.ceil() as usize).min(old);
        pixels.map(|k| (k, ((high.min((k + 1) as f64) - low.max(k as f64)) / scale) as f32)).collect()
    };
    (0..new).map(covered).collect()
}

/// An image with its place in the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamp {
    image: Arc<StampImage>,
    settings: StampSettings,
    channel: StampChannel,
    /// Whether it is seen from the other side of the box's first axis, as the mirror image of a stroke has it.
    turned_over: bool,
}

impl Stamp {
    /// A stamp of an image.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting is out of its range.
    pub fn new(image: Arc<StampImage>, settings: StampSettings, channel: StampChannel) -> Result<Self> {
        settings.check().map_err(|error| error.at("stamp"))?;
        Ok(Self { image, settings, channel, turned_over: false })
    }

    /// The image.
    pub fn image(&self) -> &Arc<StampImage> {
        &self.image
    }

    /// How it lies, and what its numbers mean.
    pub fn settings(&self) -> &StampSettings {
        &self.settings
    }

    /// Which number of a pixel is the height.
    pub fn channel(&self) -> StampChannel {
        self.channel
    }

    /// The same with the second axis of the box the other way.
    pub(crate) fn turned_over(&self) -> Self {
        Self { turned_over: !self.turned_over, ..self.clone() }
    }

    /// Whether the other is the same image, in the same place but for the side that it is seen from.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.image, &other.image) && self.settings == other.settings && self.channel == other.channel
    }

    /// Whether it is seen from the other side of the box's first axis.
    pub(crate) fn is_turned_over(&self) -> bool {
        self.turned_over
    }

    /// As `brush_stamp.wgsl` has it, but for the side that it is seen from.
    pub(crate) fn packed(&self) -> Vec<[f32; 4]> {
        let StampSettings { angle, repeat, mirror, alternate, mid, scale } = self.settings;
        let (sine, cosine) = angle.sin_cos();
        let bits = u8::from(mirror.is_on()) | u8::from(alternate.is_on()) << 1;
        let levels = &self.image.levels;
        let mut packed = vec![[cosine, sine, repeat, f32::from(bits)]];
        packed.push([mid, scale, self.channel as u32 as f32, levels.len() as f32]);
        let mut first = packed.len() + levels.len();
        for level in levels {
            packed.push([first as f32, level.width as f32, level.height as f32, 0.0]);
            first += level.pixels.len();
        }
        levels.iter().for_each(|level| packed.extend(&level.pixels));
        packed
    }

    /// Pixels of the image and its reductions.
    pub(crate) fn pixels(&self) -> usize {
        self.image.levels.iter().map(|level| level.pixels.len()).sum()
    }

    /// The filtered pixel at a place of the brush, whose neighbours are `footprint` away there: red, green, blue, not
    /// multiplied by alpha, and alpha.
    pub fn sample(&self, place: [f32; 2], footprint: f32) -> [f32; 4] {
        self.look(place, footprint, None)
    }

    /// As [`Self::sample`]; of vectors `mid` is the number that means none.
    fn look(&self, [x, y]: [f32; 2], footprint: f32, mid: Option<f32>) -> [f32; 4] {
        let StampSettings { angle, repeat, mirror, alternate, .. } = self.settings;
        let y = if self.turned_over { -y } else { y };
        let (sine, cosine) = angle.sin_cos();
        let (right, up) = (cosine * x + sine * y, cosine * y - sine * x);
        let right = if mirror.is_on() { -right } else { right };
        let [s, t] = [0.5 + 0.5 * right * repeat, 0.5 - 0.5 * up * repeat];
        let once = repeat <= 1.0;
        let address = |k: i32, size: usize| {
            let n = size as i32;
            let (turn, at) = (k.div_euclid(n), k.rem_euclid(n));
            let mirrored = alternate.is_on() && turn % 2 != 0;
            (!once || turn == 0).then_some(((if mirrored { n - 1 - at } else { at }) as usize, mirrored))
        };
        let [width, height] = self.image.size();
        let spread = 0.5 * footprint * repeat * width.max(height) as f32;
        let last = self.image.levels.len() - 1;
        let reduction = spread.max(1.0).log2().min(last as f32);
        let (low, between) = (reduction as usize, reduction.fract());
        let look = |level: usize| {
            let level = &self.image.levels[level.min(last)];
            level.sample(s * level.width as f32, t * level.height as f32, address, mid)
        };
        let mut pixel = look(low);
        if between > 0.0 {
            let far = look(low + 1);
            (0..4).for_each(|channel| pixel[channel] += between * (far[channel] - pixel[channel]));
        }
        let [r, g, b, alpha] = pixel;
        if alpha > 0.0 { [r / alpha, g / alpha, b / alpha, alpha] } else { [0.0; 4] }
    }

    /// Multiplies the brush's colours by those of the image, and the shares by its alpha.
    pub fn paint(&self, footprint: &PerKnot, weights: &mut Weights, brush: &mut Colors) {
        self.each(footprint, weights, |k, [r, g, b, alpha], share| {
            for (channel, value) in [r, g, b].into_iter().enumerate() {
                brush[channel][k] *= value;
            }
            *share *= alpha;
        });
    }

    /// Multiplies the heights by the image's, and the shares by its alpha. If the mode has no height, `masks`, the
    /// shares are multiplied by the image's height from 0 to 1 instead.
    pub fn sculpt(&self, footprint: &PerKnot, weights: &mut Weights, height: &mut PerKnot, masks: bool) {
        let StampSettings { mid, scale, .. } = self.settings;
        self.each(footprint, weights, |k, pixel, share| {
            let value = scale * (pixel[self.channel as usize] - mid);
            *share *= if self.channel == StampChannel::Alpha { 1.0 } else { pixel[3] };
            if masks {
                *share *= value.clamp(0.0, 1.0);
            } else {
                height[k] *= value;
            }
        });
    }

    /// Makes vectors along the axes of the box of the image's: red along its right, green along its top, blue out of
    /// it, times `vectors`' third number. Multiplies the shares by its alpha.
    pub(crate) fn bend(&self, footprint: &PerKnot, weights: &mut Weights, vectors: &mut [PerKnot; 3]) {
        let StampSettings { angle, mirror, mid, scale, .. } = self.settings;
        let (sine, cosine) = angle.sin_cos();
        let Weights { share, across: [x, y], .. } = weights;
        for (k, share) in share.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
            let [r, g, b, alpha] = self.look([x[k], y[k]], footprint[k], Some(mid));
            let [right, top, out] = [r, g, b].map(|value| scale * (value - mid) * vectors[2][k]);
            let right = if mirror.is_on() { -right } else { right };
            let up = sine * right + cosine * top;
            vectors[0][k] = cosine * right - sine * top;
            vectors[1][k] = if self.turned_over { -up } else { up };
            vectors[2][k] = out;
            *share *= alpha;
        }
    }

    fn each(&self, footprint: &PerKnot, weights: &mut Weights, mut set: impl FnMut(usize, [f32; 4], &mut f32)) {
        let Weights { share, across: [x, y], .. } = weights;
        for (k, share) in share.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
            set(k, self.sample([x[k], y[k]], footprint[k]), share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(image: &Arc<StampImage>, settings: StampSettings) -> Stamp {
        Stamp::new(image.clone(), settings, StampChannel::Red).unwrap()
    }

    /// Red grows to the right, green downwards.
    fn ramp(n: u32) -> Arc<StampImage> {
        let at = |k: u32| (k as f32 + 0.5) / n as f32;
        let data: Vec<f32> = (0..n * n).flat_map(|k| [at(k % n), at(k / n), 0.25]).collect();
        StampImage::new(n, n, 3, &data).unwrap()
    }

    #[test]
    fn an_image_lies_upright_and_turns_and_mirrors() {
        let image = ramp(32);
        let look = |settings, x, y| {
            let [r, g, b, a] = stamp(&image, settings).sample([x, y], 0.0);
            assert!((b - 0.25).abs() < 1e-6 && a == 1.0);
            [r, g]
        };
        let near = |found: [f32; 2], expected: [f32; 2]| {
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{found:?} {expected:?}");
        };
        let plain = StampSettings::default();
        near(look(plain, 0.5, 0.25), [0.75, 0.375]);
        near(look(StampSettings { mirror: Switch::ON, ..plain }, 0.5, 0.25), [0.25, 0.375]);
        // Turned to the left by a quarter, what was on the right is on top.
        near(look(StampSettings { angle: std::f32::consts::FRAC_PI_2, ..plain }, -0.25, 0.5), [0.75, 0.375]);
        let twice = StampSettings { repeat: 2.0, ..plain };
        near(look(StampSettings { alternate: Switch::ON, ..twice }, 0.75, 0.25), [0.75, 0.25]);
        near(look(twice, 0.75, 0.25), [0.25, 0.25]);
        // The mirror image of a stroke sees it from the other side of the first axis.
        let over = stamp(&image, plain).turned_over().sample([0.5, 0.25], 0.0);
        near([over[0], over[1]], [0.75, 0.625]);
    }

    #[test]
    fn beside_the_image_there_is_nothing() {
        let image = ramp(16);
        let settings = StampSettings { angle: 0.785, ..Default::default() };
        assert_eq!(stamp(&image, settings).sample([0.95, 0.95], 0.01), [0.0; 4]);
        assert_ne!(stamp(&image, StampSettings { repeat: 1.5, ..settings }).sample([0.95, 0.95], 0.01), [0.0; 4]);
    }

    #[test]
    fn what_is_finer_than_the_places_is_averaged() {
        // A chequerboard of single pixels with odd sides; places four pixels apart see its mean.
        let (w, h) = (63, 41);
        let data: Vec<f32> = (0..w * h).map(|k| ((k % w + k / w) % 2) as f32).collect();
        let image = StampImage::new(w, h, 1, &data).unwrap();
        let settings = StampSettings { repeat: 3.0, alternate: Switch::ON, ..Default::default() };
        let stamp = stamp(&image, settings);
        for k in 0..200 {
            let place = [(0.37 * k as f32).sin(), (0.53 * k as f32).cos()];
            let value = stamp.sample(place, 8.0 / (3.0 * w as f32))[0];
            assert!((value - 0.5).abs() < 0.06, "{place:?}: {value}");
            let sharp = stamp.sample(place, 0.0)[0];
            assert!((0.0..=1.0).contains(&sharp));
        }
        // The last reduction is the mean of all.
        let mean = image.levels.last().unwrap().pixels[0][0];
        assert!((mean - data.iter().sum::<f32>() / data.len() as f32).abs() < 1e-4);
    }

    #[test]
    fn alpha_hides_colours_and_does_not_darken_them() {
        let image = StampImage::new(2, 1, 4, &[1.0, 0.5, 0.25, 1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
        let [r, g, b, a] = stamp(&image, StampSettings::default()).sample([0.0, 0.0], 0.0);
        assert_eq!([r, g, b, a], [1.0, 0.5, 0.25, 0.5]);
    }

    #[test]
    fn images_that_cannot_be_are_refused() {
        assert!(StampImage::new(0, 4, 1, &[]).is_err());
        assert!(StampImage::new(u32::MAX, u32::MAX, 4, &[]).is_err());
        assert!(StampImage::new(16385, 1, 1, &[0.0; 16385]).is_err());
        assert!(StampImage::new(2, 2, 3, &[0.0; 11]).is_err());
        assert!(StampImage::new(2, 2, 5, &[0.0; 20]).is_err());
        let error = StampImage::new(2, 2, 1, &[0.0, 0.0, 0.0, f32::NAN]).unwrap_err().to_string();
        assert!(error.contains("(1, 1)"), "{error}");
        assert!(StampImage::new(1, 1, 2, &[0.5, 1.5]).is_err());
        let image = ramp(4);
        let bad = StampSettings { repeat: f32::NAN, ..Default::default() };
        assert!(Stamp::new(image, bad, StampChannel::Red).is_err());
    }
}
