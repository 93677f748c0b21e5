//! Layers whose edits fade (Schäfer et al. 2015, Section 7.2): displacement and colours that were edited before the
//! time that the object comes to. See [`relievo_tiles::decay`].
//!
//! What is left of an edit at a time follows from the stamps alone. So histories and documents hold these, and what
//! they hold of the texels is brought to the object's time when it is put back. Units: seconds, bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_document::head::STAMPS_OF;
use relievo_document::{Document, Head, Kind, Stamps};
use relievo_tiles::{Blocks, Channel, Decay, DecayOptions, Field, Rgba8, Rgba16, StoredTexel};

use crate::history::{BlockState, LayerState};
use crate::layered::LayeredObject;
use crate::layers::{Absorb, Stack};
use crate::object::DisplacedObject;

/// The stamps of an object.
#[derive(Debug, Default)]
pub struct Fading {
    displacement: Vec<Faded<f16>>,
    paint: Vec<Faded<Rgba8>>,
    half_paint: Vec<Faded<Rgba16>>,
    /// How the object's own displacement and colours, the lowest layers, fade.
    own: Option<(DecayOptions, u64)>,
    lost: u64,
    unstamped: u64,
}

/// The stamps of a layer.
#[derive(Debug)]
struct Faded<T> {
    /// The number of the layer, and that of its stamps as a layer of documents.
    layer: u32,
    number: u32,
    decay: Decay<T>,
    /// What has been stamped.
    stamped: Field<T>,
}

/// A kind of layers that fade, and the channel to which they come.
struct Kept<'a, T: Absorb> {
    faded: &'a mut Vec<Faded<T>>,
    stack: &'a mut Stack<Channel<T>>,
    composite: &'a mut Channel<T>,
}

