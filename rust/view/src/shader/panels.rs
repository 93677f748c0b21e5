//! The panels of the window: the text of the shader at the left, the picture in the middle, what the vectors say at the right.

use std::collections::BTreeMap;

use egui::{Color32, Key, Modifiers, Pos2, Rect, Sense, Stroke, TextureHandle, Ui, Vec2, pos2};
use relievo_core::Result;
use relievo_render::Image;
use relievo_render::color::srgb_byte;
use relievo_shaderlab::{Class, Value, Variable};

use super::plots::{ASKED, Linked, NEGATIVE, POSITIVE, matrix};
use super::profiles::profiles;
use super::session::Session;

/// Seconds without a key after which the text is compiled.
const PAUSE: f64 = 0.4;

/// What the right panel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tab {
    Variables,
    Plots,
    Diagnosis,
}

/// The state of the panels, and where their widgets were drawn last.
#[derive(Default)]
pub struct Panels {
    tab: Option<Tab>,
    chosen: Vec<usize>,
    weight: String,
    linked: Linked,
    texture: Option<TextureHandle>,
    /// Time of the last change of the text that is not compiled yet.
    edited: Option<f64>,
    /// The pixel that was clicked last.
    pointed: Option<[u32; 2]>,
    /// Where the picture is, in points.
    picture: Option<Rect>,
    widgets: BTreeMap<String, Rect>,
    plots: BTreeMap<[usize; 2], Rect>,
    status: String,
    asks_to_close: bool,
    closes: bool,
}

impl std::fmt::Debug for Panels {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Panels").field("tab", &self.tab).finish_non_exhaustive()
    }
}

impl Panels {
    /// Makes the panels of a session.
    pub fn new(context: &egui::Context, session: &Session) -> Self {
        context.set_theme(egui::Theme::Dark);
        let mut panels = Self { weight: "1.0".into(), ..Self::default() };
        panels.show_picture(context, session);
        panels
    }

    /// Returns the middle of a pixel of the picture in the window, in points.
    pub(crate) fn place(&self, pixel: [u32; 2], size: [u32; 2]) -> Option<Pos2> {
        let area = self.picture?;
        let share = |axis: usize| (pixel[axis] as f32 + 0.5) / size[axis] as f32;
        let is_inside = pixel.iter().zip(size).all(|(at, edge)| *at < edge);
        is_inside.then(|| pos2(area.left() + share(0) * area.width(), area.top() + share(1) * area.height()))
    }

    /// Returns where the widget of a name was drawn last, in points.
    pub(crate) fn widget(&self, name: &str) -> Option<Rect> {
        self.widgets.get(name).copied()
    }

    /// Returns where the plot of two features was drawn last, in points.
    pub(crate) fn plot(&self, axes: [usize; 2]) -> Option<Rect> {
        self.plots.get(&axes).copied()
    }

    /// Asks whether the window may close, which a session with unsaved work has to confirm.
    pub(crate) fn close(&mut self, session: &Session) {
        if session.is_changed() {
            self.asks_to_close = true;
        } else {
            self.closes = true;
        }
    }

    /// Returns whether the window is to close.
    pub(crate) fn closes(&self) -> bool {
        self.closes
    }

    /// Says that the text was replaced, so that it is compiled next.
    pub(crate) fn text_changed(&mut self) {
        self.edited = Some(f64::NEG_INFINITY);
    }

    fn report(&mut self, session: &mut Session, done: Result<String>) {
        match done {
            Ok(status) => {
                session.message = None;
                self.status = status;
            }
            Err(error) => session.message = Some(error.to_string()),
        }
    }

    fn show_picture(&mut self, context: &egui::Context, session: &Session) {
        let Some(picture) = session.picture() else { return };
        let image = shown(picture);
        match &mut self.texture {
            Some(texture) => texture.set(image, egui::TextureOptions::NEAREST),
            None => self.texture = Some(context.load_texture("picture", image, egui::TextureOptions::NEAREST)),
        }
    }

