//! Layers of displacement or colour: named, in order, each with opacity, blend mode and visibility.
//!
//! What is evaluated is the composite, a channel of its own that is kept and computed anew only where a layer changed.
//! With one layer that is seen as a whole the composite *is* the layer: there is no second copy. Edits of displacement
//! are made on the composite; what they changed goes to the active layer, divided by its opacity, when the layers are
//! settled. Edits of colour are made on the texels of the active layer. Units: object units, linear light.

use std::fmt::Debug;
use std::sync::Arc;

use bytemuck::Zeroable;
use relievo_core::{Context, Error, Result};
use relievo_document::{Blend, Head, PageStore, Settings};
use relievo_tiles::{Blocks, Sheet, StoredTexel};

use crate::channels::fading::LayerDecayState;
use crate::channels::history::LayerState;
use crate::channels::layer_channel::{BlockChannel, FAINTEST, LayerChannel};

/// A layer of a [`Stack`].
#[derive(Debug)]
pub struct Layer<C: LayerChannel> {
    id: u32,
    name: Arc<str>,
    settings: Settings,
    /// `None` where its texels are those of the composite.
    channel: Option<C>,
    /// Its decay, if its edits fade.
    decay: Option<LayerDecayState<C>>,
}

impl<C: LayerChannel> Layer<C> {
    /// Makes the layer that `head` describes.
    fn of(head: &Head, channel: C) -> Self {
        let (id, name, settings) = (head.id, head.name.as_str().into(), head.settings);
        Self { id, name, settings, channel: Some(channel), decay: None }
    }

    /// Its number.
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it takes part in what is seen.
    pub fn settings(&self) -> Settings {
        self.settings
    }
}

/// The fields of the composite and of the layers when it was last computed.
#[derive(Debug)]
struct Seen<F> {
    composite: F,
    layers: Vec<F>,
}

/// The layers of one kind of an object, from the lowest, and their composite.
#[derive(Debug)]
pub struct Stack<C: LayerChannel> {
    composite: C,
    layers: Vec<Layer<C>>,
    active: u32,
    background: C::Texel,
    /// `None` while the composite is the only layer.
    seen: Option<Seen<C::Field>>,
}

impl<C: LayerChannel> Stack<C> {
    /// Makes a stack of one layer, whose texels are the ones of `composite`; `background` is seen where it is hidden.
    pub fn new((id, name): (u32, &str), composite: C, background: C::Texel) -> Self {
        let settings = Settings::of(C::Texel::KIND);
        let layer = Layer { id, name: name.into(), settings, channel: None, decay: None };
        Self { composite, layers: vec![layer], active: id, background, seen: None }
    }

    /// Returns what the layers come to.
    pub fn composite(&self) -> &C {
        &self.composite
    }

    /// Returns what the layers come to, for writing. The layers are to be settled afterwards.
    pub fn composite_mut(&mut self) -> &mut C {
        &mut self.composite
    }

    /// The layers, from the lowest.
    pub fn layers(&self) -> &[Layer<C>] {
        &self.layers
    }

    /// The number of the layer that edits go to.
    pub fn active(&self) -> u32 {
        self.active
    }

    /// Whether the composite is the only layer.
    pub fn is_plain(&self) -> bool {
        self.seen.is_none()
    }

    fn index(&self, id: u32) -> Option<usize> {
        self.layers.iter().position(|layer| layer.id == id)
    }

    /// Makes `id` the layer that edits go to.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer.
    pub fn set_active(&mut self, id: u32) -> Result<()> {
        self.index(id).ok_or_else(|| no_layer(id))?;
        self.active = id;
        Ok(())
    }

    /// Lists the texels of each layer.
    fn channels(&self) -> impl Iterator<Item = &C> {
        self.layers.iter().map(|layer| layer.channel.as_ref().unwrap_or(&self.composite))
    }

    /// Lists the field of each layer.
    fn fields(&self) -> impl Iterator<Item = &C::Field> {
        self.channels().map(C::field)
    }

    /// Lists the texels of the layers that have some of their own.
    fn own(&self) -> impl Iterator<Item = &C> {
        self.layers.iter().filter_map(|layer| layer.channel.as_ref())
    }