impl<T: Absorb> Kept<'_, T> {
    /// Stamps what was edited since it was last done. Returns the tiles that budgets refused, and how many were lost.
    fn stamp(&mut self, context: &Context, time: f64) -> (Vec<u32>, u64) {
        let (mut refused, mut lost) = (Vec::new(), 0);
        for faded in &mut *self.faded {
            let Some(channel) = self.stack.channel_mut(faded.layer, self.composite) else { continue };
            let mut left = faded.decay.stamp(context, &faded.stamped, channel, time);
            // Those that have no room take that of the oldest, unless these were edited now.
            let mut oldest = faded.decay.oldest();
            oldest.retain(|(_, tile)| channel.field().version(*tile) == faded.stamped.version(*tile));
            while !left.is_empty() && !oldest.is_empty() {
                let gone: Vec<u32> = oldest.drain(..left.len().min(oldest.len())).map(|(_, tile)| tile).collect();
                if channel.lose_tiles(context, &gone).is_err() {
                    break;
                }
                left = faded.decay.stamp(context, &faded.stamped, channel, time);
            }
            refused.extend(left);
            lost += channel.take_lost().len() as u64;
            faded.stamped = channel.field().clone();
        }
        self.name_expendable();
        (refused, lost)
    }

    /// Says which tiles may be lost: of a layer that fades those that hold nothing else, of the composite those that
    /// only such layers have.
    fn name_expendable(&mut self) {
        let ids: Vec<u32> = self.stack.layers().iter().map(|layer| layer.id()).collect();
        let mut ages: BTreeMap<u32, u64> = BTreeMap::new();
        let mut named = Vec::with_capacity(ids.len());
        for id in &ids {
            let faded = self.faded.iter().find(|faded| faded.layer == *id);
            let oldest = faded.map_or_else(Vec::new, |faded| faded.decay.oldest());
            for (age, tile) in &oldest {
                let newest = ages.entry(*tile).or_insert(*age);
                *newest = (*newest).max(*age);
            }
            let tiles: Vec<u32> = oldest.into_iter().map(|(_, tile)| tile).collect();
            if let Some(channel) = self.stack.channel_mut(*id, self.composite) {
                channel.set_expendable(&tiles);
            }
            named.push(tiles.into_iter().collect::<BTreeSet<u32>>());
        }
        if self.stack.is_plain() {
            return;
        }
        for (id, named) in ids.iter().zip(&named) {
            if let Some(channel) = self.stack.channel(*id, self.composite) {
                ages.retain(|tile, _| named.contains(tile) || !channel.field().is_allocated(*tile));
            }
        }
        let mut tiles: Vec<(u64, u32)> = ages.into_iter().map(|(tile, age)| (age, tile)).collect();
        tiles.sort_unstable();
        self.composite.set_expendable(&tiles.into_iter().map(|(_, tile)| tile).collect::<Vec<_>>());
    }

    fn fade(&mut self, context: &Context, time: f64) -> Result<()> {
        for faded in &mut *self.faded {
            if let Some(channel) = self.stack.channel_mut(faded.layer, self.composite) {
                faded.decay.fade(context, channel, time)?;
            }
        }
        Ok(())
    }

    fn take_as_stamped(&mut self) {
        for faded in &mut *self.faded {
            if let Some(channel) = self.stack.channel_mut(faded.layer, self.composite) {
                faded.stamped = channel.field().clone();
            }
        }
        self.name_expendable();
    }

    /// Makes the edits of a layer fade from now on, or stay. Fails if the times are none or there is no such layer.
    fn set(&mut self, layer: u32, number: u32, options: Option<(DecayOptions, u64)>) -> Result<()> {
        let none = || Error::invalid(format!("there is no layer with the number {layer}"));
        let channel = self.stack.channel_mut(layer, self.composite).ok_or_else(none)?;
        let there = self.faded.iter().position(|faded| faded.layer == layer);
        match (options, there) {
            (Some((options, _)), Some(at)) => self.faded[at].decay.set_options(options)?,
            (Some((options, budget)), None) => {
                let decay = Decay::new(channel.field().tile_count(), options, budget)?;
                let stamped = channel.field().clone();
                self.faded.push(Faded { layer, number, decay, stamped });
            }
            (None, Some(at)) => drop(self.faded.remove(at)),
            (None, None) => {}
        }
        self.name_expendable();
        Ok(())
    }

    /// Puts back stamps, and brings their layers to `time`, whose blocks were put back.
    fn restore(&mut self, context: &Context, heads: Option<&[Head]>, blocks: &[BlockState], time: f64) -> Result<()> {
        if let Some(heads) = heads {
            let gone = |faded: &Faded<T>| !heads.iter().any(|head| head.id == faded.number);
            let gone: Vec<u32> = self.faded.iter().filter(|faded| gone(faded)).map(|faded| faded.layer).collect();
            self.faded.retain(|faded| !gone.contains(&faded.layer));
            for head in heads {
                let Some(stamps) = head.stamps.filter(|stamps| stamps.texel == T::KIND) else { continue };
                let options = DecayOptions { delay: stamps.delay, duration: stamps.duration };
                let budget = self.composite.budget();
                self.set(stamps.layer, head.id, Some((options, budget)))?;
            }
        }
        for faded in &mut *self.faded {
            let Some(channel) = self.stack.channel_mut(faded.layer, self.composite) else { continue };
            for block in blocks.iter().filter(|block| block.layer == faded.number) {
                faded.decay.restore(channel.field(), block.block, block.bytes.as_deref())?;
            }
            let own = blocks.iter().filter(|block| block.layer == faded.layer);
            let restored: Vec<u32> = own.map(|block| block.block).collect();
            faded.decay.bring(context, channel, time, &restored)?;
        }
        Ok(())
    }

    /// Keeps the stamps of layers that were there before, by their numbers then and now; they get numbers of their own.
    fn follow(&mut self, moved: &[(u32, u32)], number: &mut u32) {
        self.faded.retain_mut(|faded| match moved.iter().find(|(before, _)| *before == faded.layer) {
            Some((_, now)) => {
                (faded.layer, faded.number) = (*now, *number);
                *number += 1;
                true
            }
            None => false,
        });
    }

    /// Takes over the stamps that `document` has of these layers. Returns the newest of them.
    fn take_up(&mut self, context: &Context, document: &Document, budget: u64) -> Result<Option<f32>> {
        let mut newest: Option<f32> = None;
        for layer in document.layers() {
            let Some(Stamps { layer: of, texel, .. }) = layer.head().stamps else { continue };
            let Some(channel) = self.stack.channel_mut(of, self.composite).filter(|_| texel == T::KIND) else {
                continue;
            };
            let stamped = channel.field().clone();
            let decay = Decay::stored(context, document, layer.name(), &stamped, budget)?;
            newest = newest.into_iter().chain(decay.newest()).reduce(f32::max);
            self.faded.retain(|faded| faded.layer != of);
            self.faded.push(Faded { layer: of, number: layer.id(), decay, stamped });
        }
        Ok(newest)
    }

    /// Puts back what [`read`] gave of the same layers, after their own blocks.
    fn write(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        let misfit = || Error::invalid("stamps do not fit the layers").at(format!("tile {tile}"));
        let mut rest = bytes;
        let single = self.faded.len() == 1;
        for faded in &mut *self.faded {
            let mut block = rest;
            if let (Some(bytes), false) = (rest, single) {
                let (length, after) = bytes.split_first_chunk().ok_or_else(misfit)?;
                let (own, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(misfit)?;
                block = (!own.is_empty()).then_some(own);
                rest = Some(after);
            }
            let channel = self.stack.channel_mut(faded.layer, self.composite).ok_or_else(misfit)?;
            faded.decay.write(channel.field(), tile, block)?;
        }
        if self.faded.is_empty() && bytes.is_some() || !single && rest.is_some_and(|rest| !rest.is_empty()) {
            return Err(misfit());
        }
        Ok(())
    }

    fn take_changed(&mut self) -> Vec<u32> {
        sorted(self.faded.iter_mut().flat_map(|faded| faded.decay.take_changed()).collect())
    }
}

