//! The view of the model: what the mouse, the pen and the keys do there, and the circle of the brush on the surface.

mod decal;

use egui::{Color32, CursorIcon, Event, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui};
use glam::{DVec2, DVec3};
use relievo_core::Result;
use relievo_detail::Action;

use super::brush::{Brush, Held, Tool};
use super::picker::Picked;
use super::session::Session;
use super::triangles::Shades;
use crate::drawing::camera::{Camera, aspect};
use crate::drawing::rays::Rays;
use crate::drawing::{draw_legend, rays};
use crate::pen::{PenState, state_at};
use decal::Picture;

/// Sides of the polygon that is drawn as a circle.
const SIDES: usize = 64;

/// Seconds without an event after which faces are divided anew.
const REST: f64 = 0.35;

/// What the pointer does while a button is held.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drag {
    Orbit,
    Pan,
    Zoom,
    Stroke,
    Press,
    Pin(usize),
}

/// Goes on with the stroke, or with the tool that is pressed, along rays with pressures.
fn go_on(session: &mut Session, rays: &[((DVec3, DVec3), f64)]) -> Result<()> {
    if session.brush.tool == Tool::Press {
        // The way between two places is the tool's own; those in between would be steps of nothing.
        return rays.last().map_or(Ok(()), |(ray, pressure)| session.press_to(*ray, *pressure));
    }
    session.extend_stroke(rays)
}

/// A number of the brush that the pointer sets.
#[derive(Clone, Debug, PartialEq)]
struct Setting {
    is_size: bool,
    from: Pos2,
    before: Brush,
}

/// The view.
pub(crate) struct Viewport {
    pub(crate) camera: Camera,
    /// Whether the borders of faces are drawn.
    pub(crate) is_wired: bool,
    /// The ray caster's picture.
    pub(crate) rays: Rays,
    area: Option<Rect>,
    drag: Option<Drag>,
    setting: Option<Setting>,
    /// What is under the pointer.
    under: Option<Picked>,
    /// Where the pointer was at the last event.
    last: Option<Pos2>,
    /// How the pen was held since the last frame.
    pub(crate) pens: Vec<PenState>,
    /// How the pen is held.
    pen: PenState,
    /// When the last stroke ended whose detail may be finer than faces show.
    ended: Option<f64>,
    is_fitted: bool,
    /// The picture of the image that is laid.
    picture: Option<Picture>,
    /// Whether an image was laid in the last frame.
    had_decal: bool,
}

impl Viewport {
    pub(crate) fn new(camera: Camera) -> Self {
        Self {
            camera,
            is_wired: false,
            rays: Rays::default(),
            area: None,
            drag: None,
            setting: None,
            under: None,
            last: None,
            pens: Vec::new(),
            pen: PenState::MOUSE,
            ended: None,
            is_fitted: false,
            picture: None,
            had_decal: false,
        }
    }

    /// Where the view was laid out last, in points.
    pub(crate) fn area(&self) -> Option<Rect> {
        self.area
    }

    fn aspect(&self) -> f64 {
        self.area.map_or(1.0, aspect)
    }

    /// Has the whole model in view.
    pub(crate) fn fit(&mut self) {
        self.camera.fit(self.aspect());
    }

    /// Lays the view out in what is left of the window, and acts on what the user does there.
    pub(crate) fn show(&mut self, ui: &mut Ui, session: &mut Session) {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        self.area = Some(area);
        if !std::mem::replace(&mut self.is_fitted, true) {
            self.fit();
        }
        if !ui.ctx().egui_wants_keyboard_input() {
            self.keys(ui, session);
        }
        let done = self.pointer(ui, session, &response);
        if let Err(error) = done {
            session.message = Some(error.to_string());
        }
        self.rest(ui, session);
        self.cast(ui, session, area);
        if let Err(error) = self.decal(ui, session) {
            session.message = Some(error.to_string());
        }
        if session.shades() != Shades::Paint {
            let legend = session.shades().legend().iter();
            let entries: Vec<_> =
                legend.map(|(hex, text)| (relievo_render::color::from_hex(*hex), (*text).to_owned())).collect();
            draw_legend(ui, area, &entries);
        }
        if !session.is_laid() && (response.hovered() || self.drag.is_some()) {
            self.circle(ui, session);
        }
    }

