//! Edits that fade: every texel that is edited gets a time stamp, and what was put there goes linearly back to what
//! tiles without a block read as.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.2. The
//! latest edit of a texel wins: what it left there fades from then on. The stamped texels are kept beside the channel
//! and faded from there, so that a fade does not depend on how many steps it takes and is not stopped by rounding. A
//! tile whose last texel has faded gives its blocks back. Where a budget is full, the tiles whose newest stamp is
//! oldest make room. Units: seconds; bytes: per tile (size + 2)² times those of a texel and a stamp of 4, in a heap of
//! its own.

use std::any::Any;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Kind, Stamps};
use relievo_gpu::Device;

use crate::layers::fade::{Fader, FadingBlock, words};
use crate::quads::channel::{Channel, neighbours};
use crate::quads::field::Field;
use crate::quads::ring::Change;
use crate::store::blocks::{Blocks, of_both};
use crate::store::heap::{Heap, SizeClass};
use crate::store::pages::{CowBlocks, Entry};
use crate::store::stored::StoredTexel;
use crate::texel::Texel;

/// When edits fade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecayOptions {
    /// How long an edit stays as it is, seconds.
    pub delay: f32,
    /// How long it then takes to fade, seconds; more than 0.
    pub duration: f32,
}

impl DecayOptions {
    /// Checks the times in seconds.
    ///
    /// # Errors
    /// Fails unless the times are finite, the delay is at least 0 and the duration more.
    pub fn check(&self) -> Result<()> {
        let Self { delay, duration } = *self;
        if delay >= 0.0 && duration > 0.0 && (delay + duration).is_finite() {
            return Ok(());
        }
        Err(Error::invalid(format!("edits cannot fade for {duration} s after {delay} s"))
            .advise("use a delay of at least 0 and a duration above 0"))
    }

    /// How much is left at `time` of an edit made at `stamp`.
    pub(crate) fn share(&self, stamp: f32, time: f64) -> f64 {
        let age = time - f64::from(stamp) - f64::from(self.delay);
        1.0 - (age / f64::from(self.duration)).clamp(0.0, 1.0)
    }
}

/// The texels of a tile as they were when they were edited last, and when that was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamped<'a, T> {
    /// `(size + 2)²` texels; the ring means nothing.
    pub texels: &'a [T],
    /// As many times in seconds; [`PERMANENT`] for what does not fade.
    pub stamps: &'a [f32],
}

/// The stamp of texels that do not fade.
pub const PERMANENT: f32 = f32::MAX;

/// The stamps of a channel.
#[derive(Debug)]
pub struct Decay<T> {
    options: DecayOptions,
    heap: Heap,
    /// Of every tile the texels and then the stamps; its version says how old it is, see [`age`].
    pages: CowBlocks<Entry<u32>>,
    texel: PhantomData<T>,
    /// Tiles whose stamps changed since they were last asked for.
    changed: Vec<u32>,
    fader: Fader,
}

/// What a fade did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FadeReport {
    /// Tiles of which texels changed, ascending.
    pub changed: Vec<u32>,
    /// Tiles that were given back, ascending.
    pub freed: Vec<u32>,
}

impl<T: Texel> Decay<T> {
    /// No stamps yet, for a channel of `tiles` tiles; they may occupy `budget` bytes.
    ///
    /// # Errors
    /// Fails as [`DecayOptions::check`].
    pub fn new(tiles: usize, options: DecayOptions, budget: u64) -> Result<Self> {
        options.check()?;
        let heap = Heap::new(size_of::<T>() + size_of::<f32>(), budget);
        let (pages, fader) = (CowBlocks::new(tiles), Fader::default());
        Ok(Self { options, heap, pages, texel: PhantomData, changed: Vec::new(), fader })
    }

    /// Has a graphics device evaluate what is left of edits from now on, or the processor again, which also takes over
    /// where the device fails.
    pub fn use_device(&mut self, device: Option<&Device>) {
        self.fader.use_device(device);
    }