/// The stamps of `tile`, for caches: of the only layer that fades, or of all one after the other, each behind its
/// length. `None` if there are none.
fn read<T: StoredTexel>(list: &[Faded<T>], tile: u32) -> Option<Vec<u8>> {
    if let [only] = list {
        return only.decay.read(tile);
    }
    let (mut all, mut any) = (Vec::new(), false);
    for faded in list {
        let block = faded.decay.read(tile);
        any |= block.is_some();
        let block = block.unwrap_or_default();
        all.extend((block.len() as u32).to_le_bytes());
        all.extend(block);
    }
    any.then_some(all)
}

fn stamped<T: StoredTexel>(list: &[Faded<T>]) -> Vec<u32> {
    sorted(list.iter().flat_map(|faded| faded.decay.stamped().collect::<Vec<_>>()).collect())
}

/// The layers of stamps as documents have them; those of `states` that they belong to are marked.
fn add_states<T: Absorb>(
    list: &[Faded<T>],
    stack: &Stack<Channel<T>>,
    composite: &Channel<T>,
    states: &mut Vec<LayerState>,
) {
    for faded in list {
        let Some(channel) = stack.channel(faded.layer, composite) else { continue };
        states.iter_mut().filter(|state| state.id == faded.layer).for_each(|state| state.fades = true);
        let blocks: Arc<dyn Blocks> = Arc::new(faded.decay.blocks(channel.field()));
        let name = format!("{STAMPS_OF}{}", faded.layer);
        let stamps = Some(faded.decay.head(faded.layer));
        states.push(LayerState { stamps, fades: true, ..LayerState::new(faded.number, &name, blocks) });
    }
}

fn sorted(mut tiles: Vec<u32>) -> Vec<u32> {
    tiles.sort_unstable();
    tiles.dedup();
    tiles
}

/// Does the same for displacement and colours, of which an object has those of one format.
macro_rules! each_kind {
    ($object:expr, $kept:ident => $work:expr) => {{
        let DisplacedObject { fading, layers, displacement, paint, half_paint, .. } = &mut *$object;
        let Fading { displacement: faded, paint: faded_paint, half_paint: faded_half_paint, .. } = fading;
        #[allow(unused_mut)]
        let mut $kept = Kept { faded, stack: &mut layers.displacement, composite: displacement };
        $work;
        if let (Some(stack), Some(composite)) = (&mut layers.colors, paint) {
            #[allow(unused_mut)]
            let mut $kept = Kept { faded: faded_paint, stack, composite };
            $work;
        }
        if let (Some(stack), Some(composite)) = (&mut layers.half_colors, half_paint) {
            #[allow(unused_mut)]
            let mut $kept = Kept { faded: faded_half_paint, stack, composite };
            $work;
        }
    }};
}

impl Fading {
    /// Bytes of all stamps and the texels they belong to.
    pub fn bytes(&self) -> u64 {
        let displacement: u64 = self.displacement.iter().map(|faded| faded.decay.bytes()).sum();
        let paint: u64 = self.paint.iter().map(|faded| faded.decay.bytes()).sum();
        displacement + paint + self.half_paint.iter().map(|faded| faded.decay.bytes()).sum::<u64>()
    }

    /// When edits of the layer `id` fade; `None` if they stay.
    pub fn options(&self, id: u32) -> Option<DecayOptions> {
        let displacement = self.displacement.iter().find(|faded| faded.layer == id).map(|faded| faded.decay.options());
        let paint = || self.paint.iter().find(|faded| faded.layer == id).map(|faded| faded.decay.options());
        let half = || self.half_paint.iter().find(|faded| faded.layer == id).map(|faded| faded.decay.options());
        displacement.or_else(paint).or_else(half)
    }

    /// Counts tiles that got no stamps.
    pub(crate) fn refuse(&mut self, tiles: usize) {
        self.unstamped += tiles as u64;
    }

