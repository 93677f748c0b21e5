//! New texels of old ones: what a brush, with its image and its mode, makes of up to 256 places of any kind of surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 5.2 and
//! 6.2: the same for the texels of tiles and the vertices of tessellated triangles. What differs between them is asked of
//! a [`Spot`].

use std::borrow::Cow;

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::simd::Level;
use relievo_tiles::{ColorPlanes, Texel};

use crate::knots::{BLOCK_KNOTS, PerKnot};
use crate::mode::{Colors, PaintInput, PaintMode, SculptInput, SculptMode};
use crate::smudge::Smudge;
use crate::stamp::Stamp;
use crate::weights::Weights;

/// Up to 256 places of a surface under a brush.
pub(crate) trait Spot<T: Texel> {
    /// What the brush says of them.
    fn weights(&self) -> &Weights;

    /// What the brush says of them, to be changed.
    fn weights_mut(&mut self) -> &mut Weights;

    /// The displacement that the weights were evaluated with.
    fn heights(&self) -> &PerKnot;

    /// Calls `set` with the mean of the neighbours of every place, made of numbers from `read`. False, without a call, if
    /// all are blank.
    fn means<const N: usize>(&self, read: impl Fn(T) -> [f32; N], set: impl FnMut(usize, [f32; N])) -> bool;

    /// How far the neighbours of every place are away across the brush.
    fn footprints(&self) -> PerKnot;
}

/// How colours are changed.
pub(crate) struct Painting<'a> {
    pub level: Level,
    pub mode: PaintMode,
    pub color: [f32; 4],
    /// The colour of what is not painted.
    pub blank: [f32; 4],
    pub stamp: Option<&'a Stamp>,
    /// What a brush that smears carries.
    pub smudge: Option<&'a Smudge>,
}

impl Painting<'_> {
    /// Makes the new texels of `spot`.
    pub fn edit<T: ColorPlanes>(&self, spot: &mut impl Spot<T>, texels: &mut [T]) {
        let mut colors: Colors = [[0.0; BLOCK_KNOTS]; 4];
        T::read(self.level, texels, &mut colors);
        let mut mean: Colors = [[0.0; BLOCK_KNOTS]; 4];
        let with_mean = self.mode.needs_mean()
            && spot.means(
                |texel| texel.color().to_array(),
                |k, color| (0..4).for_each(|channel| mean[channel][k] = color[channel]),
            );
        let mut wanted = self.color.map(|channel| [channel; BLOCK_KNOTS]);
        let mut inside = [0.0; BLOCK_KNOTS];
        if self.mode == PaintMode::Smear {
            inside[..texels.len()].copy_from_slice(&spot.weights().share[..texels.len()]);
            match self.smudge {
                Some(smudge) => smudge.leave(spot.weights_mut(), &mut wanted),
                None => spot.weights_mut().share.fill(0.0),
            }
        }
        if let Some(stamp) = self.stamp {
            let mut colors = [[1.0; BLOCK_KNOTS]; 4];
            let smears = self.mode == PaintMode::Smear;
            stamp.paint(&spot.footprints(), spot.weights_mut(), if smears { &mut colors } else { &mut wanted });
        }
        let share = &spot.weights().share;
        let input = PaintInput { share, brush: &wanted, blank: self.blank, mean: with_mean.then_some(&mean) };
        self.mode.apply(self.level, &input, &mut colors);
        if let (PaintMode::Smear, Some(smudge)) = (self.mode, self.smudge) {
            smudge.pick(&inside, &spot.weights().across, &colors);
        }
        T::write(self.level, &colors, texels);
    }
}

/// How displacements are changed.
pub(crate) struct Sculpting<'a> {
    pub level: Level,
    pub mode: SculptMode,
    pub height: f32,
    pub stamp: Option<&'a Stamp>,
    /// Whether the displacement may have risen since the weights were evaluated.
    pub since: bool,
}

impl Sculpting<'_> {
    /// Makes the new texels of `spot`. `facing` sets the cosines between the normals of the surface and of the displaced
    /// one, if they are needed.
    pub fn edit<S: Spot<f16>>(&self, spot: &mut S, facing: impl Fn(&S, &mut PerKnot), texels: &mut [f16]) {
        let mode = self.mode;
        let mut now = [0.0; BLOCK_KNOTS];
        texels.convert_to_f32_slice(&mut now[..texels.len()]);
        let mut risen = [0.0; BLOCK_KNOTS];
        if self.since {
            (0..texels.len()).for_each(|k| risen[k] = now[k] - spot.heights()[k]);
        }
        let mut mean = [0.0; BLOCK_KNOTS];
        let with_mean = mode.needs_mean() && spot.means(|texel| [texel.to_f32()], |k, [value]| mean[k] = value);
        let one = [self.height; BLOCK_KNOTS];
        let mut height = Cow::Borrowed(&one);
        if let Some(stamp) = self.stamp {
            stamp.sculpt(&spot.footprints(), spot.weights_mut(), height.to_mut(), !mode.has_height());
        }
        let mut cosines = [1.0; BLOCK_KNOTS];
        if mode.needs_facing() {
            facing(spot, &mut cosines);
        }
        let input = SculptInput {
            weights: spot.weights(),
            height: &height,
            risen: &risen,
            mean: with_mean.then_some(&mean),
            facing: &cosines,
        };
        mode.apply(self.level, &input, &mut now);
        texels.convert_from_f32_slice(&now[..texels.len()]);
    }
}