    /// Shows everything and acts on what the user does.
    pub fn show(&mut self, ui: &mut Ui, session: &mut Session) {
        self.widgets.clear();
        self.plots.clear();
        let now = ui.input(|input| input.time);
        if self.edited.is_some_and(|since| now - since >= PAUSE) {
            self.edited = None;
            session.compile();
            self.show_picture(ui.ctx(), session);
            self.chosen.clear();
        }
        if self.edited.is_some() {
            ui.ctx().request_repaint();
        }
        egui::Panel::top("bar").show(ui, |ui| self.bar(ui, session));
        egui::Panel::bottom("status").show(ui, |ui| {
            match &session.message {
                Some(message) => ui.colored_label(NEGATIVE, message),
                None => ui.label(&self.status),
            };
        });
        egui::Panel::left("text").default_size(360.0).show(ui, |ui| self.text(ui, session, now));
        egui::Panel::right("vectors").default_size(420.0).show(ui, |ui| self.vectors(ui, session));
        egui::CentralPanel::default().show(ui, |ui| self.pictures(ui, session));
        if self.asks_to_close {
            self.confirm(ui, session);
        }
    }

    /// Adds a button, notes its place, and returns whether it was pressed.
    fn button(&mut self, ui: &mut Ui, name: &str) -> bool {
        let response = ui.button(name);
        self.widgets.insert(name.to_owned(), response.rect);
        response.clicked()
    }

