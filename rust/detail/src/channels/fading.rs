//! Layers whose edits fade (Schäfer et al. 2015, Section 7.2): displacement and colours that were edited before the
//! time that the object comes to. See [`relievo_tiles::decay`].
//!
//! What is left of an edit at a time follows from the stamps alone. So histories and documents hold these, and what
//! they hold of the texels is brought to the object's time when it is put back. Units: seconds, bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_document::head::STAMPS_OF;
use relievo_document::{Document, Head, Kind, Stamps};
use relievo_gpu::Device;
use relievo_tiles::{Blocks, Channel, Decay, DecayOptions, Field, StoredTexel, by_format};

use crate::channels::history::{BlockState, LayerState};
use crate::channels::layer_channel::{Absorb, BlockChannel, LayerChannel};
use crate::channels::layered::{LayeredObject, Layers, each_stack};
use crate::channels::layers::{Layer, Stack, no_layer};

/// The stamps of a channel that layers are kept in.
pub trait LayerDecay<C: LayerChannel>: Debug + Send + Sync + Sized {
    /// No stamps yet, for a channel that is `field`; they may occupy `budget` bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if a time is not finite, the delay is below 0 or the duration not above 0, and with
    /// `Memory` if the budget does not hold what every channel needs: the vertices of a triangle mesh.
    fn new(field: &C::Field, options: DecayOptions, budget: u64) -> Result<Self>;

    /// When edits fade.
    fn options(&self) -> DecayOptions;

    /// Replaces the decay times; edits already recorded follow the new ones.
    ///
    /// # Errors
    /// Fails with `Invalid` if a time is not finite, the delay is below 0 or the duration not above 0.
    fn set_options(&mut self, options: DecayOptions) -> Result<()>;

    /// Bytes of the stamps and what they belong to.
    fn bytes(&self) -> u64;

    /// Has a graphics device evaluate what is left of edits from now on, or the processor again, which also takes over
    /// where the device fails.
    fn use_device(&mut self, device: Option<&Device>);

    /// The failure after which the processor took over, told once.
    fn take_device_fault(&mut self) -> Option<Error>;

    /// The newest stamp there is.
    fn newest(&self) -> Option<f32>;

    /// The tiles or faces that hold nothing but what fades, beginning with those whose newest stamp is oldest, each
    /// behind a number that grows with that stamp.
    fn oldest(&self) -> Vec<(u64, u32)>;

    /// Stamps with `time` all in which `channel` now differs from `before`. Returns the tiles or faces, ascending, that
    /// the budget refused.
    ///
    /// # Errors
    /// Fails with `Invalid` if `channel` is over triangles and has a face that the mesh of the stamps does not have.
    fn stamp(&mut self, context: &Context, before: &C::Field, channel: &C, time: f64) -> Result<Vec<u32>>;

    /// Brings `channel` to what is left of it at `time`, and gives back what has faded. Returns the tiles or faces that
    /// look different.
    ///
    /// # Errors
    /// Fails as [`Self::stamp`], and as the page store does if a page cannot be read or written. The processor takes
    /// over where a device fails.
    fn fade(&mut self, context: &Context, channel: &mut C, time: f64) -> Result<Vec<u32>>;

    /// As [`Self::fade`] without giving anything back, after stamps and `restored` blocks of the channel were put back.
    ///
    /// # Errors
    /// Fails as [`Self::fade`], and with `Invalid` if a tile of `restored` does not exist or is a hole.
    fn bring(&mut self, context: &Context, channel: &mut C, time: f64, restored: &[u32]) -> Result<Vec<u32>>;

    /// The blocks that hold stamps, ascending.
    fn stamped(&self) -> Vec<u32>;

    /// The blocks whose stamps changed since this was called last, ascending.
    fn take_changed(&mut self) -> Vec<u32>;

    /// The stamps of a block as bytes, with what they belong to; `None` without stamps.
    fn read(&self, block: u32) -> Option<Vec<u8>>;

    /// Puts back what [`Self::read`] gave, of a channel that is `field`.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such block, the bytes are not the stamps of one or a number is not finite,
    /// and with `Memory` if the budget does not allow it.
    fn write(&mut self, field: &C::Field, block: u32, bytes: Option<&[u8]>) -> Result<()>;