    /// As [`Self::own`], for writing.
    fn own_mut(&mut self) -> impl Iterator<Item = &mut C> {
        self.layers.iter_mut().filter_map(|layer| layer.channel.as_mut())
    }

    /// Lists the number, the decay and the texels of each layer.
    pub(crate) fn decays(&self) -> impl Iterator<Item = (u32, Option<&LayerDecayState<C>>, &C)> {
        self.layers.iter().zip(self.channels()).map(|(layer, channel)| (layer.id, layer.decay.as_ref(), channel))
    }

    /// As [`Self::decays`], for writing.
    pub(crate) fn decays_mut(&mut self) -> impl Iterator<Item = (u32, &mut Option<LayerDecayState<C>>, &mut C)> {
        // One layer at most has the texels of the composite.
        let mut composite = Some(&mut self.composite);
        self.layers.iter_mut().filter_map(move |layer| {
            let channel = layer.channel.as_mut().or_else(|| composite.take())?;
            Some((layer.id, &mut layer.decay, channel))
        })
    }

    /// What the layers are, as documents have it.
    #[inline(never)]
    pub fn states(&self) -> Vec<LayerState> {
        let state = |(index, (layer, field)): (usize, (&Layer<C>, &C::Field))| {
            let blocks = Arc::new(field.clone());
            // Nothing is behind displacement.
            let is_lowest = index == 0 && C::Texel::KIND.is_color();
            let behind = if is_lowest { bytemuck::bytes_of(&self.background).to_vec() } else { Vec::new() };
            LayerState { settings: layer.settings, behind, ..LayerState::new(layer.id, &layer.name, blocks) }
        };
        self.layers.iter().zip(self.fields()).enumerate().map(state).collect()
    }

    /// What is seen where all layers are hidden.
    pub fn background(&self) -> C::Texel {
        self.background
    }

    /// Changes what is seen where all layers are hidden; the layers are to be refreshed.
    pub(crate) fn set_background(&mut self, background: C::Texel) {
        self.background = background;
    }

    /// Takes over what is behind the layers, if `head`, the lowest of them, knows it.
    fn see_behind(&mut self, head: &Head) {
        if head.behind.len() == size_of::<C::Texel>() {
            self.background = bytemuck::pod_read_unaligned(&head.behind);
        }
    }

    /// The texels of a layer; `None` if there is no such layer.
    pub fn channel(&self, id: u32) -> Option<&C> {
        self.channels().nth(self.index(id)?)
    }

    /// The texels of a layer, for writing; `None` if there is no such layer. The layers are to be settled or refreshed
    /// afterwards.
    pub fn channel_mut(&mut self, id: u32) -> Option<&mut C> {
        let index = self.index(id)?;
        Some(self.layers[index].channel.as_mut().unwrap_or(&mut self.composite))
    }

    /// Returns the texels of the active layer, for writing, as [`Self::channel_mut`] does.
    pub fn active_mut(&mut self) -> &mut C {
        let own = self.index(self.active).and_then(|index| self.layers[index].channel.as_mut());
        own.unwrap_or(&mut self.composite)
    }

    /// The block of `tile`, for caches: that of the only layer, or those of all layers one after the other, each behind
    /// its length. `None` if no layer has one.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such tile or it is a hole, and as the page store does if a block is on a
    /// page that cannot be read.
    pub fn read(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        if self.is_plain() {
            return self.composite.read(tile);
        }
        let (mut all, mut any) = (Vec::new(), false);
        for channel in self.channels() {
            let block = channel.read(tile)?;
            any |= block.is_some();
            let block = block.unwrap_or_default();
            all.extend((block.len() as u32).to_le_bytes());
            all.extend(block);
        }
        Ok(any.then_some(all))
    }

