//! The image that is laid by hand in the view: its picture on the surface, its pins, and what the mouse and the keys do there.

use egui::epaint::Vertex;
use egui::{
    Align2, Color32, ColorImage, FontId, Key, Mesh, Pos2, Stroke, TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use glam::DVec3;
use relievo_core::Result;
use relievo_decal::Artwork;
use relievo_render::color::srgb_byte;

use super::{Drag, Viewport};
use crate::model::brush::Tool;
use crate::model::session::{HandDecal, Session};

/// The most pixels along a side of the picture that is shown.
const SIDE: u32 = 1024;

/// How near to a pin the pointer takes it, in points.
const NEAR: f32 = 10.0;

/// How far in front of the surface a pin is seen, as a share of the distance to it.
const FRONT: f64 = 1e-3;

/// The picture of an image as a texture with a transparent border, and which image it is of.
pub(super) struct Picture {
    texture: TextureHandle,
    serial: u64,
    /// Pixels without the border.
    size: [u32; 2],
}

impl Picture {
    fn new(ui: &Ui, decal: &HandDecal) -> Self {
        let full = decal.artwork().sticker().pixels();
        let scale = (f64::from(full[0].max(full[1])) / f64::from(SIDE)).max(1.0);
        let size = full.map(|side| ((f64::from(side) / scale) as u32).max(1));
        let texture = ui.ctx().load_texture("decal", picture(decal.artwork(), size, scale), TextureOptions::LINEAR);
        Self { texture, serial: decal.serial, size }
    }

    /// The place in the texture of a place of the image, 0 to 1 from the left and from the bottom.
    fn place(&self, [u, v]: [f64; 2]) -> Pos2 {
        let [across, down] = [(u, self.size[0]), (1.0 - v, self.size[1])]
            .map(|(share, side)| ((share * f64::from(side) + 1.0) / (f64::from(side) + 2.0)) as f32);
        pos2(across, down)
    }
}

/// Draws an image with a transparent border of a pixel.
fn picture(artwork: &Artwork, [width, height]: [u32; 2], footprint: f64) -> ColorImage {
    let mut made = ColorImage::filled([width as usize + 2, height as usize + 2], Color32::TRANSPARENT);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let uv = [(f64::from(x) + 0.5) / f64::from(width), 1.0 - (f64::from(y) + 0.5) / f64::from(height)];
        let [r, g, b, alpha] = artwork.color(uv, footprint);
        if alpha > 0.0 {
            let [r, g, b] = [r, g, b].map(|value| srgb_byte((value / alpha).clamp(0.0, 1.0)));
            let color = Color32::from_rgba_unmultiplied(r, g, b, (255.0 * alpha.min(1.0)).round() as u8);
            made[(x as usize + 1, y as usize + 1)] = color;
        }
    }
    made
}

impl Viewport {
    /// Has the image follow the model and draws it with its pins.
    pub(super) fn decal(&mut self, ui: &Ui, session: &mut Session) -> Result<()> {
        let is_laid = session.is_laid();
        if std::mem::replace(&mut self.had_decal, is_laid) && !is_laid {
            // Faces under an image that was written may be finer than they show.
            self.ended = Some(ui.input(|input| input.time));
            ui.ctx().request_repaint();
        }
        if !is_laid {
            return Ok(());
        }
        session.follow_decal()?;
        let Some((decal, area)) = session.decal().zip(self.area) else { return Ok(()) };
        let picture = match self.picture.take().filter(|picture| picture.serial == decal.serial) {
            Some(picture) => picture,
            None => Picture::new(ui, decal),
        };
        let painter = ui.painter_at(area);
        if let Some(mesh) = self.mesh(decal, &picture) {
            painter.add(mesh);
        }
        self.picture = Some(picture);
        let dots: Vec<_> = decal.pins().to_vec();
        let selected = decal.selected;
        for (pin, (point, _)) in dots.into_iter().enumerate() {
            let Some(at) = self.project(point) else { continue };
            let is_seen = self.is_seen(session, point)?;
            let color = if selected == Some(pin) { Color32::from_rgb(255, 170, 60) } else { Color32::WHITE };
            let color = if is_seen { color } else { color.gamma_multiply(0.25) };
            painter.circle(at, 5.0, color, Stroke::new(1.5, Color32::BLACK));
            let label = (pin + 1).to_string();
            painter.text(at + vec2(8.0, -4.0), Align2::LEFT_BOTTOM, label, FontId::proportional(13.0), color);
        }
        Ok(())
    }