    /// Lets go of the stamps of colours, which are others now.
    pub(crate) fn forget_colors(&mut self) {
        self.paint.clear();
        self.half_paint.clear();
    }

    /// The numbers that stamps have as layers of documents.
    pub(crate) fn numbers(&self) -> Vec<u32> {
        let paint = self.paint.iter().map(|faded| faded.number);
        let half = self.half_paint.iter().map(|faded| faded.number);
        self.displacement.iter().map(|faded| faded.number).chain(paint).chain(half).collect()
    }

    fn is_empty(&self) -> bool {
        self.displacement.is_empty() && self.paint.is_empty() && self.half_paint.is_empty()
    }
}

impl DisplacedObject {
    /// Makes edits of the object's own displacement and colours, the lowest layers, fade from now on; what was edited
    /// before stays. Stamps may occupy `budget` bytes for each of the two. Fails if the times are none.
    pub fn set_decay(&mut self, options: DecayOptions, budget: u64) -> Result<()> {
        options.check()?;
        self.fading.own = Some((options, budget));
        self.fade_own()
    }

    /// Gives the lowest layers the decay of the object, if it has one and they have none.
    pub(crate) fn fade_own(&mut self) -> Result<()> {
        let Some(own) = self.fading.own else { return Ok(()) };
        let first = self.free_number();
        each_kind!(self, kept => {
            if let Some(lowest) = kept.stack.layers().first().map(|layer| layer.id()) {
                kept.set(lowest, first + u32::from(kept.kind().is_color()), Some(own))?;
            }
        });
        Ok(())
    }

    /// Makes edits of the layer `id` fade from now on, or stay; those that were made before too, if they have been
    /// stamped. Its stamps may occupy `budget` bytes. Where that or the budget of the layer is full, the tiles of the
    /// layer whose newest edit is oldest are lost to make room, see [`Self::take_lost`].
    ///
    /// Fails, and changes nothing, if the times are none or there is no such layer.
    pub fn set_layer_decay(
        &mut self,
        context: &Context,
        id: u32,
        options: Option<DecayOptions>,
        budget: u64,
    ) -> Result<()> {
        options.map_or(Ok(()), |options| options.check())?;
        self.settle(context)?;
        self.stamp(context);
        let number = self.free_number();
        let mut done = Err(Error::invalid(format!("there is no layer with the number {id}")));
        each_kind!(self, kept => {
            if kept.stack.layers().iter().any(|layer| layer.id() == id) {
                done = kept.set(id, number, options.map(|options| (options, budget)));
            }
        });
        done
    }

    /// The stamps, if edits of any layer fade.
    pub fn fading(&self) -> Option<&Fading> {
        (!self.fading.is_empty()).then_some(&self.fading)
    }

    /// Stamps what was edited since it was last done with the object's time; [`LayeredObject::settle`] is to be done
    /// before. Returns the tiles, ascending, whose stamps their budget refused; what was edited there stays.
    pub fn stamp(&mut self, context: &Context) -> Vec<u32> {
        if self.fading.is_empty() {
            return Vec::new();
        }
        let (time, mut refused, mut lost) = (self.time, Vec::new(), 0);
        each_kind!(self, kept => {
            let (left, gone) = kept.stamp(context, time);
            refused.extend(left);
            lost += gone;
        });
        self.fading.lost += lost;
        sorted(refused)
    }

    /// How many tiles of layers that fade were lost since this was called last, because a budget had no room for
    /// others.
    pub fn take_lost(&mut self) -> u64 {
        std::mem::take(&mut self.fading.lost)
    }

    /// How many tiles got no stamps since this was called last, because their budget refused them: [`Self::stamp`] says
    /// so itself, histories and documents do it unasked.
    pub fn take_unstamped(&mut self) -> u64 {
        std::mem::take(&mut self.fading.unstamped)
    }

    /// Comes to `time` in seconds: what was edited fades as it should, and edits are made then from now on. The time
    /// never goes back, except to be that of stamps that were put back.
    ///
    /// Fails, as [`Self::set_time`] does, if the time is not finite.
    pub fn advance(&mut self, context: &Context, time: f64) -> Result<()> {
        if self.fading.is_empty() {
            return self.set_time(time);
        }
        let _stage = context.stats().begin("decay");
        self.settle(context)?;
        self.stamp(context);
        self.set_time(time)?;
        each_kind!(self, kept => kept.fade(context, time)?);
        self.settle(context)?;
        self.take_as_stamped();
        Ok(())
    }

    /// Notes that nothing of what there is now waits for a stamp, as after channels and stamps were put back.
    pub fn take_as_stamped(&mut self) {
        each_kind!(self, kept => kept.take_as_stamped());
    }

