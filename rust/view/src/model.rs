//! The window in which a mesh or a document is looked at, painted and sculpted, after Schäfer, Keinert, Nießner and
//! Stamminger 2015, Local Painting and Deformation of Meshes on the GPU.
//!
//! A [`Session`] is what is edited: a surface with its layers, its history and its file. It knows no window and no graphics
//! device: strokes are given as rays. [`run`] opens the window, which shows the session and draws its triangles.

mod brush;
mod costs;
mod object;
mod panels;
mod picker;
mod session;
mod stamp;
mod triangles;
mod viewport;

use std::path::PathBuf;
use std::time::Duration;

use egui::Rect;
use glam::Vec3;
use relievo_core::Result;
use relievo_gpu::{Device, wgpu};

use crate::drawing::camera::Camera;
use crate::drawing::shaded::{Arrays, Shaded, Solid};
use crate::drawing::{pixels, rays};
use crate::pen::PenState;
use crate::preferences::Preferences;
use crate::script::Script;
use crate::window::{self, Content, Target};

pub use brush::{Brush, Held, Tool};
pub use costs::{Costs, STAGES};
pub use object::SurfaceKind;
pub use picker::Picked;
pub use session::{HandDecal, Opening, Session};
pub use stamp::BrushStamp;
pub use triangles::Shades;

use panels::Panels;
use viewport::Viewport;

/// Number of a stage in [`STAGES`].
const UPLOAD: usize = 3;

/// What a tool mesh is drawn in, linear.
const STEEL: [f32; 3] = [0.2, 0.22, 0.26];

/// Opens the window of a session, drawn by `device`, where the axis `up`, 0 to 2, points up. Returns the session when the
/// window is closed. A script acts first; the window closes at its end.
///
/// # Errors
/// Fails if there is no display, if the graphics device cannot present to it, is lost or has no memory, or if an act of
/// the script finds no widget.
pub fn run(mut session: Session, device: &Device, up: usize, script: Option<Script>) -> Result<Session> {
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    let preferences = Preferences::load(script.is_some());
    let scale = session.scale();
    session.brush.take_up(&preferences, scale);
    if session.decal().is_some() {
        session.brush.tool = Tool::Decal;
    }
    let mut viewport = Viewport::new(Camera::new(session.bounds(), up));
    viewport.is_wired = preferences.switch("view.faces").unwrap_or(false);
    viewport.rays.is_on = preferences.switch("view.rays").unwrap_or(false);
    viewport.rays.is_prompt = script.is_some();
    if preferences.switch("view.parallel").unwrap_or(false) {
        viewport.camera.toggle_projection();
    }
    let mut solid = Solid::new(device)?;
    solid.replace(session.triangles().arrays())?;
    let viewer = Viewer {
        solid,
        tool: Solid::new(device)?,
        tool_points: 0,
        shaded: Shaded::new(device),
        serial: session.triangles().serial,
        viewport,
        panels: Panels::default(),
        device: device.clone(),
        session,
        preferences,
    };
    Ok(window::run(context, viewer, script)?.session)
}

/// A session, its panels and its picture.
struct Viewer {
    session: Session,
    panels: Panels,
    viewport: Viewport,
    solid: Solid,
    tool: Solid,
    /// Points of the tool that are on the device.
    tool_points: usize,
    shaded: Shaded,
    /// The triangles that are on the device.
    serial: u64,
    device: Device,
    preferences: Preferences,
}

impl Viewer {
    /// Writes to the device what changed.
    fn upload(&mut self) -> Result<()> {
        let changed = self.session.take_changed();
        if self.serial != self.session.triangles().serial {
            self.serial = self.session.triangles().serial;
            return self.solid.replace(self.session.triangles().arrays());
        }
        if changed.is_empty() {
            return Ok(());
        }
        let Self { session, solid, .. } = self;
        let mut costs = std::mem::take(&mut session.costs);
        let done = costs.after(UPLOAD, || solid.update(session.triangles().arrays(), &changed));
        session.costs = costs;
        done.map(drop)
    }

    /// Writes the tool to the device where it is. Returns whether it is shown.
    fn upload_tool(&mut self) -> Result<bool> {
        let Some((tool, pose)) = self.session.tool_shown() else { return Ok(false) };
        let place = |point: &[f32; 3]| pose.transform_point3(Vec3::from(*point).as_dvec3()).as_vec3().to_array();
        let (points, triangles): (Vec<[f32; 3]>, _) = (tool.points().iter().map(place).collect(), tool.triangles());
        let (normals, colors) = (rays::smooth_normals(&points, triangles), vec![STEEL; points.len()]);
        let arrays = Arrays { points: &points, normals: &normals, colors: &colors, corners: triangles.as_flattened() };
        if std::mem::replace(&mut self.tool_points, points.len()) == points.len() {
            let whole = 0..points.len() as u32;
            self.tool.update(arrays, std::slice::from_ref(&whole))?;
        } else {
            self.tool.replace(arrays)?;
        }
        Ok(true)
    }
}

impl Content for Viewer {
    fn title(&self) -> String {
        format!("Relievo: {}", self.session.name())
    }

    fn without_window() -> &'static str {
        "`relievo draw` and `relievo doc stroke`"
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn hold(&mut self, pen: Vec<PenState>) {
        self.viewport.pens = pen;
    }

    fn count(&mut self, since: Option<Duration>) {
        self.session.costs.end_frame(since);
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        self.panels.show(ui, &mut self.session, &mut self.viewport);
    }

    fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, target: &Target<'_>) -> Result<()> {
        self.upload()?;
        let has_tool = self.upload_tool()?;
        let is_wired = self.viewport.is_wired;
        if is_wired {
            let triangles = self.session.triangles();
            self.solid.set_borders(|| triangles.borders())?;
        }
        let area = pixels(self.viewport.area().unwrap_or(Rect::NOTHING), target);
        let both = [(&self.solid, is_wired), (&self.tool, false)];
        let solids = if has_tool { &both[..] } else { &both[..1] };
        self.shaded.draw(encoder, target, area, &self.viewport.camera, solids)
    }

    fn end(&mut self) -> Result<()> {
        let Self { session, viewport, preferences, .. } = self;
        session.brush.keep(preferences, session.scale());
        preferences.set("view.faces", viewport.is_wired);
        preferences.set("view.rays", viewport.rays.is_on);
        preferences.set("view.parallel", viewport.camera.is_parallel());
        preferences.save()
    }

    fn is_resting(&self) -> bool {
        self.viewport.rays.is_done()
    }

    fn close(&mut self) {
        self.panels.close(&self.session);
    }

    fn closes(&self) -> bool {
        self.panels.closes()
    }

    fn say(&mut self, message: String) {
        self.session.message = Some(message);
    }

    fn rescue(&mut self) -> Result<Option<PathBuf>> {
        self.session.rescue()
    }

    fn widget(&self, name: &str) -> Option<Rect> {
        self.panels.widget(name)
    }

    fn view(&self) -> Option<Rect> {
        self.viewport.area()
    }
}