    /// The failure after which the processor took over, told once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.fader.take_fault()
    }

    /// When edits fade.
    pub fn options(&self) -> DecayOptions {
        self.options
    }

    /// Replaces the decay times; edits already recorded follow the new ones.
    ///
    /// # Errors
    /// Fails as [`DecayOptions::check`].
    pub fn set_options(&mut self, options: DecayOptions) -> Result<()> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Bytes that the stamps and their texels may occupy.
    pub fn budget(&self) -> u64 {
        self.heap.budget()
    }

    /// The tiles that hold nothing but what fades, beginning with those whose newest stamp is oldest, each behind a
    /// number that grows with that stamp.
    pub fn oldest(&self) -> Vec<(u64, u32)> {
        let ages = self.pages.used().filter_map(|tile| Some((self.pages.entry(tile)?.version, tile)));
        let mut ages: Vec<(u64, u32)> = ages.filter(|(age, _)| *age != KEPT).collect();
        ages.sort_unstable();
        ages
    }

    /// The newest stamp there is.
    pub fn newest(&self) -> Option<f32> {
        let stamps = self.pages.used().filter_map(|tile| self.block(tile)).flat_map(|block| block.stamps);
        stamps.copied().filter(|stamp| *stamp != PERMANENT).max_by(f32::total_cmp)
    }

    /// Bytes of the stamps and the texels they belong to.
    pub fn bytes(&self) -> u64 {
        self.heap.bytes()
    }

    /// Number of tiles with stamps.
    pub fn stamped_count(&self) -> usize {
        self.heap.total()
    }

    /// The tiles with stamps, ascending.
    pub fn stamped(&self) -> impl Iterator<Item = u32> {
        self.pages.used()
    }

    /// The stamped texels of `tile`; `None` without stamps.
    pub fn block(&self, tile: u32) -> Option<Stamped<'_, T>> {
        self.pages.entry(tile).map(|entry| {
            let words = &entry.texels;
            let (texels, stamps) = words.split_at(entry.id.class.texels() * size_of::<T>() / size_of::<u32>());
            Stamped { texels: bytemuck::cast_slice(texels), stamps: bytemuck::cast_slice(stamps) }
        })
    }

    /// The tiles whose stamps changed since this was called last, ascending.
    pub fn take_changed(&mut self) -> Vec<u32> {
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort_unstable();
        changed.dedup();
        changed
    }

    /// Stamps with `time` all texels in which `channel` now differs from `before`. Returns the tiles, ascending, that
    /// the budget refused; what was edited there stays.
    ///
    /// # Panics
    /// If the channel or the field is that of another surface.
    #[inline(never)]
    pub fn stamp(&mut self, context: &Context, before: &Field<T>, channel: &Channel<T>, time: f64) -> Vec<u32> {
        let after = channel.field();
        let known = |tile: &u32| self.pages.entry(*tile).is_some_and(|known| known.id.class == after.class(*tile));
        let gone: Vec<u32> = self.pages.used().filter(|tile| !after.is_allocated(*tile) || !known(tile)).collect();
        self.remove(&gone);
        let edited: Vec<u32> = after.allocated().filter(|tile| after.version(*tile) != before.version(*tile)).collect();
        let known = &*self;
        let blank = after.blank();
        let stamped = context.map(edited.len(), |index| {
            let tile = edited[index];
            let new = after.block(tile).unwrap_or(&[]);
            // A face that was given another size has no texels to compare with.
            let old = before.block(tile).filter(|old| old.len() == new.len());
            let was = |at: usize| old.map_or(blank, |old| old[at]);
            // Rings are the neighbours'.
            let stride = after.size(tile) as usize + 2;
            let inner = (1..stride - 1).flat_map(|j| (1..stride - 1).map(move |i| j * stride + i));
            let edits: Vec<usize> = inner.filter(|at| !new[*at].same(was(*at))).collect();
            if edits.is_empty() {
                return None;
            }
            let (mut texels, mut stamps) = (new.to_vec(), vec![PERMANENT; new.len()]);
            let known = known.block(tile).filter(|known| known.texels.len() == new.len());
            if let Some(known) = known {
                texels.copy_from_slice(known.texels);
                stamps.copy_from_slice(known.stamps);
            }
            for at in edits {
                (texels[at], stamps[at]) = (new[at], time as f32);
            }
            Some((tile, words(&texels, &stamps), age(&texels, &stamps, stride, blank)))
        });
        let mut refused = Vec::new();
        for (tile, stamps, age) in stamped.into_iter().flatten() {
            if !self.put(tile, after.class(tile), stamps, age) {
                refused.push(tile);
            }
        }
        refused
    }

    /// Brings the texels of `channel` to what is left of them at `time`, which never goes back, and gives back what has
    /// faded. Borders toward tiles that the channel's budget refuses are blank, as after an edit.
    ///
    /// # Errors
    /// Fails if a page of the channel cannot be read or written.
    ///
    /// # Panics
    /// If the channel is that of another surface.
    #[inline(never)]
    pub fn fade(&mut self, context: &Context, channel: &mut Channel<T>, time: f64) -> Result<FadeReport> {
        let gone: Vec<u32> = self.pages.used().filter(|tile| !channel.field().is_allocated(*tile)).collect();
        self.remove(&gone);
        let done = self.chosen(context, channel, |stamps| {
            !stamps.iter().any(|stamp| *stamp != PERMANENT && self.options.share(*stamp, time) > 0.0)
        });
        let changed = self.bring(context, channel, time, &[])?;
        self.remove(&done);
        let topology = channel.field().topology().clone();
        let mut around: Vec<u32> = done.iter().flat_map(|tile| neighbours(&topology, *tile)).collect();
        around.extend(&done);
        around.sort_unstable();
        around.dedup();
        let freed = channel.reclaim(context, &around)?;
        Ok(FadeReport { changed, freed })
    }

    /// The tiles with stamps for which `wanted` holds; those whose blocks have another size have none.
    fn chosen(&self, context: &Context, channel: &Channel<T>, wanted: impl Fn(&[f32]) -> bool + Sync) -> Vec<u32> {
        let (tiles, field): (Vec<u32>, _) = (self.pages.used().collect(), channel.field());
        let chosen = context.map(tiles.len(), |index| {
            let stamps = self.block(tiles[index]).map_or(&[][..], |known| known.stamps);
            let fits = field.block(tiles[index]).is_some_and(|block| block.len() == stamps.len());
            wanted(if fits { stamps } else { &[] })
        });
        tiles.into_iter().zip(chosen).filter_map(|(tile, chosen)| chosen.then_some(tile)).collect()
    }

    /// As [`Self::fade`] without giving anything back, so that stamps stay what they are: after stamps and blocks of
    /// `restored` tiles were put back, which may be those of another time. Returns the tiles of which texels changed.
    ///
    /// # Errors
    /// Fails if a tile of `restored` does not exist or is a hole, or a page of the channel cannot be read or written.
    #[inline(never)]
    pub fn bring(
        &mut self,
        context: &Context,
        channel: &mut Channel<T>,
        time: f64,
        restored: &[u32],
    ) -> Result<Vec<u32>> {
        let options = self.options;
        let fading =
            self.chosen(context, channel, |stamps| stamps.iter().any(|stamp| options.share(*stamp, time) < 1.0));
        let blank = channel.field().blank();
        let left = self.evaluate(context, &fading, blank, time);
        let known = &*self;
        let mut changes = channel.edit(context, &fading, |tile, texels| {
            let Some(known) = known.block(tile) else { return };
            let size = texels.size();
            let rows = known.texels.chunks_exact(size + 2).zip(known.stamps.chunks_exact(size + 2)).skip(1);
            let left = left.get(&tile).map(|left| &left[size + 2..]);
            for (j, (edited, stamps)) in (0..size).zip(rows) {
                let left = left.map(|left| &left[j * (size + 2) + 1..]);
                let row = texels.row_mut(j).iter_mut().zip(&edited[1..]).zip(&stamps[1..]);
                for (i, ((texel, edited), stamp)) in row.enumerate() {
                    let share = options.share(*stamp, time);
                    if share < 1.0 {
                        *texel = match left {
                            _ if share <= 0.0 => blank,
                            Some(left) => left[i],
                            None => T::nearest(blank.value() + (edited.value() - blank.value()) * share),
                        };
                    }
                }
            }
        })?;
        let changed: Vec<u32> = changes.iter().map(|change| change.tile).collect();
        changes.extend(restored.iter().map(|tile| Change::all(*tile)));
        channel.settle(context, &changes)?;
        Ok(changed)
    }

    /// What a device says is left of tiles that fade; nothing where the processor is to.
    #[inline(never)]
    fn evaluate(&mut self, context: &Context, fading: &[u32], blank: T, time: f64) -> BTreeMap<u32, Vec<T>> {
        if !self.fader.is_on_device() || fading.is_empty() {
            return BTreeMap::new();
        }
        let block = |tile: &u32| {
            let entry = self.pages.entry(*tile)?;
            Some(FadingBlock { block: *tile, words: entry.texels.clone(), texels: entry.id.class.texels() })
        };
        let blocks: Vec<FadingBlock> = fading.iter().filter_map(block).collect();
        let (fader, options) = (&mut self.fader, self.options);
        context.stats().time("decay.device", || fader.evaluate(&blocks, blank, options, time))
    }

    /// The stamped texels of `tile` as bytes: all texels, then all stamps; `None` without stamps.
    pub fn read(&self, tile: u32) -> Option<Vec<u8>> {
        self.pages.entry(tile).map(|entry| bytemuck::cast_slice(&entry.texels).to_vec())
    }

    /// Puts back what [`Self::read`] gave, for tiles of the sizes that `field` has.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the tile does not exist, the length is not that of its block, a number is not
    /// finite, or the budget does not allow it.
    #[inline(never)]
    pub fn write(&mut self, field: &Field<T>, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        let place = || format!("tile {tile}");
        if tile as usize >= field.tile_count() {
            return Err(Error::invalid("it does not exist").at(place()));
        }
        let Some(bytes) = bytes else {
            self.remove(&[tile]);
            return Ok(());
        };
        let class = field.class(tile);
        let count = class.texels();
        if bytes.len() != count * (size_of::<T>() + size_of::<f32>()) {
            return Err(Error::invalid(format!("stamps of {} bytes cannot be put back", bytes.len())).at(place()));
        }
        let (texels, stamps) = bytes.split_at(count * size_of::<T>());
        let texels: Vec<T> = texels.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect();
        let stamps: Vec<f32> = stamps.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        if !T::all_finite(&texels) || stamps.iter().any(|stamp| !stamp.is_finite()) {
            return Err(Error::invalid("a number of the stamps is not finite").at(place()));
        }
        let age = age(&texels, &stamps, class.size() as usize + 2, field.blank());
        if !self.put(tile, class, words(&texels, &stamps), age) {
            return Err(Error::memory("the stamps need more than their budget").at(place()));
        }
        Ok(())
    }

    /// Whether there is room for the stamps of a tile, which then has them.
    fn put(&mut self, tile: u32, class: SizeClass, texels: Arc<[u32]>, age: u64) -> bool {
        if let Some(entry) = self.pages.entry_mut(tile).take_if(|entry| entry.id.class != class) {
            self.heap.free(&[entry.id]);
        }
        let known = self.pages.entry(tile).map(|entry| entry.id);
        let Some(id) = known.or_else(|| self.heap.allocate(&[class])[0]) else { return false };
        *self.pages.entry_mut(tile) = Some(Entry { texels, id, version: age });
        self.changed.push(tile);
        true
    }

    fn remove(&mut self, tiles: &[u32]) {
        for tile in tiles {
            if let Some(entry) = self.pages.entry_mut(*tile).take() {
                self.heap.free(&[entry.id]);
                self.changed.push(*tile);
            }
        }
    }
}

