//! Pictures in memory.

use relievo_core::{Error, Result};

use crate::color::Color;

/// A picture of 32-bit floats. Row 0 is the top one. Colour is scene-linear Rec.709.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: u32,
    data: Vec<f32>,
}

impl Image {
    /// A picture of zeros with 1 to 4 `channels`.
    ///
    /// # Errors
    /// It would have no pixels, or more bytes than can be addressed.
    pub fn new(width: u32, height: u32, channels: u32) -> Result<Self> {
        let count = checked_count(width, height, channels)?;
        Ok(Self { width, height, channels, data: vec![0.0; count] })
    }

    /// A picture of the given numbers, pixel after pixel, row after row.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are no pixels, more than 2³², not 1 to 4 channels, or not as many numbers as these
    /// take.
    pub fn from_data(width: u32, height: u32, channels: u32, data: Vec<f32>) -> Result<Self> {
        let count = checked_count(width, height, channels)?;
        if data.len() != count {
            return Err(Error::invalid(format!("{} numbers for {width}×{height}×{channels}", data.len())));
        }
        Ok(Self { width, height, channels, data })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Numbers per pixel, 1 to 4.
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// The numbers.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// The numbers, to be changed.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// The numbers of pixel (x, y), none outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> &[f32] {
        match self.start(x, y) {
            Some(start) => &self.data[start..start + self.channels as usize],
            None => &[],
        }
    }

    /// The pixel (x, y) of a picture of at least three channels, or of a grey one, as a colour; black outside.
    pub fn color(&self, x: u32, y: u32) -> Color {
        match *self.pixel(x, y) {
            [r, g, b, ..] => [r, g, b],
            [grey, ..] => [grey; 3],
            [] => [0.0; 3],
        }
    }

    /// Sets the colour of pixel (x, y) of a picture of at least three channels. Outside the picture nothing happens.
    pub fn set_color(&mut self, x: u32, y: u32, color: Color) {
        if let (Some(start), true) = (self.start(x, y), self.channels >= 3) {
            self.data[start..start + 3].copy_from_slice(&color);
        }
    }

    fn start(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height)
            .then(|| (y as usize * self.width as usize + x as usize) * self.channels as usize)
    }

    /// Multiplies the colours by 2^`stops`.
    pub fn expose(&mut self, stops: f32) {
        let factor = stops.exp2();
        let colors = if self.channels == 4 { 3 } else { self.channels as usize };
        for pixel in self.data.chunks_exact_mut(self.channels as usize) {
            for value in &mut pixel[..colors] {
                *value *= factor;
            }
        }
    }
}

fn checked_count(width: u32, height: u32, channels: u32) -> Result<usize> {
    let count = u64::from(width) * u64::from(height);
    if count == 0 || count > 1 << 32 || !(1..=4).contains(&channels) {
        return Err(Error::invalid(format!("a picture cannot have {width}×{height} pixels of {channels} channels"))
            .advise("use at least one pixel, at most 2^32, and 1 to 4 channels"));
    }
    Ok(count as usize * channels as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_found_and_outside_is_black() {
        let mut image = Image::new(3, 2, 4).unwrap();
        image.set_color(2, 1, [1.0, 2.0, 3.0]);
        image.set_color(3, 1, [9.0; 3]);
        assert_eq!(image.pixel(2, 1), [1.0, 2.0, 3.0, 0.0]);
        assert_eq!(image.color(0, 2), [0.0; 3]);
        image.expose(1.0);
        assert_eq!(image.color(2, 1), [2.0, 4.0, 6.0]);
        assert!(Image::new(0, 1, 3).is_err() && Image::new(1, 1, 5).is_err());
        assert!(Image::from_data(2, 2, 3, vec![0.0; 11]).is_err());
    }
}