    fn bar(&mut self, ui: &mut Ui, session: &mut Session) {
        // Letters belong to the text while it has the focus.
        let is_typing = ui.ctx().egui_wants_keyboard_input();
        let saves = ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::S))
            || !is_typing && ui.input(|input| input.key_pressed(Key::S) && input.modifiers.is_none());
        ui.horizontal(|ui| {
            if self.button(ui, "Save project") || saves {
                let done = session.save().map(|path| format!("saved {}", path.display()));
                self.report(session, done);
            }
            if self.button(ui, "Save picture") {
                let path = session.stem().with_extension("png");
                let done = session.save_picture(&path).map(|()| format!("saved {}", path.display()));
                self.report(session, done);
            }
            if self.button(ui, "Save mask") {
                let mut name = session.stem().into_os_string();
                name.push("_mask.png");
                let path = std::path::PathBuf::from(name);
                let done = session.save_mask(&path).map(|()| format!("saved {}", path.display()));
                self.report(session, done);
            }
            if let Some(classes) = session.classes() {
                let (mut exponent, mut is_scaled) = (classes.exponent, classes.is_scaled);
                let slider = egui::Slider::new(&mut exponent, 0.5..=16.0).logarithmic(true).text("exponent");
                let weighed = ui.add(slider).changed();
                let scaled = ui.checkbox(&mut is_scaled, "scaled");
                self.widgets.insert("scaled".into(), scaled.rect);
                if weighed || scaled.changed() {
                    session.weigh(exponent, is_scaled);
                    self.show_picture(ui.ctx(), session);
                }
            }
            if session.is_changed() {
                ui.label("not saved");
            }
        });
    }

    fn text(&mut self, ui: &mut Ui, session: &mut Session, now: f64) {
        let lines: Vec<usize> = session.notes.iter().map(|note| note.line).collect();
        let room = ui.available_height() - 26.0 * session.notes.len().min(4) as f32 - 8.0;
        egui::ScrollArea::both().id_salt("text").max_height(room).show(ui, |ui| {
            let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| {
                let mut job = egui::text::LayoutJob::default();
                let font = egui::FontId::monospace(12.0);
                for (index, line) in text.as_str().split_inclusive('\n').enumerate() {
                    let mut format = egui::TextFormat { font_id: font.clone(), ..Default::default() };
                    let start = line.trim_start();
                    format.color = match start.starts_with("//") {
                        true if start[2..].trim_start().starts_with('.') => ASKED,
                        true => Color32::GRAY,
                        false => Color32::LIGHT_GRAY,
                    };
                    if lines.contains(&(index + 1)) {
                        format.background = Color32::from_rgb(110, 30, 20);
                    }
                    job.append(line, 0.0, format);
                }
                ui.fonts_mut(|fonts| fonts.layout_job(job))
            };
            let edit = egui::TextEdit::multiline(&mut session.text).code_editor().desired_width(f32::INFINITY);
            let response = ui.add(edit.layouter(&mut layout));
            self.widgets.insert("text".into(), response.rect.intersect(ui.clip_rect()));
            if response.changed() {
                self.edited = Some(now);
            }
        });
        for note in session.notes.iter().take(4) {
            ui.colored_label(NEGATIVE, format!("line {}: {}", note.line, note.what));
        }
    }

    fn pictures(&mut self, ui: &mut Ui, session: &mut Session) {
        let Some(texture) = &self.texture else {
            ui.label("There is no picture yet: the shader has faults.");
            return;
        };
        let [width, height] = session.size().map(|edge| edge as f32);
        let room = ui.available_size();
        let scale = (room.x / width).min((room.y - 24.0) / height);
        // Whole multiples show pixels as squares of one size.
        let scale = if scale >= 1.0 { scale.floor() } else { scale.max(0.05) };
        let (area, response) = ui.allocate_exact_size(Vec2::new(width, height) * scale, Sense::click());
        self.picture = Some(area);
        let painter = ui.painter_at(area.expand(8.0));
        painter.rect_filled(area, 0.0, Color32::BLACK);
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(texture.id(), area, whole, Color32::WHITE);
        let place = |[x, y]: [u32; 2]| area.min + Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * scale;
        for example in session.examples() {
            let (fill, at) = match example.class {
                Class::Positive => (POSITIVE, place(example.pixel)),
                Class::Negative => (NEGATIVE, place(example.pixel)),
            };
            let found =
                session.classes().and_then(|it| it.examples.iter().position(|other| other.pixel == example.pixel));
            let is_marked = found.is_some_and(|index| {
                let vector = session.classes().map_or(&[][..], |classes| &classes.examples[index].vector);
                self.linked.picked == Some(index) || self.linked.contains(vector)
            });
            painter.circle_stroke(at, 7.0, Stroke::new(4.0, if is_marked { Color32::YELLOW } else { Color32::BLACK }));
            painter.circle_stroke(at, 7.0, Stroke::new(2.5, fill));
        }
        if let Some(asked) = &session.asked {
            painter.circle_stroke(place(asked.pixel), 5.0, Stroke::new(2.0, ASKED));
        }
        ui.label("Left: positive. Right: negative. Middle: why. On an example with Shift: remove it.");
        let Some(at) = response.interact_pointer_pos() else { return };
        let [columns, rows] = session.size();
        let from = (at - area.min) / scale;
        let pixel = [(from.x as u32).min(columns - 1), (from.y as u32).min(rows - 1)];
        if response.clicked() || response.secondary_clicked() || response.middle_clicked() {
            self.pointed = Some(pixel);
        }
        let is_shift = ui.input(|input| input.modifiers.shift);
        let class = match (response.clicked(), response.secondary_clicked()) {
            (true, _) => Some(Class::Positive),
            (_, true) => Some(Class::Negative),
            _ => None,
        };
        if is_shift && class.is_some() {
            let near = |other: &[u32; 2]| place(*other).distance(at) <= 8.0;
            if let Some(pixel) = session.examples().iter().map(|example| example.pixel).find(near) {
                session.remove(pixel);
                self.linked.picked = None;
            }
        } else if let Some(class) = class {
            let done = session.classify(pixel, class).map(|()| String::new());
            self.report(session, done);
        } else if response.middle_clicked() {
            let done = session.ask(pixel).map(|()| String::new());
            self.report(session, done);
            self.tab = Some(Tab::Diagnosis);
        } else {
            return;
        }
        self.show_picture(ui.ctx(), session);
        ui.ctx().request_repaint();
    }

    fn vectors(&mut self, ui: &mut Ui, session: &mut Session) {
        let mut tab = self.tab.unwrap_or(if session.features().is_empty() { Tab::Variables } else { Tab::Plots });
        ui.horizontal(|ui| {
            for (name, other) in [("Variables", Tab::Variables), ("Plots", Tab::Plots), ("Diagnosis", Tab::Diagnosis)] {
                let response = ui.selectable_label(tab == other, name);
                self.widgets.insert(name.to_owned(), response.rect);
                if response.clicked() {
                    tab = other;
                    self.tab = Some(other);
                }
            }
        });
        ui.separator();
        egui::ScrollArea::both().id_salt("vectors").auto_shrink(false).show(ui, |ui| match tab {
            Tab::Variables => self.variables(ui, session),
            Tab::Plots => {
                let Self { linked, plots, widgets, .. } = self;
                matrix(ui, session, linked, &mut |axes, area| {
                    plots.insert(axes, area);
                });
                profiles(ui, session, linked, &mut |name, area| {
                    widgets.insert(format!("profile {name}"), area);
                });
            }
            Tab::Diagnosis => diagnosis(ui, session),
        });
    }

    /// Shows the float variables, from which a vector is chosen and written into the text (Section 4.2).
    fn variables(&mut self, ui: &mut Ui, session: &mut Session) {
        let Some(shader) = session.shader() else {
            ui.label("The shader has faults.");
            return;
        };
        let variables = shader.variables();
        egui::Grid::new("variables").num_columns(5).striped(true).show(ui, |ui| {
            for (index, variable) in variables.iter().enumerate() {
                let line = shader.line(variable);
                let mut is_chosen = self.chosen.contains(&index);
                let name = variable.label.as_ref().unwrap_or(&variable.name);
                let response = ui.checkbox(&mut is_chosen, name);
                self.widgets.insert(format!("{}@{line}", variable.name), response.rect);
                if response.changed() {
                    self.chosen.retain(|other| *other != index);
                    if is_chosen {
                        self.chosen.push(index);
                    }
                }
                ui.label(type_name(variable));
                ui.label(format!("line {line}, {}", variable.function.as_deref().unwrap_or("global")));
                if let Some(value) = session.values.as_ref().and_then(|values| values.list.get(index)) {
                    show_value(ui, value);
                }
                ui.label(variable.description.as_deref().unwrap_or(""));
                ui.end_row();
            }
        });
        ui.horizontal(|ui| {
            let pressed = ui.add_enabled_ui(self.pointed.is_some(), |ui| self.button(ui, "Values")).inner;
            if let Some(pixel) = self.pointed.filter(|_| pressed) {
                let done = session.look(pixel).map(|()| String::new());
                self.report(session, done);
            }
            ui.label(match (&session.values, self.pointed) {
                (Some(values), _) => format!("at {}, {}", values.pixel[0], values.pixel[1]),
                (None, Some([x, y])) => format!("of {x}, {y}, the pixel clicked last"),
                (None, None) => "of a pixel: click it in the picture first".into(),
            });
        });
        ui.horizontal(|ui| {
            ui.label("Weight");
            ui.add(egui::TextEdit::singleline(&mut self.weight).desired_width(160.0));
        });
        if self.button(ui, "Write vector") {
            let chosen = std::mem::take(&mut self.chosen);
            session.mark(&chosen, &self.weight);
            self.show_picture(ui.ctx(), session);
        }
    }

    fn confirm(&mut self, ui: &mut Ui, session: &mut Session) {
        egui::Modal::new(egui::Id::unique("close")).show(ui.ctx(), |ui| {
            ui.label("The project is not saved.");
            ui.horizontal(|ui| {
                if self.button(ui, "Save and close") {
                    let done = session.save().map(|path| format!("saved {}", path.display()));
                    self.closes = done.is_ok();
                    self.asks_to_close = false;
                    self.report(session, done);
                }
                if self.button(ui, "Discard") {
                    self.closes = true;
                }
                if self.button(ui, "Go on") {
                    self.asks_to_close = false;
                }
            });
        });
    }
}

