//! What a channel must be able to do to be a layer: blocks that are read and put back, a composite over others, and
//! edits of that composite taken into the layer. Units: object units, linear light.

use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Result};
use relievo_document::{Blend, PageStore, Settings};
use relievo_tiles::composite::{blended, resampled};
use relievo_tiles::spline::coarsen_block;
use relievo_tiles::{Blocks, Channel, Decay, Field, Layered, Rgba8, Rgba16, Sets, Sheet, StoredTexel};

use crate::channels::fading::LayerDecay;
/// A channel whose blocks can be read and put back by number, whatever they are blocks of.
pub trait BlockChannel: Debug + Send + Sync {
    /// What it is at one moment.
    type Field: Blocks + Clone;

    /// As it is now.
    fn field(&self) -> &Self::Field;

    /// Bytes that it may occupy.
    fn budget(&self) -> u64;

    /// Changes the budget. Blocks stay, even beyond it.
    fn set_budget(&mut self, budget: u64);

    /// The bytes of a block; `None` if it is not there.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such block or it belongs to a hole, and as the page store does if it is on a
    /// page that cannot be read.
    fn read(&self, block: u32) -> Result<Option<Vec<u8>>>;

    /// Puts back what [`Self::read`] gave.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such block, the length is not that of the block or a
    /// number is not finite, with `Memory` if the budget does not allow it, and as the page store does if a page cannot
    /// be read or written.
    fn write(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()>;

    /// Gives and takes what must be there beside `blocks` that were put back, whatever the budget says. Nothing for channels
    /// whose blocks stand by themselves.
    ///
    /// # Errors
    /// Fails as the page store does if a page cannot be read or written.
    fn mend(&mut self, _context: &Context, _blocks: &[u32]) -> Result<()> {
        Ok(())
    }

    /// Makes edits visible to readers. Returns the blocks that changed, ascending.
    fn commit(&mut self) -> Vec<u32>;

    /// Gives every face the size that `sizes` has for it, of which it was given `given`, or the same if that is empty:
    /// blocks that had another go. Nothing for channels whose blocks have their size by themselves.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if a size does not exist or faces lack one, and as the page store
    /// does if a page cannot be read or written.
    fn reshape(&mut self, _sizes: &[u32], _given: &[u32]) -> Result<()> {
        Ok(())
    }

    /// Makes blocks leave memory for `pages` when the budget is spent; without, all come back.
    ///
    /// # Errors
    /// Fails as the page store does if a block cannot be read back or written.
    fn page_to(&mut self, pages: Option<&Arc<dyn PageStore>>) -> Result<()>;

    /// Reports a failure of the page store, once.
    ///
    /// # Errors
    /// Fails with the error of the page store about what could not be read back from a page, or written to one, since
    /// this was called last.
    fn report_fault(&self) -> Result<()>;
}

/// A channel that layers are kept in.
pub trait LayerChannel: BlockChannel + Clone {
    /// What it holds.
    type Texel: Layered;
    /// The stamps of it, where its edits fade.
    type Decay: LayerDecay<Self>;

    /// A channel over the surface of `field` with the sizes that `face_sizes` has for every face, without blocks.
    ///
    /// # Errors
    /// Fails with `Invalid` if a size does not exist, and with `Memory` if the budget does not hold what every channel
    /// needs: the vertices of a triangle mesh.
    fn sized(field: &Self::Field, face_sizes: &[u32], blank: Self::Texel, budget: u64) -> Result<Self>;

