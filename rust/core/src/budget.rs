//! The memory a reader may occupy, in bytes. Every list that grows with the input grows through a [`Budget`], which
//! counts what is allocated before it is allocated.

use crate::{Error, Result};

/// Bytes that may be allocated and bytes that are.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    used: u64,
}

impl Budget {
    /// Nothing allocated yet, of `limit` bytes.
    pub fn new(limit: u64) -> Self {
        Self { limit, used: 0 }
    }

    /// Bytes still free.
    pub fn left(&self) -> u64 {
        self.limit - self.used
    }

    /// Counts `bytes` as allocated.
    ///
    /// # Errors
    /// Fails with `Memory`, and counts nothing, if `bytes` is more than is left of the limit.
    pub fn charge(&mut self, bytes: u64) -> Result<()> {
        if bytes > self.left() {
            return Err(Error::memory(format!("reading it needs more than the memory limit of {} bytes", self.limit))
                .advise("raise the memory limit, or split the file"));
        }
        self.used += bytes;
        Ok(())
    }

    /// Makes room for exactly `additional` more items.
    ///
    /// # Errors
    /// Fails with `Memory` if the new block exceeds what is left of the limit, or if the system has no memory for it.
    pub fn reserve<T>(&mut self, list: &mut Vec<T>, additional: usize) -> Result<()> {
        if additional <= list.capacity() - list.len() {
            return Ok(());
        }
        let capacity = list.len() as u64 + additional as u64;
        let size = size_of::<T>() as u64;
        // The old block lives until its items have moved.
        self.charge(capacity.saturating_mul(size))?;
        let old = list.capacity() as u64 * size;
        if list.try_reserve_exact(additional).is_err() {
            return Err(Error::memory(format!("the system has no {} bytes for it", capacity.saturating_mul(size)))
                .advise("close other programs, or split the file"));
        }
        self.used -= old;
        Ok(())
    }

    /// Makes room for `additional` more items of a list that grows in pieces; room is at least doubled.
    ///
    /// # Errors
    /// Fails with `Memory`, as [`Self::reserve`] does.
    pub fn reserve_more<T>(&mut self, list: &mut Vec<T>, additional: usize) -> Result<()> {
        if additional <= list.capacity() - list.len() {
            return Ok(());
        }
        self.reserve(list, additional.max(list.len()))
    }

    /// Appends one item; room is doubled when there is none.
    ///
    /// # Errors
    /// Fails with `Memory` if the list is full and its larger block exceeds the limit or what the system has.
    #[inline]
    pub fn push<T>(&mut self, list: &mut Vec<T>, value: T) -> Result<()> {
        if list.len() == list.capacity() {
            self.grow(list)?;
        }
        list.push(value);
        Ok(())
    }

    #[cold]
    fn grow<T>(&mut self, list: &mut Vec<T>) -> Result<()> {
        self.reserve(list, list.len().max(64))
    }

    /// A list of `count` copies of `value`.
    ///
    /// # Errors
    /// Fails with `Memory`, as [`Self::reserve`] does.
    pub fn filled<T: Clone>(&mut self, count: usize, value: T) -> Result<Vec<T>> {
        let mut list = Vec::new();
        self.reserve(&mut list, count)?;
        list.resize(count, value);
        Ok(list)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_counted_and_refused_before_it_happens() {
        let mut budget = Budget::new(1000);
        let mut list = Vec::<u32>::new();
        let error = (0..1000).find_map(|value| budget.push(&mut list, value).err()).unwrap();
        assert_eq!(error.kind, crate::ErrorKind::Memory);
        // 64 items fit; moving them to 128 would need 256 + 512 bytes; moving those to 256 would need 512 + 1024.
        assert_eq!(list.len(), 128);
        assert!(Budget::new(u64::MAX).reserve(&mut Vec::<u64>::new(), usize::MAX / 16).is_err());
        assert!(Budget::new(10).filled(3, 0u32).is_err());
    }
}
