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
use crate::store::heap::BlockId;
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

/// A channel whose blocks leave memory when its budget is spent.
pub(crate) trait Paged {
    /// What it knows of its pages.
    fn paging(&mut self) -> &mut Paging;

    /// What its blocks page to.
    fn pager(&self) -> Option<&Arc<Pager>>;

    /// Whether `bytes` more fit the budget.
    fn fits(&self, bytes: u64) -> bool;

    /// Whether a block is there and on a page.
    fn is_on_page(&self, block: u32) -> bool;

    /// The number of the edit that last changed a block.
    fn edited(&self, block: u32) -> u64;

    /// The blocks in the heap.
    fn here(&self) -> Vec<u32>;

    /// Gives a block back to the heap, its texels to a page. Returns whether that could be.
    fn evict(&mut self, block: u32) -> bool;

    /// Bytes of a block on a page that readers brought back.
    fn back_bytes(&self, block: u32) -> u64;

    /// Whether a block was looked at and could not be read.
    fn has_failed(&self, block: u32) -> bool;

    /// Forgets what readers brought back of a block.
    fn let_go(&mut self, block: u32);

    /// Gives blocks back until `bytes` more fit the budget, but none of `keep`, which ascend. Returns whether they fit.
    fn make_room(&mut self, bytes: u64, keep: &[u32]) -> bool {
        if self.fits(bytes) || self.pager().is_none() {
            return self.fits(bytes);
        }
        for listed in [false, true] {
            if listed {
                let here = self.here().into_iter().map(|block| (self.edited(block), block)).collect();
                self.paging().queue = here;
            }
            let (mut held, mut gone) = (Vec::new(), true);
            while gone && !self.fits(bytes) {
                let Some((version, block)) = self.paging().queue.pop_first() else { break };
                if self.is_on_page(block) || self.edited(block) != version {
                    continue;
                }
                let kept = keep.binary_search(&block).is_ok();
                gone = kept || self.evict(block);
                if kept || !gone {
                    held.push((version, block));
                }
            }
            self.paging().queue.extend(held);
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
                self.paging().back.insert(block);
            }
            // What could not be read may be there another time.
            if self.has_failed(block) {
                self.let_go(block);
                self.paging().back.remove(&block);
            }
        }
        let mut order: Vec<(u64, u32)> = Vec::new();
        for block in self.paging().back.clone() {
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
            self.let_go(block);
            self.paging().back.remove(&block);
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
        self.let_go();
        let all: Vec<u32> = self.field.allocated().filter(|tile| self.is_paged(*tile)).collect();
        all.iter().try_for_each(|tile| self.bring_back(*tile))?;
        self.paging = Paging::default();
        self.field.pager = store.map(Pager::new);
        self.trim();
        self.report_fault()
    }

    /// Where its blocks page to.
    pub fn page_store(&self) -> Option<&Arc<dyn PageStore>> {
        self.field.page_store()
    }

    /// Number of allocated tiles that are on pages, and have no place in the heap.
    pub fn paged_count(&self) -> usize {
        self.paging.count
    }

    /// Bytes of the blocks in the heap, and of blocks that readers brought back since the last edit or commit.
    pub fn resident_bytes(&self) -> u64 {
        let paged = self.field.allocated().filter(|tile| self.is_paged(*tile));
        self.bytes() + paged.map(|tile| self.back_bytes(tile)).sum::<u64>()
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
        self.field.pager.as_ref().and_then(|pager| pager.take_fault()).map_or(Ok(()), Err)
    }

    /// Fails if what is on pages of `tiles` cannot be read.
    pub(crate) fn check_pages(&self, tiles: impl IntoIterator<Item = u32>) -> Result<()> {
        if self.paging.count == 0 {
            return Ok(());
        }
        for tile in tiles {
            if let Some(entry) = self.field.entry(tile) {
                let checked = entry.texels.check().and_then(|()| entry.mips.check());
                if checked.is_err() {
                    // It is told now.
                    drop(self.report_fault());
                    return checked;
                }
            }
        }
        Ok(())
    }

    /// Takes away the block of `tile`. Returns its place in the heap, if it had one.
    pub(crate) fn take_block(&mut self, tile: u32) -> Option<BlockId> {
        let entry = self.field.entry_mut(tile).take()?;
        if entry.texels.is_paged() {
            self.paging.count -= 1;
            self.paging.back.remove(&tile);
            return None;
        }
        Some(entry.id)
    }

