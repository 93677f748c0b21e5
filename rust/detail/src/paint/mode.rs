//! What a brush makes of colours and displacements, given its weights: one formula a mode, side by side for up to 256
//! places of any surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5.2,
//! leaves the formulas to the brush; here each mode says its own. In them *s* is the share of the place, 0 to 1. Units:
//! object units along the normal for displacement; linear Rec.709 with alpha for colour.

use relievo_core::dispatch_simd;
use relievo_core::simd::{Arithmetic, Level};

use crate::channels::knots::{BLOCK_KNOTS, PerKnot};
use crate::paint::weights::Weights;

/// How a brush changes colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PaintMode {
    /// Toward the brush's colour: c + s (brush − c).
    #[default]
    Mix,
    /// The brush's colour is added, c + s · brush; alpha stays.
    Add,
    /// Multiplied by the brush's colour, c (1 + s (brush − 1)); alpha stays.
    Multiply,
    /// Toward the colour of what is not painted: c + s (blank − c).
    Erase,
    /// Toward the mean of the four neighbours: c + s (mean − c).
    Blur,
    /// Toward the colour that the dab before it picked up at the same place of the brush: c + s (carried − c). A single
    /// dab, and the first of a stroke, leaves nothing.
    Smear,
}

impl PaintMode {
    /// All modes and their names in scene files.
    pub const NAMES: [(PaintMode, &'static str); 6] = [
        (PaintMode::Mix, "mix"),
        (PaintMode::Add, "add"),
        (PaintMode::Multiply, "multiply"),
        (PaintMode::Erase, "erase"),
        (PaintMode::Blur, "blur"),
        (PaintMode::Smear, "smear"),
    ];

    /// Whether it reads [`PaintInput::mean`].
    pub fn needs_mean(self) -> bool {
        self == PaintMode::Blur
    }

    /// Makes the new colours of old ones. Where the share is 0 they stay to the bit.
    pub fn apply(self, level: Level, input: &PaintInput<'_>, colors: &mut Colors) {
        paint(level, self, input, colors);
    }
}

/// Red, green, blue and alpha of each place.
pub type Colors = [PerKnot; 4];

/// What a mode of painting goes by.
#[derive(Clone, Copy, Debug)]
pub struct PaintInput<'a> {
    /// Shares of the edit.
    pub share: &'a PerKnot,
    /// The brush's colour at each place.
    pub brush: &'a Colors,
    /// The colour of what is not painted.
    pub blank: [f32; 4],
    /// The mean of the neighbours of each place; `None` if all are like the place itself, or the mode does not need it.
    pub mean: Option<&'a Colors>,
}

dispatch_simd! {
    fn paint = paint_body(mode: PaintMode, input: &PaintInput<'_>, colors: &mut Colors)
}

#[inline(always)]
fn paint_body<A: Arithmetic>(_: A, mode: PaintMode, input: &PaintInput<'_>, colors: &mut Colors) {
    let PaintInput { share, brush, blank, mean } = *input;
    for (channel, now) in colors.iter_mut().enumerate() {
        let (alpha, brush) = (channel == 3, &brush[channel]);
        match mode {
            PaintMode::Mix | PaintMode::Smear => {
                change(share, now, |k, now, share| A::fma(brush[k] - now, share, now));
            }
            PaintMode::Add | PaintMode::Multiply if alpha => {}
            PaintMode::Add => change(share, now, |k, now, share| A::fma(brush[k], share, now)),
            PaintMode::Multiply => change(share, now, |k, now, share| now * A::fma(brush[k] - 1.0, share, 1.0)),
            PaintMode::Erase => change(share, now, |_, now, share| A::fma(blank[channel] - now, share, now)),
            PaintMode::Blur => {
                if let Some(mean) = mean {
                    change(share, now, |k, now, share| A::fma(mean[channel][k] - now, share, now));
                }
            }
        }
    }
}

/// How a brush changes displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SculptMode {
    /// Along the surface's normal by the height, against it if that is negative: d + s · height.
    #[default]
    Draw,
    /// Toward the mean of the four neighbours: d + s (mean − d), and of vectors likewise.
    Smooth,
    /// Toward the plane through the middle of the brush's box, across its third axis: d − s · above, where *above* is
    /// how far the place is over the plane along the surface's normal. Where that does not point out of the plane
    /// nothing changes.
    Flatten,
    /// Toward the surface without displacement: d − s · d, and of vectors likewise.
    Erase,
    /// Builds up to the plane that is the height over the middle of the box and not beyond it: as flatten toward that
    /// plane, but only what is under it rises. With a negative height only what is over it sinks.
    Clay,
    /// Takes off what is over the plane through the middle of the box: as flatten, but nothing rises.
    Scrape,
    /// As draw, but the dabs of a stroke do not add up: d becomes s · height more than when the stroke began, unless it
    /// is that already.
    Layer,
    /// Outwards by the height across the displaced surface itself: d + s · height / cos, where *cos* is between the
    /// normals of the surface and of the displaced one, and at least ¼. Bumps grow to all sides and not just upwards.
    Inflate,
    /// Toward the line through the middle of the brush's box along its third axis: v − s · across, where *across* is
    /// from the line to where the place now is. With a negative height away from it, which magnifies; how large the
    /// height is does not matter. Changes vector displacement.
    Pinch,
    /// By the vector of the brush's image times the height, in object units along the axes of the box; without an image
    /// along the third axis: v + s · vector. Changes vector displacement.
    Vector,
}

