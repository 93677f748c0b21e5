//! The stage of a subject: what is drawn, from where it is seen, and the clock that plays its frames.

use std::path::PathBuf;
use std::time::Instant;

use egui::{Event, Key, PointerButton, Rect, Response, Ui};
use glam::{DVec2, DVec3, Vec3};
use relievo_core::Result;
use relievo_render::Mesh;

use super::{Bake, Ball, Eye, Frames, Picture, Setting, Subject, bounds, complete, handle};
use crate::drawing::camera::{Camera, aspect};
use crate::drawing::rays::{MAX_TRIANGLES, Rays};

/// What the pointer does while a button is held.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drag {
    Orbit,
    Pan,
    Zoom,
    Handle,
}

/// What a picture is made of.
#[derive(Clone, Debug, PartialEq)]
struct Made {
    frame: usize,
    /// Whether the frame was baked, and a bake ran.
    baked: [bool; 2],
    values: Vec<f64>,
    /// From where it is seen, where that matters.
    eye: Option<Eye>,
    handle: Option<DVec3>,
    /// Works in the background that were done.
    works: u64,
}

/// Frames that are written as pictures.
struct Recording {
    folder: PathBuf,
    frame: usize,
    /// Whether the window shows the frame by now.
    is_shown: bool,
}

/// A subject on the stage.
pub(super) struct Stage {
    pub camera: Camera,
    pub area: Option<Rect>,
    pub is_wired: bool,
    pub rays: Rays,
    pub settings: Vec<Setting>,
    pub frames: Frames,
    /// The frame that is asked for.
    pub frame: usize,
    pub is_playing: bool,
    /// Whether playing goes on by a frame for each of the window, as scripts want it, and not by the clock.
    pub is_stepped: bool,
    pub picture: Picture,
    /// Counts pictures.
    pub serial: u64,
    /// Milliseconds that the last picture took.
    pub cost: f64,
    pub message: Option<String>,
    /// How far the frames are baked, where they are.
    pub bake: Option<Bake>,
    /// Whether the last frame of a bake is shown that runs, or has just ended.
    pub follows: bool,
    made: Option<Made>,
    handle: Option<DVec3>,
    /// Works in the background that were done, and whether one is at work.
    works: (u64, bool),
    /// When the frame was shown first.
    since: f64,
    drag: Option<Drag>,
    last: Option<egui::Pos2>,
    is_fitted: bool,
    recording: Option<Recording>,
}

impl Stage {
    /// Makes the first picture and has it in view.
    pub fn new(subject: &mut dyn Subject, up: usize) -> Result<Self> {
        let known = subject.bounds();
        let mut stage = Self {
            camera: Camera::new(known.unwrap_or_else(|| bounds(&Picture::default())), up),
            area: None,
            is_wired: false,
            rays: Rays::default(),
            settings: subject.settings(),
            frames: subject.frames(),
            frame: 0,
            is_playing: false,
            is_stepped: false,
            picture: Picture::default(),
            serial: 0,
            cost: 0.0,
            message: None,
            bake: None,
            follows: false,
            made: None,
            handle: None,
            works: (0, false),
            since: 0.0,
            drag: None,
            last: None,
            is_fitted: false,
            recording: None,
        };
        stage.bake = subject.bake(&stage.values());
        stage.fit();
        stage.make(subject)?;
        if known.is_none() {
            stage.camera = Camera::new(bounds(&stage.picture), up);
        }
        Ok(stage)
    }

    fn aspect(&self) -> f64 {
        self.area.map_or(1.6, aspect)
    }

    /// Has all of it in view.
    pub fn fit(&mut self) {
        self.camera.fit(self.aspect());
    }

    fn eye(&self) -> Eye {
        let (place, fov) = self.camera.perspective();
        let size = self.area.map_or([960, 600], |area| [area.width(), area.height()].map(|side| side.max(1.0) as u32));
        Eye { place, axes: self.camera.axes(), fov, size }
    }

    /// Returns the values of the settings.
    pub fn values(&self) -> Vec<f64> {
        self.settings.iter().map(|setting| setting.value).collect()
    }

    /// Makes the picture anew if what it is made of changed.
    fn make(&mut self, subject: &mut dyn Subject) -> Result<()> {
        let values = self.values();
        let eye = self.eye();
        let baked = self.bake.as_ref().map_or([true, false], |bake| [self.frame < bake.frames, bake.is_running]);
        let wanted = Made {
            frame: self.frame,
            baked,
            values,
            eye: subject.follows_the_eye().then_some(eye),
            handle: subject.handle(),
            works: self.works.0,
        };
        if self.made.as_ref() == Some(&wanted) {
            return Ok(());
        }
        let start = Instant::now();
        let made = subject.picture(wanted.frame, &wanted.values, &eye);
        // What failed is not tried again before something else is asked for.
        self.made = Some(wanted);
        let mut picture = made?;
        complete(&mut picture.mesh);
        self.picture = picture;
        self.cost = 1e3 * start.elapsed().as_secs_f64();
        self.serial += 1;
        self.message = None;
        Ok(())
    }

