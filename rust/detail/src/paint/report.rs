//! What a dab did: how much was looked at, what changed, and what a budget refused.

use std::borrow::Borrow;

use relievo_core::Context;

/// What dabs did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DabReport {
    /// Tiles of which texels were looked at.
    pub tested_tiles: u64,
    /// Texels that were looked at.
    pub tested_texels: u64,
    /// Tiles of which texels changed, ascending.
    pub changed: Vec<u32>,
    /// Texels that changed.
    pub changed_texels: u64,
    /// Tiles that were newly allocated, neighbours included.
    pub allocated: u64,
    /// Tiles that were given back.
    pub freed: u64,
    /// Tiles that the budget refused, ascending.
    pub refused: Vec<u32>,
    /// Bytes of the allocated tiles of the channel afterwards; of both where a mode changes displacement and vectors.
    pub bytes: u64,
}

/// Adds `more` to `numbers`, which become ascending and without repetition.
pub(crate) fn unite(numbers: &mut Vec<u32>, more: &[u32]) {
    numbers.extend_from_slice(more);
    numbers.sort_unstable();
    numbers.dedup();
}

impl DabReport {
    /// Counts tiles as refused.
    pub(crate) fn refuse(&mut self, tiles: Vec<u32>) {
        unite(&mut self.refused, &tiles);
    }

    /// Adds what another dab did afterwards.
    pub fn merge(&mut self, other: impl Borrow<Self>) {
        let other = other.borrow();
        self.tested_tiles += other.tested_tiles;
        self.tested_texels += other.tested_texels;
        unite(&mut self.changed, &other.changed);
        self.changed_texels += other.changed_texels;
        self.allocated += other.allocated;
        self.freed += other.freed;
        unite(&mut self.refused, &other.refused);
        self.bytes = other.bytes;
    }

    /// Gives the room of its lists back to the context that the dab was made with.
    pub fn give_back(self, context: &Context) {
        [self.changed, self.refused].into_iter().for_each(|list| context.scratch().keep_list(list));
    }
}
