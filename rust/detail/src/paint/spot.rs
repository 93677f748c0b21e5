//! New texels of old ones: what a brush, with its image and its mode, makes of up to 256 places of any kind of surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 5.2 and
//! 6.2: the same for the texels of tiles and the vertices of tessellated triangles. What differs between them is asked
//! of a [`Spot`].

use std::borrow::Cow;

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::simd::Level;
use relievo_tiles::{ColorPlanes, Texel};

use crate::channels::knots::{BLOCK_KNOTS, PerKnot};
use crate::paint::mode::{Colors, PaintInput, PaintMode, SculptInput, SculptMode};
use crate::paint::smudge::Smudge;
use crate::paint::stamp::Stamp;
use crate::paint::weights::Weights;

/// Up to 256 places of a surface under a brush.
pub(crate) trait Spot<T: Texel> {
    /// What the brush says of them.
    fn weights(&self) -> &Weights;

    /// What the brush says of them, to be changed.
    fn weights_mut(&mut self) -> &mut Weights;

    /// The displacement that the weights were evaluated with.
    fn heights(&self) -> &PerKnot;

    /// Calls `set` with the mean of the neighbours of every place, made of numbers from `read`. False, without a call,
    /// if all are blank.
    fn means<const N: usize>(&self, read: impl Fn(T) -> [f32; N], set: impl FnMut(usize, [f32; N])) -> bool;

    /// How far the neighbours of every place are away across the brush.
    fn footprints(&self) -> PerKnot;
}

/// How colours are changed.
pub(crate) struct Painting<'a> {
    pub level: Level,
    pub mode: PaintMode,
    /// The colour of the brush, at every place of a block alike: see [`everywhere`].
    pub color: Colors,
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
        // Filling an array that is not needed would cost as much as the whole mode.
        let mut mean = self.mode.needs_mean().then_some([[0.0; BLOCK_KNOTS]; 4]);
        if let Some(means) = &mut mean
            && !spot.means(
                |texel| texel.color().to_array(),
                |k, color| (0..4).for_each(|channel| means[channel][k] = color[channel]),
            )
        {
            mean = None;
        }
        let mut wanted = Cow::Borrowed(&self.color);
        let mut inside = None;
        if self.mode == PaintMode::Smear {
            let within = inside.insert([0.0; BLOCK_KNOTS]);
            within[..texels.len()].copy_from_slice(&spot.weights().share[..texels.len()]);
            match self.smudge {
                Some(smudge) => smudge.leave(spot.weights_mut(), wanted.to_mut()),
                None => spot.weights_mut().share.fill(0.0),
            }
        }
        if let Some(stamp) = self.stamp {
            let mut colors = [[1.0; BLOCK_KNOTS]; 4];
            let smears = self.mode == PaintMode::Smear;
            stamp.paint(&spot.footprints(), spot.weights_mut(), if smears { &mut colors } else { wanted.to_mut() });
        }
        let share = &spot.weights().share;
        let input = PaintInput { share, brush: &wanted, blank: self.blank, mean: mean.as_ref() };
        self.mode.apply(self.level, &input, &mut colors);
        if let (Some(inside), Some(smudge)) = (&inside, self.smudge) {
            smudge.pick(inside, &spot.weights().across, &colors);
        }
        T::write(self.level, &colors, texels);
    }
}

/// A colour at every place of a block.
pub(crate) fn everywhere(color: [f32; 4]) -> Colors {
    color.map(|channel| [channel; BLOCK_KNOTS])
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
    /// Makes the new texels of `spot`. `facing` sets the cosines between the normals of the surface and of the
    /// displaced one, if they are needed.
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
