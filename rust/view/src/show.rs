//! The window in which something is looked at and played: levels of a progressive mesh, particles, a crowd, soft tissue or
//! the result of a scene.
//!
//! What that is, a [`Subject`], makes a [`Picture`] for a frame and the values of its settings. The window has its camera, its
//! clock and its panels, draws the picture and records frames as pictures.

mod handle;
mod panels;
mod stage;

use std::path::PathBuf;

use egui::Rect;
use glam::{DMat3, DVec3};
use relievo_core::Result;
use relievo_gpu::{Device, wgpu};
use relievo_render::color::Color;
use relievo_render::{Image, Mesh, draw_legend, write_png};

use crate::drawing::shaded::{Arrays, Shaded, Solid};
use crate::drawing::{pixels, rays};
use crate::preferences::Preferences;
use crate::script::Script;
use crate::window::{self, Content, Target};

use panels::Panels;
use stage::Stage;

/// A ball of a picture, such as a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// In the world.
    pub center: [f32; 3],
    /// World units.
    pub radius: f32,
    /// Linear Rec.709.
    pub color: Color,
}

/// What is drawn.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Triangles in the world. Without normals they get those of the triangles at their points, without colours a grey one.
    pub mesh: Mesh,
    /// Balls.
    pub balls: Vec<Ball>,
    /// What colours stand for.
    pub legend: Vec<(Color, String)>,
    /// What the user should know of it, a line each.
    pub facts: Vec<String>,
}

/// Frames over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// How many there are; 1 of what does not move.
    pub count: usize,
    /// A second.
    pub rate: f64,
}

/// What the user can set.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What stands beside it.
    pub name: String,
    /// What it says when the pointer rests on it.
    pub hint: String,
    /// What it can be.
    pub range: Range,
    /// What it is; of a choice the number of the option.
    pub value: f64,
}

/// What a setting can be.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// One of some names.
    Choice(Vec<String>),
    /// A number from the least to the most.
    Slider {
        /// The least.
        least: f64,
        /// The most.
        most: f64,
        /// Whether the scale is logarithmic.
        is_logarithmic: bool,
        /// Whether it is a whole number.
        is_whole: bool,
    },
}

/// How far the bake of frames is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bake {
    /// Whether it runs now.
    pub is_running: bool,
    /// The share that is done, 0 to 1.
    pub share: f32,
    /// The stage it is at, or what it did or failed at.
    pub stage: String,
    /// Whether it failed.
    pub has_failed: bool,
    /// Frames that are there, from the first one on.
    pub frames: usize,
    /// Whether there is more to bake than frames that are missing, such as what other settings change.
    pub has_more: bool,
}

/// From where a picture is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// The place.
    pub place: DVec3,
    /// Columns: right, up, and against the direction of view.
    pub axes: DMat3,
    /// Vertical field of view, radians.
    pub fov: f64,
    /// Pixels along x and y.
    pub size: [u32; 2],
}

/// What a window shows and plays.
pub trait Subject {
    /// The name of what is open.
    fn name(&self) -> String;

    /// Its frames.
    fn frames(&self) -> Frames {
        Frames { count: 1, rate: 24.0 }
    }

    /// What the user can set, with the values at first.
    fn settings(&self) -> Vec<Setting> {
        Vec::new()
    }

    /// Whether pictures depend on where they are seen from.
    fn follows_the_eye(&self) -> bool {
        false
    }

    /// Smallest and largest coordinates, where the first picture may not have all of it.
    fn bounds(&self) -> Option<[DVec3; 2]> {
        None
    }

    /// Returns how far the bake of the frames is, with a value for each setting; `None` where there is nothing to bake. Asked
    /// for in every frame of the window.
    fn bake(&mut self, values: &[f64]) -> Option<Bake> {
        let _ = values;
        None
    }

    /// Begins to bake what is missing, in the background, with a value for each setting.
    fn begin_bake(&mut self, values: &[f64]) {
        let _ = values;
    }

    /// Asks the bake to stop. Frames that are there stay.
    fn stop_bake(&mut self) {}

    /// Returns where the handle is that the user drags over the surface of what is shown; `None` without one.
    fn handle(&self) -> Option<DVec3> {
        None
    }

    /// Puts the handle where the user drags it.
    fn move_handle(&mut self, place: DVec3) {
        let _ = place;
    }

    /// Returns how many works in the background changed pictures so far, and whether one is at work. Asked for in every frame
    /// of the window.
    fn works(&mut self) -> (u64, bool) {
        (0, false)
    }

    /// Makes the picture of a frame, with a value for each setting.
    ///
    /// # Errors
    /// A file cannot be read, or memory runs out. The window then shows the picture before and the error.
    fn picture(&mut self, frame: usize, values: &[f64], eye: &Eye) -> Result<Picture>;
}