    /// Divides faces anew once the hand rests.
    fn rest(&mut self, ui: &Ui, session: &mut Session) {
        let now = ui.input(|input| input.time);
        let Some(ended) = self.ended.filter(|_| !session.is_drawing() && !session.is_laid()) else { return };
        if now - ended < REST {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(REST));
            return;
        }
        self.ended = None;
        if let Err(error) = session.refine() {
            session.message = Some(error.to_string());
        }
    }

    /// Shows the ray caster's picture while the hand rests.
    fn cast(&mut self, ui: &Ui, session: &mut Session, area: Rect) {
        let is_busy = session.is_drawing() || self.drag.is_some() || self.ended.is_some();
        let (serial, triangles) = (session.changes(), session.triangles());
        let mesh = || {
            if triangles.corners().len() / 3 > rays::MAX_TRIANGLES {
                return Err(relievo_core::Error::unsupported("the model has too many triangles for the ray caster"));
            }
            Ok(relievo_render::Mesh {
                points: triangles.points().to_vec(),
                triangles: triangles.corners().as_chunks().0.to_vec(),
                normals: triangles.normals().to_vec(),
                colors: triangles.colors().to_vec(),
                ..Default::default()
            })
        };
        if let Err(error) = self.rays.show(ui, area, &self.camera, (serial, is_busy), mesh) {
            session.message = Some(error.to_string());
            self.rays.is_on = false;
        }
    }

    fn keys(&mut self, ui: &Ui, session: &mut Session) {
        let events = ui.input(|input| input.events.clone());
        for event in &events {
            let Event::Key { key, pressed: true, modifiers, .. } = event else { continue };
            let (has_control, has_shift) = (modifiers.command || modifiers.ctrl, modifiers.shift);
            self.camera.press(*key, has_control);
            match key {
                Key::Home => self.fit(),
                Key::W if !has_control => self.is_wired = !self.is_wired,
                Key::R if !has_control => self.rays.is_on = !self.rays.is_on,
                Key::X if !has_control => session.brush.symmetry = !session.brush.symmetry,
                Key::F if !has_control && self.drag.is_none() => {
                    let from = ui.input(|input| input.pointer.latest_pos()).or(self.area.map(|area| area.center()));
                    let before = session.brush.clone();
                    self.setting = from.map(|from| Setting { is_size: !has_shift, from, before });
                }
                Key::Escape => {
                    self.decal_key(session, *key);
                    self.cancel(session);
                }
                Key::Enter | Key::Delete | Key::Backspace => self.decal_key(session, *key),
                _ => {}
            }
        }
    }

    /// Takes back what is under way.
    fn cancel(&mut self, session: &mut Session) {
        if let Some(setting) = self.setting.take() {
            session.brush = setting.before;
        }
        if session.is_drawing()
            && let Err(error) = session.cancel_stroke()
        {
            session.message = Some(error.to_string());
        }
        self.drag = None;
    }

    /// The ray through a place of the window, in points.
    fn ray(&self, at: Pos2) -> (DVec3, DVec3) {
        let area = self.area.unwrap_or(Rect::from_min_size(Pos2::ZERO, egui::vec2(1.0, 1.0)));
        self.camera.ray_at(area, at)
    }

    /// Where a point of the world is in the window, in points.
    fn project(&self, point: DVec3) -> Option<Pos2> {
        self.camera.project(self.area?, point)
    }

    fn pointer(&mut self, ui: &Ui, session: &mut Session, response: &Response) -> Result<()> {
        let (events, held, latest) = ui.input(|input| {
            let inverts = input.modifiers.ctrl || input.modifiers.command;
            let held = Held { inverts, smooths: input.modifiers.shift, lean: 0.0 };
            (input.events.clone(), held, input.pointer.latest_pos())
        });
        let (mut rays, mut pinned) = (Vec::new(), None);
        let pens = std::mem::take(&mut self.pens);
        let moves = events.iter().filter(|event| matches!(event, Event::PointerMoved(_))).count();
        let mut moved = 0;
        for event in &events {
            if matches!(event, Event::PointerMoved(_) | Event::PointerButton { pressed: true, .. }) {
                self.pen = state_at(&pens, moved, moves).unwrap_or(self.pen);
            }
            match event {
                Event::Touch { force: Some(force), .. } => self.pen.pressure = f64::from(*force),
                Event::PointerButton { pos, button, pressed: true, modifiers } if response.contains_pointer() => {
                    self.last = Some(*pos);
                    if self.setting.is_some() {
                        if *button == PointerButton::Secondary {
                            self.cancel(session);
                        }
                        self.setting = None;
                        continue;
                    }
                    if *button == PointerButton::Secondary && session.is_drawing() {
                        self.cancel(session);
                        continue;
                    }
                    if *button == PointerButton::Secondary && matches!(self.drag, Some(Drag::Pin(_))) {
                        self.drag = None;
                        session.cancel_pin()?;
                        continue;
                    }
                    let lays = *button == PointerButton::Primary && session.brush.tool == Tool::Decal;
                    if lays && self.take_pin(session, *pos)? {
                        session.message = None;
                        continue;
                    }
                    let is_on = *button == PointerButton::Primary && session.pick(self.ray(*pos))?.is_some();
                    session.costs.end_event(false);
                    if is_on && session.brush.tool == Tool::Press {
                        if session.begin_press(self.ray(*pos), self.pen.pressure)? {
                            self.drag = Some(Drag::Press);
                        }
                        continue;
                    }
                    self.drag = Some(match (is_on, modifiers.shift, modifiers.ctrl || modifiers.command) {
                        (true, ..) => Drag::Stroke,
                        (_, true, _) => Drag::Pan,
                        (_, _, true) => Drag::Zoom,
                        _ => Drag::Orbit,
                    });
                    if is_on {
                        session.begin_stroke(Held { lean: self.pen.lean, ..held })?;
                        rays.push((self.ray(*pos), self.pen.pressure));
                    }
                }
                Event::PointerMoved(pos) => {
                    moved += 1;
                    let area = self.area.unwrap_or(Rect::NOTHING);
                    let way = self.last.map_or(egui::Vec2::ZERO, |last| *pos - last) / area.height().max(1.0);
                    let way = DVec2::new(f64::from(way.x), f64::from(way.y));
                    match self.drag {
                        Some(Drag::Orbit) => self.camera.orbit(way),
                        Some(Drag::Pan) => self.camera.pan(way),
                        Some(Drag::Zoom) => self.camera.zoom(-8.0 * way.y),
                        Some(Drag::Stroke | Drag::Press) => rays.push((self.ray(*pos), self.pen.pressure)),
                        Some(Drag::Pin(pin)) if self.last != Some(*pos) => pinned = Some((pin, *pos)),
                        Some(Drag::Pin(_)) => {}
                        None => self.set(session, *pos),
                    }
                    self.last = Some(*pos);
                }
                Event::PointerButton { pressed: false, .. } if matches!(self.drag, Some(Drag::Pin(_))) => {
                    self.drag = None;
                    if let Some((pin, at)) = pinned.take() {
                        self.move_pin(session, pin, at)?;
                    }
                    session.end_pin()?;
                }
                Event::PointerButton { pressed: false, .. } => {
                    let held = self.drag.take().filter(|_| session.is_drawing());
                    let is_drawn = matches!(held, Some(Drag::Stroke | Drag::Press));
                    if is_drawn && !rays.is_empty() {
                        go_on(session, &std::mem::take(&mut rays))?;
                    }
                    if is_drawn {
                        match held {
                            Some(Drag::Press) => session.end_press()?,
                            _ => session.end_stroke()?,
                        }
                        self.camera.set_bounds(session.extent());
                        self.ended = Some(ui.input(|input| input.time));
                        self.pen.pressure = 1.0;
                    }
                }
                Event::MouseWheel { delta, unit, .. } if response.contains_pointer() => {
                    let lines = match unit {
                        egui::MouseWheelUnit::Point => 40.0,
                        egui::MouseWheelUnit::Line => 1.0,
                        egui::MouseWheelUnit::Page => 0.1,
                    };
                    self.camera.zoom(f64::from(delta.y / lines));
                }
                _ => {}
            }
        }
        if !rays.is_empty() && session.is_drawing() {
            go_on(session, &rays)?;
        }
        if let Some((pin, at)) = pinned {
            self.move_pin(session, pin, at)?;
        }
        self.under = match latest.filter(|at| self.area.is_some_and(|area| area.contains(*at))) {
            Some(at) if !matches!(self.drag, Some(Drag::Orbit | Drag::Pan | Drag::Zoom)) => {
                let found = session.pick(self.ray(at))?;
                session.costs.end_event(false);
                found
            }
            _ => None,
        };
        if session.brush.tool == Tool::Press {
            session.hover_tool(self.under.as_ref())
        } else {
            session.hover_tool(None)
        }
    }

    /// Sets the size or the strength of the brush by where the pointer is.
    fn set(&self, session: &mut Session, at: Pos2) {
        let Some(Setting { is_size, from, before }) = &self.setting else { return };
        let height = self.area.map_or(1.0, |area| area.height().max(1.0));
        let way = f64::from((at.x - from.x) / height);
        if *is_size {
            let bounds = session.bounds();
            let radii = Brush::radii((bounds[1] - bounds[0]).length().max(1e-6));
            let radius = before.radius + way * self.camera.span();
            session.brush.radius = radius.clamp(*radii.start(), *radii.end());
        } else {
            session.brush.strength = (before.strength + 2.0 * way as f32).clamp(0.0, 1.0);
        }
    }

    /// Draws the circle of the brush on the surface, and of its mirror image.
    fn circle(&self, ui: &Ui, session: &Session) {
        let Some(area) = self.area else { return };
        let painter = ui.painter_at(area);
        let brush = &session.brush;
        let radius = brush.radius * Held { lean: self.pen.lean, ..Held::default() }.width();
        let color = match brush.stroke(Held::default()).action {
            Action::Paint { color: [r, g, b, _], .. } => {
                let byte = relievo_render::color::srgb_byte;
                Color32::from_rgb(byte(r).max(60), byte(g).max(60), byte(b).max(60))
            }
            Action::Sculpt { .. } => Color32::from_rgb(255, 170, 60),
        };
        let mut places: Vec<(DVec3, DVec3)> = self.under.iter().map(|under| (under.point, under.normal)).collect();
        if brush.symmetry {
            let mirror = DVec3::new(-1.0, 1.0, 1.0);
            places.extend(places.clone().into_iter().map(|(point, normal)| (point * mirror, normal * mirror)));
        }
        if self.setting.is_some() && places.is_empty() {
            return;
        }
        for (at, (point, normal)) in places.into_iter().enumerate() {
            let (right, up) = normal.any_orthonormal_pair();
            let ring = |radius: f64| {
                let corner = |side: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * side as f64 / SIDES as f64).sin_cos();
                    self.project(point + radius * (cos * right + sin * up) + 0.01 * brush.radius * normal)
                };
                (0..=SIDES).filter_map(corner).collect::<Vec<_>>()
            };
            let width = if at == 0 { 2.0 } else { 1.0 };
            painter.line(ring(radius), Stroke::new(width + 2.0, Color32::from_black_alpha(120)));
            painter.line(ring(radius), Stroke::new(width, color));
            painter.line(ring(radius * f64::from(brush.strength)), Stroke::new(1.0, color.gamma_multiply(0.6)));
        }
        if self.under.is_some() && self.drag.is_none() {
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
    }

    /// What the user may do now, in a few words.
    pub(crate) fn hint(&self, session: &Session) -> &'static str {
        match (&self.setting, self.drag) {
            (Some(Setting { is_size: true, .. }), _) => {
                "Move for the size. Click: keep. Right click or Esc: as it was."
            }
            (Some(_), _) => "Move for the strength. Click: keep. Right click or Esc: as it was.",
            (None, Some(Drag::Stroke)) => "Right click or Esc takes the stroke back.",
            (None, Some(Drag::Pin(_))) => "Right click or Esc takes the pin back to where it was.",
            (None, None) if session.brush.tool == Tool::Decal && session.is_laid() => {
                "Drag a pin, or click on the image for another. Delete: remove it. Enter: write the image. Esc: take it off."
            }
            (None, None) if session.brush.tool == Tool::Decal => "Click on the surface to lay the image there.",
            (None, Some(Drag::Press)) => "Right click or Esc takes back what the tool pressed.",
            _ => {
                "Left: brush (Ctrl inverts, Shift smooths). Middle: turn (Shift moves, Ctrl zooms). F, Shift+F: size, strength."
            }
        }
    }
}
