//! Paging: when the byte budget of a channel is spent, the blocks that were edited longest ago make room for others.
//!
//! Nothing that is read or written depends on it but memory and time: a block on a page returns when it is looked at,
//! see [`crate::store::slot`], and has a place in the heap again when it is edited. So which blocks go does not change a
//! result; it is those of the oldest version, of equal ones that of the lowest tile, whatever readers looked at. Blocks
//! go while a channel is edited or committed, never while it is only read. Within an edit its own blocks may exceed the
//! budget for a while, together with what was read for it; when it is settled the budget holds again. Only tiles that
//! are new are refused, where they do not fit the budget together with the others of the same edit. Units: bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use relievo_core::Result;
use relievo_document::{Page, PageStore};

use crate::quads::channel::Channel;
use crate::quads::field::Entry;
use crate::store::heap::{BlockId, Class, Heap, SizeClass};
use crate::store::sets::Sets;
use crate::store::slot::{Pager, Slot};
use crate::texel::Texel;

/// What a channel knows of its pages. Blocks are tiles, or those of triangles by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Paging {
    /// Blocks on pages.
    pub count: usize,
    /// Of those, blocks of which readers brought something back.
    pub back: BTreeSet<u32>,
    /// Versions and numbers of blocks in the heap, the oldest of all; some may have changed since they were listed.
    pub queue: BTreeSet<(u64, u32)>,
    /// Pages that hold what blocks in the heap had at a version.
    pub clean: BTreeMap<u32, (u64, Arc<dyn Page>)>,
}

/// The number that blocks on pages have instead of one in a heap.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// The blocks of a channel: their places in the heap, which of them are on pages, and what edits did to them.
#[derive(Clone, Debug)]
pub(crate) struct BlockStore<C: Class = SizeClass> {
    pub heap: Heap<C>,
    pub paging: Paging,
    /// The number of the last edit.
    pub revision: u64,
    /// Tiles or faces that were lost since [`Self::take_lost`].
    pub lost: Vec<u32>,
}

impl<C: Class> BlockStore<C> {
    /// Makes a store without blocks, whose places are those of `heap`.
    pub fn new(heap: Heap<C>) -> Self {
        Self { heap, paging: Paging::default(), revision: 0, lost: Vec::new() }
    }

    /// Returns the tiles or faces that were lost since this was called last, ascending.
    pub fn take_lost(&mut self) -> Vec<u32> {
        let mut lost = std::mem::take(&mut self.lost);
        lost.sort_unstable();
        lost.dedup();
        lost
    }
}

/// A block of a channel, in the heap or on a page.
pub(crate) trait StoredBlock<T: Texel, C> {
    /// Its texels, then its mips if it has some.
    fn slots(&self) -> impl Iterator<Item = &Slot<T>>;

    /// As [`Self::slots`], for writing.
    fn slots_mut(&mut self) -> impl Iterator<Item = &mut Slot<T>>;

    /// Whether its texels are on a page.
    fn is_paged(&self) -> bool {
        self.slots().next().is_some_and(Slot::is_paged)
    }

    /// Its class, and its number where it is in the heap.
    fn id(&self) -> BlockId<C>;

    /// Gives it another number.
    fn set_number(&mut self, number: u32);

    /// The number of the edit that last changed it.
    fn version(&self) -> u64;
}

/// A channel whose blocks leave memory when its budget is spent.
pub(crate) trait Paged {
    /// Its texels.
    type Texel: Texel;
    /// The sizes of its blocks.
    type Class: Class;
    /// A block of it.
    type Block: StoredBlock<Self::Texel, Self::Class>;

    /// Its heap and its pages.
    fn blocks(&self) -> &BlockStore<Self::Class>;

    /// As [`Self::blocks`], for writing.
    fn blocks_mut(&mut self) -> &mut BlockStore<Self::Class>;

    /// What its blocks page to.
    fn pager(&self) -> Option<&Arc<Pager>>;

    /// As [`Self::pager`], for writing.
    fn pager_mut(&mut self) -> &mut Option<Arc<Pager>>;

    /// What texels without a block read as.
    fn blank(&self) -> Self::Texel;

    /// The block with a number, if it is there.
    fn stored(&self, block: u32) -> Option<&Self::Block>;

    /// As [`Self::stored`], for writing.
    fn stored_mut(&mut self, block: u32) -> Option<&mut Self::Block>;

    /// The numbers of the blocks that are there.
    fn numbers(&self) -> Vec<u32>;

