//! The brush in the hand: what it does, how large and how strong it is, and the stroke that it makes.

use relievo_core::Falloff;
use relievo_core::parameter::Switch;
use relievo_detail::{Action, PaintMode, SculptMode, Stroke, StrokeSettings};

use super::stamp::BrushStamp;
use crate::preferences::Preferences;

/// The radius of a brush at first, as a share of the size of the object.
const SHARE: f64 = 0.06;

/// The same in sides of squares as large as the mean face, of which it has no more: what a dab costs grows with the faces
/// under it, and these are about 300 then.
const SIDES: f64 = 10.0;

/// Degrees that a pen leans from which on the brush gets wider, and from which on it is as wide as it gets: pens lean by some
/// 30 in a hand that writes.
const WIDENING: [f64; 2] = [40.0, 65.0];

/// What the brush does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Changes displacement.
    Sculpt(SculptMode),
    /// Changes colours.
    Paint(PaintMode),
    /// Presses a mesh into the surface.
    Press,
    /// Lays an image on the surface.
    Decal,
}

impl Tool {
    /// The name by which it is kept.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Sculpt(mode) => {
                format!("sculpt {}", SculptMode::NAMES.iter().find(|(other, _)| *other == mode).map_or("", |it| it.1))
            }
            Self::Paint(mode) => {
                format!("paint {}", PaintMode::NAMES.iter().find(|(other, _)| *other == mode).map_or("", |it| it.1))
            }
            Self::Press => "press".to_owned(),
            Self::Decal => "decal".to_owned(),
        }
    }

    /// The tool of a name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let sculpts = SculptMode::NAMES.iter().map(|(mode, _)| Self::Sculpt(*mode));
        let paints = PaintMode::NAMES.iter().map(|(mode, _)| Self::Paint(*mode));
        sculpts.chain(paints).find(|tool| tool.name() == name)
    }
}

/// What keys that are held, and how the pen is held, make of a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Control: the other way round.
    pub inverts: bool,
    /// Shift: smooths or blurs.
    pub smooths: bool,
    /// Degrees that the pen leans.
    pub lean: f64,
}

impl Held {
    /// How many times as wide the brush is: as long as a pen is held as for writing, once; flat as a pencil for shading,
    /// twice.
    pub(crate) fn width(&self) -> f64 {
        let [from, to] = WIDENING;
        1.0 + ((self.lean - from) / (to - from)).clamp(0.0, 1.0)
    }
}

/// A brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush {
    /// What it does.
    pub tool: Tool,
    /// World units on the surface.
    pub radius: f64,
    /// 0 to 1.
    pub strength: f32,
    /// What a dab adds where it is strongest, as a share of the radius.
    pub height: f32,
    /// Linear Rec.709.
    pub color: [f32; 3],
    /// How the strength falls off toward the rim.
    pub falloff: Falloff,
    /// Whether strokes are made at x mirrored too.
    pub symmetry: bool,
    /// Its image.
    pub stamp: Option<BrushStamp>,
}

impl Brush {
    /// The radii that a brush may have on an object of a size in world units.
    pub fn radii(size: f64) -> std::ops::RangeInclusive<f64> {
        1e-3 * size..=size
    }

    /// A brush that draws on an object of a size in world units, whose mean face is as large as a square of `side`: a
    /// share of the object, but no more faces than an event can change while the hand moves.
    pub fn new(size: f64, side: f64) -> Self {
        Self {
            tool: Tool::Sculpt(SculptMode::Draw),
            radius: (SHARE * size).min(SIDES * side).max(*Self::radii(size).start()),
            strength: 0.5,
            height: 0.15,
            color: [0.55, 0.05, 0.03],
            falloff: Falloff::Smooth,
            symmetry: false,
            stamp: None,
        }
    }

    /// Takes up what preferences keep of a brush, on an object of a size in world units. Its radius is kept by the one that
    /// it would have at first there.
    pub(crate) fn take_up(&mut self, kept: &Preferences, (size, side): (f64, f64)) {
        let (first, radii) = (Self::new(size, side).radius, Self::radii(size));
        self.tool = kept.get("brush.tool", Tool::named).unwrap_or(self.tool);
        let radius = kept.number("brush.size", 1e-3..=1e3).map(|share| share * first);
        self.radius = radius.map_or(self.radius, |radius| radius.clamp(*radii.start(), *radii.end()));
        self.strength = kept.number("brush.strength", 0.0..=1.0).map_or(self.strength, |it| it as f32);
        self.height = kept.number("brush.height", 0.01..=1.0).map_or(self.height, |it| it as f32);
        self.symmetry = kept.switch("brush.symmetry").unwrap_or(self.symmetry);
        let falloff = |name: &str| Falloff::NAMES.iter().find(|(_, other)| *other == name).map(|it| it.0);
        self.falloff = kept.get("brush.falloff", falloff).unwrap_or(self.falloff);
        let color = |text: &str| {
            let parts: Vec<f32> = text.split(' ').filter_map(|part| part.parse().ok()).collect();
            <[f32; 3]>::try_from(parts).ok().filter(|color| color.iter().all(|part| (0.0..=1.0).contains(part)))
        };
        self.color = kept.get("brush.color", color).unwrap_or(self.color);
    }

