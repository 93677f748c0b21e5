//! The three sets of an edit, made from one decision per candidate tile by a multi-compaction scan.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 4: a
//! classification kernel decides for each tile, a scan turns the decisions into the lists of tiles to allocate, to
//! modify and to deallocate. The scan counts in groups, sums the groups, and scatters: the lists are in candidate order
//! whatever the number of threads.

use bytemuck::{Pod, Zeroable};
use relievo_core::{Context, Parts};

/// What the classification kernel found out about a tile. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Candidate {
    /// The tile.
    pub tile: u32,
    /// [`Candidate::KEEP`], [`Candidate::MODIFY`] or [`Candidate::CLEAR`].
    pub decision: u32,
}

impl Candidate {
    /// Leave the tile as it is.
    pub const KEEP: u32 = 0;
    /// Edit the tile, and allocate it first if it is not.
    pub const MODIFY: u32 = 1;
    /// Deallocate the tile if it is allocated.
    pub const CLEAR: u32 = 2;
}

/// Tiles by what happens to them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sets {
    /// Tiles that need a block.
    pub allocate: Vec<u32>,
    /// Tiles to be edited, those to be allocated among them.
    pub modify: Vec<u32>,
    /// Tiles whose block goes back to the heap.
    pub deallocate: Vec<u32>,
}

/// Candidates counted together.
const GROUP: usize = 2048;

impl Sets {
    /// The sets of `candidates`, in their order, where `allocated` tells which tiles have a block.
    pub fn scan(context: &Context, candidates: &[Candidate], allocated: impl Fn(u32) -> bool + Sync) -> Self {
        // Membership in the three sets, in this order.
        let flags = |candidate: &Candidate| match candidate.decision {
            Candidate::MODIFY => [!allocated(candidate.tile), true, false],
            Candidate::CLEAR => [false, false, allocated(candidate.tile)],
            _ => [false; 3],
        };
        let scratch = context.scratch();
        let mut counts = scratch.list::<[usize; 3]>();
        context.map_into(candidates.len().div_ceil(GROUP), &mut counts, |group| {
            let mut counts = [0usize; 3];
            for candidate in candidates.iter().skip(group * GROUP).take(GROUP) {
                for (count, flag) in counts.iter_mut().zip(flags(candidate)) {
                    *count += usize::from(flag);
                }
            }
            counts
        });
        let list = |set: usize| {
            let mut list = scratch.take_list::<u32>();
            list.resize(counts.iter().map(|count| count[set]).sum(), 0);
            list
        };
        let mut sets = Self { allocate: list(0), modify: list(1), deallocate: list(2) };
        let lists = [&mut sets.allocate, &mut sets.modify, &mut sets.deallocate].map(Vec::as_mut_slice);
        let scattered = context.for_each_part(Groups { candidates, counts: &counts, lists }, 1, |_, groups| {
            let mut lists = groups.lists.map(|list| list.iter_mut());
            for candidate in groups.candidates {
                for (list, _) in lists.iter_mut().zip(flags(candidate)).filter(|(_, flag)| *flag) {
                    list.next().into_iter().for_each(|tile| *tile = candidate.tile);
                }
            }
            Ok(())
        });
        debug_assert!(scattered.is_ok());
        sets
    }

    /// Gives the room of the lists back to the context they are from.
    pub fn give_back(self, context: &Context) {
        [self.allocate, self.modify, self.deallocate].into_iter().for_each(|list| context.scratch().keep_list(list));
    }
}

/// Groups of candidates with what they have in each set, and their parts of the lists.
struct Groups<'a> {
    candidates: &'a [Candidate],
    counts: &'a [[usize; 3]],
    lists: [&'a mut [u32]; 3],
}

impl Parts for Groups<'_> {
    fn len(&self) -> usize {
        self.counts.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (counts, more_counts) = Parts::split_at(self.counts, at);
        let (candidates, more) = Parts::split_at(self.candidates, at * GROUP);
        let mut set = 0..3;
        let parts = self.lists.map(|list| {
            let own: usize = set.next().map_or(0, |set| counts.iter().map(|count| count[set]).sum());
            Parts::split_at(list, own)
        });
        let [(a, more_a), (b, more_b), (c, more_c)] = parts;
        let first = Groups { candidates, counts, lists: [a, b, c] };
        (first, Groups { candidates: more, counts: more_counts, lists: [more_a, more_b, more_c] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use relievo_core::ContextOptions;

    #[test]
    fn a_candidate_is_two_words() {
        assert_eq!(size_of::<Candidate>(), 8);
    }

    proptest! {
        #[test]
        fn the_scan_filters_in_order_for_any_number_of_threads(
            decisions in prop::collection::vec((0u32..3, any::<bool>()), 0..9000),
        ) {
            let candidates: Vec<_> =
                (0..).zip(&decisions).map(|(index, (decision, _))| Candidate { tile: 3 * index, decision: *decision }).collect();
            let allocated = |tile: u32| decisions[tile as usize / 3].1;
            let filter = |wanted: &dyn Fn(u32, bool) -> bool| -> Vec<u32> {
                let kept = candidates.iter().filter(|c| wanted(c.decision, allocated(c.tile)));
                kept.map(|c| c.tile).collect()
            };
            let expected = Sets {
                allocate: filter(&|decision, allocated| decision == Candidate::MODIFY && !allocated),
                modify: filter(&|decision, _| decision == Candidate::MODIFY),
                deallocate: filter(&|decision, allocated| decision == Candidate::CLEAR && allocated),
            };
            prop_assert_eq!(&Sets::scan(&Context::serial(), &candidates, allocated), &expected);
            let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
            prop_assert_eq!(&Sets::scan(&context, &candidates, allocated), &expected);
        }
    }
}