impl<T: StoredTexel> Decay<T> {
    /// What documents say of the stamps of `channel`, the layer `layer`.
    pub fn head(&self, layer: u32) -> Stamps {
        let DecayOptions { delay, duration } = self.options;
        Stamps { layer, texel: T::KIND, delay, duration }
    }

    /// The stamps as histories and documents see them, of a channel that is `field` now.
    pub fn blocks(&self, field: &Field<T>) -> StampBlocks<T> {
        let blank = [bytemuck::bytes_of(&T::zeroed()), &PERMANENT.to_le_bytes()].concat();
        StampBlocks { pages: self.pages.clone(), field: field.clone(), blank }
    }

    /// The stamps that `document` has as the layer called `name`, for a channel that is `field` now, in `budget` bytes.
    ///
    /// # Errors
    /// Fails if there is no such layer of these texels, it is damaged, or `budget` is too small.
    #[inline(never)]
    pub fn stored(context: &Context, document: &Document, name: &str, field: &Field<T>, budget: u64) -> Result<Self> {
        let place = |error: Error| error.at(format!("layer `{name}`"));
        let layer = document.layer(name).ok_or_else(|| Error::invalid("there is no such layer")).map_err(place)?;
        let stamps = layer.head().stamps.filter(|stamps| stamps.texel == T::KIND);
        let stamps = stamps.ok_or_else(|| place(Error::invalid("its times are those of other texels")))?;
        let Stamps { delay, duration, .. } = stamps;
        let mut decay = Self::new(field.tile_count(), DecayOptions { delay, duration }, budget)?;
        let unpacked = context.map(layer.blocks().len(), |at| layer.unpack(document.topology(), at));
        for (block, bytes) in layer.blocks().iter().zip(unpacked) {
            decay.write(field, block.tile(), Some(&bytes?)).map_err(place)?;
        }
        Ok(decay)
    }

