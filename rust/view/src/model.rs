//! The window in which a mesh or a document is looked at, painted and sculpted, after Schäfer, Keinert, Nießner and
//! Stamminger 2015, Local Painting and Deformation of Meshes on the GPU.
//!
//! A [`Session`] is what is edited: a surface with its layers, its history and its file. It knows no window and no graphics
//! device: strokes are given as rays. [`run`] opens the window, which shows the session and draws its triangles.

mod brush;
mod camera;
mod costs;
mod object;
mod panels;
mod picker;
mod session;
mod shaded;
mod triangles;
mod viewport;

use std::path::PathBuf;

use egui::Rect;
use relievo_core::Result;
use relievo_gpu::{Device, wgpu};

use crate::script::Script;
use crate::window::{self, Content, Target};

pub use brush::{Brush, Held, Tool};
pub use costs::{Costs, STAGES};
pub use object::SurfaceKind;
pub use picker::Picked;
pub use session::{Opening, Session};

use camera::Camera;
use panels::Panels;
use shaded::Shaded;
use viewport::Viewport;

/// Number of a stage in [`STAGES`].
const UPLOAD: usize = 3;

/// Opens the window of a session, drawn by `device`, where the axis `up`, 0 to 2, points up. Returns the session when the
/// window is closed. A script acts first; the window closes at its end.
///
/// # Errors
/// Fails if there is no display, if the graphics device cannot present to it, is lost or has no memory, or if an act of
/// the script finds no widget.
pub fn run(session: Session, device: &Device, up: usize, script: Option<Script>) -> Result<Session> {
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    let viewer = Viewer {
        shaded: Shaded::new(device, session.triangles())?,
        serial: session.triangles().serial,
        viewport: Viewport::new(Camera::new(session.bounds(), up)),
        panels: Panels::default(),
        device: device.clone(),
        session,
    };
    Ok(window::run(context, viewer, script)?.session)
}

/// A session, its panels and its picture.
struct Viewer {
    session: Session,
    panels: Panels,
    viewport: Viewport,
    shaded: Shaded,
    /// The triangles that are on the device.
    serial: u64,
    device: Device,
}

impl Viewer {
    /// Writes to the device what changed.
    fn upload(&mut self) -> Result<()> {
        let changed = self.session.take_changed();
        if self.serial != self.session.triangles().serial {
            self.serial = self.session.triangles().serial;
            return self.shaded.replace(self.session.triangles());
        }
        if changed.is_empty() {
            return Ok(());
        }
        let Self { session, shaded, .. } = self;
        let mut costs = std::mem::take(&mut session.costs);
        let done = costs.after(UPLOAD, || shaded.update(session.triangles(), &changed));
        session.costs = costs;
        done.map(drop)
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

    fn show(&mut self, ui: &mut egui::Ui) {
        self.panels.show(ui, &mut self.session, &mut self.viewport);
    }

    fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, target: &Target<'_>) -> Result<()> {
        self.upload()?;
        let area = self.viewport.area().unwrap_or(Rect::NOTHING);
        let pixel = |points: f32, most: u32| ((points * target.scale).round().max(0.0) as u32).min(most);
        let [left, right] = [area.left(), area.right()].map(|at| pixel(at, target.size[0]));
        let [top, bottom] = [area.top(), area.bottom()].map(|at| pixel(at, target.size[1]));
        let area = [left, top, right.saturating_sub(left), bottom.saturating_sub(top)];
        let wire = self.viewport.is_wired.then(|| self.session.triangles());
        self.shaded.draw(encoder, target, area, &self.viewport.camera, wire)
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
