//! Numbers that look random and follow from what they are for, so that no order of work changes them.

/// Mixes a number into a seed (Steele, Lea, Flood 2014, *Fast Splittable Pseudorandom Number Generators*, SplitMix64).
pub fn mix(seed: u64, number: u64) -> u64 {
    let mut mixed = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ mixed >> 31
}

/// Returns number `index` of a seed, evenly distributed from 0 to below 1.
pub fn unit(seed: u64, index: u64) -> f32 {
    (mix(seed, index) >> 40) as f32 / (1u64 << 24) as f32
}
