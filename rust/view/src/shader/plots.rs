//! Scatter plots of all pairs of features, linked by picking and brushing, and histograms (Section 4.3, Figure 4).
//!
//! Large marks are the vectors of examples: green circles are positive, orange squares negative. Small dots are the single
//! vectors that the pixels of examples and the pixel asked about took.

use egui::{Color32, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
use relievo_shaderlab::Class;

use super::session::Session;

/// Colours of the positive class, the negative one, the pixel asked about, and the brush.
pub(crate) const POSITIVE: Color32 = Color32::from_rgb(0, 158, 115);
pub(crate) const NEGATIVE: Color32 = Color32::from_rgb(213, 94, 0);
pub(crate) const ASKED: Color32 = Color32::from_rgb(86, 180, 233);
pub(crate) const BRUSH: Color32 = Color32::from_rgb(240, 228, 66);

/// Bars of a histogram.
const BARS: usize = 32;

/// Dots that a plot draws at most; of more, every n-th is drawn.
const MAX_DOTS: usize = 4000;

/// What is picked and brushed in all plots.
#[derive(Debug, Default)]
pub(crate) struct Linked {
    /// The example that was picked.
    pub picked: Option<usize>,
    /// Two features with the lower and upper bound of each.
    pub brush: Option<([usize; 2], [[f32; 2]; 2])>,
    start: Option<([usize; 2], Pos2)>,
}

impl Linked {
    /// Returns whether a vector lies in the brush.
    pub fn contains(&self, vector: &[f32]) -> bool {
        self.brush.is_some_and(|(axes, ranges)| {
            axes.iter()
                .zip(ranges)
                .all(|(axis, [low, high])| vector.get(*axis).is_some_and(|it| (low..=high).contains(it)))
        })
    }
}

/// A single vector with the class of its pixel, or `None` for the pixel asked about.
struct Dot<'a> {
    class: Option<Class>,
    vector: &'a [f32],
}

pub(crate) fn color(class: Option<Class>) -> Color32 {
    match class {
        Some(Class::Positive) => POSITIVE,
        Some(Class::Negative) => NEGATIVE,
        None => ASKED,
    }
}

fn dots(session: &Session) -> Vec<Dot<'_>> {
    let Some(classes) = session.classes() else { return Vec::new() };
    let width = classes.features.len().max(1);
    let logs = session.logs.iter().zip(&classes.examples).map(|(log, example)| (Some(example.class), log));
    let logs = logs.chain(session.asked.iter().map(|asked| (None, &asked.log)));
    let all: Vec<_> = logs
        .flat_map(|(class, log)| log.vectors.chunks_exact(width).map(move |vector| Dot { class, vector }))
        .collect();
    let step = all.len().div_ceil(MAX_DOTS).max(1);
    all.into_iter().step_by(step).filter(|dot| dot.vector.iter().all(|value| value.is_finite())).collect()
}

/// Returns the range of a feature over examples and dots, never empty.
fn range(session: &Session, dots: &[Dot<'_>], feature: usize) -> [f32; 2] {
    let examples = session.classes().into_iter().flat_map(|classes| &classes.examples).map(|it| it.vector.as_slice());
    let values = examples.chain(dots.iter().map(|dot| dot.vector)).filter_map(|vector| vector.get(feature)).copied();
    span(values)
}

/// Returns the range of numbers, never empty.
pub(crate) fn span(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let [low, high] = values.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], it| [low.min(it), high.max(it)]);
    match (low.is_finite(), high > low) {
        (true, true) => [low, high],
        (true, false) => [low - 0.5, low + 0.5],
        (false, _) => [0.0, 1.0],
    }
}

/// Draws the background of a plot and returns what draws inside of it.
pub(crate) fn framed(ui: &Ui, area: Rect) -> egui::Painter {
    let painter = ui.painter_at(area);
    let frame = Stroke::new(1.0, Color32::from_gray(90));
    painter.rect(area, 0.0, Color32::from_gray(22), frame, StrokeKind::Inside);
    painter
}

/// Writes the name of a feature into the upper left corner of its plot.
pub(crate) fn title(painter: &egui::Painter, area: Rect, name: &str) {
    let font = egui::FontId::proportional(12.0);
    painter.text(area.left_top() + vec2(4.0, 2.0), egui::Align2::LEFT_TOP, name, font, Color32::WHITE);
}

