//! Files that are opened for the hand, by their name or dropped on the window: the mesh that is pressed into the surface, the
//! image of the brush, and the image that is laid on the surface with its pins.

use std::path::{Path, PathBuf};

use egui::{Key, TextEdit, Ui};
use relievo_core::Result;

use super::{FAULT, Panels};
use crate::model::brush::Tool;
use crate::model::session::Session;

/// What a file is opened as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opened {
    /// The mesh that is pressed into the surface.
    Tool,
    /// The image of the brush.
    Stamp,
    /// The image that is laid on the surface.
    Decal,
}

impl Opened {
    fn title(self) -> &'static str {
        match self {
            Self::Tool => "Open tool",
            Self::Stamp => "Open stamp",
            Self::Decal => "Open image",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Tool => "A mesh to press into the surface; or drop its file here",
            Self::Decal => "An image, PNG or EXR, to lay on the surface; or drop its file here while *decal* is chosen",
            Self::Stamp => "An image, PNG or EXR, that the brush paints and sculpts with; or drop its file here",
        }
    }
}

impl Panels {
    /// Shows the mesh that is pressed into the surface.
    pub(super) fn tool(&mut self, ui: &mut Ui, session: &mut Session) {
        ui.strong("Press");
        ui.horizontal_wrapped(|ui| {
            if let Some(name) = session.tool().map(str::to_owned) {
                let response = ui.selectable_label(session.brush.tool == Tool::Press, &name).on_hover_text(
                    "Drag it over the surface. Size and strength say how large it is and how deep it sinks",
                );
                if self.clicked(&format!("press {name}"), &response) {
                    session.brush.tool = Tool::Press;
                }
            }
            self.ask_for(ui, Opened::Tool);
        });
    }

    /// Shows the image of the brush.
    pub(super) fn stamp(&mut self, ui: &mut Ui, session: &mut Session) {
        ui.separator();
        ui.strong("Stamp");
        ui.horizontal_wrapped(|ui| {
            if let Some(stamp) = &session.brush.stamp {
                ui.label(&stamp.name).on_hover_text("Paint is multiplied by its colours, heights by its red");
                let remove = ui.small_button("x").on_hover_text("Remove the image from the brush");
                if self.clicked("remove stamp", &remove) {
                    session.brush.stamp = None;
                }
            }
            self.ask_for(ui, Opened::Stamp);
        });
    }

    /// Shows the image that is laid on the surface, its pins and its distortion.
    pub(super) fn decal(&mut self, ui: &mut Ui, session: &mut Session) {
        ui.separator();
        ui.strong("Decal");
        let name = session.decal().map_or_else(|| "decal".to_owned(), |decal| decal.name().to_owned());
        ui.horizontal_wrapped(|ui| {
            let response = ui
                .selectable_label(session.brush.tool == Tool::Decal, &name)
                .on_hover_text("Click on the surface to lay the image there, as wide as the brush");
            if self.clicked("decal", &response) {
                session.brush.tool = Tool::Decal;
            }
            self.ask_for(ui, Opened::Decal);
        });
        let Some(decal) = session.decal() else { return };
        let (count, selected) = (decal.pins().len(), decal.selected);
        let quality = decal.quality().map(|quality| {
            let covered = 100.0 * quality.coverage;
            format!("{} flips, stretch {:.3}, {covered:.0} % covered", quality.flips, quality.l2)
        });
        let fault = decal.fault().map(str::to_owned);
        let mut removed = None;
        for pin in 0..count {
            ui.horizontal(|ui| {
                let name = format!("pin {}", pin + 1);
                let response = ui.selectable_label(selected == Some(pin), &name);
                if self.clicked(&name, &response) {
                    session.select_pin(Some(pin));
                }
                let response = ui.small_button("x").on_hover_text("Remove. Key: Delete");
                if self.clicked(&format!("remove {name}"), &response) {
                    removed = Some(pin);
                }
            });
        }
        if let Some(quality) = quality {
            ui.label(quality)
                .on_hover_text("Triangles turned over, the mean stretch, the share of the image on the surface");
            ui.horizontal(|ui| {
                if self.button(ui, "Write decal") {
                    let done = session.write_decal().map(|()| String::new());
                    self.report(session, done);
                }
                if self.button(ui, "Drop decal") {
                    session.drop_decal();
                }
            });
        }
        if let Some(fault) = fault {
            ui.colored_label(FAULT, fault);
        }
        if let Some(pin) = removed {
            let done = session.remove_pin(pin).map(|()| String::new());
            self.report(session, done);
        }
    }

    fn ask_for(&mut self, ui: &mut Ui, what: Opened) {
        let response = ui.button(what.title()).on_hover_text(what.hint());
        if self.clicked(what.title(), &response) {
            self.opening = Some((what, String::new()));
        }
    }

    /// Opens a file that was dropped on the window: an image or a mesh, by the ending of its name.
    pub(super) fn take_dropped(&mut self, ui: &Ui, session: &mut Session) {
        let dropped = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        let Some(path) = dropped else { return };
        let is_image = path
            .extension()
            .is_some_and(|extension| ["png", "exr"].iter().any(|image| extension.eq_ignore_ascii_case(image)));
        let what = match (is_image, session.brush.tool) {
            (true, Tool::Decal) => Opened::Decal,
            (true, _) => Opened::Stamp,
            (false, _) => Opened::Tool,
        };
        self.open(session, what, &path);
    }

    fn open(&mut self, session: &mut Session, what: Opened, path: &Path) {
        let done: Result<String> = match what {
            Opened::Tool => session.open_tool(path).map(|()| {
                session.brush.tool = Tool::Press;
                format!("{} is the tool", path.display())
            }),
            Opened::Decal => session.open_decal(path).map(|()| {
                session.brush.tool = Tool::Decal;
                String::new()
            }),
            Opened::Stamp => session.open_stamp(path).map(|()| format!("{} is the stamp of the brush", path.display())),
        };
        self.report(session, done);
    }

    /// Asks for the name of a file.
    pub(super) fn asked_file(&mut self, ui: &mut Ui, session: &mut Session) {
        let Some((what, mut name)) = self.opening.take() else { return };
        let mut goes_on = true;
        let window = egui::Window::new(what.title()).collapsible(false).resizable(false);
        window.anchor(egui::Align2::CENTER_CENTER, [0.0; 2]).show(ui.ctx(), |ui| {
            ui.label(what.hint());
            let response = ui.add(TextEdit::singleline(&mut name).desired_width(420.0));
            response.request_focus();
            self.clicked("file to open", &response);
            ui.horizontal(|ui| {
                if self.button(ui, "Open") || ui.input(|input| input.key_pressed(Key::Enter)) {
                    goes_on = false;
                    self.open(session, what, &PathBuf::from(name.trim()));
                }
                if self.button(ui, "Cancel") {
                    goes_on = false;
                }
            });
        });
        if goes_on {
            self.opening = Some((what, name));
        }
    }
}
