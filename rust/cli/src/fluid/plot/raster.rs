//! Plots as pixels. Letters are those of the legends of pictures, so that no font of the system is needed.

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use relievo_core::Result;
use relievo_render::{Image, color, draw_text};

/// Dots of a letter's cell, and its rows.
const CELL: u32 = 6;
const ROWS: u32 = 7;
/// The size of a text for each pixel of a dot: letters are then no wider than plots reckon with.
const SIZE: f64 = 13.5;

/// A picture that is drawn.
pub struct Raster {
    image: Image,
}

impl Raster {
    /// A black picture of so many pixels.
    pub fn new((width, height): (u32, u32)) -> Result<Self> {
        Ok(Self { image: Image::new(width, height, 3)? })
    }

    /// The picture, of scene-linear colours.
    pub fn image(&self) -> &Image {
        &self.image
    }
}

/// Pixels of a dot.
fn dot(style: &impl BackendTextStyle) -> u32 {
    (style.size() / SIZE).round().max(1.0) as u32
}

impl DrawingBackend for &mut Raster {
    type ErrorType = std::convert::Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.image.width(), self.image.height())
    }

    fn ensure_prepared(&mut self) -> std::result::Result<(), DrawingErrorKind<Self::ErrorType>> {
        Ok(())
    }

    fn present(&mut self) -> std::result::Result<(), DrawingErrorKind<Self::ErrorType>> {
        Ok(())
    }

    fn draw_pixel(
        &mut self,
        (x, y): BackendCoord,
        drawn: BackendColor,
    ) -> std::result::Result<(), DrawingErrorKind<Self::ErrorType>> {
        if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) {
            let over = linear(drawn).map(|value| value * drawn.alpha as f32);
            let under = self.image.color(x, y).map(|value| value * (1.0 - drawn.alpha as f32));
            self.image.set_color(x, y, [0, 1, 2].map(|channel| over[channel] + under[channel]));
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> std::result::Result<(), DrawingErrorKind<Self::ErrorType>> {
        let (width, height) = self.estimate_text_size(text, style)?;
        let (width, height) = (width as i32, height as i32);
        let anchor = style.anchor();
        let left = match anchor.h_pos {
            HPos::Left => x,
            HPos::Center => x - width / 2,
            HPos::Right => x - width,
        };
        let top = match anchor.v_pos {
            VPos::Top => y,
            VPos::Center => y - height / 2,
            VPos::Bottom => y - height,
        };
        let place = [left, top].map(|value| value.max(0) as u32);
        draw_text(&mut self.image, place, dot(style), u32::MAX, linear(style.color()), text);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> std::result::Result<(u32, u32), DrawingErrorKind<Self::ErrorType>> {
        Ok((text.chars().count() as u32 * CELL * dot(style), ROWS * dot(style)))
    }
}

/// A colour as pictures have it.
fn linear(color: BackendColor) -> [f32; 3] {
    let (red, green, blue) = color.rgb;
    [red, green, blue].map(|value| color::decode_srgb(f32::from(value) / 255.0))
}
