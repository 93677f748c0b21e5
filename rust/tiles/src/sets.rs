//! The three sets of an edit, made from one decision per candidate tile by a multi-compaction scan.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 4: a
//! classification kernel decides for each tile, a scan turns the decisions into the lists of tiles to allocate, to
//! modify and to deallocate. The scan counts in groups, sums the groups, and scatters: the lists are in candidate order
//! whatever the number of threads.

use bytemuck::{Pod, Zeroable};
use relievo_core::Context;

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
        let groups: Vec<_> = candidates.chunks(GROUP).collect();
        // Membership in the three sets, in this order.
        let flags = |candidate: &Candidate| match candidate.decision {
            Candidate::MODIFY => [!allocated(candidate.tile), true, false],
            Candidate::CLEAR => [false, false, allocated(candidate.tile)],
            _ => [false; 3],
        };
        let counts = context.map(groups.len(), |group| {
            let mut counts = [0usize; 3];
            for candidate in groups[group] {
                for (count, flag) in counts.iter_mut().zip(flags(candidate)) {
                    *count += usize::from(flag);
                }
            }
            counts
        });
        let mut lists: [Vec<u32>; 3] = std::array::from_fn(|set| vec![0; counts.iter().map(|count| count[set]).sum()]);
        // Every group gets its own part of each list.
        let [mut allocate, mut modify, mut deallocate] = lists.each_mut().map(Vec::as_mut_slice);
        let mut parts: Vec<[&mut [u32]; 3]> = Vec::with_capacity(groups.len());
        for count in &counts {
            parts.push([take(&mut allocate, count[0]), take(&mut modify, count[1]), take(&mut deallocate, count[2])]);
        }
        context.for_each_mut(&mut parts, |group, part| {
            let mut at = [0; 3];
            for candidate in groups[group] {
                for (set, flag) in flags(candidate).into_iter().enumerate() {
                    if flag {
                        part[set][at[set]] = candidate.tile;
                        at[set] += 1;
                    }
                }
            }
        });
        drop(parts);
        let [allocate, modify, deallocate] = lists;
        Self { allocate, modify, deallocate }
    }
}

/// Splits the first `count` places off `rest`.
fn take<'a>(rest: &mut &'a mut [u32], count: usize) -> &'a mut [u32] {
    rest.split_off_mut(..count).unwrap_or_default()
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