/// Shows the value of a variable, and under the pointer its range or why there is none.
fn show_value(ui: &mut Ui, value: &Result<Value>) {
    let numbers = |list: &[f32]| list.iter().map(|value| format!("{value:.4}")).collect::<Vec<_>>().join(", ");
    match value {
        Ok(Value { taken, mean, low, high }) => {
            let range = format!("mean of {taken}, from {} to {}", numbers(low), numbers(high));
            ui.label(numbers(mean)).on_hover_text(range);
        }
        Err(error) => drop(ui.weak("none").on_hover_text(&*error.what)),
    }
}

fn type_name(variable: &Variable) -> String {
    if variable.components == 1 { "float".into() } else { format!("{} floats", variable.components) }
}

/// Shows what the features are worth, and why the pixel asked about has its membership.
fn diagnosis(ui: &mut Ui, session: &Session) {
    let (Some(classes), Some(diagnosis)) = (session.classes(), &session.diagnosis) else {
        ui.label("The shader takes no vector. Choose variables and write one.");
        return;
    };
    let names = session.features();
    let name = |feature: usize| names.get(feature).map_or("", String::as_str);
    match diagnosis.error {
        Some(error) => ui.label(format!("Leave-one-out error: {:.1} %", 100.0 * error)),
        None => ui.label("Leave-one-out error: needs two examples of each class"),
    };
    for (feature, error) in diagnosis.errors_without.iter().enumerate() {
        ui.label(format!("    without {}: {:.1} %", name(feature), 100.0 * error));
    }
    for pair in &diagnosis.correlations {
        let [first, second] = pair.features.map(name);
        ui.label(format!("Correlated: {first} and {second}, {:.3}", pair.coefficient));
    }
    if let Some(feature) = diagnosis.redundant {
        ui.label(format!("Can be left out: {}", name(feature)));
    }
    ui.separator();
    let Some(asked) = &session.asked else {
        ui.label("Click a pixel with the middle button to see why it has its membership.");
        return;
    };
    let [x, y] = asked.pixel;
    ui.label(format!("Pixel {x}, {y}: membership {:.4}, {} vectors", asked.explanation.membership, asked.log.taken));
    for (feature, value) in asked.log.vector.iter().enumerate() {
        ui.label(format!("    {}: {value:.5}", name(feature)));
    }
    for neighbour in asked.explanation.neighbours.iter().take(5) {
        let Some(example) = classes.examples.get(neighbour.example) else { continue };
        let [x, y] = example.pixel;
        let (class, fill) = match example.class {
            Class::Positive => ("positive", POSITIVE),
            Class::Negative => ("negative", NEGATIVE),
        };
        let share = 100.0 * neighbour.share;
        ui.colored_label(
            fill,
            format!("{class} {x}, {y}: distance {:.5}, {share:.1} % of the weight", neighbour.distance),
        );
    }
    if let Some(feature) = asked.explanation.deciding {
        ui.label(format!("Decided by: {}", name(feature)));
    }
}

/// Returns a picture as the window shows it: sRGB, one channel as grey, transparent pixels over black.
fn shown(picture: &Image) -> egui::ColorImage {
    let channels = picture.channels().max(1) as usize;
    let mut bytes = Vec::with_capacity(picture.data().len() / channels * 4);
    for pixel in picture.data().chunks_exact(channels) {
        let color = match pixel {
            [value] => [*value; 3],
            [x, y] => [*x, *y, 0.0],
            [r, g, b, ..] => [*r, *g, *b],
            [] => [0.0; 3],
        };
        let alpha = pixel.get(3).map_or(1.0, |alpha| alpha.clamp(0.0, 1.0));
        bytes.extend(color.map(srgb_byte));
        bytes.push((alpha * 255.0 + 0.5) as u8);
    }
    egui::ColorImage::from_rgba_unmultiplied([picture.width() as usize, picture.height() as usize], &bytes)
}
