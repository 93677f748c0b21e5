//! Pictures of what windows are about: a camera, the picture that the graphics device draws in every frame, and the one that
//! the ray caster makes once the hand rests.

pub(crate) mod camera;
pub(crate) mod rays;
pub(crate) mod shaded;

use egui::{Align2, Color32, Pos2, Rect, Ui};
use relievo_render::color::srgb_byte;

use crate::window::Target;

/// Returns the pixels of an area of a window: its upper left and its size.
pub(crate) fn pixels(area: Rect, target: &Target<'_>) -> [u32; 4] {
    let pixel = |points: f32, most: u32| ((points * target.scale).round().max(0.0) as u32).min(most);
    let [left, right] = [area.left(), area.right()].map(|at| pixel(at, target.size[0]));
    let [top, bottom] = [area.top(), area.bottom()].map(|at| pixel(at, target.size[1]));
    [left, top, right.saturating_sub(left), bottom.saturating_sub(top)]
}

/// Draws swatches with their texts into the lower left corner of an area.
pub(crate) fn draw_legend(ui: &Ui, area: Rect, entries: &[([f32; 3], String)]) {
    const ROW: f32 = 18.0;
    let painter = ui.painter_at(area);
    let top = area.bottom() - 10.0 - ROW * entries.len() as f32;
    let font = egui::FontId::proportional(12.0);
    let widest = entries.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0) as f32;
    let back = Rect::from_min_max(
        Pos2::new(area.left() + 6.0, top - 4.0),
        Pos2::new(area.left() + 34.0 + 7.0 * widest, area.bottom() - 6.0),
    );
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(150));
    for (row, (color, text)) in entries.iter().enumerate() {
        let at = Pos2::new(area.left() + 10.0, top + ROW * row as f32);
        let [r, g, b] = color.map(srgb_byte);
        painter.rect_filled(Rect::from_min_size(at, egui::vec2(14.0, 14.0)), 2.0, Color32::from_rgb(r, g, b));
        painter.text(at + egui::vec2(20.0, 7.0), Align2::LEFT_CENTER, text, font.clone(), Color32::from_gray(225));
    }
}