    /// Puts into preferences what they keep of the brush.
    pub(crate) fn keep(&self, kept: &mut Preferences, (size, side): (f64, f64)) {
        kept.set("brush.tool", self.tool.name());
        kept.set("brush.size", self.radius / Self::new(size, side).radius);
        kept.set("brush.strength", self.strength);
        kept.set("brush.height", self.height);
        kept.set("brush.symmetry", self.symmetry);
        kept.set("brush.falloff", Falloff::NAMES.iter().find(|(it, _)| *it == self.falloff).map_or("", |it| it.1));
        let [r, g, b] = self.color;
        kept.set("brush.color", format!("{r} {g} {b}"));
    }

    /// What a stroke with these keys is called.
    pub fn label(&self, held: Held) -> String {
        match self.action(held) {
            Action::Sculpt { mode, height } => {
                let name = SculptMode::NAMES.iter().find(|(other, _)| *other == mode).map_or("sculpt", |it| it.1);
                format!("{name}{}", if height < 0.0 { ", inverted" } else { "" })
            }
            Action::Paint { mode, .. } => {
                let name = PaintMode::NAMES.iter().find(|(other, _)| *other == mode).map_or("paint", |it| it.1);
                format!("paint: {name}")
            }
        }
    }

    fn action(&self, held: Held) -> Action {
        match self.tool {
            Tool::Sculpt(mode) => {
                let mode = if held.smooths { SculptMode::Smooth } else { mode };
                let height = self.height * self.radius as f32;
                Action::Sculpt { mode, height: if held.inverts { -height } else { height } }
            }
            // A tool digs.
            Tool::Press => Action::Sculpt { mode: SculptMode::Draw, height: -self.height * self.radius as f32 },
            Tool::Decal => Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] },
            Tool::Paint(mode) => {
                let mode = match (held.smooths, held.inverts) {
                    (true, _) => PaintMode::Blur,
                    (false, true) => PaintMode::Erase,
                    (false, false) => mode,
                };
                let [r, g, b] = self.color;
                Action::Paint { mode, color: [r, g, b, 1.0] }
            }
        }
    }

    /// The stroke without points.
    pub fn stroke(&self, held: Held) -> Stroke {
        let settings = StrokeSettings {
            radius: (held.width() * self.radius) as f32,
            strength: self.strength,
            symmetry_x: if self.symmetry { Switch::ON } else { Switch::OFF },
            ..StrokeSettings::default()
        };
        let action = self.action(held);
        let mut stroke = Stroke::new(Vec::new(), settings, self.falloff, action);
        stroke.stamp = self.stamp.as_ref().map(|stamp| match action {
            Action::Paint { .. } => stamp.paint.clone(),
            Action::Sculpt { .. } => stamp.sculpt.clone(),
        });
        stroke
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_invert_and_smooth() {
        let mut brush = Brush::new(2.0, 1.0);
        let [plain, inverted, smooth] = [(false, false), (true, false), (true, true)]
            .map(|(inverts, smooths)| brush.stroke(Held { inverts, smooths, ..Held::default() }).action);
        let heights = [plain, inverted].map(|action| match action {
            Action::Sculpt { mode: SculptMode::Draw, height } => height,
            other => panic!("{other:?}"),
        });
        assert!(heights[0] > 0.0 && heights[0] == -heights[1]);
        assert!(matches!(smooth, Action::Sculpt { mode: SculptMode::Smooth, .. }));
        brush.tool = Tool::Paint(PaintMode::Mix);
        assert!(matches!(
            brush.stroke(Held { inverts: true, ..Held::default() }).action,
            Action::Paint { mode: PaintMode::Erase, .. }
        ));
        brush.stroke(Held::default()).check_brush().unwrap();
    }

    #[test]
    fn a_pen_that_leans_makes_the_brush_wider() {
        let brush = Brush::new(2.0, 1.0);
        for (lean, width) in [(0.0, 1.0), (40.0, 1.0), (52.5, 1.5), (65.0, 2.0), (90.0, 2.0)] {
            let stroke = brush.stroke(Held { lean, ..Held::default() });
            assert!((f64::from(stroke.settings.radius) - width * brush.radius).abs() < 1e-6, "{lean}");
        }
    }

    #[test]
    fn a_brush_is_kept_by_the_size_of_its_object() {
        let mut brush = Brush::new(2.0, 1.0);
        (brush.tool, brush.radius, brush.falloff) = (Tool::Paint(PaintMode::Blur), 0.5, Falloff::Linear);
        (brush.color, brush.symmetry) = ([0.1, 0.25, 1.0], true);
        let mut kept = Preferences::default();
        brush.keep(&mut kept, (2.0, 1.0));
        let mut other = Brush::new(8.0, 1.0);
        other.take_up(&kept, (8.0, 1.0));
        assert!((other.radius - 2.0).abs() < 1e-9, "{}", other.radius);
        assert_eq!(other, Brush { radius: other.radius, ..brush });
        // Where faces are small it has no more of them.
        other.take_up(&kept, (8.0, 0.001));
        assert!((other.radius - 0.5 / 0.12 * 0.01).abs() < 1e-9, "{}", other.radius);
        for (mode, _) in SculptMode::NAMES {
            assert_eq!(Tool::named(&Tool::Sculpt(mode).name()), Some(Tool::Sculpt(mode)));
        }
        // A tool mesh and an image are not kept.
        assert_eq!(["press", "decal"].map(Tool::named), [None; 2]);
    }
}