    /// As [`Self::write`], whatever the budget says.
    ///
    /// # Errors
    /// Fails as [`Self::write`], but for the budget.
    fn restore(&mut self, field: &C::Field, block: u32, bytes: Option<&[u8]>) -> Result<()>;

    /// What documents say of the stamps of the layer `layer`.
    fn head(&self, layer: u32) -> Stamps;

    /// The stamps as histories and documents see them.
    fn blocks(&self, field: &C::Field) -> Arc<dyn Blocks>;

    /// The stamps that `document` has as the layer called `name`, for a channel that is `field`, in `budget` bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer, its stamps are those of other texels or it is damaged, and with
    /// `Memory` if `budget` is too small.
    fn stored(context: &Context, document: &Document, name: &str, field: &C::Field, budget: u64) -> Result<Self>;
}

impl<T: Absorb> LayerDecay<Channel<T>> for Decay<T> {
    fn new(field: &Field<T>, options: DecayOptions, budget: u64) -> Result<Self> {
        Decay::new(field.tile_count(), options, budget)
    }

    fn options(&self) -> DecayOptions {
        Decay::options(self)
    }

    fn set_options(&mut self, options: DecayOptions) -> Result<()> {
        Decay::set_options(self, options)
    }

    fn bytes(&self) -> u64 {
        Decay::bytes(self)
    }

    fn use_device(&mut self, device: Option<&Device>) {
        Decay::use_device(self, device);
    }

    fn take_device_fault(&mut self) -> Option<Error> {
        Decay::take_device_fault(self)
    }

    fn newest(&self) -> Option<f32> {
        Decay::newest(self)
    }

    fn oldest(&self) -> Vec<(u64, u32)> {
        Decay::oldest(self)
    }

    fn stamp(&mut self, context: &Context, before: &Field<T>, channel: &Channel<T>, time: f64) -> Result<Vec<u32>> {
        Ok(Decay::stamp(self, context, before, channel, time))
    }

    fn fade(&mut self, context: &Context, channel: &mut Channel<T>, time: f64) -> Result<Vec<u32>> {
        Ok(Decay::fade(self, context, channel, time)?.changed)
    }

    fn bring(&mut self, context: &Context, channel: &mut Channel<T>, time: f64, restored: &[u32]) -> Result<Vec<u32>> {
        Decay::bring(self, context, channel, time, restored)
    }

    fn stamped(&self) -> Vec<u32> {
        Decay::stamped(self).collect()
    }

    fn take_changed(&mut self) -> Vec<u32> {
        Decay::take_changed(self)
    }

    fn read(&self, tile: u32) -> Option<Vec<u8>> {
        Decay::read(self, tile)
    }

    fn write(&mut self, field: &Field<T>, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        Decay::write(self, field, tile, bytes)
    }

    fn restore(&mut self, field: &Field<T>, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        Decay::restore(self, field, tile, bytes)
    }

    fn head(&self, layer: u32) -> Stamps {
        Decay::head(self, layer)
    }

    fn blocks(&self, field: &Field<T>) -> Arc<dyn Blocks> {
        Arc::new(Decay::blocks(self, field))
    }

    fn stored(context: &Context, document: &Document, name: &str, field: &Field<T>, budget: u64) -> Result<Self> {
        Decay::stored(context, document, name, field, budget)
    }
}

/// The decay of a layer.
#[derive(Debug)]
pub(crate) struct LayerDecayState<C: LayerChannel> {
    /// The number of its stamps as a layer of documents.
    number: u32,
    decay: C::Decay,
    /// What has been stamped.
    stamped: C::Field,
}

impl<C: LayerChannel> Stack<C> {
    /// Says whether it holds what `kind` does: displacement, or colours of any format.
    fn is_like(&self, kind: Kind) -> bool {
        C::Texel::KIND.is_color() == kind.is_color()
    }

    /// Returns the layers that fade, in the order of their stamps in documents: their numbers, decays and texels.
    fn fading(&self) -> Vec<(u32, &LayerDecayState<C>, &C)> {
        let mut fading: Vec<_> = self.decays().filter_map(|(id, faded, channel)| Some((id, faded?, channel))).collect();
        fading.sort_by_key(|(_, faded, _)| faded.number);
        fading
    }