/// Shows the matrix of plots; on its diagonal stand the histograms. Reports the place of each plot to `note`.
pub(crate) fn matrix(ui: &mut Ui, session: &Session, linked: &mut Linked, note: &mut dyn FnMut([usize; 2], Rect)) {
    let names = session.features();
    if names.is_empty() {
        ui.label("The shader takes no vector. Choose variables and write one.");
        return;
    }
    let dots = dots(session);
    let ranges: Vec<_> = (0..names.len()).map(|feature| range(session, &dots, feature)).collect();
    let gap = 6.0;
    let edge = ((ui.available_width() - gap * names.len() as f32) / names.len() as f32).clamp(60.0, 220.0);
    for row in 0..names.len() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(gap);
            for column in 0..names.len() {
                let (area, response) = ui.allocate_exact_size(Vec2::splat(edge), Sense::click_and_drag());
                let painter = framed(ui, area);
                if row == column {
                    histogram(&painter, area, &dots, session, row, ranges[row]);
                    title(&painter, area, &names[row]);
                    continue;
                }
                note([column, row], area);
                let axes = [column, row];
                let inner = area.shrink(6.0);
                let place = |vector: &[f32]| {
                    let share = |axis: usize| (vector[axis] - ranges[axis][0]) / (ranges[axis][1] - ranges[axis][0]);
                    pos2(inner.left() + share(column) * inner.width(), inner.bottom() - share(row) * inner.height())
                };
                if response.drag_started()
                    && let Some(at) = ui.input(|input| input.pointer.press_origin())
                {
                    linked.start = Some((axes, at));
                }
                if let Some((begun, start)) = linked.start
                    && begun == axes
                    && let Some(at) = response.interact_pointer_pos()
                {
                    let value = |axis: usize, at: Pos2| {
                        let share = match axis == column {
                            true => (at.x - inner.left()) / inner.width(),
                            false => (inner.bottom() - at.y) / inner.height(),
                        };
                        ranges[axis][0] + share * (ranges[axis][1] - ranges[axis][0])
                    };
                    let bounds = axes.map(|axis| {
                        let (a, b) = (value(axis, start), value(axis, at));
                        [a.min(b), a.max(b)]
                    });
                    linked.brush = Some((axes, bounds));
                }
                if response.drag_stopped() {
                    linked.start = None;
                }
                for dot in &dots {
                    let is_brushed = linked.contains(dot.vector);
                    let (radius, fill) =
                        if is_brushed { (2.5, BRUSH) } else { (1.2, color(dot.class).gamma_multiply(0.55)) };
                    painter.circle_filled(place(dot.vector), radius, fill);
                }
                let examples = session.classes().map_or(&[][..], |classes| &classes.examples);
                let mut nearest: Option<(f32, usize)> = None;
                for (index, example) in examples.iter().enumerate() {
                    let at = place(&example.vector);
                    let is_marked = linked.picked == Some(index) || linked.contains(&example.vector);
                    let outline = Stroke::new(2.0, if is_marked { BRUSH } else { Color32::WHITE });
                    match example.class {
                        Class::Positive => painter.circle(at, 5.0, POSITIVE, outline),
                        Class::Negative => {
                            let mark = Rect::from_center_size(at, Vec2::splat(9.0));
                            painter.rect(mark, 0.0, NEGATIVE, outline, StrokeKind::Middle)
                        }
                    };
                    let distance =
                        response.interact_pointer_pos().map_or(f32::INFINITY, |pointer| pointer.distance(at));
                    if nearest.is_none_or(|(least, _)| distance < least) {
                        nearest = Some((distance, index));
                    }
                }
                if response.clicked() {
                    linked.brush = None;
                    linked.picked = nearest.filter(|(distance, _)| *distance < 12.0).map(|(_, index)| index);
                }
                if let Some((brushed, [[left, right], [low, high]])) = linked.brush
                    && brushed == axes
                {
                    let mut corner = vec![0.0; names.len()];
                    (corner[column], corner[row]) = (left, low);
                    let first = place(&corner);
                    (corner[column], corner[row]) = (right, high);
                    let frame = Rect::from_two_pos(first, place(&corner));
                    painter.rect_stroke(frame, 0.0, Stroke::new(1.0, BRUSH), StrokeKind::Inside);
                }
            }
        });
    }
}

/// Draws how often the single vectors have values of a feature, a bar of each class beside the other.
fn histogram(
    painter: &egui::Painter,
    area: Rect,
    dots: &[Dot<'_>],
    session: &Session,
    feature: usize,
    range: [f32; 2],
) {
    let mut counts = [[0_u32; BARS]; 3];
    let examples = session.classes().into_iter().flat_map(|classes| &classes.examples);
    let examples = examples.map(|example| (Some(example.class), example.vector.as_slice()));
    for (class, vector) in dots.iter().map(|dot| (dot.class, dot.vector)).chain(examples) {
        let share = (vector[feature] - range[0]) / (range[1] - range[0]);
        let bar = ((share * BARS as f32) as usize).min(BARS - 1);
        let row = match class {
            Some(Class::Positive) => 0,
            Some(Class::Negative) => 1,
            None => 2,
        };
        counts[row][bar] += 1;
    }
    let most = counts.iter().flatten().copied().max().unwrap_or(0).max(1) as f32;
    let inner = area.shrink2(vec2(6.0, 0.0));
    let width = inner.width() / BARS as f32 / 3.0;
    for (row, (counts, fill)) in counts.iter().zip([POSITIVE, NEGATIVE, ASKED]).enumerate() {
        for (bar, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let left = inner.left() + (3 * bar + row) as f32 * width;
            let height = (inner.height() - 24.0) * *count as f32 / most;
            let bar =
                Rect::from_min_max(pos2(left, inner.bottom() - height.max(1.0)), pos2(left + width, inner.bottom()));
            painter.rect_filled(bar, 0.0, fill);
        }
    }
}
