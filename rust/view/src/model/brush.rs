//! The brush in the hand: what it does, how large and how strong it is, and the stroke that it makes.

use relievo_core::Falloff;
use relievo_core::parameter::Switch;
use relievo_detail::{Action, PaintMode, SculptMode, Stroke, StrokeSettings};

/// What the brush does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Changes displacement.
    Sculpt(SculptMode),
    /// Changes colours.
    Paint(PaintMode),
}

/// What keys that are held make of a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// Control: the other way round.
    pub inverts: bool,
    /// Shift: smooths or blurs.
    pub smooths: bool,
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
}

impl Brush {
    /// The radii that a brush may have on an object of a size in world units.
    pub fn radii(size: f64) -> std::ops::RangeInclusive<f64> {
        1e-3 * size..=size
    }

    /// A brush that draws on an object of a size in world units.
    pub fn new(size: f64) -> Self {
        Self {
            tool: Tool::Sculpt(SculptMode::Draw),
            radius: 0.06 * size,
            strength: 0.5,
            height: 0.15,
            color: [0.55, 0.05, 0.03],
            falloff: Falloff::Smooth,
            symmetry: false,
        }
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
            radius: self.radius as f32,
            strength: self.strength,
            symmetry_x: if self.symmetry { Switch::ON } else { Switch::OFF },
            ..StrokeSettings::default()
        };
        Stroke::new(Vec::new(), settings, self.falloff, self.action(held))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_invert_and_smooth() {
        let mut brush = Brush::new(2.0);
        let [plain, inverted, smooth] = [(false, false), (true, false), (true, true)]
            .map(|(inverts, smooths)| brush.stroke(Held { inverts, smooths }).action);
        let heights = [plain, inverted].map(|action| match action {
            Action::Sculpt { mode: SculptMode::Draw, height } => height,
            other => panic!("{other:?}"),
        });
        assert!(heights[0] > 0.0 && heights[0] == -heights[1]);
        assert!(matches!(smooth, Action::Sculpt { mode: SculptMode::Smooth, .. }));
        brush.tool = Tool::Paint(PaintMode::Mix);
        assert!(matches!(
            brush.stroke(Held { inverts: true, smooths: false }).action,
            Action::Paint { mode: PaintMode::Erase, .. }
        ));
        brush.stroke(Held::default()).check_brush().unwrap();
    }
}
