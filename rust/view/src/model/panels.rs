//! The panels around the view: files and edits above, the brush at the left, layers, history and costs at the right.

mod files;

use std::collections::BTreeMap;
use std::path::PathBuf;

use egui::{Color32, Key, Modifiers, Rect, Response, Slider, TextEdit, Ui};
use relievo_core::{Falloff, Result};
use relievo_detail::{LayerInfo, PaintMode, SculptMode};
use relievo_document::Settings;

use super::brush::{Brush, Tool};
use super::costs::STAGES;
use super::session::Session;
use super::triangles::Shades;
use super::viewport::Viewport;
use files::Opened;

const FAULT: Color32 = Color32::from_rgb(240, 150, 90);

/// The state of the panels, and where their widgets were drawn last.
#[derive(Default)]
pub(crate) struct Panels {
    widgets: BTreeMap<String, Rect>,
    /// The name to save under, while it is asked for.
    saving: Option<String>,
    /// The file to open, and as what, while it is asked for.
    opening: Option<(Opened, String)>,
    /// The layer that is renamed, and its name so far.
    renaming: Option<(u32, String)>,
    /// The opacity that is being set, and of which layer.
    opacity: Option<(u32, f32)>,
    status: String,
    asks_to_close: bool,
    closes: bool,
}

/// What is asked of the layers in a frame.
enum Wish {
    Activate,
    Set(Settings),
    Rename(String),
    Shift(bool),
    Remove,
}

impl Panels {
    /// Returns where the widget of a name was drawn last, in points.
    pub(crate) fn widget(&self, name: &str) -> Option<Rect> {
        self.widgets.get(name).copied()
    }

    /// Asks whether the window may close, which a session with unsaved work has to confirm.
    pub(crate) fn close(&mut self, session: &Session) {
        if session.is_unsaved() {
            self.asks_to_close = true;
        } else {
            self.closes = true;
        }
    }

    /// Whether the window is to close.
    pub(crate) fn closes(&self) -> bool {
        self.closes
    }