    /// Gives a tile on a page a place in the heap, beyond the budget if need be; its texels are `texels`, its mips come
    /// back too.
    pub(crate) fn place(&mut self, tile: u32, texels: Arc<[T]>, mips: Arc<[T]>) {
        let class = self.field.class(tile);
        let id = self.heap.allocate_beyond(class);
        if let Some(entry) = self.field.entry_mut(tile)
            && entry.texels.is_paged()
        {
            (entry.texels, entry.mips, entry.id) = (Slot::Here(texels), Slot::Here(mips), id);
            self.paging.count -= 1;
            self.paging.back.remove(&tile);
            // It is listed again in its order, if the list is of its age.
            let version = entry.version;
            self.paging.queue.insert((version, tile));
        }
    }

    /// Brings the block of `tile` back to the heap, beyond the budget if need be. Fails if it cannot be read.
    pub(crate) fn bring_back(&mut self, tile: u32) -> Result<()> {
        let Some(entry) = self.field.entry(tile).filter(|entry| entry.texels.is_paged()) else { return Ok(()) };
        let (texels, mips) = (entry.texels.shared()?, entry.mips.shared()?);
        self.place(tile, texels, mips);
        Ok(())
    }

    /// As [`Self::bring_back`]; the next call that can reports a failure. Returns whether it is in the heap.
    pub(crate) fn fetch(&mut self, tile: u32) -> bool {
        match self.bring_back(tile) {
            Ok(()) => true,
            Err(error) => {
                if let Some(pager) = &self.field.pager {
                    pager.note(tile, error);
                }
                false
            }
        }
    }

    /// Knows that `page` holds what the block of `tile` is now.
    pub(crate) fn set_clean(&mut self, tile: u32, page: Arc<dyn Page>) {
        if self.field.pager.is_some() {
            self.paging.clean.insert(tile, (self.field.version(tile), page));
        }
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

    /// Pages for itself, after it was copied from another channel.
    #[inline(never)]
    pub(crate) fn fork(&mut self) {
        let Some(pager) = self.field.pager.take() else { return };
        let pager = pager.fork();
        let paged: Vec<u32> = self.field.allocated().filter(|tile| self.is_paged(*tile)).collect();
        for tile in paged {
            if let Some(entry) = self.field.entry_mut(tile) {
                entry.texels.let_go(&pager);
                entry.mips.let_go(&pager);
            }
        }
        self.paging.back.clear();
        self.field.pager = Some(pager);
    }
}

impl<T: Texel> Paged for Channel<T> {
    fn paging(&mut self) -> &mut Paging {
        &mut self.paging
    }

    fn pager(&self) -> Option<&Arc<Pager>> {
        self.field.pager.as_ref()
    }

    fn fits(&self, bytes: u64) -> bool {
        self.bytes().saturating_add(bytes) <= self.budget()
    }

    fn is_on_page(&self, tile: u32) -> bool {
        self.is_paged(tile)
    }

    fn edited(&self, tile: u32) -> u64 {
        self.field.version(tile)
    }

    fn here(&self) -> Vec<u32> {
        self.field.allocated().filter(|tile| !self.is_paged(*tile)).collect()
    }

    fn evict(&mut self, tile: u32) -> bool {
        let (Some(pager), Some(entry)) = (self.field.pager.clone(), self.field.entry(tile)) else { return false };
        let blank = self.field.blank();
        let clean = self.paging.clean.remove(&tile).filter(|(version, _)| *version == entry.version);
        let texels = entry.texels.page_out(tile, blank, &pager, clean.map(|(_, page)| page));
        let paged = texels.and_then(|texels| Ok((texels, entry.mips.page_out(tile, blank, &pager, None)?)));
        match (paged, self.field.entry_mut(tile)) {
            (Ok((texels, mips)), Some(entry)) => {
                let id = entry.id;
                (entry.texels, entry.mips, entry.id.number) = (texels, mips, NOWHERE);
                self.heap.free(&[id]);
                self.paging.count += 1;
                true
            }
            (Err(error), _) => {
                pager.note(tile, error);
                false
            }
            (Ok(_), None) => false,
        }
    }

    fn back_bytes(&self, tile: u32) -> u64 {
        self.field.entry(tile).map_or(0, |entry| entry.texels.back_bytes() + entry.mips.back_bytes())
    }

    fn has_failed(&self, tile: u32) -> bool {
        self.field.entry(tile).is_some_and(|entry| entry.texels.has_failed() || entry.mips.has_failed())
    }

    fn let_go(&mut self, tile: u32) {
        if let (Some(pager), Some(entry)) = (self.field.pager.clone(), self.field.entry_mut(tile)) {
            entry.texels.let_go(&pager);
            entry.mips.let_go(&pager);
        }
    }
}