    /// Whether `bytes` more fit the budget.
    fn fits(&self, bytes: u64) -> bool {
        let heap = &self.blocks().heap;
        heap.bytes().saturating_add(bytes) <= heap.budget()
    }

    /// Whether a block is there and on a page.
    fn is_on_page(&self, block: u32) -> bool {
        self.stored(block).is_some_and(StoredBlock::is_paged)
    }

    /// The number of the edit that last changed a block.
    fn edited(&self, block: u32) -> u64 {
        self.stored(block).map_or(0, StoredBlock::version)
    }

    /// The blocks in the heap.
    fn here(&self) -> Vec<u32> {
        let mut all = self.numbers();
        all.retain(|block| !self.is_on_page(*block));
        all
    }

    /// The blocks on pages, in the order of [`Self::numbers`].
    fn on_pages(&self) -> Vec<u32> {
        if self.blocks().paging.count == 0 {
            return Vec::new();
        }
        let mut all = self.numbers();
        all.retain(|block| self.is_on_page(*block));
        all
    }

    /// Gives a block back to the heap, its texels to a page. Returns whether that could be.
    fn evict(&mut self, block: u32) -> bool {
        let (Some(pager), blank, version) = (self.pager().cloned(), self.blank(), self.edited(block)) else {
            return false;
        };
        let clean = self.blocks_mut().paging.clean.remove(&block).filter(|(clean, _)| *clean == version);
        let Some(stored) = self.stored(block) else { return false };
        // The page that is clean has the texels.
        let mut clean = clean.map(|(_, page)| page);
        let paged: Result<Vec<_>> =
            stored.slots().map(|slot| slot.page_out(block, blank, &pager, clean.take())).collect();
        let id = stored.id();
        match (paged, self.stored_mut(block)) {
            (Ok(paged), Some(stored)) => {
                stored.slots_mut().zip(paged).for_each(|(slot, paged)| *slot = paged);
                stored.set_number(NOWHERE);
                let blocks = self.blocks_mut();
                blocks.heap.free(&[id]);
                blocks.paging.count += 1;
                true
            }
            (Err(error), _) => {
                pager.note(block, error);
                false
            }
            (Ok(_), None) => false,
        }
    }

    /// Bytes of a block on a page that readers brought back.
    fn back_bytes(&self, block: u32) -> u64 {
        self.stored(block).map_or(0, |block| block.slots().map(Slot::back_bytes).sum())
    }

    /// Bytes of all blocks on pages that readers brought back.
    fn all_back_bytes(&self) -> u64 {
        self.on_pages().into_iter().map(|block| self.back_bytes(block)).sum()
    }

    /// Whether a block was looked at and could not be read.
    fn has_failed(&self, block: u32) -> bool {
        self.stored(block).is_some_and(|block| block.slots().any(Slot::has_failed))
    }

    /// Releases what readers brought back of a block.
    fn release(&mut self, block: u32) {
        if let (Some(pager), Some(block)) = (self.pager().cloned(), self.stored_mut(block)) {
            block.slots_mut().for_each(|slot| slot.release(&pager));
        }
    }

    /// Returns a failure of the store of pages, once.
    fn fault(&self) -> Result<()> {
        self.pager().and_then(|pager| pager.take_fault()).map_or(Ok(()), Err)
    }

    /// Fails if what is on pages of `blocks` cannot be read.
    fn check_readable(&self, blocks: impl IntoIterator<Item = u32>) -> Result<()> {
        if self.blocks().paging.count == 0 {
            return Ok(());
        }
        for block in blocks {
            let checked = self.stored(block).map_or(Ok(()), |block| block.slots().try_for_each(Slot::check));
            if checked.is_err() {
                // It is reported now.
                drop(self.fault());
                return checked;
            }
        }
        Ok(())
    }

    /// Notes that a block has a place in the heap again, or is gone.
    fn leave_page(&mut self, block: u32) {
        let paging = &mut self.blocks_mut().paging;
        paging.count -= 1;
        paging.back.remove(&block);
    }

    /// Gives a block on a page a place in the heap, beyond the budget if need be; its texels, and then its mips, are
    /// `texels`.
    fn place(&mut self, block: u32, texels: impl IntoIterator<Item = Arc<[Self::Texel]>>) {
        let Some(stored) = self.stored_mut(block).filter(|stored| stored.is_paged()) else { return };
        stored.slots_mut().zip(texels).for_each(|(slot, texels)| *slot = Slot::Here(texels));
        let (class, version) = (stored.id().class, stored.version());
        let id = self.blocks_mut().heap.allocate_beyond(class);
        if let Some(stored) = self.stored_mut(block) {
            stored.set_number(id.number);
        }
        self.leave_page(block);
        // It is listed again in its order, if the list is of its age.
        self.blocks_mut().paging.queue.insert((version, block));
    }

