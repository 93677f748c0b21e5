//! Paging of triangle meshes: when the byte budget of a channel is spent, the blocks of faces and edges that were
//! edited longest ago make room for others. See [`crate::store::paging`].
//!
//! Each block pages by itself, with the face or the edge it belongs to: a face and its edges stay allocated together.
//! Vertices never page, nor do normals, which are no channel. Units: bytes.

use std::sync::Arc;

use relievo_core::Result;
use relievo_document::{Page, PageStore};

use super::block::TriangleBlock;
use super::channel::TriangleChannel;
use super::field::{Entry, TriangleClass};
use crate::store::heap::{BlockId, Class};
use crate::store::paging::{NOWHERE, Paged, Paging};
use crate::store::slot::{Pager, Slot};
use crate::texel::Texel;

impl<T: Texel> TriangleChannel<T> {
    /// Makes blocks leave memory for `store` when the budget is spent, the oldest first; without a store all come back,
    /// whatever the budget is. Composites that are made of this channel page to the same store.
    ///
    /// # Errors
    /// Fails if blocks cannot be read back or written.
    #[inline(never)]
    pub fn page_to(&mut self, store: Option<Arc<dyn PageStore>>) -> Result<()> {
        self.paged().into_iter().try_for_each(|block| self.bring_back(block))?;
        self.paging = Paging::default();
        self.field.pager = store.map(|store| Pager::of(store, "block"));
        self.trim();
        self.report_fault()
    }

    /// Where its blocks page to.
    pub fn page_store(&self) -> Option<&Arc<dyn PageStore>> {
        self.field.pager.as_ref().map(|pager| &pager.store)
    }

    /// Whether a block of a face or an edge is there and on a page.
    pub fn is_paged(&self, block: u32) -> bool {
        self.field.is_paged(block)
    }

    /// The blocks that are on pages and have no place in the heap, ascending.
    pub fn paged(&self) -> Vec<u32> {
        if self.paging.count == 0 {
            return Vec::new();
        }
        self.field.all_blocks().filter(|block| self.is_paged(*block)).collect()
    }

    /// Bytes of vertices and blocks in the heap, and of blocks that readers brought back since the last edit or commit.
    pub fn resident_bytes(&self) -> u64 {
        self.bytes() + self.paged().into_iter().map(|block| self.back_bytes(block)).sum::<u64>()
    }

    /// Reports a failure of the store of pages, once.
    ///
    /// # Errors
    /// Fails with what could not be read back, or written, since it was asked last.
    pub fn report_fault(&self) -> Result<()> {
        self.field.pager.as_ref().and_then(|pager| pager.take_fault()).map_or(Ok(()), Err)
    }

    /// Fails if what is on pages of `blocks` cannot be read.
    pub(super) fn check_pages(&self, blocks: impl IntoIterator<Item = TriangleBlock>) -> Result<()> {
        if self.paging.count == 0 {
            return Ok(());
        }
        for block in blocks {
            let checked = self.field.block(block).map_or(Ok(()), |entry| entry.texels.check());
            if checked.is_err() {
                // It is told now.
                drop(self.report_fault());
                return checked;
            }
        }
        Ok(())
    }

    /// Takes away a block. Returns its place in the heap, if it had one.
    pub(super) fn take_block(&mut self, block: TriangleBlock) -> Option<BlockId<TriangleClass>> {
        let number = block.number(self.field.topology());
        let entry = self.field.block_mut(block)?.take()?;
        if entry.texels.is_paged() {
            self.paging.count -= 1;
            self.paging.back.remove(&number);
            return None;
        }
        Some(entry.id)
    }

    /// Bytes that a block takes of the heap.
    pub(super) fn bytes_here(&self, block: TriangleBlock) -> u64 {
        let here = self.field.block(block).filter(|entry| !entry.texels.is_paged());
        here.map_or(0, |entry| self.heap.bytes_of(entry.id.class))
    }

    /// Gives a block that is there other values of its pattern, in the heap, beyond the budget if need be.
    pub(super) fn replace(&mut self, block: TriangleBlock, values: Arc<[T]>) {
        let version = self.revision;
        let number = block.number(self.field.topology());
        let Some(Some(entry)) = self.field.block_mut(block) else { return };
        if entry.texels.is_paged() {
            entry.id = self.heap.allocate_beyond(entry.id.class);
            self.paging.count -= 1;
            self.paging.back.remove(&number);
        }
        (entry.texels, entry.version) = (Slot::Here(values), version);
        self.mark(block);
    }

