// import imprint_link
// Slots of a triangle of a mesh that several imprints of a submission meet: the least value, and of every part of its block,
// 256 values, the last record, as `Link.slots` says; the state of that part; and the highest value as a half.

/// Parts of a triangle's block.
override PARTS: u32 = 13u;

// What is known of a triangle: that an imprint of the submission gave it a block; that values on its sides changed, or
// others, which gives it one, as `faces_of` of rust/detail decides.
const TAKEN: u32 = 1u;
const SIDES: u32 = 2u;
const INNER: u32 = 4u;
const CHANGED: u32 = 6u;

// Whether a triangle has a block before the submission: none, one of as many segments, or a coarser one.
const HELD_NONE: u32 = 0u;
const HELD_WHOLE: u32 = 1u;

// In the second word of a record: it is what smoothing left, and no edit.
const SETTLED: u32 = 0x4000u;

fn slot_of(face: u32) -> u32 {
    return work.slots + face * work.stride;
}

fn state_of(face: u32) -> u32 {
    return slot_of(face) + 1u + PARTS;
}

fn highest_of(face: u32) -> u32 {
    return slot_of(face) + work.stride - 1u;
}