    /// Puts back stamps whatever the budget says.
    ///
    /// # Errors
    /// Fails as [`Self::write`], but for the budget.
    pub fn restore(&mut self, field: &Field<T>, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        let budget = self.heap.budget();
        self.heap.set_budget(u64::MAX);
        let done = self.write(field, tile, bytes);
        self.heap.set_budget(budget);
        done
    }
}

/// The stamps of a channel at one moment, with the texels they belong to.
#[derive(Clone, Debug)]
pub struct StampBlocks<T> {
    pages: CowBlocks<Entry<u32>>,
    field: Field<T>,
    blank: Vec<u8>,
}

impl<T: StoredTexel> Blocks for StampBlocks<T> {
    fn kind(&self) -> Kind {
        Kind::Stamps
    }

    fn blank(&self) -> &[u8] {
        &self.blank
    }

    fn face_sizes(&self) -> Vec<u32> {
        self.field.face_sizes()
    }

    fn given_sizes(&self) -> Vec<u32> {
        self.field.given_sizes()
    }

    fn bytes(&self, block: u32) -> Option<Cow<'_, [u8]>> {
        self.pages.entry(block).map(|entry| Cow::Borrowed(bytemuck::cast_slice(&entry.texels)))
    }

    fn numbers(&self) -> Vec<u32> {
        self.pages.used().collect()
    }

    fn changed(&self, other: &dyn Blocks) -> Vec<u32> {
        let any: &dyn Any = other;
        let Some(other) = any.downcast_ref::<Self>() else { return of_both(self, other) };
        let differs = |tile: &u32| match (self.pages.entry(*tile), other.pages.entry(*tile)) {
            (Some(a), Some(b)) => !Arc::ptr_eq(&a.texels, &b.texels) && a.texels != b.texels,
            (a, b) => a.is_some() || b.is_some(),
        };
        self.pages.unshared(&other.pages).filter(differs).collect()
    }

    fn is_shaped_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| self.field.is_shaped_as(&other.field))
    }
}

/// The age of tiles with texels that do not fade and are not blank either.
const KEPT: u64 = u64::MAX;

/// A number that grows with the newest stamp of a tile of `stride` texels a side; [`KEPT`] if something does not fade.
fn age<T: Texel>(texels: &[T], stamps: &[f32], stride: usize, blank: T) -> u64 {
    let mut newest = f32::NEG_INFINITY;
    for row in (stride..texels.len() - stride).step_by(stride) {
        let inner = row + 1..row + stride - 1;
        for (texel, stamp) in texels[inner.clone()].iter().zip(&stamps[inner]) {
            if *stamp != PERMANENT {
                newest = newest.max(*stamp);
            } else if !texel.is_blank(blank) {
                return KEPT;
            }
        }
    }
    order(newest)
}

/// A number that grows with `stamp`.
pub(crate) fn order(stamp: f32) -> u64 {
    // Floats of one sign are ordered as their bits are.
    let bits = stamp.to_bits();
    u64::from(if bits >> 31 == 0 { bits | 1 << 31 } else { !bits })
}