    /// Gives a block that is not there a place in the heap with `values`, beyond the budget if need be.
    pub(super) fn create(&mut self, block: TriangleBlock, class: TriangleClass, values: Arc<[T]>) {
        debug_assert_eq!(values.len(), class.values());
        let version = self.revision;
        if let Some(entry) = self.field.block_mut(block) {
            let id = self.heap.allocate_beyond(class);
            *entry = Some(Entry { texels: Slot::Here(values), id, version });
            self.mark(block);
        }
    }

    /// Brings a block back to the heap, beyond the budget if need be. Fails if it cannot be read.
    fn bring_back(&mut self, number: u32) -> Result<()> {
        let Some(block) = TriangleBlock::of(self.field.topology(), number) else { return Ok(()) };
        let Some(Some(entry)) = self.field.block_mut(block) else { return Ok(()) };
        if entry.texels.is_paged() {
            entry.texels = Slot::Here(entry.texels.shared()?);
            entry.id = self.heap.allocate_beyond(entry.id.class);
            self.paging.count -= 1;
            self.paging.back.remove(&number);
            // It is listed again in its order, if the list is of its age.
            self.paging.queue.insert((entry.version, number));
        }
        Ok(())
    }

    /// Knows that `page` holds what a block is now.
    pub(super) fn set_clean(&mut self, number: u32, page: Arc<dyn Page>) {
        if self.field.pager.is_some() {
            self.paging.clean.insert(number, (self.edited(number), page));
        }
    }

    /// Pages for itself, after it was copied from another channel.
    #[inline(never)]
    pub(super) fn fork(&mut self) {
        let Some(pager) = self.field.pager.as_ref().map(|pager| pager.fork()) else { return };
        self.field.pager = Some(pager);
        self.paged().into_iter().for_each(|block| self.let_go(block));
        self.paging.back.clear();
    }
}

impl<T: Texel> Paged for TriangleChannel<T> {
    fn paging(&mut self) -> &mut Paging {
        &mut self.paging
    }

    fn pager(&self) -> Option<&Arc<Pager>> {
        self.field.pager.as_ref()
    }

    fn fits(&self, bytes: u64) -> bool {
        self.heap.bytes().saturating_add(bytes) <= self.heap.budget()
    }

    fn is_on_page(&self, block: u32) -> bool {
        self.is_paged(block)
    }

    fn edited(&self, block: u32) -> u64 {
        self.field.entry(block).map_or(0, |entry| entry.version)
    }

    fn here(&self) -> Vec<u32> {
        self.field.all_blocks().filter(|block| !self.is_paged(*block)).collect()
    }

    fn evict(&mut self, number: u32) -> bool {
        let Some(block) = TriangleBlock::of(self.field.topology(), number) else { return false };
        let (Some(pager), Some(entry)) = (self.field.pager.clone(), self.field.block(block)) else { return false };
        let clean = self.paging.clean.remove(&number).filter(|(version, _)| *version == entry.version);
        let paged = entry.texels.page_out(number, self.field.blank(), &pager, clean.map(|(_, page)| page));
        match (paged, self.field.block_mut(block)) {
            (Ok(texels), Some(Some(entry))) => {
                self.heap.free(&[entry.id]);
                (entry.texels, entry.id.number) = (texels, NOWHERE);
                self.paging.count += 1;
                true
            }
            (Err(error), _) => {
                pager.note(number, error);
                false
            }
            (Ok(_), _) => false,
        }
    }

    fn back_bytes(&self, block: u32) -> u64 {
        self.field.entry(block).map_or(0, |entry| entry.texels.back_bytes())
    }

    fn has_failed(&self, block: u32) -> bool {
        self.field.entry(block).is_some_and(|entry| entry.texels.has_failed())
    }

    fn let_go(&mut self, number: u32) {
        let Some(block) = TriangleBlock::of(self.field.topology(), number) else { return };
        if let (Some(pager), Some(Some(entry))) = (self.field.pager.clone(), self.field.block_mut(block)) {
            entry.texels.let_go(&pager);
        }
    }
}
