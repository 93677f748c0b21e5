//! Items that only some of many numbers have.

use relievo_core::simd::prefetch;

use crate::connectivity::NONE;

/// Items by number.
pub struct Sparse<T> {
    /// Of every number where its item is, or [`NONE`].
    at: Vec<u32>,
    items: Vec<T>,
    /// Items of no number.
    free: Vec<u32>,
}

impl<T: Copy> Sparse<T> {
    /// Of numbers below `count`, which have nothing.
    pub fn new(count: usize) -> Self {
        Self { at: vec![NONE; count], items: Vec::new(), free: Vec::new() }
    }

    /// The item of a number.
    #[inline(always)]
    pub fn get(&self, number: u32) -> Option<&T> {
        self.items.get(self.at[number as usize] as usize)
    }

    /// Asks for what tells where the items of numbers are, and then for those.
    #[inline(always)]
    pub fn ask_ahead(&self, numbers: impl Iterator<Item = u32> + Clone) {
        numbers.clone().for_each(|number| prefetch(&self.at, number as usize));
        numbers.for_each(|number| prefetch(&self.items, self.at[number as usize] as usize));
    }

    /// Gives a number an item, or none. Returns the one it had.
    pub fn set(&mut self, number: u32, item: Option<T>) -> Option<T> {
        let at = &mut self.at[number as usize];
        match (item, *at) {
            (None, NONE) => None,
            (None, old) => {
                *at = NONE;
                self.free.push(old);
                Some(self.items[old as usize])
            }
            (Some(item), NONE) => {
                match self.free.pop() {
                    Some(free) => {
                        *at = free;
                        self.items[free as usize] = item;
                    }
                    None => {
                        *at = self.items.len() as u32;
                        self.items.push(item);
                    }
                }
                None
            }
            (Some(item), old) => Some(std::mem::replace(&mut self.items[old as usize], item)),
        }
    }
}