    /// Makes `blocks` of a composite what `sheets`, from the lowest, come to over `background`. Returns what the budget
    /// refused.
    ///
    /// # Errors
    /// Fails with `Invalid` if a tile does not exist or is a hole or a blended number is not finite, and as the page
    /// store does if a page cannot be read or written.
    fn compose(
        &mut self,
        context: &Context,
        sheets: &[Sheet<'_, Self::Field>],
        background: Self::Texel,
        blocks: &[u32],
    ) -> Result<Vec<u32>>;

    /// A composite of `sheets` over `background` in place of this one: as fine everywhere as the finest of them.
    /// Returns what the budget refused too.
    ///
    /// # Errors
    /// Fails with `Invalid` if a blended number is not finite, or `sheets` is empty on a surface of tiles, and as the
    /// page store does if a page cannot be read or written.
    fn recomposed(
        &self,
        context: &Context,
        sheets: &[Sheet<'_, Self::Field>],
        background: Self::Texel,
    ) -> Result<(Self, Vec<u32>)>;

    /// Takes the place of `before`: what differs counts as changed.
    fn follow(&mut self, before: &Self);

    /// Whether `field` has a block for a tile or a face.
    fn is_allocated(field: &Self::Field, tile: u32) -> bool;

    /// Whether a tile, or a face with what would be lost with it, was edited between `before` and `field`.
    fn is_edited(field: &Self::Field, before: &Self::Field, tile: u32) -> bool;

    /// Names tiles or faces that may be lost where the budget refuses others, the first of them first, unless they are
    /// edited meanwhile.
    fn set_expendable(&mut self, tiles: &[u32]);

    /// The tiles or faces that were lost since this was called last, because the budget had no room for others.
    fn take_lost(&mut self) -> Vec<u32>;

    /// Loses those of `tiles` that fade and were not edited since that was said.
    ///
    /// # Errors
    /// Fails as the page store does if a page cannot be read or written; always succeeds on a triangle mesh.
    fn lose(&mut self, context: &Context, tiles: &[u32]) -> Result<()>;

    /// Loses `tiles`, whether they fade or not.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if a tile or face does not exist or is a hole. Fails too as the page
    /// store does if a page cannot be read or written.
    fn lose_all(&mut self, context: &Context, tiles: &[u32]) -> Result<()>;

    /// Takes `tiles` away from `field`.
    fn forget(field: &mut Self::Field, tiles: &[u32]);

    /// Whether edits are made on the composite.
    const THROUGH_COMPOSITE: bool;

    /// Puts what was changed in `blocks` of the composite, from `composite[0]` to `composite[1]`, into this layer,
    /// which is seen with `settings` over what `below` comes to on `background`. Returns what the budget refused.
    ///
    /// # Errors
    /// Fails with `Invalid` if a tile does not exist or is a hole, with `Memory` if the budget does not allow the sizes
    /// that faces of the composite were given, and as the page store does if a page cannot be read or written.
    fn absorb(
        &mut self,
        context: &Context,
        composite: [&Self::Field; 2],
        below: (&[Sheet<'_, Self::Field>], Self::Texel),
        settings: Settings,
        blocks: &[u32],
    ) -> Result<Vec<u32>>;
}

/// The least opacity of a layer that edits of displacement can be divided by.
pub(crate) const FAINTEST: f32 = 1.0 / 256.0;

/// A texel whose layers can be edited through their composite.
pub trait Absorb: Layered {
    /// Puts what was changed in `tile` of the composite, from `before`, into `texels` of the active layer, row by row
    /// without ring, where `below` is what is seen below it. Nothing for kinds that are not edited so.
    fn absorb(tile: &Absorbed<'_, Self>, texels: &mut relievo_tiles::Texels<'_, Self>);

    /// The layer's texel, which was `old`, after that of the composite went `from[0]` to `from[1]`, where `below` is
    /// seen below the layer.
    fn take_in(old: Self, from: [Self::Sum; 2], below: impl Fn() -> Self::Sum, settings: &Settings) -> Self;

    /// Whether edits are made on the composite.
    const THROUGH_COMPOSITE: bool;
}

/// A tile of the composite that was edited.
#[derive(Debug)]
pub struct Absorbed<'a, T: Layered> {
    tile: u32,
    composite: [&'a Field<T>; 2],
    /// What is below the active layer.
    below: &'a [Sheet<'a, Field<T>>],
    background: T,
    settings: Settings,
}

macro_rules! absorb_nothing {
    ($texel:ty) => {
        impl Absorb for $texel {
            fn absorb(_: &Absorbed<'_, Self>, _: &mut relievo_tiles::Texels<'_, Self>) {}

            fn take_in(old: Self, _: [Vec4; 2], _: impl Fn() -> Vec4, _: &Settings) -> Self {
                old
            }

            const THROUGH_COMPOSITE: bool = false;
        }
    };
}

absorb_nothing!(Rgba8);
absorb_nothing!(Rgba16);

impl Absorb for f16 {
    const THROUGH_COMPOSITE: bool = true;

    fn take_in(old: Self, from: [f32; 2], below: impl Fn() -> f32, settings: &Settings) -> Self {
        let (old, change, opacity) = (old.to_f32(), from[1] - from[0], settings.opacity);
        // Where the layer cannot be seen it has no part.
        let part = |below: f32| (f16::blend(below, old, settings) + change - below) / opacity;
        let new = match settings.blend {
            Blend::Subtract => old - change / opacity,
            Blend::Max => below() + part(below()).max(0.0),
            Blend::Min => below() + part(below()).min(0.0),
            _ => old + change / opacity,
        };
        f16::from_f32(new.clamp(-65504.0, 65504.0))
    }

    fn absorb(edited: &Absorbed<'_, Self>, texels: &mut relievo_tiles::Texels<'_, Self>) {
        let (tile, size) = (edited.tile, texels.size());
        // As fine as the finest of what was, what is and the layer.
        let mut from = edited.composite.iter().map(|field| field.size(tile) as usize).fold(size, usize::max);
        let values = |field: &Field| resampled(field, tile, from).unwrap_or_else(|| vec![0.0; (from + 2) * (from + 2)]);
        let [before, mut change] = edited.composite.map(values);
        change.iter_mut().zip(before).for_each(|(now, then)| *now -= then);
        let mut below = match edited.settings.blend {
            Blend::Max | Blend::Min => blended(edited.below, edited.background, tile, from),
            _ => Vec::new(),
        };
        while from > size {
            change = coarsen_block(&change, from);
            if !below.is_empty() {
                below = coarsen_block(&below, from);
            }
            from /= 2;
        }
        for j in 0..size {
            let start = (j + 1) * (size + 2) + 1;
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                let at = start + i;
                let change = change[at];
                if change == 0.0 {
                    continue;
                }
                *texel = Self::take_in(*texel, [0.0, change], || below[at], &edited.settings);
            }
        }
    }
}

impl<T: StoredTexel> BlockChannel for Channel<T> {
    type Field = Field<T>;

    fn field(&self) -> &Field<T> {
        Channel::field(self)
    }

    fn budget(&self) -> u64 {
        Channel::budget(self)
    }

    fn set_budget(&mut self, budget: u64) {
        Channel::set_budget(self, budget);
    }

    fn read(&self, block: u32) -> Result<Option<Vec<u8>>> {
        Channel::read(self, block)
    }

    fn write(&mut self, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        Channel::write(self, block, bytes)
    }

    fn commit(&mut self) -> Vec<u32> {
        Channel::commit(self).changed().to_vec()
    }

    fn reshape(&mut self, sizes: &[u32], given: &[u32]) -> Result<()> {
        Channel::reshape(self, sizes, given)
    }

    fn page_to(&mut self, pages: Option<&Arc<dyn PageStore>>) -> Result<()> {
        Channel::page_to(self, pages.cloned())
    }

    fn report_fault(&self) -> Result<()> {
        Channel::report_fault(self)
    }
}

impl<T: Absorb> LayerChannel for Channel<T> {
    type Texel = T;
    type Decay = Decay<T>;

    const THROUGH_COMPOSITE: bool = T::THROUGH_COMPOSITE;

    fn sized(field: &Field<T>, face_sizes: &[u32], blank: T, budget: u64) -> Result<Self> {
        Channel::sized(field, face_sizes, blank, budget)
    }

    fn compose(
        &mut self,
        context: &Context,
        sheets: &[Sheet<'_, Field<T>>],
        background: T,
        tiles: &[u32],
    ) -> Result<Vec<u32>> {
        Channel::compose(self, context, sheets, background, tiles)
    }

    fn recomposed(&self, context: &Context, sheets: &[Sheet<'_, Field<T>>], background: T) -> Result<(Self, Vec<u32>)> {
        Channel::recomposed(self, context, sheets, background)
    }

    fn follow(&mut self, before: &Self) {
        Channel::follow(self, before);
    }

    fn is_allocated(field: &Field<T>, tile: u32) -> bool {
        field.is_allocated(tile)
    }

    fn is_edited(field: &Field<T>, before: &Field<T>, tile: u32) -> bool {
        field.version(tile) != before.version(tile)
    }

    fn set_expendable(&mut self, tiles: &[u32]) {
        Channel::set_expendable(self, tiles);
    }

    fn take_lost(&mut self) -> Vec<u32> {
        Channel::take_lost(self)
    }

    fn lose(&mut self, context: &Context, tiles: &[u32]) -> Result<()> {
        Channel::lose_expendable(self, context, tiles)
    }

    fn lose_all(&mut self, context: &Context, tiles: &[u32]) -> Result<()> {
        Channel::lose_tiles(self, context, tiles)
    }

    fn forget(field: &mut Field<T>, tiles: &[u32]) {
        field.forget(tiles);
    }

    fn absorb(
        &mut self,
        context: &Context,
        composite: [&Field<T>; 2],
        (below, background): (&[Sheet<'_, Field<T>>], T),
        settings: Settings,
        tiles: &[u32],
    ) -> Result<Vec<u32>> {
        let [before, after] = composite;
        let resized: Vec<u32> = tiles.iter().copied().filter(|tile| before.size(*tile) != after.size(*tile)).collect();
        let resized = self.follow_sizes(context, after, &resized)?;
        let applied = self.apply(&Sets { allocate: tiles.to_vec(), ..Sets::default() })?;
        let allocated = |tile: &u32| Channel::field(self).is_allocated(*tile);
        let kept: Vec<u32> = tiles.iter().copied().filter(allocated).collect();
        let mut changes = self.edit(context, &kept, |tile, texels| {
            T::absorb(&Absorbed { tile, composite, below, background, settings }, texels);
        })?;
        changes.extend(applied.changes);
        changes.extend(resized);
        let mut refused = applied.refused;
        refused.extend(self.settle(context, &changes)?);
        self.reclaim(context, &kept)?;
        Ok(refused)
    }
}