    /// Lays everything out and acts on what the user does.
    pub(crate) fn show(&mut self, ui: &mut Ui, session: &mut Session, viewport: &mut Viewport) {
        self.widgets.clear();
        egui::Panel::top("bar").show(ui, |ui| self.bar(ui, session, viewport));
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui, session, viewport));
        egui::Panel::left("brush").default_size(190.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| self.brush(ui, session));
        });
        egui::Panel::right("layers").default_size(250.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                self.layers(ui, session);
                ui.separator();
                self.shades(ui, session);
                ui.separator();
                self.history(ui, session);
                ui.separator();
                costs(ui, session);
            });
        });
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| viewport.show(ui, session));
        self.questions(ui, session);
    }

    /// Notes the place of a widget, and returns whether it was clicked.
    fn clicked(&mut self, name: &str, response: &Response) -> bool {
        self.widgets.insert(name.to_owned(), response.rect);
        response.clicked()
    }

    fn button(&mut self, ui: &mut Ui, name: &str) -> bool {
        let response = ui.button(name);
        self.clicked(name, &response)
    }

    fn report(&mut self, session: &mut Session, done: Result<String>) {
        match done {
            Ok(status) => (session.message, self.status) = (None, status),
            Err(error) => session.message = Some(error.to_string()),
        }
    }

    fn save(&mut self, session: &mut Session) {
        let done = session.save().map(|path| format!("saved {}", path.display()));
        self.report(session, done);
    }

    fn bar(&mut self, ui: &mut Ui, session: &mut Session, viewport: &mut Viewport) {
        let control = |key| move |input: &mut egui::InputState| input.consume_key(Modifiers::COMMAND, key);
        let both = Modifiers::COMMAND | Modifiers::SHIFT;
        let is_typing = ui.ctx().egui_wants_keyboard_input();
        let saves_as = ui.input_mut(|input| input.consume_key(both, Key::S));
        let saves = ui.input_mut(control(Key::S));
        // What has fewer keys would be taken for what has more.
        let redoes = !is_typing && ui.input_mut(|input| input.consume_key(both, Key::Z));
        let undoes = !is_typing && !redoes && ui.input_mut(control(Key::Z));
        ui.horizontal(|ui| {
            if self.button(ui, "Save") || saves {
                self.save(session);
            }
            if self.button(ui, "Save as") || saves_as {
                self.saving = Some(session.document().display().to_string());
            }
            ui.separator();
            if self.button(ui, "Undo") || undoes {
                let done = session.undo().map(|()| String::new());
                self.report(session, done);
            }
            if self.button(ui, "Redo") || redoes {
                let done = session.redo().map(|()| String::new());
                self.report(session, done);
            }
            ui.separator();
            if self.button(ui, "Fit") {
                viewport.fit();
            }
            let wire = ui.checkbox(&mut viewport.is_wired, "faces").on_hover_text("Borders of faces. Key: W");
            self.clicked("faces", &wire);
            let rays = ui.checkbox(&mut viewport.rays.is_on, "rays").on_hover_text(
                "The ray caster's picture, with shadows and the light of a sky, once the hand rests. Key: R",
            );
            self.clicked("rays", &rays);
            let mut is_parallel = viewport.camera.is_parallel();
            if ui.checkbox(&mut is_parallel, "parallel").on_hover_text("Without perspective. Key: 5").changed() {
                viewport.camera.toggle_projection();
            }
            ui.separator();
            ui.label(format!("{} faces, {} triangles", session.face_count(), session.triangle_count()));
            if session.is_unsaved() {
                ui.colored_label(FAULT, "not saved");
            }
        });
    }

    fn status(&mut self, ui: &mut Ui, session: &mut Session, viewport: &Viewport) {
        match &session.message {
            Some(message) => ui.colored_label(FAULT, message),
            None if !self.status.is_empty() => ui.label(&self.status),
            None => ui.label(viewport.hint(session)),
        };
    }

    fn brush(&mut self, ui: &mut Ui, session: &mut Session) {
        let is_bendable = session.is_bendable();
        ui.strong("Sculpt");
        ui.horizontal_wrapped(|ui| {
            for (mode, name) in SculptMode::NAMES {
                if mode.needs_vectors() && !is_bendable {
                    continue;
                }
                let response = ui.selectable_label(session.brush.tool == Tool::Sculpt(mode), name);
                if self.clicked(name, &response) {
                    session.brush.tool = Tool::Sculpt(mode);
                }
            }
        });
        ui.separator();
        ui.strong("Paint");
        ui.horizontal_wrapped(|ui| {
            for (mode, name) in PaintMode::NAMES {
                let response = ui.selectable_label(session.brush.tool == Tool::Paint(mode), name);
                if self.clicked(&format!("paint {name}"), &response) {
                    session.brush.tool = Tool::Paint(mode);
                }
            }
        });
        ui.separator();
        self.tool(ui, session);
        self.stamp(ui, session);
        self.decal(ui, session);
        self.take_dropped(ui, session);
        ui.separator();
        let color = ui.horizontal(|ui| {
            ui.label("colour");
            ui.color_edit_button_rgb(&mut session.brush.color)
        });
        self.clicked("colour", &color.inner);
        ui.separator();
        let bounds = session.bounds();
        let radii = Brush::radii((bounds[1] - bounds[0]).length().max(1e-6));
        let brush = &mut session.brush;
        ui.label("size");
        ui.add(Slider::new(&mut brush.radius, radii).logarithmic(true)).on_hover_text("Radius, world units. Key: F");
        ui.label("strength");
        ui.add(Slider::new(&mut brush.strength, 0.0..=1.0)).on_hover_text("Key: Shift+F");
        ui.label("height");
        ui.add(Slider::new(&mut brush.height, 0.01..=1.0)).on_hover_text("What a dab adds, as a share of the size");
        egui::ComboBox::from_label("falloff")
            .selected_text(Falloff::NAMES.iter().find(|(it, _)| *it == brush.falloff).map_or("", |it| it.1))
            .show_ui(ui, |ui| {
                for (falloff, name) in Falloff::NAMES {
                    ui.selectable_value(&mut brush.falloff, falloff, name);
                }
            });
        let symmetry = ui.checkbox(&mut brush.symmetry, "x symmetry").on_hover_text("Key: X");
        self.clicked("x symmetry", &symmetry);
    }

    /// Shows what colours can stand for.
    fn shades(&mut self, ui: &mut Ui, session: &mut Session) {
        ui.strong("Colours show");
        ui.horizontal_wrapped(|ui| {
            for (shades, name) in Shades::NAMES {
                let response = ui.selectable_label(session.shades() == shades, name);
                if self.clicked(&format!("show {name}"), &response) {
                    session.set_shades(shades);
                }
            }
        });
    }

    fn layers(&mut self, ui: &mut Ui, session: &mut Session) {
        let layers = session.layers();
        let mut wish = None;
        for (is_color, heading) in [(true, "Colour"), (false, "Relief")] {
            ui.horizontal(|ui| {
                ui.strong(heading);
                let response = ui.small_button("+").on_hover_text("Add a layer");
                if self.clicked(&format!("add {}", heading.to_lowercase()), &response) {
                    let done = session.add_layer(is_color).map(|()| String::new());
                    self.report(session, done);
                }
            });
            // The highest is at the top, as in other programs.
            for layer in layers.iter().rev().filter(|layer| layer.kind.is_color() == is_color) {
                if let Some(asked) = self.layer(ui, layer) {
                    wish = Some((layer, asked));
                }
            }
        }
        let Some((layer, wish)) = wish else { return };
        let done = match wish {
            Wish::Activate => session.activate_layer(layer),
            Wish::Set(settings) => session.set_layer(layer, settings),
            Wish::Rename(name) => session.rename_layer(layer, &name),
            Wish::Shift(is_up) => session.shift_layer(layer, is_up),
            Wish::Remove => session.remove_layer(layer),
        };
        self.report(session, done.map(|()| String::new()));
    }

    /// Shows a layer, and returns what is asked of it.
    fn layer(&mut self, ui: &mut Ui, layer: &LayerInfo) -> Option<Wish> {
        let mut wish = None;
        let settings = layer.settings;
        ui.horizontal(|ui| {
            let mut visible = settings.visible;
            let eye = ui.checkbox(&mut visible, "").on_hover_text("Show or hide");
            if self.clicked(&format!("eye {}", layer.name), &eye) {
                wish = Some(Wish::Set(Settings { visible, ..settings }));
            }
            match &mut self.renaming {
                Some((id, name)) if *id == layer.id => {
                    let response = ui.add(TextEdit::singleline(name).desired_width(110.0));
                    response.request_focus();
                    if ui.input(|input| input.key_pressed(Key::Enter)) {
                        wish = Some(Wish::Rename(name.clone()));
                        self.renaming = None;
                    } else if ui.input(|input| input.key_pressed(Key::Escape)) || response.clicked_elsewhere() {
                        self.renaming = None;
                    }
                }
                _ => {
                    let name = ui
                        .selectable_label(layer.active, &layer.name)
                        .on_hover_text(format!("{} faces. Click: edits go here. Double click: rename", layer.tiles));
                    if self.clicked(&layer.name, &name) && !layer.active {
                        wish = Some(Wish::Activate);
                    }
                    if name.double_clicked() {
                        self.renaming = Some((layer.id, layer.name.clone()));
                    }
                }
            }
            for (text, asked, hint) in [
                ("up", Wish::Shift(true), "Higher"),
                ("down", Wish::Shift(false), "Lower"),
                ("x", Wish::Remove, "Remove"),
            ] {
                let response = ui.small_button(text).on_hover_text(hint);
                if self.clicked(&format!("{} {}", hint.to_lowercase(), layer.name), &response) {
                    wish = Some(asked);
                }
            }
        });
        let mut opacity = self.opacity.filter(|(id, _)| *id == layer.id).map_or(settings.opacity, |it| it.1);
        let response = ui.add(Slider::new(&mut opacity, 0.0..=1.0).text("opacity"));
        // A drag of the slider is one edit.
        if response.dragged() {
            self.opacity = Some((layer.id, opacity));
        } else if response.changed() || response.drag_stopped() {
            self.opacity = None;
            wish = Some(Wish::Set(Settings { opacity, ..settings }));
        }
        self.clicked(&format!("opacity {}", layer.name), &response);
        wish
    }

    fn history(&mut self, ui: &mut Ui, session: &mut Session) {
        ui.strong("History");
        let (labels, done) = session.edits();
        let mut asked = None;
        let first = labels.len().saturating_sub(40);
        if self.step(ui, "opened", 0, done) {
            asked = Some(0);
        }
        for (at, label) in labels.iter().enumerate().skip(first) {
            if self.step(ui, &format!("{} {label}", at + 1), at + 1, done) {
                asked = Some(at + 1);
            }
        }
        if let Some(count) = asked {
            let done = session.go_to(count).map(|()| String::new());
            self.report(session, done);
        }
    }

    /// Shows an edit, grey if it is undone, and returns whether it was clicked.
    fn step(&mut self, ui: &mut Ui, text: &str, at: usize, done: usize) -> bool {
        let shown = egui::RichText::new(text);
        let shown = if at > done { shown.weak() } else { shown };
        let response = ui.selectable_label(at == done, shown);
        self.clicked(&format!("edit {at}"), &response)
    }

    /// Asks what has to be answered before work goes on.
    fn questions(&mut self, ui: &mut Ui, session: &mut Session) {
        let window = |title: &'static str| {
            egui::Window::new(title).collapsible(false).resizable(false).anchor(egui::Align2::CENTER_CENTER, [0.0; 2])
        };
        if let Some(mut name) = self.saving.take() {
            let mut goes_on = true;
            window("Save as").show(ui.ctx(), |ui| {
                let response = ui.add(TextEdit::singleline(&mut name).desired_width(420.0));
                self.clicked("name of the file", &response);
                let enters = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                ui.horizontal(|ui| {
                    if self.button(ui, "Write") || enters {
                        goes_on = false;
                        let done = session.save_as(&PathBuf::from(&name));
                        let done = done.map(|path| format!("saved {}", path.display()));
                        self.report(session, done);
                    }
                    if self.button(ui, "Cancel") {
                        goes_on = false;
                    }
                });
            });
            self.saving = goes_on.then_some(name);
        }
        self.asked_file(ui, session);
        if session.recoverable().is_some() {
            window("Recover").show(ui.ctx(), |ui| {
                ui.label("The last session ended without saving. Its edits are there.");
                ui.horizontal(|ui| {
                    if self.button(ui, "Take them up") {
                        let done = session.recover().map(|()| String::new());
                        self.report(session, done);
                    }
                    if self.button(ui, "Throw them away") {
                        session.discard();
                    }
                });
            });
        }
        if self.asks_to_close {
            window("Close").show(ui.ctx(), |ui| {
                ui.label("There are edits that are not saved.");
                ui.horizontal(|ui| {
                    if self.button(ui, "Save and close") {
                        self.save(session);
                        (self.closes, self.asks_to_close) = (!session.is_unsaved(), false);
                    }
                    if self.button(ui, "Close without saving") {
                        session.discard();
                        self.closes = true;
                    }
                    if self.button(ui, "Stay") {
                        self.asks_to_close = false;
                    }
                });
            });
        }
    }
}

/// Shows what the last brush event cost, stage by stage, and what other work did.
fn costs(ui: &mut Ui, session: &Session) {
    ui.strong("Cost");
    egui::Grid::new("costs").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, time: f32| {
            ui.label(name);
            ui.label(format!("{time:.2} ms"));
            ui.end_row();
        };
        if let Some(last) = session.costs.last() {
            row("brush event", last.iter().sum());
            STAGES.iter().zip(last).for_each(|(name, time)| row(&format!("   {name}"), time));
        }
        session.costs.others.iter().for_each(|(name, time)| row(name, *time));
    });
}
