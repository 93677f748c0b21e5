// import imprint_link
// Slots of a triangle of a mesh that several imprints of a submission meet: the least value, and of every part of its block,
// 256 values, the last record, as `Link.slots` says; what is known of it; and of every part a record that takes the place of
// the other before the next imprint.

/// Parts of a triangle's block.
override PARTS: u32 = 13u;

// What is known of a triangle: that an imprint of the submission gave it a block, or will have done so with the next; that
// values on side k changed, as bit 2 + k, or others; that records wait.
const TAKEN: u32 = 1u;
const GIVEN: u32 = 2u;
const SIDES: u32 = 4u;
const INNER: u32 = 32u;
const WAITING: u32 = 64u;

// In the second word of a record: values inside follow those on the sides.
const FOLLOWS: u32 = 0x8000u;

fn slot_of(face: u32) -> u32 {
    return work.slots + face * work.stride;
}

fn state_of(face: u32) -> u32 {
    return slot_of(face) + 1u + PARTS;
}