impl SculptMode {
    /// All modes and their names in scene files.
    pub const NAMES: [(SculptMode, &'static str); 10] = [
        (SculptMode::Draw, "draw"),
        (SculptMode::Smooth, "smooth"),
        (SculptMode::Flatten, "flatten"),
        (SculptMode::Erase, "erase"),
        (SculptMode::Clay, "clay"),
        (SculptMode::Scrape, "scrape"),
        (SculptMode::Layer, "layer"),
        (SculptMode::Inflate, "inflate"),
        (SculptMode::Pinch, "pinch"),
        (SculptMode::Vector, "vector"),
    ];

    /// Whether the object must have vector displacement.
    pub fn needs_vectors(self) -> bool {
        matches!(self, SculptMode::Pinch | SculptMode::Vector)
    }

    /// Whether it changes the vector displacement that an object may have.
    pub fn changes_vectors(self) -> bool {
        self.needs_vectors() || matches!(self, SculptMode::Smooth | SculptMode::Erase)
    }

    /// Whether it reads [`SculptInput::mean`].
    pub fn needs_mean(self) -> bool {
        self == SculptMode::Smooth
    }

    /// Whether it reads [`SculptInput::facing`].
    pub fn needs_facing(self) -> bool {
        self == SculptMode::Inflate
    }

    /// Whether it reads [`SculptInput::height`].
    pub fn has_height(self) -> bool {
        matches!(
            self,
            SculptMode::Draw | SculptMode::Clay | SculptMode::Layer | SculptMode::Inflate | SculptMode::Vector
        )
    }

    /// Makes the new displacements of old ones, −65504 to 65504. Where the share is 0 they stay to the bit.
    pub fn apply(self, level: Level, input: &SculptInput<'_>, displacements: &mut PerKnot) {
        sculpt(level, self, input, displacements);
    }

    /// Makes the new vectors of old ones, in any frames, each number −65504 to 65504. Where the share is 0 they stay to
    /// the bit, as they do if the mode does not change vectors.
    pub fn apply_vectors(self, level: Level, input: &VectorInput<'_>, vectors: &mut [PerKnot; 3]) {
        bend(level, self, input, vectors);
    }
}

/// What a mode of sculpting vectors goes by.
#[derive(Clone, Copy, Debug)]
pub struct VectorInput<'a> {
    /// Shares of the edit.
    pub share: &'a PerKnot,
    /// What is added where the share is 1: of [`SculptMode::Vector`] the brush's vectors, of [`SculptMode::Pinch`] the
    /// way to the line.
    pub change: &'a [PerKnot; 3],
    /// The mean of the neighbours of each place; `None` if all are like the place itself, or the mode does not need it.
    pub mean: Option<&'a [PerKnot; 3]>,
}