    /// As [`Self::fading`], for writing.
    fn fading_mut(&mut self) -> Vec<(u32, &mut LayerDecayState<C>, &mut C)> {
        let decays = self.decays_mut();
        let mut fading: Vec<_> =
            decays.filter_map(|(id, faded, channel)| Some((id, faded.as_mut()?, channel))).collect();
        fading.sort_by_key(|(_, faded, _)| faded.number);
        fading
    }

    /// Stamps what was edited since it was last done. Returns the tiles or faces that budgets refused, and the lost
    /// ones.
    fn stamp(&mut self, context: &Context, time: f64) -> Result<[Vec<u32>; 2]> {
        let (mut refused, mut lost) = (Vec::new(), Vec::new());
        for (_, faded, channel) in self.fading_mut() {
            let mut left = faded.decay.stamp(context, &faded.stamped, channel, time)?;
            if !left.is_empty() {
                // Tiles that have no room take that of the oldest, unless these were edited now.
                let mut oldest = faded.decay.oldest();
                oldest.retain(|(_, tile)| !C::is_edited(channel.field(), &faded.stamped, *tile));
                while !left.is_empty() && !oldest.is_empty() {
                    let gone: Vec<u32> = oldest.drain(..left.len().min(oldest.len())).map(|(_, tile)| tile).collect();
                    if channel.lose_all(context, &gone).is_err() {
                        break;
                    }
                    left = faded.decay.stamp(context, &faded.stamped, channel, time)?;
                }
            }
            refused.extend(left);
            lost.extend(channel.take_lost());
            faded.stamped = channel.field().clone();
        }
        self.name_expendable();
        Ok([refused, lost])
    }

    /// Says which tiles may be lost: of a layer that fades the tiles that hold nothing else, of the composite the tiles
    /// that only such layers have.
    fn name_expendable(&mut self) {
        let mut ages: BTreeMap<u32, u64> = BTreeMap::new();
        let mut named = Vec::with_capacity(self.layers().len());
        for (_, faded, channel) in self.decays_mut() {
            let oldest = faded.as_ref().map_or_else(Vec::new, |faded| faded.decay.oldest());
            for (age, tile) in &oldest {
                let newest = ages.entry(*tile).or_insert(*age);
                *newest = (*newest).max(*age);
            }
            let tiles: Vec<u32> = oldest.into_iter().map(|(_, tile)| tile).collect();
            channel.set_expendable(&tiles);
            named.push(tiles.into_iter().collect::<BTreeSet<u32>>());
        }
        if self.is_plain() {
            return;
        }
        for ((_, _, channel), named) in self.decays().zip(&named) {
            ages.retain(|tile, _| named.contains(tile) || !C::is_allocated(channel.field(), *tile));
        }
        let mut tiles: Vec<(u64, u32)> = ages.into_iter().map(|(tile, age)| (age, tile)).collect();
        tiles.sort_unstable();
        self.composite_mut().set_expendable(&tiles.into_iter().map(|(_, tile)| tile).collect::<Vec<_>>());
    }

    /// Has `device` evaluate it, if there is one. Returns the tiles or faces that look different, and why the processor
    /// took over, if it had to.
    #[inline(never)]
    fn fade(&mut self, context: &Context, time: f64, device: Option<&Device>) -> Result<(Vec<u32>, Option<Error>)> {
        let (mut shown, mut fault) = (Vec::new(), None);
        for (_, faded, channel) in self.fading_mut() {
            faded.decay.use_device(device);
            shown.extend(faded.decay.fade(context, channel, time)?);
            fault = faded.decay.take_device_fault().or(fault);
        }
        Ok((shown, fault))
    }

    #[inline(never)]
    fn take_as_stamped(&mut self) {
        for (_, faded, channel) in self.fading_mut() {
            faded.stamped = channel.field().clone();
        }
        self.name_expendable();
    }

