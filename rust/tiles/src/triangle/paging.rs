//! Paging of triangle meshes: when the byte budget of a channel is spent, the blocks of faces and edges that were
//! edited longest ago make room for others. See [`crate::store::paging`].
//!
//! Each block pages by itself, with the face or the edge it belongs to: a face and its edges stay allocated together.
//! Vertices never page, nor do normals, which are no channel. Units: bytes.

use std::sync::Arc;

use relievo_core::Result;
use relievo_document::PageStore;

use super::block::TriangleBlock;
use super::channel::TriangleChannel;
use super::field::{Entry, TriangleClass};
use crate::store::heap::{BlockId, Class};
use crate::store::paging::{BlockStore, Paged, StoredBlock};
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
        self.turn_to(store.map(|store| Pager::of(store, "block")))
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
        self.on_pages()
    }

    /// Bytes of vertices and blocks in the heap, and of blocks that readers brought back since the last edit or commit.
    pub fn resident_bytes(&self) -> u64 {
        self.bytes() + self.all_back_bytes()
    }

    /// Reports a failure of the store of pages, once.
    ///
    /// # Errors
    /// Fails with what could not be read back, or written, since it was asked last.
    pub fn report_fault(&self) -> Result<()> {
        self.fault()
    }

    /// Fails if what is on pages of `blocks` cannot be read.
    pub(super) fn check_pages(&self, blocks: impl IntoIterator<Item = TriangleBlock>) -> Result<()> {
        let topology = self.field.topology();
        self.check_readable(blocks.into_iter().map(|block| block.number(topology)))
    }

    /// Takes away a block. Returns its place in the heap, if it had one.
    pub(super) fn take_block(&mut self, block: TriangleBlock) -> Option<BlockId<TriangleClass>> {
        let number = block.number(self.field.topology());
        let entry = self.field.block_mut(block)?.take()?;
        if entry.texels.is_paged() {
            self.leave_page(number);
            return None;
        }
        Some(entry.id)
    }

    /// Bytes that a block takes of the heap.
    pub(super) fn bytes_here(&self, block: TriangleBlock) -> u64 {
        let here = self.field.block(block).filter(|entry| !entry.texels.is_paged());
        here.map_or(0, |entry| self.blocks.heap.bytes_of(entry.id.class))
    }

    /// Gives a block that is there other values of its pattern, in the heap, beyond the budget if need be.
    pub(super) fn replace(&mut self, block: TriangleBlock, values: Arc<[T]>) {
        let version = self.blocks.revision;
        let number = block.number(self.field.topology());
        let Some(Some(entry)) = self.field.block_mut(block) else { return };
        let was_paged = entry.texels.is_paged();
        if was_paged {
            entry.id = self.blocks.heap.allocate_beyond(entry.id.class);
        }
        (entry.texels, entry.version) = (Slot::Here(values), version);
        if was_paged {
            self.leave_page(number);
        }
        self.mark(block);
    }

    /// Gives a block that is not there a place in the heap with `values`, beyond the budget if need be.
    pub(super) fn create(&mut self, block: TriangleBlock, class: TriangleClass, values: Arc<[T]>) {
        debug_assert_eq!(values.len(), class.values());
        let version = self.blocks.revision;
        if let Some(entry) = self.field.block_mut(block) {
            let id = self.blocks.heap.allocate_beyond(class);
            *entry = Some(Entry { texels: Slot::Here(values), id, version });
            self.mark(block);
        }
    }
}

impl<T: Texel> StoredBlock<T, TriangleClass> for Entry<T> {
    fn slots(&self) -> impl Iterator<Item = &Slot<T>> {
        std::iter::once(&self.texels)
    }

    fn slots_mut(&mut self) -> impl Iterator<Item = &mut Slot<T>> {
        std::iter::once(&mut self.texels)
    }

    fn id(&self) -> BlockId<TriangleClass> {
        self.id
    }

    fn set_number(&mut self, number: u32) {
        self.id.number = number;
    }

    fn version(&self) -> u64 {
        self.version
    }
}

impl<T: Texel> Paged for TriangleChannel<T> {
    type Texel = T;
    type Class = TriangleClass;
    type Block = Entry<T>;

    fn blocks(&self) -> &BlockStore<TriangleClass> {
        &self.blocks
    }

    fn blocks_mut(&mut self) -> &mut BlockStore<TriangleClass> {
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

    fn stored(&self, number: u32) -> Option<&Entry<T>> {
        self.field.entry(number)
    }

    fn stored_mut(&mut self, number: u32) -> Option<&mut Entry<T>> {
        let block = TriangleBlock::of(self.field.topology(), number)?;
        self.field.block_mut(block)?.as_mut()
    }

    fn numbers(&self) -> Vec<u32> {
        self.field.all_blocks().collect()
    }
}