    /// The triangles of the image that face the eye, in points of the window.
    fn mesh(&self, decal: &HandDecal, picture: &Picture) -> Option<Mesh> {
        let laid = decal.decal()?;
        let mut mesh = Mesh::with_texture(picture.texture.id());
        let mut places = Vec::with_capacity(laid.points.len());
        let towards = self.camera.axes().z_axis;
        for ((point, normal), uv) in laid.points.iter().zip(&laid.normals).zip(&laid.uv) {
            let pos = self.project(DVec3::from(*point));
            let light = (255.0 * (0.45 + 0.55 * DVec3::from(*normal).dot(towards).max(0.0))).min(255.0) as u8;
            let vertex =
                Vertex { pos: pos.unwrap_or_default(), uv: picture.place(*uv), color: Color32::from_gray(light) };
            mesh.vertices.push(vertex);
            places.push(pos);
        }
        for triangle in &laid.triangles {
            let [Some(a), Some(b), Some(c)] = triangle.map(|corner| places[corner as usize]) else { continue };
            let (ab, ac) = (b - a, c - a);
            // Points of the window go downwards.
            if ab.x * ac.y - ab.y * ac.x < 0.0 {
                mesh.indices.extend(triangle);
            }
        }
        Some(mesh)
    }

    /// Whether nothing is before a point of the surface.
    fn is_seen(&self, session: &mut Session, point: DVec3) -> Result<bool> {
        let Some(at) = self.project(point) else { return Ok(false) };
        let ray = self.ray(at);
        let distance = (point - ray.0).dot(ray.1);
        let found = session.pick(ray)?;
        session.costs.end_event(false);
        Ok(found.is_none_or(|found| (found.point - ray.0).dot(ray.1) > distance * (1.0 - FRONT) - 1e-9))
    }

    /// The pin under the pointer.
    fn pin_at(&self, session: &mut Session, at: Pos2) -> Result<Option<usize>> {
        let dots: Vec<_> = session.decal().map_or_else(Vec::new, |decal| decal.pins().to_vec());
        let mut best: Option<(f32, usize)> = None;
        for (pin, (point, _)) in dots.into_iter().enumerate() {
            let distance = self.project(point).map_or(f32::INFINITY, |dot| dot.distance(at));
            if distance <= NEAR && best.is_none_or(|(other, _)| distance < other) && self.is_seen(session, point)? {
                best = Some((distance, pin));
            }
        }
        Ok(best.map(|(_, pin)| pin))
    }

    /// Takes the pin under the pointer, or puts one there. Returns whether the pointer is on a pin or on the surface.
    pub(super) fn take_pin(&mut self, session: &mut Session, at: Pos2) -> Result<bool> {
        if let Some(pin) = self.pin_at(session, at)? {
            session.select_pin(Some(pin));
            self.drag = Some(Drag::Pin(pin));
            return Ok(true);
        }
        let picked = session.pick(self.ray(at))?;
        session.costs.end_event(false);
        let Some(picked) = picked else { return Ok(false) };
        session.add_pin(&picked, self.camera.axes().y_axis)?;
        Ok(true)
    }

    /// Moves a pin to where the pointer is.
    pub(super) fn move_pin(&self, session: &mut Session, pin: usize, at: Pos2) -> Result<()> {
        let picked = session.pick(self.ray(at))?;
        session.costs.end_event(false);
        picked.map_or(Ok(()), |picked| session.drag_pin(pin, &picked))
    }

    /// Acts on a key of the image.
    pub(super) fn decal_key(&mut self, session: &mut Session, key: Key) {
        if session.brush.tool != Tool::Decal || !session.is_laid() || self.setting.is_some() {
            return;
        }
        let selected = session.decal().and_then(|decal| decal.selected);
        let done = match (key, selected) {
            (Key::Enter, _) => session.write_decal(),
            (Key::Delete | Key::Backspace, Some(pin)) => session.remove_pin(pin),
            (Key::Escape, _) if matches!(self.drag, Some(Drag::Pin(_))) => session.cancel_pin(),
            (Key::Escape, _) => {
                session.drop_decal();
                Ok(())
            }
            _ => Ok(()),
        };
        session.message = done.err().map(|error| error.to_string());
    }
}