    /// Makes the edits of a layer fade from now on, or stay. Fails if the times are invalid or there is no such layer.
    fn set_decay(&mut self, layer: u32, number: u32, options: Option<(DecayOptions, u64)>) -> Result<()> {
        let there = self.decays_mut().find(|(id, ..)| *id == layer);
        let (_, faded, channel) = there.ok_or_else(|| no_layer(layer))?;
        match (options, faded) {
            (Some((options, _)), Some(faded)) => faded.decay.set_options(options)?,
            (Some((options, budget)), none) => {
                let (decay, stamped) = (C::Decay::new(channel.field(), options, budget)?, channel.field().clone());
                *none = Some(LayerDecayState { number, decay, stamped });
            }
            (None, faded) => *faded = None,
        }
        self.name_expendable();
        Ok(())
    }

    /// Puts back stamps, and brings their layers to `time`, whose blocks were put back.
    #[inline(never)]
    fn restore_stamps(
        &mut self,
        context: &Context,
        heads: Option<&[Head]>,
        blocks: &[BlockState],
        time: f64,
    ) -> Result<()> {
        if let Some(heads) = heads {
            for (_, faded, _) in self.decays_mut() {
                faded.take_if(|faded| !heads.iter().any(|head| head.id == faded.number));
            }
            for head in heads {
                let Some(stamps) = head.stamps.filter(|stamps| stamps.texel == C::Texel::KIND) else { continue };
                let options = DecayOptions { delay: stamps.delay, duration: stamps.duration };
                let budget = self.composite().budget();
                self.set_decay(stamps.layer, head.id, Some((options, budget)))?;
            }
        }
        for (id, faded, channel) in self.fading_mut() {
            for block in blocks.iter().filter(|block| block.layer == faded.number) {
                faded.decay.restore(channel.field(), block.block, block.bytes.as_deref())?;
            }
            let restored: Vec<u32> = blocks.iter().filter(|block| block.layer == id).map(|block| block.block).collect();
            faded.decay.bring(context, channel, time, &restored)?;
        }
        Ok(())
    }

    /// Gives the stamps of layers that stay other numbers, from `number` on; releases them if layers do not `stay`.
    fn renumber_stamps(&mut self, stay: bool, number: &mut u32) {
        if !stay {
            self.decays_mut().for_each(|(_, faded, _)| *faded = None);
        }
        for (_, faded, _) in self.fading_mut() {
            faded.number = *number;
            *number += 1;
        }
    }

    /// Takes over the stamps that `document` has of these layers. Returns the newest of them.
    #[inline(never)]
    fn take_up_stamps(&mut self, context: &Context, document: &Document, budget: u64) -> Result<Option<f32>> {
        let mut newest: Option<f32> = None;
        for layer in document.layers() {
            let Some(Stamps { layer: of, texel, .. }) = layer.head().stamps else { continue };
            let there = self.decays_mut().find(|(id, ..)| *id == of && texel == C::Texel::KIND);
            let Some((_, faded, channel)) = there else { continue };
            let stamped = channel.field().clone();
            let decay = C::Decay::stored(context, document, layer.name(), &stamped, budget)?;
            newest = newest.into_iter().chain(decay.newest()).reduce(f32::max);
            *faded = Some(LayerDecayState { number: layer.id(), decay, stamped });
        }
        Ok(newest)
    }

    /// Brings all layers to what is left of them at `time`, after their stamps were taken over.
    #[inline(never)]
    fn bring(&mut self, context: &Context, time: f64) -> Result<()> {
        let mut fading = self.fading_mut().into_iter();
        fading.try_for_each(|(_, faded, channel)| faded.decay.bring(context, channel, time, &[]).map(drop))
    }

    /// Reads the stamps of `tile`, for caches: of the only layer that fades, or of all one after the other, each behind
    /// its length. `None` without stamps.
    fn read_stamps(&self, tile: u32) -> Option<Vec<u8>> {
        let fading = self.fading();
        if let [(_, only, _)] = fading[..] {
            return only.decay.read(tile);
        }
        let (mut all, mut any) = (Vec::new(), false);
        for (_, faded, _) in fading {
            let block = faded.decay.read(tile);
            any |= block.is_some();
            let block = block.unwrap_or_default();
            all.extend((block.len() as u32).to_le_bytes());
            all.extend(block);
        }
        any.then_some(all)
    }