    /// Brings a block back to the heap, beyond the budget if need be. Fails if it cannot be read.
    fn bring_back(&mut self, block: u32) -> Result<()> {
        let Some(stored) = self.stored(block).filter(|stored| stored.is_paged()) else { return Ok(()) };
        let texels: Vec<_> = stored.slots().map(Slot::shared).collect::<Result<_>>()?;
        self.place(block, texels);
        Ok(())
    }

    /// As [`Self::bring_back`]; the next call that can reports a failure. Returns whether it is in the heap.
    fn fetch(&mut self, block: u32) -> bool {
        match self.bring_back(block) {
            Ok(()) => true,
            Err(error) => {
                if let Some(pager) = self.pager() {
                    pager.note(block, error);
                }
                false
            }
        }
    }

    /// Notes that `page` holds what a block is now.
    fn set_clean(&mut self, block: u32, page: Arc<dyn Page>) {
        if self.pager().is_some() {
            let version = self.edited(block);
            self.blocks_mut().paging.clean.insert(block, (version, page));
        }
    }

    /// Makes blocks page to `pager`, or brings all back without one. Fails if blocks cannot be read back or written.
    fn turn_to(&mut self, pager: Option<Arc<Pager>>) -> Result<()> {
        self.on_pages().into_iter().try_for_each(|block| self.bring_back(block))?;
        self.blocks_mut().paging = Paging::default();
        *self.pager_mut() = pager;
        self.trim();
        self.fault()
    }

    /// Pages for itself, after it was copied from another channel.
    fn fork(&mut self) {
        let Some(pager) = self.pager().map(|pager| pager.fork()) else { return };
        *self.pager_mut() = Some(pager);
        self.on_pages().into_iter().for_each(|block| self.release(block));
        self.blocks_mut().paging.back.clear();
    }

    /// Gives blocks back until `bytes` more fit the budget, but none of `keep`, which ascend. Returns whether they fit.
    fn make_room(&mut self, bytes: u64, keep: &[u32]) -> bool {
        if self.fits(bytes) || self.pager().is_none() {
            return self.fits(bytes);
        }
        for listed in [false, true] {
            if listed {
                let here = self.here().into_iter().map(|block| (self.edited(block), block)).collect();
                self.blocks_mut().paging.queue = here;
            }
            let (mut held, mut gone) = (Vec::new(), true);
            while gone && !self.fits(bytes) {
                let Some((version, block)) = self.blocks_mut().paging.queue.pop_first() else { break };
                if self.is_on_page(block) || self.edited(block) != version {
                    continue;
                }
                let kept = keep.binary_search(&block).is_ok();
                gone = kept || self.evict(block);
                if kept || !gone {
                    held.push((version, block));
                }
            }
            self.blocks_mut().paging.queue.extend(held);
            if self.fits(bytes) || !gone {
                break;
            }
        }
        self.fits(bytes)
    }

    /// Brings the bytes in memory down to the budget: what readers brought back goes first.
    fn trim(&mut self) {
        let Some(pager) = self.pager().cloned() else { return };
        for block in pager.take_back() {
            if self.back_bytes(block) > 0 {
                self.blocks_mut().paging.back.insert(block);
            }
            // What could not be read may be there another time.
            if self.has_failed(block) {
                self.release(block);
                self.blocks_mut().paging.back.remove(&block);
            }
        }
        let mut order: Vec<(u64, u32)> = Vec::new();
        for block in self.blocks_mut().paging.back.clone() {
            order.push((self.edited(block), block));
        }
        let mut back: u64 = order.iter().map(|(_, block)| self.back_bytes(*block)).sum();
        if self.fits(back) {
            return;
        }
        order.sort_unstable();
        for (_, block) in order {
            if self.fits(back) {
                break;
            }
            back -= self.back_bytes(block);
            self.release(block);
            self.blocks_mut().paging.back.remove(&block);
        }
        self.make_room(0, &[]);
    }
}

