//! Profiles: each feature over the vectors that a pixel took one after the other, along a ray or through a loop
//! (Mindek et al. 2013, Section 4.3). Lines are linked with the scatter plots by picking and brushing.

use egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use relievo_shaderlab::Log;

use super::plots::{ASKED, BRUSH, Linked, color, framed, span, title};
use super::session::Session;

/// Points of the height of a plot.
const HEIGHT: f32 = 84.0;

/// The vectors of a pixel, in the order in which it took them.
struct Line<'a> {
    log: &'a Log,
    /// The example, or `None` for the pixel asked about.
    example: Option<usize>,
    fill: Color32,
}

/// Shows a plot for each feature, with a line for each example and for the pixel asked about, from the first vector at the left
/// to the last at the right. Shows nothing where no pixel took two vectors. Reports the place of each plot to `note`.
pub(crate) fn profiles(ui: &mut Ui, session: &Session, linked: &mut Linked, note: &mut dyn FnMut(&str, Rect)) {
    let names = session.features();
    let width = names.len();
    let examples = session.classes().map_or(&[][..], |classes| &classes.examples);
    let of_examples = session.logs.iter().zip(examples).enumerate().map(|(index, (log, example))| Line {
        log,
        example: Some(index),
        fill: color(Some(example.class)),
    });
    let asked = session.asked.iter().map(|asked| Line { log: &asked.log, example: None, fill: ASKED });
    let lines: Vec<Line> = of_examples.chain(asked).filter(|line| line.log.vectors.len() > width).collect();
    if lines.is_empty() {
        return;
    }
    ui.label("Profiles, from the first vector of a pixel to its last");
    for (feature, name) in names.iter().enumerate() {
        let (area, response) = ui.allocate_exact_size(vec2(ui.available_width().max(120.0), HEIGHT), Sense::click());
        note(name, area);
        let painter = framed(ui, area);
        let values = lines.iter().flat_map(|line| line.log.vectors.chunks_exact(width).map(|vector| vector[feature]));
        let [low, high] = span(values.filter(|value| value.is_finite()));
        let inner = area.shrink(6.0);
        let mut nearest: Option<(f32, usize)> = None;
        for line in &lines {
            let last = (line.log.vectors.len() / width - 1) as f32;
            let place = |index: usize, value: f32| {
                let share = (value - low) / (high - low);
                pos2(inner.left() + index as f32 / last * inner.width(), inner.bottom() - share * inner.height())
            };
            let vectors = || line.log.vectors.chunks_exact(width).enumerate().filter(|(_, it)| it[feature].is_finite());
            let points: Vec<Pos2> = vectors().map(|(index, vector)| place(index, vector[feature])).collect();
            if let (Some(example), Some(pointer)) = (line.example, response.interact_pointer_pos()) {
                let distance = points.iter().map(|at| at.distance(pointer)).fold(f32::INFINITY, f32::min);
                if nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, example));
                }
            }
            let is_picked = line.example.is_some() && line.example == linked.picked;
            painter.line(points, Stroke::new(if is_picked { 2.5 } else { 1.2 }, line.fill));
            for (index, vector) in vectors().filter(|(_, vector)| linked.contains(vector)) {
                painter.circle_filled(place(index, vector[feature]), 2.0, BRUSH);
            }
        }
        title(&painter, area, name);
        if response.clicked() {
            linked.picked = nearest.filter(|(distance, _)| *distance < 12.0).map(|(_, example)| example);
        }
    }
}