    /// Puts back what [`Self::read_stamps`] gave of the same layers, after their own blocks.
    fn write_stamps(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        let misfit = || Error::invalid("stamps do not fit the layers").at(format!("tile {tile}"));
        let mut rest = bytes;
        let fading = self.fading_mut();
        let (single, none) = (fading.len() == 1, fading.is_empty());
        for (_, faded, channel) in fading {
            let mut block = rest;
            if let (Some(bytes), false) = (rest, single) {
                let (length, after) = bytes.split_first_chunk().ok_or_else(misfit)?;
                let (own, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(misfit)?;
                block = (!own.is_empty()).then_some(own);
                rest = Some(after);
            }
            faded.decay.write(channel.field(), tile, block)?;
        }
        if none && bytes.is_some() || !single && rest.is_some_and(|rest| !rest.is_empty()) {
            return Err(misfit());
        }
        Ok(())
    }
}

fn sorted(mut tiles: Vec<u32>) -> Vec<u32> {
    tiles.sort_unstable();
    tiles.dedup();
    tiles
}

/// An object whose edits may fade: every one that has layers.
pub trait DecayingObject: LayeredObject {
    /// Makes edits of the object's own displacement and colours, the lowest layers, fade from now on; what was edited
    /// before stays. Stamps may occupy `budget` bytes for each of the two.
    ///
    /// # Errors
    /// Fails with `Invalid` if a time is not finite, the delay is below 0 or the duration not above 0, and with
    /// `Memory` if the budget does not hold what every channel needs.
    #[inline(never)]
    fn set_decay(&mut self, options: DecayOptions, budget: u64) -> Result<()> {
        options.check()?;
        self.stacks_mut().decay = Some((options, budget));
        self.fade_own()
    }

    /// Gives the lowest layers the decay of the object, if it has one and they have none.
    ///
    /// # Errors
    /// Fails with `Memory` if the budget of the decay does not hold what every channel needs.
    #[inline(never)]
    fn fade_own(&mut self) -> Result<()> {
        let Some(own) = self.stacks().decay else { return Ok(()) };
        let first = self.free_number();
        each_stack!(self.stacks_mut(), stack => {
            if let Some(lowest) = stack.layers().first().map(Layer::id) {
                stack.set_decay(lowest, first + u32::from(stack.is_like(Kind::Rgba8)), Some(own))?;
            }
        });
        Ok(())
    }

    /// Makes edits of the layer `id` fade from now on, or stay; earlier edits too, if they have been stamped. Its
    /// stamps may occupy `budget` bytes. Where that or the budget of the layer is full, the tiles or faces of the layer
    /// whose newest edit is oldest are lost to make room, see [`Self::take_lost`].
    ///
    /// # Errors
    /// Fails, and leaves the decay of the layer as it was, with `Invalid` if the times are invalid or there is no such
    /// layer, with `Memory` if the budget does not hold what every channel needs, and as [`LayeredObject::settle`] and
    /// [`Self::stamp`].
    #[inline(never)]
    fn set_layer_decay(
        &mut self,
        context: &Context,
        id: u32,
        options: Option<DecayOptions>,
        budget: u64,
    ) -> Result<()> {
        options.map_or(Ok(()), |options| options.check())?;
        self.settle(context)?;
        self.stamp(context)?;
        let number = self.free_number();
        let mut done = Err(no_layer(id));
        each_stack!(self.stacks_mut(), stack => {
            if stack.channel(id).is_some() {
                done = stack.set_decay(id, number, options.map(|options| (options, budget)));
            }
        });
        done
    }

    /// Says whether edits of any layer fade.
    fn is_fading(&self) -> bool {
        let mut any = false;
        each_stack!(self.stacks(), stack => any |= !stack.fading().is_empty());
        any
    }

    /// Says when edits of the layer `id` fade; `None` if they stay.
    fn decay(&self, id: u32) -> Option<DecayOptions> {
        let mut options = None;
        each_stack!(self.stacks(), stack => {
            let faded = stack.decays().find(|(layer, ..)| *layer == id).and_then(|(_, faded, _)| faded);
            options = options.or(faded.map(|faded| faded.decay.options()));
        });
        options
    }