impl<T: Texel> Channel<T> {
    /// Makes blocks leave memory for `store` when the budget is spent, the oldest first; without a store all come back,
    /// whatever the budget is. Layers that are made of this channel page to the same store.
    ///
    /// # Errors
    /// Fails if blocks cannot be read back or written.
    #[inline(never)]
    pub fn page_to(&mut self, store: Option<Arc<dyn PageStore>>) -> Result<()> {
        self.release_spent();
        self.turn_to(store.map(Pager::new))
    }

    /// Where its blocks page to.
    pub fn page_store(&self) -> Option<&Arc<dyn PageStore>> {
        self.field.page_store()
    }

    /// Number of allocated tiles that are on pages, and have no place in the heap.
    pub fn paged_count(&self) -> usize {
        self.blocks.paging.count
    }

    /// Bytes of the blocks in the heap, and of blocks that readers brought back since the last edit or commit.
    pub fn resident_bytes(&self) -> u64 {
        self.bytes() + self.all_back_bytes()
    }

    /// Whether `tile` is allocated and on a page.
    pub fn is_paged(&self, tile: u32) -> bool {
        self.field.is_paged(tile)
    }

    /// Reports a failure of the store of pages, once.
    ///
    /// # Errors
    /// Fails with what could not be read back, or written, since it was asked last.
    pub fn report_fault(&self) -> Result<()> {
        self.fault()
    }

    /// Takes away the block of `tile`. Returns its place in the heap, if it had one.
    pub(crate) fn take_block(&mut self, tile: u32) -> Option<BlockId> {
        let entry = self.field.entry_mut(tile).take()?;
        if entry.texels.is_paged() {
            self.leave_page(tile);
            return None;
        }
        Some(entry.id)
    }

    /// Makes room for an edit of `sets`: the tiles `wanted`, which are new, as far as they fit the budget together with
    /// the others, which come back.
    #[inline(never)]
    pub(crate) fn clear_the_way(&mut self, sets: &Sets, wanted: &[u32]) {
        if self.field.pager.is_none() {
            return;
        }
        let mut own: Vec<u32> = sets.allocate.iter().chain(&sets.modify).copied().collect();
        own.sort_unstable();
        own.dedup();
        let there: Vec<u32> = own.iter().copied().filter(|tile| self.field.is_allocated(*tile)).collect();
        let bytes = |tile: &u32| self.field.tile_bytes(*tile);
        let mut all: u64 = there.iter().map(bytes).sum();
        let mut new = 0;
        for bytes in wanted.iter().map(bytes) {
            if all.saturating_add(bytes) <= self.budget() {
                (all, new) = (all + bytes, new + bytes);
            }
        }
        let back: Vec<u32> = there.into_iter().filter(|tile| self.is_paged(*tile)).collect();
        let bytes: u64 = back.iter().map(|tile| self.field.tile_bytes(*tile)).sum();
        self.make_room(new.saturating_add(bytes), &own);
        for tile in back {
            if self.bytes() + new + self.field.tile_bytes(tile) <= self.budget() {
                self.fetch(tile);
            }
        }
    }
}

impl<T: Texel> StoredBlock<T, SizeClass> for Entry<T> {
    fn slots(&self) -> impl Iterator<Item = &Slot<T>> {
        [&self.texels, &self.mips].into_iter()
    }

    fn slots_mut(&mut self) -> impl Iterator<Item = &mut Slot<T>> {
        [&mut self.texels, &mut self.mips].into_iter()
    }

    fn id(&self) -> BlockId {
        self.id
    }

    fn set_number(&mut self, number: u32) {
        self.id.number = number;
    }

    fn version(&self) -> u64 {
        self.version
    }
}

impl<T: Texel> Paged for Channel<T> {
    type Texel = T;
    type Class = SizeClass;
    type Block = Entry<T>;

    fn blocks(&self) -> &BlockStore {
        &self.blocks
    }

    fn blocks_mut(&mut self) -> &mut BlockStore {
        &mut self.blocks
    }

    fn pager(&self) -> Option<&Arc<Pager>> {
        self.field.pager.as_ref()
    }

    fn pager_mut(&mut self) -> &mut Option<Arc<Pager>> {
        &mut self.field.pager
    }

    fn blank(&self) -> T {
        self.field.blank()
    }

    fn stored(&self, tile: u32) -> Option<&Entry<T>> {
        self.field.entry(tile)
    }

    fn stored_mut(&mut self, tile: u32) -> Option<&mut Entry<T>> {
        self.field.entry_mut(tile).as_mut()
    }

    fn numbers(&self) -> Vec<u32> {
        self.field.allocated().collect()
    }
}