/// What a mode of sculpting goes by.
#[derive(Clone, Copy, Debug)]
pub struct SculptInput<'a> {
    /// The brush at each place.
    pub weights: &'a Weights,
    /// The height of the brush at each place, object units.
    pub height: &'a PerKnot,
    /// By how much the displacement is more than the one that the weights were evaluated with.
    pub risen: &'a PerKnot,
    /// The mean of the neighbours of each place; `None` if all are like the place itself, or the mode does not need it.
    pub mean: Option<&'a PerKnot>,
    /// The cosine between the normals of the surface and of the displaced one at each place, if the mode needs it.
    pub facing: &'a PerKnot,
}

dispatch_simd! {
    fn sculpt = sculpt_body(mode: SculptMode, input: &SculptInput<'_>, displacements: &mut PerKnot)
}

/// The largest displacement that a half float holds.
const MAX: f32 = 65504.0;

/// The least cosine that inflating divides by.
const MIN_FACING: f32 = 0.25;

#[inline(always)]
fn sculpt_body<A: Arithmetic>(_: A, mode: SculptMode, input: &SculptInput<'_>, displacements: &mut PerKnot) {
    let SculptInput { weights, height, risen, mean, facing } = *input;
    let Weights { share, level, rise, unit, .. } = weights;
    // How far a place is under the plane `height` over the middle, along its normal; 0 where that does not rise.
    let under = |k: usize, height: f32| {
        let far = A::fma(height, *unit, -level[k]) / rise[k] - risen[k];
        if rise[k] > 0.0 { far } else { 0.0 }
    };
    let held = |value: f32| value.clamp(-MAX, MAX);
    let now = displacements;
    match mode {
        SculptMode::Draw => change(share, now, |k, now, share| held(A::fma(height[k], share, now))),
        SculptMode::Smooth => {
            if let Some(mean) = mean {
                change(share, now, |k, now, share| A::fma(mean[k] - now, share, now));
            }
        }
        SculptMode::Flatten => change(share, now, |k, now, share| held(A::fma(under(k, 0.0), share, now))),
        SculptMode::Erase => change(share, now, |_, now, share| A::fma(-now, share, now)),
        SculptMode::Clay => change(share, now, |k, now, share| {
            let far = under(k, height[k]);
            let far = if height[k] < 0.0 { far.min(0.0) } else { far.max(0.0) };
            held(A::fma(far, share, now))
        }),
        SculptMode::Scrape => {
            change(share, now, |k, now, share| held(A::fma(under(k, 0.0).min(0.0), share, now)));
        }
        SculptMode::Layer => change(share, now, |k, now, share| {
            let far = A::fma(height[k], share, -risen[k]);
            held(now + if height[k] < 0.0 { far.min(0.0) } else { far.max(0.0) })
        }),
        SculptMode::Inflate => {
            change(share, now, |k, now, share| held(A::fma(height[k] / facing[k].max(MIN_FACING), share, now)))
        }
        SculptMode::Pinch | SculptMode::Vector => {}
    }
}

dispatch_simd! {
    fn bend = bend_body(mode: SculptMode, input: &VectorInput<'_>, vectors: &mut [PerKnot; 3])
}

#[inline(always)]
fn bend_body<A: Arithmetic>(_: A, mode: SculptMode, input: &VectorInput<'_>, vectors: &mut [PerKnot; 3]) {
    let VectorInput { share, change: added, mean } = *input;
    for (axis, now) in vectors.iter_mut().enumerate() {
        match mode {
            SculptMode::Pinch | SculptMode::Vector => {
                let added = &added[axis];
                change(share, now, |k, now, share| A::fma(added[k], share, now).clamp(-MAX, MAX));
            }
            SculptMode::Smooth => {
                if let Some(mean) = mean {
                    change(share, now, |k, now, share| A::fma(mean[axis][k] - now, share, now));
                }
            }
            SculptMode::Erase => change(share, now, |_, now, share| A::fma(-now, share, now)),
            _ => {}
        }
    }
}

/// Replaces the values that have a share.
#[inline(always)]
fn change(share: &PerKnot, values: &mut PerKnot, formula: impl Fn(usize, f32, f32) -> f32) {
    for k in 0..BLOCK_KNOTS {
        let new = formula(k, values[k], share[k]);
        values[k] = if share[k] > 0.0 { new } else { values[k] };
    }
}