    /// Counts the bytes of all stamps and the texels they belong to.
    fn stamp_bytes(&self) -> u64 {
        let mut bytes = 0;
        each_stack!(self.stacks(), stack => {
            bytes += stack.fading().iter().map(|(_, faded, _)| faded.decay.bytes()).sum::<u64>();
        });
        bytes
    }

    /// Stamps what was edited since it was last done with the object's time; [`LayeredObject::settle`] is to be done
    /// before. Returns the tiles or faces, ascending, whose stamps their budget refused; what was edited there stays.
    ///
    /// # Errors
    /// Fails as [`LayerDecay::stamp`] does.
    #[inline(never)]
    fn stamp(&mut self, context: &Context) -> Result<Vec<u32>> {
        if !self.is_fading() {
            return Ok(Vec::new());
        }
        let (time, mut refused, mut lost, mut gone) = (self.time(), Vec::new(), 0, Vec::new());
        each_stack!(self.stacks_mut(), stack => {
            let [left, over] = stack.stamp(context, time)?;
            refused.extend(left);
            lost += over.len() as u64;
            if stack.is_like(Kind::Scalar) {
                gone = over;
            }
        });
        self.stacks_mut().lost += lost;
        self.note_shown(&gone);
        Ok(sorted(refused))
    }

    /// How many tiles or faces of layers that fade were lost since this was called last, because a budget had no room
    /// for others.
    fn take_lost(&mut self) -> u64 {
        std::mem::take(&mut self.stacks_mut().lost)
    }

    /// How many tiles or faces got no stamps since this was called last, because their budget refused them:
    /// [`Self::stamp`] says so itself, histories and documents do it unasked.
    fn take_unstamped(&mut self) -> u64 {
        std::mem::take(&mut self.stacks_mut().unstamped)
    }

    /// Comes to `time` in seconds: what was edited fades as it should, and edits are made then from now on. The time
    /// never goes back, except to be that of stamps that were put back.
    ///
    /// # Errors
    /// Fails with `Invalid` if the time is not finite or beyond the range of `f32`, and as [`LayeredObject::settle`],
    /// [`Self::stamp`] and [`LayerDecay::fade`]. Where a device fails the processor takes over.
    #[inline(never)]
    fn advance(&mut self, context: &Context, time: f64) -> Result<()> {
        if !self.is_fading() {
            return self.set_time(time);
        }
        let _stage = context.stats().begin("decay");
        self.settle(context)?;
        self.stamp(context)?;
        self.set_time(time)?;
        let device = self.device_in_use().cloned();
        let (mut shown, mut fault) = (Vec::new(), None);
        each_stack!(self.stacks_mut(), stack => {
            let (faded, failed) = stack.fade(context, time, device.as_ref())?;
            fault = failed.or(fault);
            if stack.is_like(Kind::Scalar) {
                shown = faded;
            }
        });
        if let Some(fault) = fault {
            self.lose_device(fault);
        }
        self.note_shown(&shown);
        self.settle(context)?;
        self.take_as_stamped();
        Ok(())
    }

    /// Notes that nothing of what there is now waits for a stamp, as after channels and stamps were put back.
    fn take_as_stamped(&mut self) {
        each_stack!(self.stacks_mut(), stack => stack.take_as_stamped());
    }

    /// The stamps of `block` of all layers of a kind, as caches keep them; `None` without stamps.
    fn read_stamps(&self, kind: Kind, block: u32) -> Option<Vec<u8>> {
        let mut stamps = None;
        each_stack!(self.stacks(), stack => {
            if stack.is_like(kind) {
                stamps = stack.read_stamps(block);
            }
        });
        stamps
    }

    /// Puts back what [`Self::read_stamps`] gave of the same layers, after their blocks; [`Self::take_as_stamped`] is
    /// to follow.
    ///
    /// # Errors
    /// Fails with `Invalid` if the bytes are not the stamps of these layers or a number is not finite, and with
    /// `Memory` if a budget does not allow it; layers before the one that fails have their stamps.
    fn write_stamps(&mut self, kind: Kind, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        each_stack!(self.stacks_mut(), stack => {
            if stack.is_like(kind) {
                stack.write_stamps(block, bytes)?;
            }
        });
        Ok(())
    }

