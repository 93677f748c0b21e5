//! Which elements of a surface have a block: pages of references that are shared until one of them is written (copy on
//! write), so that a copy of all costs one reference per page and an edit copies only what it touches.

use std::sync::Arc;

use crate::store::heap::BlockId;

/// The block of an element.
#[derive(Clone, Debug)]
pub(crate) struct Entry<T> {
    pub texels: Arc<[T]>,
    pub id: BlockId,
    pub version: u64,
}

/// Elements that share a page.
const PAGE: usize = 64;

/// What the elements of a page have.
pub(crate) type Page<E> = [Option<E>; PAGE];

/// What elements have, where they have it: their blocks.
#[derive(Clone, Debug)]
pub(crate) struct CowBlocks<E>(Vec<Option<Arc<Page<E>>>>);

impl<E> CowBlocks<E> {
    /// Has nothing for any element. What nobody else has either is given to `entry`, then the empty pages to `page`.
    pub fn release(&mut self, mut entry: impl FnMut(E), mut page: impl FnMut(Arc<Page<E>>)) {
        for mut own in self.0.iter_mut().filter_map(Option::take) {
            // What is shared is known from the count of references alone.
            if Arc::strong_count(&own) == 1
                && let Some(entries) = Arc::get_mut(&mut own)
            {
                entries.iter_mut().filter_map(Option::take).for_each(&mut entry);
                page(own);
            }
        }
    }
}

impl<E: Clone> CowBlocks<E> {
    /// Nothing for `count` elements.
    pub fn new(count: usize) -> Self {
        Self(vec![None; count.div_ceil(PAGE)])
    }

    /// Shares what `other` has, in the place of what is here.
    pub fn copy_from(&mut self, other: &Self) {
        self.0.clone_from(&other.0);
    }

    /// As [`Self::entry_mut`], where a page that others have is copied to one that `spare` gives, if it does.
    pub fn entry_with(&mut self, element: u32, spare: impl FnOnce() -> Option<Arc<Page<E>>>) -> &mut Option<E> {
        if let Some(Some(page)) = self.0.get_mut(element as usize / PAGE)
            && Arc::get_mut(page).is_none()
            && let Some(mut copy) = spare()
            && let Some(entries) = Arc::get_mut(&mut copy)
        {
            entries.clone_from_slice(&page[..]);
            *page = copy;
        }
        self.entry_mut(element)
    }

    /// What an element has, if it exists.
    pub fn entry(&self, element: u32) -> Option<&E> {
        let element = element as usize;
        self.0.get(element / PAGE)?.as_ref()?[element % PAGE].as_ref()
    }

    /// What an element, which must exist, has, for writing.
    pub fn entry_mut(&mut self, element: u32) -> &mut Option<E> {
        let element = element as usize;
        let page = self.0[element / PAGE].get_or_insert_with(|| Arc::new([const { None }; PAGE]));
        &mut Arc::make_mut(page)[element % PAGE]
    }

    /// The elements that have something, ascending.
    pub fn used(&self) -> impl Iterator<Item = u32> {
        let pages = self.0.iter().enumerate().filter_map(|(index, page)| Some((index, page.as_ref()?)));
        pages.flat_map(|(index, page)| {
            let used = page.iter().enumerate().filter(|(_, entry)| entry.is_some());
            used.map(move |(slot, _)| (index * PAGE + slot) as u32)
        })
    }

    /// The elements on pages that are not shared with `other`, ascending: only they can differ.
    pub fn unshared(&self, other: &Self) -> impl Iterator<Item = u32> {
        fn page<E>(pages: &CowBlocks<E>, index: usize) -> Option<&Arc<Page<E>>> {
            pages.0.get(index)?.as_ref()
        }
        let count = self.0.len().max(other.0.len());
        let differ = (0..count).filter(|index| match (page(self, *index), page(other, *index)) {
            (Some(a), Some(b)) => !Arc::ptr_eq(a, b),
            (a, b) => a.is_some() || b.is_some(),
        });
        differ.flat_map(|index| (index * PAGE..(index + 1) * PAGE).map(|element| element as u32))
    }
}