    /// Puts back what [`Self::read`] gave of the same layers; with several, [`Self::settle`] is to follow.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such tile, the bytes are not blocks of these layers or a number is not
    /// finite, with `Memory` if a budget does not allow it, and as the page store does if a page cannot be read or
    /// written. Layers below the first that does not fit are put back.
    pub fn write(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        if self.is_plain() {
            return self.composite.write(tile, bytes);
        }
        let misfit = || Error::invalid("a block does not fit the layers").at(format!("tile {tile}"));
        let mut rest = bytes;
        for layer in &mut self.layers {
            let mut block = None;
            if let Some(bytes) = rest {
                let (length, after) = bytes.split_first_chunk().ok_or_else(misfit)?;
                let length = u32::from_le_bytes(*length) as usize;
                let (own, after) = after.split_at_checked(length).ok_or_else(misfit)?;
                block = (length > 0).then_some(own);
                rest = Some(after);
            }
            layer.channel.as_mut().unwrap_or(&mut self.composite).write(tile, block)?;
        }
        if rest.is_some_and(|rest| !rest.is_empty()) { Err(misfit()) } else { Ok(()) }
    }

    /// The tiles of which any layer has a block, ascending.
    pub fn allocated(&self) -> Vec<u32> {
        let mut tiles: Vec<u32> = self.fields().flat_map(Blocks::numbers).collect();
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// Makes edits visible to readers. Returns the tiles that changed of the composite or of a layer, ascending.
    pub fn commit(&mut self) -> Vec<u32> {
        let mut tiles = self.composite.commit();
        tiles.extend(self.own_mut().flat_map(C::commit));
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// Checks that an edit of the active layer can be seen.
    ///
    /// # Errors
    /// Fails with `Invalid` if the active layer is hidden or its opacity below 1/256.
    pub fn check_editable(&self) -> Result<()> {
        let Some(layer) = self.index(self.active).map(|index| &self.layers[index]) else { return Ok(()) };
        let Settings { visible, opacity, .. } = layer.settings;
        if self.is_plain() || visible && opacity >= FAINTEST {
            return Ok(());
        }
        Err(Error::invalid("it is the active layer and cannot be seen, so that it cannot be edited")
            .at(format!("layer `{}`", layer.name))
            .advise("show it, or make another layer the active one"))
    }

    fn sheets(layers: &[Layer<C>]) -> Vec<Sheet<'_, C::Field>> {
        let channels = layers.iter().filter_map(|layer| Some((layer.channel.as_ref()?, layer.settings)));
        channels.map(|(channel, settings)| Sheet { field: channel.field(), settings }).collect()
    }

    fn look(&mut self) {
        let layers = self.fields().cloned().collect();
        self.seen = Some(Seen { composite: self.composite.field().clone(), layers });
    }

    /// Puts what was changed in the composite into the active layer, and computes the composite anew where layers
    /// changed. Returns the tiles that budgets refused.
    ///
    /// # Errors
    /// Fails with `Invalid` if the composite was changed, edits are made on it, and [`Self::check_editable`] fails; the
    /// composite is then as it was before it was changed. Fails with `Memory` if the budget of the active layer does
    /// not allow the sizes that faces of the composite were given, and as the page store does if a page cannot be read
    /// or written.
    #[inline(never)]
    pub fn settle(&mut self, context: &Context) -> Result<Vec<u32>> {
        let Some(mut seen) = self.seen.take() else { return Ok(Vec::new()) };
        let done = self.settle_since(context, &mut seen);
        if done.is_err() {
            self.seen = Some(seen);
        }
        let (refused, failed) = done?;
        self.report_fault()?;
        failed.map(|()| refused)
    }

    fn settle_since(&mut self, context: &Context, seen: &mut Seen<C::Field>) -> Result<(Vec<u32>, Result<()>)> {
        let mut tiles = self.composite.field().changed(&seen.composite);
        // What made room for an edit of the composite goes from its layers too, and is none of that edit.
        let lost = self.composite.take_lost();
        self.lose(context, &lost)?;
        C::forget(&mut seen.composite, &lost);
        let (mut refused, mut failed) = (Vec::new(), Ok(()));
        // An edit at another level may have changed sizes; then those of all are compared anew.
        let mut resized = !self.composite.field().is_sized_as(&seen.composite);
        if C::THROUGH_COMPOSITE && !tiles.is_empty() {
            failed = self.check_editable();
            if failed.is_ok() {
                let there = if lost.is_empty() { Vec::new() } else { self.composite.field().numbers() };
                let gone = |tile: &u32| lost.binary_search(tile).is_ok() && there.binary_search(tile).is_err();
                let edited: Vec<u32> = tiles.iter().copied().filter(|tile| !gone(tile)).collect();
                refused = self.absorb(context, seen, &edited)?;
            }
        }
        resized |= !self.fields().zip(&seen.layers).all(|(layer, before)| layer.is_sized_as(before));
        if resized {
            refused.extend(self.refresh(context)?);
            refused.sort_unstable();
            refused.dedup();
            return Ok((refused, failed));
        }
        tiles.extend(self.fields().zip(&seen.layers).flat_map(|(layer, before)| layer.changed(before)));
        tiles.sort_unstable();
        tiles.dedup();
        tiles.extend(lost);
        while !tiles.is_empty() {
            tiles.sort_unstable();
            tiles.dedup();
            refused.extend(self.composite.compose(context, &Self::sheets(&self.layers), self.background, &tiles)?);
            // Layers that do not fade keep theirs, which is then refused.
            tiles = self.composite.take_lost();
            self.lose(context, &tiles)?;
        }
        refused.sort_unstable();
        refused.dedup();
        self.look();
        Ok((refused, failed))
    }

    /// Loses blocks of the layers that fade.
    fn lose(&mut self, context: &Context, blocks: &[u32]) -> Result<()> {
        self.own_mut().try_for_each(|layer| layer.lose(context, blocks))
    }

    /// Makes the blocks of all layers, and of the composite, leave memory for `pages`.
    ///
    /// # Errors
    /// Fails as [`BlockChannel::page_to`] does.
    pub fn page_to(&mut self, pages: Option<&Arc<dyn PageStore>>) -> Result<()> {
        self.composite.page_to(pages)?;
        self.own_mut().try_for_each(|layer| layer.page_to(pages))?;
        if self.seen.is_some() {
            self.look();
        }
        Ok(())
    }

    /// Reports a failure of the page store, once for the composite and each layer.
    ///
    /// # Errors
    /// Fails with the error of the page store about what could not be read back from a page, or written to one, since
    /// this was called last: the first of the composite and the layers.
    pub fn report_fault(&self) -> Result<()> {
        self.composite.report_fault()?;
        self.own().try_for_each(BlockChannel::report_fault)
    }

    #[inline(never)]
    fn absorb(&mut self, context: &Context, seen: &Seen<C::Field>, tiles: &[u32]) -> Result<Vec<u32>> {
        let Some(index) = self.index(self.active) else { return Ok(Vec::new()) };
        let (under, above) = self.layers.split_at_mut(index);
        let Some(Layer { channel: Some(channel), settings, .. }) = above.first_mut() else { return Ok(Vec::new()) };
        let (settings, below) = (*settings, Self::sheets(under));
        let fields = [&seen.composite, self.composite.field()];
        channel.absorb(context, fields, (&below, self.background), settings, tiles)
    }

    /// Makes a channel for a layer with the sizes that `face_sizes` has for every face, without blocks.
    fn blank(&self, face_sizes: &[u32], blank: C::Texel) -> Result<C> {
        C::sized(self.composite.field(), face_sizes, blank, self.composite.budget())
    }

    /// Gives it the layers `heads`, from the lowest: layers that were there keep their texels as far as their sizes are
    /// what they were, others are blank. [`Self::refresh`] is to follow.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if `heads` is empty, or one is of another kind or has settings or
    /// sizes that its kind does not have, and as the page store does if a page cannot be read or written.
    #[inline(never)]
    pub fn arrange(&mut self, heads: &[&Head]) -> Result<()> {
        if heads.is_empty() {
            return Err(Error::invalid("the last layer cannot be removed").advise("hide it, or erase what is on it"));
        }
        let mut fresh = Vec::with_capacity(heads.len());
        for head in heads {
            let place = |error: Error| error.at(format!("layer `{}`", head.name));
            head.settings.check(C::Texel::KIND).map_err(place)?;
            if head.kind != C::Texel::KIND || head.blank.len() != size_of::<C::Texel>() {
                return Err(place(Error::invalid("it is of another kind")));
            }
            let channel = match self.channel(head.id).filter(|channel| Blocks::blank(channel.field()) == head.blank) {
                // Cheap: blocks are shared.
                Some(channel) => channel.clone(),
                None => self.blank(&head.face_sizes, bytemuck::pod_read_unaligned(&head.blank))?,
            };
            fresh.push(channel);
        }
        for (head, channel) in heads.iter().zip(&mut fresh) {
            channel.reshape(&head.face_sizes, &head.given_sizes)?;
        }
        let mut before = std::mem::take(&mut self.layers);
        let mut decay = |id: u32| before.iter_mut().find(|layer| layer.id == id)?.decay.take();
        let layers = heads.iter().zip(fresh);
        let layers = layers.map(|(head, channel)| Layer { decay: decay(head.id), ..Layer::of(head, channel) });
        self.layers = layers.collect();
        if let Some(lowest) = heads.first() {
            self.see_behind(lowest);
        }
        if self.index(self.active).is_none() {
            self.active = self.layers.last().map_or(0, |layer| layer.id);
        }
        Ok(())
    }

    /// Computes the composite anew, after layers were changed as a whole; as far as it is not the only layer. Returns
    /// the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails as the page store does if a page cannot be read or written; the composite is then as it was.
    #[inline(never)]
    pub fn refresh(&mut self, context: &Context) -> Result<Vec<u32>> {
        self.seen = None;
        if let [only] = self.layers.as_mut_slice()
            && only.settings == Settings::of(C::Texel::KIND)
        {
            if let Some(mut channel) = only.channel.take() {
                channel.follow(&self.composite);
                self.composite = channel;
            }
            return Ok(Vec::new());
        }
        for layer in &mut self.layers {
            layer.channel.get_or_insert_with(|| self.composite.clone());
        }
        let (fresh, refused) = self.composite.recomposed(context, &Self::sheets(&self.layers), self.background)?;
        self.composite = fresh;
        self.look();
        Ok(refused)
    }

    /// Puts the layer `id` and the one below it into one, which then has what both come to: the number and the name of
    /// the lower one, and does not fade. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer or none below it, one of the two is hidden,
    /// or what is seen would not stay the same. Fails too as the page store does if a page cannot be read or written.
    #[inline(never)]
    pub fn merge_down(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        let at = self.index(id).ok_or_else(|| no_layer(id))?;
        let place = |layer: &Layer<C>| format!("layer `{}`", layer.name);
        let Some(under) = at.checked_sub(1) else {
            return Err(Error::invalid("there is no layer below it").at(place(&self.layers[at])));
        };
        for layer in &self.layers[under..=at] {
            if !layer.settings.visible {
                return Err(Error::invalid("a hidden layer cannot be merged").at(place(layer)).advise("show it first"));
            }
        }
        let [lower, upper] = [under, at].map(|index| self.layers[index].settings.blend);
        let additive = |blend| matches!(blend, Blend::Add | Blend::Subtract) && !C::Texel::KIND.is_color();
        let sound =
            under == 0 || lower == Blend::Normal && upper == Blend::Normal || lower == Blend::Add && additive(upper);
        if !sound {
            let what = format!("`{}` on `{}` cannot become one layer that looks the same", upper.name(), lower.name());
            return Err(Error::invalid(what)
                .at(place(&self.layers[at]))
                .advise("merge from the lowest layer, or flatten all"));
        }
        let (merged, refused) = {
            let sheets = Self::sheets(&self.layers[under..=at]);
            let background = if under == 0 { self.background } else { C::Texel::zeroed() };
            let lowest = &Self::sheets(&self.layers[under..=under]);
            let blank = lowest.first().map_or(background, |sheet| bytemuck::pod_read_unaligned(sheet.field.blank()));
            let empty = self.blank(&sheets[0].field.face_sizes(), blank)?;
            empty.recomposed(context, &sheets, background)?
        };
        self.layers.remove(at);
        self.layers[under].settings = Settings::of(C::Texel::KIND);
        (self.layers[under].channel, self.layers[under].decay) = (Some(merged), None);
        if self.active == id {
            self.active = self.layers[under].id;
        }
        let mut all = self.refresh(context)?;
        all.extend(refused);
        Ok(all)
    }

    /// Adds a layer above all others, blank, with the sizes that `face_sizes` has for every face; edits go to it.
    /// Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and adds nothing, with `Invalid` if the settings are not for its kind or a size does not exist. Fails too
    /// as [`Self::refresh`], when the layer is added.
    pub fn add(
        &mut self,
        context: &Context,
        (id, name, settings): (u32, &str, Settings),
        face_sizes: &[u32],
    ) -> Result<Vec<u32>> {
        settings.check(C::Texel::KIND)?;
        let channel = self.blank(face_sizes, C::Texel::zeroed())?;
        self.layers.push(Layer { id, name: name.into(), settings, channel: Some(channel), decay: None });
        self.active = id;
        self.refresh(context)
    }

    /// Takes the place of all layers: layers that were read, from the lowest, with their texels. What is behind them
    /// stays. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if `layers` is empty. Fails too as [`Self::refresh`], when they have
    /// taken the place.
    #[inline(never)]
    pub fn take_up(&mut self, context: &Context, layers: Vec<(&Head, C)>) -> Result<Vec<u32>> {
        let Some((lowest, _)) = layers.first() else { return Err(Error::invalid("there are no layers to take up")) };
        let lowest = (*lowest).clone();
        self.active = lowest.id;
        self.see_behind(&lowest);
        self.layers = layers.into_iter().map(|(head, channel)| Layer::of(head, channel)).collect();
        self.refresh(context)
    }

    /// Gives the layers other numbers, from `first` on.
    pub fn renumber(&mut self, first: u32) {
        let active = self.index(self.active);
        for (layer, id) in self.layers.iter_mut().zip(first..) {
            layer.id = id;
        }
        self.active = first + active.unwrap_or(0) as u32;
    }

    /// Changes the name of a layer.
    pub fn rename(&mut self, id: u32, name: &str) {
        if let Some(index) = self.index(id) {
            self.layers[index].name = name.into();
        }
    }

    /// Changes how a layer is seen. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer or its kind cannot be seen so. Fails too as
    /// [`Self::refresh`], when the settings are changed.
    pub fn set(&mut self, context: &Context, id: u32, to: Settings) -> Result<Vec<u32>> {
        let index = self.index(id).ok_or_else(|| no_layer(id))?;
        to.check(C::Texel::KIND)?;
        self.layers[index].settings = to;
        self.refresh(context)
    }

    /// Puts a layer at a place counted from the lowest, or above all. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer. Fails too as [`Self::refresh`], when the
    /// layer is at its place.
    pub fn place(&mut self, context: &Context, id: u32, place: usize) -> Result<Vec<u32>> {
        let layer = self.layers.remove(self.index(id).ok_or_else(|| no_layer(id))?);
        self.layers.insert(place.min(self.layers.len()), layer);
        self.refresh(context)
    }

    /// Removes a layer. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer, or no other. Fails too as
    /// [`Self::refresh`], when the layer is removed.
    pub fn remove(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        let index = self.index(id).ok_or_else(|| no_layer(id))?;
        if self.layers.len() == 1 {
            return Err(Error::invalid("the last layer cannot be removed").advise("hide it, or erase what is on it"));
        }
        self.layers.remove(index);
        if self.active == id {
            self.active = self.layers[index.saturating_sub(1)].id;
        }
        self.refresh(context)
    }

    /// Makes one layer of all: what is seen. It has the number and the name of the lowest, and does not fade if there
    /// were others.
    pub fn flatten(&mut self) {
        if self.layers.len() > 1 {
            self.layers.truncate(1);
            self.layers[0].decay = None;
        }
        if let Some(only) = self.layers.first_mut() {
            (only.settings, only.channel) = (Settings::of(C::Texel::KIND), None);
            self.active = only.id;
        }
        self.seen = None;
    }
}

pub(crate) fn no_layer(id: u32) -> Error {
    Error::invalid(format!("there is no layer with the number {id}"))
}