    /// The blocks with stamps of a kind of layers, ascending.
    fn stamped_blocks(&self, kind: Kind) -> Vec<u32> {
        let mut blocks = Vec::new();
        each_stack!(self.stacks(), stack => {
            if stack.is_like(kind) {
                blocks.extend(stack.fading().iter().flat_map(|(_, faded, _)| faded.decay.stamped()));
            }
        });
        sorted(blocks)
    }

    /// The blocks of a kind of layers whose stamps changed since this was called last, ascending.
    fn commit_stamps(&mut self, kind: Kind) -> Vec<u32> {
        let mut blocks = Vec::new();
        each_stack!(self.stacks_mut(), stack => {
            if stack.is_like(kind) {
                blocks.extend(stack.fading_mut().iter_mut().flat_map(|(_, faded, _)| faded.decay.take_changed()));
            }
        });
        sorted(blocks)
    }
}

impl<O: LayeredObject> DecayingObject for O {}

/// Adds the layers of stamps to `states`, and says of the others which fade.
pub(crate) fn add_stamp_states(object: &impl LayeredObject, states: &mut Vec<LayerState>) {
    each_stack!(object.stacks(), stack => {
        for (id, faded, channel) in stack.fading() {
            states.iter_mut().filter(|state| state.id == id).for_each(|state| state.fades = true);
            let blocks = faded.decay.blocks(channel.field());
            let name = format!("{STAMPS_OF}{id}");
            let stamps = Some(faded.decay.head(id));
            states.push(LayerState { stamps, fades: true, ..LayerState::new(faded.number, &name, blocks) });
        }
    });
}

/// Lists the numbers that stamps have as layers of documents.
pub(crate) fn stamp_numbers(object: &impl LayeredObject) -> Vec<u32> {
    let mut numbers = Vec::new();
    each_stack!(object.stacks(), stack => numbers.extend(stack.fading().iter().map(|(_, faded, _)| faded.number)));
    numbers
}

/// Names what may be lost for want of room, after layers were removed or put together.
pub(crate) fn name_expendable(object: &mut impl LayeredObject) {
    each_stack!(object.stacks_mut(), stack => stack.name_expendable());
}

/// Puts back stamps of a history, whose layers were put back, and brings these to the object's time.
#[inline(never)]
pub(crate) fn put_stamps(
    object: &mut impl LayeredObject,
    context: &Context,
    heads: Option<&[Head]>,
    blocks: &[BlockState],
) -> Result<()> {
    let knows = heads.is_some_and(|heads| heads.iter().any(|head| head.stamps.is_some()));
    if !object.is_fading() && !knows {
        return Ok(());
    }
    let time = object.time();
    each_stack!(object.stacks_mut(), stack => stack.restore_stamps(context, heads, blocks, time)?);
    object.settle(context)?;
    object.take_as_stamped();
    Ok(())
}

/// Takes over the stamps of `document`, whose layers were taken over, and its time, if it has any; `stay` says whether
/// displacement and colours are the same as before.
#[inline(never)]
pub(crate) fn find_stamps(
    object: &mut impl LayeredObject,
    context: &Context,
    document: &Document,
    budget: u64,
    stay: [bool; 2],
) -> Result<()> {
    let mut newest: Option<f32> = None;
    let mut number = object.free_number().max(document.free_id());
    each_stack!(object.stacks_mut(), stack => {
        stack.renumber_stamps(stay[usize::from(stack.is_like(Kind::Rgba8))], &mut number);
        let found = stack.take_up_stamps(context, document, budget)?;
        newest = newest.into_iter().chain(found).reduce(f32::max);
    });
    object.fade_own()?;
    if document.layers().iter().any(|layer| layer.kind() == Kind::Stamps) {
        // Edits of the journal may be later than what the document says.
        let time = newest.map_or(document.time, |newest| document.time.max(f64::from(newest)));
        object.set_time(time)?;
        each_stack!(object.stacks_mut(), stack => stack.bring(context, time)?);
        object.settle(context)?;
    }
    object.take_as_stamped();
    Ok(())
}
