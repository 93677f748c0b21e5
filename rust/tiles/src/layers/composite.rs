//! Layers of texels put on each other: the composite is a channel of its own, computed tile by tile from the layers.
//!
//! Displacements add up, are taken away, or the higher or lower one counts. Colours are blended in linear light, their
//! texels taken as premultiplied by alpha (Porter and Duff 1984, Compositing Digital Images); what separable modes do
//! where either is transparent is that of the W3C's Compositing and Blending, Level 1, Section 10. A coarser layer is
//! brought to the size of the composite by B-spline subdivision: exactly for displacement, and for colours what
//! bilinear look-up gives at the centres of the finer texels. The lowest layer, where it is seen as a whole in the mode
//! of its kind, is taken as it is.

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Result};
use relievo_document::{Blend, Settings};

use crate::quads::channel::{Channel, ChannelOptions};
use crate::quads::field::Field;
use crate::quads::spline::subdivide_block;
use crate::store::blocks::Blocks;
use crate::store::sets::Sets;
use crate::store::stored::StoredTexel;
use crate::texel::{ColorTexel, Rgba8, Rgba16};

/// A texel of layers that can be put on each other.
pub trait Layered: StoredTexel {
    /// What is computed with: linear light, object units.
    type Sum: Copy + Send + Sync + PartialEq;

    /// The value.
    fn sum(self) -> Self::Sum;

    /// The nearest texel to a value.
    fn of_sum(sum: Self::Sum) -> Self;

    /// What is seen where `layer` is put on what is `below`; visibility does not count.
    fn blend(below: Self::Sum, layer: Self::Sum, settings: &Settings) -> Self::Sum;

    /// The `(n + 2)²` values of a block at twice as many texels a side.
    fn refine(block: &[Self::Sum], size: usize) -> Vec<Self::Sum>;
}

impl Layered for f16 {
    type Sum = f32;

    fn sum(self) -> f32 {
        self.to_f32()
    }

    fn of_sum(sum: f32) -> Self {
        f16::from_f32(sum.clamp(-65504.0, 65504.0))
    }

    fn blend(below: f32, layer: f32, settings: &Settings) -> f32 {
        let o = settings.opacity;
        match settings.blend {
            Blend::Subtract => below - o * layer,
            Blend::Max => below + o * (below.max(layer) - below),
            Blend::Min => below + o * (below.min(layer) - below),
            _ => below + o * layer,
        }
    }

    fn refine(block: &[f32], size: usize) -> Vec<f32> {
        subdivide_block(block, size)
    }
}

/// A colour layer on colours below it, both premultiplied.
fn blend_color(below: Vec4, layer: Vec4, settings: &Settings) -> Vec4 {
    let above = layer * settings.opacity;
    let (a, b) = (above.w, below.w);
    // What each shows where the other is transparent.
    let apart = above * (1.0 - b) + below * (1.0 - a);
    let both = match settings.blend {
        Blend::Multiply => above * below,
        Blend::Screen => above * b + below * a - above * below,
        Blend::Overlay => {
            let dark = 2.0 * above * below;
            let light = Vec4::splat(a * b) - 2.0 * (Vec4::splat(b) - below) * (Vec4::splat(a) - above);
            Vec4::select((2.0 * below).cmple(Vec4::splat(b)), dark, light)
        }
        Blend::Max => (above * b).max(below * a),
        Blend::Min => (above * b).min(below * a),
        Blend::Add => return (above + below).truncate().extend(a + b - a * b),
        _ => above * b,
    };
    (apart + both).truncate().extend(a + b - a * b)
}

fn refine_color(block: &[Vec4], size: usize) -> Vec<Vec4> {
    let planes = [0, 1, 2, 3].map(|axis| {
        let plane: Vec<f32> = block.iter().map(|color| color[axis]).collect();
        subdivide_block(&plane, size)
    });
    (0..planes[0].len()).map(|at| Vec4::from_array([0, 1, 2, 3].map(|axis: usize| planes[axis][at]))).collect()
}