    /// The stamps of `tile` of all layers of a kind, as caches keep them; `None` if there are none.
    pub fn read_stamps(&self, kind: Kind, tile: u32) -> Option<Vec<u8>> {
        match kind.is_color() {
            true if self.half_paint.is_some() => read(&self.fading.half_paint, tile),
            true => read(&self.fading.paint, tile),
            false => read(&self.fading.displacement, tile),
        }
    }

    /// Puts back what [`Self::read_stamps`] gave of the same layers, after their blocks; [`Self::take_as_stamped`] is
    /// to follow. Fails if they do not fit.
    pub fn write_stamps(&mut self, kind: Kind, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        each_kind!(self, kept => {
            if kept.kind().is_color() == kind.is_color() {
                kept.write(tile, bytes)?;
            }
        });
        Ok(())
    }

    /// The tiles with stamps of a kind of layers, ascending.
    pub fn stamped_tiles(&self, kind: Kind) -> Vec<u32> {
        match kind.is_color() {
            true if self.half_paint.is_some() => stamped(&self.fading.half_paint),
            true => stamped(&self.fading.paint),
            false => stamped(&self.fading.displacement),
        }
    }

    /// The tiles of a kind of layers whose stamps changed since this was called last, ascending.
    pub fn commit_stamps(&mut self, kind: Kind) -> Vec<u32> {
        let mut tiles = Vec::new();
        each_kind!(self, kept => {
            if kept.kind().is_color() == kind.is_color() {
                tiles = kept.take_changed();
            }
        });
        tiles
    }

    /// Adds the layers of stamps to `states`, and says of the others which fade.
    pub(crate) fn add_stamp_states(&self, states: &mut Vec<LayerState>) {
        add_states(&self.fading.displacement, &self.layers.displacement, &self.displacement, states);
        if let (Some(stack), Some(paint)) = (&self.layers.colors, &self.paint) {
            add_states(&self.fading.paint, stack, paint, states);
        }
        if let (Some(stack), Some(paint)) = (&self.layers.half_colors, &self.half_paint) {
            add_states(&self.fading.half_paint, stack, paint, states);
        }
    }

    /// Makes edits of `layers` stay, because they have become others.
    pub(crate) fn stop_fading(&mut self, layers: &[u32]) {
        each_kind!(self, kept => {
            kept.faded.retain(|faded| !layers.contains(&faded.layer));
            kept.name_expendable();
        });
    }

    /// Puts back stamps of a history, whose layers were put back, and brings these to the object's time.
    pub(crate) fn put_stamps(
        &mut self,
        context: &Context,
        heads: Option<&[Head]>,
        blocks: &[BlockState],
    ) -> Result<()> {
        let knows = heads.is_some_and(|heads| heads.iter().any(|head| head.stamps.is_some()));
        if self.fading.is_empty() && !knows {
            return Ok(());
        }
        let time = self.time;
        each_kind!(self, kept => kept.restore(context, heads, blocks, time)?);
        self.settle(context)?;
        self.take_as_stamped();
        Ok(())
    }

    /// Takes over the stamps of `document`, whose layers were taken over, and its time, if it has any. Layers that were
    /// there before have the numbers that `moved` says now.
    pub(crate) fn find_stamps(
        &mut self,
        context: &Context,
        document: &Document,
        budget: u64,
        moved: &[(u32, u32)],
    ) -> Result<()> {
        let mut newest: Option<f32> = None;
        let mut number = self.free_number().max(document.free_id());
        each_kind!(self, kept => {
            kept.follow(moved, &mut number);
            let found = kept.take_up(context, document, budget)?;
            newest = newest.into_iter().chain(found).reduce(f32::max);
        });
        self.fade_own()?;
        if document.layers().iter().any(|layer| layer.kind() == Kind::Stamps) {
            // Edits of the journal may be later than what the document says.
            let time = newest.map_or(document.time, |newest| document.time.max(f64::from(newest)));
            self.set_time(time)?;
            each_kind!(self, kept => kept.bring(context, time)?);
            self.settle(context)?;
        }
        self.take_as_stamped();
        Ok(())
    }
}

impl<T: Absorb> Kept<'_, T> {
    fn kind(&self) -> Kind {
        T::KIND
    }

    fn bring(&mut self, context: &Context, time: f64) -> Result<()> {
        for faded in &*self.faded {
            if let Some(channel) = self.stack.channel_mut(faded.layer, self.composite) {
                faded.decay.bring(context, channel, time, &[])?;
            }
        }
        Ok(())
    }
}
