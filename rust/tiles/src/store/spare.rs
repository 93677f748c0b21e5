//! Blocks that nobody looks at any more, for the next edit: an edit copies what it writes, since a commit or a history may
//! hold the old blocks, and gives back as many once they are released. Units: bytes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Bytes kept of a channel at most.
const MAX: usize = 16 << 20;

/// Spare blocks and pages of a channel, shared by all its fields.
#[derive(Debug)]
pub(crate) struct BlockPool<T, P>(Mutex<Lists<T, P>>);

#[derive(Debug)]
struct Lists<T, P> {
    /// Blocks by their length.
    blocks: Vec<(usize, Vec<Arc<[T]>>)>,
    pages: Vec<Arc<P>>,
    bytes: usize,
}

impl<T, P> Default for BlockPool<T, P> {
    fn default() -> Self {
        Self(Mutex::new(Lists { blocks: Vec::new(), pages: Vec::new(), bytes: 0 }))
    }
}

impl<T: Copy, P> BlockPool<T, P> {
    /// A block that holds what `source` does, and is nobody else's.
    pub fn copy_of(&self, source: &[T]) -> Arc<[T]> {
        self.with(source.len(), |block| block.copy_from_slice(source)).unwrap_or_else(|| source.into())
    }

    /// A block of `count` times `value`, that is nobody else's.
    pub fn filled(&self, count: usize, value: T) -> Arc<[T]> {
        self.with(count, |block| block.fill(value)).unwrap_or_else(|| vec![value; count].into())
    }

    /// A spare block of `count` values that `write` has written, if there is one.
    fn with(&self, count: usize, write: impl FnOnce(&mut [T])) -> Option<Arc<[T]>> {
        let mut block = {
            let mut lists = self.lists();
            let block = lists.blocks.iter_mut().find(|(length, _)| *length == count)?.1.pop()?;
            lists.bytes -= size_of_val(&*block);
            block
        };
        write(Arc::get_mut(&mut block)?);
        Some(block)
    }
}

impl<T, P> BlockPool<T, P> {
    fn lists(&self) -> MutexGuard<'_, Lists<T, P>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a block, unless somebody else holds it or there are many.
    pub fn keep(&self, mut block: Arc<[T]>) {
        let (count, bytes) = (block.len(), size_of_val(&*block));
        if count == 0 || Arc::get_mut(&mut block).is_none() {
            return;
        }
        let mut lists = self.lists();
        if lists.bytes + bytes > MAX {
            return;
        }
        lists.bytes += bytes;
        match lists.blocks.iter_mut().find(|(length, _)| *length == count) {
            Some((_, blocks)) => blocks.push(block),
            None => lists.blocks.push((count, vec![block])),
        }
    }

    /// A page that nobody else holds, if there is a spare one.
    pub fn page(&self) -> Option<Arc<P>> {
        let mut lists = self.lists();
        let page = lists.pages.pop()?;
        lists.bytes -= size_of::<P>();
        Some(page)
    }

    /// Keeps a page that nobody else holds, unless there are many.
    pub fn keep_page(&self, page: Arc<P>) {
        let mut lists = self.lists();
        if lists.bytes + size_of::<P>() <= MAX {
            lists.bytes += size_of::<P>();
            lists.pages.push(page);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_used_again_and_what_somebody_holds_is_not() {
        let spare = BlockPool::<u16, [u8; 8]>::default();
        let (held, free): (Arc<[u16]>, Arc<[u16]>) = (vec![1; 4].into(), vec![2; 4].into());
        let place = free.as_ptr();
        spare.keep(held.clone());
        spare.keep(free);
        let copy = spare.copy_of(&[5, 6, 7, 8]);
        assert_eq!((&*copy, copy.as_ptr(), &*held), (&[5, 6, 7, 8][..], place, &[1; 4][..]));
        spare.keep(copy);
        assert_eq!((&*spare.filled(3, 9), &*spare.filled(4, 9)), (&[9; 3][..], &[9; 4][..]));
        let large: Arc<[u16]> = vec![0; MAX / 2 + 1].into();
        spare.keep(large);
        assert!(spare.lists().bytes == 0 && spare.page().is_none());
        spare.keep_page(Arc::new([1; 8]));
        assert_eq!(spare.page().as_deref(), Some(&[1; 8]));
    }
}