    /// Lays the view out in what is left of the window, and acts on what the user does there.
    pub fn show(&mut self, ui: &mut Ui, subject: &mut dyn Subject) {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::click_and_drag());
        self.area = Some(area);
        if !std::mem::replace(&mut self.is_fitted, true) {
            self.fit();
        }
        if !ui.ctx().egui_wants_keyboard_input() {
            self.keys(ui);
        }
        self.handle = subject.handle();
        self.pointer(ui, &response);
        if let Some(place) = self.handle.filter(|place| subject.handle() != Some(*place)) {
            subject.move_handle(place);
        }
        self.follow(ui, subject);
        self.play(ui);
        self.works = subject.works();
        if let Err(error) = self.make(subject) {
            self.message = Some(error.to_string());
            self.is_playing = false;
        }
        if let Some(recording) = &mut self.recording {
            recording.is_shown = recording.frame == self.frame;
        }
        if self.is_working() {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        }
        if let Some(place) = self.handle {
            handle::draw(ui, &self.camera, area, place);
        }
        let is_busy = self.is_playing || self.drag.is_some() || self.recording.is_some();
        let Self { rays, picture, camera, serial, .. } = self;
        if let Err(error) = rays.show(ui, area, camera, (*serial, is_busy), || Ok(with_balls(picture))) {
            self.message = Some(error.to_string());
            self.rays.is_on = false;
        }
    }

    /// Whether the subject works in the background on what its picture shows, or the picture lacks what such work found.
    pub fn is_working(&self) -> bool {
        self.works.1
    }

    /// Returns where the ray through a place of the window meets the picture.
    fn met(&self, pos: egui::Pos2) -> Option<DVec3> {
        handle::met(&self.picture.mesh, self.camera.ray_at(self.area?, pos))
    }

    /// Goes on to the last frame of a bake, unless frames are played meanwhile.
    fn follow(&mut self, ui: &Ui, subject: &mut dyn Subject) {
        self.bake = subject.bake(&self.values());
        let Some(bake) = &self.bake else { return };
        if self.follows && !self.is_playing {
            self.frame = bake.frames.saturating_sub(1);
        }
        self.follows &= bake.is_running;
        if bake.is_running {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        }
    }

    /// Goes on to the frame that the clock says.
    fn play(&mut self, ui: &Ui) {
        let now = ui.input(|input| input.time);
        if let Some(recording) = &self.recording {
            self.frame = recording.frame;
            ui.ctx().request_repaint();
            return;
        }
        if !self.is_playing || self.frames.count < 2 {
            self.since = now;
            return;
        }
        let due = match self.is_stepped {
            true => 1,
            false => ((now - self.since) * self.frames.rate) as usize,
        };
        if due > 0 {
            self.frame = (self.frame + due) % self.frames.count;
            self.since = now;
        }
        ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(0.5 / self.frames.rate.max(1.0)));
    }

    fn keys(&mut self, ui: &Ui) {
        for event in &ui.input(|input| input.events.clone()) {
            let Event::Key { key, pressed: true, modifiers, .. } = event else { continue };
            let has_control = modifiers.command || modifiers.ctrl;
            let last = self.frames.count.saturating_sub(1);
            self.camera.press(*key, has_control);
            match key {
                Key::Home => self.fit(),
                Key::W if !has_control => self.is_wired = !self.is_wired,
                Key::R if !has_control => self.rays.is_on = !self.rays.is_on,
                Key::Space => self.is_playing = !self.is_playing,
                Key::ArrowRight => (self.frame, self.follows) = ((self.frame + 1).min(last), false),
                Key::ArrowLeft => (self.frame, self.follows) = (self.frame.saturating_sub(1), false),
                Key::Escape => self.recording = None,
                _ => {}
            }
        }
    }

    fn pointer(&mut self, ui: &Ui, response: &Response) {
        let height = self.area.map_or(1.0, |area| area.height().max(1.0));
        for event in &ui.input(|input| input.events.clone()) {
            match event {
                Event::PointerButton { pos, button, pressed: true, modifiers } if response.contains_pointer() => {
                    self.last = Some(*pos);
                    let has_control = modifiers.ctrl || modifiers.command;
                    let is_plain = *button == PointerButton::Primary && !modifiers.shift && !has_control;
                    let is_handle =
                        |area| self.handle.is_some_and(|place| handle::is_at(&self.camera, area, place, *pos));
                    self.drag = Some(match (button, modifiers.shift, has_control) {
                        _ if is_plain && self.area.is_some_and(is_handle) => Drag::Handle,
                        (PointerButton::Secondary, _, true) | (_, false, true) => Drag::Zoom,
                        (_, true, _) => Drag::Pan,
                        _ => Drag::Orbit,
                    });
                }
                Event::PointerMoved(pos) => {
                    let way = self.last.map_or(egui::Vec2::ZERO, |last| *pos - last) / height;
                    let way = DVec2::new(f64::from(way.x), f64::from(way.y));
                    match self.drag {
                        Some(Drag::Orbit) => self.camera.orbit(way),
                        Some(Drag::Pan) => self.camera.pan(way),
                        Some(Drag::Zoom) => self.camera.zoom(-8.0 * way.y),
                        Some(Drag::Handle) => self.handle = self.met(*pos).or(self.handle),
                        None => {}
                    }
                    self.last = Some(*pos);
                }
                Event::PointerButton { pressed: false, .. } => self.drag = None,
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
    }

    /// Begins to write all frames as pictures into a folder.
    pub fn begin_recording(&mut self, folder: PathBuf) {
        self.is_playing = false;
        self.recording = Some(Recording { folder, frame: 0, is_shown: false });
    }

    /// Whether frames are being written.
    pub fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// Returns the area of the window that is to be written now.
    pub fn recorded(&self) -> Option<Rect> {
        self.recording.as_ref().filter(|recording| recording.is_shown).and(self.area)
    }

    /// Returns the file of the frame that is shown.
    pub fn next_file(&self) -> Option<PathBuf> {
        self.recording.as_ref().map(|recording| recording.folder.join(format!("{:04}.png", recording.frame)))
    }

    /// Goes on to the next frame after one was written, or ends.
    pub fn next(&mut self, done: Result<()>) -> Result<()> {
        let Some(mut recording) = self.recording.take() else { return Ok(()) };
        if let Err(error) = done {
            self.message = Some(error.to_string());
            return Ok(());
        }
        recording.frame += 1;
        recording.is_shown = false;
        if recording.frame < self.frames.count {
            self.recording = Some(recording);
        } else {
            self.message = Some(format!("{} pictures are in {}", self.frames.count, recording.folder.display()));
        }
        Ok(())
    }
}

/// Corners and triangles of an icosahedron about the origin, of radius 1.
fn icosahedron() -> ([Vec3; 12], [[u32; 3]; 20]) {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corners = [
        [-1.0, golden, 0.0],
        [1.0, golden, 0.0],
        [-1.0, -golden, 0.0],
        [1.0, -golden, 0.0],
        [0.0, -1.0, golden],
        [0.0, 1.0, golden],
        [0.0, -1.0, -golden],
        [0.0, 1.0, -golden],
        [golden, 0.0, -1.0],
        [golden, 0.0, 1.0],
        [-golden, 0.0, -1.0],
        [-golden, 0.0, 1.0],
    ];
    #[rustfmt::skip]
    let triangles = [
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    (corners.map(|corner| Vec3::from(corner).normalize()), triangles)
}

/// The mesh of a picture with its balls as icosahedra, as many of them as are affordable.
fn with_balls(picture: &Picture) -> Mesh {
    let mut mesh = picture.mesh.clone();
    (mesh.tags, mesh.edges) = (Vec::new(), Vec::new());
    let (corners, triangles) = icosahedron();
    let room = MAX_TRIANGLES.saturating_sub(mesh.triangles.len()) / triangles.len();
    for Ball { center, radius, color } in picture.balls.iter().take(room) {
        let first = mesh.points.len() as u32;
        mesh.points.extend(corners.iter().map(|corner| (Vec3::from(*center) + *radius * *corner).to_array()));
        mesh.normals.extend(corners.iter().map(|corner| corner.to_array()));
        mesh.colors.extend([*color; 12]);
        mesh.triangles.extend(triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_icosahedron_is_closed_and_points_outwards() {
        let (corners, triangles) = icosahedron();
        let volume: f32 = triangles
            .iter()
            .map(|triangle| triangle.map(|corner| corners[corner as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        // 5 (3 + √5) / 12 times the cube of the edge, which is the radius by sin(2π/5).
        assert!((volume - 2.536_150_7).abs() < 1e-5, "{volume}");
    }
}
