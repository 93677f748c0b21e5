//! What is left out where a face or an edge of a triangle mesh is drawn in a coarser pattern than its values are kept in:
//! measured, since coarser patterns are subsets of finer ones.

use glam::Vec3;
use relievo_surface::bezier::Viewpoint;
use relievo_tiles::triangle::{Pattern, Slot};

/// Steps of 255 by which colours may differ.
const COLOR: f32 = 2.0 / 255.0;
/// Powers of two that patterns have: 2 to 64 segments, and one segment.
const POWERS: usize = 7;

/// How far finer values are from coarser patterns, by their power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Thinning {
    power: u8,
    /// In object units.
    points: [f32; POWERS],
    colors: [f32; POWERS],
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Thinning {
    fn new(power: u8, points: &[Vec3]) -> Self {
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        Self { power, low: low.to_array(), high: high.to_array(), ..Self::default() }
    }

    fn note(&mut self, power: usize, point: f32, color: f32) {
        self.points[power] = self.points[power].max(point);
        self.colors[power] = self.colors[power].max(color);
    }

    /// Of an edge of 2^power segments; where that is one, in its middle there is one vertex more.
    pub fn along(power: u8, points: &[Vec3], colors: &[Vec3]) -> Self {
        let mut made = Self::new(power, points);
        for coarser in 0..power {
            let stride = 1usize << (power - coarser);
            for step in 0..points.len() - 1 {
                let (start, share) = (step / stride * stride, (step % stride) as f32 / stride as f32);
                let away = |of: &[Vec3]| of[start].lerp(of[start + stride], share).distance(of[step]);
                made.note(usize::from(coarser), away(points), away(colors));
            }
        }
        made
    }

    /// Of a face with a pattern of 2^power segments, whose points and colours are `at` its slots.
    pub fn inside(power: u8, pattern: Pattern, at: impl Fn(Slot) -> (Vec3, Vec3)) -> Self {
        let segments = pattern.segments();
        let count = pattern.face_values() as u32;
        let sides = (0..3).flat_map(|side| (1..segments).map(move |step| Slot::Side(side, step)));
        let slots: Vec<Slot> = (0..count).map(Slot::Inside).chain((0..3).map(Slot::Corner)).chain(sides).collect();
        let values: Vec<(Vec3, Vec3)> = slots.iter().map(|slot| at(*slot)).collect();
        let number = |slot: Slot| match slot {
            Slot::Inside(index) => index,
            Slot::Corner(corner) => count + corner,
            Slot::Side(side, step) => count + 3 + side * (segments - 1) + step - 1,
        };
        let points: Vec<Vec3> = values.iter().map(|(point, _)| *point).collect();
        let mut made = Self::new(power, &points);
        let unit = 1.0 / (3.0 * segments as f32);
        for coarser in 0..power {
            let coarse = Pattern::new(1 << coarser.max(1)).unwrap_or(Pattern::COARSEST);
            let finer = power - coarser.max(1);
            for (slot, (point, color)) in slots.iter().zip(&values).take(count as usize) {
                let place = pattern.weights(pattern.at_slot(*slot)).map(|weight| weight as f32 * unit);
                let of = |at: u32, share: f32| (share * values[at as usize].0, share * values[at as usize].1);
                let terms = if coarser == 0 {
                    [0, 1, 2].map(|corner| of(count + corner, place[corner as usize]))
                } else {
                    let (nodes, shares) = coarse.locate(place);
                    [0, 1, 2].map(|k| {
                        let node = (0..finer).fold((coarse, nodes[k]), |(at, node), _| (at, at.refined(node))).1;
                        of(number(pattern.slot(node)), shares[k])
                    })
                };
                let sum = terms.iter().fold((Vec3::ZERO, Vec3::ZERO), |sum, term| (sum.0 + term.0, sum.1 + term.1));
                made.note(usize::from(coarser), sum.0.distance(*point), sum.1.distance(*color));
            }
        }
        made
    }

    /// Takes a point of a side into the bounds.
    pub fn reach(&mut self, point: Vec3) {
        self.low = Vec3::from(self.low).min(point).to_array();
        self.high = Vec3::from(self.high).max(point).to_array();
    }

    /// The lowest power at which what is left out is at most `tolerance` pixels and no colour is missed.
    pub fn lowest(&self, view: &Viewpoint, tolerance: f64) -> u8 {
        let [reach, pixel] = [tolerance, 1.0].map(|pixels| view.reach(self.low, self.high, pixels));
        let size = f64::from(Vec3::from(self.low).distance(Vec3::from(self.high)));
        let enough = |power: &u8| {
            let at = usize::from(*power);
            let cell = size / f64::from(1u32 << power);
            f64::from(self.points[at]) <= reach && (self.colors[at] <= COLOR || cell <= pixel)
        };
        (0..self.power).find(enough).unwrap_or(self.power)
    }
}