macro_rules! layered_color {
    ($texel:ty) => {
        impl Layered for $texel {
            type Sum = Vec4;

            fn sum(self) -> Vec4 {
                self.color()
            }

            fn of_sum(sum: Vec4) -> Self {
                Self::of_color(sum)
            }

            fn blend(below: Vec4, layer: Vec4, settings: &Settings) -> Vec4 {
                blend_color(below, layer, settings)
            }

            fn refine(block: &[Vec4], size: usize) -> Vec<Vec4> {
                refine_color(block, size)
            }
        }
    };
}

layered_color!(Rgba8);
layered_color!(Rgba16);

/// A layer that takes part in a composite.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a, F> {
    /// Its texels.
    pub field: &'a F,
    /// How they are seen.
    pub settings: Settings,
}

impl<T: Layered> Sheet<'_, Field<T>> {
    /// Whether the layer, as the lowest, is all that is seen of it.
    fn is_plain(&self) -> bool {
        self.settings == Settings::of(T::KIND)
    }
}

/// The values of `tile` with its ring at `size` texels a side, at least as many as the field has; `None` if it is not
/// allocated.
pub fn resampled<T: Layered>(field: &Field<T>, tile: u32, size: usize) -> Option<Vec<T::Sum>> {
    let mut values: Vec<T::Sum> = field.block(tile)?.iter().map(|texel| texel.sum()).collect();
    let mut from = field.size(tile) as usize;
    while from < size {
        values = T::refine(&values, from);
        from *= 2;
    }
    Some(values)
}

/// What `sheets`, from the lowest, come to in `tile` at `size` texels a side, ring included, over `background`.
pub fn blended<T: Layered>(sheets: &[Sheet<'_, Field<T>>], background: T, tile: u32, size: usize) -> Vec<T::Sum> {
    let mut sums = vec![background.sum(); (size + 2) * (size + 2)];
    for (index, sheet) in sheets.iter().enumerate().filter(|(_, sheet)| sheet.settings.visible) {
        let values = resampled(sheet.field, tile, size);
        if index == 0 && sheet.is_plain() {
            match values {
                Some(values) => sums = values,
                None => sums.fill(sheet.field.blank().sum()),
            }
            continue;
        }
        match values {
            Some(values) => {
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum = T::blend(*sum, value, &sheet.settings));
            }
            None => {
                let value = sheet.field.blank().sum();
                sums.iter_mut().for_each(|sum| *sum = T::blend(*sum, value, &sheet.settings));
            }
        }
    }
    sums
}

impl<T: Layered> Channel<T> {
    /// A channel over the surface of `field` with the sizes that `face_sizes` has for every face, without blocks.
    ///
    /// # Errors
    /// Fails if a size does not exist, or the store of pages fails.
    #[inline(never)]
    pub fn sized(field: &Field<T>, face_sizes: &[u32], blank: T, budget: u64) -> Result<Self> {
        let face_sizes = (0..).zip(face_sizes.iter().copied()).collect();
        let options = ChannelOptions { face_sizes, budget, ..ChannelOptions::default() };
        let mut channel = Self::blank(field.topology().clone(), blank, &options)?;
        channel.page_to(field.page_store().cloned())?;
        Ok(channel)
    }

