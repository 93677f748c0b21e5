//! Finds equal elements of large arrays with a hash table for each part of the hash's range.

use relievo_core::Context;

/// Parts of the range of hashes, each of which one thread takes.
const PARTS: usize = 256;

/// Returns for every element below `count` the first element that is equal to it, itself if none comes before.
/// Equal elements must have equal hashes.
pub fn first_equal(
    context: &Context,
    count: usize,
    hash: impl Fn(usize) -> u64 + Sync,
    equal: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<u32> {
    let hashes = context.map(count, |index| finish(hash(index)));
    let part = |hash: u64| (hash >> 56) as usize;
    let mut starts = vec![0; PARTS + 1];
    hashes.iter().for_each(|hash| starts[part(*hash) + 1] += 1);
    (0..PARTS).for_each(|part| starts[part + 1] += starts[part]);
    // Elements part by part, in their order within each.
    let mut ends = starts.clone();
    let mut entries = vec![(0u32, 0u32); count];
    for (index, hash) in hashes.iter().enumerate() {
        let end = &mut ends[part(*hash)];
        entries[*end] = (*hash as u32, index as u32);
        *end += 1;
    }
    let found = context.map(PARTS, |part| {
        let entries = &entries[starts[part]..starts[part + 1]];
        let mask = (2 * entries.len()).next_power_of_two().max(2) - 1;
        let mut table = vec![EMPTY; mask + 1];
        let first = entries.iter().enumerate().map(|(position, (hash, index))| {
            let mut slot = *hash as usize & mask;
            while table[slot] != EMPTY {
                let (other_hash, other) = entries[table[slot] as usize];
                if other_hash == *hash && equal(other as usize, *index as usize) {
                    return other;
                }
                slot = (slot + 1) & mask;
            }
            table[slot] = position as u32;
            *index
        });
        first.collect::<Vec<u32>>()
    });
    let mut result = vec![0; count];
    for ((_, index), first) in entries.iter().zip(found.iter().flatten()) {
        result[*index as usize] = *first;
    }
    result
}

const EMPTY: u32 = u32::MAX;

/// Adds a number to a hash.
pub fn add(hash: u64, number: u32) -> u64 {
    (hash.rotate_left(23) ^ u64::from(number)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// Spreads the bits of a hash (Steele, Lea, Flood 2014).
pub fn finish(mut hash: u64) -> u64 {
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash ^ (hash >> 31)
}
