//! The panels around the stage: the view above, settings and facts at the left, the clock below.

use std::collections::BTreeMap;
use std::path::PathBuf;

use egui::{Align2, Color32, Rect, Response, Slider, TextEdit, Ui};

use super::stage::Stage;
use super::{Range, Setting, Subject};
use crate::drawing::draw_legend;

const FAULT: Color32 = Color32::from_rgb(240, 150, 90);

/// The state of the panels, and where their widgets were drawn last.
#[derive(Default)]
pub(super) struct Panels {
    widgets: BTreeMap<String, Rect>,
    /// The folder to record in, while it is asked for.
    recording: Option<String>,
}

impl Panels {
    /// Returns where the widget of a name was drawn last, in points.
    pub fn widget(&self, name: &str) -> Option<Rect> {
        self.widgets.get(name).copied()
    }

    /// Lays everything out and acts on what the user does.
    pub fn show(&mut self, ui: &mut Ui, subject: &mut dyn Subject, stage: &mut Stage) {
        self.widgets.clear();
        egui::Panel::top("bar").show(ui, |ui| self.bar(ui, subject, stage));
        egui::Panel::bottom("clock").show(ui, |ui| self.clock(ui, subject, stage));
        egui::Panel::left("settings").default_size(230.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| self.settings(ui, stage));
        });
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            stage.show(ui, subject);
            legend(ui, stage);
        });
        self.question(ui, subject, stage);
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

    fn bar(&mut self, ui: &mut Ui, subject: &dyn Subject, stage: &mut Stage) {
        ui.horizontal(|ui| {
            if self.button(ui, "Fit") {
                stage.fit();
            }
            let wire = ui.checkbox(&mut stage.is_wired, "edges").on_hover_text("Edges of triangles. Key: W");
            self.clicked("edges", &wire);
            let mut is_parallel = stage.camera.is_parallel();
            let parallel = ui.checkbox(&mut is_parallel, "parallel").on_hover_text("Without perspective. Key: 5");
            if parallel.changed() {
                stage.camera.toggle_projection();
            }
            let rays = ui.checkbox(&mut stage.rays.is_on, "rays").on_hover_text(
                "The ray caster's picture, with shadows and the light of a sky, once the hand rests. Key: R",
            );
            self.clicked("rays", &rays);
            ui.separator();
            ui.label(subject.name());
        });
    }

    /// Lets the user bake the frames that are missing, and says how far that is.
    fn bake(&mut self, ui: &mut Ui, subject: &mut dyn Subject, stage: &mut Stage) {
        let values = stage.values();
        let Some(bake) = &stage.bake else { return };
        ui.horizontal(|ui| {
            let name = if bake.is_running { "Stop" } else { "Bake" };
            let hint = "Computes what is missing or was baked with other settings, and writes what the scene says";
            let has_work = bake.is_running || bake.has_more || bake.frames < stage.frames.count;
            let response = ui.add_enabled(has_work, egui::Button::new(name)).on_hover_text(hint);
            if self.clicked(name, &response) {
                match bake.is_running {
                    true => subject.stop_bake(),
                    false => subject.begin_bake(&values),
                }
                stage.follows = !bake.is_running;
            }
            if bake.is_running {
                let bar = egui::ProgressBar::new(bake.share).desired_width(160.0).show_percentage();
                ui.add(bar);
            }
            match bake.has_failed {
                true => ui.colored_label(FAULT, &bake.stage),
                false => ui.label(&bake.stage),
            };
        });
    }

    fn clock(&mut self, ui: &mut Ui, subject: &mut dyn Subject, stage: &mut Stage) {
        self.bake(ui, subject, stage);
        let last = stage.frames.count.saturating_sub(1);
        if last > 0 {
            ui.horizontal(|ui| {
                let name = if stage.is_playing { "Pause" } else { "Play" };
                let response = ui.button(name).on_hover_text("Key: space");
                if self.clicked(name, &response) {
                    stage.is_playing = !stage.is_playing;
                }
                if self.button(ui, "Record") {
                    self.recording = Some("frames".into());
                }
                ui.spacing_mut().slider_width = (ui.available_width() - 190.0).max(80.0);
                let slider = ui.add(Slider::new(&mut stage.frame, 0..=last)).on_hover_text("Keys: left, right");
                stage.follows &= !slider.changed();
                self.clicked("frame", &slider);
                ui.label(format!("{:.2} s", stage.frame as f64 / stage.frames.rate));
            });
        }
        match &stage.message {
            Some(message) => ui.colored_label(FAULT, message),
            None => ui.label("Left or middle button: turn (Shift moves, Ctrl zooms). Wheel: zoom. Home: all in view."),
        };
    }

    fn settings(&mut self, ui: &mut Ui, stage: &mut Stage) {
        for Setting { name, hint, range, value } in &mut stage.settings {
            match range {
                Range::Choice(names) => {
                    ui.strong(name.as_str()).on_hover_text(hint.as_str());
                    ui.horizontal_wrapped(|ui| {
                        for (at, option) in names.iter().enumerate() {
                            let response = ui.selectable_label(*value == at as f64, option.as_str());
                            if self.clicked(option, &response) {
                                *value = at as f64;
                            }
                        }
                    });
                }
                Range::Slider { least, most, is_logarithmic, is_whole } => {
                    ui.strong(name.as_str());
                    let slider = Slider::new(value, *least..=*most).logarithmic(*is_logarithmic);
                    let slider = if *is_whole { slider.integer() } else { slider };
                    let response = ui.add(slider).on_hover_text(hint.as_str());
                    self.clicked(name, &response);
                }
            }
            ui.separator();
        }
        for fact in &stage.picture.facts {
            ui.label(fact);
        }
        ui.separator();
        ui.strong("Cost");
        ui.label(format!("picture {:.2} ms", stage.cost));
    }

    /// Asks where to record.
    fn question(&mut self, ui: &mut Ui, subject: &dyn Subject, stage: &mut Stage) {
        let Some(mut folder) = self.recording.take() else { return };
        let mut goes_on = true;
        let window = egui::Window::new("Record").collapsible(false).resizable(false);
        window.anchor(Align2::CENTER_CENTER, [0.0; 2]).show(ui.ctx(), |ui| {
            ui.label(format!("All frames of {} as pictures, into the folder", subject.name()));
            let response = ui.add(TextEdit::singleline(&mut folder).desired_width(420.0));
            self.clicked("folder", &response);
            ui.horizontal(|ui| {
                if self.button(ui, "Write pictures") {
                    goes_on = false;
                    stage.begin_recording(PathBuf::from(&folder));
                }
                if self.button(ui, "Cancel") {
                    goes_on = false;
                }
            });
        });
        self.recording = goes_on.then_some(folder);
    }
}

/// Draws what colours stand for into a corner of the view.
fn legend(ui: &Ui, stage: &Stage) {
    let Some(area) = stage.area.filter(|_| !stage.picture.legend.is_empty()) else { return };
    draw_legend(ui, area, &stage.picture.legend);
}