    /// Makes `tiles` of a composite what `sheets`, from the lowest, come to over `background`. Tiles are allocated
    /// where a sheet that is seen is, and given back where none is. Returns tiles that the budget refused.
    ///
    /// No sheet may have more texels somewhere than the composite, which is not checked.
    ///
    /// # Errors
    /// Fails if a tile does not exist or is a hole, a blended number is not finite, or a page cannot be read or
    /// written.
    #[inline(never)]
    pub fn compose(
        &mut self,
        context: &Context,
        sheets: &[Sheet<'_, Field<T>>],
        background: T,
        tiles: &[u32],
    ) -> Result<Vec<u32>> {
        if self.page_store().is_none() {
            return self.compose_at_once(context, sheets, background, tiles);
        }
        // A part that leaves room for the neighbours it reaches.
        let largest = tiles.iter().map(|tile| self.field.tile_bytes(*tile)).max().unwrap_or(1);
        let part = usize::try_from(self.budget() / 4 / largest.max(1)).unwrap_or(usize::MAX).max(1);
        let mut refused = Vec::new();
        for tiles in tiles.chunks(part) {
            refused.extend(self.compose_at_once(context, sheets, background, tiles)?);
        }
        refused.sort_unstable();
        refused.dedup();
        refused.retain(|tile| !self.field.is_allocated(*tile));
        Ok(refused)
    }

    fn compose_at_once(
        &mut self,
        context: &Context,
        sheets: &[Sheet<'_, Field<T>>],
        background: T,
        tiles: &[u32],
    ) -> Result<Vec<u32>> {
        let there = |tile: &u32| sheets.iter().any(|sheet| sheet.settings.visible && sheet.field.is_allocated(*tile));
        let (mut allocate, mut deallocate) = (Vec::new(), Vec::new());
        for tile in tiles {
            if there(tile) { allocate.push(*tile) } else { deallocate.push(*tile) }
        }
        let sets = Sets { allocate, deallocate, ..Sets::default() };
        let applied = self.apply(&sets)?;
        let mut filled = sets.allocate;
        filled.sort_unstable();
        filled.dedup();
        filled.retain(|tile| self.field.is_allocated(*tile));
        let mut changes = self.edit(context, &filled, |tile, texels| {
            let size = texels.size();
            let sums = blended(sheets, background, tile, size);
            for (j, sums) in sums.chunks_exact(size + 2).skip(1).take(size).enumerate() {
                texels.row_mut(j).iter_mut().zip(&sums[1..]).for_each(|(texel, sum)| *texel = T::of_sum(*sum));
            }
        })?;
        changes.extend(applied.changes);
        let mut refused = applied.refused;
        refused.extend(self.settle(context, &changes)?);
        refused.sort_unstable();
        refused.dedup();
        Ok(refused)
    }

    /// A composite of `sheets` over `background` in place of this one: as fine everywhere as the finest of them.
    /// Readers that follow this channel follow it on. Returns tiles that the budget refused too.
    ///
    /// # Errors
    /// Fails if a blended number is not finite, or a page cannot be read or written.
    #[inline(never)]
    pub fn recomposed(
        &self,
        context: &Context,
        sheets: &[Sheet<'_, Field<T>>],
        background: T,
    ) -> Result<(Self, Vec<u32>)> {
        let mut finest: [Vec<u32>; 2] = [0; 2].map(|least| vec![least; self.field.topology().face_count()]);
        for Sheet { field, .. } in sheets {
            let (sizes, given) = (field.face_sizes(), field.given_sizes());
            let given = if given.is_empty() { sizes.clone() } else { given };
            for (finest, sizes) in finest.iter_mut().zip([sizes, given]) {
                finest.iter_mut().zip(sizes).for_each(|(finest, size)| *finest = size.max(*finest));
            }
        }
        let [sizes, given] = finest;
        let blank = T::of_sum(blended_blank(sheets, background));
        let mut fresh = Self::sized(&self.field, &sizes, blank, self.budget())?;
        fresh.reshape(&sizes, &given)?;
        fresh.blocks.revision = self.blocks.revision;
        fresh.page_to(self.page_store().cloned())?;
        let mut tiles: Vec<u32> =
            sheets.iter().filter(|sheet| sheet.settings.visible).flat_map(|sheet| sheet.field.allocated()).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let refused = fresh.compose(context, sheets, background, &tiles)?;
        fresh.follow(self);
        Ok((fresh, refused))
    }

    /// Takes the place of `before`: what differs counts as changed.
    #[inline(never)]
    pub fn follow(&mut self, before: &Self) {
        self.blocks.revision = self.blocks.revision.max(before.blocks.revision) + 1;
        let blank = !self.field.blank().same(before.field.blank());
        let (changed, listed) = (before.pending(), self.field.allocated().chain(before.field.allocated()));
        let mut tiles: Vec<u32> = changed.iter().copied().chain(listed).collect();
        if blank {
            tiles.extend(0..self.field.tile_count() as u32);
        }
        let revision = self.blocks.revision;
        for tile in tiles {
            if let Some(entry) = self.field.entry_mut(tile) {
                entry.version = revision;
            }
            self.mark(tile);
        }
    }
}

/// What tiles read as that no sheet has.
fn blended_blank<T: Layered>(sheets: &[Sheet<'_, Field<T>>], background: T) -> T::Sum {
    let seen = sheets.iter().enumerate().filter(|(_, sheet)| sheet.settings.visible);
    seen.fold(background.sum(), |below, (index, sheet)| {
        let blank = sheet.field.blank().sum();
        if index == 0 && sheet.is_plain() { blank } else { T::blend(below, blank, &sheet.settings) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_document::Kind;

    #[test]
    fn opaque_colours_blend_as_their_formulas_say() {
        let (below, layer) = (Vec4::new(0.2, 0.5, 0.8, 1.0), Vec4::new(0.6, 0.6, 0.1, 1.0));
        let on = |blend| blend_color(below, layer, &Settings { blend, ..Settings::of(Kind::Rgba8) });
        let expected = |f: fn(f32, f32) -> f32| {
            let rgb = [0, 1, 2].map(|axis: usize| f(below[axis], layer[axis]));
            Vec4::new(rgb[0], rgb[1], rgb[2], 1.0)
        };
        let formulas: [(Blend, fn(f32, f32) -> f32); 7] = [
            (Blend::Normal, |_, s| s),
            (Blend::Add, |d, s| d + s),
            (Blend::Multiply, |d, s| d * s),
            (Blend::Screen, |d, s| d + s - d * s),
            (Blend::Overlay, |d, s| if d <= 0.5 { 2.0 * d * s } else { 1.0 - 2.0 * (1.0 - d) * (1.0 - s) }),
            (Blend::Max, f32::max),
            (Blend::Min, f32::min),
        ];
        for (blend, formula) in formulas {
            let found = on(blend);
            assert!((found - expected(formula)).abs().max_element() < 1e-6, "{blend:?}: {found}");
            // A layer that is not there leaves what is below, in every mode.
            let nothing = blend_color(below, Vec4::ZERO, &Settings { blend, ..Settings::of(Kind::Rgba8) });
            assert!((nothing - below).abs().max_element() < 1e-6, "{blend:?}: {nothing}");
            let half = blend_color(below, layer, &Settings { blend, opacity: 0.5, visible: true });
            assert!((half - 0.5 * (below + expected(formula))).abs().max_element() < 1e-6, "{blend:?}: {half}");
        }
    }

    #[test]
    fn colours_between_texels_are_those_of_the_look_up() {
        let block: Vec<Vec4> = (0..100).map(|k| Vec4::splat(((k * 37) % 11) as f32)).collect();
        let fine = refine_color(&block, 8);
        assert_eq!(fine.len(), 18 * 18);
        // A fine texel is a quarter of a coarse one beside its parent.
        let at = |i: usize, j: usize| block[j * 10 + i].x;
        let expected = 0.75 * (0.75 * at(3, 4) + 0.25 * at(4, 4)) + 0.25 * (0.75 * at(3, 3) + 0.25 * at(4, 3));
        assert!((fine[7 * 18 + 6].x - expected).abs() < 1e-6);
    }
}