/// Opens the window of a subject, drawn by `device`, where the axis `up`, 0 to 2, points up. A script acts first; the window
/// closes at its end.
///
/// # Errors
/// Fails if there is no display, if the first picture cannot be made, if the graphics device cannot present to the display,
/// is lost or has no memory, or if an act of the script finds no widget.
pub fn run(mut subject: Box<dyn Subject>, device: &Device, up: usize, script: Option<Script>) -> Result<()> {
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    let preferences = Preferences::load(script.is_some());
    let mut stage = Stage::new(subject.as_mut(), up)?;
    stage.rays.is_prompt = script.is_some();
    stage.is_stepped = script.is_some();
    stage.rays.is_on = preferences.switch("view.rays").unwrap_or(false);
    let viewer = Viewer {
        subject,
        solid: Solid::new(device)?,
        shaded: Shaded::new(device),
        stage,
        panels: Panels::default(),
        serial: 0,
        closes: false,
        device: device.clone(),
        preferences,
    };
    window::run(context, viewer, script).map(drop)
}

struct Viewer {
    subject: Box<dyn Subject>,
    stage: Stage,
    panels: Panels,
    solid: Solid,
    shaded: Shaded,
    /// The picture that is on the device.
    serial: u64,
    closes: bool,
    device: Device,
    preferences: Preferences,
}

impl Viewer {
    /// Writes the picture to the device if it is another one.
    fn upload(&mut self) -> Result<()> {
        if self.serial == self.stage.serial {
            return Ok(());
        }
        self.serial = self.stage.serial;
        let picture = &self.stage.picture;
        self.solid.replace(Arrays {
            points: &picture.mesh.points,
            normals: &picture.mesh.normals,
            colors: &picture.mesh.colors,
            corners: picture.mesh.triangles.as_flattened(),
        })?;
        self.solid.replace_balls(&picture.balls)
    }
}

impl Content for Viewer {
    fn title(&self) -> String {
        format!("Relievo: {}", self.subject.name())
    }

    fn without_window() -> &'static str {
        "`relievo draw`, `relievo fluid render`, `relievo crowd render` and `relievo tissue render`"
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        self.panels.show(ui, self.subject.as_mut(), &mut self.stage);
    }

    fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, target: &Target<'_>) -> Result<()> {
        self.upload()?;
        if self.stage.is_wired {
            let triangles = &self.stage.picture.mesh.triangles;
            self.solid.set_borders(|| edges(triangles))?;
        }
        let area = pixels(self.stage.area.unwrap_or(Rect::NOTHING), target);
        self.shaded.draw(encoder, target, area, &self.stage.camera, &[(&self.solid, self.stage.is_wired)])
    }

    fn close(&mut self) {
        self.closes = true;
    }

    fn closes(&self) -> bool {
        self.closes
    }

    fn say(&mut self, message: String) {
        self.stage.message = Some(message);
    }

    fn rescue(&mut self) -> Result<Option<PathBuf>> {
        Ok(None)
    }

    fn end(&mut self) -> Result<()> {
        self.preferences.set("view.rays", self.stage.rays.is_on);
        self.preferences.save()
    }

    fn widget(&self, name: &str) -> Option<Rect> {
        self.panels.widget(name)
    }

    fn view(&self) -> Option<Rect> {
        self.stage.area
    }

    fn is_resting(&self) -> bool {
        let is_baking = self.stage.bake.as_ref().is_some_and(|bake| bake.is_running);
        self.stage.rays.is_done() && !self.stage.is_recording() && !is_baking && !self.stage.is_working()
    }

    fn recorded(&mut self) -> Option<Rect> {
        self.stage.recorded()
    }

    fn record(&mut self, mut picture: Image) -> Result<()> {
        let Some(file) = self.stage.next_file() else { return Ok(()) };
        let entries: Vec<_> = self.stage.picture.legend.iter().map(|(color, text)| (*color, text.as_str())).collect();
        draw_legend(&mut picture, &entries);
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|error| relievo_core::Error::io(folder, &error))?;
        }
        let done = write_png(&file, &picture);
        self.stage.next(done)
    }
}

/// The sides of triangles, two points each.
fn edges(triangles: &[[u32; 3]]) -> Vec<u32> {
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut lines: Vec<[u32; 2]> = triangles.iter().flat_map(|triangle| sides(*triangle)).collect();
    lines.sort_unstable();
    lines.dedup();
    lines.into_flattened()
}

/// Gives a mesh what it needs to be drawn.
fn complete(mesh: &mut Mesh) {
    if mesh.normals.len() != mesh.points.len() {
        mesh.normals = rays::smooth_normals(&mesh.points, &mesh.triangles);
    }
    if mesh.colors.len() != mesh.points.len() {
        mesh.colors = vec![[0.55, 0.53, 0.5]; mesh.points.len()];
    }
}

/// Returns the box around a picture.
fn bounds(picture: &Picture) -> [DVec3; 2] {
    let at = |point: [f32; 3]| glam::Vec3::from(point).as_dvec3();
    let balls = picture.balls.iter().flat_map(|ball| {
        let reach = DVec3::splat(f64::from(ball.radius));
        [at(ball.center) - reach, at(ball.center) + reach]
    });
    let places = picture.mesh.points.iter().map(|point| at(*point)).chain(balls);
    let bounds = places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    let is_there = bounds.iter().all(|corner| corner.is_finite());
    if is_there { bounds } else { [DVec3::ZERO, DVec3::ONE] }
}
