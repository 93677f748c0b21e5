//! Which elements of a surface have a block: pages of references that are shared until one of them is written (copy on
//! write), so that a copy of all costs one reference per page and an edit copies only what it touches.

use std::sync::Arc;

use crate::heap::{BlockId, SizeClass};

/// The block of an element.
#[derive(Clone, Debug)]
pub(crate) struct Entry<T, C = SizeClass> {
    pub texels: Arc<[T]>,
    pub id: BlockId<C>,
    pub version: u64,
}

/// Elements that share a page.
const PAGE: usize = 64;

type Page<T, C> = [Option<Entry<T, C>>; PAGE];

/// The blocks of all elements.
#[derive(Clone, Debug)]
pub(crate) struct Pages<T, C = SizeClass>(Vec<Option<Arc<Page<T, C>>>>);

impl<T: Copy, C: Copy> Pages<T, C> {
    /// No blocks for `count` elements.
    pub fn new(count: usize) -> Self {
        Self(vec![None; count.div_ceil(PAGE)])
    }

    /// The entry of an element, if it exists and has one.
    pub fn entry(&self, element: u32) -> Option<&Entry<T, C>> {
        let element = element as usize;
        self.0.get(element / PAGE)?.as_ref()?[element % PAGE].as_ref()
    }

    /// The entry of an element, which must exist, for writing.
    pub fn entry_mut(&mut self, element: u32) -> &mut Option<Entry<T, C>> {
        let element = element as usize;
        let page = self.0[element / PAGE].get_or_insert_with(|| Arc::new([const { None }; PAGE]));
        &mut Arc::make_mut(page)[element % PAGE]
    }

    /// The elements with a block, ascending.
    pub fn used(&self) -> impl Iterator<Item = u32> {
        let pages = self.0.iter().enumerate().filter_map(|(index, page)| Some((index, page.as_ref()?)));
        pages.flat_map(|(index, page)| {
            let used = page.iter().enumerate().filter(|(_, entry)| entry.is_some());
            used.map(move |(slot, _)| (index * PAGE + slot) as u32)
        })
    }
}
