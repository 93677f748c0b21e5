//! The window in which shaders are explored by examples (Mindek et al. 2013, Sections 4.2 and 4.3).
//!
//! A [`Session`] is what is explored: a shader, its inputs, its classified pixels and what follows from them. It knows no
//! window. [`Panels`] shows a session and changes it by clicks and keys; [`run`] opens the window.

mod panels;
mod plots;
mod profiles;
mod session;

use std::path::{Path, PathBuf};

use egui::{Pos2, Rect};
use relievo_core::Result;
use relievo_gpu::Device;

use crate::script::Script;
use crate::window::{self, Content};

pub use panels::Panels;
pub use session::{Opening, Session};

/// Opens the window of a session and returns when it is closed. A script acts first; the window closes at its end.
///
/// # Errors
/// Fails if there is no display, if the graphics device cannot present to it, is lost or has no memory, or if an act of
/// the script finds no widget.
pub fn run(session: Session, script: Option<Script>) -> Result<()> {
    let context = egui::Context::default();
    let panels = Panels::new(&context, &session);
    window::run(context, Explorer { session, panels }, script).map(drop)
}

/// A session and its panels.
struct Explorer {
    session: Session,
    panels: Panels,
}

impl Content for Explorer {
    fn title(&self) -> String {
        "Relievo: shaders".into()
    }

    fn without_window() -> &'static str {
        "`relievo shader run` and `classify`"
    }

    fn device(&self) -> &Device {
        self.session.device()
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        self.panels.show(ui, &mut self.session);
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

    fn pixel(&self, pixel: [u32; 2]) -> Option<Pos2> {
        self.panels.place(pixel, self.session.size())
    }

    fn plot(&self, axes: [usize; 2]) -> Option<Rect> {
        self.panels.plot(axes)
    }

    fn replace_text(&mut self, file: &Path) -> Result<()> {
        self.session.text = relievo_shaderlab::Source::read(file)?.text.to_string();
        self.panels.text_changed();
        Ok(())
    }
}
